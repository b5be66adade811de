# SPDX-License-Identifier: Apache-2.0
"""What runs the firmware: native code, or a processor with its compiled image."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

from mmcs import BUILD, ROOT
from mmcs.errors import InputError, RunError

HOSTS = ("native", "m68020", "rv32")


def check(host: str) -> None:
    if host not in HOSTS:
        raise InputError.one("--host", "", host, 'must be one of "native", "m68020", "rv32"')
    if host == "rv32":
        raise InputError.one("--host", "", host, 'not available yet; allowed: "native", "m68020"')


def config(host: str) -> dict:
    """The fields of mmcs_config that choose the host; builds what it needs."""
    check(host)
    if host == "native":
        return {}
    if not shutil.which("m68k-linux-gnu-gcc"):
        raise RunError(
            "--host m68020 needs m68k-linux-gnu-gcc; install it with: "
            "sudo apt-get install gcc-m68k-linux-gnu"
        )
    _make("firmware/Makefile", "m68020")
    _make("sim/hosts/Makefile", "all")
    return {
        "host": HOSTS.index(host),
        "processor": str(BUILD / "hosts" / "libm68020.so"),
        "firmware": str(BUILD / "firmware" / "m68020" / "mc.bin"),
    }


def _make(makefile: str, target: str) -> None:
    env = {k: v for k, v in os.environ.items() if k not in ("MAKEFLAGS", "MFLAGS", "MAKELEVEL")}
    env["PATH"] = f"{Path(sys.executable).parent}:{env.get('PATH', '')}"
    command = ["make", "-s", "-f", makefile, target]
    done = subprocess.run(command, cwd=ROOT, env=env, capture_output=True, text=True, check=False)
    if done.returncode:
        lines = done.stderr.strip().splitlines() or ["no output"]
        raise RunError(f"{makefile} does not build: {lines[0]}")
