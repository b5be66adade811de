# SPDX-License-Identifier: Apache-2.0
"""The simulated machine: builds the library of sim/engine and wraps its C ABI.

May know: nothing.
"""
