# SPDX-License-Identifier: Apache-2.0
"""A scenario's machine as a co-simulation FMU (FMI 3.0): driver, RTL and plant, without Python.

In the unit are the engine's library, sim/fmu/fmu.c over it, and the machine's description as the
engine takes it. Time is the machine's, so steps may have any length; a setpoint is sampled at the
next servo interrupt.
"""

import hashlib
import os
import platform
import shlex
import shutil
import struct
import tempfile
import zipfile
from pathlib import Path
from xml.sax.saxutils import quoteattr

from mmcs import ROOT, mcdef
from mmcs.engine.build import ensure_library
from mmcs.engine.sim import make_ffi
from mmcs.errors import InputError
from mmcs.place import compiled
from mmcs.scenario.setup import Setup

MACHINES = {"x86_64": "x86_64-linux", "aarch64": "aarch64-linux"}
MAGIC, TOKEN = b"mmcsfmu3", 64
LINES = (("estop_closed", "input", 1), ("enabled", "output", 2), ("panic", "output", 3))
# name, causality, group of sim/fmu/fmu.c, what
AXIS = (
    ("setpoint", "input", 1, "in the units of the axis: counts for position control"),
    ("encoder", "output", 2, "the driver's count"),
    ("angle", "output", 3, "of the joint in the physics, rad"),
    ("velocity", "output", 4, "of the joint in the physics, rad/s"),
    ("current", "output", 5, "of the motor, A"),
)
DAY = (1989, 1, 1, 0, 0, 0)  # of all files: the same machine gives the same unit


def describe(setup: Setup) -> bytes:
    """The machine as fmu.c reads it, but for the magic and the token before it."""
    ffi = make_ffi()
    config = ffi.new("mmcs_config *", setup.config())
    motors, links = ffi.new("mmcs_motor[]", setup.motors()), setup.links()
    names = ("mmcs_config", "mmcs_motor", "mmcs_link", "struct mc_param")
    head = struct.pack("=4i", *map(ffi.sizeof, names))
    parts = [ffi.new("mmcs_driver *", setup.driver()), config, motors,
             ffi.new("mmcs_link[]", links), mcdef.new_params(setup.params)]  # fmt: skip
    return head + b"".join(bytes(ffi.buffer(part)) for part in parts)


def variables(setup: Setup) -> list[tuple[str, str, str, int, str]]:
    """Type, name, causality, reference, what: of all but time."""
    each = [("Boolean", name, causality, ref, "") for name, causality, ref in LINES]
    for name, causality, group, what in AXIS:
        each += [("Float64", f"{name}[{n}]", causality, 100 * group + n, what)
                 for n in range(setup.axes)]  # fmt: skip
    return each


def model_description(setup: Setup, token: str) -> str:
    lines, outputs = [], []
    for kind, name, causality, ref, what in variables(setup):
        about = f" description={quoteattr(what)}" if what else ""
        start = {"Boolean": ' start="true"', "Float64": ' start="0"'}[kind]
        start = start if causality == "input" else ""
        varies = "continuous" if causality == "output" and kind == "Float64" else "discrete"
        lines.append(
            f'    <{kind} name={quoteattr(name)} valueReference="{ref}" causality="{causality}"'
            f' variability="{varies}"{start}{about}/>'
        )
        outputs += [ref] if causality == "output" else []
    structure = [f'    <{what} valueReference="{ref}" dependencies=""/>'
                 for what in ("Output", "InitialUnknown") for ref in outputs]  # fmt: skip
    return "\n".join([
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<fmiModelDescription fmiVersion="3.0" modelName={quoteattr("mmcs_" + setup.name)}'
        f' instantiationToken="{token}" variableNamingConvention="structured"'
        ' generationTool="mmcs" license="Apache-2.0">',
        '  <CoSimulation modelIdentifier="mmcs" canHandleVariableCommunicationStepSize="true"/>',
        f'  <DefaultExperiment stepSize="{setup.scenario.interval_us * 1e-6:g}"/>',
        "  <ModelVariables>",
        '    <Float64 name="time" valueReference="0" causality="independent"'
        ' variability="continuous"/>',
        *lines,
        "  </ModelVariables>",
        "  <ModelStructure>",
        *structure,
        "  </ModelStructure>",
        "</fmiModelDescription>",
        "",
    ])  # fmt: skip


def compile_unit(engine: Path, folder: Path) -> tuple[Path, Path]:
    """The unit, and the engine under a name of its own: a loader takes one that has the name of
    another for that other, so a host could not have two different machines."""
    name = hashlib.sha256(engine.read_bytes()).hexdigest()[:16]
    unit, alone = folder / "mmcs.so", folder / f"libmmcs_{name}.so"
    shutil.copy(engine, alone)
    source = ROOT / "sim/fmu/fmu.c"
    compiler = shlex.split(os.environ.get("CC", "cc")) or ["cc"]
    command = [*compiler, "-std=gnu11", "-O2", "-fvisibility=hidden", f"-I{ROOT / 'sim/abi'}",
               f"-I{ROOT / 'firmware/include'}", source, f"-L{folder}", f"-lmmcs_{name}",
               "-Wl,-rpath,$ORIGIN", "-lm"]  # fmt: skip
    return compiled(unit, command, [source]), alone


def write(setup: Setup, path: Path) -> None:
    """The unit for this computer's kind of processor."""
    if platform.system() != "Linux" or platform.machine() not in MACHINES:
        what = f"{platform.machine()}, {platform.system()}"
        raise InputError.one("fmu", "", None, f"needs Linux on {', '.join(MACHINES)}; here: {what}")
    machine = describe(setup)
    scenario = setup.scenario
    engine = ensure_library(
        scenario.cards, "speed", scenario.clk_hz, heartbeat_us=scenario.heartbeat_us
    )
    token = hashlib.sha256(machine + engine.read_bytes()).hexdigest()[: TOKEN - 1]
    place = f"binaries/{MACHINES[platform.machine()]}"
    with tempfile.TemporaryDirectory() as folder, zipfile.ZipFile(path, "w") as out:
        unit, alone = compile_unit(engine, Path(folder))
        for name, content in (
            ("modelDescription.xml", model_description(setup, token).encode()),
            ("resources/setup.bin", MAGIC + token.encode().ljust(TOKEN, b"\0") + machine),
            (f"{place}/mmcs.so", unit.read_bytes()),
            (f"{place}/{alone.name}", alone.read_bytes()),
        ):
            info = zipfile.ZipInfo(name, DAY)
            info.compress_type, info.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
            out.writestr(info, content)
