"""Planar grids that march off a curve by the hyperbolic equations (survey 2.7.1)."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np

from ...errors import GenerationFailed, InvalidGeometry, InvalidInput
from ...geometry.curves import Curve, polyline
from ...mesh import StructuredGrid
from ...operation import Length, Param, Port, Relative, operation
from ...progress import Progress, advance, part_of, silent
from ...quality import summary, validate
from ...report import Report, Result
from ...sizing import geometric
from ..folds import refuse_folds
from ..layer_report import layers_told, worst_skew
from ..limits import check_size
from ..poisson.elliptic_problem import Asked, solved
from . import parabolic_march
from .fronts import Front, changes_told, read_front, reason_told, stop_told
from .hyperbolic_march import Dissipation, Marched, marched
from .layer_heights import checked_heights, layer_heights
from .marching_ends import Along, End, Free, Mirror, OnCurve, Splay
from .marching_parameters import FirstHeightParam, GrowthParam, LargestHeightParam, LayersParam, asked_heights
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
        Port("Curve to end at where the march cannot go on", cells=("line",), named=True),
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
        Where the march cannot go on, the rest of the layers is made by the parabolic
        scheme, or else by the elliptic equations, and ends on this curve.
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
        Dissipation in units of the cells' aspect ratio.
    implicitness : float
        Kinsey and Barth's theta.
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
    that grows with the cells' aspect ratio and, like the square of a bay's points, where fronts are about to meet.

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
    thickness = _asked_heights(heights, ready, first_height, growth, layers, distance, largest_height)
    check_size(len(ready.points) + 1, len(thickness) + 1, parameter="layers")
    ends = _ends(ready, (first_end, last_end), (first_curve, last_curve), splay)
    result = marched(
        ready.points,
        thickness,
        closed=ready.closed,
        ends=ends,
        dissipation=Dissipation(smoothing, implicitness),
        progress=part_of(progress, 0.0, 0.6),
    )
    if result.stop is not None and target is not None:
        result = _continued(ready, result, thickness, target, part_of(progress, 0.6, 0.8))
    advance(progress, 0.8, "checking the grid")
    return _reported(ready, result, thickness)


def _asked_heights(given, ready, first_height, growth, layers, distance, largest) -> np.ndarray:
    if given is not None:
        given = checked_heights(given, len(ready.points))
        if ready.reversed:
            given = np.roll(given[:, ::-1], 1, axis=1) if ready.closed else given[:, ::-1]
        return given[:, 0] if given.shape[1] == 1 else given
    return asked_heights(first_height, growth, layers, distance, largest, diagonal=ready.diagonal)


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


def _continued(ready: Front, result: Marched, heights: np.ndarray, target: np.ndarray, progress: Progress) -> Marched:
    """The layers of a march that stopped, or as many of them as need be, and others from there to the outer points."""
    made = result.stop.layer
    tries = [("parabolic", k) for k in dict.fromkeys((made, max(0, made - 2), max(0, made - 8), made // 2))]
    tries += [("elliptic", k) for k in dict.fromkeys((max(0, made - 2), made // 2, 0))]
    for scheme, kept in tries:
        start, layers = result.points[:, kept], max(2, len(heights) - kept)
        reach = np.linalg.norm(target - start, axis=1)
        if reach.min() == 0:
            continue
        first = np.broadcast_to(heights[min(kept, len(heights) - 1)], reach.shape) / reach
        fractions = np.array([geometric(layers, first=f) for f in np.clip(first, 1e-11, 1 / layers)]).T
        rest = _rest(scheme, ready, start, target, fractions, progress)
        if rest is not None:
            ready.warnings.append(
                f"beyond layer {kept} it is {scheme} and ends on the outer curve, since after layer {made} "
                f"{reason_told(result.stop, ready)}"
            )
            return Marched(np.concatenate([result.points[:, : kept + 1], rest[:, 1:]], axis=1), result.split, None)
    return result


def _rest(scheme: str, ready: Front, start, target, fractions, progress: Progress) -> np.ndarray | None:
    """(n, layers + 1, 2) points from a front to the outer curve by another scheme; None if it finds no sound grid."""
    if scheme == "parabolic":
        rest = parabolic_march.marched(start, target, fractions, closed=ready.closed, progress=progress)
        return rest.points if rest.stop is None else None
    straight = start[:, None] + fractions.T[..., None] * (target - start)[:, None]
    grid = StructuredGrid(
        np.concatenate([straight, straight[:1]]) if ready.closed else straight, periodic=(ready.closed, False, False)
    )
    try:
        points = solved(grid, Asked(control="boundary spacing"), progress).mesh.points[:, :, 0, :2]
    except (GenerationFailed, InvalidGeometry):
        return None
    return points[:-1] if ready.closed else points


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
