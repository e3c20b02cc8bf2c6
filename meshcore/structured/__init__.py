"""Structured grids: transfinite interpolation, elliptic equations, block topologies, and operators on curved grids."""

from .control_functions import Attractor
from .curvilinear import Curvilinear
from .elliptic import elliptic
from .elliptic_smoothing import elliptically_smoothed
from .elliptic_volume import elliptic_volume
from .finite_volumes import FiniteVolumes
from .halo import Halo, with_halo
from .metrics import Metrics
from .o_grid import o_grid
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
    "elliptic",
    "elliptic_volume",
    "elliptically_smoothed",
    "o_grid",
    "transfinite",
    "transfinite_volume",
    "with_halo",
]
