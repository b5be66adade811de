# SPDX-License-Identifier: Apache-2.0
"""The signals of a slot of the 8-bit PC bus."""

from cocotbext.mmcs import pin
from cocotbext.mmcs.bus import Bus

# By the pins of a card: d goes to it, q comes from it. A host has the same the other way round.
CARD = {"a": "a_i", "aen": "aen_i", "ior_n": "ior_ni", "iow_n": "iow_ni", "d": "d_i", "q": "d_o",
        "q_oe": "d_oe_o", "clk_en": "clk_en_i", "reset_drv": "reset_drv_i", "drq": "drq_i",
        "irq": "irq_o", "iochrdy": "iochrdy_o", "wait": "wait_o"}  # fmt: skip
HOST = {"a": "a_o", "aen": "aen_o", "ior_n": "ior_no", "iow_n": "iow_no", "d": "d_o", "q": "d_i",
        "q_oe": "d_oe_i", "clk_en": "clk_en_o", "reset_drv": "reset_drv_o", "drq": "drq_o",
        "irq": "irq_i", "iochrdy": "iochrdy_i", "wait": "wait_i"}  # fmt: skip
OPTIONAL = {"aen", "q", "q_oe", "clk_en", "reset_drv", "drq", "irq", "iochrdy", "wait"}


class BusTimeout(Exception):
    """A card has held IOCHRDY low beyond the limit."""


class PcBus(Bus):
    """The signals of one slot by their short names; those that the design lacks are None.

    `iochrdy` is low while a card asks for wait states; `wait`, where a design has that instead, is
    high. from_prefix: PREFIX_ior_ni and so on of a card, PREFIX_ior_no of a host.
    """

    PINS, FACING, OPTIONAL, STROBE = CARD, HOST, OPTIONAL, "ior_n"

    def idle(self) -> None:
        """What a host that does nothing drives; CLK ticks with every clock of the design."""
        self.put(aen=0, reset_drv=0, drq=0, a=0, ior_n=1, iow_n=1, clk_en=1, d=0xFF)

    def silent(self) -> None:
        """What cards that do nothing drive."""
        self.put(q=0xFF, q_oe=0, irq=0)
        self.stretch(False)

    def can_stretch(self) -> bool:
        return self.iochrdy is not None or self.wait is not None

    def stretch(self, wait: bool) -> None:
        """A card asks for wait states, or no more."""
        self.put(iochrdy=int(not wait), wait=int(wait))

    def stretched(self) -> bool:
        if self.wait is not None:
            return bool(pin(self.wait))
        return self.iochrdy is not None and not pin(self.iochrdy)
