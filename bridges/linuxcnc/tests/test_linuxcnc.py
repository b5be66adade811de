# SPDX-License-Identifier: Apache-2.0
"""Debian's LinuxCNC moves the arm: HAL, driver, RTL, motors, and back; `make linuxcnc-test`.

HAL is one for the whole computer, so these tests run one at a time, and not beside a real LinuxCNC.
"""

from __future__ import annotations

import csv
import fcntl
import math
import os
import shutil
import subprocess
import sys
import tempfile
import time
from contextlib import contextmanager
from pathlib import Path

import pytest

from mmcs import load

HERE = Path(__file__).resolve().parents[1]
ROOT = HERE.parents[1]
REALTIME, MODULE = "/usr/lib/linuxcnc/realtime", Path("/usr/lib/linuxcnc/modules/mmcs.so")
NOBODY = 65534
PATIENCE = 5_000  # looks at a pin, of a machine that may have much else to do
TARGET_DEG = (20.0, -15.0, 15.0, 25.0, -25.0, 30.0)
HELD_OFF = 30  # counts, by friction and gravity: as in puma560_reach
SPEED, ACCELERATION = 25.0, 60.0  # degrees/s, degrees/s^2


def say(*command: str) -> str:
    """Runs a command. Its output goes through a file: the real-time process, which some of these
    leave behind, would hold a pipe open."""
    with tempfile.TemporaryFile("w+") as out:
        code = subprocess.run(command, stdout=out, stderr=out, check=False).returncode
        out.seek(0)
        text = out.read().strip()
    assert code == 0, f"{' '.join(command)}: {text}"
    return text


def halcmd(*words: str) -> str:
    return say("halcmd", *words)


def get(pin: str) -> str:
    return halcmd("getp", pin)


def until(pin: str, value: str) -> None:
    """Waits for a pin: only so many looks."""
    for _ in range(PATIENCE):
        if get(pin) == value:
            return
        assert get("mmcs.lost") == "0", "the machine is gone"
        time.sleep(0.005)
    raise AssertionError(f"{pin} stays {get(pin)}")


def wait_s(seconds: float) -> None:
    """Lets so much of the machine's time pass."""
    end = float(get("mmcs.machine-time")) + seconds
    for _ in range(PATIENCE):
        if float(get("mmcs.machine-time")) > end:
            return
    raise AssertionError("the machine's time stands still")


@pytest.fixture(scope="module")
def folder():
    """Of this session. LinuxCNC refuses to be root, so what root starts is to be nobody."""
    missing = [tool for tool in ("halrun", "halcmd", REALTIME) if not shutil.which(tool)]
    if missing or not MODULE.exists():
        pytest.fail("LinuxCNC, or our component in it, is missing; run: make linuxcnc-test")
    made = Path(tempfile.mkdtemp(prefix="mmcs-hal"))
    if os.getuid() == 0:
        os.chown(made, NOBODY, NOBODY)
        os.environ["RTAPI_UID"] = str(NOBODY)
    os.environ["RTAPI_FIFO_PATH"] = str(made / "fifo")
    with open("/tmp/mmcs-hal.lock", "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        say("halrun", "-U")
        yield made
    shutil.rmtree(made)


class Host:
    """A session of HAL with a machine behind it; `log` is the machine's own, afterwards."""

    def __init__(self, scenario: str, folder: Path, lines: str):
        self.path, self.file = folder / "hal.sock", folder / "machine.csv"
        self.log: list[dict] = []
        command = [sys.executable, str(HERE / "machine.py"), scenario]
        self.machine = subprocess.Popen(
            [*command, "--path", str(self.path), "--log", str(self.file)],
            stdout=subprocess.PIPE, text=True, env=os.environ | {"PYTHONPATH": str(ROOT)},
        )  # fmt: skip
        try:
            assert self.machine.stdout.readline().startswith("mmcs: "), "the machine does not start"
            if os.getuid() == 0:
                self.path.chmod(0o666)
            file = folder / "session.hal"
            file.write_text(lines.replace("loadrt mmcs ", f"loadrt mmcs path={self.path} "))
            say(REALTIME, "start")
            halcmd("-f", str(file))
        except BaseException:
            self.machine.kill()
            raise

    def __enter__(self) -> Host:
        return self

    def __exit__(self, *_) -> None:
        say("halrun", "-U")
        try:
            assert self.machine.wait(timeout=600) == 0
        finally:
            self.machine.kill()
        with self.file.open() as file:
            self.log = list(csv.DictReader(file))


@contextmanager
def sampling(file: Path):
    """halsampler writes down what the thread samples."""
    with file.open("w") as out:
        sampler = subprocess.Popen(["halsampler"], stdout=out)
    try:
        yield
    finally:
        sampler.terminate()
        sampler.wait()


def per_degree(axis: dict) -> float:
    return axis["counts_per_rev"] * axis["gear"] / 360


def switch_on() -> None:
    halcmd("setp", "mmcs.enable", "1")
    until("mmcs.enabled", "TRUE")
    assert get("mmcs.estop-ok-out") == "TRUE"


@pytest.fixture(scope="module")
def moved(folder):
    """Six planners move the arm: what was sampled while the servo was on, the machine's log,
    counts per degree."""
    scale = [per_degree(m) for m in load("puma560_coupled").motors()]
    samples = folder / "samples.txt"
    with Host("puma560_coupled", folder, (HERE / "arm.hal").read_text()) as host:
        for n in range(6):
            halcmd("setp", f"mmcs.scale.{n}", repr(scale[n]))
            halcmd("setp", f"simple-tp.{n}.maxvel", repr(SPEED))
            halcmd("setp", f"simple-tp.{n}.maxaccel", repr(ACCELERATION))
            halcmd("setp", f"simple-tp.{n}.target-pos", repr(TARGET_DEG[n]))
        with sampling(samples):
            halcmd("start")
            switch_on()
            for n, target in enumerate(TARGET_DEG):
                until(f"simple-tp.{n}.current-pos", f"{target:g}")
            wait_s(0.3)
            halcmd("setp", "mmcs.enable", "0")
            until("mmcs.enabled", "FALSE")
            assert get("mmcs.estop-ok-out") == "TRUE", "a stop is no fault"
            assert get("mmcs.lost") == "0"
    rows = [[float(x) for x in line.split()] for line in samples.read_text().splitlines()]
    return [row for row in rows if row[-1]], host.log, scale


@pytest.mark.req("DRV-4", "SRV-1")
def test_the_arm_follows_a_trajectory(moved):
    rows, _, scale = moved
    assert len(rows) > 1500
    for n, target in enumerate(TARGET_DEG):
        following = max(abs(row[n] - row[6 + n]) for row in rows)
        print(f"joint {n + 1}: largest following error {following:.4f} degrees")
        assert following < 0.5, f"joint {n + 1}"
        short = (rows[-1][6 + n] - target) * scale[n]
        assert abs(short) <= HELD_OFF, f"joint {n + 1} stands {short:.0f} counts off"


@pytest.mark.req("DRV-10", "ENC-1")
def test_host_counter_and_physics_agree(moved):
    """What HAL was told, what the counter holds, how the joint stands."""
    rows, log, scale = moved
    for n in range(6):
        seen = {round(row[6 + n] * scale[n]) for row in rows}
        assert len(seen) > 200 and seen <= {int(line[f"count{n}"]) for line in log}
        turned = math.degrees(float(log[-1][f"angle_rad{n}"]) - float(log[0][f"angle_rad{n}"]))
        told = int(log[-1][f"count{n}"]) / scale[n]
        assert abs(turned - told) < 0.05 + 2 * abs(1 / scale[n]), f"joint {n + 1}"


ONE_AXIS = """
loadrt threads name1=servo period1=1000000
loadrt mmcs personality=1
addf mmcs.read servo
addf mmcs.write servo
setp mmcs.estop-ok-in 1
start
"""


@pytest.mark.req("PAN-1", "DRV-6", "DRV-9")
def test_the_stop_chain(folder):
    """The host's contact opens: brakes, amplifier fault, no e-stop loop closed; and on again."""
    with Host("lab500", folder, ONE_AXIS):
        switch_on()
        until("mmcs.brakes-released", "TRUE")
        assert get("mmcs.panic") == "FALSE" and get("mmcs.amp-fault.0") == "FALSE"
        halcmd("setp", "mmcs.estop-ok-in", "0")
        until("mmcs.panic", "TRUE")
        until("mmcs.enabled", "FALSE")
        assert get("mmcs.brakes-released") == get("mmcs.estop-ok-out") == "FALSE"
        halcmd("setp", "mmcs.enable", "0")
        halcmd("setp", "mmcs.estop-ok-in", "1")
        wait_s(0.1)
        switch_on()
        assert get("mmcs.amp-fault.0") == "FALSE"
        halcmd("setp", "mmcs.position-cmd.0", "100")
        until("mmcs.panic", "FALSE")
        wait_s(0.3)
        assert abs(float(get("mmcs.position-fb.0")) - 100) <= 6


@pytest.mark.req("CAL-1", "DRV-8")
def test_index_enable(folder):
    """The axis passes its index: from there on it counts from 0, and index-enable is false."""
    with Host("lab500", folder, ONE_AXIS) as host:
        switch_on()
        halcmd("setp", "mmcs.index-enable.0", "1")
        for target in range(100, 2600, 100):
            if get("mmcs.index-enable.0") == "FALSE":
                break
            halcmd("setp", "mmcs.position-cmd.0", str(target))
            wait_s(0.1)
        assert get("mmcs.index-enable.0") == "FALSE", "a whole turn, and no index"
        halcmd("setp", "mmcs.position-cmd.0", "50")
        wait_s(0.4)
        assert abs(float(get("mmcs.position-fb.0")) - 50) <= 6
        assert get("mmcs.estop-ok-out") == "TRUE"
    # the counter was not touched: only what the host counts from
    turn = load("lab500").motors()[0]["counts_per_rev"]
    offset = load("lab500").motors()[0]["encoder_offset"] / (2 * math.pi) * turn
    end = int(host.log[-1]["count0"])
    assert end == int(host.log[-1]["true_count0"])
    assert abs((end - 50 + offset + turn / 2) % turn - turn / 2) <= 8


@pytest.mark.req("DRV-4", "SRV-6")
def test_velocity_interface(folder, tmp_path):
    """A velocity servo follows counts per second, exact in the mean though its counts are whole."""
    text = f'extends = "{ROOT}/sim/scenarios/basic/lab500.toml"\nexpect = []\nmotion = []\n'
    text += '[[servo]]\naxis = 0\nmode = "velocity"\nflags = ["coulcomp"]\n'
    file = tmp_path / "speed.toml"
    file.write_text(text + "a0 = 60\na1 = 0\nb0 = 1\nilim = 1024\n")
    with Host(str(file), folder, ONE_AXIS):
        switch_on()
        assert get("mmcs.velocity-mode.0") == "TRUE"
        halcmd("setp", "mmcs.velocity-cmd.0", "5250")
        wait_s(0.3)
        begin = float(get("mmcs.machine-time")), float(get("mmcs.position-fb.0"))
        wait_s(1.0)
        end = float(get("mmcs.machine-time")), float(get("mmcs.position-fb.0"))
        speed = (end[1] - begin[1]) / (end[0] - begin[0])
        assert 4500 < speed < 5500, speed
