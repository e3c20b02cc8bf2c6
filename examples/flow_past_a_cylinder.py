"""What grids are for: potential flow past a cylinder, solved on an O-grid in the grid's indices (survey 2.2).

Laplace's equation for the stream function is transformed to the indices of the grid, differenced there in second and
in fourth order, and solved. The answer is known, so the error tells the order: it is the formulas', although the grid
is curved and its cells grow outwards. The pressure on the wall, 1 - 4 sin^2, follows from one-sided differences.
"""

import sys
from pathlib import Path

import numpy as np

import meshcore as mc
from meshcore import gallery
from meshcore.picture import picture
from meshcore.structured import Curvilinear

FAR, STRETCH = 4.0, 3.0
"""Radius of the far field in diameters, and logarithm of the last cell's height over the first's."""


def o_grid(layers):
    """An O-grid of a unit circle, the same mapping for any number of layers."""
    first = (FAR - 0.5) * 2 * np.expm1(STRETCH / layers) / np.expm1(STRETCH)
    return mc.o_grid(gallery.circle(3 * layers, radius=1.0), radius=FAR, first_height=first, layers=layers).mesh


def stream_function(points):
    """Of a uniform flow along x past the unit circle."""
    x, y, _ = np.moveaxis(points, -1, 0)
    return y - y / (x**2 + y**2)


def solved(grid, order):
    """The stream function, given on the wall and in the far field, and the speed."""
    operators = Curvilinear(grid, order=order)
    known = np.full(grid.shape, np.nan)
    known[:, 0], known[:, -1] = 0.0, stream_function(grid.points)[:, -1]
    stream = operators.poisson(0.0, known)
    return stream, np.linalg.norm(operators.gradient(stream), axis=-1)


def main(folder="out"):
    sizes = 24, 32, 48, 64
    for order in (2, 4):
        errors = []
        for layers in sizes:
            grid = o_grid(layers)
            stream, speed = solved(grid, order)
            wall = grid.points[:, 0, 0]
            pressure = 1 - speed[:, 0, 0] ** 2
            errors.append(
                [
                    np.sqrt(np.mean((stream - stream_function(grid.points)) ** 2)),
                    np.abs(pressure - (1 - 4 * wall[:, 1] ** 2)).max(),
                ]
            )
        for found in -np.polyfit(np.log(sizes), np.log(errors), 1)[0]:
            assert abs(found - order) < 0.2, f"the order is {found:.2f}, not {order}"
    grid = grid.with_point_data(stream=stream, speed=speed)
    lines = mc.io.from_pyvista(mc.io.to_pyvista(grid).contour(np.arange(-3.375, 3.5, 0.25), scalars="stream"))
    path = Path(folder) / "flow_past_a_cylinder.png"
    picture(grid, path, scalars="speed", over=[lines], edges=False, zoom=((-3, -2.25), (3, 2.25)))
    return grid.n_cells


if __name__ == "__main__":
    main(*sys.argv[1:])
