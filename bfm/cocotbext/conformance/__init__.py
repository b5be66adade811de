# SPDX-License-Identifier: Apache-2.0
"""Conformance of a core with the data sheet of its chip, judged by bus transactions."""

from .i8254 import Pit
from .i8255 import Ppi
from .oneshot import OneShot
from .quadrature import Encoder
from .script import LeftOut, Row, Rows, Script

CHIPS = {"8254": Pit, "8255": Ppi, "quadrature": Encoder, "oneshot": OneShot}

__all__ = ["CHIPS", "Encoder", "LeftOut", "OneShot", "Pit", "Ppi", "Row", "Rows", "Script"]
