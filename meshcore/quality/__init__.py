"""Measures of quality, their report, and the validity of meshes.

`measure` computes Verdict's measures by their names, and OpenFOAM's between neighbouring cells; `report` sums them up
for a reader, `summary` for a program; `validate` says whether a mesh is one at all.
"""

from .measures import measure, measures
from .neighbours import edge_jump, face_skewness, non_orthogonality, size_jump
from .report import QualityReport, report, summary
from .validity import Fault, validate

__all__ = [
    "Fault",
    "QualityReport",
    "edge_jump",
    "face_skewness",
    "measure",
    "measures",
    "non_orthogonality",
    "report",
    "size_jump",
    "summary",
    "validate",
]
