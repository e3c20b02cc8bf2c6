"""The cure of overspill: sides with other parameters, lines of constraint inside, elliptic smoothing (survey 2.4.1).

A remedy takes a patch and its folded points, and returns them with fewer folds, if it can, and what it did. Remedies
follow one another, each going on from what the one before reached.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Literal

import numpy as np

from ...errors import InvalidGeometry
from ...geometry.curves import resampled
from ...geometry.plane import fitted_plane
from ..folds import folded_cells
from ..poisson.barrier import unfolded
from ..poisson.winslow import orientation, smoothed_grid
from .blending import Patch
from .interior_lines import bent
from .sides import fractions_of

Cure = Literal["none", "sides", "lines", "smoothing", "automatic"]
Remedy = Callable[[Patch, np.ndarray], tuple[Patch, np.ndarray, str]]
OPPOSITE = (("south", "north"), ("west", "east"))
SAMPLES = 129
"""Points on each of two sides that are matched with one another."""
CORNER = np.radians(20)
"""Turn of a side from which on a point of it is a corner."""
STIFF = 0.25
"""What a step of a match along one of two sides alone costs: without it, corners draw whole sides to themselves."""
SHARES = (0.25, 0.5, 0.75, 0.9)
"""How far points are moved towards their match; at 1 cells could become flat."""
MOST_LINES = 4
PLACES = 9
"""How many places across the folds are tried for a line."""
BENDS = (0.0, 0.5, 1.0, 1.6)
"""Lengths of a line's end slopes, at right angles with the sides, in lengths of its chord; 0 makes it straight."""


def cured(patch: Patch, points: np.ndarray, cure: Cure) -> tuple[Patch, np.ndarray, list[str]]:
    """The points of a patch with fewer folded cells, none if that can be had, and what was done.

    Parameters
    ----------
    patch : Patch
        What the points were interpolated from.
    points : (ni, nj, 3) float
        With folded cells.
    cure : {"none", "sides", "lines", "smoothing", "automatic"}
        Which remedy; "automatic" takes all in turn until no fold is left.
    """
    done = []
    bound = bool(patch.lines_i or patch.lines_j or patch.slopes is not None)
    for name, remedy in REMEDIES.items():
        if name == "smoothing" and bound:
            continue  # lines and slopes that were given would not be kept
        if cure in (name, "automatic") and _folds(points):
            patch, points, what = remedy(patch, points)
            done += [what] if what else []
    return patch, points, done


def _folds(points: np.ndarray) -> int:
    return int(folded_cells(points).sum())


def reparameterised(patch: Patch, points: np.ndarray) -> tuple[Patch, np.ndarray, str]:
    """Points of opposite sides moved along them, towards the places that are nearest to each other.

    Lines inside keep a patch's sides as they are.
    """
    if patch.lines_i or patch.lines_j:
        return patch, points, ""
    best, fewest, what = (patch, points), _folds(points), ""
    normal = _normal(patch)
    matched = {
        ("south", "north"): matching(patch.south, patch.north, normal),
        ("west", "east"): matching(patch.west, patch.east, -normal),
    }
    for pairs in (OPPOSITE[:1], OPPOSITE[1:], OPPOSITE):
        for share in SHARES:
            sides = {name: side for pair in pairs for name, side in _moved(patch, pair, matched[pair], share).items()}
            moved = replace(patch, **sides)
            new = moved.points()
            folds = _folds(new)
            if folds < fewest:
                best, fewest = (moved, new), folds
                names = " and ".join(name for p in pairs for name in p)
                what = f"overspill: points of {names} were moved along them"
            if not fewest:
                return *best, what
    return *best, what


def _normal(patch: Patch) -> np.ndarray:
    """Unit normal of a patch, or of the plane that is nearest to it."""
    loop = np.concatenate([patch.south[:-1], patch.east[:-1], patch.north[:0:-1], patch.west[:0:-1]])
    area = np.cross(loop - loop[0], np.roll(loop, -1, axis=0) - loop[0]).sum(axis=0)
    size = float(np.linalg.norm(area))
    return area / size if size else area


def _moved(patch: Patch, pair: tuple[str, str], matched: np.ndarray, share: float) -> dict[str, np.ndarray]:
    """Two opposite sides with their points moved along them, by a share of the way to their match."""
    low, high = (getattr(patch, name) for name in pair)
    at_low, at_high = fractions_of(low), fractions_of(high)
    middle = 0.5 * (at_low + at_high)
    shift = np.interp(middle, np.linspace(0, 1, len(matched)), matched)
    to_low, to_high = middle + shift, middle - shift
    return {
        pair[0]: resampled(low, _kept_corners(low, at_low, (1 - share) * at_low + share * to_low)),
        pair[1]: resampled(high, _kept_corners(high, at_high, (1 - share) * at_high + share * to_high)),
    }


def _kept_corners(side: np.ndarray, fractions: np.ndarray, moved: np.ndarray) -> np.ndarray:
    """Moved fractions with points at the corners of a side, which is its outline still."""
    moved = np.maximum.accumulate(moved)
    along = np.diff(side, axis=0)
    along /= np.linalg.norm(along, axis=1)[:, None]
    corners = 1 + np.flatnonzero((along[1:] * along[:-1]).sum(axis=1) < np.cos(CORNER))
    stations: list[int] = []
    wanted: list[float] = []
    for corner in corners:
        near = int(np.argmin(np.abs(moved - fractions[corner])))
        if max(stations, default=0) < near < len(moved) - 1:
            stations.append(near)
            wanted.append(fractions[corner])
    return bent(moved, stations, wanted, 0.0)


def matching(a: np.ndarray, b: np.ndarray, upwards: np.ndarray) -> np.ndarray:
    """How two polylines are best matched, point to point in order: half the difference of their fractions of length.

    Of all monotone walks along both (dynamic time warping), that whose matches leave both lines as nearly straight
    inwards as can be: with the least sum of squares of ``2 - cos - cos`` of their angles with the two normals.

    Parameters
    ----------
    a, b : (n, 3) float
        Polylines.
    upwards : (3,) float
        Unit normal of the surface between them, on the side from which b is to the left of a.

    Returns
    -------
    (k,) float
        Of the match whose mean fraction is m, how far its fraction on ``a`` is above m, for even steps of m.

    Examples
    --------
    >>> x = np.linspace(0, 1, 5)[:, None] * [1.0, 0, 0]
    >>> print(np.abs(matching(x, x + [0, 1, 0], np.array([0, 0, 1]))).max())
    0.0
    """
    even = np.linspace(0, 1, SAMPLES)
    p, q = resampled(a, even), resampled(b, even)
    across = q[None] - p[:, None]
    length = np.maximum(np.linalg.norm(across, axis=-1), np.finfo(float).tiny)
    slant = np.zeros((SAMPLES, SAMPLES))
    for line, axis in ((p, 1), (q, 0)):
        left = np.cross(upwards, np.gradient(line, axis=0))
        left /= np.maximum(np.linalg.norm(left, axis=1), np.finfo(float).tiny)[:, None]
        slant += 1 - (across * np.expand_dims(left, axis)).sum(axis=-1) / length
    distance = (slant**2).tolist()
    cost = [[0.0] * SAMPLES for _ in even]
    for i in range(SAMPLES):
        for j in range(SAMPLES):
            # A step along both goes twice as far as one along either.
            ways = [cost[i - 1][j - 1] + distance[i][j]] if i and j else []
            ways += [cost[i - 1][j] + STIFF] if i else []
            ways += [cost[i][j - 1] + STIFF] if j else []
            cost[i][j] = distance[i][j] + min(ways, default=0.0)
    i = j = SAMPLES - 1
    walk = [(i, j)]
    while i or j:
        ways = [(cost[i - 1][j - 1] + distance[i][j], i - 1, j - 1)] if i and j else []
        ways += [(cost[i - 1][j] + STIFF, i - 1, j)] if i else []
        ways += [(cost[i][j - 1] + STIFF, i, j - 1)] if j else []
        _, i, j = min(ways)
        walk.append((i, j))
    steps = np.array(walk[::-1]) / (SAMPLES - 1)
    return np.interp(np.linspace(0, 1, 2 * SAMPLES - 1), steps.mean(axis=1), 0.5 * (steps[:, 0] - steps[:, 1]))


def constrained(patch: Patch, points: np.ndarray) -> tuple[Patch, np.ndarray, str]:
    """Lines inside, across the folds, between opposite sides; as few as do, at most four."""
    fewest, what = _folds(points), ""
    best = patch, points
    for count in range(1, MOST_LINES + 1):
        start = best[0]
        for line in _candidates(start, best[1]):
            new = line.points()
            folds = _folds(new)
            if folds < fewest:
                best, fewest = (line, new), folds
                what = f"overspill: {count} line{'s' * (count > 1)} of constraint inside the patch"
            if not fewest:
                return *best, what
        if best[0] is start:
            break
    return *best, what


def _candidates(patch: Patch, points: np.ndarray) -> Iterator[Patch]:
    """The patch with one more line, at various places and of various forms."""
    cells = np.argwhere(folded_cells(points))
    for axis, name in enumerate(("lines_i", "lines_j")):
        known = getattr(patch, name)
        grid = np.moveaxis(points, axis, 0)
        if patch.lines_j if axis == 0 else patch.lines_i:  # a new line would have to cross those
            continue
        low, high = cells[:, axis].min(), cells[:, axis].max() + 1
        for station in np.unique(np.linspace(low, high, PLACES).round().astype(int)):
            if 0 < station < len(grid) - 1 and station not in known:
                for bend in BENDS:
                    yield replace(patch, **{name: {**known, int(station): _arched(grid, int(station), bend)}})


def _arched(grid: np.ndarray, station: int, bend: float) -> np.ndarray:
    """A cubic between two sides that leaves both at right angles, spaced as the sides beside it are."""
    share = station / (len(grid) - 1)
    at = ((1 - share) * fractions_of(grid[0]) + share * fractions_of(grid[-1]))[:, None]
    start, stop = grid[station, 0], grid[station, -1]
    chord = stop - start
    if not bend:
        line = start + at * chord
    else:
        leaving = [bend * _turned(chord, grid[station + 1, end] - grid[station - 1, end]) for end in (0, -1)]
        line = start + at**2 * (3 - 2 * at) * chord
        line = line + at * (1 - at) ** 2 * leaving[0] - at**2 * (1 - at) * leaving[1]
    line[0], line[-1] = start, stop
    return line


def _turned(chord: np.ndarray, tangent: np.ndarray) -> np.ndarray:
    """A chord turned to right angles with a tangent, if it can be; as long as it was."""
    square = float(tangent @ tangent)
    normal = chord - (chord @ tangent) / square * tangent if square else chord
    size = float(np.linalg.norm(normal))
    return normal * (np.linalg.norm(chord) / size) if size else chord


def smoothed(patch: Patch, points: np.ndarray) -> tuple[Patch, np.ndarray, str]:
    """The Laplace grid between the sides of a planar patch, its last folds unfolded."""
    flat_rows = points.reshape(-1, 3)
    try:
        plane = fitted_plane(flat_rows)
    except InvalidGeometry:
        return patch, points, ""
    flat = plane.to_plane(flat_rows).reshape(*points.shape[:2], 2)
    new = points.copy()
    inside = unfolded(smoothed_grid(flat), orientation(flat))[1:-1, 1:-1]
    new[1:-1, 1:-1] = plane.to_space(inside.reshape(-1, 2)).reshape(*inside.shape[:2], 3)
    if _folds(new) >= _folds(points):
        return patch, points, ""
    return patch, new, "overspill: the grid was smoothed by the Laplace equations"


REMEDIES: dict[str, Remedy] = {"sides": reparameterised, "lines": constrained, "smoothing": smoothed}
"""In the order in which "automatic" tries them."""
