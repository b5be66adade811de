# SPDX-License-Identifier: Apache-2.0
"""Project-wide pytest options."""

import json
from pathlib import Path


def pytest_addoption(parser):
    parser.addoption(
        "--req-json", metavar="FILE", help="write which requirement ids each collected test carries"
    )


def pytest_collection_finish(session):
    target = session.config.getoption("--req-json")
    if not target or hasattr(session.config, "workerinput"):
        return
    table = {
        item.nodeid: sorted({i for mark in item.iter_markers("req") for i in mark.args})
        for item in session.items
    }
    Path(target).write_text(json.dumps(table, indent=1))
