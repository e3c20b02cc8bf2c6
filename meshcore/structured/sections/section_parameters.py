"""What the operations that make grids round sections ask alike: their parameters, each declared once."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np

from ...errors import InvalidInput
from ...geometry.curves import Curve
from ...operation import Length, Param, Port, absolute
from ..algebraic.side_parameters import Law
from .wall_units import height_for

Method = Literal["transfinite", "elliptic", "hyperbolic", "parabolic"]
OpenFarField = Literal["C", "box"]
Base = Literal["block", "wrapped"]

SectionPort = Annotated[Curve, Port("One closed loop in a plane, such as an airfoil", cells=("line",))]
SectionOrSlitPort = Annotated[Curve, Port("One closed loop in a plane, or an open line: a slit", cells=("line",))]
RadiusParam = Annotated[float, Param("Distance of the far field from mid-chord, in chords", min=1, soft_max=100)]
MethodParam = Annotated[Method, Param("How the grid between section and far field is made")]
FirstHeightParam = Annotated[Length, Param("Height of the cells at the section", group="Spacing")]
YPlusParam = Annotated[
    float | None,
    Param("y+ of the first points, which then sets the first height", min=1e-6, group="Spacing", also=("yplus",)),
]
ReynoldsParam = Annotated[float, Param("Reynolds number of the chord, for y+", min=1, group="Spacing")]
GrowthParam = Annotated[
    float, Param("Growth of cell heights that sets the number of layers", min=1.001, max=3, group="Spacing")
]
LayersParam = Annotated[
    int | None, Param("Cells from the section out; by default as many as growth needs", min=1, soft_max=500)
]
LawIParam = Annotated[
    Law, Param("How points stand along each side of the section, from the trailing edge to the nose", group="Spacing")
]
AroundParam = Annotated[int | None, Param("Cells around the section; by default its own points", min=3, soft_max=1000)]
LeadingParam = Annotated[
    Length | None, Param("Size of the cells at the nose; by default as the section bends", group="Spacing")
]
TrailingParam = Annotated[
    Length | None, Param("Size of the cells at the trailing edge; by default as the section bends", group="Spacing")
]
WakeParam = Annotated[
    float | None, Param("Length of the wake, in chords; by default as far as the far field", min=0.05, soft_max=100)
]
WakeCellsParam = Annotated[
    int | None, Param("Cells along the wake; by default as many as wake_growth needs", min=1, soft_max=500)
]
WakeGrowthParam = Annotated[
    float, Param("Growth of cells along the wake that sets their number", min=1.001, max=3, group="Spacing")
]
WakeSpacingParam = Annotated[
    Length | None, Param("Length of the wake's first cells; by default as the section's last ones", group="Spacing")
]
OutflowSpacingParam = Annotated[
    Length | None,
    Param("Length of the wake's last cells, at the outflow; by default as they grow to be", group="Spacing"),
]
WakeHeightParam = Annotated[
    Length | None, Param("Height of the cells at the wake's end; by default as at the section", group="Spacing")
]
WakeAngleParam = Annotated[
    float, Param("Direction of the wake's end from the chord, upwards", min=-45, max=45, unit="degree")
]
BaseParam = Annotated[Base, Param("Behind a blunt trailing edge: a block of its own, or cells that go round it")]
FlowParam = Annotated[
    float, Param("Direction of the box from the chord, counter-clockwise", min=-45, max=45, unit="degree")
]


def wall_height(
    first_height: Length,
    y_plus: float | None,
    reynolds: float,
    loop: np.ndarray,
    chord: float,
    diagonal: float,
    radius: float,
) -> float:
    """The first height that is asked for, checked against the far field at ``radius``.

    Raises
    ------
    InvalidInput
        If it is too large, or lost in rounding.
    """
    height = absolute(first_height, diagonal) if y_plus is None else height_for(y_plus, reynolds, chord)
    name = "first_height" if y_plus is None else "y_plus"
    if height >= 0.5 * radius:
        raise InvalidInput(
            f"is {height:.6g}, but the far field has a radius of only {radius:.6g}; make it smaller", parameter=name
        )
    # Where lines stand is rounded as their coordinates are, and cells keep a thousandth of their heights.
    lost = 1e3 * 2.3e-16 * (radius + float(np.abs(loop).max()))
    if height <= lost:
        raise InvalidInput(
            f"is {height:.6g}, which is lost in rounding beside a far field of radius {radius:.6g}; make it larger, "
            "the radius smaller, or move the section to the origin",
            parameter=name,
        )
    return height
