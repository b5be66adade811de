# SPDX-License-Identifier: Apache-2.0
"""The robot file: motors, and for an arm its links. Fields are explained in sim/robots/*.toml."""

import math
import re
from typing import Annotated, Literal

from pydantic import AfterValidator, BeforeValidator, Field, create_model, model_validator

from mmcs.errors import Mistake, show, suggest
from mmcs.scenario.schema import Axes, Strict, is_number, refuse

STEP_S = 50e-6
FRICTION = ("coulomb_pos", "coulomb_neg", "stiction_pos", "stiction_neg")
CONFIDENCE = re.compile(r"[ABCD] (\S+)")


def _vector(length: int, most: float):
    def check(value):
        if not (isinstance(value, list) and len(value) == length and all(map(is_number, value))):
            raise refuse(f"must be a list of {length} numbers")
        if max(map(abs, value)) > most:
            raise refuse(f"must be numbers from -{most:g} to {most:g}")
        return [float(v) for v in value]

    return Annotated[list[float], BeforeValidator(check)]


def _gains(value):
    whole = isinstance(value, list) and len(value) in (3, 4)
    if not whole or not all(isinstance(v, int) and abs(v) < 2**31 for v in value):
        raise refuse("must be [a0, a1, b0] or [a0, a1, b0, b1], whole numbers of 32 bits")
    if value[2] == 0:
        raise refuse("b0, the third number, must not be 0")
    return value


Gains = Annotated[list[int], BeforeValidator(_gains)]


# Bounds far beyond any machine: a slip of the exponent is told before the physics overflows.
def _positive(most: float):
    return Annotated[float, Field(ge=1e-12, le=most)]


def _from_0(most: float):
    return Annotated[float, Field(ge=0, le=most)]


def _within(most: float):
    return Annotated[float, Field(ge=-most, le=most)]


Inertia = _positive(1e6)  # kg m^2
Torque = _from_0(1e6)  # N m
Delay = _from_0(100.0)  # s
Angle = _within(1e6)  # rad


class RobotServo(Strict):
    """Suggestions for the driver, in its own units."""

    ilim: int = Field(1024, ge=0, le=2047)
    ic_pos: int = Field(0, ge=-2047, le=2047)
    ic_neg: int = Field(0, ge=-2047, le=2047)
    pd_1000us: Gains | None = None
    pd_2000us: Gains | None = None


class Motor(Strict):
    """One axis: amplifier, motor, gear, encoder, potentiometer, brake."""

    name: str = ""
    copies: int = Field(1, ge=1, le=32)
    rotor_inertia: Inertia  # as inertia, where it is left out
    inertia: Inertia
    viscous: _from_0(1e6) = 0.0
    friction: Torque = 0.0  # stands for the next four
    coulomb_pos: Torque = 0.0
    coulomb_neg: Torque = 0.0  # as the other direction
    stiction_pos: Torque = 0.0  # as the Coulomb friction
    stiction_neg: Torque = 0.0
    km: _positive(1e4)
    resistance: _positive(1e6) = 1.0  # which only a limited supply asks for
    v_supply: _from_0(1e5) = 0.0
    amp_gain: _within(1e4)
    amp_max: _from_0(1e5) = 0.0
    amp_tau: Delay = 0.0
    gear: float = Field(1.0, ge=-1e6, le=1e6)
    stop_lo: Angle = 0.0
    stop_hi: Angle = 0.0
    pot_v_per_rad: _within(1e6) = 0.0
    pot_offset: _within(1e4) = 0.0
    angle0: Angle = 0.0
    gravity: _within(1e6) = 0.0
    brake_torque: Torque = 0.0
    brake_delay: Delay = 0.0
    brake_release_delay: Delay = 0.0
    stiffness: _from_0(1e12) = 0.0
    damping: _from_0(1e12) = 0.0
    backlash: _from_0(1e3) = 0.0
    load_inertia: _from_0(1e6) = 0.0
    counts_per_rev: int = Field(ge=4, le=10_000_000, multiple_of=4)
    index_per_rev: int = Field(1, ge=0, le=1)
    encoder_offset: Angle = 0.0
    servo: RobotServo = RobotServo()
    source: dict[str, str] = {}

    @model_validator(mode="before")
    @classmethod
    def _likewise(cls, data):
        """What is left out and follows from another value."""
        if not isinstance(data, dict):
            return data
        data = dict(data)
        if "friction" in data:
            data = dict.fromkeys(FRICTION, data["friction"]) | data
        for key, other in (
            ("rotor_inertia", "inertia"),
            ("coulomb_neg", "coulomb_pos"),
            ("stiction_pos", "coulomb_pos"),
            ("stiction_neg", "coulomb_neg"),
        ):
            if key not in data and other in data:
                data[key] = data[other]
        return data


def with_values(data: dict, entries: list[dict]) -> dict:
    """The robot file's data with values replaced. An entry has "axis" (numbers, or "all") and
    keys of Motor. A new `friction` replaces all four values that the file may have.
    """
    motors = []
    for motor in data["axis"]:
        count, name = motor.get("copies", 1), motor.get("name", "")
        for n in range(count):
            motors.append(motor | {"copies": 1, "name": f"{name}{n + 1}" if count > 1 else name})
    for entry in entries:
        values = {key: value for key, value in entry.items() if key != "axis"}
        if "friction" in entry:
            values = dict.fromkeys(FRICTION, entry["friction"]) | values
        axes = range(len(motors)) if entry["axis"] == "all" else entry["axis"]
        for axis in axes:
            motors[axis] |= values
    return data | {"axis": motors}


def _expand(motors: list[Motor]) -> list[Motor]:
    """An axis with `copies` stands for so many equal ones."""
    if sum(motor.copies for motor in motors) > 32:
        raise refuse("must make at most 32 axes, copies included")
    out = []
    for motor in motors:
        many = motor.copies > 1
        for n in range(motor.copies):
            name = f"{motor.name}{n + 1}" if many else motor.name
            out.append(motor.model_copy(update={"copies": 1, "name": name}))
    return out


def _some_of_motor(name: str, *without: str, **more):
    """Keys of Motor, none of which must be there."""
    keys = {
        key: (field.rebuild_annotation() | None, None)
        for key, field in Motor.model_fields.items()
        if key not in ("name", "copies", *without)
    }
    return create_model(name, __base__=Strict, **more, **keys)


ANY_AXES = Field("all", description="an axis number, a list of them or 'all'")
# A [[motor]] of a scenario: values in place of the robot file's.
MotorValues = _some_of_motor("MotorValues", "servo", "source", axis=(Axes, ANY_AXES))
EveryAxis = _some_of_motor("EveryAxis")


class Link(Strict):
    """One link of a serial arm, standard Denavit-Hartenberg."""

    alpha: Angle = 0.0
    a: _within(1e3) = 0.0
    d: _within(1e3) = 0.0
    theta0: Angle = 0.0
    mass: _from_0(1e6) = 0.0
    com: _vector(3, 1e3) = [0.0, 0.0, 0.0]
    inertia: _vector(6, 1e6)
    source: str = ""


def _merged(data, over):
    """Tables in tables, too."""
    if not (isinstance(data, dict) and isinstance(over, dict)):
        return over
    return data | {key: _merged(data.get(key), value) for key, value in over.items()}


class Robot(Strict):
    """The whole file."""

    format: Literal[1] = 1
    title: str = Field(min_length=1, description="one line in quotes")
    gravity: _vector(3, 1e3) = [0.0, 0.0, 0.0]
    reference: dict[str, str] = {}
    every_axis: EveryAxis = EveryAxis()
    axis: Annotated[list[Motor], AfterValidator(_expand)] = Field(
        min_length=1, max_length=32, description="one [[axis]] per motor"
    )
    link: list[Link] = []

    @model_validator(mode="before")
    @classmethod
    def _shared(cls, data):
        """What every_axis says is said of each axis that does not say otherwise."""
        every = data.get("every_axis") if isinstance(data, dict) else None
        if not isinstance(every, dict) or not isinstance(data.get("axis"), list):
            return data
        return data | {"axis": [_merged(every, motor) for motor in data["axis"]]}

    def axes(self) -> int:
        return len(self.axis)

    def axis_name(self, axis: int) -> str:
        return self.axis[axis].name

    def counts_per_rad(self, axis: int) -> float:
        """Encoder counts per radian of the joint, signed as the gear."""
        motor = self.axis[axis]
        return motor.counts_per_rev * motor.gear / (2 * math.pi)

    def counts_per(self, unit: str, axis: int) -> float:
        if unit == "counts":
            return 1.0
        per_rad = self.counts_per_rad(axis)
        return per_rad if unit == "rad" else per_rad * math.pi / 180

    def fastest(self) -> int:
        """Counts/s that no axis exceeds: half more than its motor does without load; 0: unknown."""
        if not all(motor.v_supply > 0 for motor in self.axis):
            return 0
        turns = [m.v_supply / m.km / math.tau * m.counts_per_rev for m in self.axis]
        return min(math.ceil(1.5 * max(turns, default=0)), 1 << 30)

    def motors(self, coupled: bool) -> list[dict]:
        """The fields of mmcs_motor per axis.

        In an arm the links carry the load's inertia, beyond a flexible coupling `load_inertia`
        does: then the motor's own is the rotor's.
        """
        out = []
        for motor in self.axis:
            fields = motor.model_dump(
                exclude={"name", "copies", "rotor_inertia", "friction", "servo", "source"}
            )
            if coupled or motor.stiffness > 0:
                fields["inertia"] = motor.rotor_inertia
            out.append(fields)
        return out

    def links(self) -> list[dict]:
        """The fields of mmcs_link."""
        return [link.model_dump(exclude={"source"}) for link in self.link]

    def servo(self, axis: int, interval_us: int) -> dict:
        """Servo parameters that suit the axis: PD position control with Coulomb compensation.

        Gains are given for 1 ms and 2 ms; other intervals take the nearer one of the two.
        """
        servo = self.axis[axis].servo
        gains = servo.pd_2000us if interval_us > 1500 else servo.pd_1000us
        gains = gains or servo.pd_1000us or servo.pd_2000us
        values = {"mode": "position", "flags": ["coulcomp"], "ilim": servo.ilim}
        values |= {"ic_pos": servo.ic_pos, "ic_neg": servo.ic_neg}
        return values | dict(zip(("a0", "a1", "b0", "b1"), gains or (), strict=False))

    def mistakes(self, file: str) -> list[Mistake]:
        """What no single field shows."""
        found = []

        def wrong(key: str, value: object, allowed: str) -> None:
            found.append(Mistake(file, key, show(value), allowed))

        for n, motor in enumerate(self.axis):
            key = f"axis.{n}"
            if motor.gear == 0:
                wrong(f"{key}.gear", motor.gear, "must not be 0; 1 for a motor without gear")
            if motor.amp_gain == 0:
                wrong(f"{key}.amp_gain", motor.amp_gain, "must not be 0: the motor would be dead")
            if motor.rotor_inertia > motor.inertia:
                allowed = f"must be at most inertia ({motor.inertia:g}), which includes it"
                wrong(f"{key}.rotor_inertia", motor.rotor_inertia, allowed)
            for side in ("pos", "neg"):
                stiction = getattr(motor, f"stiction_{side}")
                coulomb = getattr(motor, f"coulomb_{side}")
                if stiction < coulomb:
                    allowed = f"must be at least coulomb_{side} ({coulomb:g})"
                    wrong(f"{key}.stiction_{side}", stiction, allowed)
            if motor.stop_lo > motor.stop_hi:
                allowed = f"must be at most stop_hi ({motor.stop_hi:g}); equal for no stops"
                wrong(f"{key}.stop_lo", motor.stop_lo, allowed)
            elif motor.stop_lo < motor.stop_hi and not (
                motor.stop_lo <= motor.angle0 <= motor.stop_hi
            ):
                allowed = f"must lie between the stops ({motor.stop_lo:g} to {motor.stop_hi:g})"
                wrong(f"{key}.angle0", motor.angle0, allowed)
            if motor.backlash > 0 and motor.stiffness == 0:
                wrong(f"{key}.backlash", motor.backlash, "needs a stiffness above 0")
            if motor.stiffness > 0 and not self.link and motor.load_inertia == 0:
                allowed = "must be more than 0: what hangs on the flexible coupling"
                wrong(f"{key}.load_inertia", motor.load_inertia, allowed)
            if not self.link:
                self._check_coupling(key, motor, wrong)
            self._check_winding(key, motor, wrong)
            for name, text in motor.source.items():
                self._check_source(f"{key}.source.{name}", text, wrong)
        for n, link in enumerate(self.link):
            if link.source:
                self._check_source(f"link.{n}.source", link.source, wrong)
        if self.link and len(self.link) != len(self.axis):
            allowed = f"an arm needs one [[link]] per [[axis]] ({len(self.axis)})"
            wrong("link", f"{len(self.link)} links", allowed)
        elif self.link and not found:
            self._check_arm(wrong)
        return found

    def _check_coupling(self, key: str, motor: Motor, wrong) -> None:
        """The physics takes 50 us steps; a coupling that swings faster would blow up."""
        own, load = motor.rotor_inertia * motor.gear**2, motor.load_inertia
        if motor.stiffness == 0 or load == 0 or own == 0:
            return
        softness = 1 / load + 1 / own
        most = 0.25 / (softness * STEP_S**2)
        if motor.stiffness > most:
            allowed = f"must be at most {most:.3g}, or 0 for rigid: steps are 50 us"
            wrong(f"{key}.stiffness", motor.stiffness, allowed)
        most = 0.5 / (softness * STEP_S)
        if motor.damping > most:
            wrong(f"{key}.damping", motor.damping, f"must be at most {most:.3g}: steps are 50 us")

    def _check_arm(self, wrong) -> None:
        from mmcs.scenario.arm import is_body, stiff_joints

        for n, link in enumerate(self.link):
            if not is_body(link.inertia):
                allowed = "is the inertia of no body: it must be positive definite"
                wrong(f"link.{n}.inertia", link.inertia, allowed)
                return
        for key, most in stiff_joints(self):
            _, axis, name = key.split(".")
            allowed = f"must be at most {most:.3g} with its load: steps are 50 us"
            if most == 0:
                allowed = "must be 0: in some pose the joint moves no mass"
            wrong(key, getattr(self.axis[int(axis)], name), allowed)

    def _check_winding(self, key: str, motor: Motor, wrong) -> None:
        """Back-EMF over the winding brakes with km^2/resistance; within one step it would ring."""
        name = "rotor_inertia" if self.link or motor.stiffness > 0 else "inertia"
        least = motor.km**2 / motor.resistance * STEP_S - motor.viscous * STEP_S
        if motor.v_supply > 0 and getattr(motor, name) < least:
            allowed = f"must be at least {least:.3g}, by km and resistance: steps are 50 us"
            wrong(f"{key}.{name}", getattr(motor, name), allowed)

    def _check_source(self, key: str, text: str, wrong) -> None:
        match = CONFIDENCE.fullmatch(text)
        if not match:
            wrong(key, text, "must be a confidence A, B, C or D, a space, and a reference")
        elif match[1] not in self.reference:
            hint = suggest(match[1], self.reference)
            wrong(key, text, f'[reference] has no "{match[1]}"{hint}')
