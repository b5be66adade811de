# SPDX-License-Identifier: Apache-2.0
"""The RTL files in compile order, from mmcs.core: `sources.py [--set rtl|checkers] [--abs]`."""

import os
import sys
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parent.parent
CORE = ROOT / "mmcs.core"


def sources(name: str = "rtl", root: Path | None = None, includes: bool = False) -> list[Path]:
    """Absolute paths of a file set; include files only with `includes`.

    `root` (or the environment's MMCS_RTL, a folder `rtl`) takes the files from another tree.
    """
    other = os.environ.get("MMCS_RTL")
    base = root or (Path(other).resolve().parent if other else ROOT)
    sets = yaml.safe_load(CORE.read_text().split("\n", 1)[1])["filesets"]
    if name not in sets:
        raise KeyError(f"mmcs.core has no file set {name!r}; it has {', '.join(sets)}")
    out = []
    for entry in sets[name]["files"]:
        path, options = (entry, {}) if isinstance(entry, str) else next(iter(entry.items()))
        if options.get("is_include_file", False) and not includes:
            continue
        out.append(base / path)
    return out


def main() -> int:
    arguments = sys.argv[1:]
    absolute = "--abs" in arguments
    arguments = [a for a in arguments if a != "--abs"]
    if arguments[:1] == ["--set"] and len(arguments) == 2:
        name = arguments[1]
    elif not arguments:
        name = "rtl"
    else:
        print("sources: usage: sources.py [--set rtl|checkers] [--abs]", file=sys.stderr)
        return 2
    try:
        for path in sources(name, None if absolute else Path()):
            print(path)
    except KeyError as error:
        print(f"sources: {error.args[0]}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
