"""Model inputs in space: blocks, as grids or as the cages around them, and points."""

from __future__ import annotations

import itertools

import numpy as np

from ..mesh import Mesh, StructuredGrid
from ..structured.algebraic.blending import blended


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
