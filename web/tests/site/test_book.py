# SPDX-License-Identifier: Apache-2.0
"""The book around the machine: searchable, links checked, the machine itself beside the text."""

import re
import subprocess
import sys

import pytest

from mmcs import BUILD, ROOT

pytestmark = pytest.mark.req("TOOL-1")
BOOK = BUILD / "docs"


def test_every_chapter_is_in_it_and_can_be_searched():
    index = (BOOK / "search" / "search_index.json").read_text()
    for chapter in (ROOT / "docs").rglob("*.md"):
        name = chapter.relative_to(ROOT / "docs").with_suffix(".html")
        page = BOOK / str(name).replace("README.html", "index.html")
        assert page.is_file(), name
        assert f'"{page.relative_to(BOOK)}' in index


def test_a_link_that_leads_nowhere_ends_the_build(tmp_path):
    sys.path.insert(0, str(ROOT / "tools"))
    import book

    (tmp_path / "src").mkdir()
    config = book.CONFIG.rpartition("nav:")[0]
    for text, status in (("[here](index.md)", 0), ("[a](gone.md)", 1), ("[b](#gone)", 1)):
        (tmp_path / "src" / "index.md").write_text(f"# Top\n\n{text}\n")
        (tmp_path / "mkdocs.yml").write_text(config)
        command = [sys.executable, "-m", "mkdocs", "build", "--strict", "-f"]
        made = subprocess.run([*command, tmp_path / "mkdocs.yml"], capture_output=True, check=False)
        assert bool(made.returncode) == bool(status), text


@pytest.mark.req("PAN-1")
def test_the_button_beside_the_text_raises_panic(opened, address):
    page = opened("live.html?demo=panic")
    page.get_by_role("button", name="Enable").click()
    page.wait_for_selector(".light.lit:has-text('servo on')")
    page.get_by_role("button", name="Press the button").click()
    page.wait_for_selector(".light.lit:has-text('PANIC')")
    page.get_by_role("button", name="Release it").click()
    page.get_by_role("button", name="Enable").click()
    page.wait_for_selector(".light.lit:has-text('servo on')")


@pytest.mark.parametrize("demo,button,seen", [
    ("counter", "Turn it forward", r"as the driver has it\s*-?\d{2,}"),
    ("pccsr", "Interval 2 ms", r"interrupts\s*\d+"),
    ("servo", "write() 500", r"count, error\s*500, 4[5-9]\d|count, error\s*500, 50\d"),
])  # fmt: skip
def test_what_the_buttons_do_is_seen(opened, demo, button, seen):
    page = opened(f"live.html?demo={demo}")
    if demo == "servo":
        page.get_by_role("button", name="Enable").click()
        page.wait_for_selector(".light.lit:has-text('servo on')")
    page.get_by_role("button", name=button, exact=True).click()
    page.wait_for_function("s => new RegExp(s).test(document.body.innerText)", arg=seen)


def test_chapters_hold_the_machine(opened):
    book = "".join(page.read_text() for page in BOOK.rglob("*.html"))
    demos = set(re.findall(r'src="[./]*web/live.html\?demo=(\w+)"', book))
    assert demos == {"panic", "pccsr", "counter", "servo"}
    page = opened("../docs/hardware/chips/thct2000.html", ready=False)
    frame = page.frame_locator("iframe")
    page.locator("iframe").scroll_into_view_if_needed()
    frame.locator("body.ready").wait_for()
