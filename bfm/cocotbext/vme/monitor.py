# SPDX-License-Identifier: Apache-2.0
"""A VME monitor: records every cycle on the pins and holds both sides against the rules."""

from dataclasses import dataclass

from cocotbext.mmcs import one_of, pin, whole
from cocotbext.mmcs.monitor import Monitor
from cocotbext.vme.bus import DS_BOTH, DS_EVEN, DS_NONE, VmeBus

# ns: what the standard asks of a master at its own pins, and what is left of it at a slave's
LIMITS = {
    "master": {"addr_setup": 35, "as_high": 40, "write_setup": 35, "data_setup": 35,
               "as_to_ds": 0, "ds_skew": 10, "ds_high": 40},
    "slave": {"addr_setup": 10, "as_high": 30, "write_setup": 10, "data_setup": 10,
              "as_to_ds": -10, "ds_skew": 20, "ds_high": 30},
}  # fmt: skip
DTACK_NS = 30  # the earliest answer after a strobe

RULES = {
    # of the master
    "addr_setup": "address, AM, LWORD* and IACK* stand before AS* falls",
    "as_high": "AS* is high between two address cycles",
    "as_to_ds": "a data strobe falls in an address cycle",
    "write_setup": "WRITE* stands before the first data strobe",
    "data_setup": "write data stands before the first data strobe",
    "ds_skew": "both data strobes of a cycle fall together",
    "ds_high": "the data strobes are high between two cycles",
    "next_strobe": "a data strobe waits for DTACK* and BERR* to be high",
    "address_held": "address, AM, LWORD* and IACK* stand until the answer",
    "as_held": "AS* stands until the answer",
    "write_held": "WRITE* stands while a data strobe is low",
    "data_held": "write data stands until the answer",
    "strobe_held": "the data strobes stay low until DTACK*, BERR* or the bus timer",
    "chain_in_cycle": "IACKIN* falls in an acknowledge cycle only",
    # of the slave
    "dtack_alone": "DTACK* and BERR* fall only while a data strobe is low",
    "ds_to_dtack": "an answer comes 30 ns after the data strobe, not earlier",
    "one_answer": "a cycle ends with DTACK* or with BERR*, not with both",
    "dtack_early": "DTACK* and BERR* stay low until both data strobes are high",
    "data_first": "read data is driven before DTACK* falls",
    "data_stands": "read data stands until a data strobe rises",
    "drive_on_write": "a slave does not drive data in a write cycle",
    "drive_idle": "data drivers come on only while a data strobe is low",
    "drivers_off": "data drivers are off before DTACK* rises",
    "one_fate": "an acknowledge is answered or passed on, never both",
    "iackout_alone": "IACKOUT* is low only behind a low IACKIN*",
}


@dataclass
class VmeCycle:
    """One data transfer or acknowledge as seen on the pins; times in ns."""

    kind: str  # read, write, iack
    address: int
    am: int
    size: int
    start: float
    data: int = 0
    answer: float = 0.0
    end: float = 0.0
    outcome: str = "none"  # DTACK*, BERR*, none


class VmeMonitor(Monitor):
    """`cycles` is what was seen, `broken` the rules that were broken, as (rule, ns, sentence).

    With `fail` a broken rule fails the test at once. `at` says whose limits hold: "slave", or
    "master" for the pins of a master. Rules named in `allow` are not judged.
    """

    KIND, RULES = "vme", RULES
    WATCHED = ("a", "am", "as_n", "ds_n", "write_n", "lword_n", "d", "q", "q_oe", "dtack_n",
               "berr_n", "iack_n", "iackin_n", "iackout_n")  # fmt: skip
    cycles: list[VmeCycle]

    def __init__(
        self, bus: VmeBus, *, at: str = "slave", fail: bool = True, allow=(),
        bus_timer: int = 16_000,
    ):  # fmt: skip
        self.limits = LIMITS[one_of("at", at, tuple(LIMITS))]
        self.bus_timer = whole("bus_timer", bus_timer, 1)
        self._moved = dict.fromkeys(("as", "cycle", "write", "d", "ds", "last"), float("-inf"))
        self._open: VmeCycle | None = None
        self._late_as = False
        super().__init__(bus, fail=fail, allow=allow)

    # -- looking -------------------------------------------------------------------------------

    def _look(self) -> dict:
        """All pins; a missing one rests. What is not known counts as all ones."""
        bus, seen = self.bus, {}
        for name in ("as_n", "ds_n", "write_n", "lword_n", "iack_n", "iackin_n", "iackout_n",
                     "dtack_n", "berr_n", "sysreset_n", "a", "am", "d", "q"):  # fmt: skip
            handle = getattr(bus, name)
            seen[name] = 1 if handle is None else pin(handle)
        driven = None if bus.q_oe is None else bus.q_oe.value
        seen["oe"] = int(driven) if driven is not None and driven.is_resolvable else None
        seen["cycle"] = (seen["a"], seen["am"], seen["lword_n"], seen["iack_n"])
        return seen

    def _judge(self, was: dict, now: dict) -> None:
        self._master(was, now)
        self._slave(was, now)
        self._record(was, now)
        for name, key in (("as", "as_n"), ("cycle", "cycle"), ("write", "write_n"),
                          ("d", "d"), ("ds", "ds_n")):  # fmt: skip
            if was[key] != now[key]:
                self._moved[name] = self._now

    def _after(self, name: str, since: str) -> None:
        """That at least the limit of this name has passed since something moved."""
        gone, limit = self._now - self._moved[since], self.limits[name]
        self._rule(name, gone >= limit, f"{gone:g} ns, not {limit}")

    # -- rules ---------------------------------------------------------------------------------

    def _master(self, was: dict, now: dict) -> None:
        strobed, strobed_before = now["ds_n"] != DS_NONE, was["ds_n"] != DS_NONE
        if was["as_n"] and not now["as_n"]:
            fresh = was["cycle"] != now["cycle"]
            self._rule("addr_setup", not fresh, "they move with it")
            self._after("addr_setup", "cycle")
            self._after("as_high", "as")
            if self._late_as:
                late = self._now - self._moved["ds"]
                self._rule("as_to_ds", -late >= self.limits["as_to_ds"], f"AS* {late:g} ns late")
                self._late_as = False
        if strobed and not strobed_before:
            self._strobe(was, now)
        elif strobed and was["ds_n"] & ~now["ds_n"] and self._open:
            skew = self._now - self._open.start
            self._rule("ds_skew", skew <= self.limits["ds_skew"], f"{skew:g} ns")
        answered = not (was["dtack_n"] and was["berr_n"] and now["dtack_n"] and now["berr_n"])
        if strobed and strobed_before:
            self._rule("write_held", was["write_n"] == now["write_n"])
            if not answered:
                self._rule("address_held", was["cycle"] == now["cycle"])
                self._rule("as_held", not (now["as_n"] and not was["as_n"]))
                still = now["write_n"] or was["d"] == now["d"]
                self._rule("data_held", bool(still))
        if strobed_before and not strobed:
            waited = self._open is None or self._now - self._open.start >= self.bus_timer
            if self._late_as:
                self._rule("as_to_ds", False, "AS* is high")
                self._late_as, waited = False, True  # nobody was asked
            # an acknowledge that was passed on is answered by somebody else
            elsewhere = not now["iackout_n"] or not was["iackout_n"]
            answered = answered or (self._open is not None and self._open.outcome != "none")
            self._rule("strobe_held", answered or waited or elsewhere)
        if was["iackin_n"] and not now["iackin_n"]:
            self._rule("chain_in_cycle", not now["iack_n"] and not now["as_n"])

    def _strobe(self, was: dict, now: dict) -> None:
        """The first data strobe of a cycle has fallen."""
        self._rule("next_strobe", bool(now["dtack_n"] and now["berr_n"]))
        self._rule("write_setup", was["write_n"] == now["write_n"], "it moves with the strobe")
        self._after("write_setup", "write")
        self._after("ds_high", "ds")
        if not now["write_n"]:
            self._rule("data_setup", was["d"] == now["d"], "it moves with the strobe")
            self._after("data_setup", "d")
        self._late_as = bool(now["as_n"])

    def _slave(self, was: dict, now: dict) -> None:
        strobed, strobed_before = now["ds_n"] != DS_NONE, was["ds_n"] != DS_NONE
        write = not now["write_n"] and now["iack_n"]
        for line, other in (("dtack_n", "berr_n"), ("berr_n", "dtack_n")):
            if was[line] and not now[line]:
                self._rule("dtack_alone", strobed and strobed_before)
                gone = self._now - self._moved["ds"]
                if strobed and strobed_before:
                    self._rule("ds_to_dtack", gone >= DTACK_NS, f"{gone:g} ns")
                self._rule("one_answer", bool(now[other]))
                self._rule("one_fate", bool(now["iack_n"] or now["iackout_n"]))
                if line == "dtack_n" and not write and strobed:
                    self._rule("data_first", now["oe"] != 0)
            if now[line] and not was[line]:
                self._rule("dtack_early", not (strobed and strobed_before and now["sysreset_n"]))
                self._rule("drivers_off", not now["oe"])
        if not was["dtack_n"] and was["ds_n"] == now["ds_n"] and strobed and not write:
            self._rule("data_stands", was["q"] == now["q"] and was["oe"] == now["oe"])
        if now["oe"] and not was["oe"]:
            self._rule("drive_idle", strobed)
            self._rule("drive_on_write", not (strobed and write))
        if was["iackout_n"] and not now["iackout_n"]:
            self._rule("iackout_alone", not now["iackin_n"])

    # -- record --------------------------------------------------------------------------------

    def _record(self, was: dict, now: dict) -> None:
        strobed, strobed_before = now["ds_n"] != DS_NONE, was["ds_n"] != DS_NONE
        if strobed and not strobed_before:
            kind = "iack" if not now["iack_n"] else "read" if now["write_n"] else "write"
            self._open = VmeCycle(kind, now["a"] << 1, now["am"], 1, self._now)
        cycle = self._open
        if cycle is None:
            return
        for line, name in (("dtack_n", "DTACK*"), ("berr_n", "BERR*")):
            if was[line] and not now[line] and strobed:
                cycle.outcome, cycle.answer = name, self._now
        if strobed:
            self._value(cycle, now)
        if strobed_before and not strobed:
            cycle.end, self._open = self._now, None
            self.cycles.append(cycle)
            self.log.debug(
                "%-5s %X.%d %X %s", cycle.kind, cycle.address, cycle.size, cycle.data, cycle.outcome
            )

    @staticmethod
    def _value(cycle: VmeCycle, now: dict) -> None:
        strobes = now["ds_n"]
        if strobes == DS_BOTH:
            cycle.size = 2 if now["lword_n"] else 4
        address = now["a"] << 1
        cycle.address = address if strobes in (DS_BOTH, DS_EVEN) else address | 1
        word = now["d"] if cycle.kind == "write" else now["q"]
        word = word >> 8 if strobes == DS_EVEN else word
        cycle.data = word & (1 << 8 * cycle.size) - 1
