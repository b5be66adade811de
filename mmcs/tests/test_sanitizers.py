# SPDX-License-Identifier: Apache-2.0
"""Engine, driver and preload library with address and undefined-behaviour sanitizers: the tests of
programs, once more."""

import os
import sys

import pytest

from tools.compiled import ran

OPTIONS = {
    # Python keeps memory at its end; faults of the mapped window are not errors
    "ASAN_OPTIONS": "detect_leaks=0:handle_segv=0:handle_sigbus=0:exitcode=99",
    "UBSAN_OPTIONS": "print_stacktrace=1",
}


def runtime():
    """What must be loaded first into a program not made for it: the sanitizer, and C++'s library,
    whose exceptions it looks for when it starts."""
    ask = (["gcc", f"-print-file-name={name}.so"] for name in ("libasan", "libstdc++"))
    paths = [ran(*words).stdout.strip() for words in ask]
    return ":".join(paths) if all(map(os.path.isabs, paths)) else None


@pytest.mark.slow
@pytest.mark.req("DRV-3", "DRV-4", "API-1")
def test_programs():
    if not (library := runtime()):
        pytest.skip("libasan is missing; install gcc's with: sudo apt-get install build-essential")
    env = {**os.environ, **OPTIONS, "MMCS_SANITIZE": "1", "LD_PRELOAD": library}
    tests = [f"mmcs/tests/{name}.py" for name in ("test_exec", "test_serve")]
    command = [sys.executable, "-m", "pytest", "-x", "-s", "-p", "no:cacheprovider"]
    command += ["--timeout", "1800"]  # what hangs is told by name before this test itself times out
    command += ["-k", "not bounce"] if os.environ.get("MMCS_LONG") == "1" else []
    done = ran(*command, *tests, env=env)
    text = done.stdout + done.stderr
    print(text)
    assert done.returncode == 0, text[-4000:]
    assert "Sanitizer" not in text and "runtime error" not in text, text[-4000:]
