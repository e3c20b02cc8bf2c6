"""CGNS's types of element: which kinds of cell they are, and which of their nodes a cell takes, in what order.

Nodes beyond those of a kind, such as the centre of PYRA_14's base or all inner ones of cubic elements, are left out.

References
----------
CGNS steering committee, "Unstructured grid element numbering conventions", https://cgns.github.io/standard/conv.html
"""

from __future__ import annotations

from dataclasses import dataclass

from ..mesh import CELL_TYPES

MIXED, NGON, NFACE = 20, 22, 23
# In the order of CGNS's numbers, of which the first is 2.
_NAMES = [
    "NODE_1", "BAR_2", "BAR_3", "TRI_3", "TRI_6", "QUAD_4", "QUAD_8", "QUAD_9", "TETRA_4", "TETRA_10", "PYRA_5",
    "PYRA_14", "PENTA_6", "PENTA_15", "PENTA_18", "HEXA_8", "HEXA_20", "HEXA_27", "MIXED", "PYRA_13", "NGON",
    "NFACE", "BAR_4", "TRI_9", "TRI_10", "QUAD_12", "QUAD_16", "TETRA_16", "TETRA_20", "PYRA_21", "PYRA_29",
    "PYRA_30", "PENTA_24", "PENTA_38", "PENTA_40", "HEXA_32", "HEXA_56", "HEXA_64", "BAR_5", "TRI_12", "TRI_15",
    "QUAD_P4_16", "QUAD_25", "TETRA_22", "TETRA_34", "TETRA_35", "PYRA_P4_29", "PYRA_50", "PYRA_55", "PENTA_33",
    "PENTA_66", "PENTA_75", "HEXA_44", "HEXA_98", "HEXA_125",
]  # fmt: skip
_LINEAR = {
    "NODE": "vertex", "BAR": "line", "TRI": "triangle", "QUAD": "quad", "TETRA": "tetra", "PYRA": "pyramid",
    "PENTA": "wedge", "HEXA": "hexahedron",
}  # fmt: skip
_CURVED = {
    "BAR_3": "line3", "TRI_6": "triangle6", "QUAD_8": "quad8", "QUAD_9": "quad9", "TETRA_10": "tetra10",
    "PYRA_13": "pyramid13", "PYRA_14": "pyramid13", "PENTA_15": "wedge15", "PENTA_18": "wedge18",
    "HEXA_20": "hexahedron20", "HEXA_27": "hexahedron27",
}  # fmt: skip
# For each node in VTK's order its place in CGNS's, where they differ: CGNS has the upright edges before the top's, and
# the faces of a hexahedron from below upwards, round about, where VTK goes along the axes.
_WEDGE = (*range(9), 12, 13, 14, 9, 10, 11)
_HEXAHEDRON = (*range(12), 16, 17, 18, 19, 12, 13, 14, 15)
_ORDER = {
    "wedge15": _WEDGE,
    "wedge18": (*_WEDGE, 15, 16, 17),
    "hexahedron20": _HEXAHEDRON,
    "hexahedron27": (*_HEXAHEDRON, 24, 22, 21, 23, 20, 25, 26),
}


@dataclass(frozen=True)
class ElementType:
    """One type of element.

    Attributes
    ----------
    name : str
        CGNS's name.
    nodes : int
        Nodes an element.
    kind : str
        The kind of cell.
    order : tuple of int
        Which of its nodes are the cell's, in the cell's order.
    """

    name: str
    nodes: int
    kind: str
    order: tuple[int, ...]


def _element_type(name: str) -> ElementType:
    kind = _CURVED.get(name) or _LINEAR[name.split("_")[0]]
    return ElementType(name, int(name.split("_")[-1]), kind, _ORDER.get(kind, tuple(range(CELL_TYPES[kind].nodes))))


ELEMENTS = {number: _element_type(name) for number, name in enumerate(_NAMES, 2) if number not in (MIXED, NGON, NFACE)}
"""By CGNS's numbers."""

NUMBERS = {
    element.kind: number for number, element in ELEMENTS.items() if element.nodes == CELL_TYPES[element.kind].nodes
}
"""CGNS's numbers of the kinds of cell."""
