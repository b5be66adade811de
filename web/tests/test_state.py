# SPDX-License-Identifier: Apache-2.0
"""Panels show what the driver has, whoever changed it, and nothing else; an edit is a draft."""

import os
import signal

import pytest
from bench import chosen, enable, pick
from test_page import enter

from mmcs import mcdef

pytestmark = pytest.mark.req("TOOL-1")


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


def test_what_others_do_and_what_is_lost_is_shown_by_every_page(desk):
    """A change elsewhere, the way back, a second page in control, no samples, no connection."""
    page, other = desk.page, desk.open()
    ask = "([op, more]) => mctool.machine.link.request(op, more)"
    assert "Controlled by another" in other.inner_text("#control")
    assert other.is_disabled("#enable") and other.is_disabled("#axis0-mode [value=off]")
    moment = page.evaluate(ask, ["snapshot", {}])["snapshot"]["id"]
    page.click("#control")  # gives it back
    other.click("#control:has-text('Take control')")
    page.wait_for_selector("#control:has-text('Controlled by another')")
    assert page.is_disabled("#axis0-mode [value=off]") and page.is_disabled("#control")
    pick(other, "#axis0-mode", "vel")
    for one in (page, other):
        desk.eventually(lambda one=one: chosen(one, "#axis0-mode") == "vel")
    other.evaluate(ask, ["rewind", {"snapshot": moment}])
    for one in (page, other):
        desk.eventually(lambda one=one: chosen(one, "#axis0-mode") == "off")
    machine, gateway = (desk.tool.processes[name].pid for name in ("machine", "gateway"))
    os.kill(machine, signal.SIGSTOP)
    desk.eventually(lambda: "No sample for" in page.inner_text("body"))
    os.kill(machine, signal.SIGCONT)
    desk.eventually(lambda: "No sample" not in page.inner_text("body"))
    page.evaluate("() => mctool.machine.link.carrier.close()")
    desk.until("() => !mctool.machine.connected")
    desk.until("() => mctool.machine.connected")
    os.kill(gateway, signal.SIGKILL)
    desk.eventually(lambda: "Not connected" in page.inner_text("#cause"))
    assert page.is_disabled("#control") and other.errors == []


def test_a_square_wave_of_the_page_ends_with_power(desk):
    """PANIC ends it; Enable starts nothing, and nothing is written meanwhile."""
    page = desk.page
    page.click("#tile4")
    pick(page, "#axis4-mode", "pos")
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
