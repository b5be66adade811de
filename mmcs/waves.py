# SPDX-License-Identifier: Apache-2.0
"""A prepared view of a trace, for GTKWave (.gtkw) and Surfer (.sucl), beside the trace."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path
from typing import NamedTuple

TOP = "TOP"
MACHINE = f"{TOP}.mmcs"
SOC_MACHINE = f"{TOP}.mmcs_soc.u_mmcs"  # of --host rv32
BIN, HEX, SIGNED = "28", "22", "424"  # GTKWave's codes of a number format
GROUP_BEGIN, GROUP_END = "800200", "1000200"


class Signal(NamedTuple):
    path: str  # below the machine, or with / below what holds it
    width: int = 1
    form: str = BIN
    low: int = 0  # its lowest bit

    def full(self, machine: str = MACHINE) -> str:
        return TOP + "." + self.path[1:] if self.path[0] == "/" else f"{machine}.{self.path}"

    def gtkwave(self, machine: str = MACHINE) -> str:
        return self.full(machine) + (
            f"[{self.low + self.width - 1}:{self.low}]" if self.width > 1 else ""
        )


GROUPS = {
    "VME": [
        Signal("u_adaptor.vme_a_i", 15, HEX, 1),
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
    ],
    "PC bus": [
        Signal("pc_a", 16, HEX),
        Signal("pc_aen"),
        Signal("pc_ior_n"),
        Signal("pc_iow_n"),
        Signal("pc_wdata", 8, HEX),
        Signal("pc_rdata", 8, HEX),
        Signal("pc_reset_drv"),
    ],
    # 0 stopped, 1 program, 2 enter, 3 read, 4 compute, 5 write, 6 publish; its instruction
    "firmware": [
        Signal("u_host_view.phase", 3, HEX),
        Signal("u_host_view.pc", 32, HEX),
    ],
    "SCLOCK and PANIC": [
        Signal("sclock_o"),
        Signal("panic_o"),
        Signal("brake_release_o"),
        Signal("led_irq_o"),
    ],
    "card 0": [
        Signal("g_card[0].u_card.leds_o", 11, BIN),
        Signal("g_card[0].u_card.enc_a_i", 2, BIN),
        Signal("g_card[0].u_card.enc_b_i", 2, BIN),
        Signal("g_card[0].u_card.enc_i_i", 2, BIN),
        Signal("g_card[0].u_card.axis_enable_i", 2, BIN),
        Signal("g_card[0].u_card.bus_busy"),
    ],
    "axis 0": [
        Signal("g_card[0].u_card.g_axis[0].u_axis.latch_i"),
        Signal("g_card[0].u_card.g_axis[0].u_axis.a_i"),
        Signal("g_card[0].u_card.g_axis[0].u_axis.b_i"),
        Signal("g_card[0].u_card.g_axis[0].u_axis.u_encoder.count_q", 16, SIGNED),
        Signal("g_card[0].u_card.g_axis[0].u_axis.dac_lo_i"),
        Signal("g_card[0].u_card.g_axis[0].u_axis.dac_hi_i"),
        Signal("g_card[0].u_card.g_axis[0].u_axis.drive_v_o", 16, SIGNED),
        Signal("g_card[0].u_card.g_axis[0].u_axis.adc_v_i", 16, SIGNED),
        Signal("g_card[0].u_card.g_axis[0].u_axis.adc_code_o", 12, HEX),
        Signal("g_card[0].u_card.g_axis[0].u_axis.converting_o"),
        Signal("g_card[0].u_card.g_axis[0].u_axis.heartbeat_o"),
    ],
}


# What takes the place of these groups where the machine has its own processor.
SOC_GROUPS = {
    "VME": (
        "host port",
        [
            Signal("hp_req_i"),
            Signal("hp_write_i"),
            Signal("hp_a_i", 10, HEX, 1),
            Signal("hp_wdata_i", 8, HEX),
            Signal("hp_rdata_o", 8, HEX),
            Signal("hp_ack_o"),
        ],
    ),
    "firmware": (
        "firmware",
        [Signal("u_host_view.phase", 3, HEX), Signal("/mmcs_soc.u_host.u_cpu.u_ibex_core.pc_id", 32, HEX)],
    ),
}


def view(host: str = "native") -> tuple[str, dict[str, list[Signal]]]:
    """The machine's place in a trace, and the groups of its prepared view."""
    if host != "rv32":
        return MACHINE, GROUPS
    return SOC_MACHINE, dict(SOC_GROUPS.get(name, (name, g)) for name, g in GROUPS.items())


def write_views(trace: Path, host: str = "native") -> tuple[Path, Path]:
    """Writes the two view files beside the trace."""
    gtkw, sucl = trace.with_suffix(".gtkw"), trace.with_suffix(".sucl")
    gtkw.write_text(_gtkwave(trace, *view(host)))
    sucl.write_text(_surfer(*view(host)))
    return gtkw, sucl


def _gtkwave(trace: Path, machine: str, groups: dict[str, list[Signal]]) -> str:
    lines = [f'[dumpfile] "{trace.resolve()}"', "[timestart] 0", "[sst_expanded] 1"]
    for name, signals in groups.items():
        lines += [f"@{GROUP_BEGIN}", f"-{name}"]
        for signal in signals:
            lines += [f"@{signal.form}", signal.gtkwave(machine)]
        lines += [f"@{GROUP_END}", f"-{name}"]
    return "\n".join(lines) + "\n"


def _surfer(machine: str, groups: dict[str, list[Signal]]) -> str:
    lines = []
    for name, signals in groups.items():
        lines.append(f"divider_add {name}")
        lines += [f"variable_add {signal.full(machine)}" for signal in signals]
    return "\n".join([*lines, "zoom_fit"]) + "\n"


def open_viewer(trace: Path) -> None:
    """Opens GTKWave or Surfer when there is one and a display; else says what to type."""
    import click

    gtkw, sucl = trace.with_suffix(".gtkw"), trace.with_suffix(".sucl")
    commands = {"gtkwave": [str(trace), str(gtkw)], "surfer": ["-c", str(sucl), str(trace)]}
    found = next((name for name in commands if shutil.which(name)), None)
    if found and (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        quiet = subprocess.DEVNULL
        subprocess.Popen(
            [found, *commands[found]], stdout=quiet, stderr=quiet, start_new_session=True
        )
        return
    click.echo(f"to look at it: gtkwave {trace} {gtkw}")
    click.echo(f"           or: surfer -c {sucl} {trace}")
