# SPDX-License-Identifier: Apache-2.0
"""The signals of one VME slot, and what can go wrong on them."""

from dataclasses import dataclass

from cocotbext.mmcs import whole
from cocotbext.mmcs.bus import Bus

# {DS1*, DS0*}
DS_BOTH, DS_ODD, DS_EVEN, DS_NONE = 0b00, 0b10, 0b01, 0b11
AM_USER, AM_SUPERVISOR = 0x29, 0x2D  # A16
AM_A24_USER, AM_A24_SUPERVISOR = 0x39, 0x3D
AM_A32_USER, AM_A32_SUPERVISOR = 0x09, 0x0D
# Address lines by modifier; what is not here may have as many as the bus.
SPACES = dict.fromkeys((0x29, 0x2D), 16) | dict.fromkeys((0x39, 0x3A, 0x3D, 0x3E), 24)

# By the pins of a slave: d goes to it, q comes from it. A master has the same the other way round.
SLAVE = {"a": "a_i", "am": "am_i", "as_n": "as_ni", "ds_n": "ds_ni", "write_n": "write_ni",
         "lword_n": "lword_ni", "d": "d_i", "q": "d_o", "q_oe": "d_oe_o", "dtack_n": "dtack_no",
         "berr_n": "berr_no", "iack_n": "iack_ni", "iackin_n": "iackin_ni",
         "iackout_n": "iackout_no", "irq_n": "irq_no", "sysreset_n": "sysreset_ni"}  # fmt: skip
FLIP = {"_i": "_o", "_o": "_i", "_ni": "_no", "_no": "_ni"}
MASTER = {
    short: name[: name.rindex("_")] + FLIP[name[name.rindex("_") :]]
    for short, name in SLAVE.items()
} | {"sysreset_n": "sysreset_ni"}
OPTIONAL = {"q_oe", "berr_n", "iack_n", "iackin_n", "iackout_n", "irq_n", "lword_n", "sysreset_n"}


class BusError(Exception):
    """The cycle ended with BERR*."""


class BusTimeout(BusError):
    """Nobody answered: the backplane's bus timer drove BERR*."""


class VmeBus(Bus):
    """The signals of one slot by their short names; those that the design lacks are None.

    from_prefix: PREFIX_as_ni and so on of a slave, PREFIX_as_no of a master.
    """

    PINS, FACING, OPTIONAL, STROBE = SLAVE, MASTER, OPTIONAL, "as_n"

    def __init__(self, **handles):
        super().__init__(**handles)
        self.data_width, self.address_width = len(self.d), len(self.a) + 1
        if self.data_width not in (8, 16, 32):
            raise ValueError(f"data of 8, 16 or 32 lines, not {self.data_width}")
        self._held: dict[tuple[str, int], set] = {}

    def idle(self) -> None:
        """What a master that does nothing drives."""
        self.put(as_n=1, write_n=1, lword_n=1, iack_n=1, iackin_n=1, sysreset_n=1)
        self.put(ds_n=DS_NONE, a=0, am=0, d=0)

    def silent(self) -> None:
        """What slaves and interrupters that do nothing drive."""
        for name in ("dtack_n", "berr_n", "irq_n"):
            if (handle := getattr(self, name)) is not None:
                handle.value = (1 << len(handle)) - 1
        self.put(q=(1 << len(self.q)) - 1, q_oe=0)

    def pull(self, name: str, who: object, low: bool, bit: int = 0) -> None:
        """An open-collector line: low while anybody of those who ever pulled it still does."""
        handle = getattr(self, name)
        if handle is None:
            raise ValueError(f"this bus has no signal {name}")
        held = self._held.setdefault((name, bit), set())
        (held.add if low else held.discard)(id(who))
        level = 0
        for n in range(len(handle)):
            level |= (not self._held.get((name, n))) << n
        handle.value = level


@dataclass
class VmeTiming:
    """Least times that a master keeps, in ns: those of the standard, or longer."""

    setup: int = 35  # A, AM, LWORD*, IACK*, WRITE*, D before the strobes
    as_to_ds: int = 0
    ds_skew: int = 0  # between DS1* and DS0*, at most 10
    release: int = 0  # DTACK* low to the strobes high
    ds_high: int = 40  # both strobes high between cycles
    bus_timer: int = 16_000
    illegal: bool = False  # allow what the standard forbids

    def __post_init__(self):
        least = {"setup": 35, "ds_high": 40, "bus_timer": 1}
        for name in ("setup", "as_to_ds", "ds_skew", "release", "ds_high", "bus_timer"):
            most = 10 if name == "ds_skew" else None
            what = f"VmeTiming.{name}"
            value = getattr(self, name)
            whole(what, value, 0)
            if not self.illegal:
                try:
                    whole(what, value, least.get(name, 0), most)
                except ValueError as error:
                    raise ValueError(f"{error}: illegal=True allows it") from None
