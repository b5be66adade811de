# SPDX-License-Identifier: Apache-2.0
"""A sample of `make fuzz`: damaged inputs for every parser end in a result or in a sentence."""

import os
import sys

import pytest

from mmcs import ROOT

SANITIZE = ["-g", "-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=undefined"]
sys.path.insert(0, str(ROOT / "firmware" / "tests"))
from test_firmware import program  # noqa: E402

from tools.compiled import compiled, ran  # noqa: E402
from tools.parsers import fuzz  # noqa: E402


def said(*command):
    env = {**os.environ, "ASAN_OPTIONS": "detect_leaks=0"}
    done = ran(*command, env=env)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_every_parser_in_python(capsys):
    assert fuzz(100, seed=7) == 0, capsys.readouterr().out


@pytest.mark.req("DRV-3", "DRV-4")
def test_any_call_of_the_driver():
    said(program(), "test_random_calls", 100_000, 7)


def test_whatever_a_server_answers():
    command = ["cc", "-DSAMPLE", *SANITIZE, f"-I{ROOT}/sim/device"]
    source = ROOT / "sim" / "tests" / "fuzz" / "client.c"
    program = compiled("fuzz_client", command, [source], ["-ldl", "-lpthread"])
    assert said(program, 20_000) == "20000 inputs\n"
