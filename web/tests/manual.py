# SPDX-License-Identifier: Apache-2.0
"""Puts what the tests measured and photographed into the manual: `make tool-test WRITE=1`;
`make pictures` takes the screenshots anew first."""

import json
import shutil
import subprocess
import sys

from bench import PICTURES

from mmcs import ROOT
from tools.pages import marks, rewrite

HEADS = {
    "autotune": "| | g, counts/s² per D/A unit | Coulomb +/− | break-away | phase margin "
                "| −3 dB, rad/s | rise, ms | overshoot | steady error | farthest |\n"
                + "|---" * 10 + "|",
    "stops": "| | stops | median, ms | 90 %, ms | greatest, ms |\n|---|---|---|---|---|",
}  # fmt: skip
PAGES = [ROOT / "docs" / "use" / name for name in ("tool.md", "web.md")]


def tables() -> dict[str, str]:
    made = {}
    for path in PICTURES.glob("*.json"):
        rows = json.loads(path.read_text())
        lines = rows.values()
        made[path.stem] = "\n".join([HEADS[path.stem], *lines] if path.stem in HEADS else lines)
    return made


def main() -> None:
    if sys.argv[1:] == ["anew"]:
        tests = [sys.executable, "-m", "pytest", "-m", "pictures", "web/tests"]
        if subprocess.run(tests, cwd=ROOT, check=False).returncode:
            raise SystemExit("pictures: a test failed, see above; the manual is as it was")
    found = tables()
    for page in PAGES:
        for name, table in found.items():
            if marks(name)[0] in page.read_text():
                rewrite(page, name, table, "make tool-test WRITE=1", "web mmcs sim firmware")
    for picture in PICTURES.glob("*.png"):
        name = picture.name if picture.name.startswith("web") else f"tool_{picture.name}"
        target = ROOT / "docs" / "images" / name
        if any(name in page.read_text() for page in PAGES):
            shutil.copy(picture, target)


if __name__ == "__main__":
    main()
