"""Slow, obvious twins of the kernels of layers marched from surfaces."""

import itertools
from fractions import Fraction

import numpy as np


def rings(faces, n):
    """For each node its neighbours counter-clockwise, and whether the ring is open; by following faces."""
    follows = [{} for _ in range(n)]
    for face in faces:
        face = [node for node in face if node >= 0]
        for k, node in enumerate(face):
            follows[node][face[(k + 1) % len(face)]] = face[k - 1]
    found = []
    for chain in follows:
        first = set(chain) - set(chain.values())
        node = first.pop() if first else next(iter(chain))
        ring = [node]
        while node in chain and chain[node] != ring[0]:
            node = chain[node]
            ring.append(node)
        found.append((ring, ring[-1] not in chain))
    return found


def corners(ring, opened):
    """Pairs of neighbours in a row."""
    return list(zip(ring, ring[1:] + ([] if opened else ring[:1]), strict=False))


def normals(points, found):
    """Normals weighted by sine over product of lengths."""
    normal = []
    for i, (ring, opened) in enumerate(found):
        total = np.zeros(3)
        for a, b in corners(ring, opened):
            u, v = points[a] - points[i], points[b] - points[i]
            total += np.cross(u, v) / (u @ u) / (v @ v)
        normal.append(total / np.linalg.norm(total))
    return np.array(normal)


def ring_weights(points, normal, found):
    """Mean value coordinates in the plane across the normal, by angles."""
    weights = []
    for i, (ring, opened) in enumerate(found):
        flat = {j: points[j] - points[i] - (points[j] - points[i]) @ normal[i] * normal[i] for j in ring}
        weight = dict.fromkeys(ring, 0.0)
        for a, b in corners(ring, opened):
            la, lb = np.linalg.norm(flat[a]), np.linalg.norm(flat[b])
            tangent = np.tan(np.arccos(np.clip(flat[a] @ flat[b] / la / lb, -1, 1)) / 2)
            weight[a] += tangent / la
            weight[b] += tangent / lb
        weights.append(np.array(list(weight.values())) / sum(weight.values()))
    return weights


def corner_volumes(below, above, found):
    """Least sine of the corners at each node, of both layers."""
    least = []
    for i, (ring, opened) in enumerate(found):
        up = above[i] - below[i]
        values = []
        for layer in (below, above):
            for a, b in corners(ring, opened):
                edges = np.array([layer[a] - layer[i], layer[b] - layer[i], up])
                values.append(np.linalg.det(edges) / np.prod(np.linalg.norm(edges, axis=1)))
        least.append(min(values))
    return np.array(least)


def best_seen(faces):
    """Largest sine that any line has above all of (m, 3) unit normals' faces: two or three of them hold the best."""
    best = -1.0
    for held in [*itertools.combinations(faces, 2), *itertools.combinations(faces, 3)]:
        line = sum(held) if len(held) == 2 else np.cross(held[0] - held[1], held[0] - held[2])
        seen = faces @ line / max(np.linalg.norm(line), 1e-300)
        best = max(best, seen.min(), -seen.max())
    return best


def shares(wall, below, above, found):
    """For each node the sines of its corners, of both layers, over those of the wall's faces."""
    least = []
    for i, (ring, opened) in enumerate(found):
        up, values = above[i] - below[i], []
        for layer in (below, above):
            for a, b in corners(ring, opened):
                one, two = wall[a] - wall[i], wall[b] - wall[i]
                flat = np.linalg.norm(np.cross(one, two)) / np.linalg.norm(one) / np.linalg.norm(two)
                edges = np.array([layer[a] - layer[i], layer[b] - layer[i], up])
                values.append(np.linalg.det(edges) / np.prod(np.linalg.norm(edges, axis=1)) / flat)
        least.append(np.array(values))
    return least


def repair_cost(wall, below, above, target, height, found):
    """Sum over all corners of exp(-10 share), and of 0.3 of the squared ways from the target in heights."""
    total = sum(np.exp(np.minimum(-10 * values, 50)).sum() for values in shares(wall, below, above, found))
    return total + 0.3 * ((above - target) ** 2).sum() / height**2


def area_vectors(points, weights, seen):
    """Weighted sums of the cross products of each node's corners, given as (node, one neighbour, the next)."""
    i, a, b = seen.T
    total = np.zeros_like(points)
    np.add.at(total, i, weights[:, None] * np.cross(points[a] - points[i], points[b] - points[i]))
    return total


def stepped(points, normal, found, free, height, volume, strength, weights, right):
    """Corrections of a step by a dense matrix, with derivatives by differences, which are exact for products.

    Waves: the area vectors' changes, less (1 + volume) times their part along the normals, in units of the areas, times
    twice the least cosine between a normal and those of its corners, at most 1. Dissipation: e times the weighted mean
    of the ring.
    """
    n = len(points)
    seen = np.array([(i, a, b) for i, (ring, opened) in enumerate(found) for a, b in corners(ring, opened)])
    one, two = (points[seen[:, k]] - points[seen[:, 0]] for k in (1, 2))
    kept = 1 / ((one**2).sum(axis=1) * (two**2).sum(axis=1))
    area = np.einsum("ij,ij->i", area_vectors(points, kept, seen), normal)
    scale = np.where(free, 0.0, height / area)[:, None]
    cosine = np.einsum("ij,ij->i", np.cross(one, two), normal[seen[:, 0]])
    cosine /= np.linalg.norm(np.cross(one, two), axis=1)
    flat = np.ones(n)
    np.minimum.at(flat, seen[:, 0], cosine)
    flat = np.clip(flat / 0.5, 0.0, 1.0)[:, None]

    def changes(way):
        return scale * (area_vectors(points + way, kept, seen) - area_vectors(points - way, kept, seen)) / 2

    def along(vectors):
        return np.einsum("ij,ij->i", vectors, normal)[:, None] * normal

    matrix = np.zeros((3 * n, 3 * n))
    for k in range(3 * n):
        way = np.zeros(3 * n)
        way[k] = 1.0
        change = changes(way.reshape(n, 3))
        matrix[:, k] = way - (flat * (change - (1 + volume) * along(change))).ravel()
    for i, (ring, _) in enumerate(found):
        for axis in range(3):
            matrix[3 * i + axis, 3 * i + axis] += strength[i]
            for j, weight in zip(ring, weights[i], strict=True):
                matrix[3 * i + axis, 3 * j + axis] -= strength[i] * weight
    turn = changes(normal) * height
    widening = np.einsum("ij,ij->i", turn, normal) / height
    share = np.bincount(seen[:, 0], weights=np.linalg.norm(np.cross(one, two), axis=1))
    lost = volume * height * (widening - np.average(widening, weights=share))
    right = right + flat * (turn - along(turn) - lost[:, None] * normal)
    return np.linalg.solve(matrix, right.ravel()).reshape(n, 3)


def crossings(points, column, edges, triangles):
    """For each edge whether it passes through a triangle of none of its columns, by exact fractions."""
    exact = [[Fraction(x) for x in p] for p in np.asarray(points).tolist()]

    def volume(a, b, c, d):
        u, v, w = ([exact[q][k] - exact[a][k] for k in range(3)] for q in (b, c, d))
        cross = (v[1] * w[2] - v[2] * w[1], v[2] * w[0] - v[0] * w[2], v[0] * w[1] - v[1] * w[0])
        return sum(x * y for x, y in zip(u, cross, strict=True))

    def pierces(a, b, one, two, three):
        if volume(one, two, three, a) * volume(one, two, three, b) >= 0:
            return False
        around = [volume(a, b, *pair) for pair in ((one, two), (two, three), (three, one))]
        return all(v >= 0 for v in around) or all(v <= 0 for v in around)

    return [
        any(
            pierces(a, b, *triangle)
            for triangle in triangles
            if not {column[a], column[b]} & {column[k] for k in triangle}
        )
        for a, b in edges
    ]
