# SPDX-License-Identifier: Apache-2.0
"""The page in a real browser: a machine, its tool, and Chromium."""

import shutil

import pytest
from bench import PATIENCE_S, Desk
from playwright.sync_api import sync_playwright

from mmcs.tool.launch import start

FLAGS = [
    "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--use-gl=angle", "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader", "--site-per-process",
]  # fmt: skip


@pytest.fixture(scope="session")
def browser():
    path = shutil.which("chromium")
    assert path, "chromium is missing; `make tool-test` installs it"
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=path, args=FLAGS)
        yield chromium
        chromium.close()


@pytest.fixture
def desk(browser, request):
    # a loaded computer starves a page for longer than the 250 ms that people have
    silence = request.node.get_closest_marker("deadman")
    ms = silence.args[0] if silence else 1000 * PATIENCE_S
    found = Desk(browser, start("puma560", None, {"deadman": str(ms)}))
    yield found
    errors = found.page.errors
    found.close()
    assert errors == []
