# SPDX-License-Identifier: Apache-2.0
"""The command line: one file for each family of commands.

May know: board, bridge, campaign, design, device, engine, lab, record, result, runs, scenario,
sweeps, tool, view.
"""

from mmcs.cli.app import main

__all__ = ["main"]
