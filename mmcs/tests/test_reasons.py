# SPDX-License-Identifier: Apache-2.0
"""Every call that is refused says why; what each says: talks.py."""

import errno

import pytest

from mmcs import mcdef
from mmcs.device import reasons


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
