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
AXIS = 2
# every field of the panel and what it shows for these parameters
PARAM = {
    "a2": 300, "a1": -8000, "a0": 9000, "b2": 0, "b1": -64, "b0": 64, "ic_pos": 11, "ic_neg": 12,
    "clkdivisor": 3, "ilim": 700, "ilimax": 5, "plo": -9000, "phi": 8000, "adc_a": 2, "adc_b": -40,
    "ipole": 200,
}  # fmt: skip
SHOWN = """(axis) => {
  const of = (id) => document.getElementById(`axis${axis}-${id}`);
  const panel = document.getElementById(`axis${axis}-panel`);
  const fields = [...panel.querySelectorAll(".fields input")];
  return {
    mode: of("mode").dataset.value,
    source: of("setpoint source").dataset.value,
    feedback: of("feedback").dataset.value,
    coulomb: of("Coulomb compensation").checked,
    led: of("LED").checked,
    setpoint: of("setpoint").value,
    slider: Number(of("setpoint slider").value),
    row: of("setpoint").parentElement.hidden,
    gains: ["P", "I", "D"].map((g) => of(`${g} gain`).value),
    coefficients: panel.querySelector(".coefficients").textContent,
    fields: Object.fromEntries(fields.map((f) => [f.parentElement.innerText.trim(), f.value])),
    interval: document.getElementById("interval").value,
    diag: document.getElementById("diag").dataset.value,
    double: document.getElementById("double").checked,
    drafts: document.querySelectorAll(".draft").length,
  };
}"""


class Outsider:
    """Another program at the machine that changes everything."""

    def __init__(self, desk):
        self.link = Link(path=desk.tool.socket)
        self.link.request("open", mode="rw")

    def call(self, request: str, value: int | None = None) -> None:
        self.link.request("call", request=request, **({} if value is None else {"value": value}))

    def change(self, axis: int, **param: int) -> None:
        self.link.request("change", axis=axis, param=param)


@pytest.fixture
def outside(desk):
    """The page looks on; another program has the machine."""
    desk.page.click("#control")
    desk.until("() => !mctool.machine.controls")
    desk.choose(AXIS)
    desk.page.evaluate("() => document.querySelectorAll('details').forEach((d) => d.open = true)")
    one = Outsider(desk)
    yield one
    one.link.close()


def shows(desk, **wanted) -> None:
    def so() -> bool:
        now = desk.page.evaluate(SHOWN, AXIS)
        return all(now[name] == value for name, value in wanted.items()) and now["drafts"] == 0

    desk.eventually(so)


def test_every_field_changed_by_another_program_is_shown(desk, outside):
    outside.change(AXIS, **PARAM, mode=VEL | mcdef.COULCOMP)
    fields = {name: str(value) for name, value in (PARAM | {"mode": VEL | mcdef.COULCOMP}).items()}
    shows(desk, mode="vel", coulomb=True, fields=fields, row=False, source="slider",
          coefficients="a 9000 -8000 300  b 64 -64 0")  # fmt: skip
    interval_s = 0.002 * 3
    p = 8000 / 64 - 2 * 300 / 64
    gains = [p, 1300 / 64 / interval_s, 300 / 64 * interval_s]
    shows(desk, gains=[f"{100 * g:.2f}".rstrip("0").rstrip(".") for g in gains])
    for word, name in ((POS, "pos"), (TORQ, "torq"), (4, "test1"), (0, "off"), (VEL, "vel")):
        outside.change(AXIS, mode=word)
        shows(desk, mode=name, row=name in ("test1", "off"))
    outside.change(AXIS, mode=VEL | mcdef.ADFB)
    shows(desk, feedback="ad")
    outside.change(AXIS, mode=VEL | mcdef.ZEROFB | mcdef.ADDMD)
    shows(desk, feedback="zero", source="ad", row=True)
    outside.change(AXIS, mode=TORQ)
    outside.call("MENABLE")
    outside.link.request("write", setpoints=[0, 0, 37])
    shows(desk, setpoint="37", slider=37, source="slider", feedback="encoder")
    outside.call("MSETLED", 0x100 | AXIS)
    shows(desk, led=True)
    for request, value, field in (("MSETINTERVAL", 1000, {"interval": "1000"}),
                                  ("MDIAGMODE", 2, {"diag": "2"}),
                                  ("MDACMODE", 1, {"double": True})):  # fmt: skip
        outside.call(request, value)
        shows(desk, **field)
    desk.until("() => document.querySelector('.lamp').textContent.includes('servo on')")
    outside.change(AXIS, mode=0)
    outside.call("MSETDAC", (2048 + 55) << 8 | AXIS)
    shows(desk, mode="diag", setpoint="55")
    outside.link.request("stop")
    shows(desk, mode="off", row=True)
    assert desk.page.is_disabled(f"#axis{AXIS}-ilim")


def test_the_way_back_in_time_and_another_page_are_shown(desk, outside):
    outside.change(AXIS, ilim=321, mode=POS)
    shows(desk, mode="pos")
    moment = outside.link.request("snapshot")["snapshot"]["id"]
    outside.change(AXIS, ilim=654, mode=VEL)
    outside.call("MSETINTERVAL", 4000)
    shows(desk, mode="vel", interval="4000")
    outside.link.request("rewind", snapshot=moment)
    shows(desk, mode="pos", interval="2000")
    assert desk.page.input_value(f"#axis{AXIS}-ilim") == "321"
    other = desk.open()  # and takes control, which nobody has
    desk.choose(AXIS, other)
    pick(other, f"#axis{AXIS}-mode", "torq")
    shows(desk, mode="torq")
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


@pytest.mark.req("PAN-1")
def test_enable_asks_while_the_button_is_pressed(desk):
    page = desk.page
    desk.stop_frame.click("#press")

    desk.until("() => mctool.machine.input('estop')")
    page.click("#enable")
    desk.eventually(lambda: desk.state()["enabled"] or page.inner_text("#said") != "")
    assert not desk.state()["enabled"] and "Release it first" in page.inner_text("#said")
    assert "released hand-held button" in page.inner_text("#banner")
    page.click("#enable")
    desk.eventually(lambda: desk.state()["enabled"])


def test_the_banner_tells_the_cause_and_what_comes_next(desk):
    page = desk.page
    assert "At rest" in page.inner_text("#cause") and "PANIC" not in page.inner_text("#cause")
    page.click("#enable")
    page.wait_for_selector("#cause:has-text('Servo on')")
    desk.stop_frame.click("#press")
    desk.eventually(lambda: "the hand-held button was pressed" in page.inner_text("#cause"))
    assert "lacks a released hand-held button" in page.inner_text("#next")
    desk.stop_frame.click("#press[aria-pressed=true]")
    ask = "(input) => mctool.machine.link.request('input', input)"
    for name, index, words in (("cable", 0, "ribbon cable"), ("card_absent", 1, "card 1")):
        healthy = 1 if name == "cable" else 0
        page.evaluate(ask, {"name": name, "index": index, "value": 1 - healthy})
        desk.eventually(lambda words=words: words in page.inner_text("#next"))
        desk.eventually(lambda: page.inner_text("#cause").startswith("No sample for"))
        assert words in page.inner_text("#next")
        page.evaluate(ask, {"name": name, "index": index, "value": healthy})
    desk.eventually(lambda: page.inner_text("#next").startswith("Enable (E"))


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


def test_the_past_is_tinted_its_controls_are_dead_and_a_future_left_is_a_branch(desk):
    """The test drives the clock: the machine is paused."""
    page = desk.page

    def advance(s: float) -> None:
        t = page.evaluate("s => mctool.machine.link.request('advance', { seconds: s })", s)["t"]
        desk.until("t => mctool.machine.history.now > t - 0.01", t)

    choose(desk, "mode", "pos", lambda mode: mode == POS)
    page.click("#pause")
    enable(page)
    page.evaluate("() => mctool.machine.change(0, { a0: 5 })")
    page.evaluate("() => mctool.machine.setSetpoint(0, 3)")
    advance(0.2)
    moment = desk.link.request("snapshot")["snapshot"]["t"]
    advance(0.2)
    choose(desk, "mode", "vel", lambda mode: mode == VEL)
    page.evaluate("() => mctool.machine.change(0, { a0: 7 })")
    enter(page, "#interval", "4000")
    desk.until("() => mctool.machine.driver.interval_us === 4000")
    page.click("#control")  # gives it back, and stops
    desk.until("() => !mctool.machine.enabled && !mctool.machine.controls")
    page.click("#control")
    desk.until("() => mctool.machine.controls")
    page.evaluate("t => mctool.page.look(t)", moment)
    dead = "#enable, #robot-gains, #clear, #interval, #axis0-mode [value=off], #axis0-ilim"
    assert [one for one in dead.split(", ") if page.is_enabled(one)] == []
    assert page.inner_text("#tile0 .mode") == "Pos" and chosen(page, "#axis0-mode") == "pos"
    then = {"#axis0-setpoint": "3", "#interval": "2000", "#axis0-a0": "5"}
    assert {one: page.input_value(one) for one in then} == then
    assert "servo on" in page.inner_text(".lamp >> nth=0")
    assert page.inner_text("#cause").endswith("servo on, brakes off.")
    assert page.evaluate("() => document.body.classList.contains('past')")
    page.click("#tab-tune")
    assert page.evaluate("() => document.querySelector('.tune').inert")
    page.click("#rewind-go")
    desk.until("t => mctool.page.moment === null && mctool.machine.history.now <= t", moment)
    advance(1.0)
    desk.until("() => document.querySelector('.branch') && document.querySelector('.mark.left')")
    assert page.is_enabled("#axis0-ilim")
