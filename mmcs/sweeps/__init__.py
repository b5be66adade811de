# SPDX-License-Identifier: Apache-2.0
"""Many runs: sweeps of one scenario, and campaigns of very many faults.

May know: engine, runs, scenario.
"""
