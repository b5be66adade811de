# SPDX-License-Identifier: Apache-2.0
"""mcdef.h and sys/mmcs.h for Python (§2.3, Tables 2.1-2.3): structures, mode words, requests;
and the declarations of sim/abi.

Everything is read from the headers themselves; nothing is repeated here.
"""

import functools
import hashlib
import re
import runpy
import threading
from typing import NamedTuple

import cffi

from mmcs.cached import once
from mmcs.errors import RunError
from mmcs.place import BUILD, ROOT, workshop

HEADER = ROOT / "firmware" / "include" / "mcdef.h"
EXTRA = HEADER.parent / "sys" / "mmcs.h"
TABLE = HEADER.with_name("requests.def")
O_RDONLY, O_WRONLY, O_RDWR = 0, 1, 2
MODES = {"off": "MD_OFF", "position": "MD_POS", "velocity": "MD_VEL", "torque": "MD_TORQ",
         "test1": "MD_TEST1"}  # fmt: skip
FLAGS = ("coulcomp", "adfb", "zerofb", "addmd", "adoff", "poschk", "softerr")


@functools.cache
def _text() -> str:
    return re.sub(r"/\*.*?\*/", "", HEADER.read_text() + EXTRA.read_text(), flags=re.S)


ABI = [ROOT / "sim" / name for name in (
    "abi/mmcs_sim.h", "abi/mmcs_service.h", "device/wire.h", "device/turns.h",
)]  # fmt: skip


SEGMENT_KINDS = [name.lower() for name in re.findall(r"MMCS_SEG_(\w+) =", ABI[0].read_text())]


def declarations(text: str) -> str:
    """A C header as cffi's parser wants it: no preprocessor but integer constants, no extern C."""
    text = re.sub(r"/\*.*?\*/", "", text, flags=re.S)
    text = re.sub(r'#ifdef __cplusplus\n(extern "C" \{|\})\n#endif\n', "", text)
    constants = re.findall(r"^#define (\w+) (0x[0-9a-fA-F]+|\d+)\s*$", text, flags=re.M)
    body = re.sub(r"^#.*$", "", text, flags=re.M)
    return "\n".join(f"#define {name} {value}" for name, value in constants) + body


def structures() -> str:
    """Those of the driver's headers, as C."""
    return "\n".join(re.findall(r"^struct (?:mc|mmcs)_\w+ \{.*?^\};", _text(), flags=re.S | re.M))


@functools.cache
def fields(structure: str) -> tuple[str, ...]:
    """The names of one: fields("mc_state")."""
    body = structures().partition(f"struct {structure} {{")[2].partition("}")[0]
    return tuple(re.findall(r"(\w+)[,;]", body))


@once
def make_ffi() -> cffi.FFI:
    """Structures and calls. cffi's parser takes as long as a short run: what it makes is kept."""
    text = "\n".join([structures(), *(declarations(header.read_text()) for header in ABI)])
    name = hashlib.sha256((cffi.__version__ + text).encode()).hexdigest()[:16]
    kept = BUILD / "declared" / f"{name}.py"
    try:
        workshop()  # nobody else may write there
        return runpy.run_path(str(kept))["ffi"]
    except Exception:  # not there yet, or a full disk left something else
        ffi = cffi.FFI()
        ffi.cdef(text)
    try:
        from cffi.recompiler import make_py_source

        workshop()
        kept.parent.mkdir(parents=True, exist_ok=True)
        part = kept.with_suffix(f".{threading.get_native_id()}")
        make_py_source(ffi, "mmcs_declared", str(part))
        part.replace(kept)
    except (OSError, RunError):
        pass  # each process parses, then
    return ffi


@functools.cache
def constants() -> dict[str, int]:
    """Every #define of the headers that stands for a number."""
    bodies = {}
    for name, body in re.findall(r"^#define (\w+)[ \t]+((?:\\\n|.)+)$", _text(), flags=re.M):
        bodies[name] = body.replace("\\\n", " ").strip()
    values: dict[str, int] = {}

    def value(name: str) -> int:
        if name not in values:
            values[name] = _evaluate(bodies[name], value)
        return values[name]

    for name in bodies:
        try:
            value(name)
        except (KeyError, SyntaxError, NameError, TypeError, ValueError):
            continue  # not a number: a macro for C only
    return values


@functools.cache
def initial() -> dict[str, int]:
    """Table 2.1: the numbers of MC_PARAM_INITIAL, by name; what is not there is 0."""
    body = re.search(r"#define MC_PARAM_INITIAL((?:.*\\\n)+.*)", _text())[1]
    pairs = re.findall(r"\.(\w+) = ([^,}\\]+)", body)
    return {name: _evaluate(number.strip(), constants().__getitem__) for name, number in pairs}


class Request(NamedTuple):
    """A row of requests.def."""

    name: str
    number: int  # below 64 in mcdef.h, others in sys/mmcs.h
    argument: str  # its type; "-": none
    way: str  # "none", "in", "out", "both"
    changes: bool  # needs the device open for writing
    waits: bool  # takes time of the machine
    called: bool  # a [[call]] may ask it
    meaning: str

    @property
    def code(self) -> int:
        if self.name not in constants():
            if self.number < 64:
                raise RunError(f"mcdef.h is stale, it has no {self.name}: run `make generate`")
            raise RunError(f"firmware/include/sys/mmcs.h defines no {self.name} ({self.number})")
        return constants()[self.name]


@functools.cache
def requests() -> dict[str, Request]:
    """Every request of the driver by its name, in the order of requests.def."""
    row = r'^REQUEST\((\w+), (\d+), "([^"]*)", (\w+), \w+, (\d), (\d), (\d),((?:\s*"[^"]*")+)\)'
    found = {}
    for name, number, argument, way, *flags, texts in re.findall(row, TABLE.read_text(), re.M):
        meaning = "".join(re.findall(r'"([^"]*)"', texts))
        changes, waits, called = (flag == "1" for flag in flags)
        found[name] = Request(name, int(number), argument, way, changes, waits, called, meaning)
    return found


def _evaluate(body: str, value) -> int:
    if not re.fullmatch(r"[\w\s()|+-]+", body):
        raise ValueError(body)
    names = {n: value(n) for n in re.findall(r"\b[A-Za-z_]\w*\b", body)}
    return eval(body, {"__builtins__": {}}, names)  # sums of numbers and names of this header


def __getattr__(name: str) -> int:
    """mcdef.MSETPARAM and the like."""
    if name.isupper() and name in constants():
        return constants()[name]
    raise AttributeError(f"mcdef.h does not define {name}")


def new_int(value: int):
    return make_ffi().new("int *", value)


def new_param(axis: int):
    return make_ffi().new("struct mc_param *", {"which": axis})


def fill_param(param, values: dict) -> None:
    """Puts servo parameters by name into a struct mc_param; "mode" and "flags" become its mode."""
    for name, value in values.items():
        if name not in ("mode", "flags"):
            setattr(param, name, value)
    param.mode = mode_word(values["mode"], values["flags"])


def new_params(params: list[dict]):
    """struct mc_param of each axis."""
    made = make_ffi().new("struct mc_param[]", len(params))
    for axis, values in enumerate(params):
        made[axis].which = axis
        fill_param(made[axis], values)
    return made


def sets(values: dict) -> list[tuple[int, int, int]]:
    """What changes in a struct mc_param, as fields of mmcs_set: word, mask, value."""
    words = fields("mc_param")
    made = [(words.index(n), -1, v) for n, v in values.items() if n not in ("mode", "flags")]
    mode, mask = words.index("mode"), constants()["MD_MASK"]
    if "mode" in values:
        made.append((mode, mask, mode_word(values["mode"], [])))
    if "flags" in values:
        made.append((mode, ~mask, mode_word("off", values["flags"])))
    return made


def mode_word(mode: str, flags: list[str]) -> int:
    word = constants()[MODES[mode]]
    for flag in flags:
        word |= constants()[flag.upper()]
    return word
