# SPDX-License-Identifier: Apache-2.0
"""What the user writes: scenario and robot files, read, checked and put together.

May know: design.
"""
