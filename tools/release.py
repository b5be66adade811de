# SPDX-License-Identifier: Apache-2.0
"""`make release`: wheel and sdist into dist/, both tried outside the checkout, a lab sheet too.

Each is installed into an empty environment in a folder of its own, with no way to the checkout, and
runs `mmcs run puma560` there, with no network where the system lets us take it away. Both runs
must have the hash that the checkout's own run has.
"""

import argparse
import json
import os
import re
import shutil
import sys
import tempfile
from pathlib import Path

from mmcs import __version__
from tools.compiled import ROOT, ran

LOCK = ROOT / "requirements.lock"
DIST, SCENARIO = ROOT / "dist", "puma560"
UV = [sys.executable, "-m", "uv"]


def versions() -> dict[str, str]:
    """The version, wherever it is written."""
    citation = (ROOT / "CITATION.cff").read_text()
    log = (ROOT / "CHANGELOG.md").read_text()
    project = (ROOT / "pyproject.toml").read_text()
    return {
        "mmcs/__init__.py": __version__,
        "pyproject.toml": re.search(r'^version = "([^"]+)"', project, re.M)[1],
        "CITATION.cff": re.search(r"^version: (\S+)$", citation, re.M)[1],
        "CHANGELOG.md": re.search(r"^## \[(\d[^]]*)\]", log, re.M)[1],
    }


def run(command: list, **options) -> str:
    done = ran(*command, **options)
    if done.returncode:
        said = (done.stderr or done.stdout).strip().splitlines() or ["no output"]
        raise SystemExit(f"release: {' '.join(map(str, command[:4]))}: {said[-1]}")
    return done.stdout


def alone() -> list[str]:
    """What to begin a command with, so that it has no network; nothing where that cannot be had."""
    if not shutil.which("unshare"):
        return []
    return ["unshare", "-rn"] if ran("unshare", "-rn", "true").returncode == 0 else []


def hash_of(folder: Path) -> str:
    return json.loads((folder / "report.json").read_text())["hash"]


def tried(package: Path, folder: Path) -> str:
    """The hash of a run of the package, installed into an empty environment in the folder."""
    venv = folder / "venv"
    run([*UV, "venv", "-q", "--python", sys.executable, venv])
    install = [*UV, "pip", "install", "-q", "--compile-bytecode", "-b", LOCK]
    install += ["--python", venv / "bin" / "python"]
    run([*install, "--require-hashes", "-c", LOCK, "-r", ROOT / "pyproject.toml"])
    run([*install, "--no-deps", package])
    env = {k: v for k, v in os.environ.items() if not k.startswith(("PYTHON", "VIRTUAL", "MMCS"))}
    env |= {"XDG_CACHE_HOME": str(folder / "cache"), "PATH": "/usr/lib/ccache:/usr/bin:/bin"}
    run([*alone(), venv / "bin" / "mmcs", "run", SCENARIO], cwd=folder, env=env)
    answer = ROOT / "labs" / "mmcs_labs" / "01_velocity" / "tests" / "good.toml"
    run([*alone(), venv / "bin" / "mmcs", "lab", "check", "1", answer], cwd=folder, env=env)
    where = run([venv / "bin" / "python", "-c", "import mmcs; print(mmcs.ROOT)"], cwd=folder)
    if not Path(where.strip()).is_relative_to(folder):
        raise SystemExit(f"release: {package.name} runs the code in {where.strip()}")
    return hash_of(folder / "runs" / SCENARIO)


def main() -> None:
    argparse.ArgumentParser(description=__doc__).parse_args()
    told = versions()
    if len(set(told.values())) > 1:
        raise SystemExit(f"release: versions differ: {told}")
    shutil.rmtree(DIST, ignore_errors=True)
    run([*UV, "build", "-q", "-b", LOCK, "--out-dir", DIST, ROOT])
    with tempfile.TemporaryDirectory() as place:
        own = Path(place) / "own"
        run([sys.executable, "-m", "mmcs", "run", SCENARIO, "--out", own], cwd=ROOT)
        expected = hash_of(own)
        for package in sorted(DIST.glob("mmcs-*")):
            folder = Path(place) / package.suffix[1:]
            folder.mkdir()
            found = tried(package, folder)
            print(f"{package.name}: {SCENARIO} has hash {found}")
            if found != expected:
                raise SystemExit(f"release: in the checkout it is {expected}")
    print(f"tag it with: git tag -a v{__version__} -m 'MMCS {__version__}'")


if __name__ == "__main__":
    main()
