# SPDX-License-Identifier: Apache-2.0
"""The static site in a real browser, carried by Python's own file server."""

import functools
import threading
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer

import pytest
from bench import new_page

from mmcs import BUILD


class Quiet(SimpleHTTPRequestHandler):
    def log_message(self, *_) -> None:
        pass


@pytest.fixture(scope="session")
def address():
    for name in ("web", "docs"):
        page = BUILD / name / "index.html"
        assert page.is_file(), f"build/{name} is not there; `make {name}` makes it"
    server = ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Quiet, directory=BUILD))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}/web/"
    server.shutdown()


@pytest.fixture
def opened(browser, address):
    """opened("?scenario=…") is a page; none of them may have raised anything at the end."""
    pages = []
    context = browser.new_context(viewport={"width": 1280, "height": 800})

    def go(query: str, ready: bool = True, **more):
        own = browser.new_context(**more) if more else context
        page = new_page(own)
        page.goto(address + query)
        if ready:
            page.wait_for_selector("body.ready, body[data-failed]")
        pages.append(page)
        return page

    yield go
    errors = [error for page in pages for error in page.errors]
    for page in pages:
        page.context.close()
    assert errors == []
