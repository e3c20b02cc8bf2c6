"""Heights of layers: as growth, number and distance ask for them, or as they are given."""

from __future__ import annotations

import math

import numpy as np

from ...errors import InvalidInput

MOST_LAYERS = 100_000


def layer_heights(
    first: float, growth: float, *, layers: int | None = None, distance: float | None = None, largest: float = math.inf
) -> np.ndarray:
    """Heights of layers that grow geometrically.

    Parameters
    ----------
    first : float
        Height of the first layer.
    growth : float
        Each height over the one before; with a distance but no number of layers the largest that is allowed.
    layers : int, optional
        Number of layers.
    distance : float, optional
        Sum of the heights. With a number of layers, growth follows from the two and `growth` is not used.
    largest : float
        Heights stay below.

    Returns
    -------
    (layers,) float

    Raises
    ------
    InvalidInput
        If no such heights exist. Heights that do not grow may be a little lower than `first`, to fill the distance.

    Examples
    --------
    >>> layer_heights(1, 2, layers=3), layer_heights(1, 2, layers=4, largest=3)
    (array([1., 2., 4.]), array([1., 2., 3., 3.]))
    >>> layer_heights(1, 3, distance=7).round(6)
    array([1., 2., 4.])
    >>> layer_heights(0.3, 1, distance=1)
    array([0.25, 0.25, 0.25, 0.25])
    """
    first, growth = float(first), float(growth)
    _check(first, growth, largest)
    if distance is None:
        return _heights(first, growth, _count(layers), largest)
    if not distance > 0 or not math.isfinite(distance):
        raise InvalidInput(f"must be greater than zero, got {distance:g}", parameter="distance")
    if layers is None:
        layers = _fewest(first, growth, distance, largest)
        if growth == 1 and layers > 1:
            return np.full(layers, distance / layers)  # what divides the distance: none higher than asked
    count = _count(layers)
    if count * first >= distance:
        if abs(count * first - distance) <= 1e-9 * distance:
            return np.full(count, distance / count)
        raise InvalidInput(
            f"{count} layers of {first:g} already reach past {distance:g}; make it smaller, or the distance larger",
            parameter="first_height",
        )
    low, high = 1.0, 3.0
    if _heights(first, high, count, largest).sum() < distance:
        raise InvalidInput(
            f"{count} layers from {first:g} on reach {distance:g} only with a growth above {high:g}; give more layers",
            parameter="layers",
        )
    for _ in range(200):
        middle = 0.5 * (low + high)
        short = _heights(first, middle, count, largest).sum() < distance
        low, high = (middle, high) if short else (low, middle)
    return _heights(first, high, count, largest)


def _heights(first: float, growth: float, count: int, largest: float) -> np.ndarray:
    with np.errstate(over="ignore"):  # infinite heights only tell that less growth is enough
        return np.minimum(first * growth ** np.arange(count), largest)


def _check(first: float, growth: float, largest: float) -> None:
    if not first > 0 or not math.isfinite(first):
        raise InvalidInput(f"must be greater than zero, got {first:g}", parameter="first_height")
    if not 1 <= growth <= 3:
        raise InvalidInput(f"must lie between 1 and 3, got {growth:g}", parameter="growth")
    if not largest >= first:
        raise InvalidInput(f"is {largest:g}, below the first height {first:g}", parameter="largest_height")


def _count(layers: int | None) -> int:
    if layers is None or layers != int(layers) or layers < 1:
        raise InvalidInput(f"needs a whole number of at least 1, got {layers}", parameter="layers")
    return int(layers)


def _fewest(first: float, growth: float, distance: float, largest: float) -> int:
    """The smallest number of layers that reaches a distance."""
    total, count, height = 0.0, 0, first
    while total < distance * (1 - 1e-9):
        total, count, height = total + min(height, largest), count + 1, height * growth
        if count > MOST_LAYERS:
            raise InvalidInput(
                f"{first:g} needs more than {MOST_LAYERS:,} layers to reach {distance:g}; let heights grow faster",
                parameter="growth",
            )
    return count


def checked_heights(heights: np.ndarray, n: int) -> np.ndarray:
    """(layers, 1 or n) heights of layers, or an error that says what is wrong with them."""
    heights = _real(heights)
    if heights.ndim not in (1, 2) or not heights.size or heights.shape[1:] not in ((), (1,), (n,)):
        raise InvalidInput(f"needs shape (layers,) or (layers, {n}), got {heights.shape}", parameter="heights")
    heights = np.ascontiguousarray(heights.reshape(len(heights), -1))
    if not (np.isfinite(heights) & (heights > 0)).all():
        raise InvalidInput("must be finite and greater than zero", parameter="heights")
    return heights


def _real(heights: np.ndarray) -> np.ndarray:
    """Heights as an array, if they are real numbers."""
    try:
        found = np.asarray(heights)
        if found.dtype.kind in "biuf":
            return found.astype(float)
    except ValueError:  # of rows of different lengths
        pass
    raise InvalidInput("needs real numbers", parameter="heights")
