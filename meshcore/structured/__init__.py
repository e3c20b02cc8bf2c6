"""Structured grids: transfinite interpolation, block topologies, and operators on curved grids."""

from .curvilinear import Curvilinear
from .finite_volumes import FiniteVolumes
from .metrics import Metrics
from .topologies import o_grid
from .transfinite import transfinite
from .transfinite_volume import transfinite_volume

__all__ = ["Curvilinear", "FiniteVolumes", "Metrics", "o_grid", "transfinite", "transfinite_volume"]
