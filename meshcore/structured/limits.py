"""How large a structured grid may get: what would fill the memory is refused before it is made."""

from __future__ import annotations

import numpy as np

from ..errors import InvalidGeometry, InvalidInput
from ..mesh.extent import bounds

MAX_POINTS = 50_000_000
LARGEST, SMALLEST = 1e75, 1e-75
"""Extents beyond which products of areas would over- or underflow."""


def check_size(n_i: int, n_j: int, n_k: int = 1, *, parameter: str) -> None:
    """Refuse a grid of more than `MAX_POINTS` points.

    Parameters
    ----------
    n_i, n_j, n_k : int
        Points along i, j and k.
    parameter : str
        The number to make smaller, for the message.

    Raises
    ------
    InvalidInput
        If the grid would be too large.

    Examples
    --------
    >>> check_size(1001, 501, parameter="cells_i")
    """
    if n_i * n_j * n_k > MAX_POINTS:
        raise InvalidInput(
            f"would make {n_i * n_j * n_k:.3g} points; at most {MAX_POINTS:,} are allowed, so make it smaller",
            parameter=parameter,
        )


def check_extent(points: np.ndarray, *, parameter: str) -> float:
    """The diagonal of the bounding box of (n, 3) points, if arithmetic can do with it.

    Raises
    ------
    InvalidGeometry
        If coordinates or the extent are beyond `LARGEST` and `SMALLEST`, or all points are the same.

    Examples
    --------
    >>> check_extent(np.array([[0.0, 0, 0], [3, 4, 0]]), parameter="south")
    5.0
    """
    low, high = bounds(points)
    largest = float(np.maximum(-low, high).max())
    extent = float((high - low).max()) if largest < LARGEST else largest
    if extent == 0:
        raise InvalidGeometry("has all its points at one place; move them apart", parameter=parameter)
    if not SMALLEST < extent < LARGEST:
        raise InvalidGeometry(
            f"has an extent of {extent:.3g}; scale it to between {SMALLEST:g} and {LARGEST:g}", parameter=parameter
        )
    return float(np.linalg.norm(high - low))
