# SPDX-License-Identifier: Apache-2.0
"""Decorators of cocotb tests; a collector reads what they store on the function."""

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
