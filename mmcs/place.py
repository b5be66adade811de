# SPDX-License-Identifier: Apache-2.0
"""Where things are: the sources, what is built of them, and the results of runs.

A checkout holds all three. Installed from a wheel, the sources lie inside the package and are
built in the user's cache; so are those of a checkout that cannot be written.
"""

import functools
import hashlib
import os
import runpy
import stat
import sys
import threading
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path

from mmcs.errors import InputError, RunError

_PACKAGE = Path(__file__).resolve().parent
IN_CHECKOUT = (_PACKAGE.parent / "sim" / "Makefile").is_file()
ROOT = _PACKAGE.parent if IN_CHECKOUT else _PACKAGE / "source"
SCENARIOS = ROOT / "sim" / "scenarios"
ROBOTS = ROOT / "sim" / "robots"
LINKED = ("rtl", "sim", "firmware", "tools", "mmcs.core")  # what the makefiles read


def _cache() -> Path:
    """A folder in the user's cache for these very sources."""
    base = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    return Path(base) / "mmcs" / hashlib.sha256(str(ROOT).encode()).hexdigest()[:12]


WRITABLE = IN_CHECKOUT and os.access(ROOT, os.W_OK)
WORK = ROOT if WRITABLE else _cache()
BUILD = WORK / "build"


def workshop() -> Path:
    """The folder to call make in: the checkout, or one in the cache that links to the sources."""
    if WORK == ROOT:
        return WORK
    try:
        WORK.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        WORK.mkdir(mode=0o700, exist_ok=True)
        _check_owner(WORK)
        for name in LINKED:
            with suppress(FileExistsError):  # from before, or by another process
                (WORK / name).symlink_to(ROOT / name)
    except OSError as error:
        raise RunError(
            f"{WORK}: cannot be made: {error.strerror}; set XDG_CACHE_HOME to a folder for builds"
        ) from None
    return WORK


def _check_owner(folder: Path) -> None:
    """What is built there runs as this user: nobody else may write into it, nor put a folder of his
    in the place of one above it. Raises RunError."""
    real = folder.resolve()
    for place in dict.fromkeys((folder, *folder.absolute().parents, real, *real.parents)):
        info = place.stat()
        shared = info.st_mode & 0o022 and not info.st_mode & stat.S_ISVTX
        if info.st_uid not in (os.geteuid(), 0) or shared:
            raise RunError(
                f"{place}: another user may write there, and builds in it would run as you; "
                "set XDG_CACHE_HOME to a folder of your own"
            )


def need(packages: tuple[str, ...], extra: str, who: str) -> None:
    """Raises InputError, of `who`, where one of these is not installed; they are of [extra]."""
    if not all(map(find_spec, packages)):
        raise InputError.one(who, "", None, f"needs its packages: {installs(extra)}")


def installs(extra: str) -> str:
    """The command that installs the packages of [extra] here: a checkout's target, or the packages
    by name, since no index has mmcs itself."""
    if IN_CHECKOUT:
        return f"make {'firmware' if extra == 'hosts' else f'.venv/.{extra}'}"
    from importlib.metadata import requires

    wanted = (entry.split(";") for entry in requires("mmcs") or ())
    names = [name.strip() for name, *when in wanted if f'"{extra}"' in "".join(when)]
    if Path(sys.prefix, "pipx_metadata.json").is_file():
        by = "pipx inject mmcs"
    elif find_spec("pip"):
        by = f"{sys.executable} -m pip install"
    else:  # an environment that uv made
        by = f"uv pip install --python {sys.executable}"
    return f"{by} {' '.join(names)}"


def is_whole(path: Path, made_of: str = "") -> bool:
    """Whether it is what was built: a kill, a full disk or a bad one may have left something else,
    and who loads that dies of SIGBUS or SIGSEGV. made_of: and whether of sources of this digest."""
    try:
        told = path.with_name(f"{path.name}.sum").read_text().split()
        whole = hashlib.sha256(path.read_bytes()).hexdigest() == told[0]
    except (OSError, ValueError, IndexError):
        return False
    return whole and made_of in ("", told[-1])


def compiled(library: Path, command: list, inputs: list[Path]) -> Path:
    """A library that this command makes, when missing, damaged or of other inputs."""
    import subprocess

    workshop()  # nobody else may write there: what is found there is loaded
    made_of = hashlib.sha256(repr([*map(str, command)]).encode())
    for file in inputs:
        made_of.update(file.read_bytes())
    if is_whole(library, made_of.hexdigest()):
        return library
    library.parent.mkdir(parents=True, exist_ok=True)
    fresh = library.with_suffix(f".{threading.get_native_id()}")
    try:
        command = [*command, "-fPIC", "-shared", "-o", fresh]
        done = subprocess.run(command, text=True, capture_output=True, check=False)
    except FileNotFoundError:
        install = "install it (Debian, Ubuntu: apt-get install g++)"
        text = f"no '{command[0]}' found, and {library.name} must be built: {install}"
        raise RunError(text) from None
    if done.returncode:
        raise RunError(f"{library.name} does not compile: {done.stderr.strip()[:200]}")
    told = fresh.with_suffix(f"{fresh.suffix}.sum")
    told.write_text(f"{hashlib.sha256(fresh.read_bytes()).hexdigest()} {made_of.hexdigest()}\n")
    fresh.rename(library)
    told.rename(library.with_name(f"{library.name}.sum"))
    return library


def results(kind: str, scenario: Path | None = None) -> Path:
    """The folder of "runs" or "sweeps": build/ of the checkout, but beside a file of one's own."""
    if scenario is not None and SCENARIOS not in scenario.resolve().parents:
        return scenario.parent / kind
    return BUILD / kind if WRITABLE else Path(kind)


def run_file(name: str, kind: str) -> Path | None:
    """A file, or that of this name in a run's folder, or in that of the last run of a scenario."""
    for path in (Path(name), *(folder / kind for folder in (Path(name), *run_folders(name)))):
        if path.is_file():
            return path
    return None


def run_folders(name: str) -> list[Path]:
    """Where a run of this name may have left its results."""
    return list(dict.fromkeys([results("runs") / name, Path("runs") / name]))


@functools.cache
def digest() -> str:
    """Of the simulator's sources as this process first saw them: the end of a build's identity."""
    script = digest_script()
    return script["digest"](script["sources"](ROOT))


@functools.cache
def digest_script() -> dict:
    """The names of sim/model/digest.py, which the build runs too."""
    return runpy.run_path(str(ROOT / "sim" / "model" / "digest.py"))
