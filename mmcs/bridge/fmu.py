# SPDX-License-Identifier: Apache-2.0
"""A scenario's machine as a co-simulation FMU (FMI 3.0): driver, RTL and plant, without Python.

In the unit are the engine's library, sim/fmu/fmu.c over it, and the machine's set-up file.
Time is the machine's, so steps may have any length; a setpoint is sampled at the next servo
interrupt.
"""

import hashlib
import os
import platform
import shlex
import shutil
import tempfile
import zipfile
from dataclasses import replace
from pathlib import Path
from xml.sax.saxutils import quoteattr

from mmcs import ROOT, setup_file
from mmcs.engine.build import ensure_library
from mmcs.engine.sim import build_id, input_names, load_library
from mmcs.errors import InputError
from mmcs.place import compiled
from mmcs.scenario.compiled import compile_setup
from mmcs.scenario.setup import Setup

MACHINES = {"x86_64": "x86_64-linux", "aarch64": "aarch64-linux"}
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


def describe(setup: Setup, engine: Path, motions: bool) -> bytes:
    """The unit's set-up file; without motions the host of the unit writes the setpoints."""
    if not motions:
        bare = {"call": [], "event": [], "process": [], "expect": []}
        setup = replace(setup, scenario=setup.scenario.model_copy(update=bare), segments=[])
    library = load_library(engine)
    return compile_setup(setup, build_id(library), lambda: input_names(library))


def variables(setup: Setup, motions: bool) -> list[tuple[str, str, str, int, str]]:
    """Type, name, causality, reference, what: of all but time."""
    each = [("Boolean", name, causality, ref, "") for name, causality, ref in LINES]
    each.append(("UInt64", "hash", "output", 4, "of all samples and registers, as of mmcs run"))
    for name, causality, group, what in AXIS[motions:]:
        each += [("Float64", f"{name}[{n}]", causality, 100 * group + n, what)
                 for n in range(setup.axes)]  # fmt: skip
    return each


def model_description(setup: Setup, token: str, motions: bool) -> str:
    lines, outputs = [], []
    for kind, name, causality, ref, what in variables(setup, motions):
        about = f" description={quoteattr(what)}" if what else ""
        start = ' start="true"' if kind == "Boolean" else ' start="0"'
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
        '  <CoSimulation modelIdentifier="mmcs" canHandleVariableCommunicationStepSize="true"'
        ' canGetAndSetFMUState="true" canSerializeFMUState="true"/>',
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
    command = [*compiler, "-std=gnu11", "-O2", f"-I{ROOT / 'sim/abi'}",
               f"-I{ROOT / 'firmware/include'}", source, f"-L{folder}", f"-lmmcs_{name}",
               "-Wl,-rpath,$ORIGIN", "-lm"]  # fmt: skip
    return compiled(unit, command, [source]), alone


def write(setup: Setup, path: Path, motions: bool = False) -> None:
    """The unit for this computer's kind of processor. motions: it does what the scenario says."""
    if platform.system() != "Linux" or platform.machine() not in MACHINES:
        what = f"{platform.machine()}, {platform.system()}"
        raise InputError.one("fmu", "", None, f"needs Linux on {', '.join(MACHINES)}; here: {what}")
    for key, what in (("program", "programs"), ("card", "own cards")):
        if getattr(setup.scenario, key):
            raise InputError.one(setup.path, key, None, f"a unit has no {what}: leave them out")
    scenario = setup.scenario
    engine = ensure_library(
        scenario.cards, "speed", scenario.clk_hz, heartbeat_us=scenario.heartbeat_us
    )
    machine = describe(setup, engine, motions)
    head = setup_file.read(machine)
    token = f"{head['sum']:08x} {head['build']}"
    place = f"binaries/{MACHINES[platform.machine()]}"
    with tempfile.TemporaryDirectory() as folder, zipfile.ZipFile(path, "w") as out:
        unit, alone = compile_unit(engine, Path(folder))
        for name, content in (
            ("modelDescription.xml", model_description(setup, token, motions).encode()),
            ("resources/setup.bin", machine),
            (f"{place}/mmcs.so", unit.read_bytes()),
            (f"{place}/{alone.name}", alone.read_bytes()),
        ):
            info = zipfile.ZipInfo(name, DAY)
            info.compress_type, info.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
            out.writestr(info, content)
