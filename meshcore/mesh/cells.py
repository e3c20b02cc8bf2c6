"""The kinds of cell: names as in meshio, nodes in VTK's order, facets that look outward."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class CellType:
    """One kind of cell.

    Attributes
    ----------
    name : str
        meshio's name.
    vtk : int
        VTK's number of the type.
    dimension : int
        Topological dimension.
    nodes : int
        Nodes a cell.
    edges : tuple of pairs
        Local node pairs.
    facets : tuple of tuples
        Local nodes of each facet, outward by the right-hand rule (counter-clockwise edges in the plane).
    linear : str
        The kind made by the corner nodes alone.
    """

    name: str
    vtk: int
    dimension: int
    nodes: int
    edges: tuple[tuple[int, int], ...] = ()
    facets: tuple[tuple[int, ...], ...] = ()
    linear: str = ""


_TRIANGLE = ((0, 1), (1, 2), (2, 0))
_QUAD = ((0, 1), (1, 2), (2, 3), (3, 0))
_TETRA_EDGES = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))
_TETRA_FACETS = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2))
_HEX_EDGES = (*_QUAD, (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7))
_HEX_FACETS = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
_WEDGE_EDGES = (*_TRIANGLE, (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5))
_WEDGE_FACETS = ((0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5))
_PYRAMID_EDGES = (*_QUAD, (0, 4), (1, 4), (2, 4), (3, 4))
_PYRAMID_FACETS = ((0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4))

_LINEAR = [
    CellType("vertex", 1, 0, 1),
    CellType("line", 3, 1, 2, ((0, 1),), ((0,), (1,))),
    CellType("triangle", 5, 2, 3, _TRIANGLE, _TRIANGLE),
    CellType("quad", 9, 2, 4, _QUAD, _QUAD),
    CellType("tetra", 10, 3, 4, _TETRA_EDGES, _TETRA_FACETS),
    CellType("hexahedron", 12, 3, 8, _HEX_EDGES, _HEX_FACETS),
    CellType("wedge", 13, 3, 6, _WEDGE_EDGES, _WEDGE_FACETS),
    CellType("pyramid", 14, 3, 5, _PYRAMID_EDGES, _PYRAMID_FACETS),
]
_QUADRATIC = [
    ("line3", 21, 3, "line"),
    ("triangle6", 22, 6, "triangle"),
    ("quad8", 23, 8, "quad"),
    ("quad9", 28, 9, "quad"),
    ("tetra10", 24, 10, "tetra"),
    ("hexahedron20", 25, 20, "hexahedron"),
    ("hexahedron27", 29, 27, "hexahedron"),
    ("wedge15", 26, 15, "wedge"),
    ("wedge18", 32, 18, "wedge"),
    ("pyramid13", 27, 13, "pyramid"),
]

CELL_TYPES: dict[str, CellType] = {t.name: t for t in _LINEAR}
for _name, _vtk, _nodes, _linear in _QUADRATIC:
    # Corners come first in VTK's order, so the linear kind's edges and facets hold for the curved one.
    _base = CELL_TYPES[_linear]
    CELL_TYPES[_name] = CellType(_name, _vtk, _base.dimension, _nodes, _base.edges, _base.facets, _linear)

BY_VTK: dict[int, CellType] = {t.vtk: t for t in CELL_TYPES.values()}
