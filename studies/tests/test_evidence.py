# SPDX-License-Identifier: Apache-2.0
"""The pages of long measurements hold what today's code gives, as far as a short run can tell."""

from mmcs.sweeps.campaign import make_plan, run_chunk
from studies import bench, campaign


def test_campaign_page_is_of_todays_machines():
    """docs/evidence/campaign.md: the first faults of each machine end as the page says."""
    found = {}
    for name in ("remedies", "2026"):
        plan = make_plan((), (), campaign.SEED, campaign.MACHINES[name])
        first = [n for n in range(2 * campaign.SAMPLE) if plan.fault(n).sort != "register"]
        rows: dict[int, dict] = {}
        for numbers, task in plan.chunks(first[: campaign.SAMPLE]):
            rows |= dict(zip(numbers, run_chunk(task)["rows"], strict=True))
        found[name] = [rows[n] for n in sorted(rows)]
    assert campaign.sample_line(found) in campaign.PAGE.read_text()


def test_bench_page_has_todays_rows():
    """docs/evidence/bench.md: every bound of studies/bench.py, and the hits of today's model."""
    cells = [line.split("|")[1:-1] for line in bench.PAGE.read_text().splitlines()]
    shown = {row[0].strip(): [cell.strip() for cell in row] for row in cells if len(row) > 3}
    for name in bench.BOUNDS:
        assert shown[name][-1] == bench.wanted(name)
    # In a process of its own: machines of one process share what their caches have learned.
    told = bench.Tree(bench.ROOT).measure(next(iter(bench.LOADS.values())))
    for part, (hits, misses) in told["cache"].items():
        name = f"hits of the model's cache, {part}"
        assert shown[name][2] == bench.unit(name, 100 * hits / (hits + misses))
