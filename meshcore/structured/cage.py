"""A cage of quadrilaterals as the six faces of a block: rows and columns are found by walking over it."""

from __future__ import annotations

import itertools

import numpy as np

from ..errors import InvalidGeometry, InvalidInput
from ..mesh import Mesh

_CURE = "a block needs six sides of quads in rows and columns, such as a cube that is subdivided"


def block_of_cage(mesh: Mesh, parameter: str = "block") -> np.ndarray:
    """The faces of the block that a closed cage of quads, or the surface of hexahedra, makes.

    i, j and k leave the corner with the least number; i goes to the one of its three neighbours with the least
    number, and j and k so that the block is right-handed.

    Parameters
    ----------
    mesh : Mesh
        "quad" cells that all face outwards, or all inwards, or "hexahedron" cells of one block.
    parameter : str
        What errors call the mesh.

    Returns
    -------
    (ni, nj, nk, 3) float
        The points of the six faces; NaN inside.

    Raises
    ------
    InvalidInput, InvalidGeometry
        If the mesh has other cells, is not closed, or is no block: the message says what is missing.

    Examples
    --------
    >>> from meshcore import StructuredGrid
    >>> cube = StructuredGrid(np.stack(np.meshgrid([0, 1], [0, 1, 2], [0, 1, 2, 3], indexing="ij"), axis=-1))
    >>> block_of_cage(cube.to_mesh().boundary).shape
    (2, 3, 4, 3)
    """
    surface = mesh.boundary if len(mesh.get("hexahedron")) else mesh
    quads = surface.get("quad")
    if not len(quads) or len(quads) < surface.n_cells:
        kinds = ", ".join(kind for kind in mesh.cells if kind not in ("quad", "hexahedron")) or "no cells"
        raise InvalidInput(f"needs quads or hexahedra alone, got {kinds}; {_CURE}", parameter=parameter)
    sides = _Walk(quads, parameter).sides()
    ni, nk = sides["jmin"].shape
    points = np.full((ni, sides["kmin"].shape[1], nk, 3), np.nan)
    for axis, name in enumerate("ijk"):
        faces = np.moveaxis(points, axis, 0)
        faces[0], faces[-1] = surface.points[sides[f"{name}min"]], surface.points[sides[f"{name}max"]]
    return points if _outwards(surface.points, quads) else points.swapaxes(1, 2)


def _outwards(points: np.ndarray, quads: np.ndarray) -> bool:
    """Whether the quads of a closed surface face outwards: its volume is positive."""
    a, b, c, d = (points[quads] - points.mean(axis=0)).swapaxes(0, 1)
    return float((np.cross(c - a, d - b) * (a + b + c + d)).sum()) > 0


class _Walk:
    """Quads of a cage by their directed edges, and walks over them."""

    def __init__(self, quads: np.ndarray, parameter: str):
        self._parameter = parameter
        self._quads = quads
        count = np.bincount(quads.ravel())
        self._corners = set(np.flatnonzero(count == 3).tolist())
        if len(self._corners) != 8:
            self._fail(f"has {len(self._corners)} points where three quads meet, and a block has 8")
        # (a, b) leads to (c, d) in the quad a, b, c, d.
        self._across = {}
        for quad in quads.tolist():
            for k in range(4):
                self._across[quad[k], quad[(k + 1) % 4]] = quad[(k + 2) % 4], quad[(k + 3) % 4]
        if len(self._across) < 4 * len(quads):
            self._fail("has edges that two quads run along in the same direction; turn all faces the same way")

    def _fail(self, message: str):
        raise InvalidGeometry(f"{message}; {_CURE}", parameter=self._parameter)

    def sides(self) -> dict[str, np.ndarray]:
        """Numbers of the points of the six sides, as [i, j], [i, k] or [j, k]."""
        origin = min(self._corners)
        i = min(b for a, b in self._across if a == origin)
        # Each quad at the origin leads from one direction to the next: i to k to j, seen from outside.
        k = self._at(origin, i)[1]
        j = self._at(origin, k)[1]
        low = {"jmin": self._side(origin, i), "imin": self._side(origin, k).T, "kmin": self._side(origin, j).T}
        high = {
            "imax": self._side(low["kmin"][-1, 0], low["kmin"][-1, 1]),
            "jmax": self._side(low["imin"][-1, 0], low["imin"][-1, 1]).T,
            "kmax": self._side(low["jmin"][0, -1], low["jmin"][1, -1]),
        }
        for name, side in low.items():
            if high[name.replace("min", "max")].shape != side.shape:
                self._fail(f"has opposite sides of {side.shape} and {high[name.replace('min', 'max')].shape} points")
        every = np.unique(np.concatenate([side.ravel() for side in (*low.values(), *high.values())]))
        if len(every) < len(np.unique(self._quads)):
            self._fail("has more quads than those of its six sides")
        return {**low, **high}

    def _side(self, a: int, b: int) -> np.ndarray:
        """The side on whose rim the edge from corner a to b lies: its first axis begins along that edge."""
        rows = [self._rim(int(a), int(b))]
        while len(rows) == 1 or rows[-1][0] not in self._corners:
            if len(rows) > len(self._quads):
                self._fail("runs around without end")
            rows.append(self._above(rows[-1]))
        return np.array(rows).T

    def _rim(self, a: int, b: int) -> list[int]:
        """The points from corner a over b on, straight ahead, up to the next corner."""
        row = [a, b]
        beside = self._at(a, b)[0]
        while row[-1] not in self._corners:
            if len(row) > len(self._quads):
                self._fail("runs around without end")
            ahead, beside = self._at(beside, row[-1])
            row.append(ahead)
        return row

    def _above(self, row: list[int]) -> list[int]:
        """The row beside a row."""
        return [self._at(a, b)[1] for a, b in itertools.pairwise(row)] + [self._at(row[-2], row[-1])[0]]

    def _at(self, a: int, b: int) -> tuple[int, int]:
        if (a, b) not in self._across:
            self._fail(f"is open at the edge from point {b} to {a}")
        return self._across[a, b]
