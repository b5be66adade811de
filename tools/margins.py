# SPDX-License-Identifier: Apache-2.0
"""Collects the bus margins of a test run into docs/hardware/timing.md.

Every Verilator simulation of the machine ends with MARGIN lines (rtl/checkers/*_timing.sv). After
a run of the system tests this takes the worst of all of them. Reads the whole machine's runs in
build/cocotb (not those of the checkers by themselves, which break every rule on purpose), or the
folders given; of each test module and variant the newest run, and nothing that was built from other
sources than those of now. `--print` shows the tables and writes nothing.
"""

import argparse
import re
import sys
from dataclasses import dataclass
from pathlib import Path

from cocotb_tests.lib.runner import is_current
from tools.pages import rewrite

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "hardware" / "timing.md"
LINE = re.compile(
    r"^MARGIN (vme|pc) (\w+) (min|max) limit (-?[\d.]+) worst (-?[\d.]+) "
    r"seen (\d+) broken (\d+) by (\w+)$",
    re.M,
)
SAYS = {
    "addr_setup": "address, AM, LWORD*, IACK* before AS*",
    "as_high": "AS* high between cycles",
    "write_setup": "WRITE* before the first data strobe",
    "data_setup": "write data before the first data strobe",
    "as_to_ds": "AS* to the first data strobe",
    "ds_skew": "between DS0* and DS1*",
    "ds_high": "both data strobes high between cycles",
    "addr_hold": "address held past DTACK*",
    "data_hold": "WRITE* and write data held past DTACK*",
    "strobe_hold": "data strobes held past DTACK*",
    "next_strobe": "DTACK* high to the next data strobe",
    "ds_to_dtack": "data strobe to DTACK*, fastest",
    "answer": "data strobe to DTACK*, slowest (limit: bus timer)",
    "data_to_dtack": "read data before DTACK*",
    "data_off": "data strobes high to drivers off",
    "off_to_dtack": "drivers off before DTACK* rises",
    "dtack_rise": "data strobes high to DTACK* high",
    "iackout_rise": "AS* high to IACKOUT* high",
    "irq_release": "strobes high to IRQ* released by PCCSR",
}
PC_SAYS = {
    "addr_setup": "address before IOR# or IOW#",
    "command": "IOR#, IOW# low",
    "command_waits": "IOR#, IOW# low with IOCHRDY wait states",
    "addr_hold": "address held past the command",
    "data_setup": "write data before the end of IOW#",
    "data_hold": "write data held past IOW#",
    "read_setup": "read data before the end of IOR#",
    "recovery": "command to command",
}


@dataclass
class Margin:
    kind: str
    limit: float
    worst: float
    seen: int
    broken: int
    by: str

    def add(self, other: "Margin") -> None:
        """Limits may differ by parameters (clock, IOCHRDY): the tighter case is kept."""
        sign = 1 if self.kind == "min" else -1
        if sign * (other.worst - other.limit) < sign * (self.worst - self.limit):
            self.worst, self.limit = other.worst, other.limit
        self.seen += other.seen
        self.broken += other.broken


def newest(folder: Path) -> list[Path]:
    """The logs of the last run of each test module in one build: <module>-<worker>-<attempt>."""
    logs = sorted(folder.glob("*/sim.log"), key=lambda log: log.stat().st_mtime)
    last = {log.parent.name.split("-")[0]: log.parent.name.rsplit("-", 1)[0] for log in logs}
    return [log for log in logs if log.parent.name.rsplit("-", 1)[0] in last.values()]


def collect(logs: list[Path]) -> dict[tuple[str, str], Margin]:
    found: dict[tuple[str, str], Margin] = {}
    for log in logs:
        for bus, name, kind, limit, worst, seen, broken, by in LINE.findall(
            log.read_text(errors="replace")
        ):
            margin = Margin(kind, float(limit), float(worst), int(seen), int(broken), by)
            if (bus, name) in found:
                found[bus, name].add(margin)
            else:
                found[bus, name] = margin
    return found


def table(found: dict, bus: str, says: dict[str, str]) -> list[str]:
    rows = [
        "| parameter | what | by | limit ns | worst ns | margin ns | measured | broken |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for name, words in says.items():
        m, text = found.get((bus, name)), words.replace("*", "\\*")
        if m is None:
            rows.append(f"| {name} | {text} | | | | | 0 | |")
            continue
        sign = 1 if m.kind == "min" else -1
        rows.append(
            f"| {name} | {text} | {m.by} | {'≥' if m.kind == 'min' else '≤'} {m.limit:g} | "
            f"{m.worst:g} | {sign * (m.worst - m.limit) + 0.0:g} | {m.seen} | {m.broken or ''} |"
        )
    return rows


def main() -> int:
    parser = argparse.ArgumentParser(prog="margins", description=__doc__)
    machine = [f for f in sorted((ROOT / "build" / "cocotb").glob("mmcs-*/")) if is_current(f)]
    parser.add_argument("folders", nargs="*", type=Path, default=machine)
    parser.add_argument("--print", action="store_true", dest="show")
    args = parser.parse_args()
    logs = [log for folder in args.folders for log in newest(folder)]
    found = collect(logs)
    if not found:
        where = ", ".join(map(str, args.folders)) or ROOT / "build" / "cocotb"
        print(
            f"margins: no MARGIN lines of the present RTL below {where}: "
            "run `pytest cocotb_tests/adaptor cocotb_tests/system` first",
            file=sys.stderr,
        )
        return 2
    text = "\n".join(
        [
            "### VMEbus, at the pins of the slave",
            "",
            *table(found, "vme", SAYS),
            "",
            "### PC I/O bus",
            "",
            *table(found, "pc", PC_SAYS),
        ]
    )
    if args.show:
        print(text)
        return 0
    rewrite(PAGE, "margins", text, "make cocotb; tools/margins.py", "rtl cocotb_tests bfm")
    print(f"margins: {len(found)} parameters of {len(logs)} runs into docs/hardware/timing.md")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
