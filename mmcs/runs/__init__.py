# SPDX-License-Identifier: Apache-2.0
"""One run: carried out from a scenario, judged, reported, recorded, and made again.

May know: device, engine, scenario, view.
"""
