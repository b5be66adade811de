# SPDX-License-Identifier: Apache-2.0
# Length: every check that needs scenario and robot together stands beside the value it checks.
"""A scenario and its robot put together: what the engine and the driver are given.

Also finds the mistakes that no single file shows: an axis that the robot lacks, a motion that
starts after the end, segments that overlap.
"""

import math
import shlex
import shutil
from dataclasses import dataclass, field
from pathlib import Path

from mmcs import mcdef
from mmcs.errors import InputError, Mistake, show, suggest
from mmcs.files import MAX_TABLE, is_name
from mmcs.inputs import INPUTS, find
from mmcs.scenario.files import MAX_FILES, Files, find_robot
from mmcs.scenario.robot import Robot, with_values
from mmcs.scenario.scenario import Chirp, Glide, Scenario, Servo, Step, Table, Trapezoid, Wave
from mmcs.scenario.schema import validate

_INITIAL = {name: mcdef.initial().get(name, 0) for name in Servo.model_fields if name != "axis"}
SERVO_DEFAULTS = _INITIAL | {"mode": "off", "flags": []}

MOST_SERVO_US = 50_000  # as the driver has it


@dataclass
class Setup:
    name: str
    path: Path
    scenario: Scenario
    robot: Robot
    params: list[dict]  # servo parameters per axis, complete
    segments: list[dict]  # fields of mmcs_segment, in order of time per axis
    data: dict  # the scenario as it is in force, overrides applied
    files: dict[str, str]  # the robot's and the tables' texts, as "robot.toml", "table0.csv", ...
    binary: bytes = field(init=False, default=b"")  # the set-up file that it was loaded from,
    host: str = field(init=False, default="native")  # and which host that is for
    compiled: dict[tuple, bytes] = field(init=False, default_factory=dict)  # see compiled.py

    @property
    def axes(self) -> int:
        return len(self.params)

    def config(self) -> dict:
        """The fields of mmcs_config."""
        scenario, host = self.scenario, self.scenario.host
        return {
            "cards": scenario.cards,
            "axes": self.axes,
            "links": len(self.links()),
            "seed": scenario.seed,
            "gravity": self.robot.gravity if scenario.gravity else [0.0, 0.0, 0.0],
            **host.model_dump(include={"cpu_us_per_axis", "latency_max_us", "bus_timeout_us"}),
            "wait_states": host.wait_states,
            "instruction_cache": 256 if host.instruction_cache == "256 bytes" else 0,
            "axis_speed": self.robot.fastest(),
            "skip": int(scenario.skip),
            "amp_panic_cut": int(scenario.amp_panic_cut),
        }

    def driver(self) -> dict:  # the fields of mmcs_driver
        keys = ("verbose", "interval_us", "double_buffer")
        return {"axes": self.axes} | {key: int(getattr(self.scenario, key)) for key in keys}

    def refusals(self) -> list[str]:
        """The requests of the start whose refusal the scenario expects."""
        return [entry.request for entry in self.scenario.expect if entry.kind == "refused"]

    def moment(self) -> float:
        """When there is something to see, s of motion: the first event, or the first setpoint."""
        events = [event.at for event in self.scenario.event if not event.at_power_on]
        return min(events or [segment["t0"] for segment in self.segments], default=0.0)

    def motors(self) -> list[dict]:
        """The fields of mmcs_motor per axis."""
        motors = self.robot.motors(coupled=self.scenario.dynamics == "coupled")
        for motor, degrees in zip(motors, self.scenario.pose_deg, strict=False):
            motor["angle0"] = math.radians(degrees)
        return motors

    def links(self) -> list[dict]:
        """The fields of mmcs_link per axis; none when the axes stand alone."""
        return self.robot.links() if self.scenario.dynamics == "coupled" else []

    def about(self) -> dict:
        """What the messages tell of the machine: numbers of the robot file in SI units, and the
        driver's parameters, mode as a word, that the scenario suggests at interval_us."""
        servo = [
            {name: value for name, value in param.items() if name != "flags"}
            | {"mode": mcdef.mode_word(param["mode"], param["flags"])}
            for param in self.params
        ]
        return {
            "title": self.robot.title,
            "gravity": self.config()["gravity"],
            "motors": self.motors(),
            "links": self.robot.links(),
            "interval_us": self.scenario.interval_us,
            "heartbeat_us": self.scenario.heartbeat_us,
            "servo": servo,
        }


def make_setup(path: Path, data: dict, files: Files | None = None) -> Setup:
    """Raises InputError with every mistake of both files.

    files: those already read, for those who make many setups at once.
    """
    if not is_name(path.stem):
        raise InputError.one(path, "", None, "is no name for results; rename the file")
    files = files or Files()
    scenario, mistakes = validate(Scenario, data, str(path))
    robot = None
    name = data.get("robot")
    if isinstance(name, str) and name:
        try:
            robot_path = find_robot(name, path)
            robot, wrong = check_robot(files.toml(robot_path), str(robot_path))
            mistakes += wrong
        except InputError as error:
            where = error.mistakes[0]
            if where.file in (f'"{name}"', str(path.parent / name)):
                where = Mistake(str(path), "robot", show(name), where.allowed)
            mistakes.append(where)
    if mistakes:
        raise InputError(*mistakes)
    cross = _Cross(path, scenario, robot, files)
    if scenario.motor and not (mistakes := cross.motors()):
        entries = [entry.model_dump(exclude_none=True) for entry in scenario.motor]
        data_of_robot = with_values(files.toml(robot_path), entries)
        robot, mistakes = check_robot(data_of_robot, f"{path}: [[motor]]")
        cross.robot = robot
    if mistakes:
        raise InputError(*mistakes)
    params, segments = cross.params(), cross.segments()
    cross.check_rest()
    if cross.mistakes:
        raise InputError(*cross.mistakes)
    texts = {"robot.toml": files.text(robot_path)} | cross.tables
    if sum(map(len, texts.values())) > MAX_FILES:
        allowed = f"its tables are together larger than {MAX_FILES >> 20} MB"
        raise InputError.one(path, "motion", None, allowed)
    return Setup(path.stem, path, scenario, robot, params, segments, data, texts)


def check_robot(data: dict, file: str) -> tuple[Robot | None, list[Mistake]]:
    robot, mistakes = validate(Robot, data, file)
    return robot, mistakes or robot.mistakes(file)


class _Cross:
    """The checks that need scenario and robot together; collects mistakes as it goes."""

    def __init__(self, path: Path, scenario: Scenario, robot: Robot, files: Files):
        self.path, self.scenario, self.robot, self.files = path, scenario, robot, files
        self.tables: dict[str, str] = {}  # and cards: texts, by the names that a record gives them
        self.axes = robot.axes()
        self.mistakes: list[Mistake] = []

    def wrong(self, key: str, value: object, allowed: str) -> None:
        text = None if value is None else show(value)
        self.mistakes.append(Mistake(str(self.path), key, text, allowed))

    def _must_begin(self, key: str, at: float) -> None:
        if at >= (end := self.scenario.duration):
            self.wrong(key, at, f"must be before the end of the run ({end:g} s)")

    def chosen(self, key: str, axes) -> list[int]:
        if axes == "all":
            return list(range(self.axes))
        for axis in axes:
            if axis >= self.axes:
                self.wrong(
                    f"{key}.axis",
                    axis,
                    f'robot "{self.scenario.robot}" has axes 0 to {self.axes - 1}',
                )
        return [axis for axis in axes if axis < self.axes]

    def motors(self) -> list[Mistake]:
        """Mistakes of the axis numbers in [[motor]]."""
        for n, entry in enumerate(self.scenario.motor):
            self.chosen(f"motor.{n}", entry.axis)
        return self.mistakes

    def params(self) -> list[dict]:
        interval = self.scenario.interval_us
        params = [{**SERVO_DEFAULTS, **self.robot.servo(n, interval)} for n in range(self.axes)]
        for n, entry in enumerate(self.scenario.servo):
            key = f"servo.{n}"
            given = entry.model_dump(exclude_none=True, exclude={"axis"})
            for axis in self.chosen(key, entry.axis):
                params[axis].update(given)
            if given.get("b0") == 0:
                self.wrong(f"{key}.b0", 0, "must not be 0: it divides the compensator's output")
        for axis, values in enumerate(params):
            if values["plo"] > values["phi"]:
                self.wrong(f"axis {axis}: plo", values["plo"], f"must be <= phi ({values['phi']})")
            divisor = values["clkdivisor"]
            if divisor > 1 and divisor * interval > MOST_SERVO_US:
                most = f"must be at most {max(1, MOST_SERVO_US // interval)} at this interval_us"
                self.wrong(
                    f"axis {axis}: clkdivisor", divisor, f"{most}: servo at least every 50 ms"
                )
        return params

    def segments(self) -> list[dict]:
        segments: list[dict] = []
        for n, motion in enumerate(self.scenario.motion):
            key = f"motion.{n}"
            self._must_begin(f"{key}.at", motion.at)
            chosen = self.chosen(key, motion.axis)
            for place, axis in enumerate(chosen):
                segments.append(self._segment(key, motion, axis, place, len(chosen)))
        self._overlaps(segments)
        segments.sort(key=lambda s: (s["axis"], s["t0"]))
        self._follow_shares(segments)
        return segments

    @staticmethod
    def _follow_shares(segments: list[dict]) -> None:
        """A table of shares leads from the end of the segment before it to its own `to`."""
        ends: dict[int, float] = {}
        for segment in segments:
            table = segment.get("table")
            if table and "to" in segment:
                start = ends.get(segment["axis"], 0.0)
                table = [start + (segment["to"] - start) * share for share in table]
                segment["table"] = table
            ends[segment["axis"]] = table[-1] if table else segment["to"]

    def _segment(self, key: str, motion, axis: int, place: int, count: int) -> dict:
        scale = self.robot.counts_per(motion.unit, axis)
        segment = {"axis": axis, "kind": motion.kind, "t0": motion.at, "duration": 0.0}
        if isinstance(motion, Step | Glide | Trapezoid):
            segment["to"] = scale * self._pick(f"{key}.to", motion.to, place, count)
        if isinstance(motion, Wave | Chirp):
            segment["to"] = scale * self._pick(f"{key}.mean", motion.mean, place, count)
            segment["amplitude"] = scale * motion.amplitude
        if not isinstance(motion, Step):
            segment["duration"] = motion.duration
        if isinstance(motion, Trapezoid):
            segment |= {"v_max": abs(scale) * motion.v_max, "a_max": abs(scale) * motion.a_max}
        if isinstance(motion, Wave):
            segment |= {"f0": motion.hz, "f1": motion.hz}
        if isinstance(motion, Chirp):
            segment |= {"f0": motion.hz_from, "f1": motion.hz_to}
        if isinstance(motion, Table):
            if motion.to is not None:
                segment["to"] = scale * self._pick(f"{key}.to", motion.to, place, count)
                scale = 1.0
            segment["table"] = [scale * v for v in self._table(key, motion, scale)]
        peak = abs(segment.get("to", 0.0)) + abs(segment.get("amplitude", 0.0))
        if not math.isfinite(peak) or peak >= 2**31:
            self.wrong(f"{key}.to", None, "leaves the 32-bit range of setpoints")
        return segment

    def _pick(self, key: str, value, place: int, count: int) -> float:
        if not isinstance(value, list):
            return value
        if len(value) != count:
            if place == 0:
                what = "bands" if isinstance(value[0], list) else "numbers"
                self.wrong(key, value, f"must have {count} {what}, one per axis named")
            return 0.0
        return value[place]

    def _table(self, key: str, motion: Table, scale: float) -> list[float]:
        import csv

        def wrong(key_: str, value: str, allowed: str) -> list[float]:
            self.wrong(f"{key}.{key_}", value, allowed)
            return [0.0]

        try:
            text = self.files.text(self.path.parent / motion.file, MAX_TABLE)
        except ValueError as error:
            return wrong("file", motion.file, str(error))
        self.tables[f"table{key.rpartition('.')[2]}.csv"] = text
        try:
            reader = csv.reader(text.removeprefix("\ufeff").splitlines(keepends=True))
            rows = [(reader.line_num, row) for row in reader if row]
        except csv.Error:
            return wrong("file", motion.file, "is not a CSV text")
        column = 0
        if motion.column is not None:
            names = [name.strip() for name in rows[0][1]] if rows else []
            if motion.column not in names:
                hint = suggest(motion.column, names) or "; there are: " + ", ".join(names)
                return wrong("column", motion.column, f"no such column{hint}")
            column, rows = names.index(motion.column), rows[1:]
        values = []
        for line, row in rows:
            try:
                values.append(float(row[column]))
            except (ValueError, IndexError):
                allowed = f"line {line} has no number in that column"
                if motion.column is None and not values:
                    allowed += '; of a table with headings, name a "column"'
                return wrong("file", motion.file, allowed)
            if not abs(scale * values[-1]) < 2**31:  # NaN is not
                allowed = f"line {line} leaves the 32-bit range of setpoints"
                return wrong("file", motion.file, allowed)
        if len(values) < 2:
            return wrong("file", motion.file, "must hold at least two numbers")
        return values

    def _check_input(self, key: str, event) -> None:
        known = find(event.input)
        if known is None:
            names = suggest(event.input, INPUTS) or "; allowed: " + ", ".join(INPUTS)
            self.wrong(f"{key}.input", event.input, "no such input" + names)
            return
        count = {"machine": 1, "card": self.scenario.cards, "axis": self.axes}[known.scope]
        if event.index >= count:
            allowed = f"must be 0 to {count - 1}, the {known.scope} that {event.input} is about"
            self.wrong(f"{key}.index", event.index, allowed if count > 1 else "must be 0")
        if not known.low <= event.value <= known.high:
            allowed = f"must be {known.low:g} to {known.high:g} ({known.meaning})"
            self.wrong(f"{key}.value", event.value, allowed)

    def _overlaps(self, segments: list[dict]) -> None:
        for axis in range(self.axes):
            own = sorted((s for s in segments if s["axis"] == axis), key=lambda s: s["t0"])
            for a, b in zip(own, own[1:], strict=False):
                end = a["t0"] + a["duration"]
                if b["t0"] < end - 1e-9:
                    self.wrong(
                        "motion", None,
                        f"axis {axis}: the {b['kind']} at {b['t0']:g} s begins before the "
                        f"{a['kind']} at {a['t0']:g} s ends ({end:g} s)",
                    )  # fmt: skip

    def _check_pose(self) -> None:
        pose = self.scenario.pose_deg
        if pose and len(pose) != self.axes:
            self.wrong("pose_deg", pose, f"must have {self.axes} angles, one per axis")
            return
        for axis, degrees in enumerate(pose):
            motor = self.robot.axis[axis]
            low, high = math.degrees(motor.stop_lo), math.degrees(motor.stop_hi)
            if low < high and not low <= degrees <= high:
                allowed = f"must lie between the stops ({low:.4g} to {high:.4g})"
                self.wrong(f"pose_deg.{axis}", degrees, allowed)

    def _check_process(self) -> None:
        scenario = self.scenario
        if scenario.process and scenario.motion:
            self.wrong("process", None, "writes setpoints itself: not together with [[motion]]")
        for n, process in enumerate(scenario.process):
            chosen = self.chosen(f"process.{n}", process.axis)
            self._must_begin(f"process.{n}.at", process.at)
            for place in range(len(chosen)):
                self._pick(f"process.{n}.to", process.to, place, len(chosen))

    def _check_program(self) -> None:
        scenario = self.scenario
        for n, program in enumerate(scenario.program):
            allowed = "must name a program that can be executed"
            try:
                word = (*shlex.split(program.run), "")[0]
            except ValueError as error:
                word, allowed = "", f"{error}"
            if not any(map(shutil.which, (word, str(self.path.parent / word)))):
                self.wrong(f"program.{n}.run", program.run, allowed)
        for key in ("motion", "call", "process", "servo"):
            if scenario.program and getattr(scenario, key):
                self.wrong("program", None, f"does that itself: not together with [[{key}]]")

    def _read_cards(self) -> None:
        for n, card in enumerate(self.scenario.card):
            try:
                self.tables[f"card{n}.sv"] = self.files.text(self.path.parent / card.file)
            except ValueError as error:
                self.wrong(f"card.{n}.file", card.file, str(error))

    def check_rest(self) -> None:
        scenario = self.scenario
        if scenario.dynamics == "coupled" and not self.robot.link:
            self.wrong("dynamics", "coupled", f'robot "{scenario.robot}" has no [[link]]')
        elif scenario.dynamics == "independent":
            for n, motor in enumerate(self.robot.axis):
                if motor.stiffness > 0 and motor.load_inertia == 0:
                    allowed = f'axis {n} is flexible and has no load_inertia: only "coupled"'
                    self.wrong("dynamics", "independent", allowed)
        if self.axes > 2 * scenario.cards:
            need = (self.axes + 1) // 2
            self.wrong("cards", scenario.cards, f"{self.axes} axes need at least {need} cards")
        self._check_pose()
        self._check_process()
        self._check_program()
        self._read_cards()
        for n, call in enumerate(scenario.call):
            self.chosen(f"call.{n}", call.axis)
            if (call.request == "MSETPARAM") != (call.set is not None):
                allowed = "MSETPARAM, and no other request, takes set = { ... }"
                self.wrong(f"call.{n}.set", None, allowed)
            self._must_begin(f"call.{n}.at", call.at)
        for n, event in enumerate(scenario.event):
            self._check_input(f"event.{n}", event)
            if event.until is not None and event.until <= event.at:
                self.wrong(f"event.{n}.until", event.until, f"must be after at ({event.at:g})")
        for n, entry in enumerate(scenario.expect):
            if hasattr(entry, "axis") and isinstance(entry.axis, list | str):
                self.chosen(f"expect.{n}", entry.axis)
            elif isinstance(getattr(entry, "axis", None), int):
                self.chosen(f"expect.{n}", [entry.axis])
            self._must_begin(f"expect.{n}.after", getattr(entry, "after", -1.0))
            for key, band in entry:
                if isinstance(band, list) and isinstance(band[0], list):
                    count = self.axes if entry.axis == "all" else len(entry.axis)
                    self._pick(f"expect.{n}.{key}", band, 0, count)
            where = {"kind", "axis", "signal", "after", "until"}
            if entry.kind != "event" and not entry.model_dump(exclude_none=True, exclude=where):
                names = [k for k in type(entry).model_fields if k not in where]
                self.wrong(f"expect.{n}", None, "expects nothing; add one of: " + ", ".join(names))
