# SPDX-License-Identifier: Apache-2.0
"""`mmcs design`: control synthesis on the command line (§2.5)."""

import click

from mmcs.errors import InputError
from mmcs.screen import echo

OPTION = dict(type=float, default=0.0)
GAINS = "pass -p, -i and -d, or let --wn place the poles of a PD: not both"


@click.command()
@click.option("-p", "p", **OPTION, help="Proportional gain, LSB/count.")
@click.option("-i", "i", **OPTION, help="Integral gain, LSB/(count s).")
@click.option("-d", "d", **OPTION, help="Derivative gain, LSB s/count.")
@click.option("--tau", type=float, help="Derivative filter, s; default: none.")
@click.option("--kick", type=float, metavar="UNITS",
              help="Instead of --tau: the filter with which one count makes the derivative move "
              "the D/A by so much.")  # fmt: skip
@click.option("--wn", type=float, help="Instead of gains: PD by pole placement, rad/s.")
@click.option("--zeta", type=float, help="Damping for --wn; default: 1.")
@click.option("--method", default="backward", show_default=True, metavar="NAME",
              help="backward, bilinear, prewarp, matched, ztransform or zoh.")  # fmt: skip
@click.option("--prewarp", **OPTION, help="Frequency that prewarp keeps exact, rad/s.")
@click.option("--interval", type=int, default=1000, show_default=True, metavar="US",
              help="Servo period.")  # fmt: skip
@click.option("--scale", type=int, help="b0; default: the smallest good power of two.")
@click.option("--robot", default="puma560", show_default=True, help="Robot file of the motor.")
@click.option("--axis", type=int, default=0, show_default=True, help="Axis of that robot.")
@click.option("--toml", "as_toml", is_flag=True, help="Print what to paste into TOML files.")
def design(p, i, d, tau, kick, wn, zeta, method, prewarp, interval, scale, robot, axis,
           as_toml) -> None:  # fmt: skip
    """Make the compensator's integers from continuous gains, and show the margins."""
    from mmcs.scenario import synthesis as ds
    from mmcs.scenario.load import load_robot
    from mmcs.scenario.motor import compensation, expected_step, friction_and_limit, plant_of

    _, motors = load_robot(robot)
    if not 0 <= axis < len(motors.axis):
        raise InputError.one("--axis", "", axis, f"the robot has axes 0 to {len(motors.axis) - 1}")
    motor = motors.axis[axis]
    plant, ic = plant_of(motor), compensation(motor)
    t = interval * 1e-6
    try:
        c = _controller(plant, p, i, d, tau, wn, zeta)
        if kick is None:
            k = ds.to_integers(ds.discretize(c, method, t, prewarp), scale)
        elif tau is None:
            c, k = ds.limited_integers(c, kick, method, t, prewarp, scale)
        else:
            raise ds.DesignError("--kick chooses the derivative filter: leave out --tau")
    except ds.DesignError as error:
        raise InputError.one("mmcs design", "", None, str(error)) from None
    except (OverflowError, ValueError, ZeroDivisionError):
        raise InputError.one("mmcs design", "", None, "a number is out of all proportion") from None
    m, step = ds.margins(k.discrete(), plant, t), ds.count_step(k.discrete(), c)
    warnings = list(k.warnings)
    if not m.stable:
        warnings.append("the closed loop is unstable with double-buffered D/As")
    if as_toml:
        echo(_toml(k, ic, robot, axis, interval))
    else:
        _print(c, k, ic, m, step, method, interval)
        expected = [expected_step(k, motor, t)] if m.stable else []
        for text in friction_and_limit(k, motor) + expected:
            echo(f"  {text}")
    for text in warnings:
        echo(f"warning: {text}", err=True)


def _controller(plant, p, i, d, tau, wn, zeta):
    """Gains as given, or a PD placed."""
    from mmcs.scenario import synthesis as ds

    if wn is not None:
        if p or i or d:
            raise ds.DesignError(f"--wn: {GAINS}")
        return ds.place(plant, wn, 1.0 if zeta is None else zeta, tau or 0.0)
    if zeta is not None:
        raise ds.DesignError("--zeta is the damping for --wn, which is missing")
    if not (p or i or d):
        raise ds.DesignError("give gains with -p -i -d, or a bandwidth with --wn")
    return ds.Controller(p, i, d, tau or 0.0)


def _toml(k, ic, robot: str, axis: int, interval: int) -> str:
    """A [[servo]] for a scenario; the same as a robot file has it, where it has the form."""
    lines = ["# in a scenario:", "[[servo]]", f"axis = {axis}"]
    if interval != 1000:
        lines = [f"# above the first [[...]] of a scenario: interval_us = {interval}", *lines]
    lines += ['mode = "position"', *(f"{key} = {value}" for key, value in k.named().items())]
    friction = [f"ic_pos = {ic[0]}", f"ic_neg = {ic[1]}"] if any(ic) else []
    lines += ['flags = ["coulcomp"]', *friction] if friction else []
    if k.a[2] == k.b[2] == 0 and interval in (1000, 2000):
        gains = [k.a[0], k.a[1], k.b[0], *([k.b[1]] if k.b[1] else [])]
        lines += ["", f"# or in the robot file, after the [[axis]] number {axis} of {robot}:"]
        lines += ["[axis.servo]", f"pd_{interval}us = {gains}", *friction]
    return "\n".join(lines)


def _print(c, k, ic, m, step, method, interval) -> None:
    gains = f"P {c.p:.6g}, I {c.i:.6g}, D {c.d:.6g}" + (f", tau {c.tau:.4g} s" if c.tau else "")
    echo(f"{c.form} by {method} at {interval} us: {gains}")
    echo("  a0 a1 a2   " + "  ".join(map(str, k.a)))
    echo("  b0 b1 b2   " + "  ".join(map(str, k.b)))
    if any(ic):
        echo(f"  ic_pos {ic[0]}, ic_neg {ic[1]}: 80 % of the motor's Coulomb friction")
    if c.d:
        echo(f"  one count: the derivative makes {step:.0f} D/A units of it")
    echo(f"  error by rounding {100 * k.gain_error:.3g} %")
    echo(
        f"  gain margin {m.gain_db:.1f} dB, phase margin {m.phase_deg:.1f} deg at "
        f"{m.crossover:.1f} rad/s, sensitivity peak {m.peak:.2f}"
    )
