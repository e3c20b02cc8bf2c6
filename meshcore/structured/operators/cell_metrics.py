"""Areas, volumes and means of the cells of curved grids: what finite volumes are made of (survey 1.1 and 2.2)."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ...mesh import MultiBlock, StructuredGrid
from ...quality.vectors import cross, dot
from .joined_faces import JoinedFaces
from .metrics import Metrics, Order
from .stencils import DIFFERENCE, SLOPE, Stencil

Faces = tuple[np.ndarray, ...]

_NO_FACE = 1e-12
"""Of the grid's extent: a face that is smaller is a degenerate point, through which nothing flows."""


class CellMetrics(Metrics):
    """The mapping from the indices of a grid to its points, integrated over its cells and their faces.

    Arrays of cells and faces are those of the grid; of blocks, and of a grid with cuts, they are as `JoinedFaces` has
    them.

    Parameters
    ----------
    grid : StructuredGrid or MultiBlock
        In the plane, on a surface in space, or a volume; with cuts, across which lines run on.
    order : 2 or 4
        Order of accuracy, 2 with cuts.
    """

    def __init__(self, grid: StructuredGrid | MultiBlock, order: Order = 2):
        super().__init__(grid, order)
        self.joined = JoinedFaces(grid, self.lines is not None)

    @cached_property
    def areas(self) -> Faces:
        """For each direction, integral of the normal over each face, towards larger indices."""
        if self.dimension == 2:
            return self._edges_of_surface()
        # Stokes' theorem: half the integral of r x dr around the face, from integrals along edges that faces share.
        along = [self._edge_integrals(axis) for axis in range(3)]
        return tuple(
            self.plain(DIFFERENCE, along[k], j, k) - self.plain(DIFFERENCE, along[j], k, j)
            for j, k in ((1, 2), (2, 0), (0, 1))
        )

    @cached_property
    def volumes(self) -> np.ndarray:
        """Volume or area of each cell; negative if left-handed."""
        if self.is_curved:  # there is no divergence theorem for the position
            return self.mean(self.jacobian)
        position = self.position
        return self.balance(
            [self.mean_dot(self.mean(position, i), area, i) / self.dimension for i, area in enumerate(self.areas)]
        )

    @cached_property
    def extent(self) -> float:
        """Diagonal of the largest block."""
        return max(block.diagonal for block in self.blocks)

    def balance(self, fluxes: Faces) -> np.ndarray:
        """What flows out of each cell."""
        return sum(
            self.plain(DIFFERENCE, flux, i, *np.flatnonzero(self.joined.faces(i))) for i, flux in enumerate(fluxes)
        )

    @cached_property
    def conductances(self) -> list[list[np.ndarray]]:
        """For each direction i and each j, mean over the faces i = const of J g^ij."""
        directions = range(self.dimension)
        if self.order == 4:
            return [[self.mean(self.conductance(i, j), i) for j in directions] for i in directions]
        return [self._conductances_of_middles(i) for i in directions]

    def _conductances_of_middles(self, i: int) -> list[np.ndarray]:
        """Those of base vectors in the faces' middles, so that degenerate points at a face's corners do no harm."""
        directions = range(self.dimension)
        base = [
            self.mean(self.covariant[i], i) if j == i else self.mean(self.plain(DIFFERENCE, self.position, j), i, j)
            for j in directions
        ]
        if self.dimension == 2:
            square = [[dot(a, b) for b in base] for a in base]
            size = np.sqrt(np.maximum(square[0][0] * square[1][1] - square[0][1] ** 2, 0))
            product = {i: square[1 - i][1 - i], 1 - i: -square[0][1]}
        else:
            normals = [cross(base[j - 2], base[j - 1]) for j in directions]
            size = np.abs(dot(base[0], normals[0]))
            product = {j: dot(normals[i], normals[j]) for j in directions}
        is_face = (product[i] > (_NO_FACE * self.extent) ** (2 * self.dimension - 2)) & (size > 0)
        size = np.where(is_face, size, 1.0) * np.sign(self.volumes.flat[0])
        return [np.where(is_face, product[j] / size, 0.0) for j in directions]

    def at_faces(self, values: np.ndarray, i: int) -> np.ndarray:
        """Values on the faces of one direction, of those of cells."""
        return self.along(self.stencils.face, values, i, "cells")

    def plain(self, stencil: Stencil, values: np.ndarray, axis: int, *half: int) -> np.ndarray:
        """A stencil that takes no values from beyond cuts; values stand between points along the axes ``half``."""
        if self.lines is None:
            return self.along(stencil, values, axis)
        return self.joined.within(stencil, values, axis, self.joined.half(*half))

    def mean(self, values: np.ndarray, across: int | None = None, *half: int) -> np.ndarray:
        """Means over the faces across one direction, or the cells, of values at points, or between along ``half``."""
        for axis in self.others(across):
            if axis not in half:
                values = self.plain(self.stencils.mean, values, axis, *half)
                half = (*half, axis)
        return values

    def _edges_of_surface(self) -> Faces:
        """Area vectors of the edges of a surface's cells, which lie in the surface."""
        if self.is_curved:
            return tuple(self.mean(area, i) for i, area in enumerate(self.area_vectors))
        position, normal = self.position, self.normal
        along_i, along_j = (self.plain(DIFFERENCE, position, axis) for axis in (0, 1))
        return cross(along_j, normal), cross(normal, along_i)

    def _edge_integrals(self, axis: int) -> np.ndarray:
        """Half the integral of r x dr along each edge of one direction."""
        position = self.position
        step = self.plain(DIFFERENCE, position, axis)
        integral = cross(self.plain(self.stencils.mean, position, axis), step)
        if self.order == 4:
            integral += cross(step, self.along(DIFFERENCE, self.covariant[axis], axis)) / 12
        return 0.5 * integral

    def mean_product(self, a: np.ndarray, b: np.ndarray, across: int | None = None) -> np.ndarray:
        """Mean of a product over faces, or cells, of the means of its factors (Colella and others)."""
        product = a * b
        if self.order == 4:
            for axis in self.others(across):
                product += self.along(SLOPE, a, axis) * self.along(SLOPE, b, axis) / 12
        return product

    def mean_dot(self, a: np.ndarray, b: np.ndarray, across: int) -> np.ndarray:
        """Mean of a scalar product over faces, of the means of its factors."""
        return self.mean_product(a, b, across).sum(axis=-1)
