# SPDX-License-Identifier: Apache-2.0
"""pytest --pyargs cocotbext.conformance --dut wrapper.sv --chip 8254: options, run and summary."""

import contextlib
import json
import os
import re
import shutil
import tempfile
from pathlib import Path

import pytest

from . import CHIPS, LeftOut

TOOLS = {"icarus": "iverilog", "verilator": "verilator"}
ARGUMENTS = {"icarus": [], "verilator": ["-Wno-fatal", "--timing"]}
FOUND = pytest.StashKey[dict]()


def pytest_addoption(parser):
    group = parser.getgroup("conformance")
    group.addoption(
        "--dut",
        action="append",
        metavar="FILE",
        help="wrapper.sv, whose module wrapper has the chip's pins; again: files of the core, or a"
        " folder of included files",
    )
    group.addoption("--chip", metavar="|".join(CHIPS), help="whose data sheet")
    group.addoption("--variant", default="", help="of the chip; default: the first it has")
    group.addoption("--simulator", default="icarus", metavar="|".join(TOOLS))
    group.addoption(
        "--settle", type=int, default=4, help="clocks that the core gets after each change of pins"
    )
    group.addoption("--pulse", type=int, default=1000, help="clocks of the one-shot's pulse")
    group.addoption(
        "--template",
        action="store_true",
        help="write the wrapper --dut with the chip's ports, and end",
    )


def pytest_configure(config):
    config.addinivalue_line("markers", "long: a row of more than 50,000 changes of pins")


def _chip(config) -> type:
    """The chip whose class the options name. Raises pytest.UsageError."""
    chip, variant = config.getoption("--chip"), config.getoption("--variant")
    if not config.getoption("--dut"):
        raise pytest.UsageError("no core is named: give --dut wrapper.sv")
    if chip not in CHIPS:
        raise pytest.UsageError(f"--chip {chip}: give one of {', '.join(CHIPS)}")
    known = CHIPS[chip].VARIANTS
    if variant and variant not in known:
        raise pytest.UsageError(f"--variant {variant}: the {chip} has {', '.join(known) or 'none'}")
    return CHIPS[chip]


def pytest_cmdline_main(config):
    """Says what is wrong with the options, and writes the template, if that is asked."""
    if "cocotbext.conformance" not in config.args:
        return None
    if not config.getoption("--template"):
        chosen(config)
        return None
    script = _chip(config)(config.getoption("--variant"))
    file = Path(config.getoption("--dut")[0])
    if file.exists():
        raise pytest.UsageError(f"--template: {file} is there already: name another file")
    inputs, outputs = script.ports()
    inputs = {"": ("sys_clk", 1), "r": ("sys_rst_n", 1)} | inputs
    ports = [f"  {way} {f'[{width - 1}:0] ' * (width > 1)}{name}"
             for way, these in (("input  wire logic", inputs), ("output logic", outputs))
             for name, width in these.values()]  # fmt: skip
    head, body = f"module {file.stem} (\n", "\n);\n\n  // core\n\nendmodule\n"
    file.write_text(head + ",\n".join(ports) + body)
    print(f"{file}: the ports of the chip; put your core into it")
    return 0


def chosen(config) -> list:
    """The rows of the chip and variant that the options name. Raises pytest.UsageError."""
    kind, variant = _chip(config), config.getoption("--variant")
    for name in config.getoption("--dut"):
        if not Path(name).exists():
            raise pytest.UsageError(f"--dut {name}: there is no such file; --template writes one")
    if config.getoption("--settle") < 1:
        raise pytest.UsageError("--settle: give one clock or more")
    kind.PULSE = config.getoption("--pulse")
    rows = []
    for row in kind.ROWS:
        try:
            length = len(row.put(kind(variant)).actions)
        except LeftOut:
            continue
        rows.append(pytest.param(row, id=row.name, marks=[pytest.mark.long] * (length > 50_000)))
    return rows


def pytest_collection_finish(session):
    config = session.config
    rows = [item.callspec.params["row"] for item in session.items if _is_row(item)]
    if rows and not config.getoption("collectonly"):
        config.stash[FOUND] = simulate(config, [row.name for row in rows])


def _is_row(item) -> bool:
    return getattr(getattr(item, "module", None), "CONFORMANCE", False)


def simulate(config, names: list[str]) -> dict[str, str]:
    """What is wrong with each row, or "". Raises pytest.UsageError."""
    from cocotb_tools.runner import get_runner  # not at every start of pytest

    files = [Path(name).resolve() for name in config.getoption("--dut")]
    wrapper, simulator = files[0], config.getoption("--simulator")
    if simulator not in TOOLS:
        raise pytest.UsageError(f"--simulator {simulator}: give one of {', '.join(TOOLS)}")
    if not shutil.which(TOOLS[simulator]):
        raise pytest.UsageError(f"{TOOLS[simulator]} is not on the PATH: install {simulator}")
    if not re.search(rf"^\s*module\s+{re.escape(wrapper.stem)}\b", wrapper.read_text(), re.M):
        raise pytest.UsageError(f"{wrapper.name} has no module {wrapper.stem}: name it as the file")
    folder = Path(tempfile.mkdtemp(prefix="conformance-"))
    asked, found, log = folder / "asked.json", folder / "found.json", folder / "log"
    chip, variant = config.getoption("--chip"), config.getoption("--variant")
    asked.write_text(
        json.dumps(
            {"chip": chip, "variant": variant, "settle": config.getoption("--settle"),
             "pulse": config.getoption("--pulse"), "rows": names, "found": str(found)}
        )
    )  # fmt: skip
    runner = get_runner(simulator)
    try:
        runner.build(
            sources=[file for file in files if file.is_file()],
            includes=[file if file.is_dir() else file.parent for file in files],
            hdl_toplevel=wrapper.stem,
            build_args=ARGUMENTS[simulator],
            build_dir=folder,
            timescale=("1ns", "1ps"),
            log_file=log,
        )
    except RuntimeError:
        said = log.read_text()
        first = next(iter(re.findall(r"^.*(?:error|not found).*$", said, re.M | re.I)), said[-200:])
        raise pytest.UsageError(f"the core does not compile: {first}; all of it: {log}") from None
    current = os.environ.pop("PYTEST_CURRENT_TEST", None)
    with contextlib.suppress(RuntimeError, SystemExit):  # what it found says more
        runner.test(
            hdl_toplevel=wrapper.stem,
            hdl_toplevel_lang="verilog",
            test_module="cocotbext.conformance.player",
            build_dir=folder,
            test_dir=folder,
            timescale=("1ns", "1ps"),
            log_file=log,
            extra_env={"CONFORMANCE": str(asked)},
        )
    if current is not None:
        os.environ["PYTEST_CURRENT_TEST"] = current
    if not found.is_file():
        raise pytest.UsageError(f"the simulation did not end well: see {log}")
    wrong = json.loads(found.read_text())
    if "" in wrong:
        raise pytest.UsageError(f"{wrapper.name}: module {wrapper.stem} {wrong['']}")
    shutil.rmtree(folder)
    return wrong


def pytest_terminal_summary(terminalreporter, config):
    found = config.stash.get(FOUND, None)
    if found is None:
        return
    kind, chip = CHIPS[config.getoption("--chip")], config.getoption("--chip")
    variant = config.getoption("--variant") or kind.VARIANTS[0]
    terminalreporter.section(f"{chip} {variant}".strip())
    for section in dict.fromkeys(row.section for row in kind.ROWS):
        rows = [row for row in kind.ROWS if row.section == section and row.name in found]
        if rows:
            held = sum(not found[row.name] for row in rows)
            terminalreporter.write_line(f"{section}: {held} of {len(rows)} rows hold")
        for row in rows:
            if found[row.name]:
                how = "is otherwise" if row.silent else "does NOT hold"
                terminalreporter.write_line(f"  {row.words} {how}: {found[row.name]}")
