"""What operations on sides and surfaces ask alike: their ports and parameters, each declared once."""

from __future__ import annotations

from typing import Annotated, Literal, Union

from ...geometry.curves import Curve
from ...mesh import Mesh, StructuredGrid
from ...operation import Length, Param, Port
from ...sizing import law

_SIDE = "line cells in one chain, or points in order"

SouthPort = Annotated[
    Curve, Port(f"South side, or all four: one closed loop, or four chains; {_SIDE}", cells=("line",))
]
EastPort = Annotated[Curve | None, Port(f"East side: {_SIDE}", cells=("line",))]
NorthPort = Annotated[Curve | None, Port(f"North side: {_SIDE}", cells=("line",))]
WestPort = Annotated[Curve | None, Port(f"West side: {_SIDE}", cells=("line",))]

SurfacePort = Annotated[
    Union[Mesh, StructuredGrid, None],
    Port("Triangles or quads on which the grid shall lie, such as a scan", cells=("triangle", "quad"), named=True),
]

CellsIParam = Annotated[
    int | None, Param("Cells along south and north; by default as their points are given", min=1, soft_max=500)
]
CellsJParam = Annotated[
    int | None, Param("Cells along west and east; by default as their points are given", min=1, soft_max=500)
]
SpacingSouthParam = Annotated[Length | None, Param("Height of the cells at the south side", group="Spacing")]
SpacingEastParam = Annotated[Length | None, Param("Width of the cells at the east side", group="Spacing")]
SpacingNorthParam = Annotated[Length | None, Param("Height of the cells at the north side", group="Spacing")]
SpacingWestParam = Annotated[Length | None, Param("Width of the cells at the west side", group="Spacing")]
Law = Literal["as given", law.Law]
LawIParam = Annotated[Law, Param("How points stand along south and north", group="Spacing")]
LawJParam = Annotated[Law, Param("How points stand along west and east", group="Spacing")]
CornersParam = Annotated[
    tuple[int, int, int, int],
    Param("Points of a closed loop that are its corners; four times -1 finds them", min=-1, group="Corners"),
]
ShiftCornersParam = Annotated[
    tuple[int, int, int, int],
    Param(
        "Points along a closed loop by which each of its corners is moved",
        min=-1_000_000,
        max=1_000_000,
        soft_min=-20,
        soft_max=20,
        group="Corners",
    ),
]
ToleranceParam = Annotated[Length, Param("Largest gap between ends of sides that is closed", min=0, advanced=True)]
