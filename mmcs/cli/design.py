# SPDX-License-Identifier: Apache-2.0
"""`mmcs design`: control synthesis on the command line (§2.5)."""

from __future__ import annotations

import json
from pathlib import Path

import click

from mmcs.errors import InputError, RunError

OPTION = dict(type=float, default=0.0)


@click.command()
@click.option("-p", "p", **OPTION, help="Proportional gain, LSB/count.")
@click.option("-i", "i", **OPTION, help="Integral gain, LSB/(count s).")
@click.option("-d", "d", **OPTION, help="Derivative gain, LSB s/count.")
@click.option("--tau", **OPTION, help="Derivative filter, s; 0: none.")
@click.option("--wn", type=float, help="Instead of gains: PD by pole placement, rad/s.")
@click.option("--zeta", type=float, default=1.0, show_default=True, help="Damping for --wn.")
@click.option("--method", default="backward", show_default=True, metavar="NAME",
              help="backward, bilinear, prewarp, matched, ztransform or zoh.")  # fmt: skip
@click.option("--prewarp", **OPTION, help="Frequency that prewarp keeps exact, rad/s.")
@click.option("--interval", type=int, default=1000, show_default=True, metavar="US",
              help="Servo period.")  # fmt: skip
@click.option("--scale", type=int, help="b0; default: the smallest good power of two.")
@click.option("--robot", default="puma560", show_default=True, help="Robot file of the motor.")
@click.option("--axis", type=int, default=0, show_default=True, help="Axis of that robot.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
@click.option("--c", "as_c", is_flag=True, help="Print C for struct mc_param.")
@click.option("--plot", type=click.Path(path_type=Path), metavar="FILE", help="Bode, step, poles.")
@click.option("--apply", "apply_to", type=int, metavar="AXIS", help="Set it on a running device.")
@click.option("--dev", default="mc0", metavar="NAME", help="Server for --apply.")
def design(p, i, d, tau, wn, zeta, method, prewarp, interval, scale, robot, axis, as_json, as_c,
           plot, apply_to, dev) -> None:  # fmt: skip
    """Make the compensator's integers from continuous gains, and show the margins."""
    from mmcs.design import synthesis as ds

    plant = _plant(_load_robot(robot), axis)
    t = interval * 1e-6
    try:
        c = ds.place(plant, wn, zeta) if wn is not None else ds.Controller(p, i, d, tau)
        if wn is None and not (p or i or d):
            raise ds.DesignError("give gains with -p -i -d, or a bandwidth with --wn")
        k = ds.to_integers(ds.discretize(c, method, t, prewarp), t, scale)
    except ds.DesignError as error:
        raise InputError.one("mmcs design", "", None, str(error)) from None
    except (OverflowError, ValueError, ZeroDivisionError):
        raise InputError.one("mmcs design", "", None, "a number is out of all proportion") from None
    m = ds.margins(k.discrete(), plant, t)
    warnings = list(k.warnings)
    if not m.stable:
        warnings.append("the closed loop is unstable with double-buffered D/As")
    if as_json:
        click.echo(json.dumps(_report(c, k, m, method, interval, warnings), indent=2))
    elif as_c:
        for name, values in (("a", k.a), ("b", k.b)):
            click.echo(" ".join(f"par.{name}{n} = {v};" for n, v in enumerate(values)))
    else:
        _print(c, k, m, method, interval)
    for text in warnings:
        click.echo(f"warning: {text}", err=True)
    if plot is not None:
        from mmcs.design.plot import write_plot

        write_plot(plot, c, k, plant, t)
    if apply_to is not None:
        _apply(apply_to, k, dev, interval)


def _load_robot(name: str):
    from mmcs import ROBOTS
    from mmcs.scenario.files import find, read_toml
    from mmcs.scenario.robot import Robot
    from mmcs.scenario.schema import validate

    path = find(name, ROBOTS, "robot")
    robot, mistakes = validate(Robot, read_toml(path), str(path))
    if mistakes:
        raise InputError(*mistakes)
    return robot


def _plant(robot, axis: int):
    """The motor as the linear design sees it: counts/s^2 per D/A unit, and B/J."""
    import math

    from mmcs.design.synthesis import Plant

    if not 0 <= axis < len(robot.axis):
        raise InputError.one("--axis", "", axis, f"the robot has axes 0 to {len(robot.axis) - 1}")
    motor = robot.axis[axis]
    counts_per_rad = motor.counts_per_rev / (2 * math.pi)
    torque_per_lsb = motor.km * motor.amp_gain * 10 / 2048
    return Plant(counts_per_rad * torque_per_lsb / motor.inertia, motor.viscous / motor.inertia)


def _report(c, k, m, method, interval, warnings) -> dict:
    return {
        "form": c.form,
        "method": method,
        "interval_us": interval,
        "gains": {"p": c.p, "i": c.i, "d": c.d, "tau": c.tau},
        **{f"a{n}": v for n, v in enumerate(k.a)},
        **{f"b{n}": v for n, v in enumerate(k.b)},
        "gain_error": k.gain_error,
        "gain_margin_db": m.gain_db,
        "phase_margin_deg": m.phase_deg,
        "crossover_rad_s": m.crossover,
        "sensitivity_peak": m.peak,
        "stable": m.stable,
        "warnings": warnings,
    }


def _print(c, k, m, method, interval) -> None:
    gains = f"P {c.p:.6g}, I {c.i:.6g}, D {c.d:.6g}" + (f", tau {c.tau:.4g} s" if c.tau else "")
    click.echo(f"{c.form} by {method} at {interval} us: {gains}")
    click.echo("  a0 a1 a2   " + "  ".join(map(str, k.a)))
    click.echo("  b0 b1 b2   " + "  ".join(map(str, k.b)))
    click.echo(f"  error by rounding {100 * k.gain_error:.3g} %")
    click.echo(
        f"  gain margin {m.gain_db:.1f} dB, phase margin {m.phase_deg:.1f} deg at "
        f"{m.crossover:.1f} rad/s, sensitivity peak {m.peak:.2f}"
    )


def _apply(axis: int, k, dev: str, interval: int) -> None:
    """Only the compensator changes, between two samples; whoever runs the device keeps it."""
    from mmcs.device.client import Device

    try:
        with Device("/dev/mc0", server=dev) as device:
            if interval != device.interval():
                allowed = f"the device samples every {device.interval()} us"
                raise InputError.one("--interval", "", interval, allowed)
            param = device.get_param(axis)
            for n in range(3):
                param[f"a{n}"], param[f"b{n}"] = k.a[n], k.b[n]
            device.set_param(axis, param)
    except OSError as error:
        raise RunError(f"--apply {axis}: {error.strerror}") from None
    click.echo(f"set on axis {axis}")
