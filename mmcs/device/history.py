# SPDX-License-Identifier: Apache-2.0
"""The past of a served machine: snapshots, and going back to one.

A snapshot holds the machine and its driver, but no program. So for each it is remembered who had
the device open then; after a rewind those who have it open now have it again, and what the others
had is closed.
"""

EVERY_S, KEPT = 0.1, 100  # the ring of snapshots at the start


class History:
    def __init__(self, machine):
        self._machine, self._sim = machine, machine.sim
        # Who has the device open in snapshots from this number on: driver's number -> client's.
        self._known: list[tuple[int, dict[int, int]]] = []
        self._next = 0  # number that the next snapshot will have, or less
        self._sim.ring(EVERY_S, KEPT)

    def clients_changed(self) -> None:
        machine = self._machine
        kept = self._sim.snapshots()
        self._next = max(self._next, kept[-1]["id"] + 1 if kept else 0)
        opens = {c.driver: c.number for c in machine.clients.values() if c.driver >= 0}
        oldest = kept[0]["id"] if kept else self._next
        while len(self._known) > 1 and self._known[1][0] <= oldest:
            self._known.pop(0)  # no snapshot is as old as that
        while self._known and self._known[-1][0] == self._next:
            self._known.pop()
        self._known.append((self._next, opens))

    def rewind(self, number: int) -> None:
        self._sim.restore(number)
        self._next = max(self._next, number + 1)
        _, had = next((k for k in reversed(self._known) if k[0] <= number), (0, {}))
        self._known = [k for k in self._known if k[0] <= number]
        self._settle(had)
        self._sim.tap_note("rewind", number, f"back to snapshot {number}")
        self.clients_changed()

    def _settle(self, had: dict[int, int]) -> None:
        """Those who are here get their opens; whoever is not loses his."""
        machine = self._machine
        here = {n: c for n, c in machine.clients.items() if c.device == "/dev/mc0"}
        for client in here.values():
            client.driver = -1
        for driver, number in had.items():
            if number in here:
                here[number].driver = driver
        for client in here.values():
            if client.driver < 0:
                client.driver = max(-1, self._sim.open(client.flags & 3))
        for driver, number in had.items():
            if number not in here:
                self._sim.close(driver)
