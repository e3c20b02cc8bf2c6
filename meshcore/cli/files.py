"""Files of the command line: read for an input, refuse an output before the work, write, print as JSON."""

from __future__ import annotations

import json
import math
import os
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from ..errors import InvalidInput
from ..mesh import Mesh, MultiBlock, PolyhedralMesh, StructuredGrid

_BLOCKS = ".vtm"
"""What files that hold blocks are called."""


def read(path: Path, port_type: Any = None) -> Any:
    """The mesh in a file, as the type that an input port takes; any type without one."""
    from .. import io

    mesh = io.read(path)
    if port_type is None:
        return mesh
    if isinstance(mesh, MultiBlock) and "MultiBlock" not in str(port_type):
        if len(mesh.blocks) > 1:
            raise InvalidInput(f"{path} holds {len(mesh.blocks)} blocks, and this input is one mesh")
        mesh = mesh.blocks[0]
    if isinstance(mesh, StructuredGrid) and "StructuredGrid" not in str(port_type):
        return mesh.to_mesh()
    if isinstance(mesh, PolyhedralMesh) and "PolyhedralMesh" not in str(port_type):
        return mesh.to_mesh()
    return mesh


def check_names(outputs: Iterable[Path | None], inputs: Iterable[Path] = ()) -> None:
    """Refuse an output that is also an input or another output."""
    from ..io.registry import resolved

    taken = {resolved(path) for path in inputs}
    for path in outputs:
        if path is None:
            continue
        place = resolved(path)
        if place in taken:
            raise InvalidInput(f"{path} is named twice; an output needs a file of its own")
        taken.add(place)


def kind_of(mesh: Any) -> str:
    """ "mesh" or "grid": what an operation makes that gives back what it was given."""
    return "grid" if isinstance(mesh, (StructuredGrid, MultiBlock)) else "mesh"


def check_mesh_file(path: Path, kind: str) -> None:
    """Refuse, before the work, a file that cannot take a result of this kind, of those of `operation`.

    Its format is tried on the smallest mesh, in the folder where the result will stand.
    """
    from .. import io

    corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    smallest: Mesh | PolyhedralMesh | StructuredGrid | MultiBlock = Mesh(corners[:3], {"triangle": [[0, 1, 2]]})
    if kind in ("grid", "blocks", "grid or blocks"):
        smallest = StructuredGrid([[corners[0], corners[3]], [corners[1], corners[2]]])
    if kind == "blocks":
        smallest = MultiBlock((smallest, smallest.with_points(smallest.points + [2, 0, 0])))
    elif kind == "polyhedra":
        smallest = PolyhedralMesh.from_polygons(corners, [[0, 1, 2, 3]])
    with _folder_beside(path) as folder:
        io.write(Path(folder) / path.name, smallest)


def write(path: Path, mesh: Any, kind: str) -> tuple[Path, list[str]]:
    """Write what an operation has made; where it is, and what has to be said of that.

    Whether "grid or blocks" makes one grid or several blocks is only known in the end, when the work is done: a file
    that holds one grid gives way to one that holds blocks.
    """
    from .. import io

    try:
        io.write(path, mesh)
    except InvalidInput:
        if kind != "grid or blocks" or not isinstance(mesh, MultiBlock):
            raise
        held = path.with_suffix(_BLOCKS)
        io.write(held, mesh)
        return held, [f"{path.name} would hold one grid only: the {len(mesh.blocks)} blocks are in {held}"]
    return path, []


def check_picture_file(path: Path | None) -> None:
    """Refuse, before the work, a picture that cannot be written."""
    if path is None:
        return
    if path.suffix.lower() != ".png":
        raise InvalidInput(f"{path}: pictures are PNG files; give a name that ends in .png")
    _folder_beside(path).cleanup()


def check_folder(path: Path | None) -> None:
    """Make the folder of pictures, or refuse before the work what cannot be one."""
    if path is None:
        return
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InvalidInput(f"{path} cannot be a folder: {error.strerror}; give another name") from None


def draw(mesh: Any, path: Path, **options: Any) -> None:
    """A picture of a mesh, put in its place when it is complete."""
    from ..picture import picture

    with _folder_beside(path) as folder:
        picture(mesh, Path(folder) / path.name, **options)
        os.replace(Path(folder) / path.name, path)


def print_json(data: Any) -> None:
    """Print as JSON, which knows neither arrays nor nan.

    Examples
    --------
    >>> print_json({"angle": float("nan"), "sizes": (1, 2.5)})
    {
      "angle": null,
      "sizes": [
        1,
        2.5
      ]
    }
    """

    def plain(value: Any) -> Any:
        if isinstance(value, dict):
            return {str(key): plain(v) for key, v in value.items()}
        if isinstance(value, (list, tuple)):
            return [plain(v) for v in value]
        if hasattr(value, "tolist"):
            return plain(value.tolist())
        if isinstance(value, float) and not math.isfinite(value):
            return None
        return value if value is None or isinstance(value, (bool, int, float, str)) else str(value)

    print(json.dumps(plain(data), indent=2))


def _folder_beside(path: Path) -> tempfile.TemporaryDirectory:
    if path.is_dir():
        raise InvalidInput(f"{path} is a folder; name a file in it")
    if not path.parent.is_dir():
        raise InvalidInput(f"the folder {path.parent} does not exist; make it first")
    try:
        return tempfile.TemporaryDirectory(prefix=".meshcore-", dir=path.parent)
    except OSError as error:
        raise InvalidInput(f"{path} cannot be written: {error.strerror}") from None
