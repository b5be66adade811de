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
HEADERS = "fcntl.h poll.h pthread.h signal.h stdio.h sys/ioctl.h sys/time.h time.h unistd.h mcdef.h"
INCLUDES = "".join(f"#include <{name}>\n" for name in [*HEADERS.split(), "sys/mmcs.h", "errno.h"])
FOR_THE_SERVER = {
    "a program with threads": "pthread_t thread; pthread_create(&thread, 0, 0, 0);",
    "a program with timers": "struct itimerval every = {{1, 0}}; setitimer(0, &every, 0);",
    "a program of several processes": "fork();",
    "/dev/vme16": 'open("/dev/vme16", O_RDWR);',
}
# Every call that may be of the machine, and what it gives; then an axis is outside its limits while
# SIGUSR1 is blocked but for the wait: from then on, or before; and in another call.
CALLS = """
static int came;
static void limit(int number) { came++; (void)number; }
static void told(const char *what, long result) {
  struct timespec real, now;
  struct timeval day;
  int error = result < 0 ? errno : 0;
  gettimeofday(&day, NULL), clock_gettime(CLOCK_REALTIME, &real);
  clock_gettime(CLOCK_MONOTONIC, &now);
  printf("%s %ld %d %ld.%09ld %ld.%09ld %ld.%06ld\\n", what, result, error, (long)now.tv_sec,
         now.tv_nsec, (long)real.tv_sec, real.tv_nsec, (long)day.tv_sec, (long)day.tv_usec);
}
#define TOLD(call) told(#call, (long)(call))
int main(int ac, char **av) {
  const char *file = av[ac - 1];
  sigset_t blocked, none, after;
  struct mc_param param = {.which = 0};
  struct mc_state states[2];
  struct timespec some = {1, 2345678};
  int number, own[2], fd = open("/dev/mc0", O_RDWR), reader = open("/dev/mc0", O_CLOEXEC);
  TOLD(poll(NULL, 0, 3)), TOLD(usleep(700)), TOLD(sleep(1)), TOLD(nanosleep(&some, NULL));
  TOLD(fcntl(reader, F_GETFD)), TOLD(fcntl(fd, F_GETFD));
  TOLD(write(reader, &number, 4)), TOLD(read(reader, states, sizeof states)), TOLD(close(reader));
  TOLD(read(reader, states, sizeof states)), TOLD(ioctl(reader, MWAIT, &number));
  TOLD(ioctl(fd, MWAIT, &number)), TOLD(number), TOLD(ioctl(fd, MWAIT, NULL));
  TOLD(ioctl(fd, 0x5401, &number)), TOLD(write(fd, states, 3));
  TOLD(open(file, O_RDWR | O_CREAT | O_EXCL, 0400) > 0), TOLD(open(file, O_WRONLY) > 0);
  TOLD(open(file, O_RDWR | O_CREAT | O_EXCL, 0400) > 0), TOLD(errno), TOLD(pipe(own));
  TOLD(write(own[1], "x", 1)), TOLD(ioctl(own[0], FIONREAD, &number)), TOLD(number);
  TOLD(poll(&(struct pollfd){.fd = own[0], .events = POLLIN}, 1, 5)), TOLD(read(own[0], states, 9));
  signal(SIGUSR1, limit);
  sigemptyset(&none), sigemptyset(&blocked), sigaddset(&blocked, SIGUSR1);
  sigprocmask(SIG_BLOCK, &blocked, NULL);
  if (ioctl(fd, MENABLE, NULL) < 0 || ioctl(fd, MGETPARAM, &param) < 0) return 1;
  for (int round = 0; round < 4; round++) {
    param.mode = POSCHK | SOFTERR, param.plo = 100;
    if (ioctl(fd, MSETPARAM, &param) < 0) return 1;
    if (round == 1) usleep(5000);
    if (round == 2) sigprocmask(SIG_UNBLOCK, &blocked, NULL);
    TOLD(came), TOLD(round < 2 ? sigsuspend(&none) : round < 3 ? pause() : usleep(9000));
    sigprocmask(SIG_BLOCK, NULL, &after);
    TOLD(came), TOLD(sigismember(&after, SIGUSR1));
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


@pytest.mark.req("API-1", "DRV-5")
@pytest.mark.parametrize(("name", "more"), [("sine", []), ("bounce", OLD), ("calls", [])])
def test_it_says_what_it_says_in_lock_step(program, tmp_path, name, more):
    """No Python is started: PATH has none."""
    text = INCLUDES + CALLS if name == "calls" else ""
    made, plain = program(name, *more, text=text), exec_of(name, more, text)
    args = [tmp_path / "own"] if text else []
    own = ran(made, *args, env={"PATH": "/nowhere"}, check=True)
    for file in args:
        assert file.stat().st_mode & 0o777 == 0o400
        file.unlink()
    command = ["mmcs", "exec", "--scenario", "lab500", "--lockstep", "--", plain, *args]
    assert own.stdout == ran(sys.executable, "-m", *command, check=True).stdout


def exec_of(name: str, more: list[str], text: str):
    """The program as any: without a machine of its own."""
    words = [sys.executable, "-m", "mmcs", "exec", "--cflags", *([] if more else ["--modern"])]
    flags = ran(*words, check=True).stdout.split()
    source = written(f"{name}.c", text) if text else EXAMPLES / f"{name}.c"
    return compiled(f"plain_{name}", ["cc", *flags], [source], ["-lm", "-lpthread"])


@pytest.mark.req("API-1")
@pytest.mark.parametrize("what", FOR_THE_SERVER)
def test_what_is_for_the_server_says_so(program, what):
    body = f"{INCLUDES}int main(void) {{ {FOR_THE_SERVER[what]} return 0; }}"
    done = ran(program("served", text=body))
    told = f"{what} needs `mmcs exec`"
    assert done.returncode == 2 and done.stderr.startswith(f"mmcs: {told}"), done.stderr


@pytest.mark.skipif(not shutil.which("gdb"), reason="gdb is missing: sudo apt-get install gdb")
def test_a_debugger_stops_in_the_servo(debugged):
    """On a line of the source, with the values of its variables."""
    words = ["-batch", "-ex", "set breakpoint pending on", "-ex", "break servo_step", "-ex", "run",
             "-ex", "backtrace", "-ex", "info args"]  # fmt: skip
    told = ran("gdb", *words, debugged("sine")).stdout.rpartition("Breakpoint 1,")[2]
    assert "servo_step (" in told and "at firmware/mc/servo.c:" in told and "in main" in told
    assert "setpoint = 0" in told
