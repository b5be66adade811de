# SPDX-License-Identifier: Apache-2.0
"""The command line: one file for each family of commands.

May know: bridge, device, engine, runs, scenario, sweeps, tool, view.
"""
