# SPDX-License-Identifier: Apache-2.0
"""The Modular Motor Control System of 1989, complete in simulation: the user's side."""

import functools
import os
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from mmcs.place import BUILD, ROBOTS, ROOT, SCENARIOS

__version__ = "0.2.0"
__all__ = [
    "BUILD", "ROBOTS", "ROOT", "SCENARIOS",
    "Device", "InputError", "Machine", "Run", "RunError", "campaign", "compare", "load", "run",
    "sweep",
]  # fmt: skip

# numpy would start threads that find no work; pydantic would look through all installed packages
# for plugins. The programs of a run do not get these (execute.py).
OWN_VARIABLES = {"OPENBLAS_NUM_THREADS", "PYDANTIC_DISABLE_PLUGINS"} - set(os.environ)
os.environ |= dict.fromkeys(OWN_VARIABLES, "1")

if TYPE_CHECKING:  # for editors and type checkers; at run time each is loaded when asked for
    from mmcs.cached import once as once
    from mmcs.device.client import Device as Device
    from mmcs.device.link import Link as Link
    from mmcs.engine import hosts as hosts
    from mmcs.engine.build import ensure_library as ensure_library
    from mmcs.engine.build import make_env as make_env
    from mmcs.engine.sim import Sim as Sim
    from mmcs.engine.sim import make_ffi as make_ffi
    from mmcs.errors import InputError as InputError
    from mmcs.errors import RunError as RunError
    from mmcs.errors import one_line as one_line
    from mmcs.folder import whole_file as whole_file
    from mmcs.front import Machine as Machine
    from mmcs.front import Run as Run
    from mmcs.front import campaign as campaign
    from mmcs.front import compare as compare
    from mmcs.front import load as load
    from mmcs.front import run as run
    from mmcs.front import sweep as sweep
    from mmcs.logcols import column as column
    from mmcs.runs import expect_plant as expect_plant
    from mmcs.runs.expect_plant import calibrate as calibrate
    from mmcs.runs.expect_plant import index_counts as index_counts
    from mmcs.runs.expect_plant import moved_deg as moved_deg
    from mmcs.runs.expect_plant import rest_ms as rest_ms
    from mmcs.runs.machine import compiled as compiled
    from mmcs.runs.machine import library_of as library_of
    from mmcs.runs.machine import machine as machine
    from mmcs.runs.machine import write_setup as write_setup
    from mmcs.runs.metrics import step_response as step_response
    from mmcs.runs.record import make_record as make_record
    from mmcs.runs.record import parse as parse
    from mmcs.runs.record import write_record as write_record
    from mmcs.runs.replay import replay as replay
    from mmcs.runs.replay import trace as trace
    from mmcs.runs.report import make_report as make_report
    from mmcs.runs.report import measure as measure
    from mmcs.runs.report import write_log as write_log
    from mmcs.runs.runner import run_scenario as run_scenario
    from mmcs.runs.runner import simulate as simulate
    from mmcs.runs.session import Session as Session
    from mmcs.scenario import arm as arm
    from mmcs.scenario.describe import lacking_gains as lacking_gains
    from mmcs.scenario.describe import robot_cautions as robot_cautions
    from mmcs.scenario.files import FAULTS as FAULTS
    from mmcs.scenario.files import Files as Files
    from mmcs.scenario.files import find as find
    from mmcs.scenario.files import read_toml as read_toml
    from mmcs.scenario.files import scenario_names as scenario_names
    from mmcs.scenario.load import load_robot as load_robot
    from mmcs.scenario.motor import plant_of as plant_of
    from mmcs.scenario.schema import Strict as Strict
    from mmcs.scenario.schema import validate as validate
    from mmcs.scenario.setup import Setup as Setup
    from mmcs.scenario.setup import make_setup as make_setup
    from mmcs.scenario.synthesis import Controller as Controller
    from mmcs.scenario.synthesis import discretize as discretize
    from mmcs.scenario.synthesis import margins as margins
    from mmcs.scenario.synthesis import to_integers as to_integers
    from mmcs.screen import echo as echo
    from mmcs.tool.worker import Worker as Worker
    from mmcs.tool.worker import work as work
    from mmcs.view import waves as waves
else:

    def __getattr__(name: str):
        """A name of the list above."""
        homes = _homes()
        if name not in homes:
            raise AttributeError(f"module 'mmcs' has no attribute {name!r}")
        home = import_module(homes[name])
        if hasattr(home, "__path__"):  # a module of that room
            return import_module(f"{home.__name__}.{name}")
        return getattr(home, name)

    @functools.cache
    def _homes() -> dict[str, str]:
        """Name: its module, as the list above has them."""
        import ast

        tree = ast.parse(Path(__file__).read_text())
        (listed,) = (node for node in tree.body if isinstance(node, ast.If))
        return {alias.name: line.module for line in listed.body for alias in line.names}
