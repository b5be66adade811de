# SPDX-License-Identifier: Apache-2.0
"""The site in the hands of somebody who means no good, or does not know: one sentence, and on."""

import json

import numpy as np
import pytest
from bench import pick, saved, unfold

from mmcs import load, make_record, simulate, write_record

DONE = "() => document.body.dataset.hash"


@pytest.mark.req("TOOL-1")
@pytest.mark.parametrize("query,said", [
    ("?scenario=../../x", "there is no scenario"),
    ("?scenario=%3Cimg%20src%3Dx%20onerror%3Dalert(1)%3E", "there is no scenario <img"),
    ("?seed=seven", 'seed: "seven" is not a whole number'),
    ("?seed=-1", 'seed: "-1" is not'),
    ("?speed=fast", 'address: speed="fast" is not a number'),
    ("?deadman=never", 'address: deadman="never" is not'),
    ("?t=soon", 'address: t="soon" is not'),
    ("#record=ab%00c", "address: its record is damaged"),
    ("#record=", "address: its record is damaged"),
])  # fmt: skip
def test_an_address_that_cannot_be_is_told_and_left(opened, query, said):
    page = opened(query)
    assert page.evaluate("() => document.body.dataset.failed").startswith(said)
    assert said in page.inner_text("#said")
    unfold(page, "#scenario", "lab500")
    page.wait_for_url("**scenario=lab500**")
    if "scenario" in query:  # else the address still holds what was wrong
        page.wait_for_selector("body.ready")


@pytest.mark.req("TOOL-1", "SIM-3")
def test_the_saved_log_is_the_native_one_and_a_record_runs_again(opened, tmp_path):
    result = simulate(load("lab500", "seed=5", "duration=0.3", "expect=[]"))
    record = write_record(make_record(result, "native"), tmp_path)
    page = opened("?scenario=puma560_bounce")
    page.set_input_files("#record-file", record)
    page.wait_for_url("**#record=*")
    for _ in range(2):
        page.wait_for_function(DONE)
        assert page.evaluate(DONE) == result.hash
        assert page.inner_text("#scenario summary") == "Scenario lab500"
        assert page.input_value("#seed") == "5"
        assert page.inner_text("#hash").endswith("as recorded")
        assert page.get_attribute("#permalink", "href") == page.url
        found = np.genfromtxt(saved(page, "#log", tmp_path), delimiter=",", skip_header=1)
        assert found.shape == result.log.shape
        assert np.allclose(found, result.log, rtol=0, atol=6e-7)  # times and angles have digits
        whole = [n for n in range(1, found.shape[1]) if n % 7]
        assert (found[:, whole] == result.log[:, whole]).all()
        with page.expect_navigation():
            page.click("#again")
        page.wait_for_selector("body.ready")
    strange = json.loads(record.read_text())
    strange["data"]["call"] = [{"at": 0.1, "request": "MCALIB", "axis": 40}]
    record.write_text(json.dumps(strange))
    page.set_input_files("#record-file", record)
    page.wait_for_selector("body[data-failed]")
    assert page.inner_text("#said") == "this is no run.mmcs: its calls cannot be"


@pytest.mark.req("TOOL-1", "SIM-3")
def test_the_link_holds_scenario_and_seed(opened):
    page = opened("?scenario=puma560&seed=1&speed=0")
    page.fill("#seed", "9")
    with page.expect_navigation():
        page.press("#seed", "Enter")
    page.wait_for_selector("body.ready")
    page.click("#scenario summary")
    page.frames[1].click("#stop", trial=True)  # nothing covers it
    pick(page, "#scenario", "lab500")
    page.wait_for_url("**scenario=lab500**")
    page.wait_for_selector("body.ready")
    held = page.get_attribute("#permalink", "href").partition("?")[2]
    assert {"scenario=lab500", "seed=9"} <= set(held.split("&"))
    other = opened(f"?{held}")
    other.wait_for_function(DONE)
    assert other.evaluate(DONE) == simulate(load("lab500", "seed=9")).hash


@pytest.mark.req("TOOL-1")
def test_nothing_is_fetched_from_elsewhere_and_the_book_is_searched(opened, address):
    page = opened("../docs/index.html", ready=False)
    asked = []
    page.context.on("request", lambda request: asked.append(request.url))
    page.reload()
    page.locator("input.md-search__input").fill("heartbeat")
    page.wait_for_selector(".md-search-result__link[href*='.html']")
    for chapter in ("hardware/adaptor.html", "use/driver.html", "use/web.html"):
        page.goto(f"{address}../docs/{chapter}")
    page.goto(f"{address}?scenario=lab500")
    page.wait_for_function(DONE)
    root = address.removesuffix("web/")
    own = (root, f"blob:{root}", "data:")
    assert [url for url in asked if not url.startswith(own)] == []
    assert len(asked) > 30
