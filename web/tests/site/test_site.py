# SPDX-License-Identifier: Apache-2.0
"""The machine in a page: to the bit the native one, offline, on a telephone, for a minute."""

import json

import pytest
from bench import TELEPHONE, enable, picture, saved, until

from mmcs import load, parse, replay, simulate

pytestmark = pytest.mark.req("TOOL-1")
MINUTE_S = 60.0
DONE = "() => document.body.dataset.hash || document.body.dataset.failed"


def native(name: str, sets: tuple[str, ...] = ()):
    return simulate(load(name, *sets))


def finished(page) -> str:
    page.wait_for_function(DONE)
    return page.evaluate(DONE)


@pytest.mark.req("SIM-3")
@pytest.mark.parametrize("name", ["lab500", "puma560", "puma560_bounce"])
def test_the_page_s_hash_is_the_native_one(opened, name):
    result = native(name)
    page = opened(f"?scenario={name}&speed=0")
    assert finished(page) == result.hash


@pytest.mark.req("SIM-3")
def test_a_record_of_the_page_replays_natively_with_what_a_person_did(opened, tmp_path):
    """Gains and faults while it runs are in the record, as [[call]] and [[event]]."""
    page = opened("?scenario=puma560&seed=7&paused=1&deadman=240000")
    until(page, "mctool.machine.controls && mctool.machine.enabled")
    page.evaluate("""async () => {
      const { machine } = mctool;
      const first = [
        machine.change(1, { a0: 4000, b0: 64 }),
        machine.link.request("input", { name: "pot_noise", index: 0, value: 0.01 }),
        machine.link.call("MDACMODE", { value: 0 }),
      ];
      await machine.link.request("pace", { paused: false });
      await Promise.all(first);
      await machine.change(2, { ilim: 700 });
      await machine.link.request("pace", { speed: null });
    }""")
    hash_ = finished(page)
    path = saved(page, "#record", tmp_path)
    record = parse(path, json.loads(path.read_text()))
    assert record.hash == hash_ and record.data["seed"] == 7
    asked = [call["request"] for call in record.data["call"]]
    assert asked == ["MSETPARAM", "MDACMODE", "MSETPARAM"]
    assert record.data["event"][-1]["input"] == "pot_noise"
    assert replay(record) == (hash_, None, "")
    page.click("#permalink")
    page.wait_for_url("**#record=*")
    assert len(page.url) < 10_000
    assert finished(opened(page.url.partition("/web/")[2])) == hash_


@pytest.mark.req("DRV-9")
def test_stop_works_and_a_hung_page_stops_the_machine(opened):
    page = opened("?scenario=puma560&plays=0&deadman=240000")  # starved, it is silent for long
    enable(page)
    frame = page.frames[1]
    frame.click("#stop")
    until(page, "!mctool.machine.enabled")
    until(frame, "Number(document.body.dataset.count) > 0")
    enable(page)
    page.evaluate("""async () => {
      const { machine } = mctool;
      await machine.dropControl();
      machine.deadman_ms = 1000;
      await machine.takeControl();
      await machine.link.call("MENABLE");
      for (const t = Date.now(); Date.now() - t < 4000; );
    }""")
    until(page, "!mctool.machine.enabled && !mctool.machine.controls")


def test_it_works_without_a_network(opened):
    page = opened("?scenario=lab500&speed=0")
    page.evaluate("() => navigator.serviceWorker.ready")
    until(page, "caches.keys().then((names) => names.length === 1)")
    page.reload()
    page.context.set_offline(True)
    page.goto(page.url.split("?")[0] + "?scenario=puma560_bounce&speed=0")
    assert finished(page) == native("puma560_bounce").hash


def test_a_minute_of_motion_without_an_exception_and_without_growth(opened):
    """A wrist swings to and fro; memory is looked at when the rings are full, and at the end."""
    page = opened("?scenario=puma560&plays=0&deadman=240000")
    enable(page)
    page.evaluate("() => mctool.machine.change(4, { ilim: 200, mode: 4 })")  # Test1
    page.evaluate("() => mctool.machine.link.request('pace', { speed: null })")
    taken = []
    for t in (MINUTE_S / 2, MINUTE_S):
        until(page, f"mctool.machine.history.now > {t}")
        taken.append(page.evaluate("() => mctool.machine.link.request('memory')")["bytes"])
    assert taken[0] == taken[1]
    assert page.evaluate("() => mctool.machine.history.lost") == 0
    assert page.evaluate("() => mctool.machine.enabled")


@pytest.mark.pictures
def test_a_telephone_can_be_used(opened):
    page = opened("?scenario=puma560", **TELEPHONE)
    frame = page.frames[1]
    stop = frame.locator("#stop").bounding_box()
    assert min(stop["width"], stop["height"]) >= 44  # a finger
    page.locator("#tab-faults").tap()
    page.wait_for_selector("#fault-all")
    picture(page, "web_telephone")
    frame.locator("#stop").tap()
    until(page, "!mctool.machine.enabled")


@pytest.mark.pictures
def test_the_first_motion_comes_soon(opened):
    page = opened("?scenario=puma560")
    page.wait_for_function("""() => {
      const { history } = mctool.machine;
      const at = (row, n) => history.value(row, history.column(n, 'encnow'));
      return history.end > history.first && [0, 1, 2, 3, 4, 5].some((n) =>
        Math.abs(at(history.end - 1, n) - at(history.first, n)) > 2);
    }""")
    page.click("#tab-machine")
    page.wait_for_timeout(800)
    picture(page, "web")
