# SPDX-License-Identifier: Apache-2.0
"""A card on a board, over its serial line: registers, and a self-test.

May know: nothing.
"""
