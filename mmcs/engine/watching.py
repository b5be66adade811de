# SPDX-License-Identifier: Apache-2.0
"""Nets watched clock by clock: the part of a Sim that draws waveforms without a file."""

from __future__ import annotations

import numpy as np

from mmcs.errors import RunError

CHANGE = np.dtype([("clock", "i8"), ("net", "i4"), ("value", "u4")])  # mmcs_change


class Watching:
    def watch(self, nets: list[str]) -> None:
        """From now on changes() tells of these; of a machine that skips nothing."""
        for net in nets:
            if self.lib.mmcs_sim_watch(self._sim, net.encode()) < 0:
                raise RunError(
                    f"{net}: no register or port, or this machine does not see each clock"
                )

    def changes(self) -> np.ndarray:
        """Clock, number of the net, value after the clock; in order."""
        out = self.ffi.new("const mmcs_change **")
        count = self.lib.mmcs_sim_changes(self._sim, out)
        raw = self.ffi.buffer(out[0], count * CHANGE.itemsize) if count else b""
        return np.frombuffer(raw, CHANGE).copy()
