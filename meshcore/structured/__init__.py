"""Structured grids: transfinite interpolation and block topologies."""

from .transfinite import transfinite

__all__ = ["transfinite"]
