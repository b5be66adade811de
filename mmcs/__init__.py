# SPDX-License-Identifier: Apache-2.0
"""The Modular Motor Control System of 1989, complete in simulation: the user's side."""

from mmcs.place import BUILD, ROBOTS, ROOT, SCENARIOS

__version__ = "0.1.0"
__all__ = ["BUILD", "ROBOTS", "ROOT", "SCENARIOS", "Device"]


def __getattr__(name: str):
    """mmcs.Device, loaded when it is asked for."""
    if name == "Device":
        from mmcs.device.client import Device

        return Device
    raise AttributeError(f"module 'mmcs' has no attribute {name!r}")
