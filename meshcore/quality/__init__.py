"""Measures of quality, their report, and the validity of meshes."""

from .measures import measure, measures
from .report import summary
from .validity import Fault, validate

__all__ = ["Fault", "measure", "measures", "summary", "validate"]
