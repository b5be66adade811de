# SPDX-License-Identifier: Apache-2.0
"""What the firmware costs on the 68020: the tables of simulator/processors.md."""
