"""Gradation of a size field that is a function: limited on samples that are as dense as the sizes are small."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from ..geometry.location import Locator
from ..geometry.plane import Plane
from ..mesh import Mesh
from ..progress import Progress, advance, silent
from ..sizing.background import background_field
from ..sizing.gradation import limited
from ..sizing.size_field import SizeField, evaluated
from .delaunay import delaunay_2d
from .refiner import MAX_TRIANGLES

# Samples along the longer side of the domain, before there are more where sizes are small.
_ALONG = 128
_MOST = 1_000_000


def gradual(
    size_field: SizeField, carrier: Mesh, plane: Plane, gradation: float, progress: Progress = silent
) -> SizeField:
    """A size field that grows no faster than ``gradation``, as far as samples tell.

    They begin as the corners of the domain and an even lattice in it. Edges between samples are halved where triangles
    will be smaller than they are long, and where the field is so steep that its least value may lie between their ends.
    The field is asked nowhere outside the domain.

    Parameters
    ----------
    size_field : callable
        Takes (m, 3) points, returns (m,) sizes.
    carrier : Mesh
        Triangles that cover the domain.
    plane : Plane
        That they lie in.
    gradation : float
        Largest growth of the size per unit length.
    progress : Progress
        Is told when there are more samples, with fraction 0.

    Raises
    ------
    InvalidInput
        If a size is not finite and greater than zero.
    """
    locator = Locator(carrier)
    corners = plane.to_plane(carrier.points[np.unique(carrier.get("triangle"))])

    def sampled(places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        points = plane.to_space(places)
        return points, evaluated(size_field, points)

    def within(places: np.ndarray) -> np.ndarray:
        return places[locator.locate(plane.to_space(places)).cell >= 0]

    places = np.concatenate([corners, within(_lattice(corners))])
    points, sizes = sampled(places)
    while True:
        advance(progress, 0.0, "limiting the gradation")
        triangles = delaunay_2d(places).mesh.get("triangle")
        mesh = Mesh(points, {"triangle": triangles})
        slow = limited(mesh, sizes, gradation)
        long = _too_long(mesh.edges, places, sizes, slow)
        if (
            _triangles(places[triangles], slow[triangles]) > MAX_TRIANGLES
        ):  # which is refused, by the sizes known so far
            break
        new = within(_new_middles(places, long))
        if not len(new) or len(places) + len(new) > _MOST:
            break
        more, at_more = sampled(new)
        places, points, sizes = (np.concatenate(pair) for pair in ((places, new), (points, more), (sizes, at_more)))
    field = background_field(mesh, slow)
    return lambda points: np.minimum(evaluated(size_field, points), field(points))


def _too_long(ends: np.ndarray, places: np.ndarray, sizes: np.ndarray, slow: np.ndarray) -> np.ndarray:
    """The edges to be halved, by the limited sizes at their ends: longer than two, or the field may change by one.

    It may by the steepest slope at the ends. As steps stay steep, this holds down to a 16th of the size.
    """
    length = np.linalg.norm(places[ends[:, 1]] - places[ends[:, 0]], axis=1)
    least = slow[ends].min(axis=1)
    ends, length, least = (values[length > least / 16] for values in (ends, length, least))
    steepest = np.zeros(len(places))
    slope = np.abs(sizes[ends[:, 1]] - sizes[ends[:, 0]]) / length
    np.maximum.at(steepest, ends.ravel(), np.repeat(slope, 2))
    return ends[(length > 2 * least) | (steepest[ends].max(axis=1) * length > least)]


def _new_middles(places: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """(k, 2) float: the middles of edges that are not near a sample already, as those along a straight outline are."""
    a, b = places[ends[:, 0]], places[ends[:, 1]]
    middle = 0.5 * (a + b)
    return middle[cKDTree(places).query(middle)[0] > np.linalg.norm(b - a, axis=1) / 8]


def _triangles(corners: np.ndarray, sizes: np.ndarray) -> float:
    """Roughly how many triangles cover (m, 3, 2) corners of larger ones, with (m, 3) sizes there; rather too few."""
    (ax, ay), (bx, by) = (corners[:, 1] - corners[:, 0]).T, (corners[:, 2] - corners[:, 0]).T
    with np.errstate(over="ignore", divide="ignore"):
        return float((0.5 * np.abs(ax * by - ay * bx) / sizes.mean(axis=1) ** 2).sum())


def _lattice(corners: np.ndarray) -> np.ndarray:
    """(n, 2) float: a triangular lattice, on which ways along edges are little longer than straight ones."""
    low, high = corners.min(axis=0), corners.max(axis=0)
    step = (high - low).max() / _ALONG * np.array([1.0, 0.75**0.5])
    columns, rows = np.meshgrid(*(np.arange(n + 1) for n in np.ceil((high - low) / step).astype(int)))
    return low + step * np.column_stack([(columns + 0.5 * (rows % 2)).ravel(), rows.ravel()])
