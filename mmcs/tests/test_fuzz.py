# SPDX-License-Identifier: Apache-2.0
"""A sample of `make fuzz`: damaged inputs for every parser end in a result or in a sentence."""

import os

from mmcs import ROOT
from tools.compiled import compiled, ran
from tools.parsers import fuzz

SANITIZE = ["-g", "-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=undefined"]


def said(*command):
    env = {**os.environ, "ASAN_OPTIONS": "detect_leaks=0"}
    done = ran(*command, env=env)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_every_parser_in_python(capsys):
    assert fuzz(100, seed=7) == 0, capsys.readouterr().out


def test_whatever_a_server_answers():
    command = ["cc", "-DSAMPLE", *SANITIZE, f"-I{ROOT}/sim/device"]
    source = ROOT / "sim" / "tests" / "fuzz" / "client.c"
    program = compiled("fuzz_client", command, [source], ["-ldl", "-lpthread"])
    assert said(program, 20_000) == "20000 inputs\n"
