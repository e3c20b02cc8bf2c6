"""Curved grids with known mappings, model functions on them, and orders of convergence, for tests and benchmarks."""

from __future__ import annotations

import numpy as np

from meshcore import StructuredGrid


def smooth(u, v, w):
    """A bent square: no line is straight, no angle right."""
    x = u + 0.08 * np.sin(2 * np.pi * u) * np.sin(np.pi * v + 0.4)
    y = v + 0.1 * np.sin(np.pi * u) * np.cos(2 * np.pi * v + 0.3)
    return np.stack([x, y, 0 * u], axis=-1)


def stretched(u, v, w):
    """A square whose cells grow geometrically, the last e^1.5 times as large as the first."""
    return np.stack([np.expm1(1.5 * u) / np.expm1(1.5), np.expm1(1.5 * v) / np.expm1(1.5), 0 * u], axis=-1)


def skewed(u, v, w, angle=45.0):
    """A rhombus whose lines meet at an angle in degrees, cells growing a little."""
    a, b = (np.expm1(0.5 * t) / np.expm1(0.5) for t in (u, v))
    angle = np.radians(angle)
    return np.stack([a + b * np.cos(angle), b * np.sin(angle), 0 * u], axis=-1)


def annulus(u, v, w):
    """Between radii 1 and 2, the radii growing geometrically; u runs clockwise around and is closed."""
    r, t = 2.0**v, -2 * np.pi * u
    return np.stack([r * np.cos(t), r * np.sin(t), 0 * u], axis=-1)


def sphere(u, v, w):
    """A patch of the unit sphere."""
    a, b = 0.4 + 1.2 * u + 0.1 * np.sin(np.pi * v), 0.3 + 1.5 * v + 0.1 * np.sin(np.pi * u)
    return np.stack([np.sin(a) * np.cos(b), np.sin(a) * np.sin(b), np.cos(a)], axis=-1)


def bent_box(u, v, w):
    """A box that is bent in all directions."""

    def s(a, b, c):
        return 0.06 * np.sin(np.pi * a + 1) * np.cos(np.pi * b) * np.sin(np.pi * c + 0.5)

    return np.stack([u + s(u, v, w), v + s(v, w, u), w + s(w, u, v)], axis=-1)


def shell(u, v, w):
    """A twisted cylindrical shell; u runs around and is closed."""
    r, t = 1 + v + 0.1 * np.sin(np.pi * w), 2 * np.pi * u + 0.4 * w
    return np.stack([r * np.cos(t), r * np.sin(t), w + 0.05 * np.cos(t) * v], axis=-1)


def passage(u, v, w):
    """A box that is twisted and bent along w."""
    a = 0.6 * w
    x, y = u * np.cos(a) - v * np.sin(a) + 0.2 * w**2, u * np.sin(a) + v * np.cos(a)
    return np.stack([x, y, w + 0.1 * u], axis=-1)


VOLUMES, CLOSED = (bent_box, shell, passage), (annulus, shell)


def grid(mapping, n):
    """The mapping's grid of n cells a direction, three times as many around."""
    volume, closed = mapping in VOLUMES, mapping in CLOSED
    t = np.linspace(0, 1, n + 1)
    around = np.linspace(0, 1, 3 * n + 1) if closed else t
    points = mapping(*np.meshgrid(around, t, t if volume else np.zeros(1), indexing="ij"))
    if closed:
        points[-1] = points[0]
    return StructuredGrid(points, periodic=(closed, False, False))


def model(points):
    """A function, its gradient, and its Laplacian."""
    x, y, z = np.moveaxis(points, -1, 0)
    a, e = x + 0.3, np.exp(0.5 * y)
    value = np.sin(a) * e * np.cos(z)
    slope = np.stack([np.cos(a) * e * np.cos(z), 0.5 * value, -np.sin(a) * e * np.sin(z)], axis=-1)
    return value, slope, -1.75 * value


def planar_model(points):
    """The same where z = 0 and nothing depends on it."""
    value, slope, _ = model(points * [1, 1, 0])
    return value, slope, -0.75 * value


def cell_means(mapping, function, cells):
    """Means of a function over the mapping's cells, by Gauss points: (cells, cells, cells or 1, ...) float."""
    volume = mapping in VOLUMES
    at, weights = np.polynomial.legendre.leggauss(3)
    along = [3 * cells if mapping in CLOSED else cells, cells, cells]
    ats = [((np.arange(m)[:, None] + 0.5 + 0.5 * at) / m).ravel() for m in along]
    u = np.meshgrid(*ats[:2], ats[2] if volume else np.zeros(1), indexing="ij")
    w = [np.tile(weights, m) for m in along]
    step = 1e-4

    def slope(k):
        return (
            mapping(*(t + step * (j == k) for j, t in enumerate(u)))
            - mapping(*(t - step * (j == k) for j, t in enumerate(u)))
        ) / (2 * step)

    normal = np.cross(slope(0), slope(1))
    jacobian = (normal * slope(2)).sum(axis=-1) if volume else np.linalg.norm(normal, axis=-1)
    weight = jacobian * np.einsum("i,j,k->ijk", *w[:2], w[2] if volume else np.ones(1))

    def summed(values):
        split = (along[0], 3, along[1], 3, *((along[2], 3) if volume else (1, 1)))
        return values.reshape(*split, *values.shape[3:]).sum(axis=(1, 3, 5))

    values = function(mapping(*u))
    whole = summed(weight)
    weight, whole = (w.reshape(w.shape + (1,) * (values.ndim - 3)) for w in (weight, whole))
    return summed(weight * values) / whole


def rms(values):
    """Root of the mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def order(cells, errors):
    """Exponent p of error = c cells^-p, by least squares of logarithms."""
    return float(-np.polyfit(np.log(cells), np.log(errors), 1)[0])


def inside(values):
    """The middle half of a grid's points or cells along each direction, away from one-sided differences."""
    return values[tuple(slice(n // 4, n - n // 4) if n > 1 else slice(None) for n in values.shape[:3])]
