"""Points around a closed loop in the plane: where it turns, where its corners are, and a new spacing by curvature."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..errors import InvalidInput
from ..geometry.curves import arc_length, corners, turning
from ..geometry.spline import ShapeSpline

_BINS = 4096
_FINE = 16
"""Chords by which the length of a spline between two points is measured."""
_PARTS = 8
"""Pieces in which the turning at a point is spread over half an edge."""
_NEARLY_NONE, _HALVINGS = 1e-9, 40
"""A scale of bending that asks for no cell, and steps in which the scale that makes as many cells as given is found."""
_CORNER = np.radians(60)
"""Turn from which on the two sides of a place differ."""
_PASSES, _EXACT, _MOST = 8, 0.003, 4.0
"""Corrections of sizes at places, the relative error that is small enough, and the largest factor of them all."""


def smoothed_turning(fractions: np.ndarray, turn: np.ndarray, width: float) -> np.ndarray:
    """Density of turning over fractions of a loop's length, smoothed by a Gaussian.

    Parameters
    ----------
    fractions : (n,) float
        Where the points stand, from 0 up to less than 1.
    turn : (n,) float
        Weight of each point, such as its turning.
    width : float
        Standard deviation of the Gaussian, as a fraction of the loop.

    Returns
    -------
    (4096,) float
        Weight in each of equal bins centred on k / 4096, with the same sum as `turn`.

    Examples
    --------
    >>> density = smoothed_turning(np.array([0.0, 0.5]), np.array([1.0, 3.0]), 0.05)
    >>> print(density.sum().round(9))
    4.0
    """
    at = fractions * _BINS
    low = np.floor(at).astype(int)
    share = at - low
    density = np.zeros(_BINS)
    np.add.at(density, low % _BINS, turn * (1 - share))
    np.add.at(density, (low + 1) % _BINS, turn * share)
    frequency = np.fft.rfftfreq(_BINS, 1 / _BINS)
    return np.fft.irfft(np.fft.rfft(density) * np.exp(-0.5 * (2 * np.pi * width * frequency) ** 2), _BINS)


def accumulated(density: np.ndarray, fractions: np.ndarray) -> np.ndarray:
    """Share of a periodic density of `smoothed_turning` up to each fraction; it counts on beyond 0 and 1.

    Examples
    --------
    >>> accumulated(np.ones(4096), np.array([-0.25, 0.0, 0.5, 1.25]))
    array([-0.25,  0.  ,  0.5 ,  1.25])
    """
    steps = 0.5 * (density + np.roll(density, -1))
    total = np.concatenate([[0.0], np.cumsum(steps)]) / steps.sum()
    whole = np.floor(fractions)
    return whole + np.interp(fractions - whole, np.linspace(0, 1, _BINS + 1), total)


def respaced_loop(
    loop: np.ndarray,
    cells: int,
    *,
    bend: float = 0.5,
    width: float = 0.02,
    sizes: Sequence[tuple[float, float]] = (),
    growth: float = 1.2,
) -> np.ndarray:
    """A closed loop with another number of points: dense where it bends, every corner and the first point kept.

    Between corners the new points lie on a cubic spline through the old ones that does not wiggle.

    Parameters
    ----------
    loop : (n, 2) float
        Points in order; the last is joined to the first.
    cells : int
        Number of new points.
    bend : float
        Share of the points that follow the bending; the rest follow length.
    width : float
        Distance over which the spacing adjusts, as a fraction of the loop.
    sizes : sequence of (float, float)
        Places, as fractions of the length, and the sizes of cells there.
    growth : float
        Largest factor from cell to cell between corners.

    Returns
    -------
    (cells, 2) float

    Raises
    ------
    InvalidInput
        If there are fewer cells than stretches between corners, or than the sizes need.

    Examples
    --------
    >>> respaced_loop(np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]]), 8).round(6)[:4]
    array([[0. , 0. ],
           [0.5, 0. ],
           [1. , 0. ],
           [1. , 0.5]])
    """
    asked, given, best = list(sizes), list(sizes), (np.inf, None)
    for _ in range(_PASSES if asked else 1):
        try:
            new = _respaced(loop, cells, bend, width, given, growth)
        except InvalidInput:
            if best[1] is None:
                raise
            break
        lacking = [size / _size_at(new, _place(loop, at), size) for at, size in asked]
        worst = max((abs(x - 1) for x in lacking), default=0.0)
        if worst < best[0]:
            best = worst, new
        if worst < _EXACT:
            break
        given = [
            (at, float(np.clip(size * more, wanted / _MOST, wanted * _MOST)))
            for (at, size), (_, wanted), more in zip(given, asked, lacking, strict=True)
        ]
    return best[1] if asked else new


def _place(loop: np.ndarray, fraction: float) -> np.ndarray:
    """The point of a closed loop at a fraction of its length."""
    closed = np.vstack([loop, loop[:1]])
    length = arc_length(closed)
    return np.array([np.interp(fraction * length[-1], length, x) for x in closed.T])


def _size_at(loop: np.ndarray, place: np.ndarray, asked: float) -> float:
    """The mean length of the cells before and after the point of a loop that is nearest to a place.

    At a corner, whose other side may be a short edge, it is that of the cell that is nearer to what is asked.
    """
    k = int(np.argmin(np.linalg.norm(loop - place, axis=1)))
    before, after = loop[k] - loop[k - 1], loop[(k + 1) % len(loop)] - loop[k]
    sizes = np.linalg.norm([before, after], axis=1)
    turned = abs(np.arctan2(before[0] * after[1] - before[1] * after[0], before @ after))
    return float(min(sizes, key=lambda size: abs(np.log(size / asked))) if turned > _CORNER else sizes.mean())


def _respaced(
    loop: np.ndarray, cells: int, bend: float, width: float, sizes: Sequence[tuple[float, float]], growth: float
) -> np.ndarray:
    """The loop with sizes as they come out roughly: of arcs of the old loop, not of edges of the new one."""
    turn = turning(loop)
    corner = corners(turn)
    stops = np.unique(np.append(np.flatnonzero(corner), 0))
    if cells < max(3, len(stops)):
        raise InvalidInput(
            f"{cells} cells are too few for a loop with {len(stops)} corners; give more", parameter="around"
        )
    spline = LoopSpline(loop, stops, closed=not corner.any())
    fractions = spline.fractions
    density = smoothed_turning(*_spread(fractions[:-1], np.abs(turn), corner), width)
    density = bend * np.maximum(density, 0) / np.abs(turn).sum() + (1 - bend) / len(density)
    straight = arc_length(np.vstack([loop, loop[:1]]))
    sizes = [(float(np.interp(at * straight[-1], straight, fractions)), size / spline.length) for at, size in sizes]
    fine = _fine_fractions(sizes)
    share = _shares(density, fine, cells, sizes, growth)
    share[-1] = 1.0
    counts = _shared_out(cells, np.diff(np.interp(np.append(fractions[stops], 1.0), fine, share)))
    pieces = []
    for piece, (start, stop, count) in enumerate(zip(stops, np.append(stops[1:], len(loop)), counts, strict=True)):
        level = np.interp([fractions[start], fractions[stop]], fine, share)
        pieces.append(spline.piece(piece, np.interp(np.linspace(*level, count + 1)[:-1], share, fine)))
        pieces[-1][0] = loop[start]
    return np.concatenate(pieces)


class LoopSpline:
    """Splines from corner to corner of a loop, and places on them by their own lengths.

    Where a spline bends much between two points it is longer than its chord, and its parameter runs unevenly.

    Attributes
    ----------
    fractions : (n + 1,) float
        Of the whole length, at the loop's points.
    length : float
        The whole length.
    """

    def __init__(self, loop: np.ndarray, stops: np.ndarray, *, closed: bool):
        whole = np.vstack([loop, loop[:1]])
        self._splines = []
        places, lengths, offset = [], [], 0.0
        self.fractions = np.zeros(len(whole))
        for start, stop in zip(stops, np.append(stops[1:], len(loop)), strict=True):
            spline = ShapeSpline(whole[start : stop + 1], closed=closed)
            own = spline.length
            at = np.append((own[:-1, None] + np.diff(own)[:, None] * np.arange(_FINE) / _FINE).ravel(), own[-1])
            true = offset + arc_length(spline(at))
            self._splines.append(spline)
            places.append(at)
            lengths.append(true)
            self.fractions[start : stop + 1] = true[::_FINE]
            offset = float(true[-1])
        self.length = offset
        self.fractions /= offset
        self._tables = [(at, true / offset) for at, true in zip(places, lengths, strict=True)]

    def at(self, fractions: np.ndarray) -> np.ndarray:
        """(m, 2) float: points at fractions (m,) of the whole length, from 0 up to less than 1."""
        number = np.searchsorted([true[0] for _, true in self._tables], fractions, side="right") - 1
        found = np.empty((len(fractions), 2))
        for k in np.unique(number):
            found[number == k] = self.piece(int(k), fractions[number == k])
        return found

    def piece(self, number: int, fractions: np.ndarray) -> np.ndarray:
        """(m, 2) float: points of a piece at fractions (m,) of the whole length."""
        at, true = self._tables[number]
        return self._splines[number](np.interp(fractions, true, at))


def _fine_fractions(sizes: Sequence[tuple[float, float]]) -> np.ndarray:
    """Fractions from 0 to 1 of a table of density: one a bin, ever denser towards places of given size."""
    near = np.geomspace(1e-9, 0.1, 600)
    around = [np.concatenate([at - near, [at], at + near]) for at, _ in sizes]
    fine = np.concatenate([np.linspace(0, 1, _BINS + 1), *(ways % 1.0 for ways in around)])
    return np.unique(fine)


def _shares(density: np.ndarray, fine: np.ndarray, cells: int, sizes, growth: float) -> np.ndarray:
    """Share of the points up to each fraction: dense as asked, given sizes at some places, and growing by no more.

    The size of cells is the reciprocal of their density. Where sizes grow along the loop by no more than the logarithm
    of ``growth`` times the way, each cell is at most ``growth`` times as long as its neighbour: a limit of gradation
    (H. Borouchaki, F. Hecht, P. J. Frey, "Mesh gradation control", Int. J. Numer. Meth. Eng. 43 (1998)).
    """
    bins = np.linspace(0, 1, _BINS + 1)
    asked = np.interp(fine, bins, np.append(density, density[0])) * _BINS
    given = np.full(len(fine), np.inf)
    for at, size in sizes:
        given[np.argmin(np.abs(fine - at))] = size
    slope = np.log(growth) * fine

    def total(scale: float) -> np.ndarray:
        size = np.minimum(1 / (scale * asked), given)
        for _ in range(2):  # twice round the loop, both ways
            size[-1] = size[0] = min(size[0], size[-1])
            size = np.minimum.accumulate(size - slope) + slope
            size = np.minimum.accumulate((size + slope)[::-1])[::-1] - slope
        both = 1 / size
        return np.concatenate([[0.0], np.cumsum(0.5 * (both[1:] + both[:-1]) * np.diff(fine))])

    # What bends ask for is scaled until there are as many cells as given; the sizes alone need fewer.
    need = float(total(_NEARLY_NONE)[-1])
    if need > cells:
        raise InvalidInput(
            f"{cells} cells are too few for the spacing at the edges; give {np.ceil(need):.6g}", parameter="around"
        )
    low, high = _NEARLY_NONE, float(cells)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if total(middle)[-1] < cells else (low, middle)
    share = total(high)
    return share / share[-1]


def _spread(fractions: np.ndarray, turn: np.ndarray, sharp: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Places and weights of turning (n,) that is spread from its points over half of their edges, but at corners.

    A round on few points bends along its edges, and not at the points, as a spline through them shows.
    """
    edge = np.diff(np.append(fractions, 1.0 + fractions[0]))[:, None]
    part = (np.arange(_PARTS) + 0.5) / (2 * _PARTS)
    ahead, behind = fractions[:, None] + edge * part, fractions[:, None] - np.roll(edge, 1, axis=0) * part
    round_ = ~sharp
    weight = np.repeat(turn[round_] / (2 * _PARTS), 2 * _PARTS)
    at = np.hstack([ahead, behind])[round_].ravel() % 1.0
    return np.append(fractions[sharp], at), np.append(turn[sharp], weight)


def _shared_out(cells: int, weights: np.ndarray) -> np.ndarray:
    """Whole numbers of at least 1 that add up to ``cells``, whose shares of ``weights`` differ by the least factors.

    That is Huntington and Hill's method of equal proportions: ``c`` gives way to ``c + 1`` at their geometric mean, so
    that a short stretch, as a blunt edge, has cells as near to the length of its neighbours' as can be.
    """

    def rounded(divisor: float) -> np.ndarray:
        whole = np.floor(weights / divisor)
        return np.maximum(whole + (weights / divisor > np.sqrt(whole * (whole + 1))), 1).astype(int)

    low, high = 0.5 * weights.sum() / cells, weights.sum() * 2  # divisors that give too many, and one to each
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if rounded(middle).sum() <= cells else (middle, high)
    counts = rounded(high)
    while counts.sum() < cells:  # stretches of the same weight, of which not all can have one more
        counts[np.argmax(weights / np.sqrt(counts * (counts + 1)))] += 1
    return counts
