# SPDX-License-Identifier: Apache-2.0
"""Panels show what the driver has, whoever changed it, and nothing else; an edit is a draft."""

import os
import signal

import pytest
from bench import chosen, enable, pick
from test_page import choose, enter

from mmcs import Link, mcdef

pytestmark = pytest.mark.req("TOOL-1")
POS, VEL, TORQ = 1, 2, 3


def test_what_another_program_changes_is_shown_and_the_way_back(desk):
    page, other = desk.page, Link(path=desk.tool.socket)
    ask = other.request
    page.click("#control")  # gives it back
    desk.until("() => !mctool.machine.controls")
    ask("open", mode="rw")

    def shows(ilim: int, mode: str, interval: int) -> None:
        wanted = [str(ilim), mode, str(interval)]
        desk.eventually(lambda: wanted == [page.input_value("#axis0-ilim"),
                        chosen(page, "#axis0-mode"), page.input_value("#interval")])  # fmt: skip

    ask("change", axis=0, param={"ilim": 321, "mode": POS})
    shows(321, "pos", 2000)
    moment = ask("snapshot")["snapshot"]["id"]
    ask("change", axis=0, param={"ilim": 654, "mode": VEL})
    ask("call", request="MSETINTERVAL", value=4000)
    shows(654, "vel", 4000)
    ask("rewind", snapshot=moment)
    shows(321, "pos", 2000)
    other.close()


def test_a_draft_stays_until_it_is_taken_or_left(desk):
    page = desk.page
    desk.choose(1)
    page.fill('[id="axis1-P gain"]', "17")
    page.wait_for_timeout(400)
    assert page.input_value('[id="axis1-P gain"]') == "17" and desk.param(1)["a0"] == 1
    assert page.eval_on_selector('[id="axis1-P gain"]', "e => e.classList.contains('draft')")
    page.keyboard.press("Escape")
    desk.eventually(lambda: page.input_value('[id="axis1-P gain"]') == "100")


@pytest.mark.req("DRV-12")
def test_off_after_diag_takes_the_code_from_the_d_a(desk):
    page = desk.page
    enable(page)
    pick(page, "#axis0-mode", "torq")
    enter(page, "#axis0-setpoint", "60")
    desk.until("() => mctool.machine.history.latest(0).current === 60")
    pick(page, "#axis0-mode", "diag")  # while a current flows
    desk.until("() => mctool.machine.history.latest(0).current === 0")
    page.evaluate("() => mctool.page.changed()")
    assert chosen(page, "#axis0-mode") == "diag"
    enter(page, "#axis0-setpoint", "200")
    desk.until("() => mctool.machine.history.latest(0).current === 200")
    pick(page, "#axis0-mode", "off")
    desk.until("() => mctool.machine.history.latest(0).current === 0")
    desk.eventually(lambda: chosen(page, "#axis0-mode") == "off")


@pytest.mark.req("DRV-4")
def test_a_setpoint_moves_its_own_axis_from_what_the_driver_has(desk):
    """After a step of Tune, after the way back: not from what this page set before."""
    page = desk.page
    now = "([n, v]) => mctool.machine.history.latest(n).setpoint === v"
    for axis in (4, 5):
        choose(desk, "mode", "pos", lambda mode: mode == POS, axis)
    enable(page)
    page.click("#tab-tune")
    desk.choose(4)
    page.click("#step-go")
    counts = int(page.input_value("#step-size"))
    desk.until(now, [4, counts])
    page.evaluate("() => mctool.page.axes[4].nudge(1)")
    desk.until(now, [4, counts + 400])
    moment = desk.link.request("snapshot")["snapshot"]["id"]
    desk.choose(5)
    enter(page, "#axis5-setpoint", "694")
    desk.until(now, [5, 694])
    page.evaluate("id => mctool.machine.link.request('rewind', { snapshot: id })", moment)
    desk.until(now, [5, 0])
    desk.choose(4)
    enter(page, "#axis4-setpoint", "30")
    desk.until(now, [4, 30])
    assert desk.latest(5)["setpoint"] == 0
    desk.choose(5)
    enter(page, "#axis5-setpoint", "5000000000")  # beyond 32 bits
    desk.eventually(lambda: "no setpoint" in page.inner_text("#said"))
    assert [desk.latest(n)["setpoint"] for n in (4, 5)] == [30, 0]


def test_space_types_toggles_and_chooses_elsewhere_it_stops(desk):
    page = desk.page

    def stops(press) -> bool:
        page.click("#enable")
        desk.eventually(lambda: desk.state()["enabled"])
        press()
        page.wait_for_timeout(300)
        return not desk.state()["enabled"]

    page.click("#tab-tune")
    page.fill("#step-size", "")

    def key(where: str, name: str):
        def press() -> None:
            page.focus(where)
            page.keyboard.press(name)

        return press

    box = '[id="axis0-Coulomb compensation"]'
    assert not stops(key(box, "Space"))
    desk.eventually(lambda: desk.param(0)["mode"] & mcdef.COULCOMP)
    assert not stops(key("#step-size", "Space")) and page.input_value("#step-size") == " "
    page.click("#tab-labs")
    page.click("#lab-sheet summary")
    assert stops(key("#lab-sheet summary", "Escape"))  # with an open list, too
    assert page.locator("select").count() == 0
    page.click("#tab-tune")
    mode = "#axis0-mode [tabindex='0']"
    for where in ("#clear", mode, "[id='axis0-P gain slider']", "#tab-tune"):
        assert stops(key(where, "Space")), where
    for where in ("#step-size", box, "#clear", mode):
        assert stops(key(where, "Escape")), where


@pytest.mark.deadman(1000)
def test_a_page_that_nobody_looks_at_keeps_control(browser, desk):
    """A browser lets the timers of a hidden page run once a second, or once a minute."""
    page = browser.new_page()
    page.add_init_script("const slow = setInterval; setInterval = (f) => slow(f, 60000)")
    page.set_default_timeout(60_000)
    desk.page.click("#control")
    page.goto(desk.tool.address)
    page.wait_for_selector("body.ready")
    page.evaluate("() => mctool.machine.reclaim()")
    since = desk.state()["time"]
    page.wait_for_timeout(3000)
    assert desk.state()["lease"] is not None and desk.state()["time"] > since
    page.close()


def test_a_frozen_stream_is_told(desk):
    page = desk.page
    machine = desk.tool.processes["machine"].pid
    os.kill(machine, signal.SIGSTOP)
    desk.eventually(lambda: "No sample for" in page.inner_text("body"))
    os.kill(machine, signal.SIGCONT)
    desk.eventually(lambda: "No sample" not in page.inner_text("body"))


def test_a_lost_connection_is_told_and_mended(desk):
    page = desk.page
    gateway = desk.tool.processes["gateway"].pid
    page.evaluate("() => mctool.machine.link.carrier.close()")
    desk.eventually(lambda: not page.evaluate("() => mctool.machine.connected"))
    desk.eventually(lambda: page.evaluate("() => mctool.machine.connected") is True)
    desk.choose(3)
    page.click("#control")
    pick(page, "#axis3-mode", "vel")
    desk.eventually(lambda: desk.param(3)["mode"] == VEL)
    os.kill(gateway, signal.SIGKILL)
    desk.eventually(lambda: page.is_disabled("#axis3-mode [value=off]"))
    assert page.is_disabled("#control")
    assert "Not connected" in page.inner_text("#cause")


def test_a_square_wave_of_the_page_ends_with_power(desk):
    """PANIC ends it; Enable starts nothing, and nothing is written meanwhile."""
    page = desk.page
    choose(desk, "mode", "pos", lambda mode: mode == POS, 4)
    enable(page)
    pick(page, "[id='axis4-setpoint source']", "square")
    enter(page, "#axis4-setpoint", "100")
    desk.until("() => mctool.machine.history.latest(4).setpoint !== 0")
    desk.stop_frame.click("#press")
    desk.until("() => !mctool.machine.enabled")
    desk.eventually(lambda: chosen(page, "[id='axis4-setpoint source']") == "slider")
    assert page.evaluate("() => mctool.page.axes[4].square") is None
    desk.stop_frame.click("#press")
    desk.until("() => !mctool.machine.input('estop')")
    page.click("#enable")
    desk.until("() => document.getElementById('cause').textContent.startsWith('Servo on')")
    assert page.evaluate("() => mctool.page.axes[4].square") is None
