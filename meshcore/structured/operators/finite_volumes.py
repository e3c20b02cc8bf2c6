"""Finite volumes on curved grids, in the computational space of the grid's indices (survey 1.1 and 2.2)."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ...errors import InvalidInput
from ...mesh import StructuredGrid
from ...quality.vectors import cross
from .curvilinear import checked_field
from .metrics import Metrics, Order, check_sign
from .stencils import DIFFERENCE, SLOPE
from .swept import swept_volumes

Faces = tuple[np.ndarray, ...]


class FiniteVolumes:
    """Finite volumes of second or fourth order on a curved grid, values being means over its cells.

    What flows out of one cell flows into the next: the sum of ``divergence * volumes`` over the cells is what flows
    through the boundary, to round-off. Area vectors close around each cell, so that a uniform flow has no divergence.

    ::

          +----- F_j -----+
          |               |       F_i (ni, nj - 1, nk - 1): fluxes through the faces i = const, towards larger i;
         F_i     f       F_i      F_j (ni - 1, nj, nk - 1), F_k (ni - 1, nj - 1, nk) likewise
          |               |
          +----- F_j -----+       divergence = (sum of the differences of F_i, F_j, F_k) / volume

    Parameters
    ----------
    grid : StructuredGrid
        In the plane, on a surface in space (fluxes then are tangential), or a volume.
    order : 2 or 4
        Order of accuracy. At the second, cells have straight edges; at the fourth, edges and faces are curves and
        surfaces through the points.

    Raises
    ------
    InvalidInput
        If a line is too short or the order unknown.
    InvalidGeometry
        If a cell has no volume or is turned over (`cells` tells which), or a periodic direction is not closed.

    References
    ----------
    Survey, sections 1.1 and 2.2. P. Colella, M. R. Dorr, J. A. F. Hittinger, D. F. Martin, "High-order, finite-volume
    methods in mapped coordinates", J. Comput. Phys. 230 (2011).

    Examples
    --------
    >>> from meshcore import gallery, o_grid
    >>> grid, _ = o_grid(gallery.circle(48), radius=2, layers=12)
    >>> volumes = FiniteVolumes(grid)
    >>> uniform = np.broadcast_to([1.0, 2.0, 0.0], (48, 12, 1, 3))
    >>> bool(np.abs(volumes.divergence(uniform)).max() < 1e-12)
    True
    """

    def __init__(self, grid: StructuredGrid, order: Order = 2):
        self.metrics = Metrics(grid, order)
        if self.metrics.lines is not None:
            raise InvalidInput(
                "has cuts, through which finite volumes do not run; take `Curvilinear`, whose lines do, or "
                "`dataclasses.replace(grid, cuts=())`, whose cuts are boundaries",
                parameter="grid",
            )
        self.grid, self.order = grid, order
        check_sign(self.volumes, "volume", "cells")

    def __repr__(self) -> str:
        return f"FiniteVolumes({self.grid!r}, order={self.order})"

    # ---- geometry

    @cached_property
    def area_vectors(self) -> Faces:
        """For each direction, (faces, 3) float: integral of the normal over each face, towards larger indices."""
        if self.metrics.dimension == 2:
            return self._edges_of_surface()
        # Stokes' theorem: half the integral of r x dr around the face, from integrals along edges that faces share.
        along = [self._edge_integrals(axis) for axis in range(3)]
        return tuple(
            self.metrics.along(DIFFERENCE, along[k], j) - self.metrics.along(DIFFERENCE, along[j], k)
            for j, k in ((1, 2), (2, 0), (0, 1))
        )

    @cached_property
    def volumes(self) -> np.ndarray:
        """(cells) float: volume or area of each cell; negative if left-handed."""
        if self.metrics.is_curved:  # there is no divergence theorem for the position
            return self._mean(self.metrics.jacobian)
        position = self.metrics.position
        fluxes = [
            self._mean_dot(self._mean(position, i), area, i) / self.metrics.dimension
            for i, area in enumerate(self.area_vectors)
        ]
        return self.balance(fluxes)

    # ---- operators

    def fluxes(self, vectors: np.ndarray) -> Faces:
        """Fluxes of a vector field through the faces.

        Parameters
        ----------
        vectors : (ni-1, nj-1, max(nk-1, 1), 3) float
            Means over the cells.

        Returns
        -------
        tuple of float arrays
            For each direction, of the shape of its faces. Those of the boundary, extrapolated from inside, may be
            overwritten by boundary conditions before `balance` sums them.
        """
        vectors = self._in_indices(self._checked(vectors, "vectors", 3))
        return tuple(
            self._mean_dot(self.metrics.along(self.metrics.stencils.face, vectors, i), area, i)
            for i, area in enumerate(self.area_vectors)
        )

    def balance(self, fluxes: Faces) -> np.ndarray:
        """What flows out of each cell, of fluxes through its faces.

        Parameters
        ----------
        fluxes : sequence of float arrays
            As `fluxes` returns them.

        Returns
        -------
        (ni-1, nj-1, max(nk-1, 1)) float
        """
        return sum(self.metrics.along(DIFFERENCE, flux, i) for i, flux in enumerate(fluxes))

    def divergence(self, vectors: np.ndarray) -> np.ndarray:
        """Mean divergence over each cell.

        Parameters
        ----------
        vectors : (ni-1, nj-1, max(nk-1, 1), 3) float
            Means over the cells.

        Returns
        -------
        (ni-1, nj-1, max(nk-1, 1)) float
        """
        return self.balance(self.fluxes(vectors)) / self.volumes

    def gradient(self, values: np.ndarray) -> np.ndarray:
        """Mean gradient over each cell, by Gauss' theorem.

        Parameters
        ----------
        values : (ni-1, nj-1, max(nk-1, 1)) float
            Means over the cells.

        Returns
        -------
        (ni-1, nj-1, max(nk-1, 1), 3) float
        """
        values = self._in_indices(self._checked(values, "values"))
        fluxes = [
            self._mean_product(self.metrics.along(self.metrics.stencils.face, values, i)[..., None], area, i)
            for i, area in enumerate(self.area_vectors)
        ]
        total = self.balance(fluxes)
        if self.metrics.is_curved:  # area vectors do not close: the normal times the curvature is left over
            total -= self._mean_product(values[..., None], self.balance(self.area_vectors))
        return total / self.volumes[..., None]

    def laplacian(self, values: np.ndarray) -> np.ndarray:
        """Mean Laplacian over each cell: the balance of the gradient's fluxes through its faces.

        Parameters
        ----------
        values : (ni-1, nj-1, max(nk-1, 1)) float
            Means over the cells.

        Returns
        -------
        (ni-1, nj-1, max(nk-1, 1)) float
        """
        return self.balance(self.diffusive_fluxes(values)) / self.volumes

    def diffusive_fluxes(self, values: np.ndarray) -> Faces:
        """Fluxes of the gradient of a scalar through the faces.

        Parameters
        ----------
        values : (ni-1, nj-1, max(nk-1, 1)) float
            Means over the cells.

        Returns
        -------
        tuple of float arrays
            As those of `fluxes`.
        """
        values = self._in_indices(self._checked(values, "values"))
        found = []
        for i in range(self.metrics.dimension):
            at_face = self.metrics.along(self.metrics.stencils.face, values, i)
            flux = 0.0
            for j in range(self.metrics.dimension):
                slope = (
                    self.metrics.along(self.metrics.stencils.face_derivative, values, i)
                    if i == j
                    else self.metrics.along(self.metrics.stencils.derivative, at_face, j)
                )
                flux = flux + self._mean_product(self._mean(self.metrics.conductance(i, j), i), slope, i)
            found.append(flux)
        return tuple(found)

    def convection(
        self,
        density: np.ndarray,
        velocity: np.ndarray,
        *,
        source: float | np.ndarray = 0.0,
        swept: Faces | None = None,
    ) -> np.ndarray:
        """Rate of what the cells hold, of d(rho)/dt + div(rho U) = S integrated over each cell.

        That is d(V rho)/dt = S V - sum of rho (U . A - swept). A step of time is
        ``(density * volumes + dt * rate) / new_volumes``; a uniform density in a uniform velocity stays as it is.

        Parameters
        ----------
        density : (ni-1, nj-1, max(nk-1, 1)) float
            Mean of rho over each cell.
        velocity : (ni-1, nj-1, max(nk-1, 1), 3) float
            Mean of U over each cell.
        source : float or (ni-1, nj-1, max(nk-1, 1)) float
            Mean of S over each cell.
        swept : tuple of float arrays, optional
            Volume that each face sweeps in a unit of time, on a moving grid: `swept` over the step.

        Returns
        -------
        (ni-1, nj-1, max(nk-1, 1)) float
        """
        density = self._checked(density, "density")
        velocity = self._checked(velocity, "velocity", 3)
        source = self._checked(source, "source")
        carried, density = self.fluxes(velocity), self._in_indices(density)
        if swept is not None:
            carried = tuple(volume - moved for volume, moved in zip(carried, swept, strict=True))
        fluxes = tuple(
            self._mean_product(self.metrics.along(self.metrics.stencils.face, density, i), volume, i)
            for i, volume in enumerate(carried)
        )
        return source * self.volumes - self.balance(fluxes)

    def swept(self, moved: StructuredGrid) -> Faces:
        """Volume that each face sweeps while the points move, each on a straight line, to another grid.

        The geometric conservation law holds for it: ``balance(swept)`` is what each cell grows by, to round-off.

        Parameters
        ----------
        moved : StructuredGrid
            Of the same shape.

        Returns
        -------
        tuple of float arrays
            For each direction, of the shape of its faces, towards larger indices.

        Raises
        ------
        InvalidInput
            If the shapes differ, the order is not 2, or the grid is a curved surface or leaves its plane.
        """
        if self.order != 2:
            raise InvalidInput(f"is {self.order}; moving cells have straight edges: give order=2", parameter="order")
        if moved.shape != self.grid.shape:
            raise InvalidInput(f"has shape {moved.shape}, not {self.grid.shape}", parameter="moved")
        if self.metrics.dimension == 2:
            shift = moved.points - self.grid.points
            if self.metrics.is_curved or np.abs(shift @ self.metrics.normal).max() > 1e-9 * self.grid.diagonal:
                raise InvalidInput("moves a surface out of a plane; move within it, or a volume", parameter="moved")
        position = self.metrics.position
        normal = self.metrics.normal if self.metrics.dimension == 2 else None
        return swept_volumes(position, position + (moved.points - self.grid.points), normal)

    # ---- inside

    def _mean(self, values: np.ndarray, across: int | None = None) -> np.ndarray:
        """Means, of values at points, over the faces across one direction, or over the cells."""
        for axis in self.metrics.others(across):
            values = self.metrics.along(self.metrics.stencils.mean, values, axis)
        return values

    def _edges_of_surface(self) -> Faces:
        """Area vectors of the edges of a surface's cells, which lie in the surface."""
        if self.metrics.is_curved:
            return tuple(self._mean(area, i) for i, area in enumerate(self.metrics.area_vectors))
        position, normal = self.metrics.position, self.metrics.normal
        along_i, along_j = (self.metrics.along(DIFFERENCE, position, axis) for axis in (0, 1))
        return cross(along_j, normal), cross(normal, along_i)

    def _edge_integrals(self, axis: int) -> np.ndarray:
        """Half the integral of r x dr along each edge of one direction."""
        position = self.metrics.position
        step = self.metrics.along(DIFFERENCE, position, axis)
        integral = cross(self.metrics.along(self.metrics.stencils.mean, position, axis), step)
        if self.order == 4:
            integral += cross(step, self.metrics.along(DIFFERENCE, self.metrics.covariant[axis], axis)) / 12
        return 0.5 * integral

    def _mean_product(self, a: np.ndarray, b: np.ndarray, across: int | None = None) -> np.ndarray:
        """Mean of a product over faces, or cells, of the means of its factors (Colella and others)."""
        product = a * b
        if self.order == 4:
            for axis in self.metrics.others(across):
                product += self.metrics.along(SLOPE, a, axis) * self.metrics.along(SLOPE, b, axis) / 12
        return product

    def _mean_dot(self, a: np.ndarray, b: np.ndarray, across: int) -> np.ndarray:
        return self._mean_product(a, b, across).sum(axis=-1)

    def _in_indices(self, values: np.ndarray) -> np.ndarray:
        """Means over the cells of computational space, of means over those in space, which weigh by the Jacobian."""
        if self.order == 2:
            return values
        volumes = self.volumes.reshape(self.volumes.shape + (1,) * (values.ndim - 3))
        return values - (self._mean_product(volumes, values) / volumes - values)

    def _checked(self, values: np.ndarray, name: str, components: int = 0) -> np.ndarray:
        shape = (*self.grid.cell_shape, components) if components else self.grid.cell_shape
        return checked_field(values, shape, name)
