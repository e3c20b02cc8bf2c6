"""Planar grids that march from a curve to an outer one by a parabolic equation (survey 2.7.2)."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from ...errors import GenerationFailed, InvalidGeometry, InvalidInput
from ...geometry.curves import Curve, polyline
from ...mesh import StructuredGrid
from ...operation import Param, Port, Relative, absolute, operation
from ...progress import Progress, advance, part_of, silent
from ...quality import summary, validate
from ...report import Report, Result
from ...sizing import Spacing, cells_for_growth, geometric
from ..folds import refuse_folds
from ..layer_report import layers_told, worst_skew
from ..limits import check_size
from .fronts import Front, changes_told, read_front, stop_told
from .marching_parameters import FirstHeightParam
from .outer_points import outer_points
from .parabolic_march import marched

__all__ = ["marched", "parabolic"]

_CURE = "give the front more points where it bends, or move the outer curve away"


@operation("Parabolic Grid", category="Structured", output="grid")
def parabolic(
    front: Annotated[
        Curve, Port("The curve to march off: line cells in one chain, open or closed, in a plane", cells=("line",))
    ],
    outer: Annotated[
        Curve, Port("The curve to end at, closed round a closed front, in the same plane", cells=("line",))
    ],
    first_side: Annotated[
        Curve | None, Port("Side from the front's first point to the outer curve", cells=("line",), named=True)
    ] = None,
    last_side: Annotated[
        Curve | None, Port("Side from the front's last point to the outer curve", cells=("line",), named=True)
    ] = None,
    *,
    first_height: FirstHeightParam = Relative(0.001),
    growth: Annotated[
        float, Param("Largest growth of heights, that sets the number of layers", min=1.001, max=3, group="Layers")
    ] = 1.15,
    layers: Annotated[
        int | None, Param("Layers; by default as many as growth needs", min=1, soft_max=500, group="Layers")
    ] = None,
    spacing: Spacing | None = None,
    progress: Progress = silent,
) -> Result:
    """March layers of quadrilaterals from a curve to an outer curve, and meet it exactly.

    Lines leave the front at right angles, like those of `hyperbolic`; the farther they come, the smoother they get,
    like those of `elliptic`, and they end on the outer curve. It costs one march, no iterations.

    ::

        +---+-----+------+-----+---+   outer
        |   |     |      |     |   |   j marches from the front to the outer curve
        +---+---+---+---+---+--+---+   front; i runs along it, clockwise round a closed one

    Parameters
    ----------
    front : Mesh or (n, 3) float
        The curve, in a plane of any attitude, whose points are kept.
    outer : Mesh or (m, 3) float
        The outer curve. With as many points as the front they are kept, too, and joined to the front's in order, those
        of a closed one beginning with the nearest to the front's first; else it is given new points.
    first_side, last_side : Mesh or (m, 3) float, optional
        Sides of the grid at the ends of an open front; by default straight.
    first_height : Length
        Height of the first layer, relative to the front.
    growth : float
        Heights grow by no more, if `layers` is left out.
    layers : int, optional
        Cells along j; the growth then follows from the first height.
    spacing : Spacing, optional
        Law of the spacing along each line, in place of a first height that grows; its relative lengths are relative to
        the front. Needs `layers`.
    progress : Progress, optional
        Called with fraction and message.

    Returns
    -------
    Result
        `StructuredGrid` of (ni, layers + 1, 1) points, periodic in i if the front is closed, whose faces are the "wall"
        (jmin) and the "outer" curve (jmax).

    Raises
    ------
    InvalidInput
        If a height does not fit, or a spacing is given without the number of layers.
    InvalidGeometry
        If the curves are not in one plane, cross themselves, or are not both open or both closed.
    GenerationFailed
        If the outer curve could not be reached; `partial` is the grid up to there, and the message says where.

    Notes
    -----
    Each layer is one implicit step: hyperbolic at the front, and towards the outer curve the elliptic equation's second
    difference along the front, with a local reference grid of straight lines for what lies ahead.

    References
    ----------
    Survey, section 2.7.2. S. Nakamura, in "Numerical Grid Generation" (ed. Thompson, 1982).
    R. W. Noack, D. A. Anderson, AIAA J. 28 (1990).

    Examples
    --------
    >>> from meshcore import gallery
    >>> far_field = gallery.circle(64, radius=5, centre=(0.5, 0))
    >>> grid, report = parabolic(gallery.airfoil("rae2822"), far_field, first_height=1e-4)
    >>> bool(np.allclose(np.linalg.norm(grid.points[:, -1, 0] - [0.5, 0, 0], axis=1), 5, rtol=2e-3))
    True
    """
    ready = read_front(front)
    check_size(len(ready.points) + 1, (layers or 1) + 1, parameter="layers")
    target = outer_points(ready, outer)
    given = {"first_side": first_side, "last_side": last_side}
    sides = [None if side is None else ready.plane.to_plane(polyline(side, name)) for name, side in given.items()]
    if ready.reversed:
        sides.reverse()
    height = absolute(first_height, ready.diagonal)
    fractions = _fractions(ready, target, height, growth, layers, spacing)
    check_size(len(ready.points) + 1, len(fractions), parameter="layers")
    result = marched(
        ready.points,
        target,
        fractions,
        closed=ready.closed,
        sides=(sides[0], sides[1]),
        progress=part_of(progress, 0.0, 0.8),
    )
    advance(progress, 0.8, "checking the grid")
    names = {"jmin": "wall", "jmax": "outer"}
    grid = StructuredGrid(ready.in_space(result.points), names=names, periodic=(ready.closed, False, False))
    if result.stop is not None:
        told = stop_told(result.stop, ready, len(fractions) - 1)
        at, partial = [ready.number[result.stop.point]], grid if result.stop.layer else None
        raise GenerationFailed(f"{told}; {_CURE}", parameter="front", points=at, partial=partial)
    refuse_folds(grid, _CURE)
    validate(grid)
    counts = {"points": grid.n_points, "quads": grid.n_cells, "layers": grid.cell_shape[1]} | changes_told(result)[0]
    asked = fractions[1] * np.linalg.norm(target - ready.points, axis=1)
    quality = {**summary(grid), **layers_told(result.points, asked), **worst_skew(grid)}
    return Result(grid, Report(counts=counts, quality=quality, warnings=ready.warnings))


def _fractions(ready: Front, outer: np.ndarray, height, growth, layers, spacing) -> np.ndarray:
    """(layers + 1, n) float: the share of the way at which each layer ends, along each line."""
    reach = np.linalg.norm(outer - ready.points, axis=1)
    if spacing is not None:
        if layers is None:
            raise InvalidInput("is needed with a spacing", parameter="layers")
        lines = [np.array([[0.0, 0, 0], [length, 0, 0]]) for length in reach]
        return np.array([spacing.fractions(layers, line, diagonal=ready.diagonal) for line in lines]).T
    nearest = float(reach.min())
    if nearest == 0:
        k = int(reach.argmin())
        raise InvalidGeometry(
            f"touches the front at its point {ready.number[k]}; move it away", parameter="outer", points=[k]
        )
    if layers is None:
        if height >= nearest:
            raise InvalidInput(
                f"is {height:.6g}, but the outer curve comes as near as {nearest:.6g}; make it smaller",
                parameter="first_height",
            )
        layers = cells_for_growth(height / float(reach.max()), growth)
    if layers == 1:
        return np.array([[0.0], [1.0]])
    try:
        return np.array([geometric(layers, first=height / length) for length in reach]).T
    except InvalidInput as error:
        raise InvalidInput(
            f"{height:.6g} does not fit {layers} layers over {nearest:.6g}: {error}", parameter="first_height"
        ) from None
