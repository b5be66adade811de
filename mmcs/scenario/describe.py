# SPDX-License-Identifier: Apache-2.0
"""`mmcs show` and the cautions of `mmcs check`: what a scenario amounts to."""

from mmcs.errors import toml
from mmcs.scenario.arm import has_mass_distribution
from mmcs.scenario.setup import SERVO_DEFAULTS, Setup

LEAST_PHASE_DEG = 20


def show_setup(setup: Setup) -> None:
    from mmcs.screen import echo, table

    scenario, robot = setup.scenario, setup.robot
    echo(f"{setup.name}: {scenario.description}")
    cards = f"{scenario.cards} card{'s' if scenario.cards > 1 else ''}"
    echo(
        f"  robot {scenario.robot} ({robot.title}), {setup.axes} axes "
        f"{'coupled' if scenario.dynamics == 'coupled' else 'on their own'}, {cards}"
    )
    buffered = "double" if scenario.double_buffer else "single"
    echo(
        f"  servo every {scenario.interval_us} us, D/A {buffered}-buffered; "
        f"{scenario.duration:g} s of motion; seed {scenario.seed}"
    )
    host = scenario.host
    echo(
        f"  host: {host.cpu_us_per_axis:.4g} us per axis, interrupt latency 0 to "
        f"{host.latency_max_us:g} us, bus timer {host.bus_timeout_us:g} us"
    )
    rows = []
    for key in SERVO_DEFAULTS:
        values = [params[key] for params in setup.params]
        if any(value != SERVO_DEFAULTS[key] for value in values):
            rows.append((key, *(" ".join(v) if isinstance(v, list) else str(v) for v in values)))
    if not scenario.program:  # which sets servos itself
        names = (f"{axis} {robot.axis_name(axis)}".strip() for axis in range(setup.axes))
        echo(table("  servo parameters by axis", ("", *names), rows, left=1))
    for segment in setup.segments:
        target = f" to {segment['to']:g}" if "to" in segment else ""
        lasting = f" in {segment['duration']:g} s" if segment["duration"] else ""
        echo(
            f"  {segment['t0']:7.3f} s  axis {segment['axis']}: {segment['kind']}{target}{lasting}"
        )
    for name in ("process", "program", "call", "event", "expect"):
        for entry in getattr(scenario, name):
            fields = entry.model_dump(exclude_none=True, exclude_defaults=True)
            text = ", ".join(f"{key} = {toml(value)}" for key, value in fields.items())
            echo(f"  {name}: {text}")


def cautions(setup: Setup) -> list[str]:
    """Legal settings that will probably disappoint, one sentence each."""
    scenario, out = setup.scenario, []
    heartbeat = scenario.heartbeat_us
    if scenario.interval_us > heartbeat:
        out.append(
            f"interval_us = {scenario.interval_us}: above the heartbeat's {heartbeat} us the "
            "machine panics by design"
        )
    host = scenario.host
    busy = setup.axes * host.cpu_us_per_axis + host.latency_max_us + 9 * setup.axes
    if busy > scenario.interval_us:
        out.append(
            f"interval_us = {scenario.interval_us}: the host needs up to {busy:.0f} us for "
            f"{setup.axes} axes, so the driver will count overruns"
        )
    for axis, p in enumerate(setup.params):
        if p["mode"] == "off" and any(s["axis"] == axis for s in setup.segments):
            out.append(f'axis {axis}: has motions but mode "off"')
        if p["ilim"] > 2047:
            out.append(f"axis {axis}: ilim {p['ilim']} is beyond the D/A's 2047")
        if p["b1"] or p["b2"]:
            continue
        total = p["a0"] + p["a1"] + p["a2"]
        if p["mode"] == "position" and total * p["b0"] < 0 <= p["ic_pos"]:
            out.append(
                f"axis {axis}: negative gain is for an encoder that counts down with positive "
                "torque; then ic_pos and ic_neg must be negative too"
            )
    for axis, text in poor_gains(setup).items():
        command = f"mmcs design --wn 50 --robot {scenario.robot} --axis {axis} --toml"
        out.append(f"{text}; `{command}` makes others")
    for n, event in enumerate(scenario.event):
        if event.at >= scenario.duration and not event.at_power_on:
            out.append(f"event.{n}: at {event.at:g} s the run has ended")
    used = {s["axis"] for s in setup.segments}
    for axis in range(setup.axes):
        if axis not in used and setup.scenario.motion and setup.params[axis]["mode"] != "off":
            out.append(f"axis {axis}: no motion, it holds its position")
    return out


def poor_gains(setup: Setup) -> dict[int, str]:
    """By axis: position loops that the motor's own inertia makes unstable, or nearly so."""
    from mmcs.scenario.motor import plant_of
    from mmcs.scenario.synthesis import Discrete, margins

    scenario, out = setup.scenario, {}
    for axis, p in enumerate(setup.params):
        if p["mode"] != "position" or {"adfb", "adoff"} & set(p["flags"]) or not p["b0"]:
            continue
        num, den = ([p[f"{k}{n}"] / p["b0"] for n in range(3)] for k in "ab")
        plant, t = plant_of(setup.robot.axis[axis]), scenario.interval_us * p["clkdivisor"] * 1e-6
        if sum(num) * plant.g <= 0:
            continue  # told above, if it is a mistake
        m = margins(Discrete(tuple(num), tuple(den)), plant, t, delay=int(scenario.double_buffer))
        if m.stable and m.phase_deg > LEAST_PHASE_DEG:
            continue
        what = f"only {m.phase_deg:.0f} deg of phase margin" if m.stable else "an unstable loop"
        out[axis] = f"axis {axis}: its gains and this motor make {what} at {t * 1e6:.0f} us"
    return out


def lacking_gains(setup: Setup) -> list[str]:
    """A sentence for each position loop that moves with the driver's initial gains."""
    initial = {key: SERVO_DEFAULTS[key] for key in ("a0", "a1", "a2", "b0", "b1", "b2")}
    moved = {s["axis"] for s in setup.segments}
    return [
        f"{setup.path.name}: axis {axis} has no gains, neither here nor in {setup.scenario.robot}: "
        "the motor may never move"
        for axis, p in enumerate(setup.params)
        if axis in moved and p["mode"] == "position" and initial.items() <= p.items()
    ]


def robot_cautions(robot) -> list[str]:
    """Legal values of a robot file that will probably disappoint, one sentence each."""
    out = []
    for n, motor in enumerate(robot.axis):
        axis = f"axis {n} {motor.name}".strip()
        units = 2048 / (10 * abs(motor.amp_gain) * motor.km)  # D/A units per N m
        stuck = max(motor.stiction_pos, motor.stiction_neg) * units
        if stuck > motor.servo.ilim:
            out.append(f"{axis}: takes {stuck:.0f} D/A units to break away, ilim is less")
        if motor.servo.pd_1000us is None and motor.servo.pd_2000us is None:
            out.append(f"{axis}: has no gains (servo.pd_1000us); scenarios must give them")
        if motor.v_supply > 0:
            top = motor.v_supply / motor.km * motor.counts_per_rev / 6.283
            if top > 4e6:
                out.append(f"{axis}: {top:.3g} counts a second at full speed, the card counts 4e6")
        if motor.stop_lo < motor.stop_hi and motor.pot_v_per_rad:
            ends = [motor.pot_offset + motor.pot_v_per_rad * q for q in
                    (motor.stop_lo, motor.stop_hi)]  # fmt: skip
            if max(map(abs, ends)) > 10:
                out.append(f"{axis}: its potentiometer leaves the A/D's +-10 V")
            lsb = 20 / 4096 / abs(motor.pot_v_per_rad) * abs(motor.gear) / 6.283
            if lsb > 0.25:
                out.append(f"{axis}: the potentiometer cannot tell the motor's revolutions apart")
        for side in ("pos", "neg"):
            ic = abs(getattr(motor.servo, f"ic_{side}"))
            coulomb = getattr(motor, f"coulomb_{side}") * units
            if ic > 1.1 * coulomb + 1:
                out.append(f"{axis}: ic_{side} {ic} is above the friction ({coulomb:.0f}): it will"
                           " hunt")  # fmt: skip
    for n, link in enumerate(robot.link[1:], 1):  # of the first, one axis alone matters
        if not has_mass_distribution(link.inertia):
            out.append(
                f"link {n}: its greatest principal inertia is more than the sum of the other two, "
                "which no body has"
            )
    return out
