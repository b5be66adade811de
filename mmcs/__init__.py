# SPDX-License-Identifier: Apache-2.0
"""The Modular Motor Control System of 1989, complete in simulation: the user's side."""

from importlib import import_module

from mmcs.place import BUILD, ROBOTS, ROOT, SCENARIOS

__version__ = "0.2.0"
__all__ = [  # noqa: F822  (those of the front come when they are asked for)
    "BUILD", "ROBOTS", "ROOT", "SCENARIOS",
    "Device", "InputError", "Machine", "Run", "RunError", "compare", "load", "run",
    "sweep",
]  # fmt: skip

# For studies, bridges and graders: name, or module, and where it is at home. Loaded when asked for.
_MORE = {
    # scenarios and robots, and control design
    "scenario.load": "load_robot",
    "scenario.files": "FAULTS scenario_names find Files read_toml",
    "scenario.setup": "make_setup Setup",
    "scenario.describe": "lacking_gains robot_cautions",
    "scenario": "arm synthesis",
    "scenario.schema": "Strict validate",
    "scenario.synthesis": "Controller discretize margins to_integers",
    "scenario.motor": "plant_of",
    # the machine at the C ABI, its builds and processors
    "engine.sim": "SEGMENT_KINDS Sim make_ffi",
    "engine.build": "ensure_library library_path make_env",
    "engine": "hosts",
    # a run, and what it showed
    "runs.machine": "library_of machine",
    "runs.session": "Session",
    "runs.runner": "simulate run_scenario",
    "runs.report": "make_report measure write_log",
    "runs.expect": "judge",
    "runs.metrics": "step_response",
    "runs": "expect_plant",
    "runs.expect_plant": "calibrate index_counts moved_deg rest_ms",
    "runs.replay": "replay trace",
    "runs.record": "make_record write_record parse",
    # pictures
    "view": "waves",
    # servers, workers of a page, files and words
    "device.client": "Device",
    "device.link": "Link",
    "tool.worker": "Worker work",
    "logcols": "column",
    "folder": "whole_file",
    "screen": "echo",
}
_HOMES = dict.fromkeys(__all__[4:], "front")
_HOMES |= {name: home for home, names in _MORE.items() for name in names.split()}


def __getattr__(name: str):
    """Names of the front door, loaded when they are asked for."""
    if name not in _HOMES:
        raise AttributeError(f"module 'mmcs' has no attribute {name!r}")
    home = import_module(f"mmcs.{_HOMES[name]}")
    if hasattr(home, "__path__"):  # a module of that room
        return import_module(f"{home.__name__}.{name}")
    return getattr(home, name)
