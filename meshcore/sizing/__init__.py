"""Spacing along curves and size fields in the plane and in space."""

from .along_curve import by_curvature, copied
from .background import background_field
from .discretisation import discretised
from .gradation import limited, limited_field
from .hyperbolic_sine import hyperbolic_sine
from .law import Spacing
from .on_curves import boundary_spacing, curvature_spacing
from .poisson import poisson
from .size_field import constant, graded, smallest
from .spacing import cells_for_ends, cells_for_growth, cosine, geometric, hyperbolic_tangent, uniform

__all__ = [
    "Spacing",
    "background_field",
    "boundary_spacing",
    "by_curvature",
    "cells_for_ends",
    "cells_for_growth",
    "constant",
    "copied",
    "cosine",
    "curvature_spacing",
    "discretised",
    "geometric",
    "graded",
    "hyperbolic_sine",
    "hyperbolic_tangent",
    "limited",
    "limited_field",
    "poisson",
    "smallest",
    "uniform",
]
