# SPDX-License-Identifier: Apache-2.0
"""MMCS in a LiteX SoC: a module with a Wishbone slave and an interrupt. docs/use/bridges.md

    self.mmcs = MMCS(platform, sys_clk_freq, cards=3, estop_closed=platform.request("estop_closed"),
                     cable_ok=Constant(1), pc_power=platform.request("pc_power"))
    self.bus.add_slave("mmcs", self.mmcs.bus, SoCRegion(size=MMCS.SIZE, cached=False))
    self.irq.add("mmcs")

LiteX's own headers then give software MMCS_BASE and MMCS_INTERRUPT, and firmware/ports/window.h the
driver's bus over them: words, MMCS_BASE the first.
"""

import sys
from pathlib import Path

from litex.gen import LiteXModule
from litex.soc.interconnect import wishbone
from litex.soc.interconnect.csr_eventmanager import EventManager, EventSourceLevel
from migen import Cat, ClockSignal, Constant, Instance, ResetSignal, Signal

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))
from sources import sources  # noqa: E402

PINS_IN = {"enc_a": 2, "enc_b": 2, "enc_i": 2, "axis_enable": 2, "adc_v": 32}  # bits of a card
PINS_OUT = {"drive_v": 32, "card_leds": 11}
SAFETY = ("estop_closed", "cable_ok", "pc_power")


class MMCS(LiteXModule):
    """Adaptor and cards. The joints' pins are signals of the same names. What closes the brakes has
    no default: estop_closed, cable_ok, pc_power are the pins' signals, or Constant(1) for what
    there is not. brake_release and alive belong to the brakes' circuit (docs/hardware/fpga.md)."""

    SIZE = 0x10000  # the window is the first 4 KiB; beyond it the bus gets its error

    def __init__(self, platform, sys_clk_freq: float, cards: int = 1, **safety):
        for name in SAFETY:
            if safety.get(name) is None:
                raise ValueError(
                    f"mmcs: {name} is missing; give its pin, or Constant(1) if there is none"
                )
        if unknown := set(safety) - set(SAFETY):
            raise ValueError(f"mmcs: {min(unknown)} is no pin; there are {', '.join(SAFETY)}")
        hz = int(sys_clk_freq)
        if hz != sys_clk_freq or hz % 8_000_000 or not 8_000_000 <= hz <= 80_000_000:
            raise ValueError(f"mmcs: sys_clk_freq {sys_clk_freq:g} must be 8 to 80 MHz, in 8 MHz")
        if not 1 <= cards <= 16:
            raise ValueError(f"mmcs: cards {cards} must be 1 to 16")
        self.bus = wishbone.Interface(data_width=32, address_width=32, addressing="byte")
        self.ev = EventManager()
        self.ev.request = EventSourceLevel(description="SCLOCK or PANIC")
        self.ev.finalize()
        for name, width in (PINS_IN | PINS_OUT).items():
            setattr(self, name, Signal(width * cards, name=f"mmcs_{name}"))
        self.brake_release, self.alive = Signal(), Signal()
        self.panic, self.sclock = Signal(), Signal()
        self._add(hz, cards, safety)
        for file in sources("rtl"):
            platform.add_source(str(file))
        platform.add_verilog_include_path(str(ROOT / "rtl"))

    def _add(self, hz: int, cards: int, safety: dict) -> None:
        port = {"req": 1, "write": 1, "a": 10, "wdata": 8, "ack": 1, "rdata": 8, "vector": 8}
        hp = {name: Signal(width, name=f"mmcs_hp_{name}") for name, width in port.items()}
        reset = {"i_clk_i": ClockSignal("sys"), "i_rst_ni": ~ResetSignal("sys")}
        bus = self.bus
        self.specials += Instance(
            "adaptor_wb", **reset, p_DataWidth=32, p_AddrWidth=16,
            i_wb_cyc_i=bus.cyc, i_wb_stb_i=bus.stb, i_wb_we_i=bus.we, i_wb_adr_i=bus.adr[:16],
            i_wb_sel_i=bus.sel, i_wb_dat_i=bus.dat_w, o_wb_dat_o=bus.dat_r, o_wb_ack_o=bus.ack,
            o_wb_err_o=bus.err, o_hp_req_o=hp["req"], o_hp_write_o=hp["write"], o_hp_a_o=hp["a"],
            o_hp_wdata_o=hp["wdata"], i_hp_ack_i=hp["ack"], i_hp_rdata_i=hp["rdata"],
            i_vector_i=hp["vector"],
        )  # fmt: skip
        ports = {f"i_{n}_i": getattr(self, n) for n in PINS_IN}
        ports |= {f"i_{n}_i": pin for n, pin in safety.items()}
        ports |= {f"o_{n}_o": getattr(self, n) for n in PINS_OUT}
        ports |= {f"i_pcx_{n}_i": Constant(0, w) for n, w in
                  {"d": 8, "d_oe": 1, "wait": 1, "irq": 5}.items()}  # fmt: skip
        self.specials += Instance(
            "mmcs_core", **reset, **ports, p_NumCards=cards, p_ClkHz=hz, i_sysreset_ni=Constant(1),
            i_dip_i=Cat(*(Constant(n, 4) for n in range(cards))),
            o_brake_release_o=self.brake_release, o_alive_o=self.alive, o_panic_o=self.panic,
            o_sclock_o=self.sclock,
            o_irq_req_o=self.ev.request.trigger, o_vector_o=hp["vector"], i_hp_req_i=hp["req"],
            i_hp_write_i=hp["write"], i_hp_a_i=hp["a"], i_hp_wdata_i=hp["wdata"],
            o_hp_ack_o=hp["ack"], o_hp_rdata_o=hp["rdata"],
        )  # fmt: skip
