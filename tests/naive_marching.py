"""Slow and obvious twins of the marching kernels: dense systems, one point after the other."""

from __future__ import annotations

import numpy as np

from tests import naive


def dense_block_solution(lower, diagonal, upper, right, closed):
    """The solution (n, 2) of a block tridiagonal system, its blocks (n, 4), put into one dense matrix."""
    n = len(right)
    matrix = np.zeros((2 * n, 2 * n))
    for k in range(n):
        for blocks, to in ((lower, k - 1), (diagonal, k), (upper, k + 1)):
            if closed or 0 <= to < n:
                to %= n
                matrix[2 * k : 2 * k + 2, 2 * to : 2 * to + 2] += blocks[k].reshape(2, 2)
    return np.linalg.solve(matrix, right.ravel()).reshape(n, 2)


def tangents(front):
    """Unit tangents and spacings at the points of a closed front.

    A tangent lies between that of the parabola through three points and the bisector, which it is where the front turns
    by half a radian.
    """
    before, after = front - np.roll(front, 1, axis=0), np.roll(front, -1, axis=0) - front
    b, a = np.linalg.norm(before, axis=1)[:, None], np.linalg.norm(after, axis=1)[:, None]
    ub, ua = before / b, after / a
    share = np.minimum(1.0, np.arccos(np.clip((ub * ua).sum(axis=1), -1, 1)) / 0.5)[:, None]
    t = share * (ub + ua) + (1 - share) * 2 * (ub * a + ua * b) / (a + b)
    return t / np.linalg.norm(t, axis=1)[:, None], 0.5 * (a + b)[:, 0]


def deepest_bay(turn):
    """Radians by which a part of a closed front turns to the left, at most."""
    n = len(turn)
    return max(sum(turn[(k + m) % n] for m in range(count)) for k in range(n) for count in range(n + 1))


def averaged(values, passes):
    """Values along a closed front, each replaced so many times by the mean of itself and that of its neighbours."""
    for _ in range(passes):
        values = 0.5 * values + 0.25 * (np.roll(values, 1) + np.roll(values, -1))
    return values


def hyperbolic_step(front, height, base, volume=1.0, averaging=0.0, wall=None):
    """The next layer of a smooth closed front that nowhere is about to meet itself, by one dense system.

    ``wall`` is the first of all layers, if it is another.
    """
    n = len(front)
    t, s = tangents(front)
    wider = s / tangents(front if wall is None else wall)[1]
    normal = np.column_stack([-t[:, 1], t[:, 0]])
    matrix, right = np.zeros((n, 2, n, 2)), np.zeros((n, 2))
    bend = 2 * np.pi / n
    half = 2 * np.sin(0.5 * bend)

    def ramp(aspect, concave=0.0):
        return (aspect + 0.8 * concave) / (aspect + 0.8)

    edges = np.roll(front, -1, axis=0) - front
    heading = np.arctan2(edges[:, 1], edges[:, 0])
    turn = (heading - np.roll(heading, 1) + np.pi) % (2 * np.pi) - np.pi
    calm = max(0.0, 1 - deepest_bay(turn))
    shared = averaging * calm * ramp(height / s) * (averaged(wider, 4) / wider - 1)
    for k in range(n):
        after, before = (k + 1) % n, (k - 1) % n
        ahead_of, behind = front[after] - front[k], front[k] - front[before]
        b, a = np.linalg.norm(behind), np.linalg.norm(ahead_of)
        concave = min(1.0, max(0.0, turn[k] / 0.2))
        eps = base * height / s[k] * ramp(height / s[k], concave) / np.cos(0.5 * max(0.0, turn[k])) ** 2
        uneven = (1 - concave) * (2 * a / (a + b) - 1)
        forth, back = eps * (1 - uneven), eps * (1 + uneven)
        dissipated = forth * ahead_of - back * behind
        inward = -dissipated @ normal[k]
        cap = 0.2 * ramp(height / s[k], concave) * height
        share = min(1.0, cap / inward) if inward > 0 else 1.0
        forth, back = share * forth, share * back
        c = height / s[k] * (np.outer(t[k], normal[k]) + volume * np.outer(normal[k], t[k]))
        matrix[k, :, k] += np.eye(2) * (1 + forth + back)
        matrix[k, :, after] += 0.5 * c - forth * np.eye(2)
        matrix[k, :, before] += -0.5 * c - back * np.eye(2)
        ahead = height / s.mean()
        lost = base * ramp(ahead) * half * (1 + ahead * half)
        forward = height * (1 + volume * ahead * np.sin(bend) + lost)
        forward *= 1 + shared[k] - shared.mean()
        right[k] = forward * normal[k] + share * dissipated
    d = np.linalg.solve(matrix.reshape(2 * n, 2 * n), right.ravel()).reshape(n, 2)
    return front + d


def layers_left(a, b, front, normals, heights):
    """Layers until points a and b meet and the least cosine of a normal with the line across; 16 if they do not."""
    across = front[b] - front[a]
    one, other = normals[a] @ across, -(normals[b] @ across)
    if one <= 0 or other <= 0:
        return 16.0, 0.0
    return across @ across / (one * heights[a] + other * heights[b]), min(one, other) / np.linalg.norm(across)


def needed(m, left, facing):
    """(strength, shrink) of m points to either side that meet in so many layers."""
    slower = 1 - np.clip((facing - 0.5) / 0.5, 0, 1) * (1 - np.clip(left / 5, 0.02, 1))
    return 0.25 * m * m * min(16 / left - 1, 4), slower


def windows(front, normals, heights, left_turns):
    """(strength, shrink) of each window (m, k) of a closed front whose ends face each other."""
    n, found = len(front), {}
    for m in window_sizes(n):
        for k in range(n):
            a, b = (k - m) % n, (k + m) % n
            left, facing = layers_left(a, b, front, normals, heights)
            if left < 16 and sum(left_turns[(a + q) % n] for q in range(1, 2 * m + 1)) > 0:
                found[m, k] = needed(m, left, facing)
    return found


def across_bays(front, normals, heights, left_turns, stride):
    """(n,) strengths and shrinkings where any two points of a closed front face each other across a bay."""
    n = len(front)
    strength, shrink = np.zeros(n), np.ones(n)
    for a in range(0, n, stride):
        turned = np.cumsum(left_turns[(a + np.arange(1, n)) % n])
        met = [
            (*layers_left(a, (a + q) % n, front, normals, heights), q)
            for q in range(2 * stride, n, stride)
            if turned[q - 1] > 1
        ]
        left, facing, away = min(met, default=(16.0, 0.0, 0))
        if left < 16:
            given = np.arange(a - away // 4, a + away + away // 4 + 1) % n
            more, slower = needed(away / 2, left, facing)
            strength[given], shrink[given] = np.maximum(strength[given], more), np.minimum(shrink[given], slower)
    return strength, shrink


def window_sizes(n):
    """Windows that fit into a closed front: 5, 6, 7, 8 times powers of two, and 1, 2, 4."""
    sizes = {1, 2, 4} | {first * 2**q for first in (5, 6, 7, 8) for q in range(20)}
    return sorted(m for m in sizes if 2 * m < n)


def handed_down(found, n):
    """(n,) strengths and shrinkings when each window gives to those of half its size around it, down to points."""
    strength, shrink = np.zeros(n), np.ones(n)

    def give(m, k, value, least):
        strength[k], shrink[k] = max(strength[k], value[0]), min(shrink[k], value[1])
        for way in (-1, 1):
            to = (k + way * max(1, 3 * m // 4)) % n
            strength[to], shrink[to] = max(strength[to], value[0]), min(shrink[to], value[1])
        if m // 2 >= least:
            for to in (k - max(1, 3 * m // 4), k, k + max(1, 3 * m // 4)):
                give(m // 2, to % n, value, least)

    for (m, k), value in found.items():
        power_of_two = m & (m - 1) == 0
        give(m, k, value, 1 if power_of_two else 5)
    return strength, shrink


def crossings(front, closed):
    """Whether two edges of a front that do not touch each other cross, each compared with each."""
    n = len(front)
    start = np.arange(n if closed else n - 1)
    a, b = front[start], front[(start + 1) % n]
    across = side(a[:, None], b[:, None], a) * side(a[:, None], b[:, None], b) < 0
    apart = (start[:, None] - start) % n
    return bool((across & across.T & (apart > 1) & (apart < n - 1)).any())


def side(p, q, r):
    """Twice the area of triangles p, q, r, positive if they turn to the left."""
    return (q[..., 0] - p[..., 0]) * (r[..., 1] - p[..., 1]) - (q[..., 1] - p[..., 1]) * (r[..., 0] - p[..., 0])


def sound(points, closed):
    """Whether all corners of the cells of points (n, m, 2) turn left, and the outermost front does not cross itself."""
    grid = np.concatenate([points, points[:1]]) if closed else points
    flat = np.concatenate([grid, 0 * grid[..., :1]], axis=2)
    return bool((naive.cross_areas(flat) > 0).all()) and not crossings(points[:, -1], closed)
