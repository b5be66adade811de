# SPDX-License-Identifier: Apache-2.0
"""The tables of the manual that the product knows itself: inputs of [[event]]. `make generate`."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from mmcs.scenario import inputs  # noqa: E402
from tools.pages import splice  # noqa: E402

SCENARIOS = ROOT / "docs" / "use" / "scenarios.md"


def pages() -> dict[Path, str]:
    """Each page as it should be."""
    return {SCENARIOS: splice(SCENARIOS.read_text(), "inputs", inputs.table())}


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__).parse_args()
    for page, whole in pages().items():
        page.write_text(whole)
