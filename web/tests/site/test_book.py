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
def test_chapters_hold_the_machine_at_the_view_that_belongs_to_them(opened):
    book = "".join(page.read_text() for page in BOOK.rglob("*.html"))
    views = re.findall(r'src="[./]*web/index.html\?[^"]*&(?:amp;)?view=(\w+)"', book)
    assert set(views) == {"machine", "registers", "scope"}
    page = opened("../docs/hardware/adaptor.html", ready=False)
    page.locator("iframe").first.scroll_into_view_if_needed()
    frame = page.frame_locator("iframe >> nth=0")
    frame.locator("body.ready").wait_for()
    frame.locator("#enable").click()
    frame.locator(".lamp:has-text('servo on')").wait_for()
    frame.frame_locator("#stop").locator("#press").click()
    frame.locator("#panic-cause:has-text('button')").wait_for()
