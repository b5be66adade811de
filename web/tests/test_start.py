# SPDX-License-Identifier: Apache-2.0
"""The page as under SunView."""

import pytest
from bench import picture

pytestmark = pytest.mark.req("TOOL-1")


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
