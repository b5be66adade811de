# SPDX-License-Identifier: Apache-2.0
"""Waveforms in the page: those of a native trace of the same run; by keyboard, on a telephone."""

import itertools
import json
import subprocess
import sys
from pathlib import Path

import pytest
from bench import picture, saved, until

from mmcs import BUILD, parse, replay, trace, waves

PS_PER_CLK, BEFORE_CLKS = 125_000, 63  # a trace counts from the reset before power-on
HZ = 8_000_000
SITE = BUILD / "web"
DRAWN = "document.querySelector('.waves')?.dataset.from"
READING = "document.getElementById('waves-reading').textContent"
SETPOINTS = "() => [0, 1, 2, 3, 4, 5].map((n) => mctool.machine.setpoint(n))"
ASK = "wanted => mctool.machine.link.request('waves', wanted)"


def changes(values, begin: int, end: int, mask: int) -> list[tuple[int, int]]:
    """Changes from one clock to another, the first as it was at the begin; one for each clock."""
    last = {max(clock, begin): value & mask for clock, value in values if clock <= end}
    pairs = itertools.pairwise([(-1, None), *last.items()])
    return [(clock, value) for (_, before), (clock, value) in pairs if value != before]


@pytest.mark.req("TOOL-1", "SIM-3")
def test_waveforms_are_those_of_a_native_trace_of_the_same_run(opened, tmp_path):
    """Just after a person has changed gains, amid what the scenario's own process does."""
    import pywellen

    page = opened("?scenario=puma560_bounce&paused=1&deadman=240000")
    until(page, "mctool.machine.controls && mctool.machine.enabled")
    page.evaluate("""async () => {
      const { machine } = mctool;
      await machine.link.request("pace", { paused: false });
      await machine.link.request("pace", { paused: true });
      const change = machine.change(0, { ilim: 20 });
      await machine.link.request("pace", { paused: false });
      await change;
    }""")
    page.wait_for_selector("#record:not([disabled])")
    page.evaluate("() => mctool.machine.link.request('pace', { paused: true })")
    path = saved(page, "#record", tmp_path)
    record = parse(path, json.loads(path.read_text()))
    at = record.motion_start_s + record.data["call"][-1]["at"] + 0.001
    made = page.evaluate(ASK, {"t": at, "ms": 2})
    assert (made["from"], made["to"]) == (round((at - 1e-3) * HZ), round((at + 1e-3) * HZ))

    traced = tmp_path / "run.fst"
    assert trace(record, traced, at - 1.5e-3, at + 1.5e-3)[0] is None
    assert replay(record)[1] is None
    found = {var.full_name: var for var in pywellen.Waveform(str(traced)).all_vars()}
    signals = [s for name, group in waves.GROUPS.items() if name != "firmware" for s in group]
    busy = 0
    for signal, net in zip(signals, made["nets"], strict=True):
        span = (made["from"], made["to"], (1 << signal.width) - 1)
        seen = changes(zip(net["clocks"], net["values"], strict=True), *span)
        tv = found[signal.full()].tv
        assert seen == changes(((t // PS_PER_CLK - BEFORE_CLKS, int(v)) for t, v in tv), *span), (
            signal.path
        )
        busy += len(seen) > 1
    assert busy > 20


@pytest.mark.req("TOOL-1", "SIM-3")
@pytest.mark.parametrize("name,steps", [("lab500", 400), ("puma560_bounce", 150)])
def test_the_past_is_made_again_to_the_bit_whatever_was_done(name, steps):
    """Requests, registers by hand, faults, STOP, going back, at random: no hair of difference."""
    node, past = Path(sys.executable).with_name("node"), Path(__file__).with_name("past.mjs")
    command = [node, past, SITE, name, str(steps)]
    ended = subprocess.run(command, capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stderr
    found = json.loads(ended.stdout)
    assert found["same"] >= steps / 10 and found["drawn"] > 5000


@pytest.mark.req("TOOL-1")
@pytest.mark.pictures
def test_moments_by_scope_slider_and_number_and_all_of_it_by_keyboard(opened):
    page = opened("?scenario=puma560&deadman=240000")  # starved, it is silent for long
    until(page, "document.body.dataset.hash")
    page.click("#pause")
    page.evaluate("() => mctool.page.look(mctool.machine.history.now - 0.2)")
    page.click("#waves")
    until(page, DRAWN)
    at = page.evaluate("() => Number(document.getElementById('waves-t').value)")
    page.click("#tab-scope")
    page.click("#scope-run")
    screen = page.locator(".u-over").first
    width = screen.bounding_box()["width"]
    screen.hover(position={"x": 0.4 * width, "y": 10})  # before the moment, which is in the middle
    page.focus(".screen")
    page.keyboard.press("a")
    page.click("#tab-waves")
    page.click("#waves-scope")
    until(page, f"Math.abs(document.querySelector('.waves').dataset.from - {at}) > 0.01")
    setpoints = page.evaluate(SETPOINTS)
    page.focus("#waves-canvas")
    for key in ("ArrowDown", "a", "ArrowRight", "ArrowRight", "b"):
        page.keyboard.press(key)
    until(page, f"{READING}.includes('Δ')")
    page.wait_for_timeout(300)
    picture(page, "web_waves")
    assert page.evaluate(SETPOINTS) == setpoints  # nothing was nudged
