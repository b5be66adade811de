# SPDX-License-Identifier: Apache-2.0
"""The library of sim/device, compiled when missing, damaged or of other sources."""

from pathlib import Path

from mmcs import BUILD, ROOT
from mmcs.place import compiled

DEVICE = ROOT / "sim" / "device"
SOURCES = ("preload.c", "files.c", "wire.c", "vme_map.c", "lockstep.c", "waits.c", "sync.c",
           "clocks.c")  # fmt: skip
SANITIZE = ["-fsanitize=address,undefined", "-fno-sanitize-recover=undefined"]
LIBRARY = BUILD / "device" / "libmmcs_preload.so"


def preload_library(sanitize: bool = False) -> Path:
    """The preload library, compiled if missing, damaged or of other sources."""
    library = LIBRARY.with_stem(LIBRARY.stem + ("_asan" if sanitize else ""))
    inputs = [DEVICE / name for name in SOURCES]
    for folder in ("sim/device", "sim/abi", "firmware/include"):
        inputs += (ROOT / folder).rglob("*.h")
    include = f"-I{ROOT / 'firmware' / 'include'}"
    command = ["cc", "-std=gnu11", "-O2", include, *(DEVICE / name for name in SOURCES)]
    command += ["-ldl", "-lpthread", *([*SANITIZE, "-g"] if sanitize else [])]
    return compiled(library, command, inputs)
