"""Boolean sums of projections: points between given lines of a patch, or given surfaces of a block (survey 2.4.1)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from .sides import fractions_of

Blending = Literal["arc length", "linear", "cubic"]
NEAR = 0.3
"""Reach of right angles at sides: near corners that are none slopes must turn, which far inside makes a bulge."""


def interpolated(
    south: np.ndarray,
    east: np.ndarray,
    north: np.ndarray,
    west: np.ndarray,
    *,
    blending: Literal["arc length", "linear"] = "linear",
) -> np.ndarray:
    """The Boolean sum P_s + P_t - P_s P_t of linear projections between sides that meet exactly.

    Parameters
    ----------
    south, north : (ni, 3) float
        Sides at j = 0 and at the last j, in the direction of i.
    east, west : (nj, 3) float
        Sides at the last i and at i = 0, in the direction of j.
    blending : {"linear", "arc length"}
        Whether s and t are the cells' numbers or the sides' lengths, see `transfinite`.

    Returns
    -------
    (ni, nj, 3) float
        Points whose outermost rows are the sides, to the last bit.

    Examples
    --------
    >>> x, y = np.array([0, 0.5, 1]), np.zeros(3)
    >>> south, west = np.column_stack([x, y, y]), np.column_stack([y, x, y])
    >>> interpolated(south, west + [1, 0, 0], south + [0, 1, 0], west)[1, 1]
    array([0.5, 0.5, 0. ])
    """
    if blending == "linear":
        s = np.linspace(0, 1, len(south))[:, None]
        t = np.linspace(0, 1, len(west))[None, :]
    else:
        s, t = crossing(*(fractions_of(side) for side in (south, north, west, east)))
    s, t = s[..., None], t[..., None]
    along_s = (1 - s) * west[None] + s * east[None]
    along_t = (1 - t) * south[:, None] + t * north[:, None]
    product = (1 - s) * ((1 - t) * south[0] + t * north[0]) + s * ((1 - t) * south[-1] + t * north[-1])
    points = along_s + along_t - product
    points[:, 0], points[:, -1], points[0], points[-1] = south, north, west, east  # to the last bit
    return points


def crossing(
    s_south: np.ndarray, s_north: np.ndarray, t_west: np.ndarray, t_east: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(ni, nj) s and t where straight lines between fractions on opposite sides of the unit square cross.

    ``s = (1 - t) s_south + t s_north`` and ``t = (1 - s) t_west + s t_east`` (Soni 1985) are linear in each other.

    Examples
    --------
    >>> even = np.array([0, 0.5, 1])
    >>> s, t = crossing(even, even, even, even**2)
    >>> t[1]
    array([0.   , 0.375, 1.   ])
    """
    s0, ds = s_south[:, None], (s_north - s_south)[:, None]
    t0, dt = t_west[None, :], (t_east - t_west)[None, :]
    across = 1 - ds * dt
    return (s0 + t0 * ds) / across, (t0 + s0 * dt) / across


@dataclass(frozen=True, eq=False)
class Direction:
    """What is known across one direction of the computational space, and the blending functions along it.

    Attributes
    ----------
    parameters : (n,) float
        Increasing from 0 to 1.
    known : dict of int to (..., 3) float
        Points at stations of this direction, which keep them to the last bit; the first and last station are there.
    slopes : dict of int to (..., 3) float
        At station 0 or n - 1, the step from there to the next station up, per cell: dx/di.
    smooth : bool
        Whether blending functions are cubic splines, or broken lines through the stations.
    reach : float
        How far slopes are felt, as a part of the way to the next station. Below 1, they are added to what the known
        points give without them, and polynomials of the slopes' degree are no longer reproduced.
    """

    parameters: np.ndarray
    known: Mapping[int, np.ndarray]
    slopes: Mapping[int, np.ndarray] = field(default_factory=dict)
    smooth: bool = False
    reach: float = 1.0

    @property
    def stations(self) -> list[int]:
        """Numbers of the known points, in order."""
        return sorted(self.known)

    def project(self, values: np.ndarray) -> None:
        """Add to (n, ..., 3) values, in place, what gives them the known points and slopes."""
        stations, ends = self.stations, sorted(self.slopes)
        u, at = self.parameters, self.parameters[stations]
        data = [self.known[k] - values[k] for k in stations]
        if self.reach < 1:
            functions = cardinal(at, u, slopes=at[:0]) if self.smooth else broken(at, u)
            values += np.tensordot(functions, np.array(data), axes=1)
            for end in ends:
                away = (u - u[end]) / (self.reach * self.room(end))
                bump = (u - u[end]) * np.maximum(1 - np.abs(away), 0) ** 2
                values += np.multiply.outer(bump, self.slopes[end] / self.step(end) - end_derivative(values, u, end))
            return
        for end in ends:
            data.append(self.slopes[end] / self.step(end) - end_derivative(values, self.parameters, end))
        weights = (
            cardinal(at, self.parameters, slopes=self.parameters[ends]) if self.smooth else broken(at, self.parameters)
        )
        values += np.tensordot(weights, np.array(data), axes=1)

    def room(self, station: int) -> float:
        """Way from a station to the next one, on the side where that is nearer."""
        at = self.parameters[self.stations]
        gaps = np.abs(at - self.parameters[station])
        return float(gaps[gaps > 0].min())

    def step(self, end: int) -> float:
        """Difference of the parameters over the cell at an end."""
        u = self.parameters
        return float(u[1] - u[0] if end == 0 else u[-1] - u[-2])


def boolean_sum(directions: Sequence[Direction]) -> np.ndarray:
    """Interpolate known lines or surfaces of all directions at once.

    The projections follow one another, each adding what the ones before left over: ``P + Q - PQ = P + Q (1 - P)``.
    What is known in different directions must agree where it meets; slopes that do not are turned near there.

    Parameters
    ----------
    directions : sequence of Direction
        Along i, j and, for a block, k.

    Returns
    -------
    (ni, nj[, nk], 3) float
        Points that contain what is known to the last bit.

    References
    ----------
    Survey, section 2.4.1. W. J. Gordon, "Blending-function methods of bivariate and multivariate interpolation and
    approximation", SIAM J. Numer. Anal. 8 (1971).

    Examples
    --------
    >>> u = np.array([0, 0.5, 1])
    >>> side = np.column_stack([u, 0 * u, 0 * u])
    >>> along_i = Direction(u, {0: side[:, ::-1], 2: side[:, ::-1] + [1, 0, 0]})
    >>> along_j = Direction(u, {0: side, 2: side + [0, 0, 1]})
    >>> boolean_sum([along_i, along_j])[1, 1]
    array([0.5, 0. , 0.5])
    """
    met = {}
    for axis, direction in enumerate(directions):
        slopes = {end: _met(slope, end, axis, directions) for end, slope in direction.slopes.items()}
        met[axis] = replace(direction, slopes=slopes)
    return _summed((*(len(d.parameters) for d in directions), 3), met)


def _summed(shape: tuple[int, ...], directions: Mapping[int, Direction]) -> np.ndarray:
    """Values of a shape, to which the direction of each axis adds what the ones before left over."""
    values = np.zeros(shape)
    for axis, direction in directions.items():
        direction.project(np.moveaxis(values, axis, 0))
    for axis, direction in directions.items():  # to the last bit
        for station, known in direction.known.items():
            np.moveaxis(values, axis, 0)[station] = known
    return values


def blended(values: np.ndarray, axes: Sequence[int]) -> np.ndarray:
    """The Boolean sum of linear projections along some axes between the first and the last values of each.

    Parameters
    ----------
    values : array
        Only those at an end of one of the axes matter, and are kept.
    axes : sequence of int
        Along which to interpolate.

    Examples
    --------
    >>> blended(np.array([[0, 9, 2], [1, 9, 5.0]]), [1])
    array([[0., 1., 2.],
           [1., 3., 5.]])
    """
    directions = {}
    for axis in axes:
        rows = np.moveaxis(values, axis, 0)
        directions[axis] = Direction(np.linspace(0, 1, len(rows)), {0: rows[0], len(rows) - 1: rows[-1]})
    return _summed(values.shape, directions)


def _met(slope: np.ndarray, end: int, axis: int, directions: Sequence[Direction]) -> np.ndarray:
    """A slope across ``axis`` that at the known lines of other directions is theirs.

    What differs fades over the part of the way to the next station over which slopes are felt: the farther they are
    felt, the less suddenly may they change.
    """
    own = directions[axis]
    slope = np.array(slope, float)
    others = [a for a in range(len(directions)) if a != axis]
    for place, other in enumerate(others):
        across = directions[other]
        u = across.parameters
        rows = np.moveaxis(slope, place, 0)
        for station in across.stations:
            line = np.moveaxis(across.known[station], axis - (axis > other), 0)
            wanted = own.step(end) * end_derivative(line, own.parameters, end)
            away = np.clip(np.abs(u - u[station]) / (own.reach * across.room(station)), 0, 1)
            weight = 1 - away**2 * (3 - 2 * away)
            rows += np.multiply.outer(weight, wanted - rows[station])
    return slope


def end_derivative(values: np.ndarray, parameters: np.ndarray, end: int) -> np.ndarray:
    """Derivative of (n, ...) values at the first or last of their parameters, from the polynomial through four.

    Examples
    --------
    >>> u = np.array([0, 0.25, 0.5, 1])
    >>> print(end_derivative(u**3 + u, u, 3).round(12))
    4.0
    """
    n = min(4, len(parameters))
    near = slice(0, n) if end == 0 else slice(len(parameters) - n, None)
    at = parameters[near]
    here = 0 if end == 0 else n - 1
    weights = np.empty(n)
    for k in range(n):
        if k != here:
            others = [at[m] for m in range(n) if m not in (k, here)]
            weights[k] = np.prod([(at[here] - x) / (at[k] - x) for x in others]) / (at[k] - at[here])
    weights[here] = sum(1 / (at[here] - at[m]) for m in range(n) if m != here)
    return np.tensordot(weights, values[near], axes=1)


def broken(stations: np.ndarray, at: np.ndarray) -> np.ndarray:
    """(n, k) float: at parameters, the functions that are 1 at one of k stations, 0 at the others, straight between.

    Examples
    --------
    >>> broken(np.array([0, 0.5, 1]), np.array([0, 0.25, 1]))
    array([[1. , 0. , 0. ],
           [0.5, 0.5, 0. ],
           [0. , 0. , 1. ]])
    """
    return np.column_stack([np.interp(at, stations, row) for row in np.eye(len(stations))])


def cardinal(stations: np.ndarray, at: np.ndarray, *, slopes: np.ndarray) -> np.ndarray:
    """(n, k + e) float: at parameters, the cardinal cubic splines of k stations and e slopes at the ends.

    The first k have value 1 at one station, the last e a derivative of 1 at one end, and all other values and
    given derivatives are 0. An end without slope has no knot next to it. Where the data are no more than four, this
    makes them polynomials; either way cubics (polynomials of degree k + e - 1, if that is less) are reproduced.

    Parameters
    ----------
    stations : (k,) float
        Increasing.
    at : (n,) float
        Where the functions are wanted.
    slopes : (e,) float
        Those of the first and last station where the derivative is given, in order.

    Examples
    --------
    >>> cardinal(np.array([0, 1]), np.array([0.5]), slopes=np.array([0, 1]))
    array([[ 0.5  ,  0.5  ,  0.125, -0.125]])
    """
    count = len(stations) + len(slopes)
    if count <= 4:
        powers = np.arange(count)
        derivatives = powers * np.power.outer(slopes, np.maximum(powers - 1, 0))
        known = np.vstack([np.power.outer(stations, powers), derivatives])
        return np.linalg.solve(known.T, np.power.outer(at, powers).T).T
    from scipy.interpolate import CubicSpline  # half a second, which not every start should take

    unit = np.eye(count)
    ends = []
    for station in (stations[0], stations[-1]):
        row = len(stations) + np.flatnonzero(slopes == station)
        ends.append((1, unit[row[0]]) if len(row) else "not-a-knot")
    return CubicSpline(stations, unit[: len(stations)], bc_type=tuple(ends))(at)


@dataclass(frozen=True, eq=False)
class Patch:
    """A four-sided patch and all that is known inside it.

    Attributes
    ----------
    south, east, north, west : (n, 3) float
        The sides, with equal numbers of points where they are opposite; they meet exactly.
    lines_i, lines_j : dict of int to (n, 3) float
        Lines inside, by the i or the j that is theirs.
    blending : {"arc length", "linear", "cubic"}
        See `transfinite`.
    slopes : dict of str to (n, 3) float, optional
        For "cubic": by side, the step of the lines across it, per cell, in the direction of i or j. None makes the
        lines leave all four sides at right angles.
    """

    south: np.ndarray
    east: np.ndarray
    north: np.ndarray
    west: np.ndarray
    lines_i: Mapping[int, np.ndarray] = field(default_factory=dict)
    lines_j: Mapping[int, np.ndarray] = field(default_factory=dict)
    blending: Blending = "arc length"
    slopes: Mapping[str, np.ndarray] | None = None

    def points(self) -> np.ndarray:
        """(ni, nj, 3) float: the interpolated grid."""
        if self.blending == "cubic":
            if self.slopes is not None:
                return boolean_sum(self._directions(self.slopes, smooth=True))
            return boolean_sum([replace(d, reach=NEAR) for d in self._directions(self._normal_slopes(), smooth=True)])
        if self.lines_i or self.lines_j:
            return boolean_sum(self._directions({}, smooth=False))
        return interpolated(self.south, self.east, self.north, self.west, blending=self.blending)

    def _directions(self, slopes: Mapping[str, np.ndarray], *, smooth: bool) -> list[Direction]:
        n_i, n_j = len(self.south), len(self.west)
        along_i = {0: self.west, **self.lines_i, n_i - 1: self.east}
        along_j = {0: self.south, **self.lines_j, n_j - 1: self.north}
        across_i = {k: slopes[name] for k, name in ((0, "west"), (n_i - 1, "east")) if name in slopes}
        across_j = {k: slopes[name] for k, name in ((0, "south"), (n_j - 1, "north")) if name in slopes}
        i, j = (self._parameters(lines, n) for lines, n in ((along_j, n_i), (along_i, n_j)))
        return [Direction(i, along_i, across_i, smooth), Direction(j, along_j, across_j, smooth)]

    def _parameters(self, lines: Mapping[int, np.ndarray], n: int) -> np.ndarray:
        """Of the cells' numbers, or of the mean length of the lines that run along this direction."""
        if self.blending == "linear":
            return np.arange(n) / (n - 1)
        return np.mean([fractions_of(line) for line in lines.values()], axis=0)

    def _normal_slopes(self) -> dict[str, np.ndarray]:
        """The steps of linear blending across the sides, turned to right angles with them."""
        linear = Patch(self.south, self.east, self.north, self.west, self.lines_i, self.lines_j).points()
        steps = {
            "south": (self.south, linear[:, 1] - linear[:, 0]),
            "north": (self.north, linear[:, -1] - linear[:, -2]),
            "west": (self.west, linear[1] - linear[0]),
            "east": (self.east, linear[-1] - linear[-2]),
        }
        return {name: _across(side, step) for name, (side, step) in steps.items()}


def _across(side: np.ndarray, step: np.ndarray) -> np.ndarray:
    """Steps from the points of a side, turned to right angles with it; as long as they were."""
    tangent = np.gradient(side, axis=0)
    size = np.linalg.norm(tangent, axis=1)  # none where a side turns back on itself
    tangent /= np.where(size > 0, size, 1.0)[:, None]
    normal = step - (step * tangent).sum(axis=1)[:, None] * tangent
    size = np.linalg.norm(normal, axis=1)
    length = np.linalg.norm(step, axis=1)
    return np.where(size > 0, length / np.where(size > 0, size, 1.0), 0.0)[:, None] * normal
