# SPDX-License-Identifier: Apache-2.0
"""Scope, faults, registers, the past, and a stream without a loss, in a real browser."""

import pytest
from bench import enable, pick, saved
from test_page import enter

pytestmark = pytest.mark.req("TOOL-1")
STREAM_S = 60.0
# By the machine's own numbers of its samples, whatever the stream says of itself.
NUMBERS = """(first) => {
  const { history } = mctool.machine;
  let gaps = 0;
  for (let row = first + 1; row < history.end; row++)
    gaps += history.number(row) !== history.number(row - 1) + 1;
  return { gaps, rows: history.end - first };
}"""


def test_a_minute_of_six_axes_at_1_khz_without_a_loss(desk):
    page = desk.page
    enter(page, "#interval", "1000")
    desk.eventually(lambda: desk.link.request("call", request="MGETINTERVAL")["value"] == 1000)
    start = desk.state()["time"]
    first = page.evaluate("() => mctool.machine.history.end")
    desk.page.set_default_timeout(600_000)
    desk.until(f"() => mctool.machine.history.now > {start + STREAM_S}")
    numbers = page.evaluate(NUMBERS, first)
    assert numbers["gaps"] == 0 and numbers["rows"] >= (STREAM_S - 1) * 1000
    assert page.evaluate("() => mctool.machine.history.lost") == 0


def test_the_scope_triggers_before_a_fault_and_reopens_what_it_saved(desk, tmp_path):
    page = desk.page
    page.click("#scope-more")
    pick(page, "#scope-trigger", "panic")
    desk.until("() => document.getElementById('scope-lost').textContent.startsWith('waiting')")
    enable(page)
    page.click("#tab-scope")
    page.wait_for_timeout(1500)  # something to be seen before the fault
    desk.stop_frame.click("#press")
    desk.until("() => document.querySelector('.scope').dataset.fired")
    fired = float(page.evaluate("() => document.querySelector('.scope').dataset.fired"))
    path = saved(page, "#scope-save", tmp_path).rename(tmp_path / "saved.csv")
    about, *rows = path.read_text().splitlines()
    assert about.startswith("# puma560, interval 2000 us; encnow")
    times = [float(row.split(",")[0]) for row in rows[1:]]
    assert times[0] < fired - 0.2 and times[-1] >= fired
    lines = [int(row.split(",")[1]) for row in rows[1:]]
    at = next(n for n, t in enumerate(times) if t >= fired - 1e-9)
    assert lines[at] & 1 and not lines[at - 1] & 1
    page.set_input_files("input[type=file]", path)
    desk.until("() => document.querySelector('.channels').textContent.includes('saved.csv')")
