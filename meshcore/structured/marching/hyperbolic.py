"""Planar grids that march off a curve by the hyperbolic equations (survey 2.7.1)."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np

from ...errors import GenerationFailed, InvalidInput
from ...geometry.curves import Curve, polyline
from ...mesh import StructuredGrid
from ...operation import Length, Param, Port, Relative, absolute, operation
from ...progress import Progress, advance, part_of, silent
from ...quality import summary, validate
from ...report import Report, Result
from ..folds import refuse_folds
from ..layer_report import layers_told, worst_skew
from ..limits import LARGEST, check_size
from .fronts import Front, changes_told, read_front, stop_told
from .hyperbolic_march import Dissipation, Marched, marched
from .layer_heights import checked_heights, layer_heights
from .marching_ends import Along, End, Free, Mirror, OnCurve, Splay
from .marching_parameters import FirstHeightParam, GrowthParam, LargestHeightParam, LayersParam, asked_heights
from .outer_front import heights_to, marched_onto
from .outer_points import outer_points

__all__ = ["hyperbolic", "layer_heights", "marched"]

EndChoice = Literal["free", "plane", "constant x", "constant y", "curve", "splay"]
_CURE = "give the front more points where it bends, or march less far"
_END = "What the open front's {} point does: go freely, meet a plane of symmetry, keep x or y, follow a curve, lean out"


@operation("Hyperbolic Grid", category="Structured", output="grid")
def hyperbolic(
    front: Annotated[
        Curve, Port("The curve to march off: line cells in one chain, open or closed, in a plane", cells=("line",))
    ],
    first_curve: Annotated[
        Curve | None, Port("Curve that the first point follows, if its end asks for it", cells=("line",), named=True)
    ] = None,
    last_curve: Annotated[
        Curve | None, Port("Curve that the last point follows, if its end asks for it", cells=("line",), named=True)
    ] = None,
    outer: Annotated[
        Curve | None,
        Port("Curve at which the layers end, in place of a distance", cells=("line",), named=True),
    ] = None,
    *,
    first_height: FirstHeightParam = Relative(0.001),
    growth: GrowthParam = 1.15,
    layers: LayersParam = None,
    distance: Annotated[
        Length | None, Param("Sum of the heights; by default the front's own size, or what layers make", group="Layers")
    ] = None,
    largest_height: LargestHeightParam = None,
    other_side: Annotated[
        bool, Param("March to the other side: into a closed front, or to the right of an open one")
    ] = False,
    first_end: Annotated[EndChoice, Param(_END.format("first"), group="Ends")] = "free",
    last_end: Annotated[EndChoice, Param(_END.format("last"), group="Ends")] = "free",
    splay: Annotated[
        float, Param("By how much ends that splay lean outwards", min=0, max=80, unit="degree", group="Ends")
    ] = 15.0,
    smoothing: Annotated[
        float, Param("Dissipation in units of the cells' aspect ratio", min=0, max=2, advanced=True)
    ] = Dissipation.base,
    implicitness: Annotated[
        float, Param("How far the equations look ahead beyond the next layer", min=0, max=4, advanced=True)
    ] = Dissipation.implicitness,
    volume_smoothing: Annotated[
        float,
        Param("1 widens all cells of a layer alike, 0 keeps heights at each point", min=0, max=1, advanced=True),
    ] = Dissipation.volume_smoothing,
    volume_averaging: Annotated[
        float, Param("How far thick cells widen like those around", min=0, max=1, advanced=True)
    ] = Dissipation.volume_averaging,
    heights: np.ndarray | None = None,
    progress: Progress = silent,
) -> Result:
    """March layers of quadrilaterals off a curve, at right angles and with given heights.

    The front's points are kept exactly. Closed fronts march outwards, open ones to their left. No parameter needs a
    choice: where a layer would fold it is made in smaller steps and with more dissipation, and fronts that would meet
    across a bay are slowed down and drawn out of it.

    ::

        . . . . . . . . . . . . .
        .   .   .   .   .   .   .     j marches away from the front
        +---+---+---+---+---+---+     i runs along it; clockwise round a closed one

    Parameters
    ----------
    front : Mesh or (n, 3) float
        The curve, in a plane of any attitude. Open ones march to the left of their direction, seen from the side that
        the plane's normal (its largest component positive) points to.
    first_curve, last_curve : Mesh or (m, 3) float, optional
        In the same plane, from the front's first or last point on.
    outer : Mesh or (m, 3) float, optional
        Where layers end, in place of a distance. They are marched half of the least way, and then drawn onto it as
        those of `parabolic`, or else by the elliptic equations. With no number of layers, it is such that heights grow
        by `growth` on the longest way.
    first_height : Length
        Height of the first layer.
    growth : float
        Each height over the one before. With a distance and no number of layers, the largest that is allowed.
    layers : int, optional
        Cells along j.
    distance : Length, optional
        Sum of the heights. With `layers`, growth follows from both.
    largest_height : Length, optional
        Heights stay below.
    other_side : bool
        March into a closed front, or to the right of an open one.
    first_end, last_end : {"free", "plane", "constant x", "constant y", "curve", "splay"}
        Conditions at the ends of an open front, in the order in which its points are given. "plane" is a plane of
        symmetry square to the front; x and y are those of its plane.
    splay : float
        Degrees by which ends that splay lean outwards.
    smoothing : float
        Dissipation in units of the cells' aspect ratio: Chan and Steger's epsilon (pyHyp's epsE, and epsI).
    implicitness : float
        Kinsey and Barth's theta (pyHyp's theta): how far the equations look ahead beyond the next layer.
    volume_smoothing : float
        How far all cells of a layer widen alike (pyHyp's volBlend): 1 shares all of it, so that a circle stays one; 0
        keeps heights at each point as well as dissipation lets them.
    volume_averaging : float
        How far cells widen like those around as they get thick (in place of pyHyp's volCoef and volSmoothIter). Lines
        off corners get less skew, fronts round sharp edges less round.
    heights : (layers,) or (layers, n) float, optional
        Heights of layers in place of all that is said of them, the same everywhere or for each of the front's points.
    progress : Progress, optional
        Called with fraction and message.

    Returns
    -------
    Result
        `StructuredGrid` of (ni, layers + 1, 1) points, periodic in i if the front is closed, whose faces are the "wall"
        (jmin) and the "outer" front (jmax). If the march had to stop it has fewer layers, `converged` is False, and a
        warning says at which point, layer and concavity; the point data "stopped" are 1 there, for hosts to show.

    Raises
    ------
    InvalidInput
        If heights do not fit each other, or an end asks for a curve that is not given.
    InvalidGeometry
        If the front is not planar or crosses itself.
    GenerationFailed
        If not even one layer could be made.

    Notes
    -----
    The equations of orthogonality and area are linearised about the last layer and solved implicitly, with dissipation
    that grows with the cells' aspect ratio, at concave corners with the inverse square of the sine of half their angle,
    and, like the square of a bay's points, where fronts are about to meet. Dissipation is implicit as far as it is
    explicit, and not scaled by the number of the layer, so that fewer layers are the first ones of more.

    References
    ----------
    Survey, section 2.7.1. J. L. Steger, D. S. Chaussee, SIAM J. Sci. Stat. Comput. 1 (1980).
    W. M. Chan, J. L. Steger, Appl. Math. Comput. 51 (1992).

    Examples
    --------
    >>> from meshcore import gallery
    >>> grid, report = hyperbolic(gallery.airfoil("rae2822"), first_height=1e-4, layers=50)
    >>> grid, report.converged
    (StructuredGrid(129 x 51 points), True)
    """
    ready = read_front(front, other_side=other_side)
    target = None if outer is None else outer_points(ready, outer)
    check_size(len(ready.points) + 1, (layers or 1) + 1, parameter="layers")
    asked = first_height, growth, layers, distance, largest_height
    thickness = _asked_heights(ready, target, asked) if heights is None else _given_heights(ready, heights)
    check_size(len(ready.points) + 1, len(thickness) + 1, parameter="layers")
    if not thickness.max() < LARGEST / len(thickness):
        raise InvalidInput(f"reach {thickness.max():.3g} and more; make them smaller", parameter="heights")
    ends = _ends(ready, (first_end, last_end), (first_curve, last_curve), splay)
    dissipation = Dissipation(smoothing, implicitness, volume_smoothing, volume_averaging)
    step = part_of(progress, 0.0, 0.8)
    if target is None:
        result = marched(
            ready.points, thickness, closed=ready.closed, ends=ends, dissipation=dissipation, progress=step
        )
    else:
        result = marched_onto(ready, thickness, outer, ends=ends, dissipation=dissipation, progress=step)
    advance(progress, 0.8, "checking the grid")
    return _reported(ready, result, thickness)


def _given_heights(ready: Front, given: np.ndarray) -> np.ndarray:
    """Heights that were given, in the order of the front as it marches."""
    given = checked_heights(given, len(ready.points))
    if ready.reversed:
        given = np.roll(given[:, ::-1], 1, axis=1) if ready.closed else given[:, ::-1]
    return given[:, 0] if given.shape[1] == 1 else given


def _asked_heights(ready: Front, target: np.ndarray | None, asked: tuple) -> np.ndarray:
    """Heights as the parameters ask for them, up to the outer points if there are any."""
    if target is None:
        return asked_heights(*asked, diagonal=ready.diagonal)
    first_height, growth, layers, distance, largest = asked
    for name, value in (("distance", distance), ("largest_height", largest)):
        if value is not None:
            raise InvalidInput("is given beside an outer curve, which says how far layers go", parameter=name)
    return heights_to(ready, target, absolute(first_height, ready.diagonal), growth, layers)


def _ends(ready: Front, choices: tuple[str, str], curves: tuple, splay: float) -> tuple[End, End]:
    """The conditions at the ends, in the order of the front as it marches."""
    ends: list[End] = []
    for name, choice, curve in zip(("first", "last"), choices, curves, strict=True):
        if ready.closed and choice != "free":
            raise InvalidInput(f"is {choice!r}, but the front is closed and has no ends", parameter=f"{name}_end")
        if choice == "curve" and curve is None:
            raise InvalidInput("is needed, since the end asks for it", parameter=f"{name}_curve")
        if choice == "curve":
            points = ready.plane.to_plane(polyline(curve, f"{name}_curve"))
            ends.append(OnCurve(points))
        else:
            fixed = {"free": Free(), "plane": Mirror(), "constant x": Along((0, 1)), "constant y": Along((1, 0))}
            ends.append(Splay(splay) if choice == "splay" else fixed[choice])
    return (ends[1], ends[0]) if ready.reversed else (ends[0], ends[1])


def _reported(ready: Front, result: Marched, asked: np.ndarray) -> Result:
    made = result.points.shape[1] - 1
    changed, told = changes_told(result)
    warnings = [*ready.warnings, *told]
    if result.stop is not None:
        warnings.append(f"{stop_told(result.stop, ready, len(asked))}; {_CURE}")
        if made == 0:
            at = [ready.number[result.stop.point]]
            raise GenerationFailed(f"no layer could be made: {warnings[-1]}", parameter="front", points=at)
    names = {"jmin": "wall", "jmax": "outer"}
    grid = StructuredGrid(ready.in_space(result.points), names=names, periodic=(ready.closed, False, False))
    refuse_folds(grid, _CURE)
    validate(grid)
    if result.stop is not None:
        stopped = np.zeros(grid.shape)
        stopped[[result.stop.point, -1] if ready.closed and result.stop.point == 0 else result.stop.point, -1] = 1
        grid = grid.with_point_data(stopped=stopped)
    counts = {"points": grid.n_points, "quads": grid.n_cells, "layers": made, **changed}
    quality = {**summary(grid), **layers_told(result.points, asked[0]), **worst_skew(grid)}
    report = Report(counts=counts, quality=quality, warnings=warnings, converged=result.stop is None)
    return Result(grid, report)
