# SPDX-License-Identifier: Apache-2.0
"""Many runs of one scenario, and the table they leave.

May know: engine, result, scenario, session, view.
"""
