# SPDX-License-Identifier: Apache-2.0
"""Cards of one's own as a library for the engine (sim/card/card.py), built once for each text."""

import hashlib
import json
import re
import subprocess
from pathlib import Path

from mmcs.engine.build import LOG, make_env, one_at_a_time
from mmcs.errors import InputError, RunError
from mmcs.inputs import UPSET
from mmcs.place import BUILD, digest, is_whole, workshop


def library(texts: list[str], files: list[str], slots: list, clk_hz: int) -> Path:
    """Of all cards together. files: what messages call the texts; slots: of the machine, and the
    first of each text or None. Raises InputError for a text that is no card, with its file and
    line."""
    where = json.dumps(slots)
    words = "\0".join([*texts, where, str(clk_hz), digest()])
    name = hashlib.sha256(words.encode()).hexdigest()[:16]
    folder = BUILD / "cards" / name
    path = folder / "card.so"
    if is_whole(path):
        return path
    with one_at_a_time(LOG.parent / "build.lock"):  # whose holder may remove what is linked here
        folder.mkdir(parents=True, exist_ok=True)
        for n, text in enumerate(texts):
            (folder / f"card{n}.sv").write_text(text)
        (folder / "slots.json").write_text(where)
        made = subprocess.run(
            ["make", "-s", "-f", "sim/Makefile", "card", f"CARD=build/cards/{name}",
             f"CLK_HZ={clk_hz}"],
            check=False, cwd=workshop(), env=make_env(), capture_output=True, text=True,
        )  # fmt: skip
        if made.returncode == 0:
            return path
    for line in made.stdout.splitlines():
        if found := re.fullmatch(r"card(\d+)\.sv:(\d+): (.*)", line):
            text = re.sub(r"card(\d+)\.sv", lambda m: files[int(m[1])], found[3])
            raise InputError.one(f"{files[int(found[1])]}:{found[2]}", "", None, text)
    lines = [*made.stdout.splitlines(), *made.stderr.splitlines(), "no output"]
    raise RunError(f"the card {files[0]} does not build: {lines[0]}")


def inputs(path: Path) -> list[str]:
    """The upsets of the cards' registers, numbered behind the inputs of the machine."""
    return [UPSET + name for name in registers(path)]


def registers(path: Path) -> list[str]:
    """The names of the cards' registers; elements of a memory each have one."""
    from cffi import FFI

    ffi = FFI()
    ffi.cdef("const char *mmcs_card_register_name(int n);")
    lib, names = ffi.dlopen(str(path)), []
    while (name := lib.mmcs_card_register_name(len(names))) != ffi.NULL:
        names.append(ffi.string(name).decode())
    return names
