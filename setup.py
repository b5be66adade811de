# SPDX-License-Identifier: Apache-2.0
"""Puts what a run is built of into the package: RTL, firmware, engine, scenarios, pages; and the
lab sheets, a package of their own, beside it."""

import runpy
import shutil
from pathlib import Path

HERE = Path(__file__).resolve().parent
TREES = ("rtl", "sim", "firmware", "web")
FILES = ("mmcs.core", "tools/sources.py")
LABS = "labs/mmcs_labs"
LEFT_OUT = {"tests", "__pycache__", "node_modules"}
# The page's libraries, where `make tool` has fetched them; else they are fetched now.
LIBRARIES = HERE / ".venv" / "share" / "mmcs" / "node_modules"


def sources() -> list[str]:
    """Names of the files, from the top of the checkout."""
    found = [path for tree in TREES for path in (HERE / tree).rglob("*") if path.is_file()]
    names = [path.relative_to(HERE) for path in found]
    return [*FILES, *(str(name) for name in sorted(names) if not LEFT_OUT & set(name.parts))]


def copy_sources(target: Path) -> None:
    for name in sources():
        (target / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(HERE / name, target / name)
    libraries = target / "web" / "lib"
    if LIBRARIES.is_dir():
        shutil.copytree(LIBRARIES, libraries, dirs_exist_ok=True)
    try:
        runpy.run_path(str(HERE / "tools" / "libraries.py"))["fetch"](libraries, dev=False)
    except SystemExit as gone:
        print(f"mmcs: this package has no mctool: {gone}")
    runpy.run_path(str(HERE / "tools" / "sbom.py"))["write"](target, libraries)


def main() -> None:
    from setuptools import setup
    from setuptools.command.build_py import build_py

    class BuildWithSources(build_py):
        def run(self):
            super().run()
            if not self.editable_mode:
                copy_sources(Path(self.build_lib) / "mmcs" / "source")
                labs = Path(self.build_lib) / "mmcs_labs"
                without = shutil.ignore_patterns(*LEFT_OUT)
                shutil.copytree(HERE / LABS, labs, ignore=without, dirs_exist_ok=True)

    setup(cmdclass={"build_py": BuildWithSources})


if __name__ == "__main__":
    main()
