# SPDX-License-Identifier: Apache-2.0
"""Carries runs out, from a setup to the folder of results, and makes them again.

May know: engine, record, result, scenario, session, view.
"""
