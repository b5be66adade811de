# SPDX-License-Identifier: Apache-2.0
"""Gets the simulator library: builds it if there is none of these very sources."""

import fcntl
import os
import shutil
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

from mmcs.engine.verilator import write_command
from mmcs.errors import RunError
from mmcs.place import BUILD, ROOT, WORK, digest, digest_script, is_whole, workshop

CLK_HZ = 8_000_000
HEARTBEAT_US = 50_000
LOG = BUILD / "sim" / "build.log"
ROOM = 4 << 20  # bytes: less than a file of a build

# variables of the user's own work that sim/Makefile or make would take for its own
NOT_OURS = (
    "MAKEFLAGS", "GNUMAKEFLAGS", "MFLAGS", "MAKELEVEL", "MAKEFILES", "SOURCES", "RTL_DIR",
    "PYTHONIOENCODING",
)  # fmt: skip


def library_path(
    cards: int, kind: str, clk_hz: int = CLK_HZ, heartbeat_us: int = HEARTBEAT_US
) -> Path:
    if kind == "dpi":
        return BUILD / "sim" / "dpi" / "libmmcs_dpi.so"
    clk = "" if clk_hz == CLK_HZ else f"_clk{clk_hz}"
    beat = "" if heartbeat_us == HEARTBEAT_US else f"_beat{heartbeat_us}"
    debug = "_debug" if os.environ.get("MMCS_DEBUG") else ""  # firmware compiled with -Og -g
    return BUILD / "sim" / f"{kind}_c{cards}{beat}{clk}{debug}" / "libmmcs_sim.so"


def ensure_library(
    cards: int, kind: str, clk_hz: int = CLK_HZ, heartbeat_us: int = HEARTBEAT_US
) -> Path:
    """The library of a build; kind is "speed", "trust" (assertions live), "trace", or
    "dpi" (no machine: a simulator has it). heartbeat_us: the RTL's parameter HeartbeatUs."""
    path = library_path(cards, kind, clk_hz, heartbeat_us)
    workshop()  # nobody else may write there: what is found there is loaded
    if is_whole(path, digest()):
        return path
    command = ["make", "-s", "-f", "sim/Makefile", f"CARDS={cards}", f"KIND={kind}"]
    command += [f"CLK_HZ={clk_hz}", f"HEARTBEAT_US={heartbeat_us}"]
    env = make_env()
    check_tools(env)
    text = f"building the simulator ({cards} card{'s' if cards > 1 else ''}, {kind} build)"
    with one_at_a_time(LOG.parent / "build.lock"), _spinner(text):
        if path.exists() and not is_whole(path):
            _forget(path)
        before = _made_of()
        status = _run(command, env)
        if status and before and before == _made_of():
            # not by a change of the sources: a kill or a full disk may have cut what is compiled
            _forget(path)
            status = _run(command, env)
            if status:
                (BUILD / "sim" / "sources").unlink(missing_ok=True)  # next time once only
    if status or not path.exists():
        log = LOG.relative_to(WORK) if WORK == ROOT else LOG
        raise RunError(f"the simulator does not build; {_reason()}; see {log}")
    from mmcs.service import load

    load()  # a run records what it did: no compiler is needed once it begins
    return path


def _made_of() -> bytes | None:
    """The sources that what is compiled was made of."""
    path = BUILD / "sim" / "sources"
    return path.read_bytes() if path.is_file() else None


def _forget(path: Path) -> None:
    """Removes a library and all that it may be made of."""
    path.unlink(missing_ok=True)
    digest_script()["forget"](BUILD / "sim")


def check_tools(env: dict) -> None:
    """What a build needs and this machine may lack. Raises RunError."""
    compiler = env.get("CXX") or "g++"
    for tool, package, other in (
        ("make", "make", ""),
        (compiler.split()[0], "g++", ", or name one with CXX=..."),
    ):
        if not shutil.which(tool, path=env["PATH"]):
            install = f"install it (Debian, Ubuntu: apt-get install {package}){other}"
            raise RunError(f"no '{tool}' found, and the simulator must be built: {install}")


def make_env() -> dict[str, str]:
    """The environment of a make of its own, with the tools of the virtual environment."""
    env = {k: v for k, v in os.environ.items() if k not in NOT_OURS}
    tools = Path(sys.executable).parent
    if not (tools / "verilator").is_file():  # not a checkout's environment
        write_command(tools := workshop() / "bin", relative=False)
    env["PATH"] = f"{tools}:{Path(sys.executable).parent}:{env.get('PATH', '')}"
    env["PYTHON"] = sys.executable  # not the one that a make above was told to install with
    return env


@contextmanager
def one_at_a_time(lock: Path):
    """One build at a time: parallel tests want the same files."""
    workshop()  # made, and nobody else's
    lock.parent.mkdir(parents=True, exist_ok=True)
    with lock.open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


def _run(command: list[str], env: dict) -> int:
    with LOG.open("w") as out:
        return subprocess.run(
            command, check=False, cwd=workshop(), env=env, stdout=out, stderr=subprocess.STDOUT
        ).returncode


def _spinner(text: str):
    from mmcs.screen import console as screen

    console = screen(stderr=True)
    if not console.is_terminal:
        console.print(f"mmcs: {text}")
    return console.status(text)  # draws nothing when not a terminal


def _reason() -> str:
    """A full disk, which makes every tool say something else; or the line of the log that says
    most."""
    if shutil.disk_usage(LOG.parent).free < ROOM:
        return f"no room is left on the disk of {LOG.parent}: free some and run it again"
    lines = LOG.read_text(errors="replace").splitlines() if LOG.exists() else []
    telling = [line for line in lines if "error" in line.lower() or "not found" in line]
    return (telling or lines or ["no output"])[0].strip()[:200]
