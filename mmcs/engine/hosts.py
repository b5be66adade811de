# SPDX-License-Identifier: Apache-2.0
"""What runs the firmware: native code, or a processor with its compiled image."""

import importlib.util
import shutil
import subprocess
import zlib
from pathlib import Path

from mmcs.engine.build import make_env, one_at_a_time
from mmcs.errors import InputError, RunError
from mmcs.place import BUILD, installs, is_whole, workshop

HOSTS = ("native", "m68020")
COMPILER, CORE = "m68k-linux-gnu-gcc", "machine68k"  # CORE: the Python package with the processor


def check(host: str, given_in: object = "--host", key: str = "") -> str:
    if host not in HOSTS:
        allowed = "must be one of " + ", ".join(f'"{h}"' for h in HOSTS)
        raise InputError.one(given_in, key, host, allowed)
    return host


def config(host: str) -> dict:
    """The fields of mmcs_config that choose the host; builds what it needs."""
    check(host)
    if host == "native":
        return {}
    _need(host)
    make("firmware/Makefile", host, BUILD / "firmware" / host / "mc.bin")
    make("sim/hosts/Makefile", "all", BUILD / "hosts" / "libm68020.so")
    return {
        "host": HOSTS.index(host),
        "firmware": str(BUILD / "firmware" / host / "mc.bin"),
        "processor": str(BUILD / "hosts" / "libm68020.so"),
    }


def image_digest(host: str) -> str:
    """Of the image that a processor runs, which decides its times; "" for native code."""
    image = BUILD / "firmware" / host / "mc.bin"
    return f"{zlib.crc32(image.read_bytes()):08x}" if image.is_file() else ""


def _need(host: str) -> None:
    if not shutil.which(COMPILER):
        install = "sudo apt-get install gcc-m68k-linux-gnu"
        raise RunError(f"--host {host} needs {COMPILER}; install it with: {install}")
    if importlib.util.find_spec(CORE) is None:
        raise RunError(f"--host {host} needs its processor core: {installs('hosts')}")


def make(makefile: str, target: str, made: Path | None = None) -> None:
    """Builds a target of the firmware or of a processor; one process at a time."""
    command = ["make", "-s", "-f", makefile, target]
    with one_at_a_time(BUILD / "firmware.lock"):
        if made is not None and made.exists() and not is_whole(made):
            command.insert(1, "-B")
        done = subprocess.run(
            command, cwd=workshop(), env=make_env(), capture_output=True, text=True, check=False
        )
    if done.returncode:
        lines = done.stderr.strip().splitlines() or ["no output"]
        raise RunError(f"{makefile} does not build: {lines[0]}")
