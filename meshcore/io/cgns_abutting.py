"""Connections of CGNS by lists of points (GridConnectivity_t): those that join two rectangles point by point, as cuts.

What is told so may be anything; patches whose points do not match, and overset grids, are no cuts.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..mesh import Cut, StructuredGrid
from ..mesh.cuts import as_index
from .cgns_nodes import Node

POINT_BY_POINT = "Abutting1to1"


def is_point_by_point(node: Node) -> bool:
    """Whether a connection says that points are joined one to one, and lists both sides of these."""
    kind, location = node.find("GridConnectivityType"), node.find("GridLocation")
    by_points = location is None or location.text() == "Vertex"
    told = kind is not None and kind.text() == POINT_BY_POINT
    listed = node.find("PointRange") or node.find("PointList")
    return told and by_points and listed is not None and node.find("PointListDonor") is not None


def cut_of_lists(
    here: np.ndarray, there: np.ndarray, blocks: Sequence[StructuredGrid], block: int, partner: int
) -> Cut | None:
    """The cut that joins points of two blocks, or None if they are no rectangles on a side of each that run alike.

    Parameters
    ----------
    here, there : (m, 3) int
        Points of the two blocks, each joined to the one in the same place of the other list.
    blocks : sequence of StructuredGrid
        All blocks.
    block, partner : int
        The numbers of the two.
    """
    first, last = here.min(axis=0), here.max(axis=0)
    size = last - first + 1
    order = np.ravel_multi_index((here - first).T, size)
    if len(here) != len(there) or len(here) != np.prod(size) or len(np.unique(order)) != len(here):
        return None
    there = there[np.argsort(order)]  # as they follow here, i slowest
    here = here[np.argsort(order)]
    strides = np.array([size[1] * size[2], size[2], 1])
    matrix = np.zeros((3, 3), np.int64)
    for axis in np.flatnonzero(size > 1).tolist():
        matrix[:, axis] = there[strides[axis]] - there[0]
    across = _across(first, size, blocks[block].shape)
    beyond = _across(there.min(axis=0), np.ptp(there, axis=0) + 1, blocks[partner].shape)
    if across is None or beyond is None:
        return None
    matrix[beyond[0], across[0]] = -across[1] * beyond[1]  # out of this block is into the partner
    if blocks[block].is_surface and blocks[partner].is_surface:
        matrix[2, 2] = 1
    if (np.abs(matrix).sum(axis=0) != 1).any() or (np.abs(matrix).sum(axis=1) != 1).any():
        return None
    if (there != there[0] + (here - first) @ matrix.T).any():
        return None
    transform = as_index([int(np.argmax(np.abs(column))) + 1 for column in matrix.T] * matrix.sum(axis=0))
    ends = (as_index(there[0]), as_index(there[-1]))
    return Cut((as_index(first), as_index(last)), ends, transform, block, partner)


def _across(first: np.ndarray, size: np.ndarray, shape: Sequence[int]) -> tuple[int, int] | None:
    """The axis across a rectangle on a side, and -1 for the first one or 1 for the last; None if it is on none."""
    for axis in range(3):
        others = [k for k in range(3) if k != axis and shape[k] > 1]
        if shape[axis] > 1 and size[axis] == 1 and first[axis] in (0, shape[axis] - 1) and (size[others] > 1).all():
            return axis, -1 if first[axis] == 0 else 1
    return None
