# SPDX-License-Identifier: Apache-2.0
"""Lab sheets of a control course, and answers graded by running the machine with them."""
