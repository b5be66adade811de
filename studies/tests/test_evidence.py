# SPDX-License-Identifier: Apache-2.0
"""The pages of long measurements hold what today's code gives, as far as a short run can tell."""

from studies import bench


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
