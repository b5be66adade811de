# SPDX-License-Identifier: Apache-2.0
"""What the site saves, reads again and fetches, which is nothing from elsewhere."""

import numpy as np
import pytest
from bench import saved

from mmcs import load, make_record, simulate, write_record

DONE = "() => document.body.dataset.hash"


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
