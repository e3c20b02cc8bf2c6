"""Polyhedra that are tetrahedra, pyramids, wedges or hexahedra, as cells of these kinds."""

from __future__ import annotations

import numpy as np

from ..mesh import PolyhedralMesh
from .polyhedra import rows_of_cells

# Triangles and quads of each kind, and the corners of the face that it stands on.
_KINDS = {(4, 0): ("tetra", 3), (4, 1): ("pyramid", 4), (2, 3): ("wedge", 3), (0, 6): ("hexahedron", 4)}


def standard_cells(mesh: PolyhedralMesh) -> tuple[dict[str, np.ndarray], np.ndarray] | None:
    """Cells by kind, and the polyhedron that each is; None if some polyhedron is of no such kind.

    A kind is told by the number of triangles and quads. Its cell stands on one face, and over each corner of it lies
    the corner that an edge leads to, or the apex.
    """
    rows, nodes, count = rows_of_cells(mesh)
    sizes = np.diff(rows)
    cell = np.repeat(np.arange(mesh.n_cells), count)
    threes, fours = (np.bincount(cell[sizes == size], minlength=mesh.n_cells) for size in (3, 4))
    cells, origin = {}, []
    order = np.lexsort((sizes, cell))  # in each cell the triangles come first
    first = np.cumsum(count) - count
    for (three, four), (kind, base) in _KINDS.items():
        where = np.flatnonzero((threes == three) & (fours == four) & (count == three + four))
        if not len(where):
            continue
        faces = order[first[where][:, None] + np.arange(three + four)]
        tables = [
            nodes[rows[faces[:, span]][:, :, None] + np.arange(size)]
            for span, size in ((slice(0, three), 3), (slice(three, None), 4))
        ]
        bottom = tables[base - 3][:, 0]
        edges = np.concatenate([_edges(table) for table in tables], axis=1)
        made = _on_their_base(bottom[:, ::-1], edges, apex=kind in ("tetra", "pyramid"))
        if made is None:
            return None
        cells[kind] = made
        origin.append(where)
    found = np.concatenate(origin) if origin else np.empty(0, np.int64)
    return (cells, found) if len(found) == mesh.n_cells else None


def _edges(faces: np.ndarray) -> np.ndarray:
    """(m, k, 2) int: from node to node round each of some cells' faces."""
    return np.stack([faces, np.roll(faces, -1, axis=2)], axis=-1).reshape(len(faces), -1, 2)


def _on_their_base(base: np.ndarray, edges: np.ndarray, *, apex: bool) -> np.ndarray | None:
    """Cells on their bases, or None if an edge from a base leads nowhere or two lead to one corner."""
    leaves = ~(edges[:, :, 1, None] == base[:, None]).any(axis=2)
    over = []
    for corner in base.T:
        up = leaves & (edges[:, :, 0] == corner[:, None])
        if (up.sum(axis=1) != 1).any():
            return None
        over.append(edges[np.arange(len(edges)), np.argmax(up, axis=1), 1])
    top = np.sort(np.stack(over, axis=1), axis=1)
    different = (top[:, 1:] != top[:, :-1]).all(axis=1)
    if apex:
        return np.column_stack([base, over[0]]) if (top[:, 0] == top[:, -1]).all() else None
    return np.column_stack([base, *over]) if different.all() else None
