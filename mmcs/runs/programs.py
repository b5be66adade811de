# SPDX-License-Identifier: Apache-2.0
"""A run whose user's side is programs, in lock-step: a scenario's [[program]] entries (§2.3)."""

import shlex
import struct
import subprocess
import tempfile
import time
from pathlib import Path

from mmcs import mcdef
from mmcs.device.execute import check_program, environment, say
from mmcs.device.server import Server
from mmcs.errors import InputError
from mmcs.runs.session import CHUNK_S, WATCH_S, Result, Session
from mmcs.scenario.compiled import absolute


class ProgramSession(Session):
    """Time 0 is power-on, and the programs begin then; events count from there. The run ends with
    the last program, or with the duration, which ends them."""

    def __init__(self, *args, quiet: bool = False, **more):
        """quiet: what programs and driver print is dropped."""
        super().__init__(*args, **more)
        self._quiet = quiet

    def run(self, progress=lambda _: None) -> Result:
        sim, programs = self.sim, self.setup.scenario.program
        began = time.perf_counter()
        if self.bus is not None:
            sim.bus_cycles()
        self.begin()
        with tempfile.TemporaryDirectory(prefix="mmcs-") as folder:
            console, out = (lambda _: None, subprocess.DEVNULL) if self._quiet else (say, None)
            server = Server(sim, Path(folder) / "run.sock", None, console=console, lockstep=True)
            sim.ring(0.0, 0)
            children: list[subprocess.Popen] = []
            try:
                env = environment(server.path, lockstep=True)
                for program in programs:
                    command = absolute(program.run, self.setup.path.parent)
                    children.append(_start(command, env, out))
                    server.lockstep.expect(children[-1].pid)
                good = self._serve(server, children, progress)
                ended = "" if good else self._why_ended()
                self.log.append(sim.take_log())
                now = sim.stats(), sim.hash(), self.witnesses(), self._states()
                result = self.result(began, good, ended, *now)
            finally:
                statuses = [_end(child) for child in children]
                server.close()
        result.processes = [
            {"kind": "program", "run": program.run, "status": status}
            for program, status in zip(programs, statuses, strict=True)
        ]
        return result

    def _serve(self, server: Server, children: list[subprocess.Popen], progress) -> bool:
        """From look to look at the physics; False when an assertion of the model failed."""
        steps, duration = server.lockstep, self.setup.scenario.duration
        step = WATCH_S if self.setup.scenario.event else CHUNK_S
        looks = max(1, round(duration / step))
        self._watch(0.0)
        for look in range(1, looks + 1):
            t = duration * look / looks
            steps.now.limit = round(t * self.sim.build()["clk_hz"])
            while self.sim.clock < steps.now.limit or steps.busy():
                if not any(child.pid in steps.pids() for child in children):
                    return bool(steps.now.good)
                server.step()
            if not steps.now.good:
                return False
            self._watch(t)
            progress(t)
        return True

    def _states(self) -> list[dict]:
        """Of the last sample: the programs may have closed the device since."""
        rows = self.sim.tap_head()[0]
        row = self.sim.tap_rows(rows - 1, 1, 1)[0] if rows else bytes(self.sim.tap_head()[2])
        names, of_axis = mcdef.fields("mc_state"), struct.Struct("<10i")
        return [
            dict(zip(names, of_axis.unpack_from(row, 24 + of_axis.size * n), strict=False))
            for n in range(self.setup.axes)
        ]


def _start(command: str, env: dict[str, str], out: int | None) -> subprocess.Popen:
    words = shlex.split(command)
    check_program(words[0])
    try:
        return subprocess.Popen(words, env=env, stdout=out, stderr=out)
    except OSError as error:
        raise InputError.one("program", "run", words[0], error.strerror) from None


def _end(child: subprocess.Popen) -> int:
    """Its status, as a shell would give it; the run is over, and whoever waits for it is killed."""
    status = child.poll()
    if status is None:
        child.kill()
        status = child.wait()
    return 128 - status if status < 0 else status
