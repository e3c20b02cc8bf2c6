"""Writing Gmsh's .msh, version 2.2, and the kinds of cell and order of nodes that reading shares."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from ..mesh import CELL_TYPES, Mesh
from .fit import sets_as_tags, warn_dropped
from .lines import rows_of

KINDS = {
    15: "vertex", 1: "line", 2: "triangle", 3: "quad", 4: "tetra", 5: "hexahedron", 6: "wedge", 7: "pyramid",
    8: "line3", 9: "triangle6", 16: "quad8", 10: "quad9", 11: "tetra10", 17: "hexahedron20", 18: "wedge15",
    19: "pyramid13", 12: "hexahedron27", 13: "wedge18",
}  # fmt: skip
NUMBERS = {kind: number for number, kind in KINDS.items()}
# The order of the edges that carry the middle nodes; VTK's is that of CELL_TYPES.
_EDGES = {
    "tetra10": ((0, 1), (1, 2), (0, 2), (0, 3), (2, 3), (1, 3)),
    "hexahedron20": ((0, 1), (0, 3), (0, 4), (1, 2), (1, 5), (2, 3), (2, 6), (3, 7), (4, 5), (4, 7), (5, 6), (6, 7)),
    "wedge15": ((0, 1), (0, 2), (0, 3), (1, 2), (1, 4), (2, 5), (3, 4), (3, 5), (4, 5)),
    "pyramid13": ((0, 1), (0, 3), (0, 4), (1, 2), (1, 4), (2, 3), (2, 4), (3, 4)),
}
_EDGES |= {"hexahedron27": _EDGES["hexahedron20"], "wedge18": _EDGES["wedge15"]}
# For the middles of faces, and of the cell, in VTK's order their places in Gmsh's.
_FACES = {"hexahedron27": (2, 3, 1, 4, 0, 5, 6), "wedge18": (0, 2, 1)}


def node_order(kind: str) -> np.ndarray:
    """For each node in VTK's order its place in Gmsh's."""
    if kind not in _EDGES:
        return np.arange(CELL_TYPES[kind].nodes)
    corners = CELL_TYPES[CELL_TYPES[kind].linear].nodes
    place = {edge: corners + k for k, edge in enumerate(_EDGES[kind])}
    middles = [place[min(e), max(e)] for e in CELL_TYPES[kind].edges]
    inside = [corners + len(middles) + k for k in _FACES.get(kind, ())]
    return np.array([*range(corners), *middles, *inside])


def write_msh(path: Path, mesh: Mesh, *, binary: bool = True) -> None:
    """Version 2.2, which every tool reads; a cell is in one physical group at most."""
    spans = [(kind, cells, where, CELL_TYPES[kind].dimension) for kind, cells, where in mesh.blocks()]
    dimension = np.concatenate([np.empty(0, np.int64), *(np.full(len(c), d) for _, c, _, d in spans)])
    odd = [name for name in mesh.sets if '"' in name or "\n" in name or not name.strip()]
    warn_dropped("sets", odd, "a physical group's name has no quotes and is not empty")
    tags, names = sets_as_tags(replace(mesh, sets={n: m for n, m in mesh.sets.items() if n not in odd}), "Gmsh")
    tags = np.zeros(mesh.n_cells, np.int64) if tags is None else tags
    parts = [f"$MeshFormat\n2.2 {int(binary)} 8\n".encode()]
    parts += [np.int32(1).tobytes(), b"\n"] if binary else []
    parts.append(b"$EndMeshFormat\n")
    if names:
        rows = [
            f'{d} {k} "{name}"'
            for k, name in enumerate(names, 1)
            for d in np.unique(dimension[mesh.sets[name]]).tolist()
        ]
        parts.append("\n".join(["$PhysicalNames", str(len(rows)), *rows, "$EndPhysicalNames\n"]).encode())
    parts.append(f"$Nodes\n{mesh.n_points}\n".encode())
    parts.append(_rows(mesh.points, binary))
    parts.append(f"$EndNodes\n$Elements\n{mesh.n_cells}\n".encode())
    for kind, cells, where, _ in spans:
        order = np.argsort(node_order(kind))
        group = tags[where]
        rows = np.column_stack([np.arange(where.start, where.stop) + 1, group, np.abs(group), cells[:, order] + 1])
        number = NUMBERS[kind]
        if binary:
            parts.append(np.array([number, len(cells), 2], np.int32).tobytes() + rows.astype(np.int32).tobytes())
        else:
            form = f"%s {number} 2" + " %s" * (rows.shape[1] - 1)
            parts.append(rows_of(rows, form=form).encode())
    parts.append(b"\n$EndElements\n" if binary else b"$EndElements\n")
    others = {name: values for name, values in mesh.cell_data.items() if name != "tag"}
    for section, what, arrays in (("NodeData", "point data", mesh.point_data), ("ElementData", "cell data", others)):
        for name, values in _real(arrays, what).items():
            columns = values.shape[1] if values.ndim > 1 else 1
            head = f'${section}\n1\n"{name}"\n1\n0.0\n3\n0\n{columns}\n{len(values)}\n'
            parts += [head.encode(), _rows(values.reshape(-1, columns), binary), f"$End{section}\n".encode()]
    path.write_bytes(b"".join(parts))


def _rows(values: np.ndarray, binary: bool) -> bytes:
    """Rows of real numbers behind their number from 1."""
    if not binary:
        return rows_of(np.arange(len(values)) + 1, values).encode()
    rows = np.zeros(len(values), [("tag", "<i4"), ("value", "<f8", (values.shape[1],))])
    rows["tag"], rows["value"] = np.arange(len(values)) + 1, values
    return rows.tobytes() + b"\n"


def _real(data: dict[str, np.ndarray], what: str) -> dict[str, np.ndarray]:
    """Data that Gmsh holds: real numbers, one, three or nine a row."""
    kept, dropped = {}, []
    for name, values in data.items():
        flat = values.reshape(len(values), -1) if values.ndim > 1 and values.size else values
        if values.dtype.kind not in "biuf" or (flat.ndim > 1 and flat.shape[1] not in (3, 9)) or '"' in name:
            dropped.append(name)
        else:
            kept[name] = flat.astype(float)
    warn_dropped(what, dropped, "Gmsh holds one, three or nine real numbers a row, under a name without quotes")
    return kept
