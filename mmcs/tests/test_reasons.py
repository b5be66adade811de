# SPDX-License-Identifier: Apache-2.0
"""Every call that is refused says why, in Python's exception and by MWHY."""

import errno
import sys
from types import SimpleNamespace

import pytest

from mmcs import mcdef
from mmcs.device import reasons, wire
from mmcs.device.programs import Program
from mmcs.tests.device_bench import output_in_lockstep

REFUSED = """
import os, sys
import mmcs
from mmcs import mcdef as mc
dev, mon = mmcs.Device(), mmcs.Device(flags=os.O_RDONLY)
par, MINUS = dev.get_param(0), bytes([255] * 4)
calls = [
    lambda: dev.set_num_joints(3), lambda: dev.set_interval(50), lambda: dev.get_param(7),
    lambda: dev.set_param(0, {**par, "b0": 0}), lambda: dev.set_param(0, {**par, "clkdivisor": 0}),
    lambda: dev.set_param(0, {**par, "clkdivisor": 60}),
    lambda: dev.set_param(0, {**par, "ipole": 1024}), lambda: dev.set_param(1, {**par, "ilim": -1}),
    lambda: dev.set_encoder(9, 0), lambda: dev.set_leds(2, 1), lambda: dev.ioctl(mc.MCALIB, MINUS),
    lambda: dev.set_diag_mode(8), lambda: dev.write([1, 2, 3]), lambda: dev.ioctl(0x4D99),
    lambda: mon.enable(), lambda: mon.write([1]), lambda: mon.set_num_joints(1),
    lambda: dev.write_axis(2, 5), lambda: dev.end_calibration(3), lambda: mon.write_axis(0, 5),
    lambda: dev.set_dac(0, 5), lambda: (dev.stop(), dev.write_axis(0, 1)),
    lambda: (dev.stop(), dev.write([1])),
    lambda: dev.write([1]), lambda: dev.write_axis(0, 1),  # the driver says it once
    lambda: mmcs.Device("/dev/mc1"),
    lambda: mmcs.Device(flags=3), lambda: (mon.close(), mon.read()), lambda: mon.wait(),
]
for call in calls:
    try:
        call()
        print("nothing")
    except OSError as error:
        print(error.strerror.partition(": ")[2] or "nothing")
"""
BOUNDS = reasons.OF_ANY[errno.EINVAL]
SAID = f"""MSETNUMJOINTS: 3: negative, or more than found
MSETINTERVAL: 50: under 100 us, over 536 s (8 MHz), off by more than 0.1 %, or too \
long for a `clkdivisor`
MGETPARAM: 7: {BOUNDS}
MSETPARAM: 0: axis, or beyond the bounds of the parameters
MSETPARAM: 0: axis, or beyond the bounds of the parameters
MSETPARAM: 0: axis, or beyond the bounds of the parameters
MSETPARAM: 0: axis, or beyond the bounds of the parameters
MSETPARAM: 1: axis, or beyond the bounds of the parameters
MSETENC: 9: {BOUNDS}
MSETLED: 258: {BOUNDS}
MCALIB: -1: {BOUNDS}
MDIAGMODE: 8: other bits
write: 12: must be 4 bytes for each joint, of no more joints than the servo controls
there is no request 0x00004d99
MENABLE: the device is open for reading only
write: the device is open for reading only
MSETNUMJOINTS: the device is open for reading only
MSETPOINT: 2: {BOUNDS}
MCALIBEND: 3: {BOUNDS}
MSETPOINT: the device is open for reading only
MSETDAC: not enabled
write: stopped, MENABLE first
write: stopped, MENABLE first
write: stopped or shut down, MENABLE first
MSETPOINT: stopped or shut down
no adaptor answers there
must be opened for reading, writing or both
the device is closed
the device is closed
"""


@pytest.mark.req("DRV-3")
def test_every_refusal_has_a_sentence(bench):
    out, status = bench.finish(bench.python(REFUSED))
    assert status == 0 and out.splitlines() == SAID.splitlines()


@pytest.mark.req("DRV-3")
def test_no_request_and_no_error_is_without_one():
    """Whatever the driver may answer to whatever request, with and without an argument."""
    requests = [request.code for request in mcdef.requests().values()]
    errors = (errno.EIO, errno.EBUSY, errno.EINVAL, errno.EBADF, errno.ENOTTY, errno.EFAULT)
    said = {
        (request, error): {
            reasons.of_ioctl(error, request, argument)
            for argument in (b"", bytes(52), b"\xff" * 52)
        }
        for request in requests
        for error in errors
    }
    assert len(said) >= 20 * 6 and not [key for key, why in said.items() if "" in why]
    assert all(
        reasons.of_call("read", error, 27) and reasons.of_call("write", error, 3)
        for error in errors
    )


def test_a_refusal_names_who_holds_the_machine_only_where_that_is_why():
    program = SimpleNamespace(machine=SimpleNamespace(held=lambda _: "held by another"))
    for error in (errno.EBUSY, errno.EINVAL):
        said = Program._because(program, SimpleNamespace(driver=0), error, wire.WRITE, 0, b"ab")
        assert ("held" in said) == (error == errno.EBUSY) and said


def test_in_lockstep_too(tmp_path):
    assert output_in_lockstep(tmp_path, sys.executable, "-c", REFUSED)[:2] == (SAID, 0)
