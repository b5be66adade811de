# SPDX-License-Identifier: Apache-2.0
"""C programs that hold their own machine: output of `mmcs exec --lockstep`, a breakpoint in the
servo, and what is for the server."""

import os
import shutil
import subprocess
import sys

import pytest

from mmcs import ROOT
from tools.compiled import compiled, ran, written

EXAMPLES = ROOT / "firmware" / "examples"
OLD = ["-std=gnu89", "-w"]  # of a program of 1989
FOR_THE_SERVER = {
    "threads": """
#include <pthread.h>
static void *body(void *arg) { return arg; }
int main(void) {
  pthread_t thread;
  return pthread_create(&thread, 0, body, 0);
}
""",
    "timers": """
#include <sys/time.h>
int main(void) {
  struct itimerval every = {{1, 0}, {1, 0}};
  return setitimer(ITIMER_REAL, &every, 0);
}
""",
}
# An axis is outside its limits while SIGUSR1 is blocked but for the wait: from then on, or before.
SUSPENDED = """
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <sys/ioctl.h>
#include <unistd.h>
#include "mcdef.h"
static int came;
static void limit(int number) { came++; (void)number; }
int main(void) {
  sigset_t blocked, none, after;
  struct mc_param param = {.which = 0};
  int fd = open("/dev/mc0", O_RDWR);
  signal(SIGUSR1, limit);
  sigemptyset(&none), sigemptyset(&blocked), sigaddset(&blocked, SIGUSR1);
  sigprocmask(SIG_BLOCK, &blocked, NULL);
  if (ioctl(fd, MENABLE, NULL) < 0 || ioctl(fd, MGETPARAM, &param) < 0) return 1;
  for (int pending = 0; pending < 2; pending++) {
    param.mode = POSCHK | SOFTERR, param.plo = 100;
    if (ioctl(fd, MSETPARAM, &param) < 0) return 1;
    if (pending) usleep(5000);
    int before = came, result = sigsuspend(&none);
    sigprocmask(SIG_BLOCK, NULL, &after);
    printf("%d %d %d %d\\n", before, result, came, sigismember(&after, SIGUSR1));
    param.plo = -100;
    if (ioctl(fd, MSETPARAM, &param) < 0 || usleep(5000) < 0) return 1;
  }
  return 0;
}
"""


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    return programs(tmp_path_factory)


@pytest.fixture(scope="module")
def debugged(tmp_path_factory):
    """The same with firmware of MMCS_DEBUG=1."""
    return programs(tmp_path_factory, MMCS_DEBUG="1")


def programs(tmp_path_factory, **env):
    """A function that compiles an example together with the machine of lab500."""
    folder = tmp_path_factory.mktemp("programs")
    words = [sys.executable, "-m", "mmcs", "compile", "lab500", "-o", folder / "own.bin"]
    flags = ran(*words, "--cflags", "--libs", check=True,
                env={**os.environ, **env}).stdout.split()  # fmt: skip

    def build(name: str, *more: str, text: str = ""):
        source, made = EXAMPLES / f"{name}.c", folder / name
        source = written(f"{name}.c", text) if text else source
        subprocess.run(["cc", *more, source, *flags, "-lm", "-o", made], check=True)
        return made

    return build


@pytest.mark.req("API-1")
@pytest.mark.parametrize(("name", "more"), [("sine", []), ("bounce", OLD)])
def test_it_says_what_it_says_in_lock_step(program, name, more):
    """No Python is started: PATH has none."""
    own = ran(program(name, *more), env={"PATH": "/nowhere"}, check=True)
    command = ["mmcs", "exec", "--scenario", "lab500", "--lockstep", "--", *exec_of(name, more)]
    assert own.stdout == ran(sys.executable, "-m", *command, check=True).stdout


def exec_of(name: str, more: list[str]) -> list:
    """The program as any: without a machine of its own."""
    words = [sys.executable, "-m", "mmcs", "exec", "--cflags", *([] if more else ["--modern"])]
    flags = ran(*words, check=True).stdout.split()
    source = EXAMPLES / f"{name}.c"
    return [compiled(f"plain_{name}", ["cc", *flags], [source], ["-lm", "-lpthread"])]


@pytest.mark.req("API-1", "DRV-5")
def test_a_signal_that_is_blocked_comes_while_it_is_waited_for(program):
    assert ran(program("suspended", text=SUSPENDED), check=True).stdout == "0 -1 1 1\n1 -1 2 1\n"


@pytest.mark.req("API-1")
@pytest.mark.parametrize("name", FOR_THE_SERVER)
def test_what_is_for_the_server_says_so(program, name):
    done = ran(program(name, text=FOR_THE_SERVER[name]))
    told = f"a program with {name} needs `mmcs exec`: this one is linked with its machine"
    assert (done.returncode, done.stderr) == (2, f"mmcs: {told}\n")


@pytest.mark.skipif(not shutil.which("gdb"), reason="gdb is missing: sudo apt-get install gdb")
def test_a_debugger_stops_in_the_servo(debugged):
    """On a line of the source, with the values of its variables."""
    words = ["-batch", "-ex", "set breakpoint pending on", "-ex", "break servo_step", "-ex", "run",
             "-ex", "backtrace", "-ex", "info args"]  # fmt: skip
    told = ran("gdb", *words, debugged("sine")).stdout.rpartition("Breakpoint 1,")[2]
    assert "servo_step (" in told and "at firmware/mc/servo.c:" in told and "in main" in told
    assert "setpoint = 0" in told
