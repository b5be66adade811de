# SPDX-License-Identifier: Apache-2.0
"""What nobody should do to the server, and what an impostor does to a program."""

import contextlib
import os
import resource
import select
import signal
import socket
import struct
import subprocess
import sys
import threading

import pytest

from mmcs import ROOT, mcdef
from mmcs.device import sockets, wire
from mmcs.device.client import Device
from mmcs.device.execute import check_program, environment
from mmcs.device.link import Link
from mmcs.device.sockets import socket_path
from mmcs.errors import InputError
from mmcs.tests.device_bench import PROGRAMS, SANITIZED, Bench, compile_program, write_scenario
from mmcs.tests.raw import Raw, holding, stop_line


@pytest.fixture
def bench(tmp_path):
    before = signal.signal(signal.SIGUSR1, signal.SIG_IGN)  # the programs are this process
    with Bench(tmp_path) as made:
        yield made
    signal.signal(signal.SIGUSR1, before)


@pytest.fixture
def serving(bench, monkeypatch):
    thread = threading.Thread(target=bench.server.run)
    monkeypatch.setenv("MMCS_SOCKET", str(bench.server.path))
    thread.start()
    yield bench
    bench.server.stopping = True
    thread.join()


def descriptors():
    return len(os.listdir("/proc/self/fd"))


def is_well(bench):
    program = Raw(bench)
    assert program.call(wire.IOCTL, mcdef.MGETNUMCARDS) == (0, b"\1\0\0\0")
    program.close()
    bench.until(lambda: not bench.server.connections)
    assert not bench.server.files and not bench.server.machine.clients
    # every open of the driver's sixteen is free again
    clients = [bench.sim.open(2) for _ in range(16)]
    assert sorted(clients) == list(range(16))
    for client in clients:
        bench.sim.close(client)


# --- the server ---


@pytest.mark.parametrize("name", [b"", b"other"])
@pytest.mark.parametrize("op", [*range(0, 14), 1 << 31])
@pytest.mark.parametrize("size", [0, 1, 3, 4, 5, 8, 300, 65536])
def test_no_request_is_too_odd(attacked, op, size, name):
    """Of every kind and length, for a file that is there and one that is not."""
    bench, program, vme = attacked
    for target, a, b in [
        (program, mcdef.MGETPARAM, 0), (program, (1 << 64) - 1, (1 << 64) - 1),
        (vme, 0x6409, 1), (vme, 0x6409, 2), (vme, 0x6409, 8), (vme, 1 << 63, 1),
    ]:  # fmt: skip
        file = name or target.name
        program._send(program.channel, op, file, a, b, b"\x7f" * size)
        bench.server.step()
        for _ in range(8):
            bench.server.step()
            try:
                data = program.channel.recv(1 << 20)
            except BlockingIOError:
                continue
            break
        assert len(data) >= wire.REPLY.size  # an answer, whatever it is


@pytest.fixture(scope="module")
def attacked(tmp_path_factory):
    before = signal.signal(signal.SIGUSR1, signal.SIG_IGN)
    with Bench(tmp_path_factory.mktemp("attacked")) as bench:
        program, vme = Raw(bench), Raw(bench, device=b"/dev/vme16")
        yield bench, program, vme
        program.close()
        vme.close()
        bench.until(lambda: not bench.server.connections)
        is_well(bench)
    signal.signal(signal.SIGUSR1, before)


def test_a_file_is_opened_once_and_has_a_name(bench):
    program = Raw(bench)
    inode = os.fstat(program.file.fileno()).st_ino
    for _ in range(3):
        program._send(program.channel, wire.OPEN, b"", 2, inode, b"/dev/mc0")
        assert program._answer(program.channel)[0] == 0  # the channel is a file now
        break
    nameless = socket.socket(socket.AF_UNIX)
    nameless.connect(str(bench.server.path))
    nameless.setblocking(False)
    program._send(nameless, wire.OPEN, b"", 2, inode, b"/dev/mc0")
    assert program._answer(nameless)[0] == -22
    nameless.close()
    twice = program._connect()
    message = wire.REQUEST.pack(wire.MAGIC, wire.OPEN, b"", 2, inode, 8, os.getpid()) + b"/dev/mc0"
    twice.sendall(message * 2)
    assert program._answer(twice)[0] == 0
    assert bench.server.machine.opens == 3
    twice.close()
    program.close()
    is_well(bench)


def test_holders_come_and_go_without_leaving_descriptors(bench):
    program = Raw(bench)
    before = descriptors()
    for pid in range(400_000, 401_000):  # as many short-lived children
        program.bench.server.files[program.name].holders.add(pid)
    assert program.call(wire.READ, 56)[0] == 56
    assert descriptors() == before
    program.close()
    is_well(bench)


def test_more_connections_than_are_served(bench):
    bench.server.most = 20
    many = []
    for _ in range(60):
        sock = socket.socket(socket.AF_UNIX)
        sock.connect(str(bench.server.path))
        many.append(sock)
        bench.server.step()
    assert len(bench.server.connections) == 20
    for sock in many:
        sock.close()
    bench.until(lambda: not bench.server.connections)
    is_well(bench)


def test_no_descriptor_is_left(bench):
    """Whoever connects then is turned away; the server and the stop path live."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    many = [socket.socket(socket.AF_UNIX) for _ in range(40)]
    with stop_line(bench) as line:
        bench.server.step()
        for sock in many:
            sock.connect(str(bench.server.path))
        highest = max(map(int, os.listdir("/proc/self/fd")))
        spare = [os.dup(0) for _ in range(highest + 2 - descriptors())]
        resource.setrlimit(resource.RLIMIT_NOFILE, (descriptors(), hard))
        try:
            for _ in range(10):
                bench.server.step()
            line.sendall(b"stop\n")
            bench.server.step()
            assert line.recv(100).startswith(b"stopped")
        finally:
            resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
            for fd in spare:
                os.close(fd)
    for sock in many:
        sock.close()
    bench.until(lambda: not bench.server.connections)
    is_well(bench)


def test_an_end_comes_through_a_request_that_waits(bench):
    """MENABLE would wait for its first SCLOCK, 536 s away."""
    program = Raw(bench)
    assert program.call(wire.IOCTL, mcdef.MSETINTERVAL, struct.pack("<I", 536_000_000))[0] == 0
    looks, genuine = [], bench.server._listen

    def listen(wait):
        looks.append(bench.sim.time)
        if len(looks) == 10:
            bench.server.stopping = True  # as SIGTERM does
        genuine(wait)

    before = bench.sim.time
    bench.server._listen = listen
    assert program.call(wire.IOCTL, mcdef.MENABLE)[0] == -5
    assert bench.sim.time - before < 0.1
    bench.server._listen, bench.server.stopping = genuine, False
    program.close()


def test_others_are_served_while_one_enables(bench):
    program, other = Raw(bench), Raw(bench)
    program._send(program.channel, wire.IOCTL, program.name, mcdef.MENABLE, 0, b"")
    other._send(other.channel, wire.READ, other.name, 56, 0, b"")
    answered = []
    genuine = bench.server._look

    def look():
        result = genuine()
        answered.append(bool(select.select([other.channel], [], [], 0)[0]))
        return result

    bench.sim.set_look(look)
    assert program._answer(program.channel)[0] == 0
    assert answered[-1]
    for raw in (program, other):
        raw.close()


@pytest.mark.req("TOOL-1")
def test_a_monitor_changes_nothing(tmp_path):
    """Every bus cycle, sample and signal is the same with a monitor and a reader of the stream."""

    def run(folder, watched):
        folder.mkdir(mode=0o700)
        with Bench(folder) as bench:
            program = Raw(bench)
            monitor = Raw(bench, os.O_RDONLY) if watched else None
            link = Quiet(bench) if watched else None
            bench.server.pace.paused = True  # time passes as the test says, steps or no steps
            bench.sim.run(0.01)
            holding(bench, program)
            for n in range(40):
                program.call(wire.WRITE, 0, struct.pack("<2i", 5 * n, -5 * n))
                if watched:
                    assert monitor.call(wire.READ, 56)[0] == 56
                    assert monitor.call(wire.IOCTL, mcdef.MGETSTATS)[0] == 0
                    link.drain()
                assert bench.sim.run(0.2 + 0.01 * n)
            return bench.sim.hash(), bench.sim.stats()["bus_cycles"], bench.sim.signals(0)

    before = signal.signal(signal.SIGUSR1, signal.SIG_IGN)
    assert run(tmp_path / "a", watched=False) == run(tmp_path / "b", watched=True)
    signal.signal(signal.SIGUSR1, before)


class Quiet:
    """Follows everything, in the test's own thread."""

    def __init__(self, bench):
        self.sock = socket.socket(socket.AF_UNIX)
        self.sock.connect(str(bench.server.path.with_suffix(".msg")))
        self.sock.setblocking(False)
        text = b'{"id":1,"op":"follow","period_ms":0}'
        self.sock.send(struct.pack("<I", len(text)) + text)

    def drain(self):
        try:
            while self.sock.recv(1 << 20):
                pass
        except BlockingIOError:
            pass


# --- impostors ---


def test_a_socket_of_another_user_is_not_used(serving, monkeypatch):
    monkeypatch.setattr(sockets.os, "geteuid", lambda: 4711)
    for use in (Device, lambda: Link(path=serving.server.path)):
        with pytest.raises(OSError, match="serves this socket, not you"):
            use()


@pytest.mark.req("DRV-4")
def test_a_server_that_lies_writes_nothing_beyond_what_was_asked_for(tmp_path):
    path = tmp_path / "liar.sock"
    lies = [(4000, 28), (0, 200), (28, 4)]
    with socket.socket(socket.AF_UNIX) as door:
        door.bind(str(path))
        door.listen(8)
        told = iter(lies)

        def lie(sock):
            with sock, contextlib.suppress(ConnectionError):
                while head := sock.recv(wire.REQUEST.size, socket.MSG_WAITALL):
                    _, op, _, _, _, length, _ = wire.REQUEST.unpack(head)
                    sock.recv(length, socket.MSG_WAITALL)
                    if op == wire.OPEN:
                        sock.sendall(wire.REPLY.pack(0, 0) + b".")
                    else:
                        result, length = next(told)
                        sock.sendall(wire.REPLY.pack(result, length) + b"\x11" * length)

        def accept():
            for _ in range(1 + 1 + len(lies)):
                try:
                    sock, _ = door.accept()
                except OSError:
                    return
                threading.Thread(target=lie, args=(sock,), daemon=True).start()

        threading.Thread(target=accept, daemon=True).start()
        program = compile_program(PROGRAMS / "bounds.c")
        done = subprocess.run([program], env=environment(path, SANITIZED), capture_output=True,
                              text=True, check=False)  # fmt: skip
    assert done.stdout == "-1 5\n-1 5\n-1 5\ntouched 0\n"


# --- programs ---


@pytest.mark.req("DRV-1", "DRV-4")
def test_the_device_by_every_call_for_files(bench):
    out, status = bench.finish(bench.start(compile_program(PROGRAMS / "files.c")))
    assert (out, status) == ("done\n", 0)


def test_static_and_set_user_id_programs_are_refused_by_name(tmp_path, monkeypatch):
    source = tmp_path / "plain.c"
    source.write_text("int main(void) { return 0; }\n")
    static = tmp_path / "static"
    made = subprocess.run(["gcc", "-static", "-o", static, source], check=False)
    if made.returncode == 0:
        with pytest.raises(InputError, match="statically linked"):
            check_program(str(static))
    plain = tmp_path / "plain"
    subprocess.run(["gcc", "-o", plain, source], check=True)
    check_program(str(plain))
    check_program(sys.executable)
    check_program("there-is-no-such-program")
    plain.chmod(0o4755)
    monkeypatch.setattr("os.geteuid", lambda: 4711)
    with pytest.raises(InputError, match="set-user-id"):
        check_program(str(plain))


@pytest.fixture
def served(tmp_path, monkeypatch):
    """A `mmcs serve` of its own, and the environment of its programs."""
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    command = [sys.executable, "-m", "mmcs", "serve", str(write_scenario(tmp_path))]
    server = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True)
    assert "serving" in server.stdout.readline()
    yield server, environment(socket_path("mc0"), SANITIZED)
    server.send_signal(signal.SIGCONT)
    server.kill()
    server.communicate()


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
    child = subprocess.Popen([sys.executable, "-c", text], env=env, text=True,
                             stdin=subprocess.PIPE, stdout=subprocess.PIPE)  # fmt: skip
    assert child.stdout.readline() == "open\n"
    server.send_signal(signal.SIGSTOP)
    child.stdin.write("\n")
    child.stdin.flush()
    assert child.wait(60) == -signal.SIGALRM
    child.stdin.close()
    child.stdout.close()


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP, signal.SIGINT])
def test_the_server_ends_at_once_and_leaves_nothing(served, number):
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
    child = subprocess.Popen(
        [sys.executable, "-c", text], env=env, text=True, stdout=subprocess.PIPE, cwd=ROOT
    )
    assert child.stdout.readline() == "open\n"
    server.send_signal(number)
    assert server.wait(60) == 0
    child.wait(60)
    child.stdout.close()
    folder = socket_path("mc0").parent
    assert [p.name for p in folder.iterdir()] == ["mc0.lock"]


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_exec_passes_an_end_on_and_leaves_nothing(tmp_path, monkeypatch, number):
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    command = [sys.executable, "-m", "mmcs", "exec", "--scenario", str(write_scenario(tmp_path)),
               "--", "sh", "-c", "echo $$; exec sleep 1000"]  # fmt: skip
    runner = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True)
    pid = int(runner.stdout.readline())
    runner.send_signal(number)
    assert runner.wait(60) == 128 + number
    runner.stdout.close()
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)
    folder = socket_path("mc0").parent
    assert all(p.suffix == ".lock" for p in folder.iterdir())


# --- mmcs.Device ---


def test_calls_from_threads_and_handlers_do_not_mix(serving):
    """A handler calls while the call that it interrupts is under way; threads do as they like."""
    wrong, rounds = [], [0]
    with Device() as dev:

        def handler(*_):
            rounds[0] += 1
            if dev.interval() != 2000:
                wrong.append("interval")

        def states():
            while rounds[0] < 200:
                if len(dev.read()) != 2:
                    wrong.append("read")

        before = signal.signal(signal.SIGALRM, handler)
        signal.setitimer(signal.ITIMER_REAL, 0.001, 0.001)
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


@pytest.mark.parametrize(
    "call",
    [
        lambda d: d.set_dac(0, 5000), lambda d: d.set_dac(256, 0), lambda d: d.set_dac(-1, 0),
        lambda d: d.set_encoder(256, 0), lambda d: d.set_encoder(0, 65536),
        lambda d: d.set_encoder(0, 1.5), lambda d: d.write([1.5]), lambda d: d.write(["1"]),
        lambda d: d.write([1 << 31]), lambda d: d.write([0] * 40), lambda d: d.set_leds(300, 1),
        lambda d: d.calibrate(-1), lambda d: d.set_num_joints(None), lambda d: d.read(-1),
        lambda d: d.set_interval(-5), lambda d: d.get_param(2), lambda d: d.get_param("0"),
        lambda d: d.set_param(0, {"a7": 1}), lambda d: d.set_param(0, {"a0": 1e9}),
        lambda d: d.change_param(0, which=1), lambda d: d.change_param(0, b0=0),
        lambda d: d.write([0] * 100_000),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_einval(serving, call):
    with Device() as dev, pytest.raises(OSError) as no:
        call(dev)
    assert no.value.errno == 22


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
    done = subprocess.run([sys.executable, "-c", text], env=env, cwd=ROOT, text=True,
                          capture_output=True, check=False)  # fmt: skip
    assert (done.stdout, done.returncode) == ("lives\n", 0), done.stderr
