# SPDX-License-Identifier: Apache-2.0
"""Motions of several joints in rad and A, as firmware/lib/motion.h makes them from C.

The joints are those of a robot file; docs/use/motion.md.
"""

from __future__ import annotations

import errno
import math
from collections import deque
from dataclasses import dataclass, fields
from pathlib import Path

from mmcs import mcdef
from mmcs.device.client import Device
from mmcs.scenario.load import load_robot
from mmcs.scenario.robot import Robot

UNITS_PER_V, ADC_ZERO = 204.8, 2048  # D/A and A/D: 12 bits over +-10 V
SHARE = 0.5  # of the motor's limits, for those that motions ask for
PROFILES = ("trapezoid", "quintic", "jerk")
JERK_S = 0.05  # in which a jerk-limited motion reaches its full acceleration


@dataclass(frozen=True)
class Joint:
    """struct motion_axis of firmware/lib/motion.h."""

    name: str
    counts: float  # per rad, signed as the gear
    per_ampere: float  # D/A units
    inertia: float  # A per rad/s^2
    friction: float  # A per rad/s
    speed: float  # rad/s, rad/s^2: the most that motions here ask for
    acceleration: float
    low: float  # stops; equal: none
    high: float
    turn: int  # counts from index to index; 0: no index
    mark: float  # counts that the disc is turned against the shaft
    pot: float  # rad per A/D unit, 0: none
    pot_zero: float  # A/D value at 0 rad
    param: dict[str, int]


def joint_of(robot: Robot, axis: int, interval_us: int) -> Joint:
    motor, counts = robot.axis[axis], robot.counts_per_rad(axis)
    param = robot.servo(axis, interval_us)
    mode = mcdef.mode_word(param.pop("mode"), param.pop("flags"))
    per_ampere = UNITS_PER_V / motor.amp_gain
    torque = param["ilim"] / abs(per_ampere) * motor.km
    left = max(torque - motor.coulomb_pos, 0.2 * torque)
    speed = motor.v_supply / motor.km if motor.v_supply else math.sqrt(left / motor.inertia)
    scale = SHARE / abs(motor.gear)
    return Joint(
        motor.name, counts, per_ampere, motor.inertia * motor.gear / motor.km,
        motor.viscous * motor.gear / motor.km, scale * speed, scale * left / motor.inertia,
        motor.stop_lo, motor.stop_hi, motor.counts_per_rev if motor.index_per_rev else 0,
        motor.encoder_offset * motor.counts_per_rev / math.tau,
        1 / (UNITS_PER_V * motor.pot_v_per_rad) if motor.pot_v_per_rad else 0.0,
        ADC_ZERO + UNITS_PER_V * motor.pot_offset, {"mode": mode, **param},
    )  # fmt: skip


def joints_of(robot: str | Path, interval_us: int = 1000) -> list[Joint]:
    """Of a robot file, or of a name of sim/robots. Raises InputError."""
    _, found = load_robot(str(robot))
    return [joint_of(found, axis, interval_us) for axis in range(found.axes())]


def header(robot: str, interval_us: int) -> str:
    """The joints as a C header; what `mmcs exec --robot` prints."""
    order, rows = mcdef.fields("mc_param"), []
    for joint in joints_of(robot, interval_us):
        values = [f".{f.name} = {_c(getattr(joint, f.name))}" for f in fields(joint)[:-1]]
        param = mcdef.initial() | joint.param
        param = ", ".join(f".{key} = {_c(param[key])}" for key in order if key in param)
        rows.append("    {" + ",\n     ".join([*values, f".param = {{{param}}}"]) + "},\n")
    title = f"/* The joints of {Path(robot).stem} at {interval_us} us: mmcs exec --robot */"
    return (
        f"{title}\n#include <motion.h>\n"
        f"#define ROBOT_AXES {len(rows)}\n#define ROBOT_INTERVAL_US {interval_us}\n"
        f"static const struct motion_axis robot[ROBOT_AXES] = {{\n{''.join(rows)}}};\n"
    )


def _c(value) -> str:
    if value == -(1 << 31):
        return "-2147483647 - 1"  # which C has no literal for
    return f'"{value}"' if isinstance(value, str) else repr(value)


# --- the buffer ----------------------------------------------------------------------------------


@dataclass
class Point:
    """One number for each joint: rad, rad/s, rad/s^2, and A beside what the servo asks for."""

    position: list[float]
    velocity: list[float]
    acceleration: list[float]
    current: list[float]


def rest_at(position: list[float]) -> Point:
    zeros = [0.0] * len(position)
    return Point(list(position), zeros, zeros, zeros)


def _between(p: Point, q: Point, h: float, s: float) -> Point:
    """The polynomial of fifth order from p to q, which is h later, s after p."""
    positions, velocities, accelerations = [], [], []
    start, end = (zip(x.position, x.velocity, x.acceleration, strict=True) for x in (p, q))
    for (q0, v, a), (q1, v1, a1) in zip(start, end, strict=True):
        d = q1 - q0 - v * h - a * h * h / 2
        dv, da = (v1 - v - a * h) * h, (a1 - a) * h * h
        c3 = (10 * d - 4 * dv + da / 2) / (h * h * h)
        c4 = (-15 * d + 7 * dv - da) / (h * h * h * h)
        c5 = (6 * d - 3 * dv + da / 2) / (h * h * h * h * h)
        positions.append(q0 + s * (v + s * (a / 2 + s * (c3 + s * (c4 + s * c5)))))
        velocities.append(v + s * (a + s * (3 * c3 + s * (4 * c4 + s * 5 * c5))))
        accelerations.append(a + s * (6 * c3 + s * (12 * c4 + s * 20 * c5)))
    return Point(positions, velocities, accelerations, p.current)


class Motion:
    """The joints of a robot, on an open device. Time 0 is the first sample after this.

    What is put into its buffer is played by step() or run(): between two knots every joint follows
    the polynomial of fifth order that has their positions, velocities and accelerations.
    """

    def __init__(self, device: Device, robot: str | Path, interval_us: int = 1000):
        self.device, self.joints = device, joints_of(robot, interval_us)
        device.set_num_joints(self.axes)
        device.set_interval(interval_us)
        self.interval = device.interval() * 1e-6
        for axis, joint in enumerate(self.joints):
            device.set_param(axis, device.get_param(axis) | joint.param)
        self.zero = [0] * self.axes  # the count at 0 rad
        self.late = 0  # samples that came while the program was busy
        self.sample = self.begin = device.wait()
        self._knots: deque[tuple[float, Point]] = deque()
        names = {"a0": 1, "a1": 0, "b0": 1, "b1": 0}
        self._law = [[j.param.get(key, or_) for key, or_ in names.items()] for j in self.joints]
        self._rest()

    @property
    def axes(self) -> int:
        return len(self.joints)

    @property
    def time(self) -> float:
        """That the next setpoints are for, s."""
        return (self.sample + 1 - self.begin) * self.interval

    def enable(self) -> None:
        self.device.enable()
        self.sample = self.device.wait()
        self._rest()

    def positions(self) -> list[float]:
        """Where the joints are, rad."""
        states = self.device.read(self.axes)
        rows = zip(states, self.zero, self.joints, strict=True)
        return [(state.encnow - zero) / joint.counts for state, zero, joint in rows]

    def currents(self) -> list[float]:
        """What was asked of the amplifiers last, A."""
        states = self.device.read(self.axes)
        return [s.inow / j.per_ampere for s, j in zip(states, self.joints, strict=True)]

    def set(self, axis: int, position: float) -> None:
        """One joint goes to a position at once; the others keep their setpoints."""
        if not 0 <= axis < self.axes:
            raise OSError(errno.EINVAL, f"axis {axis}: must be 0 to {self.axes - 1}")
        self._check("position", [position] * self.axes)
        place = [*self.rest.position]
        place[axis] = position
        self.rest = rest_at(place)
        self._drive[axis] = self._ahead[axis] = 0.0
        joint = self.joints[axis]
        self.device.write_axis(axis, math.floor(self.zero[axis] + joint.counts * position + 0.5))

    def put(self, time: float, point: Point) -> None:
        """Another knot behind those there are."""
        for name, values in vars(point).items():
            self._check(name, values)
        least = self._knots[-1][0] if self._knots else self.time
        if not time >= least:
            raise OSError(errno.EINVAL, f"{time} s is earlier than {least} s")
        self._knots.append((time, point))

    def _check(self, what: str, values: list[float]) -> None:
        if len(values) != self.axes or not all(map(math.isfinite, values)):
            raise OSError(errno.EINVAL, f"{what} {values}: must be {self.axes} finite numbers")

    def step(self) -> bool:
        """Waits for the next sample and writes the setpoints of the one behind it. False: the
        motion has ended."""
        number = self.device.wait()
        self.late += number - self.sample - 1
        self.sample = number
        goes_on, point = self._at(self.time)
        counts = [v * x.counts for v, x in zip(point.velocity, self.joints, strict=True)]
        if not goes_on and max(map(abs, counts)) * self.interval >= 0.5:
            raise OSError(errno.ETIME, "the motion ended at a velocity")
        self.device.write(self._setpoints(point))
        return goes_on

    def run(self) -> None:
        while self.step():
            pass

    def _rest(self) -> None:
        self.rest = rest_at(self.positions())
        self._drive, self._ahead = [0.0] * self.axes, [0.0] * self.axes  # of the last setpoints
        self._knots.clear()

    def _at(self, time: float) -> tuple[bool, Point]:
        knots = self._knots
        while len(knots) > 1 and knots[1][0] <= time:
            knots.popleft()
        if len(knots) == 1 and knots[0][0] <= time:
            self.rest = knots.popleft()[1]
        if not knots or knots[0][0] > time:
            return bool(knots), self.rest
        (t0, p), (t1, q) = knots[0], knots[1]
        return True, _between(p, q, t1 - t0, time - t0)

    def _setpoints(self, p: Point) -> list[int]:
        """Of the next sample, with feedforward: velocity, acceleration and current ask for a drive
        u; the compensator b0 u + b1 u' = a0 e + a1 e' gives it for a setpoint that is e ahead."""
        out, drive, ahead = [], self._drive, self._ahead
        for n, x in enumerate(self.joints):
            amperes = p.current[n] + x.inertia * p.acceleration[n] + x.friction * p.velocity[n]
            u, e = x.per_ampere * amperes, 0.0
            a0, a1, b0, b1 = self._law[n]
            if abs(a1) < abs(a0):
                e = (b0 * u + b1 * drive[n] - a1 * ahead[n]) / a0
            drive[n], ahead[n] = u, e
            out.append(math.floor(self.zero[n] + x.counts * p.position[n] + e + 0.5))
        return out

    # --- profiles ---

    def move(self, to: list[float], share: float = 1.0, profile: str = "trapezoid") -> None:
        """Puts a motion of all joints behind what is in the buffer: they begin and end together,
        each within this share of its limits. jerk: limited too, by the package ruckig."""
        if profile not in PROFILES:
            raise OSError(errno.EINVAL, f"profile {profile!r}: must be one of {PROFILES}")
        self._check("to", to)
        if not 0 < share < math.inf:
            raise OSError(errno.EINVAL, f"share {share}: must be above 0")
        t, start = self._knots[-1] if self._knots else (self.time, self.rest)
        ways = [abs(b - a) for a, b in zip(start.position, to, strict=True)]
        if not any(ways):
            return
        if profile == "jerk":
            return self._jerk(t, start, to, share)
        rows = [(x, way) for x, way in zip(self.joints, ways, strict=True) if way]
        speed = min(share * x.speed / way for x, way in rows)
        a = min(share * x.acceleration / way for x, way in rows)
        if profile == "quintic":
            self._put_share(t, start, to, 0, 0, 0)
            t += max(1.875 / speed, math.sqrt(5.773502691896258 / a))
            return self._put_share(t, start, to, 1, 0, 0)
        v = min(speed, math.sqrt(a))
        ramp = v / a
        flat, half = max(1 / v - ramp, 0.0), v * ramp / 2
        self._put_share(t, start, to, 0, 0, a)
        self._put_share(t + ramp, start, to, half, v, a)
        self._put_share(t + ramp, start, to, half, v, 0)
        self._put_share(t + ramp + flat, start, to, 1 - half, v, 0)
        self._put_share(t + ramp + flat, start, to, 1 - half, v, -a)
        t += 2 * ramp + flat
        self._put_share(t, start, to, 1, 0, -a)
        self._put_share(t, start, to, 1, 0, 0)

    def _put_share(self, t, start: Point, to, way: float, speed: float, rise: float) -> None:
        whole = [b - a for a, b in zip(start.position, to, strict=True)]
        self.put(t, Point(
            [a + w * way for a, w in zip(start.position, whole, strict=True)],
            [w * speed for w in whole], [w * rise for w in whole], start.current,
        ))  # fmt: skip

    def _jerk(self, t: float, start: Point, to: list[float], share: float) -> None:
        try:
            from ruckig import InputParameter, Result, Ruckig, Trajectory
        except ImportError:
            why = 'profile "jerk" needs the package ruckig: pip install "mmcs[motion]"'
            raise OSError(errno.ENOSYS, why) from None
        given, way = InputParameter(self.axes), Trajectory(self.axes)
        given.current_position, given.target_position = start.position, list(to)
        given.current_velocity, given.current_acceleration = start.velocity, start.acceleration
        given.max_velocity = [share * x.speed for x in self.joints]
        given.max_acceleration = [share * x.acceleration for x in self.joints]
        given.max_jerk = [a / JERK_S for a in given.max_acceleration]
        if Ruckig(self.axes).calculate(given, way) != Result.Working:
            raise OSError(errno.EINVAL, "ruckig finds no way: look at the limits and the goal")
        for n in range(math.ceil(way.duration / self.interval)):
            at = n * self.interval
            self.put(t + at, Point(*(list(x) for x in way.at_time(at)), start.current))
        self.put(t + way.duration, rest_at(to))

    # --- where the joints are ---

    def home(self, share: float = 0.25) -> None:
        """Finds out where all joints are: each turns its motor once and a quarter, away from the
        nearer stop, and looks for its index. From then on angles are those of the robot file."""
        for name, joint in ((j.name, j) for j in self.joints):
            if not joint.turn or not joint.pot:
                raise OSError(errno.ENODEV, f"{name} has no index or no potentiometer")
        for _ in range(3):
            self.step()  # the A/D values are those of the potentiometers now
        before, to = self.device.read(self.axes), []
        for axis, (x, state) in enumerate(zip(self.joints, before, strict=True)):
            at = (state.adcvai - x.pot_zero) * x.pot
            way = 1.25 * abs(x.turn / x.counts)
            to.append(self.rest.position[axis] + (-way if at > (x.low + x.high) / 2 else way))
            self.device.calibrate(axis)
        waits, zero = set(range(self.axes)), list(self.zero)
        self.move(to, share)
        while self.step():
            self._take_indexes(before, waits, zero)
        for axis in waits:
            self.device.end_calibration(axis)
        self.zero = zero
        self._rest()
        if waits:
            names = ", ".join(self.joints[axis].name for axis in sorted(waits))
            raise OSError(errno.ENODEV, f"no index of {names} came")

    def _take_indexes(self, before, waits: set[int], zero: list[int]) -> None:
        found = set()
        for axis, state in enumerate(self.device.read(self.axes)):
            if axis in waits and state.errcode & mcdef.MERR_ZINDEX:
                index = (state.errcode >> 16) - state.encnow  # 16 bits, near where it is
                index = (index + 0x8000) % 0x10000 - 0x8000 + state.encnow
                zero[axis] = zero_of(self.joints[axis], before[axis], index)
                found.add(axis)
        waits -= found
        if found:
            self.device.clear_error()


def zero_of(x: Joint, before, index: int) -> int:
    """The count at 0 rad, by the potentiometer, which knows the turn, and the count at the index,
    which knows the place in it."""
    rough = (before.adcvai - x.pot_zero) * x.pot * x.counts - before.encnow
    turns = math.floor((rough + x.mark + index) / x.turn + 0.5)
    return math.floor(x.mark + 0.5) - (turns * x.turn - index)
