"""Model inputs, used alike by tests, examples, benchmarks, `meshcore warmup` and the hosts' round trips."""

from __future__ import annotations

import itertools
from importlib import resources
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull

from . import io
from .errors import InvalidInput
from .geometry.curves import lines_through, polyline
from .mesh import Mesh, MultiBlock, StructuredGrid
from .operation import operations
from .progress import Progress, advance, part_of, silent
from .sizing.around_loop import respaced_loop
from .structured.blending import blended


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


def twisted_cage(n: int = 8, m: int = 6, layers: int = 5) -> Mesh:
    """Closed surface of quads around a passage that turns by 30 degrees, of ``n`` by ``m`` by ``layers`` cells.

    Examples
    --------
    >>> twisted_cage(3, 2, 2)
    Mesh(34 points, 32 quad)
    """
    x, y, z = np.meshgrid(*(np.linspace(0, 1, count + 1) for count in (n, m, layers)), indexing="ij")
    angle = np.radians(30) * z
    u, v = x - 0.5, (y - 0.5) * (1 + 0.3 * np.sin(np.pi * z))
    points = np.stack([u * np.cos(angle) - v * np.sin(angle), u * np.sin(angle) + v * np.cos(angle), 1.5 * z], axis=-1)
    points = np.round(points * 2**12) / 2**12  # which single precision holds exactly, as hosts have it
    skin = StructuredGrid(points).to_mesh().boundary.compacted()
    return Mesh(skin.points, skin.cells)


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


def dented_box(n: int = 8, *, depth: float = 0.3, bulge: float = 0.0) -> Mesh:
    """Surface of a unit cube of ``n`` quads a side whose top is dented, as a closed cage of "quad" cells.

    With a ``bulge``, from about 0.05 on, the dent is a bulb with a narrower neck.

    Examples
    --------
    >>> dented_box(4)
    Mesh(98 points, 96 quad)
    """
    points = np.stack(np.meshgrid(*[np.linspace(0, 1, n + 1)] * 3, indexing="ij"), axis=-1)
    top = points[:, :, -1]
    across = 2 * top[..., :2] - 1
    radius = np.clip(np.linalg.norm(across, axis=-1), 1e-9, 1)
    top[..., :2] += 0.5 * across * (2 * bulge * np.sin(2 * np.pi * radius) / radius)[..., None]
    top[..., 2] -= depth * np.cos(np.pi * radius / 2) ** 2
    points = np.round(points * 2**20) / 2**20  # which single precision holds exactly, as hosts have it
    surface = StructuredGrid(points).to_mesh().boundary
    return Mesh(surface.points, surface.cells).compacted()


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


def rough_tube(n: int = 24, m: int = 10) -> Mesh:
    """Quads on a waisted tube, ``n`` around and ``m`` along, whose points inside were shifted about on it.

    Examples
    --------
    >>> rough_tube(12, 4)
    Mesh(60 points, 48 quad)
    """
    s, t = np.meshgrid(np.arange(n + 1) / n, np.arange(m + 1) / m, indexing="ij")
    inside = np.sin(np.pi * t)
    angle = 2 * np.pi * s + 0.3 * inside * np.sin(6 * np.pi * s + 1)
    height = 3 * (t + 0.06 * inside * np.cos(8 * np.pi * s))
    radius = 0.7 + 0.3 * np.cos(2 * np.pi * height / 3)
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle), height], axis=-1)
    points = np.round(points * 2**20) / 2**20  # which single precision holds exactly, as hosts have it
    return StructuredGrid(points, periodic=(True, False, False)).to_mesh()


def turbine_passage(n: int = 24, m: int = 48, layers: int = 20, *, twist: float = 70.0) -> StructuredGrid:
    """Passage between two blades of a row: ``n`` cells across, ``m`` along the flow, from the hub outwards.

    It is filled by linear transfinite interpolation, and turns by ``twist`` degrees from the hub to the tip.

    Examples
    --------
    >>> turbine_passage(4, 6, 5)
    StructuredGrid(5 x 7 x 6 points)
    """
    u, v, w = np.meshgrid(*(np.linspace(0, 1, cells + 1) for cells in (n, m, layers)), indexing="ij")
    on_blade = np.clip((v - 0.25) / 0.5, 0, 1)
    x = u - 0.5 + 0.8 * np.sin(0.5 * np.pi * on_blade) * (1 - 0.3 * w) + 0.2 * np.sin(np.pi * on_blade) * (1 - 2 * u)
    y = 2.5 * (v - 0.5)
    turn = np.radians(twist) * w
    height = 1.5 * w + 0.15 * np.sin(np.pi * v) * (1 - w)
    faces = np.stack([x * np.cos(turn) - y * np.sin(turn), x * np.sin(turn) + y * np.cos(turn), height], axis=-1)
    return StructuredGrid(blended(faces, (0, 1, 2)))


def bumpy_torus(n: int = 96, m: int = 48) -> Mesh:
    """A torus with bumps as triangles, ``n`` quads around its axis and ``m`` around its tube, each cut in two.

    Examples
    --------
    >>> bumpy_torus(12, 8)
    Mesh(96 points, 192 triangle)
    """
    s, t = np.meshgrid(np.arange(n + 1) / n, np.arange(m + 1) / m, indexing="ij")
    points = np.round(on_bumpy_torus(2 * np.pi * s, 2 * np.pi * t) * 2**16) / 2**16
    wrapped = StructuredGrid(points, periodic=(True, True, False)).to_mesh()
    quads = wrapped.get("quad")
    return Mesh(wrapped.points, {"triangle": np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])})


def on_bumpy_torus(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """(..., 3) points of `bumpy_torus`, at angles around the axis and around the tube.

    Examples
    --------
    >>> on_bumpy_torus(np.array([0.0]), np.array([0.0])).round(3)
    array([[3., 0., 0.]])
    """
    tube = 1 + 0.12 * np.sin(5 * u) * np.cos(2 * v) + 0.05 * np.sin(9 * u + 1.0) * np.sin(3 * v)
    return np.stack([(2 + tube * np.cos(v)) * np.cos(u), (2 + tube * np.cos(v)) * np.sin(u), tube * np.sin(v)], axis=-1)


def sides_on_torus(n: int = 32, m: int = 24) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """South, east, north and west of a patch of `bumpy_torus` with wavy sides: (n + 1, 3) and (m + 1, 3) points.

    Examples
    --------
    >>> [len(side) for side in sides_on_torus(4, 2)]
    [5, 3, 5, 3]
    """
    s, t = np.linspace(0, 1, n + 1), np.linspace(0, 1, m + 1)
    across, along = 0.15 * np.sin(2 * np.pi * s), 0.12 * np.sin(2 * np.pi * t)
    ends = [(1.6 * s, across - 0.4), (1.6 + along, 1.8 * t - 0.4), (1.6 * s, 1.4 - across), (along, 1.8 * t - 0.4)]
    return tuple(on_bumpy_torus(u + 0 * v, v + 0 * u) for u, v in ends)  # type: ignore[return-value]


def blade_row(n: int = 24, m: int = 60, layers: int = 24, *, blades: int = 11) -> StructuredGrid:
    """Passage of an annular row of biconvex, twisted blades: ``n`` cells from blade to blade, ``m`` along the flow.

    Up- and downstream of the blades the faces across i are images of each other, turned about the z axis. It is filled
    by linear transfinite interpolation, ``layers`` from the hub to the casing.

    Examples
    --------
    >>> blade_row(4, 12, 5)
    StructuredGrid(5 x 13 x 6 points)
    """
    u, v, w = np.meshgrid(*(np.linspace(0, 1, cells + 1) for cells in (n, m, layers)), indexing="ij")
    on_blade = np.clip((v - 0.3) / 0.4, 0, 1)
    pitch, radius = 2 * np.pi / blades, 0.6 + 0.1 * np.sin(np.pi * v) ** 2 + w * (0.55 - 0.1 * v)
    thickness = 0.5 * pitch * on_blade * (1 - on_blade) * (1.6 - 0.6 * w)
    camber = 0.25 * (1 + 0.6 * w) * np.sin(0.5 * np.pi * on_blade) ** 2 + 0.25 * np.clip(v - 0.7, 0, 1) * (1 + w)
    angle = camber + (1 - u) * 0.5 * thickness + u * (pitch - 0.5 * thickness)
    faces = np.stack([radius * np.cos(angle), radius * np.sin(angle), 1.4 * v], axis=-1)
    return StructuredGrid(blended(faces, (0, 1, 2)), names={"kmin": "hub", "kmax": "casing", "imin": "blade"})


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


def cloud_in_a_ball(n: int = 200) -> Mesh:
    """``n`` points spread evenly, but not regularly, in the unit ball, as "vertex" cells.

    Examples
    --------
    >>> cloud_in_a_ball(50)
    Mesh(50 points, 50 vertex)
    """
    k = np.arange(n) + 0.5
    height, turn = 1 - 2 * k / n, np.pi * (1 + np.sqrt(5)) * k  # directions by the golden section
    direction = np.column_stack([np.cos(turn) * np.sqrt(1 - height**2), np.sin(turn) * np.sqrt(1 - height**2), height])
    radius = np.cbrt((k * np.sqrt(2)) % 1)
    return Mesh(radius[:, None] * direction, {"vertex": np.arange(n)[:, None]})


def bumpy_ball(n: int = 162, *, bump: float = 0.15) -> Mesh:
    """Closed surface of triangles: a ball with bumps and hollows, ``n`` points spread evenly over it.

    Examples
    --------
    >>> bumpy_ball(42)
    Mesh(42 points, 80 triangle)
    """
    k = np.arange(n) + 0.5
    polar, turn = np.arccos(1 - 2 * k / n), np.pi * (1 + 5**0.5) * k
    ball = np.column_stack([np.cos(turn) * np.sin(polar), np.sin(turn) * np.sin(polar), np.cos(polar)])
    hull = ConvexHull(ball)
    outwards = np.einsum("ij,ij->i", hull.equations[:, :3], _normals(ball, hull.simplices)) > 0
    triangles = np.where(outwards[:, None], hull.simplices, hull.simplices[:, [0, 2, 1]]).astype(np.int64)
    x, y, z = ball.T
    radius = 1 + bump * np.sin(3 * x) * np.sin(4 * y + 1) * np.cos(3 * z)
    return Mesh(np.round(ball * radius[:, None] * 2**12) / 2**12, {"triangle": triangles})


def bricks(filled: np.ndarray, *, size: float = 1.0) -> Mesh:
    """Closed surface of quads around the cubes that an (ni, nj, nk) array of truth values fills.

    Examples
    --------
    >>> bricks(np.ones((2, 2, 2), bool))
    Mesh(26 points, 24 quad)
    """
    around, corners = np.pad(filled, 1), tuple(n + 1 for n in filled.shape)
    quads = []
    for axis, side in itertools.product(range(3), (-1, 1)):
        cells = np.argwhere(filled)
        beside = cells + 1
        beside[:, axis] += side
        outer = cells[~around[tuple(beside.T)]]
        outer[:, axis] += side > 0
        u, v = np.eye(3, dtype=int)[[(axis + 1) % 3, (axis + 2) % 3][::side]]
        quads += [[np.ravel_multi_index((outer + step).T, corners) for step in (0 * u, u, u + v, v)]]
    points = np.stack(np.unravel_index(np.arange(np.prod(corners)), corners), axis=-1).astype(float)
    return Mesh(size * points, {"quad": np.concatenate([np.column_stack(q) for q in quads])}).compacted()


def six_patches(n: int = 9) -> MultiBlock:
    """A unit sphere of six patches of ``n`` by ``n`` points, three of which meet at each of eight corners.

    Examples
    --------
    >>> six_patches(3).n_points
    54
    """
    s = np.tan(np.linspace(-1, 1, n) * np.pi / 4)
    a, b = np.meshgrid(s, s, indexing="ij")
    patches = []
    for axis, side in itertools.product(range(3), (-1, 1)):
        cube = np.empty((n, n, 3))
        cube[..., axis], cube[..., (axis + 1) % 3], cube[..., (axis + 2) % 3] = side, a, side * b
        patches.append(StructuredGrid(cube / np.linalg.norm(cube, axis=-1, keepdims=True)))
    return MultiBlock(tuple(patches))


def wing_tip(chord: int = 40, span: int = 24, tip: int = 4) -> Mesh:
    """Half a wing, open at its root in the plane z = 0: naca0012 without taper, its tip half a body of revolution.

    Parameters
    ----------
    chord, span : int
        Cells from the leading to the trailing edge, and from the root to the tip.
    tip : int
        Cells from the upper side over the tip to the middle.

    Examples
    --------
    >>> wing_tip(8, 4, 2)
    Mesh(101 points, 8 triangle, 88 quad)
    """
    x = 0.5 * (1 - np.cos(np.linspace(0, np.pi, chord + 1)))
    half = 0.6 * (0.2969 * np.sqrt(x) - 0.126 * x - 0.3516 * x**2 + 0.2843 * x**3 - 0.1036 * x**4)
    half[[0, -1]] = 0.0
    z = 1.5 * np.sin(np.linspace(0, np.pi / 2, span + 1))
    turn = np.linspace(0, np.pi, 2 * tip + 1)[1:-1]
    # Round the wing: up to the tip, over it, and back to the root.
    across = [np.ones_like(z), np.cos(turn), -np.ones_like(z)]
    out = [np.outer(np.ones_like(half), z), 1.5 + np.outer(half, np.sin(turn)), np.outer(np.ones_like(half), z[::-1])]
    y = np.outer(half, np.concatenate(across))
    points = np.stack([np.broadcast_to(x[:, None], y.shape), y, np.concatenate(out, axis=1)], axis=-1)
    return _without_repeats(StructuredGrid(points[::-1]).to_mesh())


def _without_repeats(mesh: Mesh) -> Mesh:
    """A mesh of quads with coincident points made one; quads that lose a corner become triangles, others go."""
    points, number = np.unique(np.round(mesh.points, 12), axis=0, return_inverse=True)
    quads = number.reshape(-1)[mesh.get("quad")]
    corners = [list(dict.fromkeys(quad)) for quad in quads.tolist()]
    kinds = {"triangle": [c for c in corners if len(c) == 3], "quad": [c for c in corners if len(c) == 4]}
    return Mesh(points, {kind: np.array(cells) for kind, cells in kinds.items() if cells}).compacted()


def _normals(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    a, b, c = points[triangles].transpose(1, 0, 2)
    return np.cross(b - a, c - a)


def arguments(identifier: str) -> tuple[tuple[Any, ...], dict[str, Any]]:
    """A small, typical call of an operation: positional inputs and keywords.

    Raises
    ------
    InvalidInput
        If the gallery has none for it: each operation needs one, or it cannot be warmed up.

    Examples
    --------
    >>> inputs, keywords = arguments("delaunay_refinement")
    >>> inputs[0]
    Mesh(45 points, 45 line)
    """
    calls: dict[str, tuple[tuple[Any, ...], dict[str, Any]]] = {
        "hyperbolic": ((airfoil("naca0012"),), {"first_height": 0.002, "growth": 1.25}),
        "parabolic": (
            (airfoil("naca0012"), circle(48, radius=2.0, centre=(0.5, 0.0))),
            {"first_height": 0.004, "growth": 1.25},
        ),
        "hyperbolic_volume": ((bumpy_ball(),), {"first_height": 0.01, "layers": 10}),
        "o_grid": ((airfoil("naca0012"),), {"radius": 4.0, "first_height": 0.01, "growth": 1.3}),
        "c_grid": ((airfoil("naca0012"),), {"radius": 4.0, "first_height": 0.005, "growth": 1.3}),
        "h_grid": ((airfoil("naca0012"),), {"radius": 3.0, "first_height": 0.01, "growth": 1.3}),
        "elliptic_volume": ((dented_box(depth=0.6, bulge=0.1),), {"edges": "poisson", "spacing_kmin": 0.05}),
        "elliptically_smoothed": ((rough_ring(),), {}),
        "transfinite": (tuple(lines_through(side) for side in wavy_sides()), {}),
        "transfinite_volume": ((twisted_cage(),), {}),
        "elliptic": (tuple(lines_through(side) for side in wavy_sides()), {}),
        "constrained_delaunay": ((square_with_hole(),), {}),
        "delaunay_3d": ((cloud_in_a_ball(),), {}),
        "discretised": ((square_with_hole(),), {"size": 0.08, "gradation": 0.5}),
        "delaunay_2d": ((square_with_hole(),), {}),
        "delaunay_refinement": ((square_with_hole(),), {"min_angle": 30.0}),
        "voronoi_2d": ((sunflower(), circle(24, radius=1.1)), {}),
        "voronoi_3d": ((cloud_in_a_ball(60),), {}),
        "smoothed": ((triangulated_square(),), {"rounds": 2}),
        "refined": ((triangulated_square(),), {"indicator": "front", "levels": 2}),
    }
    if identifier not in calls:
        raise InvalidInput(f"the gallery has no model call of {identifier!r}; add one to gallery.arguments")
    return calls[identifier]


def warm_up(progress: Progress = silent) -> dict[str, float]:
    """Make the model call of each operation, which compiles what it needs; seconds by operation.

    Raises
    ------
    Cancelled
        If ``progress`` answers False.
    """
    seconds = {}
    known = operations()
    for number, (name, operation) in enumerate(known.items()):
        step = part_of(progress, number / len(known), (number + 1) / len(known))
        advance(step, 0.0, f"compiling {operation.label}")
        positional, keywords = arguments(name)
        seconds[name] = operation.function(*positional, **keywords, progress=step).report.seconds
    advance(progress, 1.0, "compiled")
    return seconds
