# SPDX-License-Identifier: Apache-2.0
"""The machine for other programs: server, client, programs run against it.

May know: engine.
"""
