# SPDX-License-Identifier: Apache-2.0
"""The package of the lab sheets, found by its entry points: `command` is `mmcs lab`, `page`
the worker of the page's view *Labs*."""

from mmcs.errors import InputError


def offered(name: str):
    """The entry point. Raises InputError where no such package is installed."""
    from importlib.metadata import entry_points

    for found in entry_points(group="mmcs.labs", name=name):
        return found
    raise InputError.one("mmcs lab", "", None, "no lab sheets are installed: make .venv/.sim")
