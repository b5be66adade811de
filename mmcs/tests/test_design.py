# SPDX-License-Identifier: Apache-2.0
"""Control synthesis (§2.5) beside independent oracles, and in the machine; what
`mmcs design` says of friction, limit and the step to expect."""

import json
import math
import random
import re

import numpy as np
import pytest

from mmcs import ROOT, run
from mmcs.scenario import synthesis as ds
from mmcs.scenario.identify import identify
from mmcs.scenario.load import load_robot
from mmcs.scenario.motor import compensation, plant_of
from mmcs.tests.conftest import good
from mmcs.tests.inputs import recording

T = 1e-3
EXTRA = "missing; install it with: uv pip install -e .[test]"
PROPER = [
    ds.Controller(4.0),
    ds.Controller(4.0, 30.0),
    ds.Controller(4.0, 0.0, 0.1, 0.004),
    ds.Controller(4.0, 30.0, 0.1, 0.004),
]
IMPROPER = [ds.Controller(4.0, 0.0, 0.1), ds.Controller(4.0, 30.0, 0.1)]
pytestmark = pytest.mark.req("SYN-1")


def continuous(c):
    """num, den of C(s) by hand, for the oracle."""
    num, den = np.poly1d([c.p]), np.poly1d([1.0])
    if c.i:
        num, den = num * np.poly1d([1, 0]) + c.i * den, den * np.poly1d([1, 0])
    if c.d:
        f = np.poly1d([c.tau, 1])
        num, den = num * f + np.poly1d([c.d, 0]) * den, den * f
    return num.coeffs, den.coeffs


def response(d, w):
    return d.at(np.exp(1j * w * T))


W = np.geomspace(1, 3000, 50)


@pytest.mark.parametrize("c", PROPER, ids=lambda c: c.form)
def test_zero_order_hold_is_that_of_scipy(c):
    signal = pytest.importorskip("scipy.signal", reason=EXTRA)
    num, den, _ = signal.cont2discrete(continuous(c), T, "zoh")
    z = np.exp(1j * W * T)
    oracle = np.polyval(np.ravel(num), z) / np.polyval(den, z)
    assert response(ds.discretize(c, "zoh", T), W) == pytest.approx(oracle, rel=1e-6)


@pytest.mark.parametrize("c", PROPER + IMPROPER, ids=lambda c: c.form)
@pytest.mark.parametrize("method", ["bilinear", "backward", "prewarp"])
def test_substitution_is_what_it_says(c, method):
    """An oracle without a library, for improper controllers too: s as a function of z."""
    w0 = 200.0
    q = np.exp(-1j * W * T)
    s = {
        "backward": (1 - q) / T,
        "bilinear": 2 / T * (1 - q) / (1 + q),
        "prewarp": w0 / math.tan(w0 * T / 2) * (1 - q) / (1 + q),
    }[method]
    made = response(ds.discretize(c, method, T, w0), W)
    assert made == pytest.approx(c.at(s), rel=1e-6)
    if method == "prewarp":
        at = ds.discretize(c, method, T, w0).at(np.exp(1j * np.array([w0]) * T))
        assert at == pytest.approx(c.at(np.array([1j * w0])), rel=1e-9)


@pytest.mark.parametrize("lag", [0.0, 0.24, 40.0])
def test_plant_same_as_scipy(lag):
    signal = pytest.importorskip("scipy.signal", reason=EXTRA)
    num, den, _ = signal.cont2discrete(([1000.0], [1.0, lag, 0.0]), T, "zoh")
    z = np.exp(1j * W * T)
    oracle = np.polyval(np.ravel(num), z) / np.polyval(den, z)
    assert ds.Plant(1000.0, lag).discrete(T).at(z) == pytest.approx(oracle, rel=1e-5)


def test_margins_same_as_control():
    control = pytest.importorskip("control", reason=EXTRA)
    plant = ds.Plant(1000.0, 0.24)
    k = ds.to_integers(ds.discretize(ds.place(plant, 80.0), "backward", T))
    d, g = k.discrete(), plant.discrete(T)
    # in powers of z: both sides as long as the longest
    num = np.convolve(np.convolve(d.num, g.num), [0, 1.0])
    den = np.convolve(d.den, g.den)
    size = max(len(num), len(den))
    loop = control.tf(np.pad(num, (0, size - len(num))), np.pad(den, (0, size - len(den))), T)
    gain, phase, *_ = control.margin(loop)
    found = ds.margins(d, plant, T)
    assert found.stable
    assert found.gain_db == pytest.approx(20 * math.log10(gain), abs=0.05)
    assert found.phase_deg == pytest.approx(phase, abs=0.2)


@pytest.mark.parametrize("slow", [0.0, 7.5])
def test_an_integral_adds_a_pole_and_leaves_the_others(slow):
    """Of 1 + C(s) G(s): PD has two, PID a third where it was asked for."""
    plant, wn, zeta = ds.Plant(1000.0, 0.24), 60.0, 0.8
    c = ds.place(plant, wn, zeta, slow=slow)
    found = np.poly1d([1.0, plant.lag + plant.g * c.d, plant.g * c.p, plant.g * c.i])
    pair = np.poly1d([1.0, 2 * zeta * wn, wn * wn])
    assert found.coeffs == pytest.approx((pair * np.poly1d([1.0, slow])).coeffs)


@pytest.mark.req("DAC-1")
@pytest.mark.parametrize(("method", "rings"), [("bilinear", True), ("backward", False)])
def test_ringing_in_the_machine(method, rings):
    """Double-buffered D/As and the bilinear PID: the current alternates at half the sample rate."""
    plant = plant_of(load_robot("lab500")[1].axis[0])
    pd = ds.place(plant, 80.0)
    k = ds.to_integers(ds.discretize(ds.Controller(pd.p, 5.0, pd.d), method, T))
    values = zip(("a0", "a1", "a2", "b0", "b1", "b2"), (*k.a, *k.b), strict=True)
    sets = [f"axis.0.{name}={value}" for name, value in values]
    seen = run("lab500", *sets, "axis.0.flags=[]", "axis.0.ilim=2047", "motion.0.to=50")
    tail = seen.column(0, "current")[-100:].astype(float)
    alternation = abs(np.mean(tail * (-1.0) ** np.arange(100)))
    assert (alternation > 100) == rings, alternation


@pytest.mark.parametrize("scale", [None, 64, 256, 4096])
@pytest.mark.parametrize("method", ["backward", "matched", "bilinear", "zoh"])
def test_rounded_gains_obey_the_limit(method, scale):
    """Many gains and limits: what MSETPARAM gets, not what was rounded, keeps below."""
    draw, filtered = random.Random(150), 0
    for _ in range(60):
        gains = ds.Controller(draw.uniform(1, 30), 0.0, draw.uniform(0.02, 1.0))
        most = draw.uniform(0.05, 0.9) * gains.d / T
        made, k = ds.limited_integers(gains, most, method, T, 0.0, scale)
        step = k.a[0] / k.b[0] - sum(k.a) / sum(k.b)
        assert 0.4 * most < step <= most, (gains, most, k)
        filtered += made.tau > 0
    assert filtered > 50


@pytest.mark.parametrize("interval", [1000, 2000])
@pytest.mark.parametrize("axis", range(6))
def test_the_robot_ships_what_design_makes(mmcs, axis, interval):
    """The commands that sim/robots/puma560.toml names, and no kick above 150."""
    _, robot = load_robot("puma560")
    recipe = robot.reference[f"design_{interval}us"].split("; ")
    chosen = next(r for r in recipe if f"J{axis + 1}" in r.split(": ")[0].split())
    out = good(mmcs(*chosen.split(": ")[1].split()[1:], "--interval", interval, "--axis", axis,
                    "--toml"))  # fmt: skip
    shipped = getattr(robot.axis[axis].servo, f"pd_{interval}us")
    assert f"pd_{interval}us = {shipped}\n" in out
    a0, a1, b0, b1 = [*shipped, 0][:4]
    assert a0 / b0 - (a0 + a1) / (b0 + b1) <= 150


# --- of a motor -----------------------------------------------------------------------------------


@pytest.mark.parametrize("robot", ["lab500", "puma560"])
def test_compensation_is_that_of_the_robot_files(robot):
    motors = load_robot(robot)[1].axis
    for motor in motors:
        pos, neg = compensation(motor)
        assert abs(pos - motor.servo.ic_pos) <= 1 and abs(neg - motor.servo.ic_neg) <= 1
    reversed_axis = motors[0].model_copy(update={"amp_gain": -motors[0].amp_gain})
    assert compensation(reversed_axis) == tuple(-ic for ic in compensation(motors[0]))


def test_the_design_says_where_the_machine_rests(mmcs, tmp_path):
    """The bounds that the program prints hold in the machine, and are not far from what it does."""
    status, said, _ = mmcs("design", "--wn", "80", "--robot", "lab500")
    bounds = re.search(r"may rest (\d+) counts off its setpoint, (\d+) without", said)
    first = re.search(r"a step of more than (\d+) counts begins at ilim 1024", said)
    assert status == 0 and "ic_pos 84, ic_neg 84" in said and first
    for flags, bound in (('["coulcomp"]', bounds[1]), ("[]", bounds[2])):
        error = run("lab500", f"axis.0.flags={flags}").report["axes"][0]["steady_error_counts"]
        assert 0.3 * int(bound) - 1 <= error <= int(bound)
    for step, cut in ((int(first[1]) - 1, False), (int(first[1]) + 2, True)):
        out = tmp_path / f"step{step}"
        said = mmcs("run", "lab500", "--set", f"motion.0.to={step}", "--out", str(out))[1]
        assert ("the limit cut the current" in said) == cut
        report = json.loads((out / "report.json").read_text())
        assert (report["axes"][0]["limited_samples"] > 0) == cut


@pytest.mark.parametrize("axis, options", [(0, ()), (0, ("--wn", "40")), (1, ()), (5, ())])
def test_the_expected_step_is_the_machine_s(mmcs, axis, options):
    """On the bench motor, and on joints of the PUMA, of which one counts the other way."""
    robot = "puma560" if axis else "lab500"
    wanted = ("--robot", robot, "--axis", axis, *(options or ("--wn", "80")))
    said = mmcs("design", *map(str, wanted))[1]
    told = r"rises in (\d+) ms, overshoots by (\d+) %, ends (\d+) counts off"
    rise, over, off = map(int, re.search(told, said).groups())
    pasted = mmcs("design", *map(str, wanted), "--toml")[1]
    made = dict(re.findall(r"^([a-z]\w+) = (-?\d+)$", pasted, re.M))
    sets = [f"axis.{axis}.{key}={value}" for key, value in made.items() if key != "axis"]
    step = f'motion=[{{axis = {axis}, kind = "step", at = 0.05, to = 200}}]'
    seen = run(robot, *sets, step, "duration=0.7", "expect=[]").report["axes"][axis]
    assert abs(seen["rise_ms"] - rise) <= max(3, 0.1 * rise), (seen["rise_ms"], rise)
    assert abs(seen["overshoot_pct"] - over) <= 2
    assert abs(abs(seen["steady_error_counts"]) - off) <= 3


def test_the_first_hour_tells_what_the_design_expects(mmcs, tmp_path):
    page = (ROOT / "docs" / "use" / "first_hour.md").read_text()
    motor = tmp_path / "motor.toml"
    motor.write_text(re.search(r"```toml motor.toml\n(.*?)```", page, re.S)[1])
    said = mmcs("design", "--wn", "80", "--robot", str(motor))[1]
    rise, off = re.search(r"rises in (\d+) ms, .* ends (\d+) counts off", said).groups()
    told = f"rises in {rise} ms and ends {off} counts from its setpoint"
    assert told in " ".join(page.split())


@pytest.mark.req("TOOL-1")
@pytest.mark.parametrize(
    "g,lag,pos,neg", [(150, 3, 300, 350), (760, 2, 70, 106), (1450, 0.3, 105, 105)]
)
def test_the_motor_is_found_in_its_motion(g, lag, pos, neg):
    motor = identify(*recording(g, lag, pos, neg))
    assert (motor.g, motor.lag) == (pytest.approx(g, rel=0.02), pytest.approx(lag, abs=1.0))
    assert (motor.tc_pos, motor.tc_neg) == pytest.approx((pos, neg), abs=12)
