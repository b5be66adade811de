# SPDX-License-Identifier: Apache-2.0
"""What the tests of the models share: a VMEbus of wires; errors that must come, and their words."""

from contextlib import contextmanager

from cocotb.triggers import Timer
from cocotbext.vme import VmeBus

NAMES = ("a", "am", "as_n", "ds_n", "write_n", "lword_n", "d", "q", "q_oe", "dtack_n", "berr_n",
         "iack_n", "iackin_n", "iackout_n", "irq_n")  # fmt: skip


@contextmanager
def raises(kind: type, words: str = ""):
    try:
        yield
    except kind as error:
        assert words in str(error), f"{error!r} does not say {words!r}"
    else:
        raise AssertionError(f"no {kind.__name__}: {words}")


def refused(*cases) -> None:
    """Each (kind, words, call) ends in that error."""
    for kind, words, call in cases:
        with raises(kind, words):
            call()


async def wires(dut, **other) -> VmeBus:
    """The bus, at rest."""
    bus = VmeBus(**{name: getattr(dut, name) for name in NAMES} | other)
    bus.idle()
    bus.silent()
    dut.chain1_n.value = dut.iackout_n.value = 1
    await Timer(10, "ns")
    return bus
