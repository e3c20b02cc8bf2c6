"""Quads in rows and columns, found in a mesh: a patch with four corners, a ring, or a closed cage with eight."""

from __future__ import annotations

from collections.abc import Container
from functools import cached_property
from itertools import permutations
from typing import NoReturn

import numpy as np

from ...errors import InvalidGeometry
from ...mesh import Mesh, StructuredGrid
from ..limits import check_extent


class QuadNet:
    """The quads of a mesh and who stands beside whom; nobody asks how they are turned.

    Parameters
    ----------
    mesh : Mesh
        Its "quad" cells count.
    parameter : str
        Name of the input, for messages.
    """

    def __init__(self, mesh: Mesh, parameter: str):
        self.points = mesh.points
        self.parameter = parameter
        self.quads = mesh.get("quad").tolist()
        self.at_edge: dict[tuple[int, int], list[int]] = {}
        for number, quad in enumerate(self.quads):
            for a, b in zip(quad, quad[1:] + quad[:1], strict=True):
                self.at_edge.setdefault((a, b) if a < b else (b, a), []).append(number)
        crowded = [edge for edge, quads in self.at_edge.items() if len(quads) > 2]
        if crowded:
            raise InvalidGeometry(
                f"more than two quads meet at an edge, {len(crowded)} times; remove the inner ones",
                parameter=parameter,
                points=crowded[0],
            )

    @cached_property
    def valence(self) -> np.ndarray:
        """(n,) int: quads at each point."""
        return np.bincount(np.ravel(self.quads).astype(int), minlength=len(self.points))

    @property
    def is_closed(self) -> bool:
        """Whether each edge has two quads."""
        return all(len(quads) == 2 for quads in self.at_edge.values())

    def beside(self, quad: int, point: int, other: int) -> int:
        """The neighbour of a point in a quad that is not ``other``."""
        nodes = self.quads[quad]
        k = nodes.index(point)
        before, after = nodes[k - 1], nodes[(k + 1) % 4]
        return after if before == other else before

    def across(self, quad: int, a: int, b: int) -> int | None:
        """The quad on the other side of an edge."""
        return next((q for q in self.at_edge[(a, b) if a < b else (b, a)] if q != quad), None)

    def rows(self, corner: int, along: int, across: int, corners: Container[int]) -> np.ndarray:
        """(n, m) int: points of the patch that begins at a corner, first index along, second across.

        Parameters
        ----------
        corner : int
            A point.
        along, across : int
            Its two neighbours in the first quad.
        corners : container of int
            Where the patch ends, if it has a neighbour there; at an edge without neighbour it ends anyhow. With the
            corner alone a ring ends where it began, and its last column is its first.

        Raises
        ------
        InvalidGeometry
            If the quads are not in rows and columns.
        """
        corner, along, across = int(corner), int(along), int(across)
        shared = set(self.at_edge[tuple(sorted((corner, along)))]) & set(self.at_edge[tuple(sorted((corner, across)))])
        first = next(iter(shared))
        low, high = self._strip(first, corner, across, corners, None)
        columns = [low, high]
        while high[0] not in corners and (first := self.across(first, high[0], high[1])) is not None:
            low, new = self._strip(first, high[0], self.beside(first, high[0], high[1]), corners, len(high))
            if low != high or len(columns) > len(self.quads):
                self._fail(high)
            high = new
            columns.append(high)
        found = np.array(columns).T
        closes = len(columns) > 3 and columns[-1] == columns[0]
        distinct = found[:, :-1] if closes else found
        if len(np.unique(distinct)) != distinct.size:
            self._fail(high)
        return found

    def _strip(
        self, quad: int, a: int, b: int, corners: Container[int], count: int | None
    ) -> tuple[list[int], list[int]]:
        """Points on both sides of a strip of quads from the edge (a, b) on, so many of them if that is known."""
        low, high = [a], [b]
        while True:
            a, b = self.beside(quad, a, b), self.beside(quad, b, a)
            low.append(a)
            high.append(b)
            at_end = len(low) == count if count else a in corners
            beyond = self.across(quad, a, b)
            if at_end or beyond is None:
                return low, high
            if len(low) > len(self.quads) + 1:
                self._fail(low)
            quad = beyond

    def _fail(self, points: list[int]) -> NoReturn:
        raise InvalidGeometry(
            "its quads are not in rows and columns between the corners; give faces that are grids",
            parameter=self.parameter,
            points=points[:4],
        )


def patch_of(mesh: Mesh, parameter: str) -> np.ndarray:
    """(n, m, 3) float: the points of a patch of quads, rows along the first index.

    Raises
    ------
    InvalidGeometry
        If the mesh has cells other than quads, or is not one patch with four corners.

    Examples
    --------
    >>> x, y = np.meshgrid([0.0, 1, 2], [0.0, 1], indexing="ij")
    >>> from meshcore import StructuredGrid
    >>> patch_of(StructuredGrid(np.stack([x, y], axis=-1)).to_mesh(), "face").shape
    (3, 2, 3)
    """
    return mesh.points[_patch(_net(mesh, parameter))]


def grid_of(mesh: Mesh, parameter: str) -> StructuredGrid:
    """The structured grid that a patch or a ring of quads is, with the mesh's point data.

    i and j begin at the corner, of a ring at the boundary's point, with the lowest number. i follows the first quad's
    nodes, of a ring the boundary, around which it is periodic: the mesh of a grid gives the grid again.

    Raises
    ------
    InvalidGeometry
        If the mesh has cells other than quads, or is neither a patch with four corners nor a ring.

    Examples
    --------
    >>> from meshcore import gallery
    >>> from meshcore.structured import o_grid
    >>> grid = o_grid(gallery.circle(24), radius=3, layers=8).mesh
    >>> again = grid_of(grid.to_mesh(), "grid")
    >>> again, again.periodic, bool((again.points == grid.points).all())
    (StructuredGrid(25 x 9 points), (True, False, False), True)
    """
    net = _net(mesh, parameter)
    is_ring = net.valence.max() > 1 and not (net.valence == 1).any() and not net.is_closed
    found = (_ring(net) if is_ring else _patch(net))[:, :, None]
    data = {name: values[found] for name, values in mesh.point_data.items()}
    return StructuredGrid(mesh.points[found], data, periodic=(is_ring, False, False))


def cage_of(mesh: Mesh, parameter: str) -> dict[str, np.ndarray]:
    """The six faces of a closed surface of quads by name, each (n, m, 3): its corners are where three quads meet.

    i, j and k begin in the corner with the least x + y + z and run along x, y and z, as nearly as can be.

    Raises
    ------
    InvalidGeometry
        If the surface does not have eight such corners, or is not six patches of rows and columns between them.

    Examples
    --------
    >>> from meshcore import gallery
    >>> {name: face.shape[:2] for name, face in cage_of(gallery.twisted_cage(4, 3, 2), "cage").items()}["kmax"]
    (5, 4)
    """
    net = _net(mesh, parameter)
    corners = np.flatnonzero(net.valence == 3).tolist()
    if len(corners) != 8 or not net.is_closed:
        what = f"has {len(corners)} points where three quads meet" if net.is_closed else "is open"
        where = (
            corners if net.is_closed else np.unique([edge for edge, quads in net.at_edge.items() if len(quads) == 1])
        )
        raise InvalidGeometry(
            f"{what}; a cage is a closed surface of quads with eight such corners", parameter=parameter, points=where
        )
    start = min(corners, key=lambda c: (float(mesh.points[c].sum()), c))
    ends = sorted({p for edge in net.at_edge if start in edge for p in edge if p != start})
    axes = along_axes(mesh.points[ends] - mesh.points[start])
    i, j, k = (ends[a] for a in axes)
    faces = {"kmin": net.rows(start, i, j, corners), "jmin": net.rows(start, i, k, corners)}
    faces["imin"] = net.rows(start, j, k, corners)
    south, front, west = faces["kmin"], faces["jmin"], faces["imin"]
    faces["imax"] = net.rows(south[-1, 0], south[-1, 1], front[-1, 1], corners)
    faces["jmax"] = net.rows(south[0, -1], south[1, -1], west[-1, 1], corners)
    faces["kmax"] = net.rows(front[0, -1], front[1, -1], west[1, -1], corners)
    if len(np.unique(np.concatenate([face.ravel() for face in faces.values()]))) != int((net.valence > 0).sum()):
        net._fail(corners)
    return {name: mesh.points[face] for name, face in faces.items()}


def along_axes(directions: np.ndarray) -> tuple[int, int, int]:
    """Which of three directions go best along x, y and z, in a right-handed order.

    Examples
    --------
    >>> along_axes(np.array([[0.0, 1, 0], [1, 0, 0.1], [0, 0, 2]]))
    (1, 0, 2)
    """
    size = np.linalg.norm(directions, axis=1)
    unit = directions / np.where(size > 0, size, 1.0)[:, None]
    orders = [p for p in permutations(range(3)) if np.linalg.det(unit[list(p)]) > 0] or [(0, 1, 2)]
    return max(orders, key=lambda p: sum(unit[p[axis], axis] for axis in range(3)))


def _net(mesh: Mesh, parameter: str) -> QuadNet:
    others = sum(len(cells) for kind, cells in mesh.cells.items() if kind not in ("quad", "line", "vertex"))
    if others or not len(mesh.get("quad")):
        raise InvalidGeometry(
            f"needs quads alone, has {len(mesh.get('quad'))} and {others} other faces", parameter=parameter
        )
    check_extent(mesh.points[mesh.get("quad")].reshape(-1, 3), parameter=parameter)
    return QuadNet(mesh, parameter)


def _patch(net: QuadNet) -> np.ndarray:
    """(n, m) int: points of a patch with four corners."""
    corners = np.flatnonzero(net.valence == 1)
    if len(corners) != 4:
        raise InvalidGeometry(
            f"needs a patch of quads with four corners, where one quad has a point alone; it has {len(corners)}",
            parameter=net.parameter,
            points=corners,
        )
    corner = int(corners[0])
    nodes = next(quad for quad in net.quads if corner in quad)
    k = nodes.index(corner)
    return _all(net.rows(corner, nodes[(k + 1) % 4], nodes[k - 1], ()), net)


def _ring(net: QuadNet) -> np.ndarray:
    """(n, m) int: points of a ring, of which the last row repeats the first."""
    ends = [edge for edge, quads in net.at_edge.items() if len(quads) == 1]
    start = min(map(min, ends))
    for a, b in (edge for edge in ends if start in edge):
        nodes = net.quads[net.at_edge[a, b][0]]
        k = nodes.index(start)
        if nodes[(k + 1) % 4] in (a, b):
            found = net.rows(start, nodes[k - 1], nodes[(k + 1) % 4], (start,)).T
            if (found[0] != found[-1]).any():
                break
            _all(found[:-1], net)
            return found
    net._fail([start])


def _all(found: np.ndarray, net: QuadNet) -> np.ndarray:
    """``found`` if it has all points of the net."""
    if found.size != int((net.valence > 0).sum()):
        net._fail(found.ravel().tolist())
    return found
