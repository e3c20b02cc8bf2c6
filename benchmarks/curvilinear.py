"""Operators on curved grids: orders of truncation and of solutions, uniform flow, and time a point.

``python benchmarks/curvilinear.py [--quick] [--repeats 5]``
"""

from __future__ import annotations

import numpy as np
from _common import Target, arguments, of_turns, print_claim, print_heading, print_row, taken_alternately

from meshcore import StructuredGrid
from meshcore.structured import Curvilinear, FiniteVolumes
from tests import curved_grids as curved
from tests.curved_grids import cell_means, inside, model, order, planar_model, rms

MAPPINGS = (curved.smooth, curved.stretched, curved.skewed, curved.annulus, curved.passage)
NAMES = "gradient", "divergence", "Laplacian"
ORDER = {2: "2.0 +- 0.1", 4: "4.0 +- 0.2"}
FREESTREAM = Target(1e-12, at_most=True)


def verdict(p: int, found: float) -> str:
    """The order beside its target."""
    return f"**{found:.2f}** ({ORDER[p]} {'met' if abs(found - p) <= p / 20 else 'MISSED'})"


def fields(mapping, n: int, means: bool):
    """A function, its gradient and Laplacian, a vector field and its divergence: at points, or their means."""
    planar = mapping not in curved.VOLUMES
    functions = planar_model if planar else model
    direction = np.array([1.0, -0.5, 0.0 if planar else 0.7])
    points = curved.grid(mapping, n).points
    value, slope, laplacian = (
        cell_means(mapping, lambda p, k=k: functions(p)[k], n) if means else functions(points)[k] for k in range(3)
    )
    return value, slope, laplacian, value[..., None] * direction, slope @ direction


def truncation(p: int, quick: bool) -> None:
    """Orders of truncation in the middle half of the grid, and with its ends."""
    print_heading(
        f"Truncation of order {p}",
        "Root mean square errors over four sizes; in the middle half, and with the one-sided ends in brackets.",
    )
    print_row("values", "grid", "cells", *(f"{name}: order, error" for name in NAMES), head=True)
    for operators, means in ((Curvilinear, False), (FiniteVolumes, True)):
        for mapping in MAPPINGS:
            flat = (32, 48, 64, 80) if quick or means else (64, 96, 128, 192)
            solid = (10, 12, 16, 20) if means else (24, 32, 40, 48)
            sizes = solid if mapping in curved.VOLUMES else flat
            errors = []
            for n in sizes:
                value, slope, laplacian, vectors, divergence = fields(mapping, n, means)
                made = operators(curved.grid(mapping, n), order=p)
                found = (
                    made.gradient(value) - slope,
                    made.divergence(vectors) - divergence,
                    made.laplacian(value) - laplacian,
                )
                errors.append([(rms(inside(e)), rms(e)) for e in found])
            e = np.array(errors)
            cells = [
                f"{verdict(p, order(sizes, e[:, k, 0]))} [{order(sizes, e[:, k, 1]):.2f}], {e[-1, k, 0]:.1e}"
                for k in range(3)
            ]
            where = "cells" if means else "points"
            print_row(where, mapping.__name__, f"{sizes[0]} to {sizes[-1]}", *cells)


def solutions() -> None:
    """Orders of the solution of Poisson's equation with values given on the boundary."""
    print_heading("Solutions of Poisson's equation", "Given on the boundary; root mean square error inside.")
    print_row("grid", "order", "cells", "order found", "error", head=True)
    for mapping in (curved.smooth, curved.stretched, curved.skewed, curved.annulus):
        for p in (2, 4):
            sizes, errors = (24, 32, 40, 48) if mapping is curved.annulus else (64, 96, 128, 160), []
            for n in sizes:
                grid = curved.grid(mapping, n)
                value, _, laplacian = planar_model(grid.points)
                known = value.copy()
                known[slice(None) if grid.periodic[0] else slice(1, -1), 1:-1] = np.nan
                errors.append(rms((Curvilinear(grid, order=p).poisson(laplacian, known) - value)[np.isnan(known)]))
            found = order(sizes, errors)
            print_row(mapping.__name__, p, f"{sizes[0]} to {sizes[-1]}", verdict(p, found), f"{errors[-1]:.1e}")


def uniform_flow(quick: bool) -> None:
    """Divergence of a uniform flow of speed 1, and what it would be without conservative metrics."""
    print_heading(
        "A uniform flow of speed 1",
        "Largest divergence in a box of size 1; relative to the flux through a cell's faces over its volume; "
        "of products of base vectors instead.",
    )
    print_row("values", "order", "points", "divergence", "relative", "of products", head=True)
    for n in (16, 32) if quick else (16, 32, 64):
        grid = curved.grid(curved.bent_box, n)
        flow = np.array([0.6, -0.64, 0.48])
        for p in (2, 4):
            made = Curvilinear(grid, order=p)
            found = np.abs(made.divergence(np.broadcast_to(flow, grid.points.shape)))
            scale = np.abs(made.area_vectors @ flow).max(axis=0) / np.abs(made.jacobian)
            products = made.contravariant @ flow * made.jacobian
            plain = np.abs(sum(made.derivative(products[i], i) for i in range(3)) / made.jacobian).max()
            relative = FREESTREAM.verdict(float(found.max() / scale.max()))
            print_row("points", p, grid.n_points, f"{found.max():.1e}", relative, f"{plain:.1e}")
            volumes = FiniteVolumes(grid, order=p)
            found = np.abs(volumes.divergence(np.broadcast_to(flow, (*grid.cell_shape, 3)))).max()
            print_row("cells", p, grid.n_points, FREESTREAM.verdict(float(found)), "", "")


def skewness() -> None:
    """Error of the Laplacian by the angle between the lines."""
    print_heading("Skewness", "Laplacian in the middle of a rhombus of 96^2 cells, and its order from 32 to 96.")
    print_row("angle", "order 2: error over that at 90", "found", "order 4: error over that at 90", "found", head=True)
    sizes, base, worst = (32, 48, 64, 96), {}, 0.0
    for angle in (90, 60, 45, 30, 20):
        row = [angle]
        for p in (2, 4):
            errors = []
            for n in sizes:
                t = np.linspace(0, 1, n + 1)
                grid = StructuredGrid(curved.skewed(*np.meshgrid(t, t, np.zeros(1), indexing="ij"), angle=angle))
                value, _, laplacian = planar_model(grid.points)
                errors.append(rms(inside(Curvilinear(grid, order=p).laplacian(value) - laplacian)))
            base.setdefault(p, errors[-1])
            row += [errors[-1] / base[p], f"{order(sizes, errors):.2f}"]
            worst = max(worst, abs(order(sizes, errors) - p))
        print_row(*row)
    print_claim(
        "skewness increases the coefficient of the truncation error, but doesn't change the order",
        f"the coefficient grows with the angle's departure; the order is off by {worst:.2f} at most",
    )


def size_variation() -> None:
    """The diffusion that the variation of cell size adds to a convection of speed 1."""
    print_heading(
        "Variation of cell size",
        "Diffusion that a growing grid adds to a flow of speed 1, over speed times cell size: measured on a parabola.",
    )
    print_row("growth", "diffusion along the flow", "-(growth - 1) / (growth + 1)", head=True)
    for growth in (0.8, 0.9, 1.0, 1.1, 1.25):
        x = np.cumsum(np.concatenate([[0.0], growth ** np.arange(20.0)]))
        grid = StructuredGrid(np.stack(np.meshgrid(x, np.arange(6.0), indexing="ij"), axis=-1))
        at = grid.points[..., 0]
        flow = np.broadcast_to([1.0, 0, 0], grid.points.shape)
        error = Curvilinear(grid).convection(at**2, flow) + 2 * at
        size = 0.5 * (at[2:] - at[:-2])
        print_row(growth, float((error[1:-1] / 2 / size).mean()), -(growth - 1) / (growth + 1))
    print_claim(
        "grid size variation gives numerical diffusion (or anti-diffusion leading to instability)",
        "diffusion where cells shrink along the flow, anti-diffusion where they grow, in proportion to the growth",
    )


def speed(quick: bool, repeats: int) -> None:
    """Nanoseconds a point, beside numpy's differences of the same array."""
    print_heading("Time a point", "Nanoseconds, and over numpy.gradient of the same values, which knows no metrics.")
    print_row("grid", "order", "turns", "metrics", "gradient", "divergence", "Laplacian", head=True)
    for mapping, n in ((curved.smooth, 256 if quick else 1024), (curved.bent_box, 32 if quick else 96)):
        grid = curved.grid(mapping, n)
        value, vectors = model(grid.points)[:2]
        axes = (0, 1) if grid.is_surface else (0, 1, 2)
        for p in (2, 4):
            made = Curvilinear(grid, order=p)

            def metrics(p=p, grid=grid):
                new = Curvilinear(grid, order=p)
                return new.contravariant, new.area_vectors

            contestants = {
                "numpy": lambda value=value, axes=axes: np.gradient(value, axis=axes),
                "metrics": metrics,
                "gradient": lambda made=made, value=value: made.gradient(value),
                "divergence": lambda made=made, vectors=vectors: made.divergence(vectors),
                "laplacian": lambda made=made, value=value: made.laplacian(value),
            }
            for run in contestants.values():
                run()
            times = taken_alternately(contestants, repeats)
            base = times.pop("numpy").seconds
            cells = [f"{t.seconds / grid.n_points * 1e9:.0f} ns, {t.seconds / base:.1f}" for t in times.values()]
            print_row(f"{mapping.__name__}, {grid.n_points:,} points", p, of_turns(times.values()), *cells)


def main() -> None:
    options = arguments(__doc__)
    for p in (2, 4):
        truncation(p, options.quick)
    solutions()
    uniform_flow(options.quick)
    skewness()
    size_variation()
    speed(options.quick, options.repeats)


if __name__ == "__main__":
    main()
