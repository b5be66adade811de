# SPDX-License-Identifier: Apache-2.0
"""What the page asks of Python: designs, predictions, recordings as MCAP, and auto-tune.

Lines as mmcs/tool/worker.py has them; {"type": "progress"} tells how an experiment gets on.

  design   p, i, d (LSB/count, LSB/(count s), LSB s/count), tau, interval_s
  predict  motor {g, lag, …}, param, interval_s, step (counts), away: the step with limit and
           friction, and the closed loop's Bode plot
  mcap     csv: whole lines (web/recording.js); first, last: of a file. What of it they made, base64
  tune     axis, wn (rad/s), zeta, half (counts to each side that are safe), lender (client)
  judge    t (s), y, u of a step of `size` counts, wn, zeta, param, interval_s, motor: its figures,
           and with a motor whether they are as asked
  chirp    axis, amplitude, low, high (Hz), seconds, lender
  waves    t (s), ms: what nets do around that moment, as web/waves.js draws it
  alive    the page is there; without one for deadman_ms (250) an experiment is broken off
"""

import base64
import sys
import time
from dataclasses import fields
from functools import partial
from pathlib import Path

import numpy as np

from mmcs.scenario.identify import IdentifyError, Motor
from mmcs.scenario.synthesis import Discrete, Plant, margins, step_response
from mmcs.service import DesignError, design_answer
from mmcs.tool.worker import Worker, work

DEADMAN_MS = 250


class Advisor(Worker):
    def __init__(self, socket: Path, out=sys.stdout):
        super().__init__(out)
        self.socket = socket
        self.patience_s = DEADMAN_MS / 1000
        self.mcap = None  # the file that is being written

    # one sentence for each mistake that a person can make
    known = (DesignError, IdentifyError)

    # --- designs ---

    def do_design(self, message: dict) -> dict:
        gains = [float(message.get(name, 0.0)) for name in ("p", "i", "d", "tau")]
        return design_answer(gains, _interval(message))

    def do_predict(self, message: dict) -> dict:
        param, t = message["param"], _interval(message)
        b0 = param["b0"]
        d = Discrete(
            tuple(param[f"a{n}"] / b0 for n in range(3)),
            tuple(param[f"b{n}"] / b0 for n in range(3)),
        )
        motor = message["motor"]
        plant = Plant(abs(float(motor["g"])), max(float(motor["lag"]), 0.0))
        m = margins(d, plant, t)
        rows = int(min(4.0, float(message.get("seconds", 0.4))) / t)
        size = float(message.get("step", 1.0))
        if "tc_pos" in motor and abs(size) >= 1:
            from mmcs.tool.judge import predict

            whole = Motor(**{f.name: float(motor[f.name]) for f in fields(Motor)})
            step = np.array(predict(whole, param, t, size, rows * t, float(message["away"]))["y"])
        else:
            step = size * step_response(d, plant, t, rows)
        hz = np.geomspace(0.5, min(200.0, 0.45 / t), 120)
        z = np.exp(2j * np.pi * hz * t)
        loop = d.at(z) * plant.discrete(t).at(z) / z
        response = loop / (1 + loop)
        return {
            "stable": m.stable, "phase_deg": m.phase_deg, "gain_db": _finite(m.gain_db),
            "peak": m.peak, "t": (np.arange(len(step)) * t).tolist(), "y": step.tolist(),
            "hz": hz.tolist(), "bode_db": (20 * np.log10(abs(response))).tolist(),
            "bode_deg": np.degrees(np.unwrap(np.angle(response))).tolist(),
        }  # fmt: skip

    def do_judge(self, message: dict) -> dict:
        from mmcs.tool.judge import Wish, judge, step_figures

        t, y, u = (np.array(message[name], dtype=float) for name in "tyu")
        step = step_figures(t, y, float(message["size"]))
        if not message.get("motor"):
            return step
        wish = Wish(float(message["wn"]), float(message["zeta"]), _interval(message))
        verdict = judge(step | {"u": u}, wish, Motor(**message["motor"]), message["param"])
        return step | {"fine": verdict.met, "verdict": verdict.text}

    def do_mcap(self, message: dict) -> dict:
        from mmcs.view.mcap_file import CsvWriter

        text, last = message["csv"], bool(message.get("last"))
        if message.get("first"):
            self.mcap = CsvWriter(text)
            text = text.partition("\n")[2]
        if self.mcap is None:
            raise ValueError("mcap: the first line is missing")
        writer, self.mcap = self.mcap, None if last else self.mcap
        return {"base64": base64.b64encode(writer.add(text, last)).decode()}

    def do_waves(self, message: dict) -> dict:
        from mmcs.tool.moment import waves

        return waves(self.socket, float(message["t"]), float(message.get("ms", 2.0)))

    # --- experiments ---

    def _alive(self) -> None:
        if self.gone.is_set() or time.monotonic() - self.heard > self.patience_s:
            raise OSError("the page has disconnected; the machine is stopped")

    def _experiment(self, message: dict, work) -> dict:
        """work(probe) with the lease that the page lends; a failure stops the machine."""
        from mmcs.tool.tune import Probe, TuneError, connect

        self.patience_s = float(message.get("deadman_ms", DEADMAN_MS)) / 1000
        with connect(self.socket) as link:
            probe = Probe(link, int(message["axis"]), self._alive)
            self.say({"type": "progress", "lend": link.hello["you"]})
            self._wait_for_lease(link)
            try:
                probe.begin()
                done = work(probe)
            except BaseException as error:
                link.request("stop")
                if isinstance(error, TuneError):
                    raise ValueError(f"{error} (the machine is stopped)") from None
                raise
            finally:
                probe.release()
                self._give_back(link, message)
            return done

    def _wait_for_lease(self, link) -> None:
        since = time.monotonic()
        while True:
            self._alive()
            mine = [
                c for c in link.request("clients")["clients"] if c["client"] == link.hello["you"]
            ]
            if mine and mine[0]["lease"]:
                return
            if time.monotonic() - since > 2.0:
                raise ValueError("the page does not hold the lease")
            time.sleep(0.01)

    def _give_back(self, link, message: dict) -> None:
        try:
            link.request("lease", give=int(message["lender"]))
        except OSError:
            link.request("lease", drop=True)

    def do_tune(self, message: dict) -> dict:
        from mmcs.tool.tune import tune

        wn, zeta = float(message["wn"]), float(message.get("zeta", 1.0))
        half = float(message["half"])
        if half < 100:
            raise ValueError("half: allow at least 100 counts to each side")

        def say(text: str) -> None:
            self.say({"type": "progress", "text": text})

        work = partial(tune, wn=wn, zeta=zeta, half=half, say=say)
        return self._experiment(message, work)

    def do_chirp(self, message: dict) -> dict:
        from mmcs.tool.tune import chirp

        amplitude, seconds = float(message["amplitude"]), float(message.get("seconds", 8.0))
        low, high = float(message["low"]), float(message["high"])
        if not (0.2 <= low < high <= 100 and 1 <= seconds <= 60):
            raise ValueError("chirp: 0.2 Hz <= low < high <= 100 Hz, 1 to 60 s")
        made = self._experiment(message, lambda probe: chirp(probe, amplitude, low, high, seconds))
        return {name: getattr(made, name).tolist()
                for name in ("hz", "gain_db", "phase_deg", "coherence")}  # fmt: skip


def _interval(message: dict) -> float:
    t = float(message["interval_s"])
    if not 1e-4 <= t <= 1.0:
        raise ValueError("interval_s: the driver's is 0.0001 to 1 s")
    return t


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None


if __name__ == "__main__":
    work(Advisor(Path(sys.argv[1])))
