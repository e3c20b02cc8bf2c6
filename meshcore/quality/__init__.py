"""Measures of quality, their report, and the validity of meshes.

`measure` computes Verdict's measures by their names, OpenFOAM's between neighbouring cells, and those along the lines
of a grid; `report` sums them up for a reader, `summary` for a program; `validate` says whether a mesh is one at all.
"""

from .grid import face_angle, first_height, growth_ratio, line_angle, with_quality
from .lines import line_growth, wall_angle, wall_height
from .measures import measure, measures
from .neighbours import edge_jump, face_skewness, non_orthogonality, size_jump
from .report import QualityReport, report, summary
from .validity import Fault, validate

__all__ = [
    "Fault",
    "QualityReport",
    "edge_jump",
    "face_angle",
    "face_skewness",
    "first_height",
    "growth_ratio",
    "line_angle",
    "line_growth",
    "measure",
    "measures",
    "non_orthogonality",
    "report",
    "size_jump",
    "summary",
    "validate",
    "wall_angle",
    "wall_height",
    "with_quality",
]
