"""Structured grids: transfinite interpolation, elliptic, hyperbolic, parabolic; topologies, curved operators."""

from .c_grid import c_grid
from .control_functions import Attractor
from .curvilinear import Curvilinear
from .elliptic import elliptic
from .elliptic_smoothing import elliptically_smoothed
from .elliptic_volume import elliptic_volume
from .finite_volumes import FiniteVolumes
from .h_grid import h_grid
from .halo import Halo, with_halo
from .hyperbolic import hyperbolic
from .hyperbolic_volume import hyperbolic_volume
from .metrics import Metrics
from .o_grid import o_grid
from .parabolic import parabolic
from .transfinite import transfinite
from .transfinite_volume import transfinite_volume
from .wall_control import Wall

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
