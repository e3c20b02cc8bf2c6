"""The main job: one airfoil meshed three ways, with files, pictures and a table of quality."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from . import gallery, io, quality
from .adapt import refined
from .geometry.curves import lines_through, polyline
from .mesh import Mesh, StructuredGrid
from .picture import histogram, picture
from .progress import Progress, advance, part_of, silent
from .report import Result
from .sizing.around_loop import respaced_loop
from .sizing.size_field import graded
from .structured import o_grid
from .unstructured import delaunay_refinement

NOSE = ((-0.05, -0.075), (0.15, 0.075))
SHOCK = ((0.46, 0.02), (0.7, 0.2))
ANGLE = 30.0
"""Smallest angle asked of the triangulation, degrees."""


def run(folder: str | os.PathLike, progress: Progress = silent, *, airfoil: str | os.PathLike = "rae2822") -> str:
    """Mesh an airfoil in a far field three ways, and write meshes and pictures of each.

    ====================== =======================================================================================
    ``triangulation.vtu``  quality triangulation, angles from 30 degrees, small cells at the surface growing outwards
    ``o_grid.vts``         O-type block that a hyperbolic march makes, with wall spacing
    ``adapted.vtu``        the triangulation refined where a given field, like a shock's, is steep
    ====================== =======================================================================================

    and for each a ``.png``, a close-up ``..._nose.png``, or ``..._shock.png`` of the adapted one, and histograms of
    quality.

    Parameters
    ----------
    folder : path
        Where to write; it is made if need be.
    progress : Progress, optional
        Called with fraction and message.
    airfoil : str or path
        Name of a shipped section, or a file with one closed loop.

    Returns
    -------
    str
        The files, and a table of quality of the three meshes.

    Raises
    ------
    InvalidInput
        If there is no such airfoil.
    MissingLibrary
        Without pyvista.

    Examples
    --------
    On the command line, ``meshcore demo out/demo``; in Python::

        print(run("out/demo"))
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    advance(progress, 0.0, "reading the airfoil")
    section = gallery.airfoil(airfoil) if airfoil in gallery.airfoils() else io.read(airfoil)
    makers = (
        ("triangulation", lambda step: triangulation(section, progress=step)),
        ("o_grid", lambda step: block(section, progress=step)),
        ("adapted", lambda step: adapted(meshes["triangulation"], progress=step)),
    )
    meshes: dict[str, Mesh | StructuredGrid] = {}
    for number, (name, make) in enumerate(makers):
        step = part_of(progress, number / 3, (number + 1) / 3)
        mesh, _ = make(part_of(step, 0.0, 0.5))
        meshes[name] = mesh
        io.write(folder / f"{name}.{'vts' if isinstance(mesh, StructuredGrid) else 'vtu'}", mesh)
        advance(step, 0.6, f"drawing {name}")
        draw(name, mesh, folder)
    advance(progress, 1.0, "done")
    files = ", ".join(sorted(path.name for path in folder.iterdir()))
    return f"{comparison(meshes)}\n\nin {folder}: {files}"


def triangulation(section: Mesh, *, cells: int = 240, progress: Progress = silent) -> Result:
    """A triangulation between a section and a circle at ten chords, small at the section and growing outwards.

    Parameters
    ----------
    section : Mesh
        One closed loop of lines, chord about 1.
    cells : int
        Lines on the section.
    progress : Progress, optional
        Called with fraction and message.

    Returns
    -------
    Result

    Examples
    --------
    >>> mesh, report = triangulation(gallery.airfoil("naca0012"), cells=80)
    >>> report.converged
    True
    """
    wall = lines_through(respaced_loop(polyline(section)[:-1, :2], cells), closed=True)
    domain = gallery.joined(gallery.circle(60, radius=10.0, centre=(0.5, 0.0)), wall)
    lengths = np.linalg.norm(np.diff(wall.points[wall.get("line")], axis=1)[:, 0], axis=1)
    size = graded(wall, float(np.median(lengths)), 1.25, 1.2)
    return delaunay_refinement(domain, min_angle=ANGLE, size_field=size, progress=progress)


def block(section: Mesh, *, cells: int = 240, progress: Progress = silent) -> Result:
    """An O-type block around a section out to ten chords, its first cells a ten-thousandth of the chord high.

    Parameters
    ----------
    section : Mesh
        One closed loop of lines, chord about 1.
    cells : int
        Cells around the section.
    progress : Progress, optional
        Called with fraction and message.

    Returns
    -------
    Result

    Examples
    --------
    >>> grid, report = block(gallery.airfoil("naca0012"), cells=80)
    >>> grid.cell_shape[0]
    80
    """
    return o_grid(section, around=cells, first_height=1e-4 * section.diagonal, growth=1.15, progress=progress)


def shock(points: np.ndarray) -> np.ndarray:
    """A field like the pressure over a transonic wing: a steep front that leans back over the upper surface.

    Parameters
    ----------
    points : (n, 3) float
        Where, in chords.

    Returns
    -------
    (n,) float
        Negative ahead of the front, positive behind it, and fading away from it to zero.

    Examples
    --------
    >>> shock(np.array([[0.54, 0.1, 0.0], [0.59, 0.1, 0.0]])).round(2)
    array([-0.96,  0.98])
    """
    x, y = points[:, 0], points[:, 1]
    strength = np.exp(-((x - 0.6) ** 2 + (y - 0.1) ** 2) / 0.35**2) * 0.5 * (1 + np.tanh(y / 0.03))
    return strength * np.tanh((x - 0.55 - 0.15 * y) / 0.01)


def adapted(mesh: Mesh, *, levels: int = 3, progress: Progress = silent) -> Result:
    """A triangulation refined where `shock` is steep: the field is sampled anew on each finer mesh.

    Parameters
    ----------
    mesh : Mesh
        Triangles.
    levels : int
        How often to refine.
    progress : Progress, optional
        Called with fraction and message.

    Returns
    -------
    Result
        The mesh has the field as ``point_data["shock"]``.

    Examples
    --------
    >>> coarse = gallery.triangulated_square(4)
    >>> fine, report = adapted(coarse, levels=1)
    >>> fine.n_cells > coarse.n_cells
    True
    """
    fine = mesh.with_point_data(shock=shock(mesh.points))
    for level in range(levels):
        step = part_of(progress, level / levels, (level + 1) / levels)
        fine, report = refined(fine, indicator="shock", fraction=0.6, progress=step)
        fine = fine.with_point_data(shock=shock(fine.points))
    return Result(fine, report)


def draw(name: str, mesh: Mesh | StructuredGrid, folder: Path) -> None:
    """Write the pictures of one of the demo's meshes.

    Parameters
    ----------
    name : str
        "triangulation", "o_grid" or "adapted".
    mesh : Mesh or StructuredGrid
        What to draw.
    folder : Path
        Where to write.
    """
    title = f"{name.replace('_', '-')}: {mesh.n_cells:,} cells"
    near = ((-0.5, -0.9), (1.9, 0.9))
    if name == "adapted":
        picture(mesh, folder / "adapted.png", scalars="shock", zoom=near, title=title)
        picture(mesh, folder / "adapted_shock.png", scalars="shock", zoom=SHOCK)
    else:
        picture(mesh, folder / f"{name}.png", zoom=near, title=title)
    if name != "adapted":
        picture(mesh, folder / f"{name}_nose.png", zoom=NOSE)
    histogram(quality.report(mesh), folder / f"{name}_quality.png")


def comparison(meshes: dict[str, Mesh | StructuredGrid]) -> str:
    """A table of quality, a column a mesh.

    Parameters
    ----------
    meshes : dict of str to Mesh or StructuredGrid
        By the name that heads the column.

    Returns
    -------
    str

    Examples
    --------
    >>> comparison({"square": gallery.triangulated_square(2)}).splitlines()[1].split()
    ['points', '9']
    """
    columns = {
        name: {"points": mesh.n_points, "cells": mesh.n_cells, **quality.summary(mesh)} for name, mesh in meshes.items()
    }
    labels = list(dict.fromkeys(label for column in columns.values() for label in column))
    width = max(map(len, labels))
    lines = [" " * width + "".join(f"{name:>15}" for name in columns)]
    for label in labels:
        shown = (column.get(label) for column in columns.values())
        cells = ("" if v is None else f"{v:,}" if isinstance(v, int) else f"{v:.4g}" for v in shown)
        lines.append(f"{label:<{width}}" + "".join(f"{cell:>15}" for cell in cells))
    return "\n".join(lines)
