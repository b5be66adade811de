# SPDX-License-Identifier: Apache-2.0
"""Project-wide pytest options. With CI=true in the environment a skipped test fails."""

import json
import os
import sys
from collections import Counter
from pathlib import Path

import pytest

from tools.share import mixed, shared

# `.venv/bin/python -m pytest` finds the simulators as `make test` does.
os.environ["PATH"] = f"{Path(sys.executable).parent}{os.pathsep}{os.environ.get('PATH', '')}"
# What tests import is compiled once and kept: the suite starts Python some hundred times.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False


def pytest_addoption(parser):
    parser.addoption(
        "--req-json", metavar="FILE", help="write which requirement ids each collected test carries"
    )
    parser.addoption("--req", metavar="ID", help="only tests that hold this requirement: INT-1")
    parser.addoption("--share", action="store_true", help="SHARE is of all tests, not of slow ones")


def pytest_itemcollected(item):
    """Tests that share something costly share a worker, or each worker would make it. Marked before
    xdist looks for groups."""
    made = getattr(item, "_fixtureinfo", None)
    shared = made and any(d[-1].scope == "module" for d in made.name2fixturedefs.values())
    if shared and not item.get_closest_marker("xdist_group"):
        item.add_marker(pytest.mark.xdist_group(item.nodeid.partition("::")[0]))


def _requirements(item) -> set[str]:
    return {i for mark in item.iter_markers("req") for i in mark.args}


def pytest_collection_modifyitems(config, items):
    """The long tests begin first, so that no worker is left alone with one at the end."""
    if wanted := config.getoption("--req"):
        others = [item for item in items if wanted not in _requirements(item)]
        config.hook.pytest_deselected(items=others)
        items[:] = [item for item in items if wanted in _requirements(item)]
    if os.environ.get("SHARE"):
        _keep_share(config, items)
    for item in items:
        for mark in item.iter_markers("xdist_group"):
            if "]" in mark.args[0]:  # xdist would take it for the end of the test's own name
                raise pytest.UsageError(f"{item.nodeid}: a group's name holds no ]: {mark.args[0]}")
    items.sort(key=lambda item: item.get_closest_marker("slow") is None)


def _keep_share(config, items):
    """Of what costs most only the share of ten that SHARE names: slow tests, with --share all."""
    every = config.getoption("--share")
    unit = {}  # what is run together is in one share
    for item in items:
        if every or item.get_closest_marker("slow"):
            group = item.get_closest_marker("xdist_group") if every else None
            unit[item] = group.args[0] if group else item.nodeid
    kept = set(shared(mixed(set(unit.values()))))
    others = [item for item in unit if unit[item] not in kept]
    config.hook.pytest_deselected(items=others)
    items[:] = [item for item in items if unit.get(item) is None or unit[item] in kept]


def pytest_terminal_summary(terminalreporter, config):
    if share := os.environ.get("SHARE"):
        what = "all tests" if config.getoption("--share") else "the slow tests"
        terminalreporter.write_line(f"Share {share} of ten of {what}; SHARE= runs every one.")
    told = [report.longrepr for report in terminalreporter.stats.get("skipped", [])]
    reasons = Counter(one[2] if isinstance(one, tuple) else str(one) for one in told)
    if reasons:
        line = f"{len(told)} tests did NOT run; with CI=true they fail. Why, and what to install:"
        terminalreporter.write_line(line, yellow=True)
    for reason, number in reasons.most_common():
        terminalreporter.write_line(f"  {number}: {reason.removeprefix('Skipped: ')}", yellow=True)


def pytest_sessionfinish(session, exitstatus):
    if exitstatus == pytest.ExitCode.NO_TESTS_COLLECTED and os.environ.get("SHARE"):
        session.exitstatus = pytest.ExitCode.OK  # a share may be empty


def pytest_collection_finish(session):
    target = session.config.getoption("--req-json")
    if not target or hasattr(session.config, "workerinput"):
        return
    table = {item.nodeid: sorted(_requirements(item)) for item in session.items}
    Path(target).write_text(json.dumps(table, indent=1))


# --- nothing is skipped where nobody looks ------------------------------------------------------


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport():
    """Turns a skip, whose reason names the tool and how to install it, into a failure."""
    report = yield
    wanted = os.environ.get("CI", "").lower() in ("1", "true", "yes")
    if wanted and report.skipped and not hasattr(report, "wasxfail"):
        reason = report.longrepr[2] if isinstance(report.longrepr, tuple) else report.longrepr
        report.outcome = "failed"
        report.longrepr = f"{report.nodeid}: not run, and CI=true allows no skip. {reason}"
    return report


pytest_make_collect_report = pytest_runtest_makereport
