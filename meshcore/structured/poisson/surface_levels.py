"""Grids on curved surfaces as levels of a multigrid solver: by parameters, or on facets on which points are dropped."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass

import numpy as np

from ...geometry.closest import FacetedSurface, Foot
from ...geometry.surfaces import Surface
from ...threads import Workers
from ..folds import beside_poles
from . import _winslow_surface_kernels as kernels
from .multigrid import Level
from .transfer import LEAST_CELLS, Line, Ring, Transfer, coarsened, coarser, growth_on_coarse


class OnSurface(Level):
    """One grid on a surface: x and f of shape (m, ni, nj); how x stands for points, those derived from it know."""

    cyclic: bool
    sweeps = 2
    _period: tuple[float, ...]
    """By what the last row of a cyclic grid differs from the first, in x."""

    def _prepare(self, x: np.ndarray, growth: np.ndarray, cyclic: bool) -> None:
        self.x = np.ascontiguousarray(x)
        self.f = np.zeros_like(self.x)
        self.cyclic = cyclic
        self.set_growth(growth)
        self._shape = self.x.shape[1:]
        self._local = np.zeros((2, *self._shape))
        self._line = np.empty((4, max(self._shape)))

    def set_growth(self, growth: np.ndarray) -> None:
        """Take (2, ni, nj) logarithms of growth as control functions; none if empty."""
        self._control = -2 * np.tanh(growth.reshape(-1) / 2)

    def smooth(self, *, back: bool) -> None:
        """Zebra lines along i and j, or in the reverse order, more than once: coarse grids fit less than in a plane."""
        for axis in ((1, 0) if back else (0, 1)) * self.sweeps:
            self._sweep(axis)

    @abstractmethod
    def _sweep(self, axis: int) -> None:
        """Zebra lines along one direction."""

    @abstractmethod
    def _evaluated(self) -> tuple[np.ndarray, np.ndarray]:
        """Flat points and tangents at x, which is kept on the surface."""

    @abstractmethod
    def points_and_normals(self) -> tuple[np.ndarray, np.ndarray]:
        """(ni, nj, 3) points and unit normals at x, or vectors without direction where there are none."""

    @abstractmethod
    def _right_side(self, tangents: np.ndarray) -> np.ndarray:
        """Flat f in components of the tangents."""

    @abstractmethod
    def points_at(self, x: np.ndarray) -> np.ndarray:
        """(ni, nj, 3) points that x stands for."""

    def settle(self) -> None:
        """Put x on the surface."""
        self._evaluated()

    def _close(self) -> None:
        if self.cyclic:
            self.x[:, -1] = self.x[:, 0] + np.array(self._period)[:, None]

    def residual(self) -> float:
        """Root mean square of the lengths by which point relaxation would move the nodes."""
        total = self._squares(*self._evaluated())
        return float(np.sqrt(total / ((self._shape[0] - (1 if self.cyclic else 2)) * (self._shape[1] - 2))))

    def _squares(self, r: np.ndarray, t: np.ndarray) -> float:
        """Fill the defect in components of the tangents."""
        f = self._right_side(t)
        return kernels.defect(r, t, f, self._control, self._shape, self.cyclic, self._local.reshape(-1))

    def _relax(self, r: np.ndarray, t: np.ndarray, x: np.ndarray, axis: int) -> None:
        f = self._right_side(t)
        kernels.relax(r, t, x, f, self._control, self._shape, self.cyclic, axis, self._line)

    def largest_move(self, before: np.ndarray) -> float:
        """Largest move of a node since ``before``, in local spacings."""
        new, old = self.points_at(self.x), self.points_at(np.ascontiguousarray(before))
        spacing = np.minimum(*(np.linalg.norm(np.gradient(new, axis=axis), axis=-1) for axis in (0, 1)))
        moved = np.linalg.norm(new - old, axis=-1)
        return float((moved / np.maximum(spacing, kernels.TINY))[1:-1, 1:-1].max())


class Patch(OnSurface):
    """A grid on a surface with parameters: x are u and v."""

    _period = (1.0, 0.0)

    def __init__(self, surface: Surface, size: float, x: np.ndarray, growth: np.ndarray, cyclic: bool, sign: float):
        self._prepare(x, growth, cyclic)
        self._surface, self._size, self._sign = surface, size, sign

    def points_at(self, x: np.ndarray) -> np.ndarray:
        """(ni, nj, 3) points of the surface."""
        return self._surface.points(*x)

    def points_and_normals(self) -> tuple[np.ndarray, np.ndarray]:
        """(ni, nj, 3) points and unit normals at x."""
        self.settle()
        normals = np.cross(*self._surface.tangents(*self.x))
        length = np.linalg.norm(normals, axis=-1, keepdims=True)
        return self.points_at(self.x), normals / np.where(length > 0, length, 1.0)

    def _evaluated(self) -> tuple[np.ndarray, np.ndarray]:
        """Flat points and tangents at x, which is kept within the surface."""
        self._close()
        for q in (0, 1):
            np.clip(self.x[q], self._surface.low[q], self._surface.high[q], out=self.x[q])
        with np.errstate(invalid="ignore"):  # a coarse grid may run away round the surface; its correction is not taken
            points = self._surface.points(*self.x) / self._size
            tangents = np.concatenate(self._surface.tangents(*self.x), axis=-1) / self._size
        return np.moveaxis(points, -1, 0).ravel(), np.moveaxis(tangents, -1, 0).ravel()

    def _right_side(self, tangents: np.ndarray) -> np.ndarray:
        return self.f.reshape(-1)

    def _sweep(self, axis: int) -> None:
        self._relax(*self._evaluated(), self.x.reshape(-1), axis)
        self._close()

    def defect(self) -> np.ndarray:
        """f - N(x), zero on the boundary; the array is used again by the next call."""
        self._squares(*self._evaluated())
        return self._local

    def folded(self) -> int:
        """Cells with a corner whose angle in the parameters is zero or has the wrong sign."""
        return int((self._sign * corner_jacobians(np.moveaxis(self.x, 0, -1)) <= 0).any(axis=0).sum())


class Draped(OnSurface):
    """A grid on a surface of facets: x are points in space, which are dropped on it wherever they move.

    The equations are those of the smooth surface that the facets stand for, above x, and what is tangential is so to
    its normals. Right sides are vectors in space.
    """

    _period = (0.0, 0.0, 0.0)

    def __init__(
        self, surface: FacetedSurface, size: float, x: np.ndarray, growth: np.ndarray, cyclic: bool, sign: float
    ):
        self._prepare(x, growth, cyclic)
        self._surface, self._size, self._sign = surface, size, sign
        self._defect = np.zeros_like(self.x)
        self._moves = np.zeros((2, *self._shape))

    def points_at(self, x: np.ndarray) -> np.ndarray:
        """(ni, nj, 3) points as they are."""
        return np.moveaxis(x, 0, -1)

    def points_and_normals(self) -> tuple[np.ndarray, np.ndarray]:
        """(ni, nj, 3) points and unit normals at x."""
        self._close()
        foot = dropped(self._surface, self.x, self.cyclic)
        return self.points_at(self.x), foot.normals.reshape(*self._shape, 3)

    def _evaluated(self) -> tuple[np.ndarray, np.ndarray]:
        """Flat points and orthonormal tangents at x, whose inner points are dropped on the surface."""
        self._close()
        foot = dropped(self._surface, self.x, self.cyclic)
        n = np.ascontiguousarray(foot.normals.T)
        # Lines are solved for components along the tangents: these must turn smoothly along them, as the grid does.
        along = self._along_i().reshape(3, -1)
        along -= n * (n * along).sum(axis=0)
        length = np.linalg.norm(along, axis=0)
        first = along / np.where(length > 0, length, 1.0)
        points = (self.x.reshape(-1) + foot.lifts.T.ravel()) / self._size
        return points, np.concatenate([first, np.cross(n, first, axis=0)]).ravel()

    def _along_i(self) -> np.ndarray:
        """(3, ni, nj) differences of the points across each node."""
        along = np.gradient(self.x, axis=1)
        if self.cyclic:
            along[:, 0] = along[:, -1] = 0.5 * (self.x[:, 1] - self.x[:, -2])
        return along

    def _right_side(self, tangents: np.ndarray) -> np.ndarray:
        return (tangents.reshape(2, 3, -1) * self.f.reshape(1, 3, -1)).sum(axis=1).ravel()

    def _sweep(self, axis: int) -> None:
        r, t = self._evaluated()
        before = r.copy()
        self._relax(r, t, self._moves.reshape(-1), axis)
        self.x += self._size * (r - before).reshape(self.x.shape)
        dropped(self._surface, self.x, self.cyclic)

    def defect(self) -> np.ndarray:
        """f - N(x) in space, zero on the boundary; the array is used again by the next call."""
        r, t = self._evaluated()
        self._squares(r, t)
        t = t.reshape(2, 3, *self._shape)
        self._defect[...] = t[0] * self._local[0] + t[1] * self._local[1]
        return self._defect

    def folded(self) -> int:
        """Cells with a corner that looks away from the side of the surface that the grid as a whole is seen on."""
        normals = self._surface.closest(self.x.reshape(3, -1).T).normals
        return int(folded_against(np.moveaxis(self.x, 0, -1), self._sign * normals).sum())


@dataclass(frozen=True)
class _Dropping(Transfer):
    """A transfer between grids on a surface of facets: what is sampled is dropped on it."""

    surface: FacetedSurface
    cyclic: bool

    def sampled(self, fine: np.ndarray) -> np.ndarray:
        """(3, *coarse shape) points of the surface near to those at the coarse nodes."""
        coarse = super().sampled(fine)
        dropped(self.surface, coarse, self.cyclic)
        return coarse


def dropped(surface: FacetedSurface, x: np.ndarray, cyclic: bool) -> Foot:
    """Where the (3, ni, nj) points of x come to lie on a surface; the inner ones are put there."""
    foot = surface.closest(x.reshape(3, -1).T)
    at = foot.points.T.reshape(x.shape)
    inner = np.s_[:, :, 1:-1] if cyclic else np.s_[:, 1:-1, 1:-1]
    x[inner] = at[inner]
    return foot


def folded_against(points: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """(ni - 1, nj - 1) bool: cells with a corner that is flat or does not look to the side of the surface's normals.

    Parameters
    ----------
    points : (ni, nj, 3) float
        A grid on a surface.
    normals : (ni * nj, 3) float
        The surface's normals at its points.

    Examples
    --------
    >>> x, y = np.meshgrid([0.0, 1, 2], [0.0, 1], indexing="ij")
    >>> points = np.stack([x, y, 0 * x], axis=-1)
    >>> points[1, 0, 0] = 2.5
    >>> folded_against(points, np.tile([0.0, 0, 1], (6, 1))).ravel()
    array([False,  True])
    """
    normals = normals.reshape(points.shape)
    quad, facing = ([a[:-1, :-1], a[1:, :-1], a[1:, 1:], a[:-1, 1:]] for a in (points, normals))
    front = sum(facing)
    edges = [quad[(k + 1) % 4] - quad[k] for k in range(4)]
    corners = np.stack([(np.cross(edges[k - 1], edges[k]) * front).sum(axis=-1) <= 0 for k in range(4)])
    return beside_poles(corners, points).any(axis=0)


def corner_jacobians(plane: np.ndarray) -> np.ndarray:
    """(4, ni - 1, nj - 1) Jacobians at the corners of the cells of a planar grid.

    Examples
    --------
    >>> corner_jacobians(np.array([[[0, 0], [0, 2]], [[1, 0], [1, 2.0]]])).ravel()
    array([2., 2., 2., 2.])
    """
    quad = [plane[:-1, :-1], plane[1:, :-1], plane[1:, 1:], plane[:-1, 1:]]
    edges = [quad[(k + 1) % 4] - quad[k] for k in range(4)]
    return np.stack(
        [edges[k - 1][..., 0] * edges[k][..., 1] - edges[k - 1][..., 1] * edges[k][..., 0] for k in range(4)]
    )


def levels_on(
    surface: Surface | FacetedSurface,
    x: np.ndarray,
    growth: np.ndarray | None,
    cyclic: bool,
    workers: Workers,
    fewest: int = LEAST_CELLS,
) -> list[OnSurface]:
    """The grid x and ever coarser ones, finest first, down to where no direction of so many cells can be coarsened."""
    theta = np.empty((2, 0, 0)) if growth is None else growth
    draped = isinstance(surface, FacetedSurface)
    kind = Draped if draped else Patch
    sign = _side(surface, x)
    points = x if draped else np.moveaxis(surface.points(*x), -1, 0)
    size = float(np.ptp(points.reshape(3, -1), axis=1).max()) or 1.0
    levels = [kind(surface, size, x, theta, cyclic, sign)]
    while lines := _coarsened(levels[-1].x.shape[1:], fewest):
        if cyclic:
            lines = (Ring(lines[0].fine, lines[0].coarse), lines[1])
        transfer = _Dropping(lines, workers, surface, cyclic) if draped else Transfer(lines, workers)
        levels[-1].transfer = transfer
        theta = theta if growth is None else growth_on_coarse(transfer, theta)
        levels.append(kind(surface, size, transfer.sampled(levels[-1].x), theta, cyclic, sign))
    return levels


def _coarsened(shape: tuple[int, ...], fewest: int) -> tuple[Line, ...]:
    return coarsened(shape, [coarser(n - 1, fewest) < n - 1 for n in shape])


def set_growth(levels: list[OnSurface], growth: np.ndarray) -> None:
    """Give (2, ni, nj) logarithms of growth to the finest level, and what they are on them to the coarser ones."""
    for level in levels:
        level.set_growth(growth)
        if level.transfer is not None:
            growth = growth_on_coarse(level.transfer, growth)


def _side(surface: Surface | FacetedSurface, x: np.ndarray) -> float:
    """1 if the grid as a whole is seen from the side of the surface's normals or parameters, else -1."""
    if not isinstance(surface, FacetedSurface):
        return 1.0 if corner_jacobians(np.moveaxis(x, 0, -1)).sum() >= 0 else -1.0
    normals = surface.closest(x.reshape(3, -1).T).normals.reshape(*x.shape[1:], 3)
    p = np.moveaxis(x, 0, -1)
    area = np.cross(p[1:, 1:] - p[:-1, :-1], p[:-1, 1:] - p[1:, :-1])
    return 1.0 if (area * (normals[1:, 1:] + normals[:-1, :-1])).sum() >= 0 else -1.0
