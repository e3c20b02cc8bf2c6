"""Measures of quality, their report, and the validity of meshes."""

from .validity import Fault, validate

__all__ = ["Fault", "validate"]
