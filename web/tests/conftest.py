# SPDX-License-Identifier: Apache-2.0
"""The page in a real browser: a machine, its tool, and Chromium."""

from __future__ import annotations

import shutil

import pytest
from playwright.sync_api import sync_playwright

from mmcs import BUILD
from mmcs.device.link import Link
from mmcs.tool.launch import start

FLAGS = [
    "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--use-gl=angle", "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader", "--site-per-process",
]  # fmt: skip
PICTURES = BUILD / "tool"


@pytest.fixture(scope="session")
def browser():
    path = shutil.which("chromium")
    assert path, "chromium is missing; `make tool-test` installs it"
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=path, args=FLAGS)
        yield chromium
        chromium.close()


class Desk:
    """A running tool with one page open, and a link of the test's own to the same machine."""

    def __init__(self, browser, tool, options: str = ""):
        self.browser, self.tool = browser, tool
        self.page = self.open(options)
        name = tool.processes["machine"].args
        self.link = Link(name[name.index("--dev") + 1])
        self.link.request("open", mode="r")

    def open(self, options: str = ""):
        page = self.browser.new_page(viewport={"width": 1280, "height": 800})
        page.set_default_timeout(240_000)  # a loaded computer is slow, not wrong
        page.errors = []
        page.on("pageerror", lambda error: page.errors.append(str(error)))
        page.goto(self.tool.address + options)
        page.wait_for_selector("body.ready")
        return page

    @property
    def stop_frame(self):
        return self.page.frames[1]

    def param(self, axis: int) -> dict:
        return self.link.request("call", request="MGETPARAM", axis=axis)["param"]

    def latest(self, axis: int) -> dict:
        return self.page.evaluate("n => mctool.machine.history.latest(n)", axis)

    def state(self) -> dict:
        return self.link.request("hello")

    def until(self, what: str, argument=None) -> None:
        """Waits for a condition in the page."""
        self.page.wait_for_function(what, arg=argument)

    def eventually(self, true) -> None:
        """Waits, working the page, until the check holds; the test's own limit ends it else."""
        while not true():
            self.page.wait_for_timeout(20)

    def close(self) -> None:
        self.link.close()
        self.page.close()
        self.tool.__exit__()


@pytest.fixture
def desk(browser, request):
    strict = request.node.get_closest_marker("deadman")
    # a loaded computer starves a page for longer than 250 ms: only its own tests are that strict
    options = {} if strict else {"deadman": "10000"}
    found = Desk(browser, start("puma560", None, options))
    yield found
    errors = found.page.errors
    found.close()
    assert errors == []


def picture(page, name: str) -> None:
    """A screenshot for the manual."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    page.screenshot(path=PICTURES / f"{name}.png")
