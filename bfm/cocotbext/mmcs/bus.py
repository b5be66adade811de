# SPDX-License-Identifier: Apache-2.0
"""What the slots of all buses have in common: signals by short names, split data lines."""

from typing import ClassVar, Self

from cocotbext.mmcs import check_time_step, find, pin


class ProtocolError(AssertionError):
    """A rule of the bus was broken."""


class Bus:
    """The signals of one slot by their short names; those that the design lacks are None.

    A kind of bus says its PINS as a slave or card names them, the same FACING it, of a master or
    host, which of them are OPTIONAL, and the STROBE by whose name the two are told apart.
    """

    PINS: ClassVar[dict[str, str]]
    FACING: ClassVar[dict[str, str]]
    OPTIONAL: ClassVar[set[str]]
    STROBE: ClassVar[str]

    def __init__(self, **handles):
        check_time_step()
        kind = type(self).__name__
        unknown = sorted(handles.keys() - self.PINS.keys())
        if unknown:
            raise TypeError(f"{kind} has no signal {unknown[0]}: it has {', '.join(self.PINS)}")
        missing = sorted(self.PINS.keys() - self.OPTIONAL - handles.keys())
        if missing:
            raise TypeError(f"{kind} needs the signal {missing[0]}")
        for name in self.PINS:
            setattr(self, name, handles.get(name))

    @classmethod
    def from_prefix(cls, dut, prefix: str) -> Self:
        """By the names of a slave or card, or by those of a master or host."""
        facing = hasattr(dut, f"{prefix}_{cls.FACING[cls.STROBE]}")
        return cls(**find(dut, prefix, cls.FACING if facing else cls.PINS, cls.OPTIONAL))

    def put(self, **values: int) -> None:
        """Drives signals; those that the design lacks are left out."""
        for name, value in values.items():
            if (handle := getattr(self, name)) is not None:
                handle.value = value

    def driven(self) -> bool | None:
        """Whether a slave or card drives the data lines; None where no pin tells."""
        return None if self.q_oe is None else bool(pin(self.q_oe))

    def data(self) -> int:
        """The data as a master or host sees it: high where nobody drives."""
        if self.driven() is False:
            return (1 << len(self.d)) - 1
        if self.q is None:
            raise ValueError("this bus has no signal q, which a read needs")
        value = self.q.value
        if not value.is_resolvable:
            raise ProtocolError(f"the read data is {value}: not driven, or not known")
        return int(value)
