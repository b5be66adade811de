# SPDX-License-Identifier: Apache-2.0
"""`make bench`: how fast the simulation is."""
