"""What elliptic operations ask alike: their parameters, each declared once, and what these mean at the sides."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Literal

from ...errors import InvalidInput
from ...mesh.structured_grid import FACES
from ...operation import Length, Param, absolute
from .elliptic_problem import Control
from .wall_control import Wall
from .winslow import SIDES

Walls = Literal["none", "south", "east", "north", "west", "south and north", "west and east", "all"]

ControlParam = Annotated[
    Control, Param("Whether the sides' spacing is carried inside, or lines spread evenly (Laplace)")
]
WallsParam = Annotated[Walls, Param("Sides where the angle of lines and the first height are controlled")]
FaceWalls = Literal[
    "none",
    "imin",
    "imax",
    "jmin",
    "jmax",
    "kmin",
    "kmax",
    "imin and imax",
    "jmin and jmax",
    "kmin and kmax",
    "i and j",
    "i and k",
    "j and k",
    "all",
]
FaceWallsParam = Annotated[
    FaceWalls, Param("Faces where the angle of lines and the first height are controlled; i stands for imin and imax")
]
FirstHeightParam = Annotated[
    Length | None, Param("Length of the first edge at walls; by default what it becomes", group="Walls")
]
WallAngleParam = Annotated[
    float, Param("Angle between walls and the lines that leave them", min=10, max=170, unit="degree", group="Walls")
]
LeanAtEdgesParam = Annotated[
    bool, Param("Whether lines lean near the edges of walls as those on the faces beside them do", group="Walls")
]
SlidingParam = Annotated[
    bool, Param("Whether points slide along walls to make the angle, instead of lines that lean", group="Walls")
]
ResidualParam = Annotated[
    float | None,
    Param("Residual to reach, of the start's; by default near to the converged grid", min=1e-13, max=1, advanced=True),
]
MaxCyclesParam = Annotated[int, Param("Cycles after which to give up", min=1, advanced=True)]


def sides_of(walls: Walls) -> list[str]:
    """The sides that a choice of walls names.

    Examples
    --------
    >>> sides_of("south and north"), sides_of("none")
    (['south', 'north'], [])
    """
    return [] if walls == "none" else list(SIDES) if walls == "all" else walls.split(" and ")


def check_walls(walls: Sequence[Wall]) -> None:
    """Refuse what is no sequence of `Wall`."""
    if not isinstance(walls, Sequence) or not all(isinstance(wall, Wall) for wall in walls):
        raise InvalidInput(f"needs walls in a list, such as [Wall('south')], got {walls!r}", parameter="each_wall")


def asked_walls(
    chosen: Walls,
    first_height: Length | None,
    angle: float,
    sliding: bool,
    *,
    diagonal: float,
    places: Mapping[str, str] | None = None,
    cuts: Sequence[str] = (),
) -> list[Wall]:
    """What the parameters of walls ask at the sides of a grid.

    Parameters
    ----------
    chosen, first_height, angle, sliding
        As for `elliptic`.
    diagonal : float
        Size of the grid, for relative lengths.
    places : mapping of str to str, optional
        Where in the grid each named side stands, if the grid had to be turned.
    cuts : sequence of str
        Sides that are no boundary; "all" leaves them out.

    Raises
    ------
    InvalidInput
        If a height or sliding is asked for, but no walls.

    Examples
    --------
    >>> asked_walls("south", 0.01, 80.0, False, diagonal=1.0)
    [Wall(side='south', first_height=0.01, angle=80.0, slides=False, lean_at_edges=False)]
    """
    if chosen == "none":
        _refuse_without_walls(first_height, sliding)
        return []
    places = places or {side: side for side in SIDES}
    names = [side for side in sides_of(chosen) if side not in cuts or chosen != "all"]
    height = None if first_height is None else absolute(first_height, diagonal)
    turned = places["west"] != "west"
    angles = {side: 180 - angle if turned and side in ("south", "north") else angle for side in SIDES}
    return [Wall(places[name], height, angles[places[name]], sliding) for name in names]


def asked_faces(
    chosen: FaceWalls,
    first_height: Length | None,
    angle: float,
    sliding: bool = False,
    lean_at_edges: bool = False,
    *,
    diagonal: float,
    cuts: Sequence[str] = (),
) -> list[Wall]:
    """What the parameters of walls ask at the faces of a block.

    Parameters
    ----------
    chosen, first_height, angle, sliding, lean_at_edges
        As for `elliptic_volume`.
    diagonal : float
        Size of the block, for relative lengths.
    cuts : sequence of str
        Faces that are no boundary; "all" and names of directions leave them out.

    Raises
    ------
    InvalidInput
        If a height or sliding is asked for, but no walls.

    Examples
    --------
    >>> [wall.side for wall in asked_faces("i and k", 0.01, 90.0, diagonal=1.0, cuts=("imin", "imax"))]
    ['kmin', 'kmax']
    """
    if chosen == "none":
        _refuse_without_walls(first_height, sliding)
        return []
    parts = "ijk" if chosen == "all" else chosen.split(" and ")
    names = [face for face in FACES if face in parts or (face[0] in parts and face not in cuts)]
    height = None if first_height is None else absolute(first_height, diagonal)
    return [Wall(name, height, angle, sliding, lean_at_edges) for name in names]


def _refuse_without_walls(first_height: Length | None, sliding: bool) -> None:
    for name, given in (("first_height", first_height is not None), ("sliding", sliding)):
        if given:
            raise InvalidInput("is given, but no walls; name the sides that are walls", parameter=name)
