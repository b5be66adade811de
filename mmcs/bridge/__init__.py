# SPDX-License-Identifier: Apache-2.0
"""The machine for what others use: FMI.

May know: engine, scenario.
"""
