# SPDX-License-Identifier: Apache-2.0
"""Runs an unmodified program against the simulator: `mmcs exec -- PROGRAM`."""

from __future__ import annotations

import os
import signal
import subprocess
from pathlib import Path

from mmcs import BUILD, ROOT
from mmcs.device.server import Server, socket_path
from mmcs.errors import InputError, RunError

DEVICE = ROOT / "sim" / "device"
SOURCES = ("preload.c", "wire.c", "vme_map.c")
SANITIZE = ["-fsanitize=address,undefined", "-fno-sanitize-recover=undefined"]
LIBRARY = BUILD / "device" / "libmmcs_preload.so"


def cflags() -> list[str]:
    """Compiler flags for a program written as chapter 2 of the report shows (gcc)."""
    return [
        "-std=gnu89",
        "-w",
        f"-I{DEVICE / 'include'}",
        "-wrapper",
        str(DEVICE / "cc_wrapper.sh"),
    ]


def preload_library(sanitize: bool = False) -> Path:
    """The preload library, compiled if missing or older than its sources."""
    library = LIBRARY.with_stem(LIBRARY.stem + "_asan") if sanitize else LIBRARY
    inputs = [DEVICE / name for name in (*SOURCES, "wire.h")]
    if library.exists() and library.stat().st_mtime > max(f.stat().st_mtime for f in inputs):
        return library
    library.parent.mkdir(parents=True, exist_ok=True)
    fresh = library.with_suffix(f".{os.getpid()}")
    command = ["cc", "-std=gnu11", "-O2", "-fPIC", "-shared", "-o", fresh]
    command += [*SANITIZE, "-g"] if sanitize else []
    command += [DEVICE / name for name in SOURCES] + ["-ldl", "-lpthread"]
    done = subprocess.run(command, text=True, capture_output=True, check=False)
    if done.returncode:
        raise RunError(f"the preload library does not compile: {done.stderr.strip()[:200]}")
    fresh.rename(library)
    return library


def environment(path: Path, sanitize: bool = False) -> dict[str, str]:
    """What makes a program find the server that listens at `path`."""
    before = os.environ.get("LD_PRELOAD", "").split(":")
    libraries = [str(preload_library(sanitize)), *filter(None, before)]
    if sanitize:  # the sanitizer's own library comes first, whatever else there is
        libraries.sort(key=lambda name: "libasan" not in name)
    return {**os.environ, "LD_PRELOAD": ":".join(libraries), "MMCS_SOCKET": str(path)}


def run_program(command: list[str], sim=None, speed: float | None = None, name: str = "mc0") -> int:
    """Runs a program to its end and returns its exit status, as a shell would.

    With `sim` a private server runs beside it; without, the program uses the server called `name`.
    """
    server = None
    if sim is None:
        path = socket_path(name)
        if not path.exists():
            raise InputError.one(
                "mmcs exec", "", None, "no server is running; start `mmcs serve` or give --scenario"
            )
    else:
        path = socket_path(f"exec-{os.getpid()}")
        server = Server(sim, path, speed)
    try:
        return _run(command, environment(path), server)
    finally:
        if server:
            server.close()


def _run(command: list[str], env: dict[str, str], server: Server | None) -> int:
    try:
        child = subprocess.Popen(command, env=env)
    except FileNotFoundError:
        raise InputError.one("mmcs exec", "", command[0], "no such program") from None
    except OSError as error:
        raise InputError.one("mmcs exec", "", command[0], error.strerror) from None
    # Ctrl-C goes to the program; we end when it ends
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        if server is None:
            status = child.wait()
        else:
            while (status := child.poll()) is None:
                server.step()
    finally:
        signal.signal(signal.SIGINT, before)
    return 128 - status if status < 0 else status
