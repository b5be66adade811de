# SPDX-License-Identifier: Apache-2.0
"""The Modular Motor Control System of 1989, complete in simulation: the user's side."""

from mmcs.place import BUILD, ROBOTS, ROOT, SCENARIOS

__version__ = "0.2.0"
__all__ = [  # noqa: F822  (those of the front come when they are asked for)
    "BUILD", "ROBOTS", "ROOT", "SCENARIOS",
    "Device", "InputError", "Machine", "Motion", "Run", "RunError", "compare", "load", "run",
    "sweep",
]  # fmt: skip


def __getattr__(name: str):
    """The names of mmcs/front.py, loaded when they are asked for."""
    if name in __all__:
        from mmcs import front

        return getattr(front, name)
    raise AttributeError(f"module 'mmcs' has no attribute {name!r}")
