# SPDX-License-Identifier: Apache-2.0
"""The RTL files in compile order, from mmcs.core."""

import argparse
import os
import re
import sys
from collections.abc import Iterable
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parent.parent


def manifest() -> dict:
    """What mmcs.core says, less its first line."""
    return yaml.safe_load((ROOT / "mmcs.core").read_text().split("\n", 1)[1])


def sources(name: str = "rtl", root: Path | None = None, includes: bool = False) -> list[Path]:
    """Absolute paths of a file set; include files only with `includes`.

    `root` (or the environment's MMCS_RTL, a folder `rtl`) takes the files from another tree.
    """
    base = root or _tree()
    sets = manifest()["filesets"]
    if name not in sets:
        raise KeyError(f"mmcs.core has no file set {name!r}; it has {', '.join(sets)}")
    out = []
    for entry in sets[name]["files"]:
        path, options = (entry, {}) if isinstance(entry, str) else next(iter(entry.items()))
        if options.get("is_include_file", False) and not includes:
            continue
        out.append(base / path)
    return out


def reached(tops: Iterable[str], files: list[Path]) -> list[Path]:
    """Those of the files that these modules are made of, in their order. KeyError without a top."""
    text = {f: re.sub(r"//.*", "", f.read_text()) for f in files if f.is_file()}
    declares = {
        name: f
        for f, t in text.items()
        for name in re.findall(r"^\s*(?:module|package)\s+(?:automatic\s+)?(\w+)", t, re.M)
    }
    found, todo = set(), [declares[top] for top in tops]
    while todo:
        file = todo.pop()
        if file not in found:
            found.add(file)
            used = re.findall(r"(\w+)\s+(?:#\(|\w+\s*\()|(\w+)::", text[file])
            todo += [declares[word] for pair in used for word in pair if word in declares]
    return [f for f in files if f in found]


def made_of(*tops: str) -> list[Path]:
    """The files of the set rtl that these modules are made of, from the top of the checkout."""
    return [f.relative_to(ROOT) for f in reached(tops, sources("rtl", ROOT))]


def _tree() -> Path:
    other = os.environ.get("MMCS_RTL")
    return Path(other).resolve().parent if other else ROOT


def in_tree(file: Path) -> Path:
    """A file of ours as the tree has it that the environment's MMCS_RTL names."""
    inside = file.is_relative_to(ROOT / "rtl")
    return _tree() / file.relative_to(ROOT) if inside else file


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--set", default="rtl", metavar="NAME", help="rtl or checkers")
    parser.add_argument("--of", metavar="MODULE", help="only what this module is made of")
    options = parser.parse_args()
    try:
        every = sources(options.set, Path())
        if options.of and options.of not in (file.stem for file in every):
            raise KeyError(f"mmcs.core has no module {options.of!r} in its set {options.set!r}")
        for path in made_of(options.of) if options.of else every:
            print(path)
    except KeyError as error:
        print(f"sources: {error.args[0]}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
