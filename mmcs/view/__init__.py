# SPDX-License-Identifier: Apache-2.0
"""Finished runs to look at: plots, comparisons, films, views of waveforms, MCAP files.

May know: engine, scenario.
"""
