# SPDX-License-Identifier: Apache-2.0
"""Panels show what the driver has, whoever changed it, and nothing else; an edit is a draft."""

import os
import signal

import pytest
from bench import chosen, pick

from mmcs import mcdef

pytestmark = pytest.mark.req("TOOL-1")


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
