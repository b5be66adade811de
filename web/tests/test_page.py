# SPDX-License-Identifier: Apache-2.0
"""Chapter 3, control by control: each changes what the driver reads back."""

import pytest
from bench import enable, pick, picture

pytestmark = pytest.mark.req("TOOL-1")


def enter(page, selector: str, text: str) -> None:
    page.fill(selector, text)
    page.press(selector, "Enter")


@pytest.mark.req("DRV-9")
def test_the_page_closed_in_mid_move_stops_the_machine(desk):
    """By its end, not by its silence, which would be allowed to last ten seconds."""
    pick(desk.page, "#axis0-mode", "torq")
    pick(desk.page, '[id="axis0-setpoint source"]', "square")  # to and fro: it never rests
    enable(desk.page)
    desk.page.wait_for_selector("#axis0-panel .setpoint:has-text('Amplitude')")
    enter(desk.page, "#axis0-setpoint", "700")
    desk.until("() => mctool.machine.history.latest(0).vel > 2")
    before = desk.state()["time"]
    desk.page.close()
    while desk.state()["enabled"]:
        assert desk.state()["time"] - before < 5  # of the machine: it is far less
    desk.page = desk.open()


@pytest.mark.pictures
def test_pictures_for_the_manual(desk):
    page = desk.page
    enable(page)
    page.click("#tab-tune")
    page.fill("#tune-wn", "50")
    page.click("#tune-go")
    desk.eventually(lambda: page.inner_text("#tune-verdict") != "")
    picture(page, "tune")
    page.click("#robot-gains")  # friction may have undone the tuned ones: the axis is Off then
    desk.until("() => mctool.page.axes[0].mode === 'pos'")
    page.click("#tab-scope")
    pick(page, '[id="axis0-setpoint source"]', "square")
    page.wait_for_selector("#axis0-panel .setpoint:has-text('Amplitude')")
    enter(page, "#axis0-setpoint", "4000")
    desk.until("() => mctool.machine.history.latest(0).setpoint < -2000")
    desk.until("() => mctool.machine.history.latest(0).setpoint > 2000")
    page.wait_for_timeout(300)
    picture(page, "scope")
    page.emulate_media(color_scheme="dark")
    page.wait_for_timeout(700)
    picture(page, "dark")
    page.emulate_media(color_scheme="light")
    page.set_viewport_size({"width": 390, "height": 844})
    page.wait_for_timeout(700)
    picture(page, "telephone")
    page.keyboard.press("Escape")
    page.set_viewport_size({"width": 1280, "height": 800})


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


def test_a_newcomer_is_told_what_holds_a_joint_and_what_moves_it(desk):
    """Enable, Pos, 200: with power-on gains friction holds J1, unasked nothing is written."""
    page = desk.page
    assert page.eval_on_selector_all(".filled", "all => all.map((e) => e.id)") == ["enable"]
    pick(page, "#axis0-mode", "pos")
    enable(page)
    enter(page, "#axis0-setpoint", "200")
    words = "axis 0 pushes 200 D/A units, friction holds about 590"
    desk.eventually(lambda: words in page.inner_text("#cause"))
    assert page.evaluate("() => mctool.machine.history.latest(0).encnow") == 0
    page.click("#offer")
    desk.until("() => Math.abs(mctool.machine.history.latest(0).encnow - 200) < 20")
    desk.eventually(lambda: page.inner_text("#cause").startswith("Servo on, brakes off"))
    assert not page.is_visible("#offer")
    for axis, wanted in enumerate(desk.link.request("machine")["servo"]):
        assert desk.param(axis) == desk.param(axis) | wanted
