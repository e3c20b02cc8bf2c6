"""Metrics of curved grids: base vectors, Jacobian and area vectors, by differences of the points (survey 2.2)."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property, partial
from typing import Literal

import numpy as np

from ...errors import InvalidGeometry, InvalidInput
from ...mesh import MultiBlock, StructuredGrid
from ...mesh.cuts import free_sides
from ...quality.vectors import cross, dot
from .joined_lines import JoinedLines, Where
from .stencils import STENCILS, Stencil

Order = Literal[2, 4]


class Metrics:
    """The mapping from the indices of a grid to its points, differentiated in second or fourth order.

    Parameters
    ----------
    grid : StructuredGrid or MultiBlock
        In the plane, on a surface in space, or a volume; with cuts, across which lines run on.
    order : 2 or 4
        Order of accuracy. A line that is not closed needs 5 points for the second, 7 for the fourth.

    Attributes
    ----------
    dimension : int
        2, or 3 for a volume.
    periods : tuple of three int
        Cells along closed directions, 0 for open ones.
    shape : tuple of three int
        That of arrays of values at points: the grid's, or (points, 1, 1) of several blocks, one after the other.
    position : (ni, nj, nk, 3) float
        The points relative to their mean, so that products of them round less.

    Raises
    ------
    InvalidInput
        If a line is too short or the order unknown.
    InvalidGeometry
        If a periodic direction is not closed; when it is used, if the Jacobian vanishes or changes its sign (`points`
        tells where).

    Examples
    --------
    >>> x, y = np.meshgrid(np.arange(5.0), 2 * np.arange(5.0), indexing="ij")
    >>> metrics = Metrics(StructuredGrid(np.stack([x, y], axis=-1)))
    >>> float(metrics.jacobian[0, 0, 0].round(12)), metrics.contravariant[1, 0, 0, 0].round(12).tolist()
    (2.0, [0.0, 0.5, 0.0])
    """

    def __init__(self, grid: StructuredGrid | MultiBlock, order: Order = 2):
        if not isinstance(grid, (StructuredGrid, MultiBlock)):
            raise InvalidInput(f"needs a StructuredGrid or a MultiBlock, got {type(grid).__name__}", parameter="grid")
        if order not in STENCILS:
            raise InvalidInput(f"is {order!r}; the operators are of order 2 or 4", parameter="order")
        self.grid, self.order = grid, order
        self.blocks = grid.blocks if isinstance(grid, MultiBlock) else (grid,)
        if len({block.is_surface for block in self.blocks}) > 1:
            raise InvalidInput("has surfaces and volumes; give the ones or the others", parameter="grid")
        self.dimension = 2 if self.blocks[0].is_surface else 3
        self.stencils = STENCILS[order]
        self.periods = (0, 0, 0)
        self.lines: JoinedLines | None = None
        if isinstance(grid, MultiBlock) or grid.cuts:
            self.lines = _joined_lines(grid, order, self.blocks)
            points = np.concatenate([block.points.reshape(-1, 1, 1, 3) for block in self.blocks])
        else:
            self.periods = tuple(
                cells if closed else 0 for cells, closed in zip(grid.cell_shape, grid.periodic, strict=True)
            )
            _check_lines(grid, order, self.periods)
            points = grid.points
        self.shape = points.shape[:3]
        self.position = points - points.reshape(-1, 3).mean(axis=0)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.grid!r}, order={self.order})"

    def along(self, stencil: Stencil, values: np.ndarray, axis: int, where: Where = "points") -> np.ndarray:
        """A stencil's result along one direction, across the cut of a closed one and through cuts."""
        if self.lines is None:
            return stencil.along(values, axis, self.periods[axis])
        return self._times(self.lines.matrix(stencil, axis, where), values)

    def along_of(
        self, stencil: Stencil, values: list[np.ndarray], axis: int, component: int, where: Where, odd: bool = True
    ) -> np.ndarray:
        """The same for values that belong to a direction, given for all: beyond a cut they are those of another one."""
        if self.lines is None:
            return stencil.along(values[component], axis, self.periods[axis])
        return self._times(self.lines.matrix(stencil, axis, where, component, odd), np.concatenate(values))

    def _times(self, matrix, values: np.ndarray) -> np.ndarray:
        return (matrix @ values.reshape(len(values), -1)).reshape(-1, 1, 1, *values.shape[3:])

    def _parts(self, values: np.ndarray) -> list[np.ndarray]:
        """Values at points, an array of its own shape for each block."""
        ends = np.cumsum([block.n_points for block in self.blocks])[:-1]
        parts = [values] if self.lines is None else np.split(values, ends)
        return [part.reshape(block.shape) for part, block in zip(parts, self.blocks, strict=True)]

    def others(self, i: int | None) -> list[int]:
        """The directions but one."""
        return [j for j in range(self.dimension) if j != i]

    @property
    def is_curved(self) -> bool:
        """Whether the grid is a surface that does not lie in a plane."""
        return self.dimension == 2 and self.normal.ndim > 1

    def derivative(self, values: np.ndarray, axis: int) -> np.ndarray:
        """Derivative along the lines of one direction, in index units.

        Parameters
        ----------
        values : (ni, nj, nk, ...) float
            At the points.
        axis : int
            0, 1, 2 for i, j, k.

        Returns
        -------
        (ni, nj, nk, ...) float
        """
        return self.along(self.stencils.derivative, values, axis)

    @cached_property
    def covariant(self) -> np.ndarray:
        """(d, ni, nj, nk, 3) float: the base vectors a_i along the lines; d is 2, or 3 for a volume."""
        return np.stack([self.derivative(self.position, i) for i in range(self.dimension)])

    @cached_property
    def jacobian(self) -> np.ndarray:
        """(ni, nj, nk) float: volume, or area, of the parallelepiped of the base vectors; negative if left-handed.

        The side of a planar grid is that of the plane's z axis; on a curved surface it is positive.
        """
        base = self.covariant
        jacobian = dot(base[0], cross(base[1], base[2])) if self.dimension == 3 else dot(cross(*base), self.normal)
        check_sign(self._parts(jacobian), "Jacobian", "points")
        return jacobian

    @cached_property
    def normal(self) -> np.ndarray:
        """(3,) float: unit normal of a plane; (ni, nj, 1, 3) float: those of a curved surface at its points."""
        area = cross(*self.covariant)
        whole = area.sum(axis=(0, 1, 2))
        unit = whole / max(float(np.linalg.norm(whole)), np.finfo(float).tiny)
        if np.abs(self.position @ unit).max() <= 1e-9 * max(block.diagonal for block in self.blocks):
            return unit if abs(unit[2]) < 1 else np.array([0.0, 0.0, 1.0])
        size = np.sqrt(dot(area, area))
        return area / np.where(size > 0, size, 1.0)[..., None]

    @cached_property
    def contravariant(self) -> np.ndarray:
        """(d, ni, nj, nk, 3) float: the vectors a^i with a^i . a_j = 1 if i = j, else 0: the gradients of indices."""
        return self._normals_of_faces(self.covariant) / self.jacobian[..., None]

    @cached_property
    def metric(self) -> np.ndarray:
        """(d, d, ni, nj, nk) float: the metric g_ij = a_i . a_j."""
        return _products(self.covariant)

    @cached_property
    def inverse_metric(self) -> np.ndarray:
        """(d, d, ni, nj, nk) float: the metric g^ij = a^i . a^j, the inverse of g_ij."""
        return _products(self.contravariant)

    @cached_property
    def area_vectors(self) -> np.ndarray:
        """(d, ni, nj, nk, 3) float: J a^i in a form that conserves: their differences d(J a^i)/di sum to round-off.

        In a plane that is J times `contravariant`. In a volume, where products of differences do not commute with
        differences, they are differences themselves (Thomas and Lombard, in the symmetric form of Vinokur and Yee):
        J a^1 = (d(r x dr/dk)/dj - d(r x dr/dj)/dk) / 2, and so on.
        """
        if self.dimension == 2:
            return self._normals_of_faces(self.covariant)
        products = [cross(self.position, base) for base in self.covariant]
        along = partial(self.along_of, self.stencils.derivative, products, where="points")
        return 0.5 * np.stack(
            [along(axis=j, component=k) - along(axis=k, component=j) for j, k in ((1, 2), (2, 0), (0, 1))]
        )

    def conductance(self, i: int, j: int) -> np.ndarray:
        """(ni, nj, nk) float: J g^ij, the flux across i that a unit slope along j drives; 0 if i, j are orthogonal."""
        return self.jacobian * self.inverse_metric[i, j]

    def _normals_of_faces(self, base: np.ndarray) -> np.ndarray:
        """(d, ...) vectors J a^i, as products of the base vectors."""
        if self.dimension == 3:
            return np.stack([cross(base[1], base[2]), cross(base[2], base[0]), cross(base[0], base[1])])
        return np.stack([cross(base[1], self.normal), cross(self.normal, base[0])])


def _products(vectors: np.ndarray) -> np.ndarray:
    """(d, d, ...) float: scalar products of (d, ..., 3) vectors."""
    return np.stack([np.stack([dot(u, v) for v in vectors]) for u in vectors])


def _check_lines(grid: StructuredGrid, order: int, periods: tuple[int, ...], ends: Sequence[int] = (0, 1, 2)) -> None:
    """Raise if a line that ends here, along one of the axes `ends`, has too few points, or a closed one is open."""
    needed = STENCILS[order].derivative.needed + 1  # of cells, too, as many as ghosts are made of
    for axis, (n, period) in enumerate(zip(grid.shape, periods, strict=True)):
        if axis == 2 and grid.is_surface:
            continue
        name = "ijk"[axis]
        if axis in ends and not period and n < needed:
            raise InvalidInput(
                f"has {n} points along {name}; order {order} needs {needed}, or a periodic direction", parameter="grid"
            )
        lines = np.moveaxis(grid.points, axis, 0)
        if period and np.abs(lines[-1] - lines[0]).max() > 1e-9 * grid.diagonal:
            raise InvalidGeometry(
                f"is periodic along {name}, but its last points are not where its first are; close it",
                parameter="grid",
            )


def _joined_lines(grid: StructuredGrid | MultiBlock, order: int, blocks: tuple[StructuredGrid, ...]) -> JoinedLines:
    if any(cut.moves for cut in grid.joins):
        raise InvalidInput("has sides that are moved into each other; the operators take none", parameter="grid")
    shapes = [block.shape for block in blocks]
    ends = {(block, axis) for block, axis, _, free in free_sides(shapes, grid.joins) if free.any()}
    for number, block in enumerate(blocks):
        _check_lines(block, order, (0, 0, 0), [axis for axis in range(3) if (number, axis) in ends])
    return JoinedLines(shapes, grid.joins)


def check_sign(values: list[np.ndarray], name: str, of: Literal["points", "cells"]) -> None:
    """Raise `InvalidGeometry`, with the places, if Jacobians or volumes of blocks vanish or differ in sign.

    Examples
    --------
    >>> check_sign([np.array([[[-1.0], [-2.0]]])], "volume", "cells")
    """
    sign = [np.sign(part) for part in values]
    whole = np.sign(sum(part.sum() for part in sign)) or 1.0
    bad = [np.argwhere(part != whole) for part in sign]
    count = sum(map(len, bad))
    if not count:
        return
    starts = np.cumsum([0, *(part.size for part in sign)])
    numbers = [
        start + np.ravel_multi_index(tuple(places.T), part.shape, order="F")
        for start, places, part in zip(starts, bad, sign, strict=False)
    ]
    first = next(k for k, places in enumerate(bad) if len(places))
    block = f" of block {first}" if len(values) > 1 else ""
    raise InvalidGeometry(
        f"has a {name} that is zero or of the other sign at {count} of {starts[-1]} {of}, the first at "
        f"{tuple(bad[first][0].tolist())}{block}; give a grid that does not fold or collapse there",
        parameter="grid",
        **{of: np.concatenate(numbers)},
    )
