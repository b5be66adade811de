# SPDX-License-Identifier: Apache-2.0
"""mctool in the browser, §3: gateway, stop button, tuning; the pages are in web/.

May know: device, engine, runs, scenario, view.
"""
