# SPDX-License-Identifier: Apache-2.0
"""What a run showed: figures, verdicts on the expectations, the report.

May know: engine, scenario.
"""
