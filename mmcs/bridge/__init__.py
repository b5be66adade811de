# SPDX-License-Identifier: Apache-2.0
"""The machine for what others use: Gymnasium, FMI.

May know: engine, scenario.
"""
