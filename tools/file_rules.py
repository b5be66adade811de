# SPDX-License-Identifier: Apache-2.0
"""Rules for files as files: licence line, length, README's shape; and those of rtl_rules.py."""

import argparse
import sys

from tools import rtl_rules
from tools.compiled import ROOT, ran

# Whatever writes a file, a person reads it: nobody is exempt from the length for being generated.
CODE = {".py", ".sv", ".svh", ".c", ".h", ".cpp", ".sh", ".rdl", ".toml", ".sby", ".S", ".ld"}
CODE |= {".js", ".mjs", ".css", ".html", ".vlt", ".yaml", ".yml"}
PAGES = {".md"}  # of the length only; their licence is the project's
LIMIT = 400
README_LINES = 150
FIRST_COMMAND = 25


def tracked(*patterns: str) -> list[str]:
    out = ran("git", "ls-files", *patterns, check=True).stdout.split()
    return [f for f in out if (ROOT / f).is_file()]


def main() -> int:
    argparse.ArgumentParser(description=__doc__).parse_args()
    found = rtl_rules.complaints(ROOT)
    for name in tracked():
        path = ROOT / name
        if path.suffix not in CODE | PAGES:
            continue
        lines = path.read_text().splitlines()
        head = "\n".join(lines[:12])
        licensed = path.suffix in PAGES or name == "pyproject.toml"
        if "SPDX-License-Identifier: Apache-2.0" not in head and not licensed:
            found.append(f"{name}: no SPDX licence line at the top")
        if len(lines) > LIMIT and "Length:" not in head:
            found.append(f"{name}: {len(lines)} lines; split it, or say why in a 'Length:' comment")
    readme = (ROOT / "README.md").read_text().splitlines()
    if len(readme) > README_LINES:
        found.append(f"README.md: {len(readme)} lines, at most {README_LINES}")
    if not any("make sim" in line for line in readme[:FIRST_COMMAND]):
        found.append(f"README.md: no command in the first {FIRST_COMMAND} lines")
    for line in found:
        print(f"file rules: {line}", file=sys.stderr)
    return 1 if found else 0


if __name__ == "__main__":
    raise SystemExit(main())
