# SPDX-License-Identifier: Apache-2.0
"""The page for those who see little, hear it read, or have no mouse: measured by axe-core."""

import pytest
from bench import TELEPHONE, enable

from mmcs.tool.pages import library_folder

pytestmark = pytest.mark.req("TOOL-1")
VIEWS = ("scope", "tune", "machine", "registers", "faults", "waves", "labs", "log")
RUN = """async () => {
  const found = await axe.run(document, { resultTypes: ["violations"], iframes: false });
  return found.violations.map(({ id, impact, nodes }) =>
    ({ id, impact, where: nodes.slice(0, 3).map((n) => `${n.target} ${n.failureSummary}`) }));
}"""
# live regions that a screen reader reads out by itself, and what Tab comes to
TALKS = """() => [...document.querySelectorAll(
    "[aria-live], [role=status], [role=alert], [role=log], output")]
  .filter((e) => e.getClientRects().length && e.getAttribute("aria-live") !== "off").length"""
STOPS = """() => [...document.querySelectorAll(
    "a[href], button, input, select, summary, iframe, [tabindex]")]
  .filter((e) => e.checkVisibility() && !e.disabled && e.tabIndex >= 0).length"""

SMALL = """() => [...document.querySelectorAll("button, input, select, summary")]
  .filter((e) => e.checkVisibility()).map((e) => [e, e.getBoundingClientRect()])
  .filter(([, { width, height }]) => Math.min(width, height) < 24)
  .map(([e, { width, height }]) => `${e.id || e.textContent} ${width} ${height}`)"""


def serious(frame, source: str) -> list:
    frame.evaluate(source + "; null")
    return [one for one in frame.evaluate(RUN) if one["impact"] in ("serious", "critical")]


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_no_serious_finding_in_any_view(desk, scheme):
    page = desk.page
    source = (library_folder().parent / "dev/node_modules/axe-core/axe.min.js").read_text()
    page.emulate_media(color_scheme=scheme)
    assert serious(desk.stop_frame, source) == []
    assert desk.stop_frame.get_by_role("button", name="STOP", exact=True).count() == 1
    assert page.evaluate(STOPS) <= 60
    for view in VIEWS:
        page.click(f"#tab-{view}")
        assert page.evaluate(TALKS) <= 4, view
        page.evaluate("() => document.querySelectorAll('details').forEach((d) => d.open = true)")
        assert serious(page, source) == [], view
    enable(page)
    assert serious(page, source) == []


def test_a_finger_finds_every_control_on_a_telephone(desk):
    page = desk.open(**TELEPHONE)
    assert page.frames[1].evaluate(SMALL) == []
    for view in VIEWS:
        page.locator(f"#tab-{view}").tap()
        page.evaluate("() => document.querySelectorAll('details').forEach((d) => (d.open = true))")
        assert page.evaluate(SMALL) == [], view
    page.close()


def test_nothing_overflows_at_1280_by_800_and_on_a_telephone(desk):
    page = desk.page
    wide = "() => document.documentElement.scrollWidth - document.documentElement.clientWidth"
    # of its panel too, with wide numbers: a panel that scrolls stays within the window's edge
    inside = """() => {
      document.querySelectorAll("details").forEach((d) => (d.open = true));
      for (const [name, wide] of [["count", "-65535"], ["A/D", "4095"], ["current", "-2048"]])
        document.getElementById(`axis0-${name}`).textContent = wide;
      const right = (e) => e.getBoundingClientRect().right;
      return [...document.querySelectorAll("#panels *, #tiles *, header *, #timebar *")]
        .filter((e) => e.checkVisibility() && !e.closest(".track"))
        .filter((e) => right(e) > Math.min(innerWidth, right(e.closest(".row, .panel, body"))) + 1)
        .map((e) => `${e.id || e.className || e.parentElement.textContent} ${right(e)}`);
    }"""
    for size in ({"width": 1280, "height": 800}, {"width": 390, "height": 844}):
        page.set_viewport_size(size)
        page.wait_for_timeout(400)
        assert page.evaluate(wide) <= 0 and page.evaluate(inside) == []
    order = [page.locator(one).bounding_box()["y"] for one in ("#stop", "#side", "#tiles", "#axis")]
    assert order == sorted(order)  # STOP and the scope first
    page.set_viewport_size({"width": 1280, "height": 800})
    page.evaluate("() => document.querySelectorAll('details').forEach((d) => (d.open = false))")
    panel = page.locator("#axis0-panel").bounding_box()
    tile = page.locator("#tile0").bounding_box()
    assert page.locator("#rewind").bounding_box()["width"] > 600
    assert tile["y"] > 0 and panel["y"] + panel["height"] <= 800


def test_dark_is_dark_and_a_wish_for_less_motion_is_kept(desk):
    page = desk.page
    bright = """() => Math.max(...getComputedStyle(document.querySelector("#axis0-panel"))
      .backgroundColor.match(/\\d+/g).slice(0, 3).map(Number))"""
    for scheme, good in (("light", range(200, 256)), ("dark", range(100))):
        page.emulate_media(color_scheme=scheme, reduced_motion="reduce")
        assert page.evaluate(bright) in good, scheme
    moving = """() => [...document.querySelectorAll("*")].map((e) => getComputedStyle(e))
      .filter((s) => parseFloat(s.transitionDuration) > 0 || s.animationName !== "none").length"""
    page.add_style_tag(content=".tile { transition: all 1s }")
    assert page.evaluate(moving) == 0
