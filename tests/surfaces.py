"""Random surfaces for layers: smooth and spiked bodies, bricks, polyhedra, extruded sections, rings, open patches."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.spatial import ConvexHull

import meshcore as mc
from meshcore import gallery
from tests.bodies import random_bodies

Surface = mc.Mesh | mc.StructuredGrid | mc.MultiBlock


def random_surfaces(number: int, seed: int) -> Iterator[tuple[str, Surface]]:
    """Kind and surface, of extent about one. Surface k of a seed is the same whatever their number."""
    kinds = list(SURFACES)
    for k in range(number):
        kind = kinds[k % len(kinds)]
        yield kind, SURFACES[kind](np.random.default_rng([seed, k]))


def turned(points: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Points turned at random, and stretched by up to two."""
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    return points * rng.uniform(0.5, 1, 3) @ (q * np.sign(np.diag(r))) * (1 if np.linalg.det(q) > 0 else -1)


def blob(rng: np.random.Generator) -> mc.MultiBlock:
    """Six patches of a sphere, with waves."""
    ways, phases = rng.normal(size=(5, 3)) * rng.uniform(1, 4), rng.uniform(0, 7, 5)
    depth = rng.uniform(0, 0.12)
    blocks = []
    for block in gallery.six_patches(int(rng.integers(5, 15))).blocks:
        waves = np.cos(block.points @ ways.T + phases).sum(axis=-1, keepdims=True)
        blocks.append(mc.StructuredGrid(block.points * (1 + depth * waves)))
    return mc.MultiBlock(tuple(blocks))


def ball(rng: np.random.Generator) -> mc.Mesh:
    """Triangles with bumps."""
    mesh = gallery.bumpy_ball(int(rng.integers(50, 800)), bump=rng.uniform(0, 0.4))
    return mesh.with_points(turned(mesh.points, rng))


def bricks(rng: np.random.Generator) -> mc.Mesh:
    """Bricks at random that hang together, sheared."""
    while True:
        filled = np.zeros((3, 3, 3), bool)
        place = np.array([1, 1, 1])
        for _ in range(int(rng.integers(1, 14))):
            filled[tuple(place)] = True
            step = np.eye(3, dtype=int)[rng.integers(3)] * rng.choice([-1, 1])
            place = np.clip(place + step, 0, 2)
        fine = int(rng.integers(1, 5))
        mesh = gallery.bricks(filled.repeat(fine, 0).repeat(fine, 1).repeat(fine, 2), size=1 / (3 * fine))
        edges = np.sort(np.concatenate([mesh.get("quad")[:, [k, (k + 1) % 4]] for k in range(4)]), axis=1)
        if np.unique(edges, axis=0, return_counts=True)[1].max() == 2:
            shear = np.eye(3) + np.triu(rng.uniform(-0.5, 0.5, (3, 3)), 1)
            return mesh.with_points(mesh.points @ shear)


def polyhedron(rng: np.random.Generator) -> mc.Mesh:
    """The hull of points at random."""
    points = rng.normal(size=(int(rng.integers(4, 40)), 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True) ** rng.uniform(0.5, 1)
    hull = ConvexHull(points)
    used, faces = np.unique(hull.simplices, return_inverse=True)
    mesh = mc.Mesh(turned(points[used], rng), {"triangle": faces.reshape(-1, 3)})
    return split(split(mesh)) if rng.random() < 0.7 else mesh


def spiked(rng: np.random.Generator) -> mc.Mesh:
    """A polyhedron with a pyramid on each face, so that edges are hollow."""
    points = rng.normal(size=(int(rng.integers(5, 10)), 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    hull = ConvexHull(points)
    faces = hull.simplices
    tops = points[faces].mean(axis=1) + rng.uniform(0.05, 0.6) * hull.equations[:, :3]
    top = len(points) + np.arange(len(faces))
    sides = np.concatenate([np.column_stack([faces[:, k], faces[:, (k + 1) % 3], top]) for k in range(3)])
    return split(split(mc.Mesh(np.concatenate([points, tops]), {"triangle": sides})))


def split(mesh: mc.Mesh) -> mc.Mesh:
    """Each triangle as four."""
    faces = mesh.get("triangle")
    edges = np.sort(np.concatenate([faces[:, [k, (k + 1) % 3]] for k in range(3)]), axis=1)
    unique, number = np.unique(edges, axis=0, return_inverse=True)
    a, b, c = faces.T
    ab, bc, ca = len(mesh.points) + number.reshape(3, -1)
    four = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    points = np.concatenate([mesh.points, mesh.points[unique].mean(axis=1)])
    return mc.Mesh(points, {"triangle": np.concatenate([np.column_stack(t) for t in four])})


def extruded(rng: np.random.Generator) -> mc.Mesh:
    """A section with its span and flat ends."""
    *_, (_, loop) = random_bodies(int(rng.integers(1, 11)), int(rng.integers(1 << 30)))
    loop = loop[:-1]
    n, rows = len(loop), int(rng.integers(2, 8))
    k = np.arange(n)
    ends = mc.constrained_delaunay(
        mc.Mesh(np.pad(loop, ((0, 0), (0, 1))), {"line": np.column_stack([k, (k + 1) % n])})
    ).mesh.get("triangle")
    z = np.linspace(0, rng.uniform(0.3, 3), rows)
    points = np.concatenate([np.column_stack([loop, np.full(n, h)]) for h in z])
    below = np.column_stack([k, (k + 1) % n, (k + 1) % n + n, k + n])
    quads = np.concatenate([below + n * row for row in range(rows - 1)])
    return mc.Mesh(points, {"quad": quads, "triangle": np.concatenate([ends[:, ::-1], ends + n * (rows - 1)])})


def ring(rng: np.random.Generator) -> mc.StructuredGrid:
    """A torus."""
    n, m = rng.integers(8, 40, 2)
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, n), np.linspace(0, 2 * np.pi, m), indexing="ij")
    thick = rng.uniform(0.1, 0.8)
    x = 1 + thick * np.cos(v)
    points = np.stack([x * np.cos(u), x * np.sin(u), thick * np.sin(v)], axis=-1)
    points[-1], points[:, -1] = points[0], points[:, 0]
    return mc.StructuredGrid(points)


def patch(rng: np.random.Generator) -> mc.StructuredGrid:
    """Open and wavy."""
    n, m = rng.integers(4, 30, 2)
    u, v = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, rng.uniform(0.5, 2), m), indexing="ij")
    a, b = rng.uniform(1, 8, 2)
    waves = rng.uniform(0, 0.15) * np.sin(a * u + rng.uniform(0, 7)) * np.cos(b * v)
    return mc.StructuredGrid(np.stack([u + rng.uniform(0, 0.3) * v, v, waves], axis=-1))


SURFACES = {
    "blob": blob,
    "ball": ball,
    "bricks": bricks,
    "polyhedron": polyhedron,
    "spiked": spiked,
    "extruded": extruded,
    "ring": ring,
    "patch": patch,
}
"""Makers of one surface each."""
