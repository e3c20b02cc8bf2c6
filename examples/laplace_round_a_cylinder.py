"""Laplace's equation round a cylinder on O-, C- and H-grids: one formula inside and through the cuts (survey 2.8.1).

The answer is known, the stream function of the flow past the cylinder, so the error tells the order: that of the
formulas on all three. On the C-grid lines run on through the wake in the other direction, on the H-grid from one block
to the other. Where the round wall meets a cut the C- and the H-grid are singular; around these points, marked,
values are given, as on the boundary.
"""

import sys
from pathlib import Path

import numpy as np

import meshcore as mc
from meshcore import Cut, Mesh, MultiBlock, StructuredGrid, gallery
from meshcore.picture import picture
from meshcore.structured import Curvilinear
from meshcore.structured.operators.joined_lines import on_boundary

SINGULAR = 1.6
"""Up to so far from singular points values are given."""


def o_type(n):
    """What meshcore makes, closed by a cut like the others'."""
    first = 5.0 * np.expm1(2.5 / n) / np.expm1(2.5)
    grid, _ = mc.o_grid(gallery.circle(4 * n, radius=1.0), radius=3, first_height=first, layers=n)
    return MultiBlock((StructuredGrid(grid.points),), cuts=grid.joins), []


def c_type(n):
    """The lines of w = s + i t with z + 1/z = w^2 - 2, bent: the cylinder is |s| < 2, t = 0, the wake beyond it."""
    s, t = 2.0 / n * np.arange(-2 * n, 2 * n + 1)[:, None], np.linspace(0, 1.5, n + 1)
    w = s * (1 + 0.02 * (s**2 - 4 - t**2)) + 1j * t * (1 + 0.02 * (0.3 * t**2 + s**2))
    z = outside(w**2 - 2, np.where(s < 0, -1, 1))
    z[3 * n :, 0] = z[n::-1, 0]
    cut = Cut(((0, 0, 0), (n, 0, 0)), ((4 * n, 0, 0), (3 * n, 0, 0)), (-1, -2, 3), name="wake")
    return MultiBlock((in_plane(z),), cuts=(cut,)), [1.0]


def h_type(n):
    """The lines of z + 1/z = p + i q, bent, above and below: the cylinder is |p| < 2, q = 0."""
    p, q = 2.0 / n * np.arange(-2 * n, 2 * n + 1)[:, None], np.linspace(0, 3, n + 1)
    zeta = p * (1 + 0.02 * (p**2 - 4 - q**2)) + 1j * q * (1 + 0.02 * (0.3 * q**2 + p**2))
    above = outside(zeta, 1)
    cuts = [Cut(((a, n, 0), (a + n, n, 0)), ((a, 0, 0), (a + n, 0, 0)), (1, 2, 3), 0, 1) for a in (0, 3 * n)]
    return MultiBlock((in_plane(above.conj()[:, ::-1]), in_plane(above)), ("below", "above"), tuple(cuts)), [-1.0, 1.0]


def outside(zeta, side):
    """The z outside the unit circle with z + 1/z = zeta; on the slit the circle itself, above or below."""
    z = 0.5 * (zeta + np.sqrt(zeta - 2 + 0j) * np.sqrt(zeta + 2 + 0j))
    straight, slit = np.abs(zeta.imag) < 1e-12, np.abs(zeta.real) < 2 - 1e-9
    z = np.where(straight & slit, np.exp(1j * side * np.arccos(np.clip(zeta.real / 2, -1, 1))), z)
    return np.where(straight & ~slit, z.real, z)


def in_plane(z):
    return StructuredGrid(np.stack([z.real, z.imag], axis=-1))


def stream_function(points):
    """Of a uniform flow along x past the unit circle."""
    x, y, _ = np.moveaxis(points, -1, 0)
    return y - y / (x**2 + y**2)


def known(blocks, singular):
    """The answer on the boundary and near singular points, nan elsewhere."""
    values = []
    for block, given in zip(blocks.blocks, on_boundary([b.shape for b in blocks.blocks], blocks.cuts), strict=True):
        x, y, _ = np.moveaxis(block.points, -1, 0)
        near = [np.hypot(x - place, y) < SINGULAR for place in singular]
        values.append(np.where(np.any([given, *near], axis=0), stream_function(block.points), np.nan))
    return values


def solved(blocks, singular, order):
    """The stream function, and the root mean square of its error."""
    found = Curvilinear(blocks, order).poisson(0.0, known(blocks, singular))
    error = [f - stream_function(block.points) for f, block in zip(found, blocks.blocks, strict=True)]
    return found, np.sqrt(np.mean(np.concatenate([e.ravel() for e in error]) ** 2))


def draw(blocks, singular, found, path):
    """Grid and stream lines."""
    drawn = [block.with_point_data(stream=f) for block, f in zip(blocks.blocks, found, strict=True)]
    levels = np.arange(-2.875, 3, 0.25)
    lines = [mc.io.from_pyvista(mc.io.to_pyvista(b).contour(levels, scalars="stream")) for b in drawn]
    marks = [Mesh([[x, 0, 0.0] for x in singular], {"vertex": [[k] for k in range(len(singular))]})] if singular else []
    picture(MultiBlock(tuple(drawn)), path, zoom=((-4, -3), (4, 3)), over=[*lines, *marks])


def main(folder="out"):
    sizes, cells = (20, 28, 40), 0
    for name, make in (("o", o_type), ("c", c_type), ("h", h_type)):
        for order in (2, 4):
            errors = []
            for n in sizes:
                blocks, singular = make(n)
                stream, error = solved(blocks, singular, order)
                errors.append(error)
            falls = -np.polyfit(np.log(sizes), np.log(errors), 1)[0]
            assert falls > order - 0.3, f"on the {name}-grid the order is {falls:.2f}, not {order}"
        draw(blocks, singular, stream, Path(folder) / f"laplace_{name}_grid.png")
        cells += blocks.n_cells
    return cells


if __name__ == "__main__":
    main(*sys.argv[1:])
