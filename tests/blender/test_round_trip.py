"""Each operation by its model call: geometry made in Blender, through the operator, the same as meshcore gives."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from tests.blender import scene

OPERATIONS = json.loads((Path(__file__).parent.parent / "registry.json").read_text())


def expected(core, identifier):
    """What meshcore makes of the gallery's model, with coordinates as Blender has them."""
    from meshcore import gallery

    inputs, keywords = gallery.arguments(identifier)
    inputs = [scene.rounded(mesh) for mesh in inputs]
    result = core.operations()[identifier].function(*inputs, **keywords)
    return inputs, keywords, shown(core, result.mesh), result.report


def shown(core, mesh):
    """A result as Blender shows it: polyhedra each on its own, structured grids as quads."""
    if isinstance(mesh, core.PolyhedralMesh):
        return mesh.separated() if mesh.dimension == 3 else mesh
    return mesh if isinstance(mesh, core.Mesh) else mesh.to_mesh()


def faces_of(core, mesh):
    """The nodes of each face."""
    if isinstance(mesh, core.PolyhedralMesh):
        return [nodes.tolist() for nodes in np.split(mesh.face_nodes, mesh.face_offsets[1:-1])]
    if mesh.dimension == 1:
        return []
    mesh = mesh.boundary if mesh.dimension == 3 else mesh
    return [cell for cells in mesh.cells.values() for cell in cells.tolist()]


@pytest.mark.parametrize("identifier", OPERATIONS)
def test_operator_gives_what_meshcore_gives(core, identifier):
    inputs, keywords, mesh, report = expected(core, identifier)
    objects = [scene.from_core(f"input {k}", one) for k, one in enumerate(inputs)]
    scene.activate(*objects)
    assert scene.operator(identifier)(**keywords) == {"FINISHED"}
    ob = scene.active()
    assert ob not in objects
    np.testing.assert_allclose(scene.world_points(ob), mesh.points, rtol=0, atol=scene.SINGLE * mesh.diagonal)
    assert scene.faces(ob) == faces_of(core, mesh)
    order = slice(None)
    if mesh.dimension == 1:  # Blender may have put its edges in another order
        edges = [sorted(edge.vertices) for edge in ob.data.edges]
        assert sorted(edges) == sorted(map(sorted, mesh.get("line").tolist()))
        order = [edges.index(sorted(line)) for line in mesh.get("line").tolist()]
    for name, values in mesh.point_data.items():
        np.testing.assert_allclose(scene.values(ob, name), values, rtol=scene.SINGLE, atol=scene.SINGLE)
    for name, values in mesh.cell_data.items():
        if mesh.dimension == 3:  # its faces have what the cells behind them have
            values = values[mesh.boundary.cell_data["cell"]]
        np.testing.assert_allclose(scene.values(ob, name)[order], values, rtol=scene.SINGLE, atol=scene.SINGLE)
    assert dict(ob.data["meshcore_report"]["counts"]) == report.counts


@pytest.mark.parametrize("identifier", OPERATIONS)
def test_sources_stay_as_they_were(core, identifier):
    inputs, keywords, _, _ = expected(core, identifier)
    objects = [scene.from_core(f"input {k}", one) for k, one in enumerate(inputs)]
    scene.activate(*objects)
    scene.operator(identifier)(**keywords)
    for ob, mesh in zip(objects, inputs, strict=True):
        np.testing.assert_array_equal(scene.world_points(ob), mesh.points)
        assert not ob.data.validate()
