"""Finite volumes on curved grids, in the computational space of the grid's indices (survey 1.1 and 2.2)."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ...errors import InvalidInput
from ...mesh import MultiBlock, StructuredGrid
from .cell_metrics import CellMetrics, Faces
from .curvilinear import checked_field
from .metrics import Order, check_sign
from .swept import swept_volumes


class FiniteVolumes:
    """Finite volumes of second or fourth order on a curved grid, values being means over its cells.

    What flows out of one cell flows into the next: the sum of ``divergence * volumes`` over the cells is what flows
    through the boundary, to round-off. Area vectors close around each cell, so that a uniform flow has no divergence.
    Through cuts (``grid.cuts``, blocks) it flows as inside: faces there have one flux, seen from either side. Sides may
    be collapsed to a point, as in the middle of a polar grid.

    ::

          +----- F_j -----+
          |               |       F_i (ni, nj - 1, nk - 1): fluxes through the faces i = const, towards larger i;
         F_i     f       F_i      F_j (ni - 1, nj, nk - 1), F_k (ni - 1, nj - 1, nk) likewise
          |               |
          +----- F_j -----+       divergence = (sum of the differences of F_i, F_j, F_k) / volume

    Parameters
    ----------
    grid : StructuredGrid or MultiBlock
        In the plane, on a surface in space (fluxes then are tangential), or a volume. Of a `MultiBlock`, where methods
        take or give an array, it is a list of one for each block; of fluxes, such a list for each direction.
    order : 2 or 4
        Order of accuracy. At the second, cells have straight edges; at the fourth, edges and faces are curves and
        surfaces through the points, and there may be no cuts.

    Raises
    ------
    InvalidInput
        If a line is too short, the order unknown, or 4 on a grid with cuts.
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

    def __init__(self, grid: StructuredGrid | MultiBlock, order: Order = 2):
        self.metrics = CellMetrics(grid, order)
        if self.metrics.lines is not None and order != 2:
            raise InvalidInput(
                f"is {order}; through cuts finite volumes are of the second order: give 2, or take `Curvilinear`",
                parameter="order",
            )
        self.grid, self.order = grid, order
        check_sign(self.metrics.joined.parts(self.metrics.volumes, self.metrics.joined.cells()), "volume", "cells")

    def __repr__(self) -> str:
        return f"FiniteVolumes({self.grid!r}, order={self.order})"

    # ---- geometry

    @cached_property
    def area_vectors(self) -> Faces:
        """For each direction, (faces, 3) float: integral of the normal over each face, towards larger indices."""
        return self._given_faces(self.metrics.areas)

    @cached_property
    def volumes(self) -> np.ndarray:
        """(cells) float: volume or area of each cell; negative if left-handed."""
        return self.metrics.joined.given(self.metrics.volumes, self.metrics.joined.cells())

    @cached_property
    def boundary(self) -> Faces:
        """For each direction, (faces) bool: whether a face is one of the boundary, which no cut joins to anything."""
        return self._given_faces(self.metrics.joined.boundary())

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
        return self._given_faces(self._fluxes(self._checked(vectors, "vectors", 3)))

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
        return self._given(self.metrics.balance(self._checked_faces(fluxes, "fluxes")))

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
        fluxes = self._fluxes(self._checked(vectors, "vectors", 3))
        return self._given(self.metrics.balance(fluxes) / self.metrics.volumes)

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
        cells, values = self.metrics, self._in_indices(self._checked(values, "values"))
        fluxes = [
            cells.mean_product(cells.at_faces(values, i)[..., None], area, i) for i, area in enumerate(cells.areas)
        ]
        total = cells.balance(fluxes)
        if cells.is_curved:  # area vectors do not close: the normal times the curvature is left over
            total -= cells.mean_product(values[..., None], cells.balance(cells.areas))
        return self._given(total / cells.volumes[..., None])

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
        fluxes = self._diffusive_fluxes(self._checked(values, "values"))
        return self._given(self.metrics.balance(fluxes) / self.metrics.volumes)

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
        return self._given_faces(self._diffusive_fluxes(self._checked(values, "values")))

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
        cells = self.metrics
        density = self._checked(density, "density")
        velocity = self._checked(velocity, "velocity", 3)
        source = self._checked(source, "source")
        carried, density = self._fluxes(velocity), self._in_indices(density)
        if swept is not None:
            moved = self._checked_faces(swept, "swept")
            carried = tuple(volume - gone for volume, gone in zip(carried, moved, strict=True))
        fluxes = [cells.mean_product(cells.at_faces(density, i), volume, i) for i, volume in enumerate(carried)]
        return self._given(source * cells.volumes - cells.balance(cells.joined.shared(fluxes)))

    def swept(self, moved: StructuredGrid | MultiBlock) -> Faces:
        """Volume that each face sweeps while the points move, each on a straight line, to another grid.

        The geometric conservation law holds for it: ``balance(swept)`` is what each cell grows by, to round-off.

        Parameters
        ----------
        moved : StructuredGrid or MultiBlock
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
        cells, blocks = self.metrics, moved.blocks if isinstance(moved, MultiBlock) else (moved,)
        shapes, own = [block.shape for block in blocks], [block.shape for block in cells.blocks]
        if shapes != own:
            raise InvalidInput(f"has shape {shapes}, not {own}", parameter="moved")
        shifts = [after.points - before.points for after, before in zip(blocks, cells.blocks, strict=True)]
        normal = cells.normal if cells.dimension == 2 else None
        if normal is not None and (
            cells.is_curved or max(np.abs(shift @ normal).max() for shift in shifts) > 1e-9 * cells.extent
        ):
            raise InvalidInput("moves a surface out of a plane; move within it, or a volume", parameter="moved")
        before = cells.joined.parts(cells.position, cells.joined.half())
        found = [swept_volumes(at, at + shift, normal) for at, shift in zip(before, shifts, strict=True)]
        return tuple(list(part) if cells.joined.several else part[0] for part in zip(*found, strict=True))

    # ---- inside

    def _fluxes(self, vectors: np.ndarray) -> Faces:
        cells, vectors = self.metrics, self._in_indices(vectors)
        fluxes = [cells.mean_dot(cells.at_faces(vectors, i), area, i) for i, area in enumerate(cells.areas)]
        return cells.joined.shared(fluxes)

    def _diffusive_fluxes(self, values: np.ndarray) -> Faces:
        cells, values = self.metrics, self._in_indices(values)
        directions, stencils = range(cells.dimension), cells.stencils
        at_faces = [cells.at_faces(values, i) for i in directions]
        fluxes = []
        for i in directions:
            slopes = [
                cells.along(stencils.face_derivative, values, i, "cells")
                if i == j
                else cells.along_of(stencils.derivative, at_faces, j, i, "faces", odd=False)
                for j in directions
            ]
            terms = zip(cells.conductances[i], slopes, strict=True)
            fluxes.append(sum(cells.mean_product(conductance, slope, i) for conductance, slope in terms))
        return cells.joined.shared(fluxes)

    def _in_indices(self, values: np.ndarray) -> np.ndarray:
        """Means over the cells of computational space, of means over those in space, which weigh by the Jacobian."""
        if self.order == 2:
            return values
        volumes = self.metrics.volumes.reshape(self.metrics.volumes.shape + (1,) * (values.ndim - 3))
        return values - (self.metrics.mean_product(volumes, values) / volumes - values)

    def _given(self, values: np.ndarray) -> np.ndarray:
        """Values of cells as the user has them."""
        return self.metrics.joined.given(values, self.metrics.joined.cells())

    def _given_faces(self, fluxes: Faces) -> Faces:
        joined = self.metrics.joined
        return tuple(joined.given(flux, joined.faces(i)) for i, flux in enumerate(fluxes))

    def _checked(self, values: np.ndarray, name: str, components: int = 0) -> np.ndarray:
        """The user's values of cells in one array."""
        tail = (components,) if components else ()
        joined = self.metrics.joined
        return joined.taken(values, joined.cells(), name, lambda v, shape, of: checked_field(v, shape + tail, of))

    def _checked_faces(self, fluxes: Faces, name: str) -> Faces:
        joined = self.metrics.joined

        def checked(values: np.ndarray, shape: tuple[int, ...], of: str) -> np.ndarray:
            return checked_field(values, shape + np.shape(values)[3:], of)

        return tuple(joined.taken(flux, joined.faces(i), f"{name}[{i}]", checked) for i, flux in enumerate(fluxes))
