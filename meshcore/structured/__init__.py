"""Structured grids: transfinite interpolation and block topologies."""

from .topologies import o_grid
from .transfinite import transfinite

__all__ = ["o_grid", "transfinite"]
