"""Spacing along curves and size fields in the plane and in space."""

from .background import background_field
from .discretisation import discretised
from .gradation import limited, limited_field
from .on_curves import boundary_spacing, curvature_spacing
from .size_field import constant, graded, smallest
from .spacing import cells_for_growth, cosine, geometric, hyperbolic_tangent, uniform

__all__ = [
    "background_field",
    "boundary_spacing",
    "cells_for_growth",
    "constant",
    "cosine",
    "curvature_spacing",
    "discretised",
    "geometric",
    "graded",
    "hyperbolic_tangent",
    "limited",
    "limited_field",
    "smallest",
    "uniform",
]
