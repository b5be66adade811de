# SPDX-License-Identifier: Apache-2.0
"""Skipping against clocking every clock (mmcs/lockstep.py). MMCS_LONG=1 for 1e9 clocks."""

import os

import pytest

from mmcs import lockstep

LONG = os.environ.get("MMCS_LONG") == "1"


@pytest.mark.req("API-1")
@pytest.mark.parametrize(
    ("name", "seed"),
    [("puma560", 13), ("puma560", 62), ("puma560", 105), ("lab500", 1), ("lab500", 2)],
)
def test_a_stranger_finds_no_difference(name, seed):
    """Random accesses, switches, wires, upsets; seeds that found mistakes once are among them."""
    assert lockstep.lockstep_torture(seed, 1600, name) > 100_000


@pytest.mark.req("API-1")
def test_a_difference_is_found():
    """One machine has a bit of a counter flipped, which no access reads: the hash tells."""
    _, plain, skipping = lockstep.machines("lab500")
    with plain, skipping:
        skipping.add_event(1e-5, plain.input_names().index("seu_encoder"), 0, 4)
        with pytest.raises(lockstep.Differs, match="seed 1"):
            lockstep.torture((plain, skipping), 1, 200)


@pytest.mark.req("API-1")
def test_the_command_compares_scenarios_too(monkeypatch, capsys):
    monkeypatch.setattr(lockstep, "scenario_names", lambda: ["lab500"])
    assert lockstep.main(["--clocks", "1", "--actions", "50"]) == 0
    assert "clocks equal" in capsys.readouterr().out


if LONG:

    @pytest.mark.req("API-1")
    def test_a_thousand_million_clocks():
        assert lockstep.main(["--clocks", "1e9"]) == 0
