"""Layers of a MeshSet made from meshes, the way a user of pymeshlab makes them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pymeshlab
import pytest

from meshcore import Relative, gallery, operations


def lines_layer(mesh):
    return pymeshlab.Mesh(vertex_matrix=mesh.points, edge_matrix=mesh.get("line").astype(np.int32))


def faces_layer(mesh):
    if len(mesh.get("quad")):
        faces = [*mesh.get("triangle").tolist(), *mesh.get("quad").tolist()]
        return pymeshlab.Mesh(vertex_matrix=mesh.points, face_list_of_indices=faces)
    return pymeshlab.Mesh(vertex_matrix=mesh.points, face_matrix=mesh.get("triangle").astype(np.int32))


def add(ms, mesh, label):
    """Add a mesh of lines or faces with its data as custom attributes; return its id."""
    ms.add_mesh(lines_layer(mesh) if len(mesh.get("line")) else faces_layer(mesh), label)
    for name, values in mesh.point_data.items():
        ms.current_mesh().add_vertex_custom_scalar_attribute(values, name)
    return ms.current_mesh_id()


def with_named_data(mesh, names):
    return replace(mesh, point_data={name: mesh.point_data[name] for name in mesh.point_data.keys() & set(names)})


def model_call(ms, identifier):
    """The gallery's call of an operation, with its inputs as layers: keywords of the filter and the inputs."""
    inputs, given = gallery.arguments(identifier)
    # A filter cannot list a layer's attributes: it sees those only that a parameter names.
    inputs = tuple(with_named_data(mesh, given.values()) for mesh in inputs)
    ports = list(operations()[identifier].inputs)
    keywords = {
        name: pymeshlab.PercentageValue(100 * value.fraction) if isinstance(value, Relative) else value
        for name, value in given.items()
    }
    ids = [add(ms, mesh, port) for port, mesh in zip(ports, inputs, strict=False)]
    keywords.update(zip(ports[1:], ids[1:], strict=False))
    if ids:
        ms.set_current_mesh(ids[0])
    return keywords, inputs, given


@pytest.fixture
def ms():
    return pymeshlab.MeshSet(verbose=False)
