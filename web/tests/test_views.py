# SPDX-License-Identifier: Apache-2.0
"""Scope, faults, registers, the past, and a stream without a loss, in a real browser."""

import re

import pytest
from bench import enable, pick, saved
from test_page import choose, enter

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

CHOOSE = """(share) => {
  const slider = document.getElementById("rewind");
  slider.value = share * 1000;
  slider.dispatchEvent(new Event("input"));
  return mctool.page.moment;
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
    assert "encnow" not in page.inner_text("body")  # the driver's name of what people call count
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
    path = saved(page, "#scope-mcap", tmp_path).rename(tmp_path / "saved.mcap")
    assert path.read_bytes()[:5] == b"\x89MCAP"


def test_fingers_carry_and_stretch_the_scope(desk):
    page = desk.page
    touch = page.context.new_cdp_session(page)
    box = page.locator(".screen").bounding_box()
    view = "() => mctool.page.span"

    def fingers(kind: str, *xs: float) -> None:
        points = [{"x": box["x"] + x * box["width"], "y": box["y"] + 60, "id": n}
                  for n, x in enumerate(xs)]  # fmt: skip
        touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    page.click("#scope-run")  # holds
    before = page.evaluate(view)
    fingers("touchStart", 0.4)
    fingers("touchMove", 0.5)
    fingers("touchMove", 0.7)
    fingers("touchEnd")
    desk.until(f"before => ({view})()[1] < before - 0.2", before[1])
    left, right = page.evaluate(view)
    wide = right - left
    assert wide == pytest.approx(before[1] - before[0])
    narrower = f"wide => {{ const [a, b] = ({view})(); return b - a < wide }}"
    page.mouse.move(box["x"] + 0.7 * box["width"], box["y"] + 60)
    page.mouse.wheel(0, -200)
    desk.until(narrower, 0.9 * wide)
    fingers("touchStart", 0.4, 0.6)
    fingers("touchMove", 0.3, 0.7)
    fingers("touchEnd")
    desk.until(narrower, 0.6 * wide)
    left, _ = page.evaluate(view)
    page.press(".screen", "ArrowLeft")
    assert page.evaluate(view)[0] < left
    page.press(".screen", "0")  # rolls on
    page.press("#scope-window", "End")
    desk.until(f"() => {{ const [a, b] = ({view})(); return b - a > 599 }}")  # all that is kept


def test_panes_stand_side_by_side_as_a_person_left_them(desk):
    """The scope is in sight beside every other view; bars between panes move by mouse and keys."""
    page = desk.page
    wide = "(s) => document.querySelector(s).getBoundingClientRect().width"
    alone = page.evaluate(wide, ".scope")
    page.click("#tab-registers")
    scope, other = page.evaluate(wide, ".scope"), page.evaluate(wide, ".registers")
    assert 0.4 * alone < scope < 0.6 * alone and 0.4 * alone < other < 0.6 * alone
    box = page.locator("#splitter-scope").bounding_box()
    page.mouse.move(box["x"] + 3, box["y"] + 50)
    page.mouse.down()
    page.mouse.move(box["x"] + 3 + 0.2 * alone, box["y"] + 60)
    page.mouse.up()
    assert page.evaluate(wide, ".scope") == pytest.approx(scope + 0.2 * alone, abs=0.02 * alone)
    axis = page.evaluate(wide, "#axis")
    page.focus("#splitter-axis")
    page.keyboard.press("ArrowLeft")
    assert page.evaluate(wide, "#axis") < axis
    assert desk.latest(0)["setpoint"] == 0  # nothing was nudged
    left = [page.evaluate(wide, one) for one in ("#axis", ".scope", ".registers")]
    page.reload()
    page.wait_for_selector("body.ready")
    assert left == [page.evaluate(wide, one) for one in ("#axis", ".scope", ".registers")]


def test_back_to_a_moment_and_on_from_there(desk):
    page = desk.page
    page.evaluate("() => mctool.machine.link.request('ring', { every_s: 0.1, count: 40 })")
    desk.eventually(lambda: desk.state()["time"] > 5)
    before = page.evaluate(CHOOSE, 0.6)
    desk.eventually(lambda: abs(float(page.inner_text("#time")[:-2]) - before) < 0.02)
    page.click("#now")
    page.click("#pause")
    desk.eventually(lambda: desk.state()["paused"])
    then = desk.state()["time"]
    kept = [s["t"] for s in desk.link.request("snapshots")["snapshots"]]
    # the page asks twice a second how far back the ring reaches
    desk.eventually(lambda: page.evaluate(CHOOSE, 0.3) >= kept[0])
    wanted = page.evaluate("() => mctool.page.moment")
    page.click("#rewind-go")
    desk.eventually(lambda: desk.state()["time"] < then - 0.5)
    back = desk.state()["time"]
    assert back == pytest.approx(max(t for t in kept if t <= wanted), abs=1e-6)
    desk.until("() => mctool.page.moment === null")  # it has heard of it
    page.evaluate("t => mctool.page.look(t)", back)
    page.click("#waves")
    desk.until("() => document.querySelector('.waves').dataset.from")
    assert float(page.input_value("#waves-t")) == pytest.approx(back, abs=1e-6)
    page.evaluate("() => mctool.page.look(null)")
    page.click("#step")
    desk.eventually(lambda: desk.state()["time"] > back)
    page.click("#pause")
    desk.eventually(lambda: desk.state()["time"] > then)


def test_minutes_are_saved_without_a_pause_of_the_page(desk, tmp_path):
    """Text is made by a Worker, a chunk at a time, so the page says that it is there."""
    page = desk.page
    page.evaluate("""() => {
      const { history } = mctool.machine;
      const rows = 120_000, ints = new Array(history.rowInts).fill(-123456);
      for (let n = 0; n < rows; n++) history.add(n, history.now + 0.001, ints);
      window.turns = 0;
      const turn = () => { turns++; setTimeout(turn) };
      turn();
    }""")
    page.click("#scope-more")
    path = saved(page, "#scope-save", tmp_path)
    assert len(path.read_text().splitlines()) > 120_000
    # the page's own turns come between the pieces, of which there are fifteen
    assert page.evaluate("() => turns") >= 15


HOLD = """() => {
  const ask = window.requestAnimationFrame;
  window.requestAnimationFrame = (f) => (window.holds ? heldFrames.push(f) : ask(f));
  Object.assign(window, { heldFrames: [], holds: true });
}"""


def test_state_waits_for_no_frame(desk):
    """A lid closed, a hidden tab, a slow GPU: lamps, banner and count go on, pictures come back."""
    page = desk.page
    choose(desk, "mode", "pos", lambda mode: mode == 1, 4)
    page.evaluate(HOLD)
    desk.until("() => heldFrames.length")  # the page waits for its next frame, which does not come
    enable(page)
    desk.until("() => document.querySelector('.lamp').textContent.includes('servo on')")
    desk.until("() => document.getElementById('cause').textContent.startsWith('Servo on')")
    enter(page, "#axis4-setpoint", "694")
    desk.until("() => mctool.machine.history.latest(4).setpoint === 694")
    desk.eventually(lambda: abs(int(page.inner_text("#axis4-count")) - 694) < 200)
    assert page.evaluate("() => heldFrames.length") == 1
    page.evaluate(WRITTEN)
    page.wait_for_timeout(600)  # longer than pictures are apart
    assert page.evaluate("() => written.length") == 0
    page.evaluate("""() => {
      holds = false;
      heldFrames.splice(0).forEach((f) => f(performance.now()));
    }""")
    desk.until("() => written.length")


WRITTEN = """() => {
  window.written = [];
  const write = CanvasRenderingContext2D.prototype.fillText;
  CanvasRenderingContext2D.prototype.fillText = function (text, ...at) {
    written.push([this.textAlign, String(text)]);
    write.call(this, text, ...at);
  };
}"""


def test_counts_have_whole_ticks_and_coherence_is_drawn(desk):
    page = desk.page
    for name in ("error 0", "current 0"):  # one lane, with room for many ticks
        page.get_by_label(f"remove {name}").click()
    page.evaluate(WRITTEN)
    desk.until("() => written.length > 40")
    ticks = {text for align, text in page.evaluate("() => written") if align == "right"}
    assert len(ticks) > 1 and all(re.fullmatch(r"[-−]?[\d,]+", tick) for tick in ticks), ticks
    page.evaluate("""() => { mctool.page.advice.request = async () =>
      ({ hz: [1, 40], gain_db: [0, -9], phase_deg: [0, -90], coherence: [1, 0.5] }) }""")
    enable(page)
    page.click("#tab-tune")
    page.click("#bode-go")
    desk.until("() => written.some(([, text]) => text === 'coherence')")
