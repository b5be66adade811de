# SPDX-License-Identifier: Apache-2.0
"""Quadrature encoders for cocotb: a source of edges, and a decoder that checks. See README.md."""

from cocotbext.mmcs import Pins
from cocotbext.quadrature.decoder import QuadratureDecoder
from cocotbext.quadrature.source import PHASES, QuadratureSource

__all__ = ["PHASES", "Pins", "QuadratureDecoder", "QuadratureSource"]
