#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A scenario's machine for LinuxCNC: the far end of the component mmcs.comp. docs/use/linuxcnc.md

    .venv/bin/python bridges/linuxcnc/machine.py puma560_coupled --path /tmp/mmcs-hal.sock

One exchange for each period of the HAL thread: commands in, one servo interval of the machine, what
it measured out. So both live by one clock, and a run is the same every time, however busy the
computer is. The scenario's motions, calls and events are left aside: LinuxCNC moves the arm.
"""

import argparse
import csv
import os
import socket
import struct
import sys
from pathlib import Path

from mmcs import InputError, RunError, Setup, load, machine, mcdef

AXES, MAGIC = 32, 0x3148434D
HEAD, ANSWER = struct.Struct("<IIq"), struct.Struct("<IId")
AXIS_IN, AXIS_OUT = struct.Struct("<ddII"), struct.Struct("<dddII")
ENABLE, ESTOP_OK = 1, 2
FAULT, ENABLED, PANIC, RELEASED = 1, 2, 4, 8
INDEX_WANTED = 1
AMP_FAULT, INDEX_SEEN, VELOCITY = 1, 2, 4
PATH = Path("/tmp/mmcs-hal.sock")
VOLTS_PER_UNIT = 10 / 2048
SHUTS_DOWN = mcdef.MERR_PLO | mcdef.MERR_PHI | mcdef.MERR_ILIM | mcdef.MERR_PANIC
LINES = struct.Struct("<ddi")  # head of a sample's row (docs/use/protocol.md)


class Axis:
    """What the host counts from, and what it waits for."""

    def __init__(self, number: int, values: dict):
        self.number, self.zero, self.waits, self.count = number, 0, False, 0
        self.mode = values["mode"]
        self.rest = 0.0  # of a velocity: what whole counts per period have left over

    def setpoint(self, position: float, velocity: float, period_s: float) -> int:
        """In the units of the axis's servo: counts, or counts per period, exact in the mean."""
        if self.mode != "velocity":
            return round(position) + self.zero
        wanted = velocity * period_s + self.rest
        self.rest = wanted - round(wanted)
        return round(wanted)

    def index_seen(self, count: int, at: int) -> None:
        """The low 16 bits of the count were `at` at the index: that place is now 0."""
        self.zero = count - ((count - at + 0x8000 & 0xFFFF) - 0x8000)
        self.waits = False


class Bridge:
    """The driver of one machine as the host sees it."""

    def __init__(self, sim, setup: Setup):
        self.sim, self.setup = sim, setup
        self.axes = [Axis(n, values) for n, values in enumerate(setup.params)]
        self.interval_s = setup.scenario.interval_us * 1e-6
        self.wanted = self.fault = self.pressed = False
        self.estop = sim.input_names().index("estop")
        sim.tap(16, 16)
        self.client = sim.open(mcdef.O_RDWR)
        if self.client < 0:
            raise RunError(f"open: {os.strerror(-self.client)}")
        self._configure(on=False)

    def _configure(self, **parts: bool) -> bool:
        """False: MENABLE is refused."""
        driver, params = self.setup.driver(), self.setup.params
        result, what = self.sim.configure(self.client, driver, params, **parts)
        if result < 0 and what != "MENABLE":
            raise RunError(f"{what}: {os.strerror(-result)}")
        return result >= 0

    def _ask(self, request: str, argument=None) -> None:
        result = self.sim.ioctl(self.client, getattr(mcdef, request), argument)
        if result < 0:
            raise RunError(f"{request}: {os.strerror(-result)}")

    def exchange(self, message: bytes) -> bytes:
        magic, flags, period_ns = HEAD.unpack_from(message)
        size = HEAD.size + AXES * AXIS_IN.size
        if magic != MAGIC or len(message) != size:
            raise RunError("not a message of this mmcs.comp: build the component again")
        if abs(period_ns * 1e-9 - self.interval_s) > 0.01 * self.interval_s:
            raise RunError(
                f"the HAL thread's period is {period_ns} ns and the scenario's interval_us"
                f" {self.setup.scenario.interval_us}: make them equal"
            )
        self._press(not flags & ESTOP_OK)
        if self.wanted and not flags & ESTOP_OK:
            self.fault = True
        self._enable(flags & (ENABLE | ESTOP_OK) == ENABLE | ESTOP_OK)
        self._command([AXIS_IN.unpack_from(message, HEAD.size + AXIS_IN.size * n)
                       for n in range(len(self.axes))])  # fmt: skip
        if not self.sim.run(self.sim.time + self.interval_s):
            raise RunError("an assertion of the machine has failed")
        return self._answer()

    def _press(self, pressed: bool) -> None:
        """The host's contact is in the loop of the hand-held button."""
        if pressed != self.pressed:
            self.sim.add_event(self.sim.time, self.estop, 0, float(pressed))
            self.pressed = pressed

    def _enable(self, wanted: bool) -> None:
        if wanted and not self.wanted:
            self.sim.read(self.client)
            self._ask("MCLEARERROR")
            self.fault = not self._configure(set_up=False)
        elif self.wanted and not wanted:
            self._ask("MSTOP")
        self.wanted = wanted

    def _command(self, commands: list[tuple]) -> None:
        for axis, (_, _, flags, _) in zip(self.axes, commands, strict=True):
            if flags & INDEX_WANTED and not axis.waits:
                axis.waits = True
                self._ask("MCALIB", mcdef.new_int(axis.number))
        if self.sim.stats()["enabled"]:
            self.sim.write(self.client, [
                axis.setpoint(position, velocity, self.interval_s)
                for axis, (position, velocity, _, _) in zip(self.axes, commands, strict=True)
            ])  # fmt: skip

    def _answer(self) -> bytes:
        states, stats = self.sim.read(self.client), self.sim.stats()
        self.fault = self.fault or (self.wanted and not stats["enabled"])
        out, indexed = [], False
        for axis, state in zip(self.axes, states, strict=True):
            errors = state["errcode"]
            seen = bool(errors & mcdef.MERR_ZINDEX)
            indexed = indexed or seen
            if seen and axis.waits:
                axis.index_seen(state["encnow"], errors >> 16 & 0xFFFF)
            else:
                seen = False
            speed = (state["encnow"] - axis.count) / self.interval_s
            axis.count = state["encnow"]
            broken = self.wanted and (not stats["enabled"] or errors & SHUTS_DOWN)
            flags = (AMP_FAULT * bool(broken) | INDEX_SEEN * seen
                     | VELOCITY * (axis.mode == "velocity"))  # fmt: skip
            volts = state["inow"] * VOLTS_PER_UNIT
            out.append(AXIS_OUT.pack(axis.count - axis.zero, speed, volts, flags, 0))
        if indexed:
            self._ask("MCLEARERROR")
        rows = self.sim.tap_head()[0]
        lines = LINES.unpack_from(self.sim.tap_rows(max(rows - 1, 0), 1, 1)[0])[2] if rows else 0
        panic = bool(stats["panic_level"])  # now, which the lines of the last sample may not know
        flags = (FAULT * self.fault | ENABLED * bool(stats["enabled"])
                 | PANIC * panic | RELEASED * bool(lines & 2 and not panic))  # fmt: skip
        out += [bytes(AXIS_OUT.size)] * (AXES - len(out))
        return ANSWER.pack(MAGIC, flags, self.sim.time) + b"".join(out)


def serve(bridge: Bridge, host: socket.socket, log) -> None:
    """Until the host hangs up; log: a CSV writer, or None."""
    if log:
        names = ("count", "true_count", "angle_rad")
        log.writerow(["t_s", *(f"{n}{a.number}" for a in bridge.axes for n in names)])
    while True:
        try:
            message = host.recv(4096)
            if not message:
                return
            host.send(bridge.exchange(message))
        except (BrokenPipeError, ConnectionResetError):
            return
        if log:
            row = [f"{bridge.sim.time:.6f}"]
            for axis in bridge.axes:
                truth = bridge.sim.true(axis.number)
                row += [axis.count, truth["count"], f"{truth['angle']:.9f}"]
            log.writerow(row)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenario", help="as mmcs run takes it")
    parser.add_argument("--path", type=Path, default=PATH, help="of the socket")
    parser.add_argument("--log", type=Path, help="CSV of counts and angles, a row per period")
    given = parser.parse_args()
    try:
        setup = load(given.scenario)
        if given.path.exists() and not given.path.is_socket():
            raise InputError.one("--path", "", str(given.path), "is there and is no socket")
        with machine(setup) as sim, socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as door:
            file = given.log.open("w", newline="") if given.log else None
            given.path.unlink(missing_ok=True)
            door.bind(str(given.path))
            door.listen(1)
            print(f"mmcs: {setup.name}, {setup.axes} axes, at {given.path}", flush=True)
            try:
                with door.accept()[0] as host:
                    serve(Bridge(sim, setup), host, csv.writer(file) if file else None)
            finally:
                given.path.unlink(missing_ok=True)
                if file:
                    file.close()
    except (InputError, RunError, OSError) as error:
        print(f"mmcs: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
