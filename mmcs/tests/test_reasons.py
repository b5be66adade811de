# SPDX-License-Identifier: Apache-2.0
"""Every call that is refused says why; what each says: talks.py."""

import errno
from types import SimpleNamespace

import pytest

from mmcs import mcdef
from mmcs.device import reasons, wire
from mmcs.device.programs import Program


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
