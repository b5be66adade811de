# SPDX-License-Identifier: Apache-2.0
"""Every link of the docs leads somewhere, every page is reached, every file named exists."""

import re
from pathlib import Path

import pytest

from mmcs import ROOT
from tools.compiled import ran

TRACKED = ran("git", "ls-files", check=True).stdout.split()
LEFT_OUT = ("CHANGELOG.md", "tools/tests/making.py")  # it names pages that it makes
PAGES = [name for name in TRACKED if name.endswith(".md") and (ROOT / name).is_file()]


def links(name: str) -> list[str]:
    """Those outside of blocks of code."""
    text = re.sub(r"^```.*?^```", "", (ROOT / name).read_text(), flags=re.M | re.S)
    return [t for t in re.findall(r"\]\(([^)\s]+)\)", text) if not re.match(r"\w+:", t)]


def anchors(page: Path) -> set[str]:
    heads = re.findall(r"^#+ (.*)$", page.read_text(), flags=re.M)
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}


@pytest.mark.parametrize("name", PAGES)
def test_links_lead_somewhere(name):
    for link in links(name):
        target, _, anchor = link.partition("#")
        path = (ROOT / name).parent / target if target else ROOT / name
        assert path.exists(), link
        assert not anchor or anchor in anchors(path), link


def test_every_page_is_reached_from_the_book():
    seen, todo = set(), [ROOT / "docs" / "README.md"]
    while todo:
        page = todo.pop().resolve()
        if page in seen or page.suffix != ".md":
            continue
        seen.add(page)
        for link in links(str(page.relative_to(ROOT))):
            path = (page.parent / link.partition("#")[0]).resolve()
            todo += sorted(path.glob("*.md")) if path.is_dir() else [path]
    lost = [name for name in PAGES if name.startswith("docs/") and (ROOT / name) not in seen]
    assert lost == []


def test_pages_that_code_names_exist():
    lost = []
    for name in TRACKED:
        path = ROOT / name
        skipped = path.suffix in {".svg", ".png", ".gif", ".json", ".lock"}
        if skipped or name.startswith(LEFT_OUT) or not path.is_file():
            continue
        for page in set(re.findall(r"\bdocs/[\w/]+\.(?:md|toml|svg)\b", path.read_text())):
            if not (ROOT / page).exists():
                lost.append(f"{name}: {page}")
    assert lost == []


def test_files_that_contributing_names_exist():
    """But for names that stand for the reader's own."""
    named = re.findall(r"`([\w.-]+(?:/[\w.-]+)+\.\w+)`", (ROOT / "CONTRIBUTING.md").read_text())
    own = re.compile(r"\b(x|NAME|x_tb|cocotb_x|NN_name|build|markN)\b")
    assert len(named) > 30
    assert [n for n in named if not own.search(n) and not (ROOT / n).exists()] == []
