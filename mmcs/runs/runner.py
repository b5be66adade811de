# SPDX-License-Identifier: Apache-2.0
"""`mmcs run`: library, session, progress, results."""

import math
import shlex
from dataclasses import replace
from functools import partial
from pathlib import Path

from mmcs.files import LONGEST_S, short
from mmcs.scenario.compiled import absolute, inline
from mmcs.scenario.load import setup_of
from mmcs.scenario.setup import Setup


def run_scenario(
    setup: Setup,
    folder: Path,
    trace: Path | None = None,
    host: str = "native",
    carry_out=None,
    stderr: bool = False,
) -> bool:
    """Runs, writes folder and prints the table; True when every expectation held.

    carry_out: what makes a result of the setup, when not simulate(), on this host, with this trace.
    stderr: prints there.
    """
    from mmcs.folder import RESULTS, check_file, check_folder, writing
    from mmcs.runs import record as records
    from mmcs.runs import report as reports
    from mmcs.screen import echo
    from mmcs.service import bus_lines
    from mmcs.view.plot import write_plot

    for place in [folder] + ([trace.parent] if trace else []):
        check_folder(place)
    for file in [folder / name for name in RESULTS] + ([trace] if trace else []):
        check_file(file)
    with writing(folder) as stage:
        result = carry_out(setup) if carry_out else simulate(setup)
        report = reports.make_report(result, host)
        report["log_crc32"] = reports.write_log(result, stage)
        reports.write_report(report, stage)
        if result.bus is not None:
            (stage / "bus.csv").write_bytes(bus_lines(result.bus))
        write_plot(result, stage / "plot.svg")
        records.write_record(records.make_record(result, host), stage)
    say = partial(echo, err=stderr)
    reports.print_report(report, result, say)
    files = [f"{short(file)}" for file in (folder / "plot.svg", *([trace] if trace else []))]
    say(", ".join([f"results in {short(folder)}", *files]))
    if result.hash and not stderr:
        say(f"next: mmcs trace {short(folder)} (waveforms), mmcs compare A B (two runs)")
    return all(item["ok"] for item in report["expect"])


def simulate(
    setup: Setup,
    trace: Path | None = None,
    realtime: bool = False,
    host: str = "native",
    bus: bool = False,
):
    """Carries the setup out on the real machine.

    bus: keep the cycles of the VME bus.
    """
    from mmcs.engine.hosts import image_digest
    from mmcs.runs.machine import machine, progress
    from mmcs.runs.session import session_of

    kind = "trace" if trace else "speed"
    with machine(setup, kind, host=host) as sim, progress(setup.scenario.duration) as advance:
        image = image_digest(host)
        if trace:
            sim.trace(trace)
        result = session_of(sim, setup, realtime, bus).run(advance)
        result.image = image
        return result


def run_program(setup: Setup, command: list[str], folder: Path) -> int:
    """Runs a program on the setup's machine, with its events and, if the motions were not its own,
    its expectations, and writes folder. The program's status; 1 if that is 0 and one is not met."""
    statuses: list[int] = []

    def carry_out(made: Setup):
        result = simulate(made)
        statuses.append(result.processes[0]["status"])
        ended = math.ceil(result.simulated_s * 1e3) / 1e3
        least = setup.scenario.duration if made.scenario.expect else 0.0  # has what they speak of
        result.setup = _with(made, duration=max(ended, least))
        return result

    own = {"motion", "call", "process", "servo"}
    dropped = own | ({"expect"} if setup.scenario.motion or setup.scenario.process else set())
    data = {key: value for key, value in setup.data.items() if key not in dropped}
    words = shlex.join(command)
    data |= {"program": [{"run": absolute(words, Path.cwd())}], "duration": LONGEST_S}
    data |= {"description": f"the program {words}"}
    made = setup_of(setup.path, inline(data, setup.path.parent), setup.files)
    good = run_scenario(made, folder, carry_out=carry_out, stderr=True)
    return statuses[0] or int(not good)


def _with(setup: Setup, **values) -> Setup:
    scenario = setup.scenario.model_copy(update=values)
    return replace(setup, scenario=scenario, data=setup.data | values)
