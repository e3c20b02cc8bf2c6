"""Files: the true mesh of a result, projects with all their layers, and scripts that are really there."""

from __future__ import annotations

import os
import re
import xml.etree.ElementTree as ET
from pathlib import Path

import pymeshlab

from meshcore import InvalidInput, Mesh, StructuredGrid, io

from . import conversion
from .filters import FilterResult, meshlab_errors

SURFACE_FORMATS = (".ply", ".obj", ".stl", ".off", ".dxf", ".wrl", ".x3d", ".dae", ".3ds", ".gltf", ".glb", ".xyz")
"""Extensions that MeshLab reads or writes; any other is meshcore's."""


def write(result: FilterResult | Mesh | StructuredGrid, path: str | os.PathLike[str]) -> None:
    """Write the mesh itself, not its layers, by meshcore's writers: quads, volumes, data and sets are kept.

    Parameters
    ----------
    result : FilterResult, Mesh or StructuredGrid
        What a filter returned, or a mesh.
    path : path
        Its extension names the format, see ``meshcore.io.formats()``.

    Raises
    ------
    pymeshlab.PyMeshLabException
        If the format or the folder does not exist, or the format cannot hold the mesh.
    """
    with meshlab_errors("write"):
        mesh = result.mesh if isinstance(result, FilterResult) else result
        if mesh is None:
            raise InvalidInput("has no mesh; give what a filter returned", parameter="result")
        try:
            io.write(path, mesh)
        except OSError as error:
            raise InvalidInput(f"{path}: {error.strerror or error}", parameter="path") from error


def load(ms: pymeshlab.MeshSet, path: str | os.PathLike[str]) -> None:
    """Load a mesh or a project (.mlp) into a MeshSet; formats that MeshLab lacks are read by meshcore.

    Raises
    ------
    pymeshlab.PyMeshLabException
        If the file, or a mesh of the project, is not there or cannot be read.
    """
    path = Path(path).absolute()
    with meshlab_errors("load"):
        if not path.is_file():
            raise InvalidInput(f"no such file: {path}")
        if path.suffix.lower() == ".mlp":
            missing = [name for name in _meshes_of(path) if not (path.parent / name).is_file()]
            if missing:
                raise InvalidInput(f"{path.name} names {missing[0]!r}, which is not there")
        elif path.suffix.lower() not in SURFACE_FORMATS:
            conversion.add(ms, io.read(path), path.stem, "scaled_jacobian")
            return
    (ms.load_project if path.suffix.lower() == ".mlp" else ms.load_new_mesh)(str(path))


def save(ms: pymeshlab.MeshSet, path: str | os.PathLike[str]) -> None:
    """Save the current layer, or for a project (.mlp) all layers.

    A project names files, and MeshLab gives each layer the name it was last saved by, or none. So each layer is
    saved as PLY beside the project first.

    Raises
    ------
    pymeshlab.PyMeshLabException
        If the folder does not exist or cannot be written to.
    """
    path = Path(path).absolute()
    with meshlab_errors("save"):
        if not path.parent.is_dir():
            raise InvalidInput(f"no such folder: {path.parent}")
    if path.suffix.lower() != ".mlp":
        ms.save_current_mesh(str(path), **_quality_options(path))
        return
    current = ms.current_mesh_id()
    for layer in list(ms):
        name = re.sub(r"[^\w.-]+", "_", layer.label()).strip("_.") or "layer"
        file = path.with_name(f"{path.stem}_{layer.id()}_{name.removesuffix('.ply')}.ply")
        ms.set_current_mesh(layer.id())
        ms.save_current_mesh(str(file), **_quality_options(file))
    ms.set_current_mesh(current)
    ms.save_project(str(path))


def _quality_options(path: Path) -> dict[str, bool]:
    """PLY alone keeps face scalars, if it is told so."""
    return {"save_face_quality": True} if path.suffix.lower() == ".ply" else {}


def _meshes_of(project: Path) -> list[str]:
    """File names in a project."""
    try:
        return [mesh.get("filename", "") for mesh in ET.parse(project).getroot().iter("MLMesh")]
    except ET.ParseError as error:
        raise InvalidInput(f"{project.name} is no MeshLab project: {error}") from None


def apply_script(ms: pymeshlab.MeshSet, path: str | os.PathLike[str]) -> int:
    """Run a MeshLab script (.mlx) and return how many filters it has.

    pymeshlab does nothing, without a word, if the file is missing or empty; here that is an error. A script can
    name MeshLab's own filters only.

    Raises
    ------
    pymeshlab.PyMeshLabException
        If the script is missing, empty, no script, or one of its filters fails.
    """
    path = Path(path).absolute()
    with meshlab_errors("script"):
        if not path.is_file():
            raise InvalidInput(f"no such script: {path}")
        try:
            root = ET.parse(path).getroot()
        except ET.ParseError as error:
            raise InvalidInput(f"{path.name} is no MeshLab script: {error}") from None
        count = len(root.findall("filter")) + len(root.findall("xmlfilter"))
        if root.tag != "FilterScript" or not count:
            raise InvalidInput(f"{path.name} has no filters")
    ms.clear_filter_script()
    try:
        ms.load_filter_script(str(path))
        ms.apply_filter_script()
    except pymeshlab.PyMeshLabException as error:
        reason = next(iter(str(error).strip().splitlines()), "failed")
        hint = "a script can name MeshLab's own filters only, as its menus do"
        raise pymeshlab.PyMeshLabException(f"script: {path.name}: {reason} ({hint})") from error
    return count
