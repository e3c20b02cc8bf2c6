"""Sound structured volumes are summed up from their points as from a mesh of their cells; others take the long way."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshcore import StructuredGrid
from meshcore.errors import GenerationFailed
from meshcore.quality import _block_kernels as kernels
from meshcore.quality import measure, summary, validate
from meshcore.quality.block import is_sound, sound_summary
from meshcore.quality.solid import corner_jacobians


def jittered(seed, size, shape=(4, 3, 5)):
    lattice = np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), axis=-1).astype(float)
    return lattice + size * np.random.default_rng(seed).uniform(-1, 1, lattice.shape)


@given(st.integers(0, 10**6), st.floats(0, 0.7))
def test_equals_the_summary_of_the_cells(seed, size):
    grid = StructuredGrid(jittered(seed, size) * [1, 2, 0.3])
    mesh = grid.to_mesh()
    fast = sound_summary(grid)
    folded = measure(mesh, "jacobian").min() <= 0  # this counts the centre, too
    corners = validate(mesh, raise_=False)
    assert (fast is None) == (not is_sound(grid)) == bool(corners)
    if fast is not None:
        assert fast == pytest.approx(summary(mesh), rel=1e-12)
        assert validate(grid) == []
    else:
        assert folded
        assert summary(grid) == summary(mesh)
        with pytest.raises(GenerationFailed, match="not positively oriented") as caught:
            validate(grid)
        assert caught.value.cells == tuple(corners[0].cells)


@pytest.mark.parametrize("scale", [1e-120, 1e-60, 1e-30, 1e30, 1e60, 1e120])
def test_extreme_sizes_take_the_long_way(scale):
    grid = StructuredGrid(jittered(1, 0.1) * scale)
    assert sound_summary(grid) is None or sound_summary(grid) == pytest.approx(
        sound_summary(StructuredGrid(jittered(1, 0.1)))
    )


def test_flat_cells_are_not_its_affair():
    flat = jittered(1, 0)
    flat[..., 2] = 0
    assert sound_summary(StructuredGrid(flat)) is None and not is_sound(StructuredGrid(flat))
    assert sound_summary(None) is None and not is_sound(None)


@given(st.integers(0, 10**6), st.floats(0, 0.7))
def test_least_determinant_is_that_of_all_corners(seed, size):
    points = jittered(seed, size)
    corners = corner_jacobians("hexahedron", cell_corners(points))
    assert kernels.least_determinant(points) == pytest.approx(corners.min(), abs=1e-12)


def cell_corners(points):
    mesh = StructuredGrid(points).to_mesh()
    return mesh.points[mesh.get("hexahedron")]
