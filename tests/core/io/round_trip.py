"""Meshes that formats have to keep, and the one comparison of what went out with what came back."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np

import meshcore as mc

# Values with infinite binary expansions: a digit less than all is seen.
POINTS = np.array(
    [
        [0, 0, 0],
        [1 / 3, 0, 0],
        [1 / 3, 1 / 7, 0],
        [0, 1 / 7, 0],
        [2 / 3, 1 / 11, 0],
        [1 / 13, 0.9, 0],
        [-1e-17, 3e17, 0],
    ]
)
SPACE = POINTS + np.outer(np.sqrt(np.arange(7)), [0, 0, 1 / 17])


def curve(*, space: bool = False) -> mc.Mesh:
    """Lines in two pieces."""
    return mc.Mesh((SPACE if space else POINTS)[:6], {"line": [[0, 1], [1, 2], [4, 5]]})


def surface(*, space: bool = False) -> mc.Mesh:
    """Triangles and a quad, positively oriented in the plane."""
    return mc.Mesh((SPACE if space else POINTS)[:6], {"triangle": [[1, 4, 2], [3, 2, 5]], "quad": [[0, 1, 2, 3]]})


def volume() -> mc.Mesh:
    """A hexahedron, a wedge, a pyramid and a tetrahedron that share faces."""
    x, y, z = np.meshgrid([0, 1 / 3], [0, 1 / 7], [0, 1 / 11], indexing="ij")
    cube = np.column_stack([x.ravel(), y.ravel(), z.ravel()])[[0, 4, 6, 2, 1, 5, 7, 3]]
    more = np.array([[1 / 6, 1 / 14, 0.3], [0.6, 0, 0], [0.6, 0, 1 / 11], [0.8, 0.1, 0.4]])
    cells = {
        "hexahedron": [[0, 1, 2, 3, 4, 5, 6, 7]],
        "wedge": [[1, 9, 2, 5, 10, 6]],
        "pyramid": [[4, 5, 6, 7, 8]],
        "tetra": [[5, 10, 6, 11]],
    }
    return mc.Mesh(np.concatenate([cube, more]), cells)


def with_data(mesh: mc.Mesh, *, vectors: bool = True) -> mc.Mesh:
    """Numbers and, where asked, vectors on points and cells."""
    point_data = {"u": np.sqrt(np.arange(mesh.n_points)) / 3}
    cell_data = {"f": np.cbrt(np.arange(mesh.n_cells)) / 7}
    if vectors:
        point_data["velocity"] = np.sin(np.arange(3.0 * mesh.n_points)).reshape(-1, 3)
        cell_data["normal"] = np.cos(np.arange(3.0 * mesh.n_cells)).reshape(-1, 3)
    return mc.Mesh(mesh.points, mesh.cells, point_data, cell_data, mesh.sets, mesh.field_data)


def with_sets(mesh: mc.Mesh) -> mc.Mesh:
    """Two sets that share no cell; their names have a blank and a letter beyond ASCII."""
    last = mesh.n_cells - 1
    return mc.Mesh(mesh.points, mesh.cells, mesh.point_data, mesh.cell_data, {"upper wall": [last], "Öffnung": [0]})


def grid(*, layers: int = 3) -> mc.StructuredGrid:
    """A curved block."""
    i, j, k = np.meshgrid(np.arange(4), np.arange(3), np.arange(layers), indexing="ij")
    return mc.StructuredGrid(np.stack([i / 3 + 0.1 * np.sin(j), j / 7, k / 11], axis=-1))


def same(found: Any, expected: Any) -> None:
    """Types, points, cells in their order, data and sets are equal to the last bit."""
    assert type(found) is type(expected)
    if isinstance(expected, mc.MultiBlock):
        assert found.names == expected.names
        for a, b in zip(found.blocks, expected.blocks, strict=True):
            same(a, b)
        return
    np.testing.assert_array_equal(found.points, expected.points)
    if isinstance(expected, mc.Mesh):
        assert list(found.cells) == list(expected.cells)
        for kind in expected.cells:
            np.testing.assert_array_equal(found.cells[kind], expected.cells[kind])
        assert set(found.sets) == set(expected.sets)
        for name, members in expected.sets.items():
            np.testing.assert_array_equal(found.sets[name], np.sort(members))
        same_arrays(found.field_data, expected.field_data)
    else:
        assert found.names == expected.names
        assert tuple(found.periodic) == tuple(expected.periodic)
    same_arrays(found.point_data, expected.point_data)
    same_arrays(found.cell_data, expected.cell_data)


def same_arrays(found: dict, expected: dict) -> None:
    assert set(found) == set(expected)
    for name, values in expected.items():
        np.testing.assert_array_equal(found[name], values)


def round_trip(folder: Path, extension: str, mesh: Any, **options: Any) -> Any:
    """What comes back of a mesh written in silence."""
    path = folder / f"mesh{extension}"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        mc.io.write(path, mesh, **options)
        return mc.io.read(path)


def check(folder: Path, extension: str, mesh: Any, **options: Any) -> None:
    same(round_trip(folder, extension, mesh, **options), mesh)
