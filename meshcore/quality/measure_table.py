"""What is known of one measure for one kind of cell."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

SMALLER_IS_BETTER = frozenset(
    {
        "aspect_frobenius",
        "aspect_gamma",
        "aspect_ratio",
        "condition",
        "edge_jump",
        "equiangle_skew",
        "face_skewness",
        "growth_i",
        "growth_j",
        "growth_k",
        "line_growth",
        "max_angle",
        "max_aspect_frobenius",
        "max_edge_ratio",
        "med_aspect_frobenius",
        "non_orthogonality",
        "oddy",
        "radius_ratio",
        "size_jump",
        "skew",
        "taper",
    }
)
"""Names of the measures whose large values are bad; of all others it is the small values."""


@dataclass(frozen=True)
class Measure:
    """One measure of one kind of cell.

    Attributes
    ----------
    function : callable
        (m, k, 3) float corner coordinates of the cells -> (m,) float.
    acceptable : tuple of two float
        Range of well-shaped cells, both ends included.
    unit : str
        "degree", "length", "area", "volume", or empty for a pure number.
    """

    function: Callable[[np.ndarray], np.ndarray]
    acceptable: tuple[float, float]
    unit: str = ""


def relative_size(size: np.ndarray, mean: float | None = None) -> np.ndarray:
    """(m,) float: min(s, 1 / s)^2 with s the size of each cell over the mean; 0 for cells without size.

    Examples
    --------
    >>> relative_size(np.array([1.0, 3.0]))
    array([0.25      , 0.44444444])
    """
    mean = size.mean() if mean is None else mean
    if not mean > 0:
        return np.zeros(len(size))
    ratio = np.maximum(size / mean, 0.0)
    with np.errstate(divide="ignore"):
        return np.minimum(ratio, 1 / ratio) ** 2
