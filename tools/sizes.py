# SPDX-License-Identifier: Apache-2.0
"""Lines of each folder against tools/sizes.toml, which a folder may not exceed; --lower takes the
present numbers where they are smaller."""

import argparse
import re
import sys
import tomllib
from pathlib import Path

from tools.compiled import ROOT, ran

TABLE = ROOT / "tools" / "sizes.toml"
NOT_COUNTED = (":!*.svg", ":!*.lock", ":!*package-lock*")


def lines(rows: list[str]) -> dict[str, int]:
    """Lines of the text files of each row; a file is of the row with its innermost folder."""
    done = ran("git", "grep", "-Ic", "", "--", ".", *NOT_COUNTED, check=True)
    owners = {Path(folder): row for row in rows for folder in row.split()}
    found = dict.fromkeys(rows, 0)
    for name, _, count in (line.rpartition(":") for line in done.stdout.splitlines()):
        found[next(owners[p] for p in Path(name).parents if p in owners)] += int(count)
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--lower", action="store_true")
    lower = parser.parse_args().lower
    text, grown = TABLE.read_text(), 0
    limits = tomllib.loads(text)
    for name, count in lines(list(limits)).items():
        if lower and count < limits[name]:
            text = re.sub(rf'(?<="{re.escape(name)}" = )\d+', str(count), text)
        if count > limits[name]:
            print(f"sizes: {name} has {count} lines, at most {limits[name]}", file=sys.stderr)
            grown += 1
    TABLE.write_text(text)
    return int(grown > 0)


if __name__ == "__main__":
    raise SystemExit(main())
