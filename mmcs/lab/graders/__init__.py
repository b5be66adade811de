# SPDX-License-Identifier: Apache-2.0
"""One module for each sheet, by its name: the model of an answer, and its questions."""
