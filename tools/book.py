# SPDX-License-Identifier: Apache-2.0
"""`make docs`: the docs as a searchable site in build/docs, every link checked.

The chapters are those of docs/ in the order of docs/README.md. Files of the sources that a chapter
names are pages of the book as well, and a mark like <!-- live: machine --> becomes the machine
itself at that view of its page, if `make web` has built it.
"""

import argparse
import inspect
import os
import re
import shutil
import sys
import tomllib
from pathlib import Path

import mmcs
from mmcs import BUILD, ROOT
from tools.compiled import ran
from tools.pages import aged, told_age

DOCS = ROOT / "docs"
STAGE = BUILD / "book"
BOOK = BUILD / "docs"
API = "api.md"
LINK = re.compile(r"(\]\()([^)\s]+)(\))")
LIVE = re.compile(r"<!-- live: (\w+) -->")
LANGUAGES = {".sv": "systemverilog", ".svh": "systemverilog", ".py": "python", ".c": "c", ".h": "c",
             ".cpp": "cpp", ".toml": "toml", ".js": "javascript", ".sh": "bash",
             ".S": "gas"}  # fmt: skip
LOOK = ("look.css", "book.css")  # the same as of the tool and the page
CONFIG = """\
site_name: MMCS
site_description: The motor controller of 1989, rebuilt
docs_dir: src
site_dir: site
use_directory_urls: false
theme:
  name: material
  font: false
  features: [navigation.tabs, navigation.top, search.highlight, content.code.copy]
  palette:
    - {scheme: default, media: "(prefers-color-scheme: light)"}
    - {scheme: slate, media: "(prefers-color-scheme: dark)"}
extra_css: [look.css, book.css]
plugins: [search]
markdown_extensions:
  - tables
  - attr_list
  - md_in_html
  - pymdownx.superfences
  - pymdownx.highlight: {linenums: true}
  - toc:
      permalink: true
      slugify: !!python/object/apply:pymdownx.slugs.slugify {kwds: {case: lower}}
validation:
  nav: {omitted_files: ignore, not_found: warn}
  links: {not_found: warn, anchors: warn, unrecognized_links: warn}
nav:
"""


def main() -> None:
    argparse.ArgumentParser(description=__doc__).parse_args()
    shutil.rmtree(STAGE, ignore_errors=True)
    source = STAGE / "src"
    shutil.copytree(DOCS, source)
    (BUILD / "FUSESOC_IGNORE").touch()  # copies of .core files are no cores
    for name in LOOK:
        shutil.copy(ROOT / "web" / name, source)
    wanted: set[Path] = set()  # files and folders outside docs/ that chapters name
    for page in sorted(source.rglob("*.md")):
        original = DOCS / page.relative_to(source)
        page.write_text(chapter(aged(original.read_text()), original, wanted))
    for name in ("CONTRIBUTING.md", "CHANGELOG.md"):
        wanted.add(ROOT / name)
    done: set[Path] = set()
    while todo := wanted - done:
        for path in sorted(todo):
            write_source(path, source, wanted)
        done |= todo
    address = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["mmcs"]["repository"]
    link = f"repo_url: {address}\n" if address else ""
    write_api(source / API)
    (STAGE / "mkdocs.yml").write_text(link + CONFIG + nav())
    build()
    print(f"docs: {told_age()}")


def write_api(page: Path) -> None:
    """The public names of mmcs with their docstrings; docs/use/python.md has its errors."""
    lines = ["# Python API", "", "Made from the docstrings of the names that `mmcs` exports."]
    for name in mmcs.__all__:
        thing = getattr(mmcs, name)
        if not callable(thing) or name.endswith("Error"):
            continue
        lines += ["", f"## {name}", ""]
        methods = vars(thing).items() if inspect.isclass(thing) else ()
        public = [(n, m) for n, m in methods if n[0] != "_" and callable(m)]
        for called, what in [(f"mmcs.{name}", thing), *public]:
            about = inspect.getdoc(what) or ""
            lines += ["~~~python", f"{called}{inspect.signature(what)}", "~~~", "", about, ""]
    page.write_text("\n".join(lines) + "\n")


def chapter(text: str, original: Path, wanted: set[Path]) -> str:
    """The text with links that hold in the book."""

    def link(match: re.Match) -> str:
        target, _, anchor = match[2].partition("#")
        if not target or re.match(r"\w+:", target):
            return match[0]
        path = (original.parent / target).resolve()
        if not (path.is_relative_to(DOCS) and path.is_file()):
            wanted.add(path)
        to = os.path.relpath(place(path), place(original).parent)
        place_ = f"#{anchor}" if anchor and path.suffix == ".md" else ""
        return f"{match[1]}{to}{place_}{match[3]}"

    parts = re.split(r"(^```.*?^```)", text, flags=re.M | re.S)
    parts[::2] = [LINK.sub(link, part) for part in parts[::2]]
    up = "../" * (len(original.relative_to(DOCS).parts) if original.is_relative_to(DOCS) else 1)
    asked = "scenario=lab500&plays=0&deadman=10000&view="
    frame = f'<iframe src="{up}web/index.html?{asked}\\1" title="the machine" loading="lazy" ' \
            'style="width: 100%; height: 560px; border: 1px solid #ccc"></iframe>'  # fmt: skip
    built = (BUILD / "web" / "index.html").is_file()
    return LIVE.sub(frame if built else "", "".join(parts))


def place(path: Path) -> Path:
    """Where a file is in the book, from its top."""
    if path.is_relative_to(DOCS) and path.is_file():
        return path.relative_to(DOCS)
    inside = Path("source") / path.relative_to(ROOT)
    if path.is_dir():
        return inside / "index.md"
    return inside if path.suffix == ".md" else inside.with_name(inside.name + ".md")


def write_source(path: Path, source: Path, wanted: set[Path]) -> None:
    """A file of the sources as a page, a folder as a list of what it holds."""
    target = source / place(path)
    if target.exists():
        return
    target.parent.mkdir(parents=True, exist_ok=True)
    if path.is_dir():
        files = sorted(p for p in path.iterdir() if p.is_file() and not p.name.startswith("."))
        wanted.update(p for p in files if not p.is_relative_to(DOCS))
        lines = [f"* [{p.name}]({os.path.relpath(place(p), place(path).parent)})" for p in files]
        target.write_text(f"# {path.relative_to(ROOT)}\n\n" + "\n".join(lines) + "\n")
    elif path.suffix == ".md":
        target.write_text(chapter(path.read_text(), path, wanted))
    else:
        language = LANGUAGES.get(path.suffix, "text")
        head = f"---\nsearch:\n  exclude: true\n---\n# {path.relative_to(ROOT)}\n\n"
        target.write_text(f"{head}~~~~~~ {language}\n{path.read_text()}\n~~~~~~\n")


def nav() -> str:
    """The parts and chapters of docs/README.md, in its order."""
    lines, seen = ["  - The book: README.md"], {"README.md"}
    part = None
    for line in (DOCS / "README.md").read_text().splitlines():
        if line.startswith("## "):
            part = line[3:]
            lines.append(f"  - {part}:")
        for text, target in re.findall(r"\[([^\]]+)\]\(([^)#\s]+)\)", line):
            if target in seen or part is None or not line.startswith("|"):
                continue
            path = DOCS / target
            seen.add(target)
            inside = "      "
            if path.name == "README.md" and path.parent != DOCS:
                pages = re.findall(r"\]\(([^)#\s]+\.md)\)", path.read_text())
                lines.append(f"{inside}- {text}:")
                lines += [f"{inside}    - {place((path.parent / p).resolve())}"
                          for p in ("README.md", *pages)]  # fmt: skip
            elif path.resolve().is_relative_to(DOCS):
                lines.append(f"{inside}- {text}: {target}")
    lines += [
        "  - More:",
        f"      - Python API: {API}",
        "      - contributing: source/CONTRIBUTING.md",
        "      - changes: source/CHANGELOG.md",
    ]
    return "\n".join(lines) + "\n"


def build() -> None:
    """Any link that leads nowhere ends it."""
    quiet = {"NO_MKDOCS_2_WARNING": "1", "DISABLE_MKDOCS_2_WARNING": "true"}
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "-f", STAGE / "mkdocs.yml"]
    made = ran(*command, env=os.environ | quiet)
    if made.returncode:
        sys.stderr.write(made.stdout + made.stderr)
        raise SystemExit("mmcs: the book does not build; see above")
    shutil.rmtree(BOOK, ignore_errors=True)
    BOOK.parent.mkdir(parents=True, exist_ok=True)
    (STAGE / "site").rename(BOOK)
    print(f"mmcs: {(BOOK / 'index.html').relative_to(ROOT)}")


if __name__ == "__main__":
    main()
