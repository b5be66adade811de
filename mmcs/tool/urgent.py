# SPDX-License-Identifier: Apache-2.0
"""Processes that a busy computer shall not keep waiting: the stop process and the machine.

Who may (root, or `nice` and `rtprio` in limits.conf) runs before the programs of others; everybody
may ask for short turns, which Linux gives sooner (sched_setattr, since 6.12).
"""

import contextlib
import ctypes
import os
import platform
import runpy
import signal
import struct

LIBC = ctypes.CDLL(None)
PR_SET_PDEATHSIG = 1
TURN_NS = 100_000  # the shortest that Linux gives
NICE = -10
SYS_SCHED_SETATTR = {"x86_64": 314, "aarch64": 274}.get(platform.machine())
# size, policy, flags, nice, priority, runtime, deadline, period
ATTRIBUTES = struct.Struct("=IIQiIQQQ")


def end_with_parent() -> None:
    """SIGTERM when the parent dies, however it does."""
    LIBC.prctl(PR_SET_PDEATHSIG, signal.SIGTERM)


def prefer(pid: int, sleeps: bool = False) -> None:
    """sleeps: it works for microseconds at a time, and may run before all others."""
    if SYS_SCHED_SETATTR is not None:
        short = ATTRIBUTES.pack(ATTRIBUTES.size, os.SCHED_OTHER, 0, 0, 0, TURN_NS, 0, 0)
        LIBC.syscall(SYS_SCHED_SETATTR, pid, short, 0)
    with contextlib.suppress(OSError):
        os.setpriority(os.PRIO_PROCESS, pid, NICE)
        if sleeps:
            os.sched_setscheduler(pid, os.SCHED_RR, os.sched_param(1))


if __name__ == "__main__":  # `mmcs …` for a program that ends with the one that started it
    end_with_parent()
    runpy.run_module("mmcs", run_name="__main__", alter_sys=True)
