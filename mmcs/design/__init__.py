# SPDX-License-Identifier: Apache-2.0
"""Control synthesis, §2.5: from continuous gains to the compensator's integers.

May know: nothing.
"""
