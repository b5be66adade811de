# SPDX-License-Identifier: Apache-2.0
"""The machine for what others use: Gymnasium, python-control, PlotJuggler, FMI.

May know: device, engine, scenario.
"""
