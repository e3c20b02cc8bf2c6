"""Point sets on which triangulations go wrong: grids, circles, spheres, clumps, lines up to rounding, extreme scales.

Each function makes about ``n`` points in the plane or in space, as (m, d) float; `PLANE` and `SPACE` name them.
"""

from __future__ import annotations

import itertools

import numpy as np


def uniform(n, d, rng):
    """Nothing degenerate."""
    return rng.random((n, d))


def integer_grid(n, d, rng):
    """Whole coordinates: every cell cocircular, lines and planes of the hull full of points."""
    side = max(2, round(n ** (1 / d)))
    return np.stack(np.meshgrid(*[np.arange(float(side))] * d, indexing="ij"), axis=-1).reshape(-1, d)


def linspace_grid(n, d, rng):
    """A grid with rounded coordinates: nearly, not exactly, cocircular."""
    return integer_grid(n, d, rng) / (max(2, round(n ** (1 / d))) - 1)


def rotated_grid(n, d, rng):
    """A grid turned: rounded in all directions, the hull ragged by single bits."""
    turn, _ = np.linalg.qr(np.random.default_rng(3).normal(size=(d, d)))
    return linspace_grid(n, d, rng) @ turn


def shuffled_grid(n, d, rng):
    """The integer grid in random order: ties are decided by scattered numbers."""
    return rng.permutation(integer_grid(n, d, rng))


def sphere(n, d, rng):
    """On a circle or sphere, rounded."""
    direction = rng.normal(size=(n, d))
    return direction / np.linalg.norm(direction, axis=1, keepdims=True)


def clumps(n, d, rng):
    """A hundred clumps a millionth of the domain wide."""
    centres = rng.random((max(1, min(100, n // 4)), d))
    return centres[rng.integers(0, len(centres), n)] + 1e-6 * rng.normal(size=(n, d))


def slanted_line(n, d, rng):
    """On a line up to rounding: slivers across the whole set."""
    x = rng.random(n)
    return np.column_stack([x, 0.3 * x + 0.1, -0.7 * x + 0.2][:d])


def hexagonal_lattice(n, d, rng):
    """The densest packing: six points around each in the plane, twelve in space, octahedral holes in it."""
    whole = integer_grid(n, d, rng)
    if d == 2:
        return np.column_stack([whole[:, 0] + 0.5 * (whole[:, 1] % 2), whole[:, 1] * np.sqrt(0.75)])
    return whole[:, [1, 2, 0]] + whole[:, [2, 0, 1]] * [0.0, 1.0, -1.0]


def octahedra(n, d, rng):
    """Octahedra (squares on their corner in the plane) side by side, with their centres."""
    corners = np.concatenate([np.zeros((1, d)), np.eye(d), -np.eye(d)])
    centres = 3 * integer_grid(max(1, n // len(corners)), d, rng)
    return (centres[:, None] + corners).reshape(-1, d)


def duplicates(n, d, rng):
    """Each place about three times."""
    places = rng.random((max(d + 1, n // 3), d))
    return places[rng.integers(0, len(places), n)]


def two_lines(n, d, rng):
    """Two skew lines: in space every pair of intervals makes a tetrahedron, so the size is quadratic: keep n small."""
    x = np.arange(float(n // 2))
    zero = np.zeros_like(x)
    return np.concatenate([np.column_stack([x, zero, zero][:d]), np.column_stack([zero + 0.5, x + 1, zero + 1][:d])])


def tiny(n, d, rng):
    """Products of these coordinates underflow."""
    return 1e-300 * rng.random((n, d))


def huge(n, d, rng):
    """Products of these coordinates overflow."""
    return 1e300 * rng.uniform(-1, 1, (n, d))


def offset(n, d, rng):
    """Far from the origin: few bits are left for the differences."""
    return 1e8 + rng.random((n, d))


def stretched(n, d, rng):
    """Extents of very different size."""
    return rng.random((n, d)) * np.array([1.0, 1e-7, 1e-3])[:d]


_ALL = (
    uniform, integer_grid, linspace_grid, rotated_grid, shuffled_grid, sphere, clumps, slanted_line, hexagonal_lattice,
    octahedra, duplicates, tiny, huge, offset, stretched,
)  # fmt: skip
PLANE = {f.__name__: f for f in _ALL}
SPACE = {f.__name__: f for f in _ALL}


def small_lattice(cases, n, d, rng, side=3):
    """(cases, n, d) different points of a lattice of few sites, in random order: ties everywhere."""
    sites = np.array(list(itertools.product(range(side), repeat=d)), float)
    order = np.argsort(rng.random((cases, len(sites))), axis=1)[:, :n]
    return sites[order]


def small_repeated(cases, n, d, rng, side=3):
    """(cases, n, d) points of a lattice, some at one place."""
    return rng.integers(0, side, (cases, n, d)).astype(float)


def small_on_spheres(cases, n, d, rng):
    """(cases, n, d) points with whole coordinates on one circle or sphere of many lattice points, and its centre."""
    reach = np.arange(-8, 9)
    sites = np.array(list(itertools.product(reach, repeat=d)), float)
    sites = sites[(sites**2).sum(axis=1) == (65 if d == 2 else 26)]
    sites = np.concatenate([sites, np.zeros((1, d))])
    return sites[np.argsort(rng.random((cases, len(sites))), axis=1)[:, :n]]


def small_uniform(cases, n, d, rng):
    """(cases, n, d) with nothing degenerate."""
    return rng.integers(-400, 401, (cases, n, d)).astype(float)


def small_rounded(cases, n, d, rng):
    """(cases, n, d) lattice points, turned and rounded."""
    turn, _ = np.linalg.qr(rng.normal(size=(d, d)))
    return small_lattice(cases, n, d, rng) @ turn


def small_near_a_line(cases, n, d, rng):
    """(cases, n, d) points on a slanted line up to rounding."""
    return np.stack([slanted_line(n, d, rng) for _ in range(cases)])


SMALL = {
    f.__name__: f
    for f in (small_lattice, small_repeated, small_on_spheres, small_uniform, small_rounded, small_near_a_line)
}
