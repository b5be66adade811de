# SPDX-License-Identifier: Apache-2.0
"""What the user writes: scenario and robot files, checked and put together; control design, §2.5.

May know: nothing.
"""
