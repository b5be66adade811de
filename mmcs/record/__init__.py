# SPDX-License-Identifier: Apache-2.0
"""What a run can be made again from: its record, and snapshots on the way.

May know: engine, result, scenario, session.
"""
