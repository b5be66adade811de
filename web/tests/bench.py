# SPDX-License-Identifier: Apache-2.0
"""What tests of pages share: a running tool with a page, pictures and tables for the manual."""

import json
import time
from pathlib import Path

from mmcs import BUILD, Link

PICTURES = BUILD / "tool"
TELEPHONE = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True}
PATIENCE_S = 240  # a loaded computer is slow, not wrong


def new_page(browser, **options):
    """A page that keeps what it raises."""
    page = browser.new_page(**options)
    page.set_default_timeout(PATIENCE_S * 1000)
    page.errors = []
    page.on("pageerror", lambda error: page.errors.append(str(error)))
    return page


class Desk:
    """A running tool with one page open, and a link of the test's own to the same machine."""

    def __init__(self, browser, tool, options: str = ""):
        self.browser, self.tool = browser, tool
        self.page = self.open(options)
        self.link = Link(path=tool.socket)
        self.link.request("open", mode="r")

    def open(self, options: str = "", **more):
        page = new_page(self.browser, **({"viewport": {"width": 1280, "height": 800}} | more))
        page.goto(self.tool.address + options)
        page.wait_for_selector("body.ready")
        return page

    @property
    def stop_frame(self):
        return self.page.frames[1]

    def param(self, axis: int) -> dict:
        return self.link.request("call", request="MGETPARAM", axis=axis)["param"]

    def state(self) -> dict:
        return self.link.request("hello")

    def until(self, what: str, argument=None) -> None:
        """Waits for a condition in the page."""
        self.page.wait_for_function(what, arg=argument)

    def eventually(self, true, patience_s: float = PATIENCE_S) -> None:
        """Waits, working the page, until the check holds."""
        end = time.monotonic() + patience_s
        while not true():
            if time.monotonic() > end:
                shows = [self.page.inner_text(f"#{part}") for part in ("cause", "next", "said")]
                raise AssertionError(f"not so within {patience_s} s; the page says: {shows}")
            self.page.wait_for_timeout(20)

    def close(self) -> None:
        self.link.close()
        self.page.close()
        self.tool.__exit__()


def until(page, what: str) -> None:
    page.wait_for_function(f"() => {what}")


def enable(page) -> None:
    page.click("#enable")
    until(page, "mctool.machine.enabled")


def pick(page, choice: str, value: str) -> None:
    """Presses one of the buttons of a choice."""
    page.click(f"{choice} [value='{value}']")


def unfold(page, choice: str, value: str) -> None:
    """Presses one of the buttons behind a word."""
    page.click(f"{choice} summary")
    pick(page, choice, value)


def chosen(page, choice: str) -> str:
    return page.get_attribute(choice, "data-value")


def saved(page, button: str, folder: Path) -> Path:
    """The file that the page gives at a press of the button."""
    with page.expect_download() as download:
        page.click(button)
    path = folder / download.value.suggested_filename
    download.value.save_as(path)
    return path


def picture(page, name: str) -> None:
    """A screenshot for the manual."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    page.screenshot(path=PICTURES / f"{name}.png")


def note(table: str, row: str, line: str) -> None:
    """A line of a table of the manual; the lines of other tests stay."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    path = PICTURES / f"{table}.json"
    rows = json.loads(path.read_text()) if path.exists() else {}
    path.write_text(json.dumps(rows | {row: line}, indent=1))
