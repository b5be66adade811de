# SPDX-License-Identifier: Apache-2.0
"""Very many faults, each a run beside its fault-free twin, and which of them stay undetected.

May know: engine, result, scenario, session, sweeps, view.
"""
