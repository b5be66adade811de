# SPDX-License-Identifier: Apache-2.0
"""The parts of a Sim that look on: nets clock by clock and the cycles of the VME bus, for waveforms
without a file; sample by sample, for programs in lock-step."""

from mmcs.errors import RunError


class Watching:
    def watch(self, nets: list[str], others: list[str] | None = None) -> list[str]:
        """From now on changes() tells of these; of a machine that skips nothing. And of those
        others that can be watched, which it returns."""
        for net in nets:
            if self.lib.mmcs_sim_watch(self._sim, net.encode()) < 0:
                raise RunError(
                    f"{net}: no register or port, or this machine does not see each clock"
                )
        watch = self.lib.mmcs_sim_watch
        return [net for net in others or () if watch(self._sim, net.encode()) >= 0]

    def changes(self):
        """An array: clock, number of the net, value after the clock; in order."""
        import numpy as np

        change = np.dtype([("clock", "i8"), ("net", "i4"), ("value", "u4")])  # mmcs_change
        out = self.ffi.new("const mmcs_change **")
        count = self.lib.mmcs_sim_changes(self._sim, out)
        raw = self.ffi.buffer(out[0], count * change.itemsize) if count else b""
        return np.frombuffer(raw, change).copy()

    def run_to(self, clock: int, samples: bool) -> bool:
        """As run() up to a clock, or to the next SIGUSR1, or if asked servo sample, before it."""
        return self.lib.mmcs_sim_run_to(self._sim, clock, samples) == 0

    @property
    def samples(self) -> int:
        """Servo samples since power-on."""
        return self.lib.mmcs_sim_samples(self._sim)

    def bus_cycles(self) -> bytes:
        """Cycles of the VME bus since the last call, an array of mmcs_bus_cycle; the first call
        starts to record them."""
        out = self.ffi.new("const mmcs_bus_cycle **")
        count = self.lib.mmcs_sim_bus_cycles(self._sim, out)
        return bytes(self.ffi.buffer(out[0], count * self.ffi.sizeof("mmcs_bus_cycle")))

    # --- the tap: positions count from the first record ever ---

    def tap(self, rows: int, events: int) -> None:
        """From now on so many samples and events are kept for readers."""
        if self.lib.mmcs_sim_tap(self._sim, rows, events):
            raise RunError(f"no tap of {rows} samples and {events} events can be made")

    def tap_head(self) -> tuple[int, int, int]:
        """Samples and events there have been, bytes of a sample's row."""
        head = self._head
        self.lib.mmcs_sim_tap_head(self._sim, head)
        return head.rows, head.events, head.row_bytes

    def tap_rows(self, start: int, every: int, limit: int) -> tuple[bytes, int, int, int]:
        """Rows from a position on: as bytes, how many, where to go on, and how many are lost."""
        size = self.tap_head()[2]
        buffer, read = bytearray(limit * size), self.ffi.new("mmcs_tap_read *")
        data = self.ffi.from_buffer(buffer)
        self.lib.mmcs_sim_tap_rows(self._sim, start, every, data, limit, read)
        return bytes(memoryview(buffer)[: read.count * size]), read.count, read.next, read.lost

    def tap_events(self, start: int, limit: int) -> tuple[list[dict], int, int]:
        """Events from a position on, where to go on, and how many are lost."""
        found, read = self.ffi.new("mmcs_tap_event[]", limit), self.ffi.new("mmcs_tap_read *")
        self.lib.mmcs_sim_tap_events(self._sim, start, found, limit, read)
        text = lambda chars: self.ffi.string(chars).decode(errors="replace")  # noqa: E731
        events = [
            {"n": e.n, "t": e.t, "kind": text(e.kind), "axis": e.axis, "value": e.value,
             "text": text(e.text)}
            for e in found[0 : read.count]
        ]  # fmt: skip
        return events, read.next, read.lost

    def tap_note(self, text: str) -> None:
        """A line of the log, about no axis."""
        self.lib.mmcs_sim_tap_note(self._sim, b"log", -1, 0, text.encode())
