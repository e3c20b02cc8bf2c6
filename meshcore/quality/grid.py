"""Quality of structured grids along their lines and at their faces: angles, growth, wall spacing (survey 2.2)."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import combinations
from typing import NamedTuple

import numpy as np

from ..errors import InvalidInput
from ..mesh import StructuredGrid
from ..mesh.structured_grid import FACES
from .measure_table import Measure
from .vectors import cross, dot, length, quotient


class Steps(NamedTuple):
    """The edges before and after each point of a grid, along the lines of one direction.

    Attributes
    ----------
    before, after : (ni, nj, nk, 3) float
        nan at the ends of lines that are not closed.
    """

    before: np.ndarray
    after: np.ndarray

    @classmethod
    def of(cls, grid: StructuredGrid, axis: int) -> Steps:
        """Those of a grid along one axis; all nan where it has one layer only."""
        parts = np.ascontiguousarray(grid.points.transpose(3, 0, 1, 2))  # in memory, as `vectors` wants them
        lines = np.moveaxis(parts.transpose(1, 2, 3, 0), axis, 0)
        edges = np.diff(lines, axis=0)
        none = np.full((1, *lines.shape[1:]), np.nan)
        before = np.concatenate([edges[-1:] if grid.periodic[axis] else none, edges])
        after = np.concatenate([edges, edges[:1] if grid.periodic[axis] else none])
        return cls(np.moveaxis(before, 0, axis), np.moveaxis(after, 0, axis))

    def tangent(self) -> np.ndarray:
        """(ni, nj, nk, 3) float: direction of the parabola through neighbouring points; at ends, of the edge."""
        before, after = length(self.before)[..., None], length(self.after)[..., None]
        middle = quotient(before, after, 0.0) * self.after + quotient(after, before, 0.0) * self.before
        ends = np.where(np.isnan(self.before), self.after, self.before)
        return np.where(np.isnan(middle), ends, middle)


def _directions(grid: StructuredGrid) -> range:
    return range(2 if grid.is_surface else 3)


def _angle(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Angle between two lines in degrees, at most 90; 0 where one has no direction."""
    sine, cosine = length(cross(a, b)), np.abs(dot(a, b))
    return np.degrees(np.arctan2(sine, cosine))


def line_angle(grid: StructuredGrid) -> np.ndarray:
    """Angle between the lines at each point: 90 degrees on an orthogonal grid.

    Parameters
    ----------
    grid : StructuredGrid
        A surface or a volume.

    Returns
    -------
    (ni, nj, nk) float
        Degrees; the least of the angles between two lines. The survey accepts 45 degrees inside a grid.

    Examples
    --------
    >>> x, y = np.meshgrid(np.arange(3.0), np.arange(3.0), indexing="ij")
    >>> line_angle(StructuredGrid(np.stack([x + y, y], axis=-1)))[:, 1, 0].round(9).tolist()
    [45.0, 45.0, 45.0]
    """
    tangents = [Steps.of(grid, axis).tangent() for axis in _directions(grid)]
    return np.minimum.reduce([_angle(a, b) for a, b in combinations(tangents, 2)])


def growth_ratio(grid: StructuredGrid, axis: int) -> np.ndarray:
    """Length of the edge after each point over that before it, along the lines of one direction.

    Parameters
    ----------
    grid : StructuredGrid
        A surface or a volume.
    axis : int
        0, 1, 2 for i, j, k.

    Returns
    -------
    (ni, nj, nk) float
        Above 1 where cells grow with the index; nan at the ends of lines that are not closed.

    Examples
    --------
    >>> x, y = np.meshgrid([0.0, 1, 3, 7], np.arange(2.0), indexing="ij")
    >>> growth_ratio(StructuredGrid(np.stack([x, y], axis=-1)), 0)[:, 0, 0].tolist()
    [nan, 2.0, 2.0, nan]
    """
    steps = Steps.of(grid, axis)
    before, after = length(steps.before), length(steps.after)
    ratio = quotient(after, before, np.inf)
    return np.where(np.isnan(before) | np.isnan(after), np.nan, ratio)


class _Wall(NamedTuple):
    """A face of the grid: the edges that leave it, and how far they reach along its normal."""

    edges: np.ndarray
    heights: np.ndarray


def _wall(grid: StructuredGrid, face: str) -> _Wall:
    if face not in FACES:
        raise InvalidInput(f"{face!r} is no face; faces are {', '.join(FACES)}", parameter="face")
    axis, last = divmod(FACES.index(face), 2)
    if axis not in _directions(grid):
        raise InvalidInput(f"is {face!r}, but a surface has no faces across k", parameter="face")

    def at(values: np.ndarray, layer: int) -> np.ndarray:
        return np.take(values, -1 - layer if last else layer, axis)

    edges = at(grid.points, 1) - at(grid.points, 0)
    tangents = [at(Steps.of(grid, other).tangent(), 0) for other in _directions(grid) if other != axis]
    if len(tangents) == 2:
        normal = cross(*tangents)
        return _Wall(edges, np.abs(quotient(dot(edges, normal), length(normal), 0.0)))
    return _Wall(edges, quotient(length(cross(edges, tangents[0])), length(tangents[0]), 0.0))


def first_height(grid: StructuredGrid, face: str) -> np.ndarray:
    """Distance of the first points off a face from it, along its normal.

    Parameters
    ----------
    grid : StructuredGrid
        A surface, whose faces are curves in it, or a volume.
    face : str
        "imin", "imax", "jmin", "jmax", "kmin" or "kmax".

    Returns
    -------
    (n, m) float
        At the points of the face, in the order of the two other indices.

    Raises
    ------
    InvalidInput
        If there is no such face.

    Examples
    --------
    >>> x, y = np.meshgrid(np.arange(3.0), [0.0, 0.25, 1.0], indexing="ij")
    >>> grid = StructuredGrid(np.stack([x + 3 * y, y], axis=-1))
    >>> first_height(grid, "jmin").ravel().tolist(), first_height(grid, "jmax").ravel().tolist()
    ([0.25, 0.25, 0.25], [0.75, 0.75, 0.75])
    """
    return _wall(grid, face).heights


def face_angle(grid: StructuredGrid, face: str) -> np.ndarray:
    """Angle between a face and the lines that leave it: 90 degrees along its normal.

    Parameters
    ----------
    grid : StructuredGrid
        A surface, whose faces are curves in it, or a volume.
    face : str
        "imin", "imax", "jmin", "jmax", "kmin" or "kmax".

    Returns
    -------
    (n, m) float
        Degrees, at the points of the face, in the order of the two other indices.

    Raises
    ------
    InvalidInput
        If there is no such face.

    Examples
    --------
    >>> x, y = np.meshgrid(np.arange(3.0), np.arange(3.0), indexing="ij")
    >>> face_angle(StructuredGrid(np.stack([x + y, y], axis=-1)), "jmin").round(9).ravel().tolist()
    [45.0, 45.0, 45.0]
    """
    edges, heights = _wall(grid, face)
    return np.degrees(np.arcsin(np.clip(quotient(heights, length(edges), 0.0), 0, 1)))


def with_quality(grid: StructuredGrid) -> StructuredGrid:
    """The same grid with its quality as data, for pictures, files and hosts.

    Parameters
    ----------
    grid : StructuredGrid
        A surface or a volume.

    Returns
    -------
    StructuredGrid
        With all of `MEASURES` that are defined for it as cell data, and the angle and the growth as point data.

    Examples
    --------
    >>> x, y = np.meshgrid(np.arange(3.0), np.arange(3.0), indexing="ij")
    >>> sorted(with_quality(StructuredGrid(np.stack([x, y], axis=-1))).point_data)
    ['growth_i', 'growth_j', 'line_angle']
    """
    cells = {name: known.function(grid) for name, known in MEASURES.items()}
    points = {f"growth_{'ijk'[axis]}": growth_ratio(grid, axis) for axis in _directions(grid)}
    defined = {name: values for name, values in cells.items() if not np.isnan(values).all()}
    return grid.with_cell_data(**defined).with_point_data(line_angle=line_angle(grid), **points)


# ---- as measures of cells: the worst of a cell's points


def _over_corners(reduce: np.ufunc, values: np.ndarray) -> np.ndarray:
    """(ni-1, nj-1, max(nk-1, 1)) float: the largest, or smallest, of a cell's corners that is not nan."""
    for axis in range(3):
        if values.shape[axis] > 1:
            lines = np.moveaxis(values, axis, 0)
            values = np.moveaxis(reduce(lines[:-1], lines[1:]), 0, axis)
    return np.ascontiguousarray(values)


def _angle_of_cells(grid: StructuredGrid) -> np.ndarray:
    return _over_corners(np.fmin, line_angle(grid))


def _growth_of_cells(axis: int, grid: StructuredGrid) -> np.ndarray:
    ratio = growth_ratio(grid, axis)
    return _over_corners(np.fmax, np.fmax(ratio, quotient(1.0, ratio, np.where(np.isnan(ratio), np.nan, np.inf))))


def _of_first_cells(face: str, at_points: Callable, grid: StructuredGrid) -> np.ndarray:
    """The least of the values at a cell's corners on the face; nan away from it, and at faces that are none."""
    axis, last = divmod(FACES.index(face), 2)
    found = np.full(grid.cell_shape, np.nan)
    if axis in _directions(grid) and not grid.periodic[axis]:
        values = _over_corners(np.fmin, np.expand_dims(at_points(grid, face), axis))
        np.moveaxis(found, axis, 0)[-1 if last else 0] = values.squeeze(axis)
    return found


MEASURES = {
    "line_angle": Measure(_angle_of_cells, (45, 90), "degree"),
    **{f"growth_{name}": Measure(partial(_growth_of_cells, axis), (1, 1.3)) for axis, name in enumerate("ijk")},
    **{
        f"{name}_{face}": Measure(partial(_of_first_cells, face, function), acceptable, unit)
        for face in FACES
        for name, function, acceptable, unit in (
            ("first_height", first_height, (0, np.inf), "length"),
            ("face_angle", face_angle, (45, 90), "degree"),
        )
    },
}
"""Measures of a structured grid's cells, whose function takes the grid; nan where the grid has no such thing.

The survey accepts 45 degrees inside a grid (section 2.2) and asks for orthogonality at boundaries.
"""
