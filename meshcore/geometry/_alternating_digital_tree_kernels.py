"""Kernels of the alternating digital tree: built over bounding boxes, asked for cells at a point and nearest ones.

A box in d dimensions is a point in 2d dimensions: its lower corner, then its upper corner (Bonet & Peraire 1991,
section 3). Going down the tree these 2d coordinates take turns; at each node the region is halved, and the boxes go to
its two sides. Two things differ from the paper, where each node holds one box and boxes come one by one:

- the tree is built at once from all boxes, so that the children of a node and the boxes of a leaf lie together in
  memory; the left child of node k is node k + 1;
- a node keeps the bounding box of all that lies below it, which closes a branch sooner than its region in 2d
  dimensions does, and bounds a distance from below. So a query is right however boxes were shared out, and a region may
  shrink to what it holds before it is halved, or, far down, be cut by number: depth stays below DEEP + 31.
"""

import numpy as np

from .._numba import kernel
from ._predicates_kernels import orient2d, orient3d

LEAF = 4
"""Largest number of boxes in a leaf."""
DEEP = 96
"""Depth from which on boxes are halved by number: identical and exponentially shrinking boxes end up there."""
STACK = 160
"""Nodes that wait at any time are fewer than levels, DEEP + 31 at most."""


@kernel(allocates=True)
def build(boxes, order, n, dimension, right, first, bounds):
    """Build the tree; return the number of nodes.

    ``boxes`` (n * 2 * dimension,) and ``order`` (n,) are put into the order of the leaves. Node k has the left child
    k + 1 and the right child ``right[k]``, or is a leaf: then ``right[k]`` is minus the number of its boxes, which
    begin at ``first[k]``. ``bounds`` holds lower and upper corner of each node.
    """
    size = 2 * dimension
    low = np.empty(size)
    high = np.empty(size)
    stack = np.empty((STACK, 4), np.int64)
    stack[0, 0] = 0
    stack[0, 1] = n
    stack[0, 2] = 0
    stack[0, 3] = -1
    waiting = 1 if n > 0 else 0
    nodes = 0
    while waiting > 0:
        waiting -= 1
        start = stack[waiting, 0]
        stop = stack[waiting, 1]
        depth = stack[waiting, 2]
        if stack[waiting, 3] >= 0:
            right[stack[waiting, 3]] = nodes
        for k in range(size):
            low[k] = np.inf
            high[k] = -np.inf
        for item in range(start, stop):
            for k in range(size):
                value = boxes[size * item + k]
                low[k] = min(low[k], value)
                high[k] = max(high[k], value)
        for k in range(dimension):
            bounds[size * nodes + k] = low[k]
            bounds[size * nodes + dimension + k] = high[dimension + k]
        first[nodes] = start
        right[nodes] = start - stop
        if stop - start > LEAF:
            middle = _halved(boxes, order, start, stop, depth, size, low, high)
            stack[waiting, 0] = middle
            stack[waiting, 1] = stop
            stack[waiting, 2] = depth + 1
            stack[waiting, 3] = nodes
            stack[waiting + 1, 0] = start
            stack[waiting + 1, 1] = middle
            stack[waiting + 1, 2] = depth + 1
            stack[waiting + 1, 3] = -1
            waiting += 2
        nodes += 1
    return nodes


@kernel
def _halved(boxes, order, start, stop, depth, size, low, high):
    """Share the boxes of a node out to its two sides; return where the second side begins."""
    axis = -1
    for k in range(size):  # the coordinate whose turn it is, or the next one that differs at all
        candidate = (depth + k) % size
        if low[candidate] < high[candidate]:
            axis = candidate
            break
    if axis < 0 or depth >= DEEP:
        return (start + stop) // 2
    pivot = 0.5 * low[axis] + 0.5 * high[axis]
    if pivot >= high[axis]:  # of neighbouring doubles the middle may round to the upper one
        pivot = low[axis]
    i = start
    j = stop - 1
    while True:
        while boxes[size * i + axis] <= pivot:
            i += 1
        while boxes[size * j + axis] > pivot:
            j -= 1
        if i > j:
            return i
        order[i], order[j] = order[j], order[i]
        for k in range(size):
            boxes[size * i + k], boxes[size * j + k] = boxes[size * j + k], boxes[size * i + k]


@kernel
def morton_keys(points, dimension, n, lower, scale, keys):
    """Interleave 16 bits of each coordinate, so that points of neighbouring keys mostly are neighbours."""
    for i in range(n):
        key = 0
        for k in range(dimension):
            cell = int(min(max((points[dimension * i + k] - lower[k]) * scale, 0.0), 65535.0))
            for bit in range(16):
                key |= ((cell >> bit) & 1) << (dimension * bit + k)
        keys[i] = key


# ---- which cell holds a point


@kernel(allocates=True)
def find_triangles(points, queries, start, stop, corners, order, right, first, bounds, work, cell, weights):
    """For each query point of the plane the first triangle, by number, that holds it, or -1; its weights.

    ``corners`` (n * 6,) are counter-clockwise triangles of exact orientation, in the order of the leaves.
    """
    stack = np.empty(STACK, np.int64)
    for q in range(start, stop):
        p = queries[q]
        x = points[2 * p]
        y = points[2 * p + 1]
        found = -1
        at = -1
        stack[0] = 0
        waiting = 1 if len(right) > 0 else 0
        while waiting > 0:
            waiting -= 1
            node = stack[waiting]
            b = 4 * node
            if x < bounds[b] or y < bounds[b + 1] or x > bounds[b + 2] or y > bounds[b + 3]:
                continue
            if right[node] > 0:
                stack[waiting] = right[node]
                stack[waiting + 1] = node + 1
                waiting += 2
                continue
            for item in range(first[node], first[node] - right[node]):
                if found >= 0 and order[item] > found:
                    continue
                c = 6 * item
                ax, ay, bx = corners[c], corners[c + 1], corners[c + 2]
                by, cx, cy = corners[c + 3], corners[c + 4], corners[c + 5]
                if orient2d(ax, ay, bx, by, x, y, work) < 0.0:
                    continue
                if orient2d(bx, by, cx, cy, x, y, work) < 0.0 or orient2d(cx, cy, ax, ay, x, y, work) < 0.0:
                    continue
                found = order[item]
                at = item
        cell[p] = found
        if found >= 0:
            c = 6 * at
            ax, ay, bx = corners[c], corners[c + 1], corners[c + 2]
            by, cx, cy = corners[c + 3], corners[c + 4], corners[c + 5]
            weights[p, 0] = max(orient2d(bx, by, cx, cy, x, y, work), 0.0)
            weights[p, 1] = max(orient2d(cx, cy, ax, ay, x, y, work), 0.0)
            weights[p, 2] = max(orient2d(ax, ay, bx, by, x, y, work), 0.0)
            total = weights[p, 0] + weights[p, 1] + weights[p, 2]
            for k in range(3):
                weights[p, k] /= total


@kernel
def _faces_of_tetrahedron(corners, item, x, y, z, work, signs):
    """Whether a tetrahedron holds a point; ``signs`` are orient3d with each corner in turn replaced by the point."""
    c = 12 * item
    ax, ay, az = corners[c], corners[c + 1], corners[c + 2]
    bx, by, bz = corners[c + 3], corners[c + 4], corners[c + 5]
    cx, cy, cz = corners[c + 6], corners[c + 7], corners[c + 8]
    dx, dy, dz = corners[c + 9], corners[c + 10], corners[c + 11]
    signs[0] = orient3d(bx, by, bz, dx, dy, dz, cx, cy, cz, x, y, z, work)
    if signs[0] < 0.0:
        return False
    signs[1] = orient3d(ax, ay, az, cx, cy, cz, dx, dy, dz, x, y, z, work)
    if signs[1] < 0.0:
        return False
    signs[2] = orient3d(ax, ay, az, dx, dy, dz, bx, by, bz, x, y, z, work)
    if signs[2] < 0.0:
        return False
    signs[3] = orient3d(ax, ay, az, bx, by, bz, cx, cy, cz, x, y, z, work)
    return signs[3] >= 0.0


@kernel(allocates=True)
def find_tetrahedra(points, queries, start, stop, corners, order, right, first, bounds, work, cell, weights):
    """For each query point of space the first tetrahedron, by number, that holds it, or -1; its weights.

    ``corners`` (n * 12,) are tetrahedra of exactly positive volume, in the order of the leaves.
    """
    stack = np.empty(STACK, np.int64)
    signs = np.empty(4)
    for q in range(start, stop):
        p = queries[q]
        x = points[3 * p]
        y = points[3 * p + 1]
        z = points[3 * p + 2]
        found = -1
        stack[0] = 0
        waiting = 1 if len(right) > 0 else 0
        while waiting > 0:
            waiting -= 1
            node = stack[waiting]
            b = 6 * node
            if x < bounds[b] or y < bounds[b + 1] or z < bounds[b + 2]:
                continue
            if x > bounds[b + 3] or y > bounds[b + 4] or z > bounds[b + 5]:
                continue
            if right[node] > 0:
                stack[waiting] = right[node]
                stack[waiting + 1] = node + 1
                waiting += 2
                continue
            for item in range(first[node], first[node] - right[node]):
                if found >= 0 and order[item] > found:
                    continue
                if _faces_of_tetrahedron(corners, item, x, y, z, work, signs):
                    found = order[item]
                    total = signs[0] + signs[1] + signs[2] + signs[3]
                    for k in range(4):
                        weights[p, k] = signs[k] / total
        cell[p] = found


# ---- which cell is nearest to a point


@kernel
def _on_segment(ax, ay, az, bx, by, bz, x, y, z):
    """Where along a segment the nearest place is, from 0 to 1, and its squared distance."""
    ux, uy, uz = bx - ax, by - ay, bz - az
    px, py, pz = x - ax, y - ay, z - az
    length2 = ux * ux + uy * uy + uz * uz
    t = 0.0
    if length2 > 0.0:
        t = min(max((px * ux + py * uy + pz * uz) / length2, 0.0), 1.0)
    px, py, pz = px - t * ux, py - t * uy, pz - t * uz
    return t, px * px + py * py + pz * pz


@kernel
def _on_simplex(corners, item, n_corners, x, y, z, share):
    """Squared distance to a segment or a triangle; ``share`` becomes the weights of its corners."""
    c = 9 * item
    ax, ay, az = corners[c], corners[c + 1], corners[c + 2]
    bx, by, bz = corners[c + 3], corners[c + 4], corners[c + 5]
    t, best = _on_segment(ax, ay, az, bx, by, bz, x, y, z)
    share[0] = 1.0 - t
    share[1] = t
    share[2] = 0.0
    if n_corners < 3:
        return best
    cx, cy, cz = corners[c + 6], corners[c + 7], corners[c + 8]
    t, squared = _on_segment(bx, by, bz, cx, cy, cz, x, y, z)
    if squared < best:
        best = squared
        share[0] = 0.0
        share[1] = 1.0 - t
        share[2] = t
    t, squared = _on_segment(cx, cy, cz, ax, ay, az, x, y, z)
    if squared < best:
        best = squared
        share[0] = t
        share[1] = 0.0
        share[2] = 1.0 - t
    # The foot on the plane, by the normal equations; a flat triangle has none, and its edges are all of it.
    ux, uy, uz = bx - ax, by - ay, bz - az
    vx, vy, vz = cx - ax, cy - ay, cz - az
    px, py, pz = x - ax, y - ay, z - az
    uu, uv, vv = ux * ux + uy * uy + uz * uz, ux * vx + uy * vy + uz * vz, vx * vx + vy * vy + vz * vz
    pu, pv = px * ux + py * uy + pz * uz, px * vx + py * vy + pz * vz
    determinant = uu * vv - uv * uv
    if determinant > 1e-14 * uu * vv:
        v = (pu * vv - pv * uv) / determinant
        w = (pv * uu - pu * uv) / determinant
        if v >= 0.0 and w >= 0.0 and v + w <= 1.0:
            px, py, pz = px - v * ux - w * vx, py - v * uy - w * vy, pz - v * uz - w * vz
            squared = px * px + py * py + pz * pz
            if squared < best:
                best = squared
                share[0] = 1.0 - v - w
                share[1] = v
                share[2] = w
    return best


@kernel
def _to_box(bounds, node, x, y, z):
    """Squared distance from a point to the box of a node."""
    b = 6 * node
    dx = max(bounds[b] - x, x - bounds[b + 3], 0.0)
    dy = max(bounds[b + 1] - y, y - bounds[b + 4], 0.0)
    dz = max(bounds[b + 2] - z, z - bounds[b + 5], 0.0)
    return dx * dx + dy * dy + dz * dz


@kernel(allocates=True)
def find_nearest(
    points, queries, start, stop, corners, n_corners, order, right, first, bounds, cell, weights, distance2
):
    """For each query point the nearest simplex of one to three corners, the first by number of equally near ones.

    ``corners`` (n * 9,) in the order of the leaves. The search goes to the nearer child first, and leaves out what is
    farther than what was found; the search for a point begins with what was nearest to the one before.
    """
    stack = np.empty(STACK, np.int64)
    least = np.empty(STACK)
    share = np.empty(3)
    before = 0
    for q in range(start, stop):
        p = queries[q]
        x = points[3 * p]
        y = points[3 * p + 1]
        z = points[3 * p + 2]
        best = np.inf
        found = -1
        stack[0] = 0
        least[0] = 0.0
        waiting = 1
        item = before
        last = before + 1
        while True:
            while item < last:
                squared = _on_simplex(corners, item, n_corners, x, y, z, share)
                if squared < best or (squared == best and order[item] < found):
                    best = squared
                    found = order[item]
                    before = item
                    for k in range(n_corners):
                        weights[p, k] = share[k]
                item += 1
            if waiting == 0:
                break
            waiting -= 1
            node = stack[waiting]
            if least[waiting] > best:
                continue
            if right[node] <= 0:
                item = first[node]
                last = item - right[node]
                continue
            near = node + 1
            far = right[node]
            to_near = _to_box(bounds, near, x, y, z)
            to_far = _to_box(bounds, far, x, y, z)
            if to_far < to_near:
                near, far = far, near
                to_near, to_far = to_far, to_near
            stack[waiting] = far
            least[waiting] = to_far
            stack[waiting + 1] = near
            least[waiting + 1] = to_near
            waiting += 2
        cell[p] = found
        distance2[p] = best
