# SPDX-License-Identifier: Apache-2.0
"""A prepared view of a trace, for GTKWave (.gtkw) and Surfer (.sucl), beside the trace.

It opens on the first PANIC, else on the first SCLOCK that was missed (its edge found the latch of
the one before still set), else on one servo pass. Markers, explained in the first row, are at
these, and at SCLOCK, acknowledge, first read and last D/A write of the pass.
States, registers and parts of the pass have names, counts and D/As are drawn as curves. GTKWave's
view is checked on its screen; Surfer's was never tried.
"""

import math
import os
import shutil
import subprocess
from pathlib import Path
from typing import NamedTuple

from mmcs.folder import whole_file
from mmcs.place import need
from mmcs.screen import echo
from mmcs.view.moments import Pass, first_missed, first_panic, first_pass, variables
from mmcs.view.names import write_tables

MACHINE = "TOP.mmcs"
CARD = "g_card[0].u_card"
AXIS = f"{CARD}.g_axis[0].u_axis"
BIN, HEX, SIGNED = "28", "22", "424"  # GTKWave's codes of a number format
STATE = "100000028"  # by the names of its enumeration, which is in the trace
GROUP_BEGIN, GROUP_END = "800200", "1000200"
NAMED, CURVE, ROOM = 0x2000, 0x8000, "20000"  # a table of names; drawn in steps; height for it
CURVE_LINES = 3
PIXELS, FRAME = 900, 200  # across which the servo pass is spread; GTKWave's zoom counts frames
MARKERS = ("SCLOCK", "acknowledge", "first read", "last D/A write")
EVENTS = ("missed", "PANIC")  # what the markers behind those are at
ALONE_PS = 1_000_000_000  # shown around an event, in a trace without a whole pass
LETTERS = "ABCDEF"
LEGEND = ", ".join(" ".join(pair) for pair in zip(LETTERS, MARKERS + EVENTS, strict=True))


class Signal(NamedTuple):
    path: str  # below the machine
    width: int = 1
    form: str = BIN
    low: int = 0  # its lowest bit
    names: str = ""  # a table of names.TABLES
    curve: bool = False
    state_of: str = ""  # the module whose states it has
    port: str = ""  # of a board, that holds it from bit 0 on: stands for it without a trace

    def full(self) -> str:
        if self.path.startswith("CARD."):  # of own cards, beside the machine
            return self.path
        cards = "u_cards." if self.path.startswith("g_card") else ""
        return f"{MACHINE}.{cards}{self.path}"

    def gtkwave(self) -> str:
        return self.full() + (f"[{self.low + self.width - 1}:{self.low}]" if self.width > 1 else "")

    @property
    def label(self) -> str:
        """Its name behind that of its block, with no dot: GTKWave shows what is behind the last."""
        *above, name = self.gtkwave().split(".")
        block = next(
            (b.removeprefix("u_") for b in reversed(above) if b.startswith("u_")), above[-1]
        )
        return f"{block}/{name}"

    def lines(self, folder: Path, tables: dict[str, int]) -> list[str]:
        """Of a .gtkw file, which numbers its tables as they come."""
        flags = int(self.form, 16) | (NAMED if self.names else 0) | (CURVE if self.curve else 0)
        number = tables.setdefault(self.names, len(tables) + 1) if self.names else 0
        return [
            f"@{flags:x}",
            *([f"^{number} {folder / self.names}.txt"] if self.names else ()),
            f"+{{{self.label}}} {self.gtkwave()}",
            *([f"@{ROOM}", *["-"] * CURVE_LINES] if self.curve else ()),
        ]


GROUPS = {
    "SCLOCK and PANIC": [
        Signal("u_adaptor.sclock_o"),
        Signal("u_adaptor.panic_o"),
        Signal("u_adaptor.brake_release_o"),
        Signal("u_adaptor.led_irq_o"),
    ],
    "interrupt": [
        Signal("u_adaptor.u_core.u_pccsr.sclock_q"),
        Signal("u_adaptor.u_core.u_pccsr.csr_q", 8, HEX),
        Signal("u_adaptor.u_core.u_pccsr.sclock_latch_q"),
        Signal("u_adaptor.u_core.u_pccsr.panic_latch_q"),
        Signal("u_adaptor.u_core.u_pccsr.irq_req_q"),
        # the level of an acknowledge
        Signal("u_adaptor.u_bus_interrupter.vme_a_i", 3, HEX, 1, port="u_adaptor.vme_a_i"),
        Signal("u_adaptor.u_core.u_pit.g_counter[2].u_counter.ce_q", 16, HEX),
    ],
    "VME": [
        Signal("u_adaptor.vme_a_i", 15, HEX, 1, names="registers"),
        Signal("u_adaptor.vme_am_i", 6, HEX),
        Signal("u_adaptor.vme_as_ni"),
        Signal("u_adaptor.vme_ds_ni", 2, BIN),
        Signal("u_adaptor.vme_write_ni"),
        Signal("u_adaptor.vme_d_i", 8, HEX),
        Signal("u_adaptor.vme_d_o", 8, HEX),
        Signal("u_adaptor.vme_d_oe_o"),
        Signal("u_adaptor.vme_dtack_no"),
        Signal("u_adaptor.vme_irq_no", 7, BIN, 1),
        Signal("u_adaptor.vme_iack_ni"),
        Signal("u_adaptor.vme_iackin_ni"),
        Signal("u_adaptor.vme_iackout_no"),
        Signal("u_adaptor.u_bus_slave.busy_q"),
        Signal("u_adaptor.u_bus_slave.ds0_held_q"),
        Signal("u_adaptor.u_bus_interrupter.respond_q"),
        Signal("u_adaptor.u_bus_interrupter.answer_q"),
        Signal("u_adaptor.u_core.state_q", 2, STATE, state_of="adaptor_core"),
    ],
    "PC bus": [
        Signal("u_adaptor.pc_a_o", 16, HEX),
        Signal("u_adaptor.pc_aen_o"),
        Signal("u_adaptor.pc_ior_no"),
        Signal("u_adaptor.pc_iow_no"),
        Signal("u_adaptor.pc_d_o", 8, HEX),
        Signal("u_adaptor.pc_d_i", 8, HEX),
        Signal("u_adaptor.pc_reset_drv_o"),
        Signal("u_adaptor.u_core.u_master.state_q", 2, STATE, state_of="pcbus_master"),
    ],
    "axis 0": [
        Signal(f"{AXIS}.u_encoder.latch_i"),
        Signal(f"{AXIS}.u_encoder.a_i"),
        Signal(f"{AXIS}.u_encoder.b_i"),
        Signal(f"{AXIS}.u_encoder.count_q", 16, SIGNED, curve=True),
        Signal(f"{AXIS}.u_dac.rank1_q", 12, HEX),
        Signal(f"{AXIS}.u_dac.rank2_q", 12, HEX),
        Signal(f"{AXIS}.drive_v_o", 16, SIGNED, curve=True, port=f"{CARD}.drive_v_o"),
        Signal(f"{AXIS}.adc_v_i", 16, SIGNED, curve=True, port=f"{CARD}.adc_v_i"),
        Signal(f"{AXIS}.adc_code_q", 12, HEX),
        Signal(f"{AXIS}.u_adc.busy_q"),
        Signal(f"{AXIS}.u_heartbeat.run_q"),
    ],
    # the part of a pass, and the instruction, of a processor
    "firmware": [
        Signal("u_host_view.phase", 3, HEX, names="phases"),
        Signal("u_host_view.pc", 32, HEX),
    ],
    "card 0": [
        Signal(f"{CARD}.leds_o", 11, BIN),
        Signal(f"{CARD}.enc_a_i", 2, BIN),
        Signal(f"{CARD}.enc_b_i", 2, BIN),
        Signal(f"{CARD}.enc_i_i", 2, BIN),
        Signal(f"{CARD}.axis_enable_i", 2, BIN),
    ],
}


def check_packages() -> None:
    """Raises InputError where the package that reads a trace is not installed."""
    need(("pywellen",), "waves", "waveforms")


def write_views(trace: Path) -> tuple[Path, Path]:
    """Writes the two view files beside the trace, and the tables of names."""
    gtkw, sucl = trace.with_suffix(".gtkw"), trace.with_suffix(".sucl")
    names = trace.resolve().with_suffix(".names")
    write_tables(names)
    found = variables(trace)
    cards = [Signal(path, var.length, HEX) for path, var in found.items() if path[:5] == "CARD."]
    groups = GROUPS | ({"own card": cards} if cards else {})
    seen = first_pass(found, MACHINE)
    events = (first_missed(found, MACHINE), first_panic(found, MACHINE))
    for path, text in (
        (gtkw, _gtkwave(trace, names, groups, seen, events)),
        (sucl, _surfer(groups, seen)),
    ):
        with whole_file(path) as part:
            part.write_text(text)
    return gtkw, sucl


def _gtkwave(trace: Path, names: Path, groups: dict, seen: Pass | None, events: tuple) -> str:
    """events: when each of EVENTS came, or None."""
    lines, tables = [f'[dumpfile] "{trace.resolve()}"'], {}
    came = [at for at in events if at is not None]
    if seen or came:
        wide = seen.last_write - seen.sclock if seen else ALONE_PS
        zoom = -math.log2(wide * 1.15 / PIXELS * FRAME)
        begin = came[-1] - wide // 2 if came else seen.sclock - wide // 20
        times = [*(seen or [-1] * len(MARKERS)), *(-1 if at is None else at for at in events)]
        times += [-1] * (26 - len(times))
        lines += [f"[timestart] {max(0, begin)}", f"*{zoom:.6f} -1 {' '.join(map(str, times))}"]
        lines += ["@200", f"-{LEGEND}"]
    lines += ["[sst_expanded] 1"]
    for name, signals in groups.items():
        lines += [f"@{GROUP_BEGIN}", f"-{name}"]
        for signal in signals:
            lines += signal.lines(names, tables)
        lines += [f"@{GROUP_END}", f"-{name}"]
    return "\n".join(lines) + "\n"


def _surfer(groups: dict, seen: Pass | None) -> str:
    lines = []
    for name, signals in groups.items():
        lines.append(f"divider_add {name}")
        lines += [f"variable_add {signal.full()}" for signal in signals]
    lines += ["zoom_fit", *([f"cursor_set {seen.sclock}"] if seen else ())]
    return "\n".join(lines) + "\n"


def open_viewer(trace: Path) -> None:
    """Opens GTKWave or Surfer when there is one and a display, or says what to type."""
    gtkw, sucl = trace.with_suffix(".gtkw"), trace.with_suffix(".sucl")
    commands = {"gtkwave": [str(trace), str(gtkw)], "surfer": ["-c", str(sucl), str(trace)]}
    found = next((name for name in commands if shutil.which(name)), None)
    if found and (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        quiet = subprocess.DEVNULL
        subprocess.Popen(
            [found, *commands[found]], stdout=quiet, stderr=quiet, start_new_session=True
        )
        return
    echo(f"to look at it: gtkwave {trace} {gtkw}")
    echo(f"           or: surfer -c {sucl} {trace}   (untried)")
