# SPDX-License-Identifier: Apache-2.0
"""No test may depend on being alone on the machine or on being quick.

The only limit in seconds is pytest's own, against what never ends. A test that must wait waits for
what it is about. `make test-loaded` shows the rest: it stops every process of the suite at random.
"""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
CLOCK = re.compile(
    r"\btime\.(time|monotonic|perf_counter|process_time)\w*\(|\b(limit_s|timeout)\s*=\s*[\d.]"
    r"|\bsignal\.alarm|\bclock_gettime|\"--timeout\"|\balarm\("
)
# what a line that is found may be, and why
ALLOWED = {
    "mmcs/tests/test_lockstep.py": "its programs' clocks show machine time",
    "sim/tests/device/waits.c": "its clocks show machine time",
    "mmcs/tests/test_sanitizers.py": "an inner pytest tells what hangs before the outer one",
}


def sources():
    """Tests and what they are made of."""
    found = [ROOT / "conftest.py"]
    trees = ("firmware", "mmcs", "sim", "studies", "tools")
    for folder in ("cocotb_tests", *(f"{tree}/tests" for tree in trees)):
        found += [f for f in (ROOT / folder).rglob("*") if f.suffix in (".py", ".c", ".h")]
    names = sorted(str(f.relative_to(ROOT)) for f in found)
    return [n for n in names if n not in ALLOWED and Path(n).name != Path(__file__).name]


@pytest.mark.parametrize("name", sources())
def test_no_clock_on_the_wall(name):
    lines = (ROOT / name).read_text().splitlines()
    timed = [f"{n}: {line.strip()}" for n, line in enumerate(lines, 1) if CLOCK.search(line)]
    assert not timed, "wait for what the test is about, not for a time"


@pytest.mark.parametrize("line", [
    "end = time.monotonic() + 60", "while time.time() < end:", "p.wait(timeout=5)",
    "bench.until(ready, limit_s=3)", "signal.alarm(4)", "subprocess.run(c, timeout = 60)",
])  # fmt: skip
def test_the_rule_sees(line):
    assert CLOCK.search(line)


@pytest.mark.parametrize("line", [
    "with machine(bus_timeout_us=16.0) as sim:", "time.sleep(0.01)", "assert tb.timeouts == 3",
])  # fmt: skip
def test_the_rule_passes(line):
    assert not CLOCK.search(line)
