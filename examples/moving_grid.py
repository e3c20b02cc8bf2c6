"""Convection on a grid that moves: the geometric conservation law (survey 1.1 and 2.2).

A cloud drifts through a square whose grid swings to and fro. The equation d(rho)/dt + div(rho U) = 0 in the grid's
indices has the grid's own velocity in it; with the rate of the Jacobian by the geometric conservation law a uniform
density stays uniform to round-off, and the cloud arrives in second or fourth order. Without the law the grid's
movement alone makes density from nothing.
"""

import sys
from pathlib import Path

import numpy as np

import meshcore as mc
from meshcore.picture import picture
from meshcore.structured import Curvilinear

DRIFT, START, WIDTH = np.array([0.3, 0.2, 0.0]), np.array([0.35, 0.4, 0.0]), 0.09


def swinging(n, t):
    """The grid at a time, and the velocity of its points; the boundary rests."""
    u, v = np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1), indexing="ij")
    bend = np.sin(np.pi * u) * np.sin(np.pi * v)
    shift = np.stack([0.08 * bend * np.cos(np.pi * v), 0.12 * bend, 0 * u], axis=-1)
    points = np.stack([u, v, 0 * u], axis=-1) + np.sin(2 * np.pi * t) * shift
    return mc.StructuredGrid(points), 2 * np.pi * np.cos(2 * np.pi * t) * shift[:, :, None]


def cloud(points, t):
    """The density that drifts along, over a background of 1."""
    return 1 + np.exp(-((points - START - t * DRIFT) ** 2).sum(axis=-1) / (2 * WIDTH**2))


def rate(density, n, t, order, law=True):
    """Rate of the density at the moving points, which is none on the boundary."""
    grid, moving = swinging(n, t)
    flow = np.broadcast_to(DRIFT, grid.points.shape)
    operators = Curvilinear(grid, order=order)
    found = operators.convection(density, flow, grid_velocity=moving)
    if not law:
        found += density * operators.divergence(moving)
    found[[0, -1]] = found[:, [0, -1]] = 0
    return found


def advanced(density, n, order, law=True, end=1.0):
    """The density at the end, by steps of Runge and Kutta's of fourth order."""
    steps = round(2 * n * end)
    h = end / steps
    for k in range(steps):
        t = k * h
        a = rate(density, n, t, order, law)
        b = rate(density + h / 2 * a, n, t + h / 2, order, law)
        c = rate(density + h / 2 * b, n, t + h / 2, order, law)
        d = rate(density + h * c, n, t + h, order, law)
        density = density + h / 6 * (a + 2 * b + 2 * c + d)
    return density


def main(folder="out"):
    uniform = np.ones(swinging(16, 0)[0].shape)
    assert np.abs(advanced(uniform, 16, 4) - 1).max() < 1e-12
    assert np.abs(advanced(uniform, 16, 4, law=False) - 1).max() > 1e-3
    sizes = 24, 32, 48
    for order in (2, 4):
        errors = []
        for n in sizes:
            start, end = swinging(n, 0)[0].points, swinging(n, 1)[0].points
            density = advanced(cloud(start, 0), n, order)
            errors.append(np.abs(density - cloud(end, 1)).max())
        found = -np.polyfit(np.log(sizes), np.log(errors), 1)[0]
        assert abs(found - order) < 0.4, f"the order is {found:.2f}, not {order}"
    density = advanced(cloud(start, 0), n, 4, end=0.25)
    picture(swinging(n, 0.25)[0], Path(folder) / "moving_grid.png", scalars=density, window=(1000, 850))
    return n * n


if __name__ == "__main__":
    main(*sys.argv[1:])
