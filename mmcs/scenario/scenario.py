# SPDX-License-Identifier: Apache-2.0
"""The scenario file: what is simulated, what happens, and what is expected of it."""

from typing import Annotated, Literal

from pydantic import Field

from mmcs import mcdef
from mmcs.files import LONGEST_S
from mmcs.scenario.robot import MotorValues
from mmcs.scenario.schema import Axes, Count, Limit, NumberOrList, Pair, Strict

INT_MIN, INT_MAX = -(2**31), 2**31 - 1
Int32 = Annotated[int, Field(ge=INT_MIN, le=INT_MAX)]
Seconds = Annotated[float, Field(ge=0, le=LONGEST_S)]
Duration = Annotated[float, Field(gt=0, le=LONGEST_S)]
Degrees = Annotated[float, Field(ge=-36_000, le=36_000)]
Mode = Literal[*mcdef.MODES]
Flag = Literal[*mcdef.FLAGS]


class Host(Strict):
    """The computer that runs the servo."""

    cpu_us_per_axis: float = Field(430 / 6, ge=0, le=10_000)  # a Sun 3/160: 430 us for six
    latency_max_us: float = Field(100.0, ge=0, le=100_000)
    bus_timeout_us: float = Field(16.0, ge=2, le=1000)
    # --host m68020 only
    wait_states: int = Field(0, ge=0, le=100)
    instruction_cache: Literal["ideal", "256 bytes"] = "ideal"


class Servo(Strict):
    """Servo parameters; what is left out comes from the robot file."""

    axis: Axes = Field("all", description="an axis number, a list of them or 'all'")
    mode: Mode | None = None
    flags: list[Flag] | None = None
    a0: Int32 | None = None
    a1: Int32 | None = None
    a2: Int32 | None = None
    b0: Int32 | None = None
    b1: Int32 | None = None
    b2: Int32 | None = None
    ic_pos: Int32 | None = None
    ic_neg: Int32 | None = None
    clkdivisor: Annotated[int, Field(ge=1, le=INT_MAX)] | None = None
    ilim: Annotated[int, Field(ge=0, le=INT_MAX)] | None = None
    ilimax: Annotated[int, Field(ge=0, le=INT_MAX)] | None = None
    plo: Int32 | None = None
    phi: Int32 | None = None
    adc_a: Int32 | None = None
    adc_b: Int32 | None = None
    ipole: Annotated[int, Field(ge=0, le=1023)] | None = None


class _Segment(Strict):
    axis: Axes = Field(description="an axis number, a list of them or 'all'")
    at: Seconds = Field(description="seconds after the start of motion")
    unit: Literal["counts", "deg", "rad"] = "counts"


class Step(_Segment):
    kind: Literal["step"]
    to: NumberOrList = Field(description="the new setpoint")


class Glide(_Segment):
    kind: Literal["ramp", "quintic"]
    to: NumberOrList = Field(description="the final setpoint")
    duration: Duration = Field(description="seconds")


class Trapezoid(_Segment):
    kind: Literal["trapezoid"]
    to: NumberOrList = Field(description="the final setpoint")
    duration: Duration = Field(description="seconds")
    v_max: float = Field(0.0, ge=0)
    a_max: float = Field(0.0, ge=0)


class Wave(_Segment):
    kind: Literal["sine", "square"]
    mean: NumberOrList = 0.0
    amplitude: float = Field(ge=0, description="units of the setpoint")
    hz: float = Field(gt=0, le=1000, description="Hz")
    duration: Duration = Field(description="seconds")


class Chirp(_Segment):
    kind: Literal["chirp"]
    mean: NumberOrList = 0.0
    amplitude: float = Field(ge=0, description="units of the setpoint")
    hz_from: float = Field(gt=0, le=1000, description="Hz")
    hz_to: float = Field(gt=0, le=1000, description="Hz")
    duration: Duration = Field(description="seconds")


class Table(_Segment):
    kind: Literal["table"]
    file: str = Field(min_length=1, description="a CSV file beside the scenario")
    column: str | None = None
    duration: Duration = Field(description="seconds")
    to: NumberOrList | None = None  # then the column is the share of the way there, 0 to 1


Motion = Annotated[Step | Glide | Trapezoid | Wave | Chirp | Table, Field(discriminator="kind")]


class Event(Strict):
    """A named input of the machine or the plant takes a value."""

    at: Seconds = Field(description="seconds after the start of motion")
    input: str = Field(min_length=1, description="the name of an input, see docs/use/scenarios.md")
    index: int = Field(0, ge=0, le=31)  # the axis or card it applies to
    value: float = Field(description="the new value of the input")
    until: Seconds | None = None  # then the input is healthy again
    at_power_on: bool = False  # it is so before the driver is opened; `at` counts from power-on


Request = Literal[*sorted(r.name for r in mcdef.requests().values() if r.called)]


class Call(Strict):
    """What the user's program asks of the driver during the motion."""

    at: Seconds = Field(description="seconds after the start of motion")
    request: Request
    axis: Axes = "all"  # of MCALIB, MSETENC and MSETPARAM
    value: Int32 = 0  # of MDACMODE, MSETENC, MSETINTERVAL
    set: Servo | None = None  # of MSETPARAM: what changes


class Loop(Strict):
    """A user's process closes the loop itself: state in, current out (MD_TORQ), §1.3.1."""

    kind: Literal["pd"]
    axis: Axes = Field(description="an axis number, a list of them or 'all'")
    at: Seconds = Field(description="seconds after the start of motion: the step")
    to: NumberOrList = Field(description="where to, counts")
    p: float  # D/A units per count
    d: float = 0.0  # D/A units per count and sample
    period_us: float = Field(1000.0, ge=100, le=1_000_000)
    jitter_us: float = Field(0.0, ge=0, le=1_000_000)  # it wakes up late by 0 to this, by seed


class Bounce(Strict):
    """A user's process that turns round wherever a position limit signals, Fig. 2.2 to 2.4."""

    kind: Literal["bounce"]
    axis: Axes = Field(description="an axis number, a list of them or 'all'")
    at: Seconds = Field(description="seconds after the start of motion")
    to: NumberOrList = Field(description="the speed, counts per sample")


Process = Annotated[Loop | Bounce, Field(discriminator="kind")]


class Program(Strict):
    """A program of one's own, run in lock-step; it configures the driver itself."""

    run: str = Field(min_length=1, max_length=4096, description="a command, words as in a shell")
    digest: str = ""  # of the files it names, when a record was made


class Card(Strict):
    """A card of one's own on the PC-bus expansion; of several files, those that others instantiate
    are parts of cards."""

    file: str = Field(min_length=1, description="a SystemVerilog file beside the scenario")
    slot: int | None = Field(None, ge=0, le=15, description="of a card with motors: its first slot")


class AxisExpect(Strict):
    """About the measured response of axes."""

    kind: Literal["axis"]
    axis: Axes = "all"
    rise_ms: Pair | None = None
    overshoot_pct: Limit | None = None
    settle_ms: Pair | None = None
    steady_error_counts: Limit | None = None
    final_counts: Pair | None = None
    peak_error_counts: Limit | None = None  # largest |error| during the whole motion


class StatsExpect(Strict):
    """About the driver's statistics."""

    kind: Literal["stats"]
    interrupts: Count | None = None
    missed: Count | None = None
    overruns: Count | None = None
    panics: Count | None = None
    spurious: Count | None = None
    clips: Count | None = None
    bus_errors: Count | None = None


class QuietExpect(StatsExpect):
    """Nothing went wrong, as far as the driver's statistics tell; unless given otherwise."""

    kind: Literal["quiet"]
    missed: Count | None = [0.0, 0.0]
    overruns: Count | None = [0.0, 0.0]
    panics: Count | None = [0.0, 0.0]
    bus_errors: Count | None = [0.0, 0.0]


EventKind = Literal["panic", "error", "signal", "fault", "log", "bus", "assert",
                    "missed", "overrun", "spurious"]  # fmt: skip


class EventExpect(Strict):
    """About something that happens, or must not."""

    kind: Literal["event"]
    event: EventKind | Annotated[list[EventKind], Field(min_length=1)]  # any of a list
    text: str | None = None  # must occur in the note's text
    axis: int | None = Field(None, ge=0, le=31)
    seen: bool = True
    after: Seconds = 0.0  # seconds after the start of motion
    within_ms: float | None = Field(None, gt=0)


class SignalExpect(Strict):
    """About a column of the log in a stretch of time."""

    kind: Literal["signal"]
    axis: Axes = "all"
    signal: Literal["setpoint", "encoder", "velocity", "error", "current"]
    after: Seconds = 0.0
    until: Seconds = LONGEST_S
    mean: Pair | None = None
    rms: Pair | None = None
    lowest: Pair | None = None
    highest: Pair | None = None
    last: Pair | None = None


class PhysicsExpect(Strict):
    """About what the joints really did, whatever the driver thinks."""

    kind: Literal["physics"]
    axis: Axes = "all"
    after: Seconds = 0.0
    moved_deg: Limit | None = None  # farthest from where the joint was at `after`
    rest_ms: Pair | None = None  # from `after` until it stays at rest
    current_a: Limit | None = None  # in the motor at the end
    off_counts: Limit | None = None  # true position minus encoder count at the end


class CalibrationExpect(Strict):
    """About the absolute position found with potentiometer and index."""

    kind: Literal["calibration"]
    axis: Axes = "all"
    found: bool = True
    error_counts: Limit = [0.0, 0.0]


class RefusedExpect(Strict):
    """The driver refuses a request of the start, and that is the end of the run."""

    kind: Literal["refused"]
    request: str = Field(min_length=1, description="the request, like MSETNUMJOINTS")
    error: str = Field(min_length=1, description="the name of the error, like EINVAL")


Expect = Annotated[
    AxisExpect
    | StatsExpect
    | QuietExpect
    | EventExpect
    | SignalExpect
    | PhysicsExpect
    | CalibrationExpect
    | RefusedExpect,
    Field(discriminator="kind"),
]


class Scenario(Strict):
    """The whole file."""

    description: str = Field(min_length=1, description="one sentence in quotes")
    robot: str = Field(min_length=1, description="a robot's name or the path of its file")
    cards: int = Field(ge=1, le=16, description="the number of motor interface cards, 1 to 16")
    clk_hz: int = Field(8_000_000, ge=8_000_000, le=80_000_000, multiple_of=8_000_000)
    interval_us: int = Field(1000, ge=100, le=1_000_000)
    double_buffer: bool = True
    duration: Duration = Field(description="seconds of motion")
    seed: int = Field(1, ge=0, le=2**63 - 1)
    dynamics: Literal["independent", "coupled"] = "independent"
    gravity: bool = True  # of a coupled arm
    pose_deg: list[Degrees] = []  # joint angles at the start, instead of the robot file's
    heartbeat_us: int = Field(50_000, ge=1_000, le=50_000)  # the RTL's HeartbeatUs
    amp_panic_cut: bool = False
    skip: bool = True  # pass over clocks in which nothing happens
    verbose: bool = False
    host: Host = Host()
    motor: list[MotorValues] = []
    servo: list[Servo] = []
    motion: list[Motion] = []
    event: list[Event] = []
    call: list[Call] = []
    process: list[Process] = []
    program: list[Program] = []
    card: list[Card] = []
    expect: list[Expect] = []
