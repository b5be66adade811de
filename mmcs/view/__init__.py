# SPDX-License-Identifier: Apache-2.0
"""Finished runs to look at: plots, comparisons, films, views of waveforms.

May know: engine, result, scenario.
"""
