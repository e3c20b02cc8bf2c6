"""Medit's .mesh, by meshio; references are ``tag`` of cells and points, or sets.

Names of sets stand in a comment behind the end, which `read` understands and other programs pass over.

References
----------
P. J. Frey, "Medit: an interactive mesh visualization software", INRIA RT-0253 (2001).
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InvalidInput, MissingLibrary
from ..mesh import CELL_TYPES, Mesh
from .content import text_of
from .fit import Holds, sets_as_tags, warn_dropped
from .registry import register

_REFERENCE = "medit:ref"
_NAMES = "# meshcore sets "
_KINDS = ("line", "triangle", "quad", "tetra", "hexahedron", "wedge", "pyramid")


def _medit() -> Any:
    """meshio's module of this format: its general entrance ends the process on a bad file."""
    try:
        import meshio
    except ImportError:
        raise MissingLibrary("meshio", "reading and writing Medit files") from None
    return meshio


def _merged(found: Any) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Cells and cell data of a meshio mesh, blocks of the same kind joined."""
    kinds: dict[str, list[int]] = {}
    for k, block in enumerate(found.cells):
        if block.type not in CELL_TYPES:
            raise InvalidInput(f"it has {len(block.data)} {block.type} cells, which a Mesh does not hold")
        kinds.setdefault(block.type, []).append(k)
    cells = {
        kind: np.concatenate(
            [np.asarray(found.cells[k].data, np.int64).reshape(-1, CELL_TYPES[kind].nodes) for k in ks]
        )
        for kind, ks in kinds.items()
    }
    order = [k for ks in kinds.values() for k in ks]
    data = {name: np.concatenate([np.asarray(v[k]) for k in order]) for name, v in found.cell_data.items() if order}
    return cells, data


def read_mesh(path: Path) -> Mesh:
    """Any mesh of cells with straight edges; required and corner entities are not read."""
    text = text_of(path)
    if not re.search(r"^\s*MeshVersionFormatted\b", text, flags=re.MULTILINE):
        raise InvalidInput("it has no MeshVersionFormatted")
    if not re.search(r"^\s*End\b", text, flags=re.MULTILINE):
        raise InvalidInput("it does not end with 'End', so it is cut off")
    found = _medit().medit.read(path)
    cells, data = _merged(found)
    tags = np.asarray(data.get(_REFERENCE, np.zeros(0)), np.int64)
    names = re.search(f"^{_NAMES}(\\[.*\\])$", text, flags=re.MULTILINE)
    sets, cell_data, point_data = {}, {}, {}
    if names:
        sets = {str(name): np.flatnonzero(tags == k) for k, name in enumerate(json.loads(names.group(1)), 1)}
    elif tags.any():
        cell_data["tag"] = tags
    references = np.asarray(found.point_data.get(_REFERENCE, np.zeros(0)), np.int64)
    if references.any():
        point_data["tag"] = references
    return Mesh(found.points, cells, point_data, cell_data, sets)


def write_mesh(path: Path, mesh: Mesh) -> None:
    """Text with every digit; a planar mesh has dimension 2."""
    meshio = _medit()
    tags, names = sets_as_tags(mesh, "Medit")
    tags = np.zeros(mesh.n_cells, np.int64) if tags is None else tags
    references = mesh.point_data.get("tag", np.zeros(mesh.n_points, np.int64))
    if references.ndim != 1 or references.dtype.kind not in "biu":
        warn_dropped("point data", ["tag"], "Medit needs whole numbers")
        references = np.zeros(mesh.n_points, np.int64)
    whole = meshio.Mesh(
        mesh.points[:, :2] if mesh.is_planar and mesh.dimension < 3 else mesh.points,
        list(mesh.cells.items()),
        point_data={_REFERENCE: references.astype(np.int64)},
        cell_data={_REFERENCE: [tags[where] for _, _, where in mesh.blocks()]},
    )
    meshio.medit.write(path, whole, float_fmt=".17g")
    if names:
        with open(path, "a", encoding="utf-8") as file:
            file.write(f"{_NAMES}{json.dumps(names)}\n")


register(
    "Medit mesh",
    (".mesh",),
    "meshes of cells with straight edges, references as tags or sets (by meshio)",
    Holds(cells=_KINDS, point_data=("tag",), cell_data=("tag",), sets=True),
    read=read_mesh,
    write=write_mesh,
)
