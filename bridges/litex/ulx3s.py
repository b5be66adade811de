# SPDX-License-Identifier: Apache-2.0
"""The SoC on a ULX3S with an LFE5U-45F: its bitstream, size and fmax. Nothing of it was tried on a
board. Of LiteX's ULX3S it takes the pins alone: no SDRAM, no BIOS.

.venv/bin/python bridges/litex/ulx3s.py [build/litex-ulx3s]
"""

import json
import os
import sys
from pathlib import Path

from soc import CLK_HZ, ROOT, Soc, with_firmware  # isort: skip  # says what is missing of LiteX

from litex.build.generic_platform import IOStandard, Misc, Pins
from litex.gen import LiteXModule
from litex.soc.cores.clock import ECP5PLL
from litex_boards.platforms import radiona_ulx3s
from migen import Cat, ClockDomain, ClockSignal, Constant, Instance, ResetSignal

TOOLS = {"yosys": [], "nextpnr-ecp5": ["--report", "report.json"], "ecppack": []}
CELLS = {"TRELLIS_COMB": "LUT4", "TRELLIS_FF": "flip-flops", "DP16KD": "block RAM",
         "MULT18X18D": "multipliers"}  # fmt: skip
# Header J1. Inputs are pulled up, so that an open stop loop is a pressed button; what drives
# brakes is pulled down.
HEADER = {
    "spi_sclk": ("B11", "NONE"), "adc_cs_n": ("C11", "NONE"), "adc_din": ("A10", "NONE"),
    "adc_dout": ("A11", "UP"), "dac_sync_n": ("A9", "NONE"), "dac_din": ("B10", "NONE"),
    "dac_clr_n": ("A5", "DOWN"), "dac_ldac_n": ("A2", "UP"),
    "enc_a": ("B9 C8", "UP"), "enc_b": ("C10 B8", "UP"), "enc_i": ("A7 C6", "UP"),
    "enable_n": ("A6 B6", "UP"), "estop_n": ("A8", "UP"),
    "brake_release": ("C7", "DOWN"), "alive": ("A4", "DOWN"),
}  # fmt: skip


class Clock(LiteXModule):
    """24 MHz of the board's 25; the button FIRE 1 is the reset."""

    def __init__(self, platform):
        self.cd_sys = ClockDomain()
        self.pll = pll = ECP5PLL()
        self.comb += pll.reset.eq(platform.request("rst"))
        pll.register_clkin(platform.request("clk25"), 25e6)
        pll.create_clkout(self.cd_sys, CLK_HZ, margin=1e-9)


def board(image: list | None = None) -> Soc:
    platform = radiona_ulx3s.Platform(device="LFE5U-45F")
    platform.add_extension([
        (name, 0, Pins(pins), IOStandard("LVCMOS33"), Misc(f"PULLMODE={pull}"))
        for name, (pins, pull) in HEADER.items()
    ])  # fmt: skip
    pin = {name: platform.request(name) for name in HEADER}
    safety = {"estop_closed": ~pin["estop_n"], "cable_ok": Constant(1), "pc_power": Constant(1)}
    soc = Soc(platform, Clock(platform), image, **safety)
    mmcs = soc.mmcs
    soc.comb += [getattr(mmcs, name).eq(pin[name]) for name in ("enc_a", "enc_b", "enc_i")]
    soc.comb += [mmcs.axis_enable.eq(~pin["enable_n"])]
    soc.comb += [pin[name].eq(getattr(mmcs, name)) for name in ("brake_release", "alive")]
    lights = Cat(mmcs.card_leds[:4], mmcs.sclock, mmcs.brake_release, mmcs.panic)
    soc.comb += [platform.request("user_led", n).eq(lights[n]) for n in range(len(lights))]
    soc.specials += Instance(
        "spi_converters", p_ClkHz=CLK_HZ, i_clk_i=ClockSignal("sys"), i_rst_ni=soc.crg.pll.locked,
        i_run_i=~ResetSignal("sys"), o_sclk_o=pin["spi_sclk"], o_adc_cs_no=pin["adc_cs_n"],
        o_adc_din_o=pin["adc_din"], i_adc_dout_i=pin["adc_dout"], o_dac_sync_no=pin["dac_sync_n"],
        o_dac_din_o=pin["dac_din"], o_dac_clr_no=pin["dac_clr_n"],
        o_dac_ldac_no=pin["dac_ldac_n"], i_drive_v_i=mmcs.drive_v, o_adc_v_o=mmcs.adc_v,
    )  # fmt: skip
    platform.add_source(str(ROOT / "fpga/bus/spi_converters.sv"))
    return soc


def add_tools(folder: Path) -> None:
    """The pinned tools under the names that LiteX calls, first on the PATH."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, more in TOOLS.items():
        tool = folder / name
        pinned = Path(sys.executable).with_name(f"yowasp-{name}")
        if not pinned.is_file():
            sys.exit(f"mmcs: {pinned.name} is missing; run: make fpga")
        tool.write_text(f'#!/bin/sh\nexec {" ".join([str(pinned), *more])} "$@"\n')
        tool.chmod(0o755)
    os.environ["PATH"] = f"{folder}:{os.environ['PATH']}"


def main(folder: Path) -> None:
    add_tools(folder / "bin")
    soc = with_firmware(board, folder)
    soc.platform.build(soc, build_dir=str(folder), build_name="ulx3s")
    report = json.loads((folder / "report.json").read_text())
    used = report["utilization"]
    sizes = [f"{used[c]['used']} of {used[c]['available']} {name}" for c, name in CELLS.items()]
    fmax = min(clock["achieved"] for clock in report["fmax"].values())
    print(f"{folder / 'ulx3s.bit'}: {', '.join(sizes)}; {fmax:.1f} MHz, {CLK_HZ / 1e6:g} wanted")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "build/litex-ulx3s").resolve())
