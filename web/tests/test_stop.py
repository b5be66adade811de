# SPDX-License-Identifier: Apache-2.0
"""STOP works while the page hangs, the page's server is stopped, or samples flood."""

import os
import signal

import pytest
from bench import note

HANG_MS = 700
SILENT_MS = 20_000  # far longer than the dead man of that test


def enable(desk) -> None:
    """In control and enabled; a starved page may have to take control again."""

    def enabled() -> bool:
        desk.page.evaluate("() => mctool.machine.reclaim()")
        desk.page.evaluate("() => mctool.machine.try(mctool.machine.link.call('MENABLE'))")
        known = desk.page.evaluate("() => mctool.machine.enabled && mctool.machine.controls")
        return known and desk.state()["enabled"]

    desk.eventually(enabled)


def hang(page, ms: int) -> None:
    """The page's scripts come to nothing else for so long."""
    hung = "const t = Date.now(); while (Date.now() - t < ms);"
    page.evaluate(f"ms => setTimeout(() => {{ {hung} }})", ms)


def press(desk) -> float:
    """Presses STOP and waits until the frame shows that it took effect; how late, ms."""
    assert desk.state()["enabled"]
    frame = desk.stop_frame
    before = int(frame.evaluate("() => document.body.dataset.count ?? 0"))
    frame.evaluate("() => document.getElementById('stop').dispatchEvent(new Event('pointerdown'))")
    frame.wait_for_function("n => Number(document.body.dataset.count ?? 0) > n", arg=before)
    assert desk.state()["stopped"]
    assert not desk.state()["enabled"]
    return float(frame.evaluate("() => document.body.dataset.late"))


@pytest.mark.req("TOOL-1", "DRV-9")
def test_a_hundred_stops(desk):
    """Sixty with the page well, twenty while its scripts hang, twenty with its server stopped."""
    late: dict[str, list[float]] = {"page well": [], "page hung": [], "server stopped": []}
    gateway = desk.tool.processes["gateway"].pid
    for n in range(100):
        enable(desk)
        kind = "page hung" if n % 5 == 3 else "server stopped" if n % 5 == 4 else "page well"
        if kind == "page hung":
            hang(desk.page, HANG_MS)
        if kind == "server stopped":
            os.kill(gateway, signal.SIGSTOP)
        try:
            late[kind].append(press(desk))
        finally:
            os.kill(gateway, signal.SIGCONT)
    for kind, values in late.items():
        values.sort()
        middle, most = values[len(values) // 2], values[int(len(values) * 0.9)]
        figures = f"{len(values)} | {middle:.0f} | {most:.0f} | {values[-1]:.0f}"
        note("stops", kind, f"| {kind} | {figures} |")
    assert [len(values) for values in late.values()] == [60, 20, 20]


@pytest.mark.deadman(1000)
@pytest.mark.req("TOOL-1")
def test_a_hung_page_in_control_stops_the_machine_by_itself(desk):
    enable(desk)
    hang(desk.page, SILENT_MS)
    since = desk.state()["time"]
    while desk.state()["enabled"]:
        assert desk.state()["time"] - since < SILENT_MS / 1000 - 1


@pytest.mark.deadman(3000)
def test_a_page_that_is_busy_for_twice_the_dead_man_keeps_control(desk):
    """A Worker says that the page is there; a page that hangs for longer is the test above."""
    enable(desk)
    hang(desk.page, 6000)
    desk.until("() => true")  # once it is over
    assert desk.page.evaluate("() => mctool.machine.controls") and desk.state()["enabled"]
