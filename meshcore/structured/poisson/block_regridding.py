"""Blocks whose edges are gridded anew, and then their faces, on the surfaces through their points (survey 2.6)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product

import numpy as np

from ...errors import InvalidGeometry, InvalidInput
from ...geometry.curves import arc_length
from ...geometry.parametric import spline
from ...geometry.surfaces import SplineSurface
from ...operation import Length
from ...sizing import Spacing, copied
from ..algebraic.blending import Patch, crossing
from ..algebraic.block_edges import Asked, checked_spacings
from ..algebraic.block_faces import AXES, PLACES, across, end
from ..algebraic.sides import fractions_of
from ..algebraic.transfinite_volume import interpolated_volume

_FINE = 16  # pieces of each cell's edge by which the length of its curve is measured


def asked_of_edges(
    law: str,
    cells: tuple[int | None, int | None, int | None],
    ends: Mapping[str, Length | None],
    spacings: Mapping[str, Spacing] | None,
    diagonal: float,
) -> Asked | None:
    """What is asked of the edges of a block; None if they keep their points.

    Parameters
    ----------
    law : str
        "kept", or a law of `Spacing`.
    cells : tuple of three int or None
        Numbers of cells along i, j, k.
    ends : dict of str to Length or None
        By face, the size of the cells that touch it.
    spacings : dict of str to Spacing, optional
        By axis, in place of law and ends.
    diagonal : float
        What relative lengths are relative to.

    Raises
    ------
    InvalidInput
        If sizes of cells are asked of edges that are kept, or spacings of what is no axis.

    Examples
    --------
    >>> asked_of_edges("kept", (None, None, None), dict.fromkeys(PLACES), None, 1.0) is None
    True
    """
    spacings = checked_spacings(spacings)
    given = [place for place in PLACES if ends[place] is not None and place[0] not in spacings]
    if law == "kept" and given:
        raise InvalidInput("is given, but edges are kept; choose a law for them", parameter=f"spacing_{given[0]}")
    if law == "kept" and not spacings and cells == (None, None, None):
        return None
    return Asked(cells, "as given" if law == "kept" else law, ends, diagonal, spacings)


@dataclass(frozen=True)
class _Edge:
    """New points of an edge, and the numbers that they have among its old ones, which are whole at those."""

    points: np.ndarray
    numbers: np.ndarray


def regridded(points: np.ndarray, asked: Asked) -> np.ndarray:
    """A block with other points on its edges, and so on its faces and inside.

    Points move along the cubic splines through the points of an edge. The faces are the bicubic surfaces through their
    points, on which new lines run from edge to edge as straight as the surface's parameters let them. The inside is
    filled by transfinite interpolation.

    Parameters
    ----------
    points : (ni, nj, nk, 3) float
        The block.
    asked : Asked
        Numbers of cells, law, and sizes of end cells. Edges of an axis of which nothing is asked keep their points.

    Returns
    -------
    (mi, mj, mk, 3) float

    Raises
    ------
    InvalidInput
        If the law cannot have these sizes on an edge.

    Examples
    --------
    >>> box = np.stack(np.meshgrid(*[np.linspace(0, 1, 5)] * 3, indexing="ij"), axis=-1)
    >>> ends = dict.fromkeys(PLACES) | {"kmin": 0.1}
    >>> new = regridded(box, Asked((None, None, 3), "as given", ends, 1.0))
    >>> new.shape, new[1, 2, :, 2].round(3)
    ((5, 5, 4, 3), array([0. , 0.1, 0.4, 1. ]))
    """
    edges = {}
    for axis in range(3):
        lines = np.moveaxis(points, axis, 0)
        for a, b in product((0, 1), repeat=2):
            edges[axis, a, b] = _edge(lines[:, -a, -b], axis, asked)
    faces = {place: _face(points, place, edges) for place in PLACES}
    return interpolated_volume(faces, blending="linear")


def _edge(line: np.ndarray, axis: int, asked: Asked) -> _Edge:
    """New points of one of the four edges along an axis; one without length stays a point."""
    count = asked.cells[axis] or len(line) - 1
    names = [end(axis, 0), end(axis, 1)]
    spacing = asked.along(names)
    even = np.linspace(0, len(line) - 1, count + 1)
    if spacing is None and count == len(line) - 1:
        return _Edge(line, even)
    if not (line != line[0]).any():
        return _Edge(np.broadcast_to(line[0], (count + 1, 3)), even)
    curve = spline(line)
    at = np.interp(np.arange(_FINE * (len(curve.knots) - 1) + 1) / _FINE, np.arange(len(curve.knots)), curve.knots)
    fine = curve.points(at)
    fractions = copied(count, line) if spacing is None else asked.spaced(spacing, count, fine, names)
    new = np.interp(fractions, fractions_of(fine), at)
    found = curve.points(new)
    found[0], found[-1] = line[0], line[-1]
    return _Edge(found, np.interp(new, arc_length(line), np.arange(len(line))))


def _face(points: np.ndarray, place: str, edges: dict[tuple[int, int, int], _Edge]) -> np.ndarray:
    """A face between its new edges, on the surface through its old points; if it is no surface, between the edges."""
    normal, side = AXES.index(place[0]), int(place.endswith("max"))
    first, second = across(place)
    along = {}
    for axis, other in ((first, second), (second, first)):
        for bit in (0, 1):
            ends = {normal: side, other: bit}
            along[axis, bit] = edges[(axis, *(ends[a] for a in sorted(ends)))]
    lines = [along[first, 0], along[first, 1], along[second, 0], along[second, 1]]
    new = Patch(*(lines[k].points for k in (0, 3, 1, 2)), blending="linear").points()
    try:
        surface = SplineSurface(points.take(-side, normal))
    except InvalidGeometry:  # a line or a point, as on the axis of a wedge
        return new
    knots = surface.parameters[:, 0, 0], surface.parameters[0, :, 1]
    at = [np.interp(line.numbers, np.arange(len(knots[k > 1])), knots[k > 1]) for k, line in enumerate(lines)]
    inner = (slice(1, -1), slice(1, -1))
    new[inner] = surface.points(*crossing(*at))[inner]
    return new
