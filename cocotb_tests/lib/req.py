# SPDX-License-Identifier: Apache-2.0
"""Decorators of cocotb tests; a collector reads what they store on the function."""

from collections.abc import Callable
from functools import partial, wraps
from inspect import signature

import cocotb

REQ = "mmcs_req"
SLOW = "mmcs_slow"
VARIANTS = "mmcs_variants"


def test(*ids: str):
    """A cocotb test, with the requirements that would be unproven without it."""

    def mark(func):
        setattr(getattr(func, "func", func), REQ, ids)
        return cocotb.test()(func)

    return mark


def tests_on(bench: Callable, *only: str):
    """A test() whose function gets the bench, started, as `tb`, and the `dut` where it names that.

    `bench` is a class with start(), or a coroutine function that takes the dut; what the decorator
    is given by name goes to it. `only`: as variants().
    """

    def test_on(*ids: str, **options):
        def mark(func):
            made = test(*ids)(func)
            fill = made.func

            @wraps(fill)
            async def run(dut, **named):
                start = bench(dut).start if isinstance(bench, type) else partial(bench, dut)
                named["tb"] = await start(**options)
                if "dut" in signature(fill).parameters:
                    named["dut"] = dut
                await fill(**named)

            made.func = variants(*only)(run) if only else run
            return made

        return mark

    test_on.__test__ = False
    return test_on


test.__test__ = tests_on.__test__ = False  # pytest: none of them is a test


def slow(func):
    """Left out of `make test-fast`."""
    setattr(func, SLOW, True)
    return func


def variants(*names: str):
    """Runs the test on these entries of the module's VARIANTS only."""

    def mark(func):
        setattr(func, VARIANTS, names)
        return func

    return mark
