# SPDX-License-Identifier: Apache-2.0
"""Very many faults, each a run beside its fault-free twin, and where the design is deaf to them.

May know: engine, result, scenario, session, sweeps, view.
"""
