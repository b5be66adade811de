# SPDX-License-Identifier: Apache-2.0
"""Programs in C and Python: every call for files, signals to end, alarms, threads, handlers."""

import contextlib
import os
import re
import shutil
import signal
import subprocess
import sys
import threading

import pytest

from mmcs import ROOT, mcdef
from mmcs.device import execute
from mmcs.device.client import Device
from mmcs.device.execute import check_program, environment
from mmcs.device.link import Link
from mmcs.errors import InputError
from mmcs.tests.conftest import call, good
from mmcs.tests.device_bench import PROGRAMS, SANITIZED, compile_program, write_scenario
from tools.compiled import CompileError, compiled, ran, written

# --- programs ---


@pytest.mark.req("DRV-1", "DRV-2", "DRV-3", "DRV-4")
def test_the_device_by_every_call_for_files(unsignalled, bench):
    out, status = bench.finish(bench.start(compile_program(PROGRAMS / "files.c")))
    assert (out, status) == ("done\n", 0)


def test_static_programs_are_refused_by_name(tmp_path):
    source = written("plain.c", "int main(void) { return 0; }\n")
    with contextlib.suppress(CompileError):  # no static library of C here
        static = compiled("static", ["gcc", "-static"], [source])
        with pytest.raises(InputError, match="statically linked"):
            check_program(str(static))
    plain = tmp_path / "plain"
    shutil.copy(compiled("plain", ["gcc"], [source]), plain)
    check_program(str(plain))
    check_program(sys.executable)
    check_program("there-is-no-such-program")


@pytest.fixture
def served(mc0, tmp_path, request):
    """A `mmcs serve` of its own, and the environment of its programs."""
    env = environment(mc0, SANITIZED)  # first: nothing may end this with a server
    scenario = write_scenario(tmp_path)
    if getattr(request, "param", "") == "compiled":
        good(call("compile", scenario, "-o", tmp_path / "own.bin"))
        scenario = tmp_path / "own.bin"
    # Tests in the background or under nohup ignore some signals, and their children inherit that.
    command = ["env", "--default-signal=INT,HUP", sys.executable, "-m", "mmcs", "serve",
               str(scenario)]  # fmt: skip
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True) as server:
        try:
            assert "serving" in server.stdout.readline()
            yield server, env
        finally:
            server.kill()


def started(text, env):
    """A program that has said that it has the device open."""
    child = subprocess.Popen([sys.executable, "-c", text], env=env, text=True, cwd=ROOT,
                             stdin=subprocess.PIPE, stdout=subprocess.PIPE)  # fmt: skip
    assert child.stdout.readline() == "open\n"
    return child


@pytest.mark.parametrize("served", ["scenario", "compiled"], indirect=True)
def test_an_alarm_comes_through_when_the_server_is_stopped(served):
    server, env = served
    text = """
import os, signal
fd = os.open("/dev/mc0", os.O_RDWR)
print("open", flush=True)
input()
signal.setitimer(signal.ITIMER_REAL, 0.01)
os.read(fd, 56)
"""
    with started(text, env) as child:
        server.send_signal(signal.SIGSTOP)
        child.stdin.write("\n")
        child.stdin.flush()
        assert child.wait(60) == -signal.SIGALRM


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP, signal.SIGINT])
def test_the_server_ends_at_once_and_leaves_nothing(served, mc0, number):
    """Also while programs enable again and again at an interval of minutes."""
    server, env = served
    text = """
import fcntl, os, struct
from mmcs import mcdef
fd = os.open("/dev/mc0", os.O_RDWR)
fcntl.ioctl(fd, mcdef.MSETINTERVAL, struct.pack("I", 500_000_000))
print("open", flush=True)
while True:
    try:
        fcntl.ioctl(fd, mcdef.MENABLE)
    except OSError as error:
        pass
    if not os.path.exists(os.environ["MMCS_SOCKET"]):
        break
"""
    with started(text, env) as child:
        server.send_signal(number)
        assert server.wait(60) == 0
        child.wait(60)
    assert not list(mc0.parent.iterdir())


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_exec_passes_an_end_on_and_leaves_nothing(mc0, tmp_path, number):
    command = [sys.executable, "-m", "mmcs", "exec", "--scenario", str(write_scenario(tmp_path)),
               "--", "sh", "-c", "echo $$; exec sleep 1000"]  # fmt: skip
    runner = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True)
    pid = int(runner.stdout.readline())
    runner.send_signal(number)
    assert runner.wait(60) == 128 + number
    runner.stdout.close()
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)
    assert not list(mc0.parent.iterdir())


@pytest.mark.parametrize("early", [True, False])
def test_a_program_ends_with_what_runs_it(tmp_path, monkeypatch, early):
    """By a signal that comes before the program does, and by an error while it runs."""
    told, start, begun = tmp_path / "pid", execute._start, []
    program = ["sh", "-c", f"echo $$ > {told}; exec sleep 1000"]
    handler = signal.getsignal(signal.SIGTERM)

    def starting(*given):
        if early:
            os.kill(os.getpid(), signal.SIGTERM)
        begun.append(start(*given))
        return begun[0]

    def step():
        if not early and told.exists() and told.read_text():
            raise BlockingIOError

    monkeypatch.setattr(execute, "_start", starting)
    with contextlib.nullcontext() if early else pytest.raises(BlockingIOError):
        assert execute._run(program, dict(os.environ), step) == 128 + signal.SIGTERM
    assert begun[0].returncode == -(signal.SIGTERM if early else signal.SIGKILL)
    assert signal.getsignal(signal.SIGTERM) == handler


@pytest.mark.req("DRV-5")
def test_what_the_driver_says_reaches_those_who_run_programs(served):
    """At a server that runs elsewhere, up to the last line before the program ended."""
    _, env = served
    text = """
import fcntl, os, struct
from mmcs import mcdef
fd = os.open("/dev/mc0", os.O_RDWR)
fcntl.ioctl(fd, mcdef.MSETVERBOSITY, struct.pack("i", mcdef.M_VERBOSE))
fcntl.ioctl(fd, mcdef.MENABLE)
fcntl.ioctl(fd, mcdef.MSTOP)
"""
    done = ran(sys.executable, "-m", "mmcs", "exec", "--", sys.executable, "-c", text)
    assert (done.stdout, done.returncode) == ("", 0)
    assert done.stderr.splitlines() == ["mc: cards: 1", "mc: enabled, axes: 2", "mc: stopped"]


def test_a_server_that_does_not_answer_is_told_and_not_waited_for(served, monkeypatch):
    """Stopped while the program runs, and before it."""
    server, _ = served
    monkeypatch.setattr(Link.__init__, "__defaults__", ("mc0", None, 0.2))
    monkeypatch.setattr(execute, "FAREWELL_S", 0.01)
    try:
        assert execute.run_program(["sh", "-c", f"kill -STOP {server.pid}"]) == 0
        with pytest.raises(InputError, match="the server mc0 does not answer"):
            execute.run_program(["true"])
    finally:
        server.send_signal(signal.SIGCONT)


# --- mmcs.Device ---


def test_calls_from_threads_and_handlers_do_not_mix(serving):
    """A handler calls while the call that it interrupts is under way; threads do as they like."""
    wrong, rounds = [], [0]
    with Device() as dev:

        def handler(*_):
            rounds[0] += 1
            if dev.interval() != 2000:
                wrong.append("interval")
            if rounds[0] < 200:
                signal.setitimer(signal.ITIMER_REAL, 0.001)

        def states():
            while rounds[0] < 200:
                if len(dev.read()) != 2:
                    wrong.append("read")

        before = signal.signal(signal.SIGALRM, handler)
        signal.setitimer(signal.ITIMER_REAL, 0.001)
        threads = [threading.Thread(target=states) for _ in range(3)]
        for thread in threads:
            thread.start()
        while rounds[0] < 200:
            if dev.get_param(1)["which"] != 1:
                wrong.append("param")
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
        for thread in threads:
            thread.join()
    assert not wrong


def test_ctrl_c_in_a_call_harms_no_later_one(serving):
    class Enough(BaseException):
        pass

    def handler(*_):
        raise Enough

    before = signal.signal(signal.SIGALRM, handler)
    with Device() as dev:
        for n in range(100):
            try:
                signal.setitimer(signal.ITIMER_REAL, 0.0002 * (n % 7 + 1))
                while True:
                    dev.read()
            except Enough:
                pass
            assert dev.num_cards() == 1 and dev.interval() == 2000
    signal.signal(signal.SIGALRM, before)


def test_each_call_is_its_request(serving, monkeypatch):
    made = []
    with Device() as dev:
        monkeypatch.setattr(dev, "ioctl", lambda code, data=b"": made.append((code, data.hex())))
        dev.set_dac(1, 0xABC), dev.set_encoder(2, -2), dev.set_leds(3, 1), dev.calibrate(4)
        dev.end_calibration(5), dev.set_dac_mode(True), dev.set_diag_mode(3), dev.take_lease()
        dev.set_verbosity(2), dev.drop_lease(), dev.zero_stats(), dev.clear_error()
    want = """MSETDAC=01bc0a00 MSETENC=02feff00 MSETLED=03010000 MCALIB=04000000 MCALIBEND=05000000
        MDACMODE=01000000 MDIAGMODE=03000000 MLEASE=01000000 MSETVERBOSITY=02000000 MLEASE=00000000
        MZEROSTATS= MCLEARERROR="""
    assert made == [(getattr(mcdef, n), v) for n, _, v in (w.partition("=") for w in want.split())]


def test_a_python_process_without_a_handler_lives(served):
    """Its axis is outside its limits: SIGUSR1 would end it."""
    _, env = served
    text = """
import mmcs
from mmcs import mcdef as mc
with mmcs.Device() as dev:
    dev.change_param(0, mode=mc.MD_POS | mc.POSCHK | mc.SOFTERR, plo=100, phi=200)
    dev.enable()
    while not dev.read()[0].errcode:
        pass
print("lives")
"""
    done = ran(sys.executable, "-c", text, env=env)
    assert (done.stdout, done.returncode) == ("lives\n", 0), done.stderr


def test_nobody_serves(tmp_path, monkeypatch):
    monkeypatch.setenv("MMCS_SOCKET", str(tmp_path / "none"))
    with pytest.raises(OSError, match="mmcs serve"):
        Device()


def test_example_of_the_manual(serving, capsys):
    text = (ROOT / "docs" / "use" / "device.md").read_text()
    exec(re.search(r"```python\n(.*?)```", text, flags=re.S)[1], {})
    # however long it looked away: undamped, it comes to twice the step at most
    assert abs(int(capsys.readouterr().out)) <= 400
