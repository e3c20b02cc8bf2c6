"""Named boundaries of O, C and H grids and of volumes, as other programs read them: meshio, VTK, and a map by hand."""

from __future__ import annotations

import itertools
import re
import shlex
from pathlib import Path

import meshio
import numpy as np
import pytest
import pyvista
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOParallel import vtkMultiBlockPLOT3DReader

import meshcore as mc
from meshcore import gallery
from tests.core.io.test_cgns import vtk_output


def lifted() -> mc.StructuredGrid:
    """Layers off a bent patch, whose first and last are named."""
    u, v = np.meshgrid(np.linspace(0, 1, 7), np.linspace(0, 1, 5), indexing="ij")
    patch = mc.StructuredGrid(np.stack([u, v, 0.1 * np.sin(3 * u) * v], axis=-1)[:, :, None])
    return mc.hyperbolic_volume(patch, layers=4, first_height=0.05).mesh


GRIDS = {
    "o": lambda: mc.o_grid(gallery.airfoil("naca0012"), radius=3, first_height=0.01).mesh,
    "c": lambda: mc.c_grid(gallery.airfoil("naca0012"), radius=3, first_height=0.01).mesh,
    "h": lambda: mc.h_grid(gallery.airfoil("naca0012"), radius=3, first_height=0.01).mesh,
    "volume": lifted,
}


@pytest.fixture(scope="module", params=GRIDS)
def made(request) -> mc.StructuredGrid | mc.MultiBlock:
    return GRIDS[request.param]()


def sides(grid: mc.StructuredGrid | mc.MultiBlock) -> dict[str, list[tuple]]:
    """Points of the cells of each named side, straight from the grid's patches, in order."""
    blocks = grid.blocks if isinstance(grid, mc.MultiBlock) else (grid,)
    found: dict[str, list[tuple]] = {}
    for patch in mc.patches(grid):
        found.setdefault(patch.name, []).extend(cells_of(blocks[patch.block].points, *patch.points))
    return {name: sorted(cells) for name, cells in found.items()}


def cells_of(points: np.ndarray, low: tuple, high: tuple) -> list[tuple]:
    """Lines or quads of a rectangle of points, each as its sorted points."""
    part = np.squeeze(points[tuple(slice(a, b + 1) for a, b in zip(low, high, strict=True))])
    if part.ndim == 2:
        return [rounded([a, b]) for a, b in itertools.pairwise(part)]
    corners = np.stack([part[:-1, :-1], part[1:, :-1], part[1:, 1:], part[:-1, 1:]], axis=2)
    return [rounded(quad) for quad in corners.reshape(-1, 4, 3)]


def rounded(points: np.ndarray) -> tuple:
    return tuple(sorted(tuple(row) for row in (np.round(points, 9) + 0.0).tolist()))


def test_markers_of_su2_as_meshio_reads_them(made, tmp_path):
    """meshio counts markers from 1 instead of reading their names, which stand in the file in the same order."""
    mc.io.write(tmp_path / "a.su2", made)
    found = meshio.su2.read(tmp_path / "a.su2")
    points = np.pad(found.points, ((0, 0), (0, 3 - found.points.shape[1])))
    names = re.findall(r"MARKER_TAG= (.*)", (tmp_path / "a.su2").read_text())
    markers: dict[str, list[tuple]] = {name: [] for name in names}
    domain = 0
    for block, tags in zip(found.cells, found.cell_data["su2:tag"], strict=True):
        domain += int((tags == 0).sum())
        for cell, tag in zip(block.data, tags, strict=True):
            if tag:
                markers[names[tag - 1]].append(rounded(points[cell]))
    assert domain == made.n_cells
    assert {name: sorted(cells) for name, cells in markers.items()} == {
        name.replace(" ", "_"): cells for name, cells in sides(made).items()
    }


def test_conditions_of_cgns_as_vtk_reads_them(made, tmp_path):
    """From structured zones and from an unstructured one."""
    expected = sides(made)
    for what in (made, mc.with_named_sides(made)):
        mc.io.write(tmp_path / "a.cgns", what)
        found: dict[str, list[tuple]] = {}
        for name, block in vtk_output(tmp_path / "a.cgns"):
            plain = re.sub(r" \d+$", "", name)
            if plain in expected:
                points = vtk_to_numpy(block.GetPoints().GetData())
                for k in range(block.GetNumberOfCells()):
                    cell = block.GetCell(k)
                    ids = [cell.GetPointId(n) for n in range(cell.GetNumberOfPoints())]
                    found.setdefault(plain, []).append(rounded(points[ids]))
        assert {name: sorted(cells) for name, cells in found.items()} == expected


def vtk_plot3d(path: Path) -> list[np.ndarray]:
    """Points of each block, i first, as VTK reads them."""
    reader = vtkMultiBlockPLOT3DReader()
    reader.SetFileName(str(path))
    reader.AutoDetectFormatOn()
    reader.SetDoublePrecision(True)
    reader.Update()
    output = reader.GetOutput()
    blocks = [pyvista.wrap(output.GetBlock(k)) for k in range(output.GetNumberOfBlocks())]
    return [np.reshape(b.points, (*b.dimensions[::-1], 3)).transpose(2, 1, 0, 3) for b in blocks]


FACES = {1: (2, 0), 2: (2, -1), 3: (0, 0), 4: (0, -1), 5: (1, 0), 6: (1, -1)}  # kmin kmax imin imax jmin jmax


def face_points(blocks: list[np.ndarray], columns: list[int]) -> np.ndarray:
    """(n, m, 3) points of a range of a neutral map: B F S1 E1 S2 E2, the first range running along the first axis."""
    block, face, s1, e1, s2, e2 = columns
    axis, end = FACES[face]
    side = np.take(blocks[block - 1], end, axis=axis)
    side = side.swapaxes(0, 1) if axis == 1 else side  # across j the axes go on with k, then i
    for k, (first, last) in enumerate(((s1, e1), (s2, e2))):
        index = np.arange(first, last + np.sign(last - first or 1), np.sign(last - first or 1)) - 1
        side = np.take(side, index, axis=k)
    return side


def test_plot3d_and_its_map_as_read_by_vtk_and_by_hand(made, tmp_path):
    mc.io.write(tmp_path / "a.p3d", made)
    blocks = vtk_plot3d(tmp_path / "a.p3d")
    own = made.blocks if isinstance(made, mc.MultiBlock) else (made,)
    assert [b.tolist() for b in blocks] == [b.points.tolist() for b in own]
    rows = [shlex.split(line, comments=True) for line in (tmp_path / "a.nmf").read_text().splitlines()]
    rows = [row for row in rows if len(row) > 6]
    found: dict[str, list[tuple]] = {}
    for name, *words in rows:
        here = face_points(blocks, [int(word) for word in words[:6]])
        if name != "ONE_TO_ONE":
            assert len(words) == 6
            low, high = (0, 0, 0), (here.shape[0] - 1, here.shape[1] - 1, 0)
            found.setdefault(name, []).extend(cells_of(here[:, :, None], low, high))
            continue
        there = face_points(blocks, [int(word) for word in words[6:12]])
        there = there.swapaxes(0, 1) if words[12] == "TRUE" else there
        np.testing.assert_allclose(here, there, atol=1e-9)
    assert {name: sorted(cells) for name, cells in found.items()} == sides(made)
    joins = len(made.joins) if isinstance(made, mc.MultiBlock) else len(made.cuts) + sum(made.periodic)
    assert sum(row[0] == "ONE_TO_ONE" for row in rows) == joins
