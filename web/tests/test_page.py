# SPDX-License-Identifier: Apache-2.0
"""Chapter 3, control by control: each changes what the driver reads back."""

import tomllib

import pytest
from bench import chosen, enable, pick, picture, saved

pytestmark = pytest.mark.req("TOOL-1")
POS, VEL, TORQ, TEST1 = 1, 2, 3, 4
CURRENTS = """(() => {
  const { history } = mctool.machine;
  const rows = Array.from({ length: 600 }, (_, n) => Math.max(history.first, history.end - 1 - n));
  return rows.map((row) => history.value(row, history.column(4, "current")));
})()"""
FLAGS = {"COULCOMP": 0x10, "ADFB": 0x20, "ZEROFB": 0x40, "ADDMD": 0x80}


def choose(desk, what: str, value: str, want, axis: int = 0) -> None:
    """Chooses, and waits until the driver's mode word is as wanted."""
    desk.choose(axis)
    pick(desk.page, f'[id="axis{axis}-{what}"]', value)
    desk.eventually(lambda: want(desk.param(axis)["mode"]))


def enter(page, selector: str, text: str) -> None:
    page.fill(selector, text)
    page.press(selector, "Enter")


def test_a_panel_for_each_axis_and_nothing_written_at_the_start(desk):
    for axis in range(6):
        desk.choose(axis)
        assert desk.page.locator(".panel").get_attribute("id") == f"axis{axis}-panel"
        param = desk.param(axis)
        assert (param["a0"], param["b0"], param["mode"], param["ilim"]) == (1, 1, 0, 1024)
    assert not desk.state()["enabled"]


def test_modes_sources_feedback_and_switches(desk):
    for name, word in (("pos", POS), ("vel", VEL), ("torq", TORQ), ("test1", TEST1), ("off", 0)):
        choose(desk, "mode", name, lambda mode, word=word: mode & 0xF == word)
    choose(desk, "mode", "vel", lambda mode: mode & 0xF == VEL)
    desk.page.wait_for_selector("#axis0-panel .setpoint:has-text('counts/sample')")
    choose(desk, "setpoint source", "ad", lambda mode: mode & FLAGS["ADDMD"])
    choose(desk, "setpoint source", "square", lambda mode: not mode & FLAGS["ADDMD"])
    desk.page.wait_for_selector("#axis0-panel .setpoint:has-text('Amplitude')")
    choose(desk, "feedback", "ad", lambda mode: mode & FLAGS["ADFB"])
    choose(desk, "feedback", "zero", lambda mode: mode & FLAGS["ZEROFB"])
    desk.page.check('[id="axis0-Coulomb compensation"]')
    desk.eventually(lambda: desk.param(0)["mode"] & FLAGS["COULCOMP"])
    desk.choose(3)
    desk.page.check("#axis3-LED")
    desk.until("() => (mctool.machine.history.lights(1) >> 9) & 1")


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
    assert desk.param(0)["mode"] == VEL | FLAGS["ADFB"]


@pytest.mark.req("SYN-1")
def test_gains_in_percent_and_every_parameter_by_number(desk):
    page = desk.page
    desk.choose(1)
    enter(page, '[id="axis1-P gain"]', "4000")
    desk.eventually(lambda: desk.param(1)["a0"] == 40 * desk.param(1)["b0"])
    enter(page, '[id="axis1-D gain"]', "20,5")
    desk.eventually(lambda: desk.param(1)["a1"] < 0)
    param = desk.param(1)
    assert (param["a0"] + param["a1"]) / param["b0"] == pytest.approx(40, rel=0.01)
    assert -param["a1"] / param["b0"] * 0.002 == pytest.approx(0.205, rel=0.01)
    enter(page, '[id="axis1-P gain"]', "1,234")  # refused: it leaves itself and the others
    desk.eventually(lambda: "no gain" in page.inner_text("#said"))
    desk.eventually(lambda: page.input_value('[id="axis1-P gain"]') == "4000")
    assert desk.param(1) == param
    page.click("#axis1-panel summary")
    for name, value in (("ilim", 500), ("plo", -7000), ("clkdivisor", 2), ("ic_neg", 33)):
        enter(page, f"#axis1-{name}", str(value))
        desk.eventually(lambda name=name, value=value: desk.param(1)[name] == value)
    enter(page, "#axis1-b0", "0")  # the driver refuses: what is shown is what it has
    desk.eventually(lambda: page.input_value("#axis1-b0") == str(desk.param(1)["b0"]) != "0")


def test_interval_diagnostics_and_double_buffering(desk):
    page = desk.page
    enter(page, "#interval", "1000")
    desk.eventually(lambda: desk.link.request("call", request="MGETINTERVAL")["value"] == 1000)

    def port_b() -> int:
        return desk.link.request("load", offset=0x03)["value"]

    page.click(".gear summary")
    pick(page, "#diag", "2")
    desk.eventually(lambda: port_b() & 1 == 0)  # the synthetic encoder lines
    pick(page, "#diag", "0")
    page.check("#double")
    desk.eventually(lambda: port_b() & 0x09 == 0x09)


@pytest.mark.req("SRV-6")
def test_diag_puts_out_codes_and_test1_has_the_amplitude_of_ilim(desk):
    page = desk.page
    enable(page)
    desk.choose(2)
    pick(page, "#axis2-mode", "diag")
    enter(page, "#axis2-setpoint", "120")
    desk.until("() => mctool.machine.history.latest(2).current === 120")
    desk.choose(4)
    page.click("#axis4-panel summary")
    enter(page, "#axis4-ilim", "60")
    pick(page, "#axis4-mode", "test1")
    desk.eventually(lambda: "triangle of ±60 " in page.inner_text("#axis4-panel .note"))
    for peak in (60, -60):
        desk.until("value => " + CURRENTS + ".includes(value)", peak)
    assert desk.page.evaluate(f"() => Math.max(...{CURRENTS}.map(Math.abs))") == 60


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


def test_everything_by_keyboard(desk):
    page = desk.page
    desk.choose(1)
    pick(page, "#axis1-mode", "torq")
    page.click("#tab-log")
    page.keyboard.press("e")
    page.keyboard.press("Enter")
    desk.until("() => mctool.machine.enabled")
    page.keyboard.press("c")
    desk.eventually(lambda: "has control" in page.inner_text("#said"))  # it is not given back
    page.keyboard.press("1")
    assert page.evaluate("() => document.activeElement.id") == "axis1-panel"
    page.keyboard.press("ArrowRight")
    desk.until("() => mctool.machine.history.latest(1).setpoint > 0")
    page.keyboard.press("Space")
    desk.until("() => !mctool.machine.enabled")


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


MISTAKES = {  # what is typed where: what the page says
    "#axis0-setpoint": {"2000": "more than ilim, 1024", "": "no setpoint", "1e400": "no setpoint"},
    "#interval": {"50": "interval, µs", "1000000": "panics by", "600000000": "timers do not make"},
    "#axis0-ilim": {"1,234": "whole number", "": "whole number"},
    "[id='axis0-P gain']": {"": "no gain in %", "1e400": "no gain in %"},
}


def test_a_sentence_for_each_mistake(desk):
    page = desk.page
    choose(desk, "mode", "torq", lambda mode: mode == TORQ)
    page.click("#axis0-panel summary")
    for where, typed in MISTAKES.items():
        for text, said in typed.items():
            enter(page, where, text)
            desk.eventually(lambda said=said: said in page.inner_text("#said"))
    enter(page, "[id='axis0-P gain']", "-100")
    desk.eventually(lambda: "drives away" in page.inner_text("#axis0-panel .warnings"))
    page.evaluate("() => mctool.machine.change(0, { plo: -50, phi: 50, mode: 1 })")
    desk.eventually(lambda: chosen(page, "#axis0-mode") == "pos")
    enter(page, "#axis0-setpoint", "51")
    desk.eventually(lambda: "beyond the limits plo and phi, -50 to 50" in page.inner_text("#said"))
    enter(page, "#interval", "2000")
    desk.eventually(lambda: desk.link.request("call", request="MGETINTERVAL")["value"] == 2000)
    page.click("#tab-tune")
    enable(page)
    for field, name in (("#tune-wn", "bandwidth"), ("#tune-half", "safe counts")):
        page.fill(field, "")
        page.click("#tune-go")
        desk.eventually(lambda name=name: name in page.inner_text("#said"))
        page.fill(field, "1000")
