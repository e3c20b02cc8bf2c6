"""Exact geometric predicates on arrays of points, and the range of coordinates in which they are exact."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from ..errors import InvalidGeometry, InvalidInput
from . import _predicates_kernels as kernels

LOWEST_BIT = -214
"""Coordinates must be multiples of 2 to this power.

The largest product, insphere's, is of degree 5. Every term of every expansion of degree d is a multiple of 2 to the
power d * LOWEST_BIT, and 5 * -214 = -1070 is above -1074, the last bit of the smallest double: nothing underflows."""

HIGHEST_BIT = 202
"""Coordinates must be smaller than 2 to this power.

Differences are below 2^203, lifts below 3 * 2^406, 3 x 3 minors below 6 * 2^609, and the four products of insphere
together below 4 * 18 * 2^1015 < 2^1022: neither determinant nor permanent overflows. `two_product` multiplies its
factors, minors and entries of degree 3 at most, by 2^27 + 1 to split them: far below."""


# A quantum smaller than this part of the largest coordinate is of no use: no permanent would be below its limits.
_SMALLEST_QUANTUM = 2.0**-40


def workspace(quantum: float = 0.0) -> np.ndarray:
    """Scratch array for the predicate kernels; each thread needs its own.

    Parameters
    ----------
    quantum : float
        A power of two of which all coordinates are multiples, or 0 if unknown (`quantum_of`). With it, determinants
        of points near each other, on a grid say, are known to be exact in doubles.

    Returns
    -------
    work : (k,) float
        Its contents do not matter.

    Notes
    -----
    If all coordinates are multiples of q, a term of degree d of the determinant is a multiple of q^d. Where the
    permanent is below 2^53 q^d, so are all partial sums and all factors of terms that are not zero: nothing is rounded.
    Two powers are left for the rounding of the permanent itself.

    Examples
    --------
    >>> from meshcore.geometry import _predicates_kernels as kernels
    >>> kernels.orient2d(0.0, 0.0, 1.0, 0.0, 0.0, 1.0, workspace()) > 0
    True
    """
    work = np.empty(kernels.WORK_SIZE)
    for place, degree in (
        (kernels.EXACT_ORIENT2D, 2),
        (kernels.EXACT_INCIRCLE, 4),
        (kernels.EXACT_ORIENT3D, 3),
        (kernels.EXACT_INSPHERE, 5),
    ):
        work[place] = 2.0**51 * quantum**degree
    return work


def quantum_of(points: np.ndarray) -> float:
    """The largest power of two of which all coordinates are multiples.

    Parameters
    ----------
    points : (n, 2) or (n, 3) float
        C-contiguous and safe, see `rescaled`.

    Returns
    -------
    quantum : float
        0 if it is too small, beside the largest coordinate, to be of use.

    Examples
    --------
    >>> quantum_of(np.array([[0.5, 3.0], [1.25, 2.0]])), quantum_of(np.array([[0.1, 0.2]]))
    (0.25, 0.0)
    """
    numbers = points.reshape(-1)
    found = np.zeros(2)
    kernels.magnitudes(numbers, found)
    if found[1] == 0.0:
        return 0.0
    largest = math.ldexp(0.5, math.frexp(found[1])[1])
    return kernels.quantum(numbers, largest, largest * _SMALLEST_QUANTUM)


def is_safe(points: np.ndarray) -> bool:
    """Whether all coordinates are finite and surely within what the predicates can take, without a closer look.

    Examples
    --------
    >>> is_safe(np.array([[0.0, 1.0]])), is_safe(np.array([[1e-300, 1.0]]))
    (True, False)
    """
    found = np.zeros(2)
    finite = kernels.magnitudes(points.reshape(-1), found)
    smallest, largest = found.tolist()
    return finite and smallest >= 2.0 ** (LOWEST_BIT + 53) and largest < 2.0**HIGHEST_BIT


def rescaled(points: np.ndarray) -> tuple[np.ndarray, int]:
    """Points times a power of two that makes the predicates safe from under- and overflow.

    The predicates' kernels need coordinates below 2^202, in multiples of 2^-214: any coordinates between 1e-48 and
    1e60, or zero, are. Other ones are scaled, without rounding, so that their signs stay what they were.

    Parameters
    ----------
    points : (n, 2) or (n, 3) float
        Points.

    Returns
    -------
    points : (n, 2) or (n, 3) float
        The points times ``2.0**exponent``; the array itself if the exponent is zero.
    exponent : int
        Zero for all but extreme input; ``numpy.ldexp(points, -exponent)`` goes back.

    Raises
    ------
    InvalidInput
        If the points are not finite, or too large and too small coordinates are mixed.

    Examples
    --------
    >>> rescaled(np.array([[0.5, 2.0]]))
    (array([[0.5, 2. ]]), 0)
    >>> points, exponent = rescaled(np.array([[3e-300, 0.0], [0.0, 1e-310]]))
    >>> exponent
    994
    """
    points = np.ascontiguousarray(points, dtype=np.float64)
    if is_safe(points):
        return points, 0
    bad = np.argwhere(~np.isfinite(points))
    if len(bad):
        raise InvalidGeometry(
            f"point {bad[0][0]} is {points[bad[0][0]].tolist()}; remove or repair it",
            parameter="points",
            points=np.unique(bad[:, 0]),
        )
    exponent = int(_safe_exponents(points.reshape(1, -1), "points")[0])
    return (np.ldexp(points, exponent) if exponent else points), exponent


def resolved(queries: np.ndarray) -> np.ndarray:
    """Places to be looked for among points that are safe: themselves where they are so too, else the nearest that are.

    Beyond the range of the predicates there are no points; below it coordinates are rounded to what they resolve.

    Examples
    --------
    >>> resolved(np.array([[0.5, 1e-300]]))
    array([[0.5, 0. ]])
    """
    if is_safe(queries):
        return queries
    queries = np.clip(queries, -(2.0**200), 2.0**200)
    tiny = np.abs(queries) < 2.0 ** (LOWEST_BIT + 53)
    queries[tiny] = np.ldexp(np.rint(np.ldexp(queries[tiny], -LOWEST_BIT)), LOWEST_BIT)
    return queries


def orient2d(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Which way the corners a, b, c turn, exactly.

    Parameters
    ----------
    a, b, c : (n, 2) float
        Points; single points are repeated.

    Returns
    -------
    signs : (n,) int8
        1 if counter-clockwise, -1 if clockwise, 0 if collinear.

    Raises
    ------
    InvalidInput
        If shapes do not fit, or coordinates of one test are too far apart in magnitude (more than about 1e109).
    InvalidGeometry
        If a coordinate is not finite.

    References
    ----------
    J. R. Shewchuk, "Adaptive precision floating-point arithmetic and fast robust geometric predicates", Discrete &
    Computational Geometry 18 (1997).

    Examples
    --------
    >>> orient2d([0, 0], [1, 1], [[0, 1], [1, 0], [3, 3]])
    array([ 1, -1,  0], dtype=int8)
    """
    return _signs(kernels.orient2d_signs, 2, a=a, b=b, c=c)


def incircle(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray) -> np.ndarray:
    """Whether d lies inside the circle through the counter-clockwise a, b, c, exactly.

    Parameters
    ----------
    a, b, c, d : (n, 2) float
        Points; single points are repeated.

    Returns
    -------
    signs : (n,) int8
        1 inside, -1 outside, 0 on the circle; the opposite if a, b, c are clockwise.

    Raises
    ------
    InvalidInput, InvalidGeometry
        As in `orient2d`.

    Examples
    --------
    >>> incircle([0, 0], [1, 0], [1, 1], [[0.5, 0.5], [2, 2], [0, 1]])
    array([ 1, -1,  0], dtype=int8)
    """
    return _signs(kernels.incircle_signs, 2, a=a, b=b, c=c, d=d)


def orient3d(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray) -> np.ndarray:
    """On which side of the plane through a, b, c the point d lies, exactly.

    Parameters
    ----------
    a, b, c, d : (n, 3) float
        Points; single points are repeated.

    Returns
    -------
    signs : (n,) int8
        1 if d is on the side of the right-hand normal of a, b, c (a tetrahedron in VTK's order), -1 if on the
        other, 0 if coplanar.

    Raises
    ------
    InvalidInput, InvalidGeometry
        As in `orient2d`.

    Examples
    --------
    >>> orient3d([0, 0, 0], [1, 0, 0], [0, 1, 0], [[0, 0, 1], [0, 0, -1], [5, 5, 0]])
    array([ 1, -1,  0], dtype=int8)
    """
    return _signs(kernels.orient3d_signs, 3, a=a, b=b, c=c, d=d)


def insphere(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray, e: np.ndarray) -> np.ndarray:
    """Whether e lies inside the sphere through the positively oriented tetrahedron a, b, c, d, exactly.

    Parameters
    ----------
    a, b, c, d, e : (n, 3) float
        Points; single points are repeated.

    Returns
    -------
    signs : (n,) int8
        1 inside, -1 outside, 0 on the sphere; the opposite if the tetrahedron is inverted.

    Raises
    ------
    InvalidInput, InvalidGeometry
        As in `orient2d`.

    Examples
    --------
    >>> insphere([0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [[0.5, 0.5, 0.5], [2, 2, 2], [1, 1, 1]])
    array([ 1, -1,  0], dtype=int8)
    """
    return _signs(kernels.insphere_signs, 3, a=a, b=b, c=c, d=d, e=e)


def _signs(kernel: Callable[..., None], dimension: int, **points: Any) -> np.ndarray:
    """Run a kernel over the tests; each test is rescaled on its own, since a scale does not change a sign."""
    columns = {name: _checked(name, p, dimension) for name, p in points.items()}
    try:
        together = np.broadcast_arrays(*columns.values())
    except ValueError:
        shapes = ", ".join(f"{name} {p.shape}" for name, p in columns.items())
        raise InvalidInput(f"numbers of points do not fit: {shapes}; give as many of each, or one") from None
    shape = together[0].shape[:-1]
    rows = np.concatenate(together, axis=-1).reshape(-1, dimension * len(points))
    exponents = _safe_exponents(rows, ", ".join(points))
    if exponents.any():
        rows = np.ldexp(rows, exponents[:, None])
    signs = np.zeros(len(rows), np.int8)
    kernel(np.ascontiguousarray(rows), signs, workspace())
    return signs.reshape(shape)


def _checked(name: str, points: Any, dimension: int) -> np.ndarray:
    try:
        points = np.asarray(points, dtype=np.float64)
    except (TypeError, ValueError):
        raise InvalidInput(f"needs numbers, as an (n, {dimension}) array", parameter=name) from None
    if points.shape[-1:] != (dimension,):
        raise InvalidInput(f"needs shape (n, {dimension}), got {points.shape}", parameter=name)
    bad = np.flatnonzero(~np.isfinite(points).all(axis=-1))
    if len(bad):
        value = points.reshape(-1, dimension)[bad[0]].tolist()
        raise InvalidGeometry(f"point {bad[0]} is {value}; remove or repair it", parameter=name, points=bad)
    return points


def _safe_exponents(rows: np.ndarray, parameter: str) -> np.ndarray:
    """(n,) int: for each row of numbers the exponent, mostly zero, whose power of two makes it safe."""
    mantissa, exponent = np.frexp(rows)
    whole = np.abs(np.ldexp(mantissa, 53)).astype(np.int64)
    last_bit = np.frexp((whole & -whole).astype(float))[1] - 1
    zero = rows == 0
    top = np.where(zero, -5000, exponent).max(axis=1, initial=-5000)
    bottom = np.where(zero, 5000, exponent - 53 + last_bit).min(axis=1, initial=5000)
    # Into [1/2, 1) if that keeps the last bits, else as much larger as they need.
    shift = np.maximum(-top, LOWEST_BIT - bottom)
    shift[((top <= HIGHEST_BIT) & (bottom >= LOWEST_BIT)) | zero.all(axis=1)] = 0
    bad = np.flatnonzero((top + shift > HIGHEST_BIT) & ~zero.all(axis=1))
    if len(bad):
        row = np.abs(rows[bad[0]])
        raise InvalidInput(
            f"coordinates of {row[row > 0].min():.3g} beside {row.max():.3g} are too far apart for exact arithmetic "
            f"(the limit is about 1e109); set the small ones to zero",
            parameter=parameter,
        )
    return shift
