# SPDX-License-Identifier: Apache-2.0
# Length: each rule has a small program of its own, which stands in its test.
"""Lock-step: time passes only while every attached program waits, so that programs repeat."""

import os
import signal
import subprocess
import sys

import pytest

from mmcs.device.execute import environment
from mmcs.device.programs import Program
from mmcs.device.wire import MWAIT
from mmcs.tests.device_bench import (
    EXAMPLES,
    PORT,
    PROGRAMS,
    ROBOT,
    compile_example,
    compile_program,
    lockstep_server,
    output_in_lockstep,
)
from tools.compiled import written

PYTHON = (sys.executable, "-c")


@pytest.mark.req("DRV-4")
def test_every_wait_takes_its_time_of_the_machine(tmp_path):
    program = compile_program(PROGRAMS / "waits.c")
    (said, status, _), again = (output_in_lockstep(tmp_path, program) for _ in range(2))
    assert status == 0 and again[0] == said
    first, *lines = said.splitlines()
    assert first == "begin 599616000 599616000 0"
    took = [tuple(map(int, line.split()[-2:])) for line in lines if "runs out" not in line]
    expected = [
        (0, 1500), (0, 5000), (0, 5000), (0, 500), (0, 1_000_000), (0, 5000), (0, 4000), (0, 5000),
        (0, 3000), (0, 5000), (0, 6000), (0, 0),
        (-1, 2000), (-1, 1_000_000), (-1, 2000), (0, 2000), (14, 2000), (-1, 5000),
        (-1, 1000), (-1, 3000), (1, 1000), (8, 0), (8, 2500),
        (0, 2900), (0, 1000), (110, 1000), (0, 1000), (-1, 1000), (0, 0), (0, 4000),
        (1, 8000), (1, 0), (0, 250_000), (0, 9000),
        (1, 2000), (1, 2000), (1, 2000), (1, 2000), (1, 2000), (1, 2000), (0, 6000),
        (110, 1000), (110, 1000), (0, 900), (0, 2000), (110, 1000), (-1, 1000),
        (-1, 2000), (-1, 0), (1, 2000), (1, 2000), (-1, 1000), (1, 1000), (2700, 0), (3e6, 0),
        (3e6, 0), (-1, 0), (0, 0), (2000, 0), (0, 0), (14, 10), (-1, 2000), (-1, 0), (-1, 0),
        (2, 5e5), (-1, 0), (60, 0), (600, 0), (2600, 0), (0, 0), (-1, 0), (0, 0), (1, 0), (35, 0),
    ]  # fmt: skip
    assert "runs out 3" in said
    for got, want in zip(took, expected, strict=True):
        assert got[0] == want[0] and abs(got[1] - want[1]) <= 1, (got, want)


PAIR = """
import os, select, signal, sys, time
import mmcs
from mmcs import mcdef as mc
said, ends = [], os.pipe()
[os.set_blocking(end, False) for end in ends]
signal.set_wakeup_fd(ends[1])
signal.signal(signal.SIGUSR1, lambda *_: said.append(round(time.monotonic(), 6)))
name = sys.argv[1] if len(sys.argv) > 1 else "a"
with mmcs.Device() as dev:
    if name == "a" and os.fork() == 0:
        name = "b"
        inherited, dev = dev, mmcs.Device()  # of its own: signals come to it by that
        inherited.close()
    for turn in range(20):
        number = dev.wait()
        print(name, number, round(time.monotonic(), 6), flush=True)
        if name == "b" and turn % 3 == 0:
            time.sleep(0.0025)
        if name == "a" and turn == 7:
            dev.set_param(0, {**dev.get_param(0), "mode": mc.MD_VEL | mc.POSCHK | mc.SOFTERR,
                              "plo": 5, "phi": 9})
            dev.enable()
            select.select(ends[:1], [], [])  # until the signal comes
print(name, said)
if name == "a":
    os.wait()
"""


def test_several_processes_have_an_order(tmp_path):
    """Who sleeps, who waits for samples, who is signalled: the same to the bit, each time."""
    runs = {output_in_lockstep(tmp_path, *PYTHON, PAIR) for _ in range(3)}
    ((text, status, _),) = runs
    assert status == 0
    lines = [line.split() for line in text.splitlines()]
    rows = [(who, int(number)) for who, number, *rest in lines if number.isdigit()]
    assert len(rows) == 40
    # both see a sample in the same order, the parent first
    shared = {n for who, n in rows if who == "a"} & {n for who, n in rows if who == "b"}
    assert len(shared) > 10
    for number in shared:
        assert rows.index(("a", number)) < rows.index(("b", number))
    heard = [line for line in text.splitlines() if line.startswith(("a [", "b ["))]
    assert len(heard) == 2 and heard[0][2:] == heard[1][2:] != "[]"


def test_a_pipe_between_programs(tmp_path):
    """Who reads it waits for who writes, who sleeps; stdio at both ends."""
    tail = "import sys, time\nfor s in sys.stdin: print(s.strip(), round(time.time() % 60, 6))"
    head = "import time; [(time.sleep(0.01), print(n, flush=True)) for n in range(5)]"
    command = f"{sys.executable} -c '{head}' | {sys.executable} -c '{tail}'"
    for _ in range(2):
        said, status, _ = output_in_lockstep(tmp_path, "sh", "-c", command)
        rows = [line.split() for line in said.splitlines()]
        assert status == 0 and rows == [[str(n), f"{(n + 1) / 100:g}"] for n in range(5)]


# What is written is more than a pipe holds, and read a little at each sample.
FULL = """
import os, socket, time
import mmcs
for ends in (os.pipe(), [s.detach() for s in socket.socketpair()]):
    reads, writes = ends
    if os.fork() == 0:
        os.close(writes)
        got = 0
        with mmcs.Device(flags=os.O_RDONLY) as dev:
            while data := os.read(reads, 10000):
                got += len(data)
                dev.wait()
        print("read", got, flush=True)
        os._exit(0)
    os.close(reads)
    print(os.write(writes, bytes(300000)), round(time.monotonic(), 6), flush=True)
    os.close(writes)
    os.wait()
"""
POOL = """
import multiprocessing, time
import mmcs
def square(n):
    time.sleep(0.001 * (n % 3))
    return n * n
def other(queue, event, dev):
    [queue.put(dev.wait()) for n in range(5)]
    event.set()
with mmcs.Device(flags=0) as dev, multiprocessing.Pool(3) as pool:
    print(pool.map(square, range(20)), dev.wait())
    queue, event = multiprocessing.Queue(), multiprocessing.Event()
    child = multiprocessing.Process(target=other, args=(queue, event, dev))
    child.start()
    print([queue.get() for n in range(5)])
    event.wait(), child.join()
    lock = multiprocessing.Lock()
    lock.acquire()
    print(lock.acquire(timeout=0.005), dev.wait())
"""
# A loop that asks and does not wait.
ASKS = """
import os, select, time
for ask in (lambda: select.select([reads], [], [], 0)[0], lambda: poll.poll(0),
            lambda: epoll.poll(0)):
    reads, writes = os.pipe()
    poll, epoll = select.poll(), select.epoll()
    poll.register(reads), epoll.register(reads, select.EPOLLIN)
    if os.fork() == 0:
        time.sleep(0.01), os.write(writes, b"x"), os._exit(0)
    while not ask():
        pass
    print(round(time.monotonic(), 6))
    os.wait()
"""
# A program ends with all of its threads, whichever the kernel ends first.
ENDS = """
import os, threading, time
lock = threading.Lock()
lock.acquire()
for n in range(20):
    if os.fork() == 0:
        for n in range(5):
            threading.Thread(target=lock.acquire, daemon=True).start()
        time.sleep(0.001)
        os._exit(0)
    os.wait()
print(round(time.monotonic(), 6))
"""


@pytest.mark.parametrize("text, last", [
    (FULL, "read 300000"), (POOL, "False 11"), (ASKS, "0.03"), (ENDS, "0.02"),
], ids=["full", "pool", "asks", "ends"])  # fmt: skip
def test_pipes_pools_polls_and_ends(text, last, tmp_path):
    runs = {output_in_lockstep(tmp_path, *PYTHON, text) for _ in range(2)}
    (said, status, _), *others = runs
    assert status == 0 and not others and said.splitlines()[-1] == last, runs


THREADS = """
#include <pthread.h>
#include <stdio.h>
#include <unistd.h>
static void *run(void *number) {
  for (int turn = 0; turn < 3; turn++) {
    usleep(1000);
    printf("%ld ", (long)number);
  }
  return NULL;
}
int main(void) {
  pthread_t thread[12];
  for (long n = 0; n < 12; n++) pthread_create(&thread[n], NULL, run, (void *)n);
  for (int n = 0; n < 12; n++) pthread_join(thread[n], NULL);
  return 0;
}
"""


def test_threads_run_in_the_order_of_their_creation(tmp_path):
    """Not in that in which the computer began them."""
    program = compile_program(written("threads_in_order.c", THREADS))
    said, status, _ = output_in_lockstep(tmp_path, program)
    assert status == 0 and said.split() == 3 * [str(n) for n in range(12)]


# Without pwm_card.c, whose card no other scenario has (test_own_card.py).
EXAMPLES_RUN = [PORT, *sorted(p for p in EXAMPLES.iterdir() if p.suffix in (".c", ".py") and
                              p.stem != "pwm_card")]  # fmt: skip


def example(path):
    if path.suffix == ".py":
        return [sys.executable, path, *([ROBOT] if path.stem == "move" else [])]
    return [compile_example(path)]


@pytest.mark.parametrize("text, why", [
    ("import os; BEGUN; os.read(0, 1)", "waits for the outside world"),
    ("import sys; BEGUN; sys.stdin.readline()", "waits for the outside world"),
    ("import select; BEGUN; select.select([0], [], [])", "waits for the outside world"),
    ("import socket; s = socket.socket(); s.bind(('127.0.0.1', 0)); s.listen(); BEGUN; s.accept()",
     "waits for the outside world"),
    ("import os; r, w = os.pipe(); BEGUN; os.wait() if os.fork() else (os.close(w), os.read(r, 1))",
     "waits for the outside world"),
    ("BEGUN\nwhile True: pass", "without a call that waits"),
    ("import mmcs; d = mmcs.Device(); BEGUN\nwhile 1: d.write([0])", "without a call that waits"),
])  # fmt: skip
def test_who_never_waits_for_the_machine_is_told_of(text, why, tmp_path):
    here, there = os.pipe()  # that nobody attached has
    said, begun = [], tmp_path / "begun"
    text = text.replace("BEGUN", f"open({str(begun)!r}, 'w').close()")
    with lockstep_server(tmp_path, console=said.append) as server:
        env = environment(server.path, lockstep=True)
        child = subprocess.Popen([*PYTHON, text], env=env, stdin=here)
        server.lockstep.now.silent_s = server.lockstep.now.outside_s = 600  # while Python begins
        try:
            server.lockstep.expect(child.pid)
            while not begun.exists() and child.poll() is None:
                server.step()
            server.lockstep.now.silent_s, server.lockstep.now.outside_s = 2, 0.1
            while not any("lock-step" in line for line in said) and child.poll() is None:
                server.step()
            stood = server.sim.clock
            for _ in range(3):
                server.step()
            assert child.poll() is None
            assert server.sim.clock - stood < 1e4
        finally:
            child.kill()
            child.wait()
            os.close(here)
            os.close(there)
    assert len([line for line in said if why in line]) == 1, said
    assert "machine time stands still" in said[-1]


# What a program of 1989 does, that knows of no MWAIT.
POLLING = """
#include <fcntl.h>
#include <stdio.h>
#include <sys/ioctl.h>
#include <time.h>
#include <unistd.h>
#include "mcdef.h"
int main(void) {
  struct mc_stats stats;
  struct mc_state state;
  struct timespec began, now;
  int fd = open("/dev/mc0", O_RDWR), zero = 0, turns;
  ioctl(fd, MENABLE, &zero);
  ioctl(fd, MZEROSTATS, &zero);
  clock_gettime(CLOCK_MONOTONIC, &began);
  do ioctl(fd, MGETSTATS, &stats);
  while (stats.total < 20);
  for (turns = 0; turns < 250; turns++)
    if (read(fd, &state, sizeof state) != sizeof state) return 1;
  clock_gettime(CLOCK_MONOTONIC, &now);
  printf("%d %ld\\n", stats.total, (now.tv_nsec - began.tv_nsec) / 1000);
  return 0;
}
"""


@pytest.mark.req("DRV-4")
def test_a_loop_of_calls_that_see_nothing_new_lets_time_pass(tmp_path, monkeypatch):
    """As a loop of poll() does: every hundredth takes 100 us. The same each time, and of some
    40,000 calls the server gets the first of each hundred."""
    serve, calls = Program.serve, []
    monkeypatch.setattr(Program, "serve", lambda *a: calls.append(1) or serve(*a))
    program = compile_program(written("polling.c", POLLING))
    runs = {output_in_lockstep(tmp_path, program) for _ in range(3)}
    assert 3 * 380 < len(calls) < 3 * 440
    ((said, status, _),) = runs
    assert status == 0 and said.split()[0] == "20" and 38_000 < int(said.split()[1]) < 41_000


# A handler installed with SA_RESTART, and one without; the alarm comes in the middle of each wait.
RESTARTS = """
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <semaphore.h>
#include <signal.h>
#include <stdio.h>
#include <sys/ioctl.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>
#include <sys/mmcs.h>
#include "mcdef.h"
static volatile int rang;
static void ring(int number) { rang += number == SIGALRM; }
int main(void) {
  int fd = open("/dev/mc0", O_RDWR), zero = 0, us = 20000, number;
  sem_t none;
  sem_init(&none, 0, 0);
  ioctl(fd, MSETINTERVAL, &us);
  ioctl(fd, MENABLE, &zero);
  for (int flags = SA_RESTART; flags >= 0; flags -= SA_RESTART) {
    struct sigaction action = {.sa_handler = ring, .sa_flags = flags};
    struct itimerval soon = {.it_value = {0, 1000}};
    struct timespec until;
    sigaction(SIGALRM, &action, NULL);
    rang = 0;
    setitimer(ITIMER_REAL, &soon, NULL);
    int result = ioctl(fd, MWAIT, &number);
    printf("%d %d ", result, result < 0 ? errno : 0);
    fflush(stdout);
    const pid_t child = fork();
    if (child == 0) return usleep(5000);
    setitimer(ITIMER_REAL, &soon, NULL);
    result = waitpid(child, NULL, 0) == child;
    printf("%d %d ", result, result ? 0 : errno);
    if (!result) waitpid(child, NULL, 0);
    setitimer(ITIMER_REAL, &soon, NULL);
    clock_gettime(CLOCK_REALTIME, &until);
    until.tv_sec++;
    result = sem_timedwait(&none, &until);
    printf("%d %d %d ", result, errno == EINTR, rang);
    setitimer(ITIMER_REAL, &soon, NULL);
    for (int n = 0; rang < 4 && n < 5000; n++) ioctl(fd, MSETINTERVAL, &us);
    printf("%d\\n", rang);
    fflush(stdout);
  }
  return 0;
}
"""


@pytest.mark.req("DRV-4")
def test_waits_go_on_under_sa_restart(tmp_path):
    program = compile_program(written("restarts.c", RESTARTS))
    said, status, _ = output_in_lockstep(tmp_path, program)
    assert status == 0 and said.splitlines() == ["0 0 1 0 -1 0 3 4", "-1 4 0 4 -1 1 3 4"]


LOCKS = """
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>
static pthread_mutex_t a = PTHREAD_MUTEX_INITIALIZER, b = PTHREAD_MUTEX_INITIALIZER;
static void *crossed(void *unused) {
  pthread_mutex_lock(&b);
  usleep(1000);
  pthread_mutex_lock(&a);
  return unused;
}
static void *goes_on(void *unused) {
  usleep(20000);
  for (puts("ready"), fflush(stdout);;) usleep(1000);
  return unused;
}
int main(int count, char **words) {
  pthread_t thread;
  open("/dev/mc0", O_RDWR);
  if (count > 1 && strcmp(words[1], "stops") == 0) raise(SIGSTOP);
  if (count > 1) {
    pthread_create(&thread, NULL, goes_on, NULL);
    pthread_exit(NULL);
  }
  pthread_mutex_lock(&a);
  pthread_create(&thread, NULL, crossed, NULL);
  usleep(5000);
  pthread_mutex_lock(&b);
  return 0;
}
"""
LOCKS_IN_PYTHON = """
import threading
lock = threading.Lock()
lock.acquire()
threading.Thread(target=lock.acquire, daemon=True).start()
lock.acquire()
"""


NESTED = """
#include <fcntl.h>
#include <mcdef.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <sys/mmcs.h>
#include <sys/wait.h>
#include <unistd.h>
extern char **environ;
int ioctl(int, unsigned long, ...), came;
static void interrupted(int number) { usleep(3000), came += number == SIGINT; }
int main(int count, char **words) {
  int number, child, other = getpid(), fd = open("/dev/mc0", O_RDWR);
  ioctl(fd, MENABLE);
  for (int restarts = 0; restarts < 2; restarts++) {
    signal(SIGINT, interrupted), siginterrupt(SIGINT, !restarts);
    if (fork() == 0) {
      for (int n = 0; n < 5; n++) usleep(5100), kill(other, SIGINT);
      _exit(0);
    }
    for (int n = 0; n < 40; n++) ioctl(fd, MWAIT, &number);
    if (wait(NULL) < 0 || posix_spawnp(&child, "sleep", NULL, NULL, words, environ)) return 1;
    printf("%d %d\\n", came, waitid(P_PID, (id_t)child, NULL, WEXITED));
  }
}
"""


def test_a_handler_waits_while_its_program_waits(tmp_path):
    program = compile_program(written("nested.c", NESTED)), "0.02"
    assert {output_in_lockstep(tmp_path, *program)[:2] for _ in range(3)} == {("5 0\n10 0\n", 0)}


def test_a_cancelled_thread_has_its_mutex(tmp_path):
    """Sixty times: the first cancellation of a process takes long."""
    often = f"for n in $(seq 60); do {compile_program(PROGRAMS / 'cancels.c')}; done"
    assert output_in_lockstep(tmp_path, "sh", "-c", often)[:2] == (120 * "1 1\n", 0)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=["Ctrl-C", "SIGTERM"])
@pytest.mark.parametrize("what", ["crossed", "python", "stops", "main has ended"])
def test_every_program_can_be_ended(what, number, tmp_path):
    """Ctrl-C goes to all of the terminal's processes, SIGTERM to mmcs. And it is said that threads
    wait for each other."""
    program = compile_program(written("locks.c", LOCKS))
    words = {"crossed": [program], "python": [*PYTHON, LOCKS_IN_PYTHON]}.get(what, [program, what])
    command = [sys.executable, "-m", "mmcs", "exec", "--lockstep", "--scenario", "lab500", "--"]
    child = subprocess.Popen([*command, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                             text=True, start_new_session=True)  # fmt: skip
    try:
        if what == "main has ended":
            assert child.stdout.readline() == "ready\n"
        elif what == "stops":
            while "T" not in subprocess.run(
                ["ps", "-o", "stat=", "-s", str(child.pid)], capture_output=True, text=True,
                check=False).stdout:  # fmt: skip
                assert child.poll() is None
        else:
            lines = iter(child.stderr.readline, "")
            assert any("its threads wait for each other" in line for line in lines)
        (os.killpg if number == signal.SIGINT else os.kill)(child.pid, number)
        assert child.wait() == 128 + number
    finally:
        child.kill()
        child.communicate()


def test_mwait_without_lockstep(bench):
    text = f"""
import array, asyncio, fcntl, os
import mmcs
fd = os.open("/dev/mc0", os.O_RDWR)
seen = []
for n in range(10):
    number = array.array("I", [0])
    fcntl.ioctl(fd, {MWAIT}, number)
    seen.append(number[0])
with mmcs.Device() as dev:
    seen += [dev.wait() for n in range(10)]
    async def some():
        return [await dev.next_sample() for n in range(10)]
    seen += asyncio.run(some())
assert seen == sorted(set(seen)), seen
print(seen[-1] - seen[0])
"""
    out, status = bench.finish(bench.python(text))
    assert status == 0 and int(out) >= 29, out
