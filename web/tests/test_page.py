# SPDX-License-Identifier: Apache-2.0
"""Chapter 3, control by control: each changes what the driver reads back."""

import tomllib

import pytest
from bench import chosen, enable, pick, picture, saved

from mmcs import mcdef

pytestmark = pytest.mark.req("TOOL-1")
POS, VEL, TORQ = 1, 2, 3


def choose(desk, what: str, value: str, want, axis: int = 0) -> None:
    """Chooses, and waits until the driver's mode word is as wanted."""
    desk.choose(axis)
    pick(desk.page, f'[id="axis{axis}-{what}"]', value)
    desk.eventually(lambda: want(desk.param(axis)["mode"]))


def enter(page, selector: str, text: str) -> None:
    page.fill(selector, text)
    page.press(selector, "Enter")


def test_changes_asked_for_faster_than_the_machine_answers_come_in_turn(desk):
    page = desk.page
    page.evaluate(
        """() => {
          const { link } = mctool.machine, ask = link.request.bind(link);
          const late = (reply) => new Promise((done) => setTimeout(done, 300, reply));
          link.request = (...args) => ask(...args).then(late);
        }"""
    )
    for what, value in (("mode", "pos"), ("setpoint source", "ad"), ("feedback", "ad"),
                        ("mode", "vel"), ("setpoint source", "square")):  # fmt: skip
        pick(page, f'[id="axis0-{what}"]', value)
    page.evaluate("() => mctool.page.drafts.settled")
    assert "Amplitude" in page.locator("#axis0-panel .setpoint").inner_text()
    assert chosen(page, '[id="axis0-setpoint source"]') == "square"
    assert desk.param(0)["mode"] == VEL | mcdef.ADFB


def test_a_joint_dragged_by_hand_is_chosen_and_its_setpoint_follows(desk):
    page = desk.page
    choose(desk, "mode", "pos", lambda mode: mode == POS, 2)
    desk.choose(0)
    desk.until("() => mctool.arm.seen.some(({ joint }) => joint === 2)")
    x, y = page.evaluate("""() => {
      const { arm } = mctool;
      const { from, to } = arm.seen.findLast(({ joint }) => joint === 2);
      const { left, top } = arm.element.getBoundingClientRect();
      return [left + (from.x + 3 * to.x) / 4, top + (from.y + 3 * to.y) / 4];
    }""")
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 20, y)
    page.mouse.up()
    assert page.evaluate("() => mctool.page.axis") == 2
    desk.until("() => mctool.machine.history.latest(2).setpoint > 500")
    assert [desk.latest(n)["setpoint"] for n in (0, 1, 3, 4, 5)] == [0] * 5


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


def test_auto_tune_is_judged_undone_and_exported(desk, tmp_path):
    page = desk.page
    desk.choose(4)
    enter(page, "#interval", "1000")
    before = desk.param(4)
    enable(page)
    page.click("#tab-tune")
    page.click("#tune-go")
    desk.eventually(lambda: page.inner_text("#tune-verdict")[:1] in ("✓", "✗"))
    table = page.inner_text("#tune-result")
    assert "predicted" in table and "P, I, D" in table
    assert page.locator(".plots .uplot").count() == 1
    tuned = desk.param(4)
    assert tuned["a0"] != before["a0"] and page.input_value("#axis4-a0") == str(tuned["a0"])
    (servo,) = tomllib.loads(saved(page, "#tune-save", tmp_path).read_text())["servo"]
    assert (servo["axis"], servo["a0"], servo["b0"]) == (4, tuned["a0"], tuned["b0"])
    page.click("#tune-undo")
    desk.eventually(lambda: desk.param(4) == before)
    page.click("#tune-keep")
    desk.eventually(lambda: desk.param(4)["a0"] == tuned["a0"])
    page.click("#step-go")  # compared with what was asked for, too
    desk.eventually(lambda: page.inner_text("#tune-verdict")[:1] in ("✓", "✗"))
