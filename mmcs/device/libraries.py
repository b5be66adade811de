# SPDX-License-Identifier: Apache-2.0
"""The libraries of sim/device, compiled when missing, damaged or older than their sources."""

import hashlib
import os
import subprocess
from pathlib import Path

from mmcs import BUILD, ROOT
from mmcs.engine.build import is_whole
from mmcs.errors import RunError

DEVICE = ROOT / "sim" / "device"
SOURCES = ("preload.c", "files.c", "wire.c", "vme_map.c")
LOCKSTEP = (*SOURCES, "lockstep.c", "waits.c", "sync.c", "clocks.c")
SANITIZE = ["-fsanitize=address,undefined", "-fno-sanitize-recover=undefined"]
LIBRARY = BUILD / "device" / "libmmcs_preload.so"


def preload_library(sanitize: bool = False, lockstep: bool = False) -> Path:
    """The preload library, compiled if missing, damaged or older than its sources."""
    stem = "mmcs_preload" + ("_lockstep" if lockstep else "") + ("_asan" if sanitize else "")
    return compiled_library(stem, LOCKSTEP if lockstep else SOURCES, sanitize)


def compiled_library(stem: str, sources: tuple[str, ...], sanitize: bool = False) -> Path:
    library = LIBRARY.with_stem(f"lib{stem.removeprefix('lib')}")
    headers = ("wire.h", "device.h", "lockstep.h", "include/sys/mmcs.h")
    inputs = [DEVICE / name for name in (*sources, *headers)]
    inputs += [
        ROOT / "firmware" / "include" / "sys" / "mmcs.h",
        ROOT / "sim" / "abi" / "mmcs_sim.h",
    ]
    newest = max(f.stat().st_mtime for f in inputs)
    if is_whole(library) and library.stat().st_mtime > newest:
        return library
    library.parent.mkdir(parents=True, exist_ok=True)
    fresh = library.with_suffix(f".{os.getpid()}")
    command = ["cc", "-std=gnu11", "-O2", "-fPIC", "-shared", "-o", fresh]
    command += [*SANITIZE, "-g"] if sanitize else []
    command += [DEVICE / name for name in sources] + ["-ldl", "-lpthread"]
    done = subprocess.run(command, text=True, capture_output=True, check=False)
    if done.returncode:
        raise RunError(f"{library.name} does not compile: {done.stderr.strip()[:200]}")
    digest = fresh.with_suffix(f"{fresh.suffix}.sum")
    digest.write_text(hashlib.sha256(fresh.read_bytes()).hexdigest() + "\n")
    fresh.rename(library)
    digest.rename(library.with_name(f"{library.name}.sum"))
    return library
