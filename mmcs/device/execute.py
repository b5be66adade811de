# SPDX-License-Identifier: Apache-2.0
"""Runs an unmodified program against the simulator: `mmcs exec -- PROGRAM`."""

import contextlib
import os
import select
import shutil
import signal
import struct
import subprocess
import sys
from pathlib import Path

from mmcs import OWN_VARIABLES, ROOT
from mmcs.device.libraries import DEVICE, LIBRARY, preload_library
from mmcs.device.link import Link
from mmcs.device.server import Server
from mmcs.device.sockets import check_folder, socket_path
from mmcs.device.turns import Turns
from mmcs.errors import InputError
from mmcs.screen import clean

FORWARDED = (signal.SIGTERM, signal.SIGHUP)
OF_THE_TERMINAL = (signal.SIGINT, signal.SIGQUIT)  # the program gets them by itself
FAREWELL_S = 1.0  # a server that has not answered by then is not waited for
PT_INTERP = b"\3\0\0\0"


def cflags(modern: bool = False) -> list[str]:
    """Compiler flags for a program written as chapter 2 of the report shows (gcc), or of today."""
    preload_library()  # the compiler runs with it
    return [
        *(
            ("-Wall", "-Wextra", f"-I{ROOT / 'firmware' / 'examples'}")
            if modern
            else ("-std=gnu89", "-w", "-include", "errno.h")
        ),
        f"-I{DEVICE / 'include'}",
        "-idirafter",  # <mcdef.h> alone, as the driver's sources have it
        str(ROOT / "firmware" / "include"),
        "-wrapper",
        f"{DEVICE / 'cc_wrapper.sh'},{LIBRARY}",
    ]


def environment(path: Path, sanitize: bool = False, lockstep: bool = False) -> dict[str, str]:
    """What makes a program find the server that listens at `path`."""
    before = os.environ.get("LD_PRELOAD", "").split(":")
    libraries = [*filter(None, before), str(preload_library(sanitize))]  # a sanitizer's is first
    more = {"MMCS_LOCKSTEP": "1", "PYTHONHASHSEED": "0"} if lockstep else {}
    given = {name: value for name, value in os.environ.items() if name not in OWN_VARIABLES}
    return {**given, **more, "LD_PRELOAD": ":".join(libraries), "MMCS_SOCKET": str(path)}


def run_program(command: list[str], sim=None, speed: float | None = None, name: str = "mc0",
                lockstep: bool = False) -> int:  # fmt: skip
    """Runs a program to its end and returns its exit status, as a shell would.

    With `sim` a private server runs beside it; without, the program uses the server called `name`.
    What the driver says meanwhile comes on stderr.
    """
    check_program(command[0])
    if sim is not None:
        path = socket_path(f"exec-{os.getpid()}")
        server = Server(sim, path, speed, console=say, lockstep=lockstep)
        try:
            return serve_program(server, command)
        finally:
            server.close()
    path = socket_path(name)
    if not path.exists():
        raise InputError.one(
            "mmcs exec", "", None, "no server is running; start `mmcs serve` or give --scenario"
        )
    check_folder(path.parent)
    try:
        link = Link(path=path)
        link.request("follow", samples=False, period_ms=0)
    except TimeoutError:
        why = f"the server {path.stem} does not answer; continue it (kill -CONT) or end it"
        raise InputError.one("mmcs exec", "", None, why) from None
    except OSError as error:
        raise InputError.one("mmcs exec", "", None, error.strerror) from None
    console = _Console(link)
    with link:
        env = environment(path, lockstep=link.hello["lockstep"])
        status = _run(command, env, console.step)
        console.finish()
    return status


def serve_program(server: Server, command: list[str]) -> int:
    """As run_program(), beside a server of one's own."""
    turns = server.lockstep if server.lockstep.on else None
    return _run(command, environment(server.path, lockstep=turns is not None), server.step, turns)


def say(text: str) -> None:
    with contextlib.suppress(OSError, ValueError):  # nobody may be there to hear
        print(clean(text), file=sys.stderr, flush=True)


class _Console:
    """The lines of a server that runs elsewhere."""

    def __init__(self, link: Link):
        self._links = [link]  # none: the server is gone, which the program will notice by itself

    def step(self) -> None:
        for link in select.select(self._links, [], [], 0.05)[0]:
            try:
                self._show(link.receive())
            except OSError:
                self._links.clear()

    def finish(self) -> None:
        """What was said before the program ended is on its way: by the second answer it is here."""
        for link in self._links:
            link.set_timeout(FAREWELL_S)
            with contextlib.suppress(OSError):
                link.request("alive")
                link.request("alive")
            for message in link.kept():
                self._show(message)

    @staticmethod
    def _show(message) -> None:
        if isinstance(message, dict) and message.get("kind") == "log":
            say(message["text"])


# --- what can be given a device at all ---------------------------------------------------------


def check_program(name: str) -> None:
    """The library comes into a program through its loader: a static program has none, and would
    only be told that there is no /dev/mc0."""
    found = shutil.which(name)
    if found is None:
        return  # starting it tells why not
    with contextlib.suppress(OSError):
        if is_static(Path(found)):
            allowed = "is statically linked, and gets no devices; link it dynamically"
            raise InputError.one("mmcs exec", "", name, allowed)


def is_static(path: Path) -> bool:
    """An ELF program of 64 bits that names no loader."""
    with path.open("rb") as file:
        head = file.read(64)
        if head[:5] != b"\x7fELF\x02" or len(head) < 64:
            return False
        at, size, count = struct.unpack_from("<32xQ14xHH", head)
        file.seek(at)
        table = file.read(size * count)
    kinds = [table[n : n + 4] for n in range(0, len(table) - 3, size or 1)]
    return bool(kinds) and PT_INTERP not in kinds


# --- running -----------------------------------------------------------------------------------


def _run(command: list[str], env: dict[str, str], step, turns: Turns | None = None) -> int:
    """Calls step() until the program ends. Signals to end are passed on: it shall clean up."""
    child: subprocess.Popen | None = None
    early: list[int] = []

    def pass_on(number, _frame):
        if child is None:
            early.append(number)
            return
        if number in FORWARDED:
            child.send_signal(number)
        for pid in _descendants(child.pid):  # one that has stopped itself ends when it goes on
            with contextlib.suppress(OSError):
                os.kill(pid, signal.SIGCONT)

    before = {n: signal.signal(n, pass_on) for n in (*FORWARDED, *OF_THE_TERMINAL)}
    try:
        child = _start(command, env)
        if turns:
            turns.expect(child.pid)
        for number in early:
            pass_on(number, None)
        while (status := child.poll()) is None or (turns and child.pid in turns.pids()):
            step()
    except BaseException:
        if child is not None:
            child.kill()
            child.wait()
        raise
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
    return 128 - status if status < 0 else status


def _descendants(pid: int) -> list[int]:
    found = [pid]
    for parent in found:
        with contextlib.suppress(OSError):
            for children in Path(f"/proc/{parent}/task").glob("*/children"):
                found += map(int, children.read_text().split())
    return found


def _start(command: list[str], env: dict[str, str]) -> subprocess.Popen:
    try:
        return subprocess.Popen(command, env=env)
    except OSError as error:
        why = "no such program" if isinstance(error, FileNotFoundError) else error.strerror
        raise InputError.one("mmcs exec", "", command[0], why) from None
