# SPDX-License-Identifier: Apache-2.0
"""The pages of long measurements hold what today's code gives, as far as a short run can tell."""

from types import SimpleNamespace

from mmcs.sweeps.classes import DANGEROUS, LATE, MASKED
from studies import bench, campaign


def test_bench_page_has_todays_rows():
    """docs/evidence/bench.md: every bound of studies/bench.py."""
    cells = [line.split("|")[1:-1] for line in bench.PAGE.read_text().splitlines()]
    shown = {row[0].strip(): row[-1].strip() for row in cells if len(row) == 4}
    for name in bench.BOUNDS:
        assert shown[name] == bench.wanted(name)


def test_failures_of_the_campaign_are_shares_of_all_flips(tmp_path, monkeypatch):
    """Two motions, of 10 and 30 flip-flops: 1/2 and 1/4 of their flips are dangerous."""
    monkeypatch.setattr(campaign, "FOLDER", tmp_path)
    row = {"sort": "register", "deg": 6.0, "after_ms": None}
    rows = [row | {"motion": "a", "class": name} for name in (DANGEROUS, MASKED)]
    rows += [row | {"motion": "b", "class": name} for name in (DANGEROUS, MASKED, MASKED, LATE)]
    rows += [row | {"motion": "a", "class": DANGEROUS, "sort": "pin", "after_ms": 50.0}]
    motion = SimpleNamespace(name="a", until=1.0, registers=(("x", 4), ("y", 6)))
    other = SimpleNamespace(name="b", until=2.0, registers=(("x", 30),))
    plan = SimpleNamespace(motions=(motion, other))
    least = (0.5 * 10 * 1.0 + 0.25 * 30 * 2.0) * 8e6 / 1e9
    assert campaign.extrapolated(plan, rows, DANGEROUS).startswith(f"{least:.2f} (")
    for name in campaign.MOTIONS:
        (tmp_path / "x" / name).mkdir(parents=True)
        table = "panics,interrupts\n0,1000\n0,1000\n0,400\n1,1000\n"
        (tmp_path / "x" / name / "table.csv").write_text(table)
    cells = campaign.table({"x": rows}, {"x": plan})[2].split(" | ")
    assert cells[:2] == ["| x", "7"] and cells[2].startswith("428,600 (") and cells[3] == cells[2]
    assert cells[-1] == "8 of 16 |"
    assert campaign.times({"x": rows})[2].startswith("| x | 1 | 50 | 50 |")
