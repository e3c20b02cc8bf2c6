"""Named boundaries of volume meshes, by a slow and obvious count of their cells' faces."""

from __future__ import annotations

from collections import Counter

import numpy as np

from meshcore import Mesh

_FACES = {
    "wedge": ((0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0)),
    "hexahedron": ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
}


def solid(mesh: Mesh) -> Mesh:
    """The volume cells alone."""
    return Mesh(mesh.points, {kind: cells for kind, cells in mesh.cells.items() if kind in _FACES})


def sides_of_volumes(mesh: Mesh) -> dict[str, np.ndarray]:
    """(k,) numbers of the boundary's cells by name, once each face of one cell only is found in one set, outwards."""
    seen: dict[frozenset[int], list[np.ndarray]] = {}
    for kind, faces in _FACES.items():
        for cell in mesh.get(kind).tolist():
            for face in faces:
                seen.setdefault(frozenset(cell[k] for k in face), []).append(mesh.points[cell].mean(axis=0))
    single = {nodes: inside[0] for nodes, inside in seen.items() if len(inside) == 1}
    sided = {}
    for kind, cells, where in mesh.blocks():
        if kind in ("triangle", "quad"):
            sided |= dict(zip(range(where.start, where.stop), cells.tolist(), strict=True))
    assert sorted(map(sorted, sided.values())) == sorted(map(sorted, single))
    for nodes in sided.values():
        x = mesh.points[nodes]
        normal = np.cross(x[2] - x[0], x[-1] - x[1])
        assert normal @ (x.mean(axis=0) - single[frozenset(nodes)]) > 0
    members = Counter(number for cells in mesh.sets.values() for number in cells.tolist())
    assert members == Counter(list(sided))  # each once
    return mesh.sets


def middles(mesh: Mesh, name: str) -> np.ndarray:
    """(k, 3) middles of the cells of a set."""
    return mesh.centroids[mesh.sets[name]]
