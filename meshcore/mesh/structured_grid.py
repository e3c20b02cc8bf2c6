"""StructuredGrid: points in rows, columns and layers; neighbours are counted, not stored."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from ..errors import InvalidGeometry, InvalidInput
from .cuts import Cut, checked_cuts, closing, glued
from .extent import extents
from .mesh import Mesh

FACES = ("imin", "imax", "jmin", "jmax", "kmin", "kmax")


@dataclass(frozen=True, eq=False, repr=False)
class StructuredGrid:
    """A block of quadrilaterals (nk = 1) or hexahedra with regular connectivity.

    ::

        j
        ^   (0, nj-1) ---- (ni-1, nj-1)
        |       |               |            points[i, j, k]
        |   (0, 0) -------- (ni-1, 0)
        +--------> i

    Parameters
    ----------
    points : (ni, nj, nk, 3) float
        Coordinates; (ni, nj, 3), (ni, nj, 2) are taken as nk = 1.
    point_data : dict of str to (ni, nj, nk, ...) array
        Values at points.
    cell_data : dict of str to (ni-1, nj-1, max(nk-1, 1), ...) array
        Values on cells.
    names : dict of str to str
        Names of the faces "imin", "imax", "jmin", "jmax", "kmin", "kmax", such as ``{"jmin": "wall"}``.
    periodic : tuple of three bool
        Whether the last points along i, j, k repeat the first, as at the cut of an O-grid.
    cuts : tuple of Cut
        Where else faces, or ranges of them, are joined, as along the wake of a C-grid.

    Raises
    ------
    InvalidInput, InvalidGeometry
        If shapes do not fit, points are not finite, or the two sides of a cut are not at the same places.

    Examples
    --------
    >>> x, y = np.meshgrid([0, 1, 3], [0, 1], indexing="ij")
    >>> StructuredGrid(np.stack([x, y], axis=-1))
    StructuredGrid(3 x 2 points)
    """

    points: np.ndarray
    point_data: dict[str, np.ndarray] = field(default_factory=dict)
    cell_data: dict[str, np.ndarray] = field(default_factory=dict)
    names: dict[str, str] = field(default_factory=dict)
    periodic: tuple[bool, bool, bool] = (False, False, False)
    cuts: tuple[Cut, ...] = ()

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        set_(self, "points", _checked_points(self.points))
        set_(self, "point_data", _checked_data(self.point_data, self.shape, "point_data"))
        set_(self, "cell_data", _checked_data(self.cell_data, self.cell_shape, "cell_data"))
        if unknown := set(self.names) - set(FACES):
            raise InvalidInput(f"{sorted(unknown)[0]!r} is no face; faces are {', '.join(FACES)}", parameter="names")
        set_(self, "cuts", checked_cuts(self.cuts, [self]))

    def __repr__(self) -> str:
        shape = self.shape[:2] if self.is_surface else self.shape
        return f"StructuredGrid({' x '.join(map(str, shape))} points)"

    @property
    def shape(self) -> tuple[int, int, int]:
        """Points along i, j, k."""
        ni, nj, nk = self.points.shape[:3]
        return ni, nj, nk

    @property
    def cell_shape(self) -> tuple[int, int, int]:
        """Cells along i, j, k; one layer for a surface."""
        ni, nj, nk = self.shape
        return ni - 1, nj - 1, max(nk - 1, 1)

    @property
    def n_points(self) -> int:
        """Number of points."""
        return int(np.prod(self.shape))

    @property
    def n_cells(self) -> int:
        """Number of cells."""
        return int(np.prod(self.cell_shape))

    @property
    def is_surface(self) -> bool:
        """Whether the grid has one layer of points, that is, quadrilateral cells."""
        return self.shape[2] == 1

    @property
    def joins(self) -> tuple[Cut, ...]:
        """All cuts: those of periodic directions, as if they were given, and `cuts`."""
        return tuple(closing(self.shape, axis) for axis in np.flatnonzero(self.periodic)) + self.cuts

    @cached_property
    def diagonal(self) -> float:
        """Length of the bounding box's diagonal."""
        return float(np.linalg.norm(extents(self.points)))

    def with_points(self, points: np.ndarray) -> StructuredGrid:
        """The same grid on moved points."""
        return replace(self, points=points)

    def with_cell_data(self, **arrays: np.ndarray) -> StructuredGrid:
        """The same grid with more cell data."""
        return replace(self, cell_data={**self.cell_data, **arrays})

    def with_point_data(self, **arrays: np.ndarray) -> StructuredGrid:
        """The same grid with more point data."""
        return replace(self, point_data={**self.point_data, **arrays})

    def reversed_along_i(self) -> StructuredGrid:
        """The same grid counted from its other end along i: imin and imax change places, left and right hand too."""
        places = {"imin": "imax", "imax": "imin"}
        return replace(
            self,
            points=self.points[::-1],
            point_data={name: values[::-1] for name, values in self.point_data.items()},
            cell_data={name: values[::-1] for name, values in self.cell_data.items()},
            names={places.get(face, face): name for face, name in self.names.items()},
            cuts=tuple(cut.counted_back(0, self.shape[0] - 1) for cut in self.cuts),
        )

    def flat(self, values: np.ndarray) -> np.ndarray:
        """(ni, nj, nk, ...) values as (ni * nj * nk, ...), i running fastest as in VTK."""
        values = np.asarray(values)
        return np.ascontiguousarray(values.swapaxes(0, 2)).reshape(-1, *values.shape[3:])

    def to_mesh(self) -> Mesh:
        """The same cells as a `Mesh` of "quad" or "hexahedron" cells; points on both sides of a cut become one."""
        number = np.arange(self.n_points).reshape(self.shape[::-1]).swapaxes(0, 2)
        if self.joins:
            number = number.ravel()[glued(self.joins, [self.shape])[0]]
        quads = [number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]]
        if self.is_surface:
            kind, corners = "quad", quads
        else:
            kind = "hexahedron"
            corners = [q[:, :, :-1] for q in quads] + [q[:, :, 1:] for q in quads]
        cells = np.column_stack([self.flat(c) for c in corners])
        return Mesh(
            self.flat(self.points),
            {kind: cells},
            point_data={name: self.flat(values) for name, values in self.point_data.items()},
            cell_data={name: self.flat(values) for name, values in self.cell_data.items()},
        ).compacted()


def _checked_points(points: Any) -> np.ndarray:
    try:
        given = np.asarray(points)
        points = np.ascontiguousarray(given, dtype=np.float64) if given.dtype.kind != "c" else None
    except (TypeError, ValueError):
        points = None
    if points is None:
        raise InvalidInput("needs real numbers, as an (ni, nj, nk, 3) array", parameter="points")
    if points.ndim == 3:
        points = points[:, :, None, :]
    if points.ndim != 4 or points.shape[3] not in (2, 3):
        raise InvalidInput(f"needs shape (ni, nj, nk, 3), got {points.shape}", parameter="points")
    if points.shape[0] < 2 or points.shape[1] < 2 or points.shape[2] < 1:
        raise InvalidInput(f"needs at least 2 x 2 points, got {points.shape[:3]}", parameter="points")
    if points.shape[3] == 2:
        points = np.concatenate([points, np.zeros((*points.shape[:3], 1))], axis=3)
    bad = np.argwhere(~np.isfinite(points).all(axis=3))
    if len(bad):
        where = np.ravel_multi_index(tuple(bad.T), points.shape[:3], order="F")
        raise InvalidGeometry(
            f"point {tuple(bad[0].tolist())} is {points[tuple(bad[0])].tolist()}", parameter="points", points=where
        )
    return np.ascontiguousarray(points)


def _checked_data(data: Mapping[str, Any], shape: tuple[int, ...], what: str) -> dict[str, np.ndarray]:
    checked = {}
    for name, values in dict(data).items():
        values = np.asarray(values)
        if values.shape[:3] != shape:
            raise InvalidInput(f"needs shape {shape}, got {values.shape}", parameter=f"{what}[{name!r}]")
        checked[name] = np.ascontiguousarray(values)
    return checked
