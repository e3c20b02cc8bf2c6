"""Slow, obvious twins of the kernels of layers marched from surfaces."""

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


def smoothed(strength, weights, found, right):
    """The solution of d - e L d = right by a dense matrix; weights are those of rings."""
    n = len(found)
    matrix = np.eye(n)
    for i, (ring, _) in enumerate(found):
        matrix[i, i] += strength[i]
        for j, weight in zip(ring, weights[i], strict=True):
            matrix[i, j] -= strength[i] * weight
    return np.linalg.solve(matrix, right)
