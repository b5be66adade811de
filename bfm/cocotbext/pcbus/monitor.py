# SPDX-License-Identifier: Apache-2.0
"""A monitor of the PC I/O bus: records every cycle and holds it against the rules."""

from dataclasses import dataclass

from cocotbext.mmcs import number
from cocotbext.mmcs.monitor import Monitor
from cocotbext.pcbus.bus import PcBus

RULES = {
    "one_command": "IOR# and IOW# are never low together",
    "aen": "AEN is low in an I/O cycle",
    "setup": "the address stands before the command",
    "address_held": "the address stands through the command",
    "address_after": "the address stands past the end of the command",
    "command": "a command is long enough",
    "longest": "IOCHRDY stretches a command up to its limit, no further",
    "recovery": "two commands are apart",
    "data_held": "write data stands past the end of IOW#",
    "drive_in_read": "a card drives data only while IOR# is low",
}


@dataclass
class PcCycle:
    """One I/O cycle as seen on the bus; times in ns."""

    kind: str
    address: int
    data: int
    start: float
    setup: float
    command: float = 0.0


class PcBusMonitor(Monitor):
    """`cycles` is what was seen, `broken` the rules that were broken, as (rule, ns, sentence).

    With `fail` a broken rule fails the test at once. Rules named in `allow` are not judged.
    """

    KIND, RULES = "pcbus", RULES
    WATCHED = ("a", "d", "q", "q_oe", "ior_n", "iow_n", "aen")
    cycles: list[PcCycle]

    def __init__(
        self, bus: PcBus, *, setup_ns: float = 125, command_ns: float = 500, hold_ns: float = 20,
        recovery_ns: float = 0, longest_ns: float = float("inf"), fail: bool = True, allow=(),
    ):  # fmt: skip
        self.limits = {"setup": setup_ns, "command": command_ns, "hold": hold_ns,
                       "recovery": recovery_ns, "longest": longest_ns}  # fmt: skip
        for name, ns in self.limits.items():
            number(f"{name}_ns", ns, 0, float("inf"))
        self._address_at = self._ended = float("-inf")
        self._open: PcCycle | None = None
        super().__init__(bus, fail=fail, allow=allow)

    def _look(self) -> dict:
        bus, seen = self.bus, {}
        for name in self.WATCHED:
            handle = getattr(bus, name)
            known = handle is not None and handle.value.is_resolvable
            seen[name] = int(handle.value) if known else int(name.endswith("_n"))
        return seen

    def _judge(self, was: dict, now: dict) -> None:
        now_low = not (now["ior_n"] and now["iow_n"])
        was_low = not (was["ior_n"] and was["iow_n"])
        last = self.cycles[-1] if self.cycles else None
        gone = self._now - self._ended
        if last and gone < self.limits["hold"]:
            self._rule("address_after", was["a"] == now["a"], f"{gone:g} ns")
            if last.kind == "write":
                self._rule("data_held", was["d"] == now["d"], f"{gone:g} ns")
        self._rule("one_command", bool(now["ior_n"] or now["iow_n"]))
        if now_low and not was_low:
            self._begin(was, now, gone)
        elif now_low:
            self._rule("address_held", was["a"] == now["a"])
            self._rule("aen", not now["aen"])
        if self._open and now_low:
            self._open.data = now["q"] if self._open.kind == "read" else now["d"]
        if was_low and not now_low and self._open:
            self._end(was, now)
        if now["q_oe"] and now["ior_n"]:
            self._rule("drive_in_read", False)
        if was["a"] != now["a"]:
            self._address_at = self._now

    def _begin(self, was: dict, now: dict, gone: float) -> None:
        kind = "write" if now["ior_n"] else "read"
        setup = self._now - self._address_at if was["a"] == now["a"] else 0.0
        self._open = PcCycle(kind, now["a"], 0, self._now, setup)
        self._rule("aen", not now["aen"])
        # a clock's period in whole ps may fall short of its half ns
        self._rule("setup", setup >= self.limits["setup"] - 1, f"{setup:g} ns")
        self._rule("recovery", gone >= self.limits["recovery"] - 1, f"{gone:g} ns")

    def _end(self, was: dict, now: dict) -> None:
        cycle, self._open = self._open, None
        cycle.command = self._now - cycle.start
        self.cycles.append(cycle)
        self._ended = self._now
        self.log.debug("%-5s %04X %02X", cycle.kind, cycle.address, cycle.data)
        self._rule("command", cycle.command >= self.limits["command"] - 1, f"{cycle.command:g} ns")
        self._rule("longest", cycle.command <= self.limits["longest"], f"{cycle.command:g} ns")
        self._rule("address_after", was["a"] == now["a"], "it moves with the command's end")
        if cycle.kind == "write":
            self._rule("data_held", was["d"] == now["d"], "it moves with the command's end")
