"""Model inputs in the plane: outlines, sections, sides, rough grids and points."""

from __future__ import annotations

from importlib import resources

import numpy as np

from .. import io
from ..errors import InvalidInput
from ..geometry.curves import lines_through, polyline
from ..mesh import Mesh, StructuredGrid
from ..sizing.around_loop import respaced_loop


def square(n: int = 1, *, size: float = 1.0) -> Mesh:
    """Closed outline of a square with ``n`` lines a side, counter-clockwise from the origin.

    Examples
    --------
    >>> square(2)
    Mesh(8 points, 8 line)
    """
    t = np.arange(n) / n
    zero, one = np.zeros(n), np.ones(n)
    sides = [(t, zero), (one, t), (1 - t, one), (zero, 1 - t)]
    points = size * np.concatenate([np.column_stack(side) for side in sides])
    return lines_through(points, closed=True)


def circle(n: int = 32, *, radius: float = 1.0, centre: tuple[float, float] = (0.0, 0.0)) -> Mesh:
    """Closed polygon of ``n`` lines on a circle, counter-clockwise.

    Examples
    --------
    >>> circle(8)
    Mesh(8 points, 8 line)
    """
    angle = 2 * np.pi * np.arange(n) / n
    return lines_through(np.asarray(centre) + radius * np.column_stack([np.cos(angle), np.sin(angle)]), closed=True)


def joined(*meshes: Mesh) -> Mesh:
    """Several boundaries as one, each loop with its own number in ``cell_data["tag"]``.

    Examples
    --------
    >>> joined(square(), circle(8, radius=0.25, centre=(0.5, 0.5)))
    Mesh(12 points, 12 line)
    """
    starts = np.cumsum([0] + [m.n_points for m in meshes])
    lines = [m.get("line") + start for m, start in zip(meshes, starts, strict=False)]
    tag = np.repeat(np.arange(1, len(meshes) + 1), [len(c) for c in lines])
    return Mesh(np.concatenate([m.points for m in meshes]), {"line": np.concatenate(lines)}, cell_data={"tag": tag})


def square_with_hole(n: int = 8) -> Mesh:
    """Unit square with a circular hole of radius 1/4, ``n`` lines a side and about as dense on the circle.

    Examples
    --------
    >>> square_with_hole(4)
    Mesh(24 points, 24 line)
    """
    return joined(square(n), circle(max(8, round(np.pi * n / 2)), radius=0.25, centre=(0.5, 0.5)))


def l_shape(n: int = 1) -> Mesh:
    """Outline of the unit square's double without its upper right quarter, ``n`` lines a unit.

    Examples
    --------
    >>> l_shape()
    Mesh(8 points, 8 line)
    """
    corners = np.array([[0, 0], [1, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2], [0, 1]], float)
    steps = np.arange(n)[:, None] / n
    after = np.roll(corners, -1, axis=0)
    points = [a + steps * (b - a) for a, b in zip(corners, after, strict=True)]
    return lines_through(np.concatenate(points), closed=True)


def wavy_sides(n: int = 16, m: int = 8) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """South, east, north and west of a patch with curved sides: (n + 1, 3) and (m + 1, 3) points.

    Examples
    --------
    >>> [len(side) for side in wavy_sides(4, 2)]
    [5, 3, 5, 3]
    """
    s, t = np.linspace(0, 1, n + 1), np.linspace(0, 1, m + 1)
    zero = np.zeros_like
    south = np.column_stack([2 * s, 0.15 * np.sin(2 * np.pi * s), zero(s)])
    north = np.column_stack([2 * s, 1 + 0.1 * np.sin(3 * np.pi * s), zero(s)])
    east = np.column_stack([2 + 0.1 * np.sin(np.pi * t), t, zero(t)])
    west = np.column_stack([-0.1 * np.sin(np.pi * t), t, zero(t)])
    return south, east, north, west


def airfoils() -> list[str]:
    """Names of the airfoils that meshcore ships, from the UIUC Airfoil Coordinates Database.

    Examples
    --------
    >>> airfoils()
    ['naca0012', 'rae2822', 's1223']
    """
    files = resources.files("meshcore").joinpath("data").iterdir()
    return sorted(file.name[: -len(".dat")] for file in files if file.name.endswith(".dat"))


def airfoil(name: str = "rae2822", *, cells: int | None = None) -> Mesh:
    """A shipped airfoil as one closed loop of lines, counter-clockwise, chord about 1.

    Parameters
    ----------
    name : str
        One of `airfoils`.
    cells : int, optional
        Resample to so many lines, densely where the section bends; by default the file's own points.

    Raises
    ------
    InvalidInput
        If no such airfoil is shipped.

    Examples
    --------
    >>> airfoil("rae2822")
    Mesh(128 points, 128 line)
    """
    if name not in airfoils():
        raise InvalidInput(f"{name!r} is not shipped; there are {', '.join(airfoils())}", parameter="name")
    with resources.as_file(resources.files("meshcore").joinpath("data", f"{name}.dat")) as path:
        section = io.read(path)
    if cells is None:
        return section
    return lines_through(respaced_loop(polyline(section)[:-1, :2], cells), closed=True)


def airfoil_in_far_field(
    name: str = "rae2822", *, radius: float = 10.0, cells: int | None = None, outer: int = 48
) -> Mesh:
    """A shipped airfoil inside a circle: ``cell_data["tag"]`` is 1 on the far field, 2 on the section.

    Parameters
    ----------
    name : str
        One of `airfoils`.
    radius : float
        Radius of the circle about mid-chord, in chords.
    cells : int, optional
        Lines on the section; by default the file's own points.
    outer : int
        Lines on the circle.

    Raises
    ------
    InvalidInput
        If no such airfoil is shipped.

    Examples
    --------
    >>> airfoil_in_far_field("naca0012", outer=32)
    Mesh(101 points, 101 line)
    """
    return joined(circle(outer, radius=radius, centre=(0.5, 0.0)), airfoil(name, cells=cells))


def triangulated_square(n: int = 4) -> Mesh:
    """Unit square of ``2 n^2`` right triangles, with the point field "front" that is steep along a circle.

    Examples
    --------
    >>> triangulated_square(2)
    Mesh(9 points, 8 triangle)
    """
    i, j = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")
    corner = (i * (n + 1) + j).ravel()
    lower = np.column_stack([corner, corner + n + 1, corner + n + 2])
    upper = np.column_stack([corner, corner + n + 2, corner + 1])
    x, y = (a.ravel() / n for a in np.meshgrid(np.arange(n + 1), np.arange(n + 1), indexing="ij"))
    front = np.tanh(20 * (np.hypot(x, y) - 0.7))
    return Mesh(np.column_stack([x, y]), {"triangle": np.concatenate([lower, upper])}, point_data={"front": front})


def rough_ring(n: int = 24, m: int = 8) -> Mesh:
    """Quads around a hole, ``n`` around and ``m`` outwards, whose points inside were shifted about.

    Examples
    --------
    >>> rough_ring(12, 4)
    Mesh(60 points, 48 quad)
    """
    angle, radius = np.meshgrid(2 * np.pi * np.arange(n + 1) / n, np.linspace(1, 3, m + 1), indexing="ij")
    inside = np.sin(np.pi * (radius - 1) / 2)
    angle = angle + 0.3 * inside * np.sin(5 * angle)
    radius = radius + 0.3 * inside * np.cos(4 * angle)
    points = np.stack([radius * np.cos(angle), -radius * np.sin(angle)], axis=-1)
    points = np.round(points * 2**20) / 2**20  # which single precision holds exactly, as hosts have it
    return StructuredGrid(points, periodic=(True, False, False)).to_mesh()


def sunflower(n: int = 60) -> Mesh:
    """``n`` points in the unit disk as the seeds of a sunflower stand, turned by the golden angle, as "vertex" cells.

    Examples
    --------
    >>> sunflower(50)
    Mesh(50 points, 50 vertex)
    """
    k = np.arange(n)
    turn, radius = np.pi * (3 - np.sqrt(5)) * k, np.sqrt((k + 0.5) / n)
    return Mesh(np.column_stack([radius * np.cos(turn), radius * np.sin(turn)]), {"vertex": k[:, None]})
