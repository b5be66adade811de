# SPDX-License-Identifier: Apache-2.0
"""One run: what a user's program does with /dev/mc0 while the machine goes on.

May know: device, engine, scenario.
"""
