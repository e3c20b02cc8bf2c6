"""Differential operators on curved grids, in the computational space of the grid's indices (survey 1.1 and 2.2)."""

from __future__ import annotations

from functools import cached_property

import numpy as np
import scipy.sparse
import scipy.sparse.linalg

from ...errors import InvalidInput
from ...mesh import MultiBlock, StructuredGrid
from ...mesh.cuts import glued
from ...quality.vectors import dot
from .joined_lines import Where, on_boundary
from .metrics import Metrics, Order
from .stencils import Stencil


class Curvilinear(Metrics):
    """Finite differences of second or fourth order on a curved grid, values standing at its points.

    The equations are transformed to the indices (i, j, k) of the grid, where points stand at distance 1, and
    differenced there: the grid's curvature, stretching and skewness do not lower the order. Ends of lines are treated
    one-sidedly, in the same order; closed lines (``grid.periodic``) are differenced across their cut.
    Through other cuts (``grid.cuts``, blocks) lines run on likewise, in whatever orientation: on a cut the formula is
    that of the interior.

    ::

             a_2  ^     / a^2                 a_i: along the lines;  a^i: normal to the faces i = const
                  |    /                      a_i . a^j = 1 if i = j, else 0
                  |   /
                  |  /                        gradient    a^i df/di
                  | /                         divergence  1/J d(J a^i . v)/di
                  +----------> a_1            Laplacian   1/J d(J g^ij df/dj)/di
                   \\ a^1

    Parameters
    ----------
    grid : StructuredGrid or MultiBlock
        In the plane, on a surface in space, or a volume. On a surface gradients lie in the surface, divergences are
        those of tangential vectors, and the Laplacian is Beltrami's. Of a `MultiBlock`, where methods take or give an
        array, it is a list of one for each block.
    order : 2 or 4
        Order of accuracy. A line that is not closed needs 5 points for the second, 7 for the fourth.

    Raises
    ------
    InvalidInput
        If a line is too short or the order unknown.
    InvalidGeometry
        If the Jacobian vanishes or changes its sign (`points` tells where), or a periodic direction is not closed.

    References
    ----------
    Survey, sections 1.1 and 2.2. P. D. Thomas and C. K. Lombard, "Geometric conservation law and its application to
    flow computations on moving grids", AIAA J. 17 (1979). M. R. Visbal and D. V. Gaitonde, "On the use of
    higher-order finite-difference schemes on curvilinear and deforming meshes", J. Comput. Phys. 181 (2002).

    Examples
    --------
    >>> from meshcore import gallery, o_grid
    >>> grid, _ = o_grid(gallery.circle(48), radius=2, layers=12)
    >>> operators = Curvilinear(grid, order=4)
    >>> x, y, _ = np.moveaxis(grid.points, -1, 0)
    >>> operators.gradient(2 * x - y)[5, 5, 0].round(12).tolist()
    [2.0, -1.0, 0.0]
    """

    def __init__(self, grid: StructuredGrid | MultiBlock, order: Order = 2):
        super().__init__(grid, order)
        _ = self.jacobian  # a folded grid is refused at once

    def gradient(self, values: np.ndarray) -> np.ndarray:
        """Gradient; exact for linear functions of the coordinates.

        Parameters
        ----------
        values : (ni, nj, nk) float
            At the points.

        Returns
        -------
        (ni, nj, nk, 3) float
        """
        values = self._checked(values, "values")
        return self._given(
            sum(self.contravariant[i] * self.derivative(values, i)[..., None] for i in range(self.dimension))
        )

    def divergence(self, vectors: np.ndarray) -> np.ndarray:
        """Divergence in conservation form; zero up to rounding for constant vectors.

        Parameters
        ----------
        vectors : (ni, nj, nk, 3) float
            At the points.

        Returns
        -------
        (ni, nj, nk) float
        """
        vectors = self._checked(vectors, "vectors", 3)
        return self._given(self._divergence_of(self._through(vectors)))

    def laplacian(self, values: np.ndarray) -> np.ndarray:
        """Laplacian in conservation form, of narrow stencils along the lines.

        Parameters
        ----------
        values : (ni, nj, nk) float
            At the points.

        Returns
        -------
        (ni, nj, nk) float
        """
        values = self._checked(values, "values")
        stencils, directions = self.stencils, range(self.dimension)
        slopes = [self.derivative(values, j) for j in directions]
        along = [self._middle_conductance[i] * self.along(stencils.middle_derivative, values, i) for i in directions]
        across = [sum(self.conductance(i, j) * slopes[j] for j in self.others(i)) for i in directions]
        result = self._sum_along(stencils.derivative_of_middles, along, "middles")
        return self._given((result + self._sum_along(stencils.derivative, across, "points")) / self.jacobian)

    def laplacian_matrix(self) -> scipy.sparse.csr_matrix:
        """(points, points) sparse: `laplacian` as a matrix, for ``values.ravel()``.

        Rows and columns go with the grid's shape, the last index fastest, and block after block. In a periodic
        direction the columns of the last points are empty, since these repeat the first.
        """
        stencils, directions, diagonal = self.stencils, range(self.dimension), scipy.sparse.diags
        slopes = [self._matrix(stencils.derivative, j) for j in directions]
        along = [
            diagonal(self._middle_conductance[i].ravel()) @ self._matrix(stencils.middle_derivative, i)
            for i in directions
        ]
        across = [sum(diagonal(self.conductance(i, j).ravel()) @ slopes[j] for j in self.others(i)) for i in directions]
        total = sum(
            self._matrix_of(stencils.derivative_of_middles, along, i, "middles")
            + self._matrix_of(stencils.derivative, across, i, "points")
            for i in directions
        )
        return scipy.sparse.csr_matrix(diagonal(1 / self.jacobian.ravel()) @ total)

    def poisson(self, source: np.ndarray, known: np.ndarray) -> np.ndarray:
        """Solve Poisson's equation, the Laplacian of f being the source, by a direct solver.

        Parameters
        ----------
        source : (ni, nj, nk) float
            At the points; a number stands for the same everywhere.
        known : (ni, nj, nk) float
            Values of f where it is given, on the whole boundary at least; nan where it is to be found.

        Returns
        -------
        (ni, nj, nk) float

        Raises
        ------
        InvalidInput
            If a value on the boundary is missing, or there are none at all.
        """
        known = self._checked(known, "known", missing=True)
        source = self._checked(source, "source")
        number = np.concatenate([n.ravel() for n in glued(self.grid.joins, [b.shape for b in self.blocks])])
        number = number.reshape(self.shape)
        values = known.ravel().copy()
        unknown = np.isnan(values[number])
        self._check_boundary(unknown)
        free = np.unique(number[unknown])
        values[free] = 0.0
        copies = scipy.sparse.csr_matrix((np.ones(number.size), (np.arange(number.size), number.ravel())))
        matrix = self.laplacian_matrix()[free] @ copies
        right = source.ravel()[free] - matrix @ np.nan_to_num(values[: matrix.shape[1]])
        values[free] = scipy.sparse.linalg.spsolve(matrix[:, free].tocsc(), right)
        return self._given(values[number])

    def convection(
        self,
        density: np.ndarray,
        velocity: np.ndarray,
        *,
        source: float | np.ndarray = 0.0,
        grid_velocity: np.ndarray | None = None,
    ) -> np.ndarray:
        """Rate of change of a density at the points, by d(rho)/dt + div(rho U) = S in conservation form.

        On a grid that moves that is the rate which the moving points see: d(J rho)/dt + d(J a^i . (U - W) rho)/di = J S
        with the velocity W of the points, and dJ/dt by the geometric conservation law dJ/dt = d(J a^i . W)/di,
        differenced in the same way. So a uniform density in a uniform velocity stays as it is, however the grid moves.

        Parameters
        ----------
        density : (ni, nj, nk) float
            The density rho.
        velocity : (ni, nj, nk, 3) float
            The velocity U.
        source : float or (ni, nj, nk) float
            The source S.
        grid_velocity : (ni, nj, nk, 3) float, optional
            The velocity W of the points; by default they rest.

        Returns
        -------
        (ni, nj, nk) float
        """
        density = self._checked(density, "density")
        velocity = self._checked(velocity, "velocity", 3)
        source = self._checked(source, "source")
        if grid_velocity is None:
            return self._given(source - self._divergence_of(self._through(density[..., None] * velocity)))
        grid_velocity = self._checked(grid_velocity, "grid_velocity", 3)
        outflow = self._divergence_of(self._through(density[..., None] * (velocity - grid_velocity)))
        return self._given(source - outflow - density * self._divergence_of(self._through(grid_velocity)))

    # ---- inside

    def _matrix(self, stencil: Stencil, axis: int, shape: list[int] | None = None) -> scipy.sparse.csr_matrix:
        """A stencil along one axis as a matrix for raveled arrays of a shape, by default of the points."""
        if self.lines is not None:
            return self.lines.matrix(stencil, axis, "points")
        parts = [scipy.sparse.identity(n) for n in shape or self.grid.shape]
        parts[axis] = stencil.matrix(parts[axis].shape[0], self.periods[axis])
        return scipy.sparse.kron(scipy.sparse.kron(parts[0], parts[1]), parts[2], format="csr")

    def _matrix_of(
        self, stencil: Stencil, parts: list[scipy.sparse.csr_matrix], axis: int, where: Where
    ) -> scipy.sparse.csr_matrix:
        """A stencil along one axis behind the matrices that make the fluxes of all directions."""
        if self.lines is not None:
            return self.lines.matrix(stencil, axis, where, axis, odd=True) @ scipy.sparse.vstack(parts)
        shape = [n - (where == "middles" and a == axis) for a, n in enumerate(self.shape)]
        return self._matrix(stencil, axis, shape) @ parts[axis]

    def _sum_along(self, stencil: Stencil, fluxes: list[np.ndarray], where: Where) -> np.ndarray:
        """The sum of a stencil's results, for the flux of each direction along that direction."""
        return sum(self.along_of(stencil, fluxes, i, i, where) for i in range(self.dimension))

    def _check_boundary(self, unknown: np.ndarray) -> None:
        """Raise if a value on a side that is joined to nothing is unknown, or all are."""
        marks = on_boundary([block.shape for block in self.blocks], self.grid.joins)
        boundary = np.concatenate([mark.ravel() for mark in marks]).reshape(self.shape)
        lacking = np.argwhere(boundary & unknown)
        if len(lacking) or unknown.all():
            where = f"on the boundary at {tuple(lacking[0].tolist())}" if len(lacking) else "anywhere"
            raise InvalidInput(f"has no value {where}; give it all, so that f is unique", parameter="known")

    def _through(self, vectors: np.ndarray) -> list[np.ndarray]:
        """Fluxes of a vector field for each direction."""
        return [dot(area, vectors) for area in self.area_vectors]

    def _divergence_of(self, fluxes: list[np.ndarray]) -> np.ndarray:
        return self._sum_along(self.stencils.derivative, fluxes, "points") / self.jacobian

    def _given(self, values: np.ndarray) -> np.ndarray | list[np.ndarray]:
        """Values as the user has them: in the grid's shape, or one array for each block."""
        if not isinstance(self.grid, MultiBlock):
            return values.reshape(*self.grid.shape, *values.shape[3:])
        ends = np.cumsum([block.n_points for block in self.blocks])[:-1]
        parts = zip(np.split(values, ends), self.blocks, strict=True)
        return [part.reshape(*block.shape, *values.shape[3:]) for part, block in parts]

    @cached_property
    def _middle_conductance(self) -> list[np.ndarray]:
        """For each direction, J g^ii in the middles between the points along it."""
        directions = range(self.dimension)
        conductances = [self.conductance(i, i) for i in directions]
        return [self.along_of(self.stencils.middle, conductances, i, i, "points", odd=False) for i in directions]

    def _checked(self, values: np.ndarray, name: str, components: int = 0, missing: bool = False) -> np.ndarray:
        tail = (components,) if components else ()
        if not isinstance(self.grid, MultiBlock):
            return checked_field(values, self.grid.shape + tail, name, missing).reshape(self.shape + tail)
        if not isinstance(values, (list, tuple)) and np.ndim(values) == 0:
            values = [values] * len(self.blocks)
        if not isinstance(values, (list, tuple)) or len(values) != len(self.blocks):
            raise InvalidInput(f"needs a list of {len(self.blocks)} arrays, one a block", parameter=name)
        fields = [
            checked_field(v, block.shape + tail, f"{name}[{k}]", missing)
            for k, (v, block) in enumerate(zip(values, self.blocks, strict=True))
        ]
        return np.concatenate([field.reshape(-1, 1, 1, *tail) for field in fields])


def checked_field(values: np.ndarray, shape: tuple[int, ...], name: str, missing: bool = False) -> np.ndarray:
    """Values as floats of a grid's shape, or `InvalidInput`; nan are allowed where values may be missing.

    One number stands for the same everywhere, and the layer of a surface may be left out.

    Examples
    --------
    >>> checked_field([[1, 2], [3, 4]], (2, 2, 1), "values").shape
    (2, 2, 1)
    """
    try:
        values = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise InvalidInput("needs numbers", parameter=name) from None
    if values.ndim == 0:
        values = np.full(shape, values)
    if shape[2] == 1 and values.shape == shape[:2] + shape[3:]:
        values = values.reshape(shape)
    if values.shape != shape:
        raise InvalidInput(f"needs shape {shape}, got {values.shape}", parameter=name)
    bad = np.isinf(values) if missing else ~np.isfinite(values)
    if bad.any():
        where = tuple(np.argwhere(bad)[0].tolist())
        raise InvalidInput(f"is {values[where]} at {where}; give finite values", parameter=name)
    return values
