"""Planar marches that end on a given outer curve: half of the way they are hyperbolic, then drawn onto it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from ...errors import GenerationFailed, InvalidGeometry, InvalidInput
from ...geometry.curves import Curve
from ...mesh import StructuredGrid
from ...progress import Progress, part_of
from ...sizing import geometric
from ..poisson.elliptic_problem import Asked, solved
from . import hyperbolic_march, parabolic_march
from .fronts import Front, reason_told
from .hyperbolic_march import Dissipation, Marched
from .layer_heights import layer_heights
from .march_stops import Stop
from .marching_ends import End
from .outer_points import EVENNESS, outer_points

SHARE = 0.5
"""Of the least way to the outer curve: how much of it is marched by the hyperbolic equations, as in space."""


def heights_to(ready: Front, target: np.ndarray, first: float, growth: float, layers: int | None) -> np.ndarray:
    """(layers,) float: heights of layers that come as far as the outer points are on average.

    Parameters
    ----------
    ready : Front
        What is marched off.
    target : (n, 2) float
        The point of the outer curve for each of the front's.
    first : float
        Height of the first layer.
    growth : float
        The largest growth, by which the number of layers is found, on the longest way.
    layers : int, optional
        Their number; growth follows from it.

    Raises
    ------
    InvalidInput
        If no such heights exist.
    InvalidGeometry
        If the outer curve touches the front.
    """
    reach = np.linalg.norm(target - ready.points, axis=1)
    if reach.min() == 0:
        k = int(reach.argmin())
        raise InvalidGeometry(
            f"touches the front at its point {ready.number[k]}; move it away", parameter="outer", points=[k]
        )
    if layers == 1:
        return np.array([reach.mean()])
    if first >= reach.min():
        raise InvalidInput(
            f"is {first:.6g}, but the outer curve comes as near as {reach.min():.6g}; make it smaller",
            parameter="first_height",
        )
    count = len(layer_heights(first, growth, distance=float(reach.max()))) if layers is None else layers
    return np.diff(geometric(count, first=first / float(reach.mean()))) * float(reach.mean())


def marched_onto(
    ready: Front,
    heights: np.ndarray,
    outer: Curve,
    *,
    ends: tuple[End, End],
    dissipation: Dissipation,
    progress: Progress,
) -> Marched:
    """As many layers as there are heights, the last of them on the outer curve.

    The march goes on by the parabolic scheme from where half of the least way is behind it, or where it has to stop; if
    that does not reach the curve, from earlier layers, and at last by the elliptic equations. What then does not either
    has the layers up to where the parabolic scheme stopped.
    """
    layers = len(heights)
    nearest = float(cKDTree(outer_points(ready, outer)).query(ready.points)[0].min())
    total = np.cumsum(heights.max(axis=1) if heights.ndim == 2 else heights)
    asked = max(0, min(int(np.searchsorted(total, SHARE * nearest, side="right")), layers - 2))
    inside = Marched(ready.points[:, None], 0, None)
    if asked:
        inside = hyperbolic_march.marched(
            ready.points,
            heights[:asked],
            closed=ready.closed,
            ends=ends,
            dissipation=dissipation,
            progress=part_of(progress, 0.0, 0.4),
        )
    made = inside.points.shape[1] - 1
    tries = [("parabolic", k) for k in dict.fromkeys((made, max(0, made - 2), max(0, made - 8), made // 2, 0))]
    tries += [("elliptic", k) for k in dict.fromkeys((max(0, made - 2), made // 2, 0))]
    farthest = inside
    for number, (scheme, kept) in enumerate(tries):
        step = part_of(progress, 0.4 + 0.6 * number / len(tries), 0.4 + 0.6 * (number + 1) / len(tries))
        start = np.ascontiguousarray(inside.points[:, kept])
        evenness = EVENNESS if kept == 0 or kept < asked else 0.0  # half of the way a front has evened out by itself
        target = outer_points(replace(ready, points=start), outer, evenness)
        rest = _rest(scheme, ready, start, heights[min(kept, layers - 1) :], target, step)
        if rest is None:
            continue
        found = _joined(inside, rest, kept)
        if found.stop is None:
            ready.warnings.extend(_told(ready, inside.stop, scheme, kept, made))
            return found
        if farthest.stop is None or found.stop.layer > farthest.stop.layer:
            farthest = found
    return farthest


def _joined(inside: Marched, rest: Marched, kept: int) -> Marched:
    """The layers of a march, and from the kept one on those of the rest."""
    points = np.concatenate([inside.points[:, : kept + 1], rest.points[:, 1:]], axis=1)
    stop = None if rest.stop is None else rest.stop._replace(layer=rest.stop.layer + kept)
    return Marched(points, inside.split + rest.split, stop, max(inside.raised, rest.raised))


def _told(ready: Front, stop: Stop | None, scheme: str, kept: int, made: int) -> list[str]:
    """What there is to tell of a grid whose march was not ended as was meant."""
    if stop is not None:
        reason = f"since after layer {made} {reason_told(stop, ready)}"
    elif kept < made or scheme == "elliptic":
        reason = f"since the parabolic scheme did not reach it from layer {made}"
    else:
        return []
    return [f"beyond layer {kept} it is {scheme} and ends on the outer curve, {reason}"]


def _rest(scheme: str, ready: Front, start, heights: np.ndarray, target, progress: Progress) -> Marched | None:
    """Layers from a front to the outer points by another scheme, the first as high as asked; None if there are none."""
    reach = np.linalg.norm(target - start, axis=1)
    if reach.min() == 0:
        return None
    layers = len(heights)
    first = np.clip(np.broadcast_to(heights[0], reach.shape) / reach, 1e-11, 1 / layers)
    fractions = np.array([geometric(layers, first=f) if layers > 1 else [0.0, 1.0] for f in first]).T
    if scheme == "parabolic":
        return parabolic_march.marched(start, target, fractions, closed=ready.closed, progress=progress)
    straight = start[:, None] + fractions.T[..., None] * (target - start)[:, None]
    grid = StructuredGrid(
        np.concatenate([straight, straight[:1]]) if ready.closed else straight, periodic=(ready.closed, False, False)
    )
    try:
        points = solved(grid, Asked(control="boundary spacing"), progress).mesh.points[:, :, 0, :2]
    except (GenerationFailed, InvalidGeometry):
        return None
    return Marched(points[:-1] if ready.closed else points, 0, None)
