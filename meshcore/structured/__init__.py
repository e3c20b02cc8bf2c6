"""Structured grids: transfinite interpolation, elliptic, hyperbolic, parabolic; topologies, curved operators."""

from .algebraic.transfinite import transfinite
from .algebraic.transfinite_volume import transfinite_volume
from .marching.hyperbolic import hyperbolic
from .marching.hyperbolic_volume import hyperbolic_volume
from .marching.parabolic import parabolic
from .operators.curvilinear import Curvilinear
from .operators.finite_volumes import FiniteVolumes
from .operators.halo import Halo, with_halo
from .operators.metrics import Metrics
from .poisson.control_functions import Attractor
from .poisson.elliptic import elliptic
from .poisson.elliptic_smoothing import elliptically_smoothed
from .poisson.elliptic_volume import elliptic_volume
from .poisson.wall_control import Wall
from .sections.c_grid import c_grid
from .sections.h_grid import h_grid
from .sections.o_grid import o_grid

__all__ = [
    "Attractor",
    "Curvilinear",
    "FiniteVolumes",
    "Halo",
    "Metrics",
    "Wall",
    "c_grid",
    "elliptic",
    "elliptic_volume",
    "elliptically_smoothed",
    "h_grid",
    "hyperbolic",
    "hyperbolic_volume",
    "o_grid",
    "parabolic",
    "transfinite",
    "transfinite_volume",
    "with_halo",
]
