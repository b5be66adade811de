# SPDX-License-Identifier: Apache-2.0
"""How the tool starts: switches, a machine that others drive, two pages, screen readers."""

import pytest
from bench import Desk, chosen, enable, pick, picture
from test_page import choose, enter

from mmcs import Link
from mmcs.tool.launch import _end, start

pytestmark = pytest.mark.req("TOOL-1")


def test_interval_zeroed_encoders_and_frozen_numbers(browser):
    desk = Desk(browser, start("puma560", None, {"t": "3", "z": "1", "u": "1"}))
    try:
        assert desk.link.request("call", request="MGETINTERVAL")["value"] == 3000
        assert desk.page.input_value("#interval") == "3000"
        assert desk.page.evaluate("() => mctool.machine.deadman_ms") == 250
        desk.until("() => mctool.machine.history.latest(0)?.encnow === 0")
        desk.page.wait_for_timeout(500)
        assert desk.page.inner_text("#axis0-count") == ""  # -u: the panel does not follow
        assert not desk.state()["enabled"]
    finally:
        desk.close()


@pytest.mark.pictures
def test_it_looks_as_under_sunview(browser, desk):
    old = desk.open("&theme=1989")
    assert old.evaluate("() => getComputedStyle(document.body).fontFamily").find("Mono") > 0
    looks = "all => all.map((e) => getComputedStyle(e)).map((e) => e.color + e.borderTopColor)"
    colours = old.locator("button, .panel, h2").evaluate_all(looks)
    grey = [c for c in colours if len(set(c.replace("rgb(", "").split(")")[0].split(", "))) > 1]
    assert grey == []  # black and white, nothing else
    picture(old, "1989")
    old.close()


def test_a_page_beside_the_program_bounce_looks_on(browser, attached):
    """`--attach`: the program of chapter 2 drives, a page comes and goes. That it changes
    nothing is shown to the bit in mmcs/tests/test_monitor.py."""
    socket, bounce = attached
    with Link(path=socket) as link:
        link.request("open", mode="r")
        desk = Desk(browser, start("", socket, {}))
        assert chosen(desk.page, "#axis0-mode") == "off"
        program = bounce()
        desk.until("() => mctool.machine.history.latest(0).setpoint !== 0")
        desk.eventually(lambda: chosen(desk.page, "#axis0-mode") == "vel")
        assert desk.page.input_value("#axis0-a0") == str(desk.param(0)["a0"])
        assert desk.page.input_value('[id="axis0-P gain"]') != "100"
        assert desk.page.inner_text("#control") == "Take control"
        assert desk.page.is_disabled("#enable") and desk.page.is_disabled("#axis0-mode [value=off]")
        desk.page.close()
        desk.link.close()
        for process in ("gateway", "stopper"):
            _end(desk.tool.processes[process])
        assert link.request("hello")["enabled"] and program.poll() is None


def test_two_pages_at_once_one_in_control(desk):
    other = desk.open()
    assert "Controlled by another" in other.inner_text("#control")
    assert other.is_disabled("#enable") and other.is_disabled("#axis0-mode [value=off]")
    assert desk.page.inner_text("#control") == "Give control back"
    desk.page.click("#control")
    other.wait_for_selector("#control:has-text('Take control')")
    other.click("#control")
    desk.until("() => document.getElementById('control').textContent.startsWith('Controlled')")
    desk.choose(3, other)
    desk.choose(3)
    pick(other, "#axis3-mode", "vel")
    desk.eventually(lambda: desk.param(3)["mode"] & 0xF == 2)
    off = "#axis3-mode [value=off]"
    assert desk.page.is_disabled(off) and other.is_enabled(off)
    assert desk.page.is_disabled("#control")
    assert desk.page.errors == other.errors == []
    desk.page.close()
    desk.page = other
    desk.eventually(lambda: len(desk.link.request("clients")["clients"]) == 2)
    assert desk.param(3)["mode"] & 0xF == 2  # the end of a page without control changes nothing


def test_the_wheel_changes_no_number_and_turns_the_arm_nearer(desk):
    page = desk.page
    pick(page, "#axis0-mode", "torq")
    desk.eventually(lambda: desk.param(0)["mode"] & 0xF == 3)
    before = desk.param(0)
    for control in ("setpoint slider", "setpoint", "P gain slider", "P gain"):
        page.hover(f'[id="axis0-{control}"]')
        page.focus(f'[id="axis0-{control}"]')
        page.mouse.wheel(0, 240)
    page.wait_for_timeout(200)
    assert desk.param(0) == before and desk.latest(0)["setpoint"] == 0
    page.hover(".arm")
    page.mouse.wheel(0, -400)
    desk.until("() => Number(document.querySelector('.arm').dataset.away) < 2.5")


def test_a_newcomer_is_told_what_holds_a_joint_and_what_moves_it(desk):
    """Enable, Pos, 200: with power-on gains friction holds J1, unasked nothing is written."""
    page = desk.page
    assert page.inner_text("h1") == page.title() == "Unimation PUMA 560, simulated"
    assert page.eval_on_selector_all(".filled", "all => all.map((e) => e.id)") == ["enable"]
    assert page.is_visible("#offer") and page.is_visible("#robot-gains")
    choose(desk, "mode", "pos", lambda mode: mode & 0xF == 1)
    enable(page)
    enter(page, "#axis0-setpoint", "200")
    words = "axis 0 pushes 200 D/A units, friction holds about 590"
    desk.eventually(lambda: words in page.inner_text("#cause"))
    assert desk.latest(0)["encnow"] == 0 and page.locator(".filled").count() == 0
    page.click("#offer")
    desk.until("() => Math.abs(mctool.machine.history.latest(0).encnow - 200) < 20")
    desk.eventually(lambda: page.inner_text("#cause").startswith("Servo on, brakes off"))
    assert not page.is_visible("#offer")
    suggested = desk.link.request("machine")["servo"]
    for axis, wanted in enumerate(suggested):
        assert desk.param(axis) == desk.param(axis) | wanted
    assert desk.link.request("call", request="MGETINTERVAL")["value"] == 1000
