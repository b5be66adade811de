# SPDX-License-Identifier: Apache-2.0
"""Lines of each folder against tools/sizes.toml, which a folder may not exceed; --lower takes the
present numbers where they are smaller."""

import argparse
import re
import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TABLE = ROOT / "tools" / "sizes.toml"
NOT_COUNTED = (":!*.svg", ":!*.lock", ":!*package-lock*")


def lines(paths: list[str]) -> int:
    """Lines of the text files that these pathspecs of git select."""
    command = ["git", "grep", "-Ic", "", "--", *paths, *NOT_COUNTED]
    done = subprocess.run(command, cwd=ROOT, text=True, capture_output=True, check=True)
    return sum(int(line.rpartition(":")[2]) for line in done.stdout.splitlines())


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--lower", action="store_true")
    lower = parser.parse_args().lower
    text, grown = TABLE.read_text(), 0
    for name, folder in tomllib.loads(text).items():
        count, limit = lines(folder["paths"]), folder["lines"]
        if lower and count < limit:
            text = re.sub(rf'(?<=\["{re.escape(name)}"\]\nlines = )\d+', str(count), text)
        if count > limit:
            print(f"sizes: {name} has {count} lines, at most {limit}", file=sys.stderr)
            grown += 1
    TABLE.write_text(text)
    return int(grown > 0)


if __name__ == "__main__":
    raise SystemExit(main())
