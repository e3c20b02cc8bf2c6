"""Model inputs on curved surfaces: tubes, tori, balls, patches and wings."""

from __future__ import annotations

import itertools

import numpy as np
from scipy.spatial import ConvexHull

from ..mesh import Mesh, MultiBlock, StructuredGrid


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
    south, east, north, west = (on_bumpy_torus(u + 0 * v, v + 0 * u) for u, v in ends)
    return south, east, north, west


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


def hub_sector(around: int = 12, along: int = 16, *, parts: int = 10, waves: float = 0.06) -> StructuredGrid:
    """One of ``parts`` of a wavy body of revolution about z, of radius about 1: imin turned about z is imax.

    Its side jmin, a circle in the plane z = 0, stands on `conical_wall`.

    Parameters
    ----------
    around, along : int
        Cells.
    parts : int
        How many of it make the whole.
    waves : float
        Their height.

    Examples
    --------
    >>> hub_sector()
    StructuredGrid(13 x 17 points)
    """
    turn, z = np.meshgrid(np.linspace(0, 2 * np.pi / parts, around + 1), np.linspace(0, 1, along + 1), indexing="ij")
    radius = 1 + waves * np.cos(parts * turn + 0.7) * np.sin(3 * z)
    return StructuredGrid(np.stack([radius * np.cos(turn), radius * np.sin(turn), z], axis=-1))


def conical_wall(around: int = 24, outwards: int = 4, *, slope: float = 0.4) -> StructuredGrid:
    """A wall on which `hub_sector` stands, z = -slope (r - 1): all around, for r from 0.5 to 3.

    Examples
    --------
    >>> conical_wall()
    StructuredGrid(25 x 5 points)
    """
    turn, radius = np.meshgrid(np.linspace(0, 2 * np.pi, around + 1), np.linspace(0.5, 3, outwards + 1), indexing="ij")
    return StructuredGrid(np.stack([radius * np.cos(turn), radius * np.sin(turn), slope * (1 - radius)], axis=-1))


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
