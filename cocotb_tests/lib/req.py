# SPDX-License-Identifier: Apache-2.0
"""Decorators that a cocotb test carries below `@cocotb.test()`; a collector reads them.

They only store attributes on the function: no simulator is needed to read them.
"""

REQ = "mmcs_req"
SLOW = "mmcs_slow"
VARIANTS = "mmcs_variants"


def req(*ids: str):
    """Names the requirements that would be unproven without this test."""

    def mark(func):
        setattr(func, REQ, tuple(getattr(func, REQ, ())) + ids)
        return func

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
