# SPDX-License-Identifier: Apache-2.0
"""The sizes of machine that most system tests share, so that few builds serve them all.

Heartbeat, relay and A/D are shortened where a test does not measure the real time.
"""

SHORT = {"HeartbeatUs": 400, "RelayUs": 20}
USUAL = {"NumCards": 3, **SHORT}
SINGLE = {"NumCards": 1, "HeartbeatUs": 2000, "RelayUs": 20}
