"""Sound structured surfaces are told and summed up from their points as from a mesh of their cells."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshcore import StructuredGrid
from meshcore.errors import GenerationFailed, InvalidGeometry
from meshcore.quality import measure, summary, validate
from meshcore.quality.block import is_sound, sound_summary
from meshcore.structured.folds import folded_cells, refuse_folds

ATTITUDES = {
    "z = 0": lambda x, y: (x, y, 0 * x),
    "z = 3": lambda x, y: (x, y, 0 * x + 3),
    "x = 2": lambda x, y: (0 * x + 2, x, y),
    "tilted": lambda x, y: (x, y, 0.5 * x - 2 * y),
    "curved": lambda x, y: (x, y, 0.3 * x**2 - 0.2 * x * y),
    "sphere": lambda x, y: (np.cos(x) * np.cos(y / 3), np.sin(x) * np.cos(y / 3), np.sin(y / 3)),
}


def lattice(shape=(5, 4)):
    return np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), axis=-1).astype(float)


def laid(plane, attitude):
    return StructuredGrid(np.stack(ATTITUDES[attitude](plane[..., 0], plane[..., 1]), axis=-1))


def jittered(seed, size, attitude, stretch=1.0):
    plane = lattice() + size * np.random.default_rng(seed).uniform(-1, 1, (5, 4, 2))
    return laid(plane * [1, stretch], attitude)


def orientation_of_cells(grid):
    return [fault for fault in validate(grid.to_mesh(), raise_=False) if fault.name == "orientation"]


def slow_summary(grid):
    mesh = grid.to_mesh()
    return {
        "smallest angle (degree)": measure(mesh, "min_angle").min(),
        "largest angle (degree)": measure(mesh, "max_angle").max(),
        "mean radius ratio": measure(mesh, "radius_ratio").mean(),
        "worst scaled jacobian": measure(mesh, "scaled_jacobian").min(),
    }


@given(
    st.integers(0, 10**6),
    st.floats(0, 0.6),
    st.sampled_from(list(ATTITUDES)),
    st.sampled_from([1.0, 1e-3, 1e-6, -1.0]),
)
def test_equals_what_a_mesh_of_the_cells_says(seed, size, attitude, stretch):
    grid = jittered(seed, size, attitude, stretch)
    told, faults = validate(grid, raise_=False), orientation_of_cells(grid)
    assert [(fault.message, fault.cells.tolist()) for fault in told] == [
        (fault.message, fault.cells.tolist()) for fault in faults
    ]
    assert not (is_sound(grid) and faults)
    assert summary(grid) == pytest.approx(slow_summary(grid), rel=1e-9)


@given(st.integers(0, 10**6), st.floats(0, 0.6), st.sampled_from(list(ATTITUDES)))
def test_folds_are_refused_as_cell_by_cell(seed, size, attitude):
    grid = jittered(seed, size, attitude)
    folded = folded_cells(grid.points[:, :, 0])
    if not folded.any():
        return refuse_folds(grid, "")
    with pytest.raises(GenerationFailed) as caught:
        refuse_folds(grid, "")
    assert list(caught.value.cells) == np.flatnonzero(folded.ravel(order="F")).tolist()


@pytest.mark.parametrize("attitude", list(ATTITUDES))
def test_good_grids_take_the_quick_way(attitude):
    """Else all the rest here would hold of nothing."""
    grid = jittered(3, 0.2, attitude)
    assert sound_summary(grid) is not None
    assert is_sound(grid) or attitude == "sphere"


def moved(point, to, attitude):
    plane = lattice()
    plane[point] = to
    return laid(plane, attitude)


FAULTS = {
    "a cell turned over": moved((2, 2), (2, 0.5), "z = 3"),
    "a reflex corner": moved((2, 2), (1.4, 1.4), "x = 2"),
    "a flat corner": moved((2, 3), (3, 3), "z = 0"),
    "three points in line": moved((0, 0), (0.5, 0.5), "z = 0"),
    "two points at one place": moved((2, 2), (2, 1), "z = 3"),
    "four points at one place": laid(np.where(lattice()[..., :1] < 2, 0, lattice()), "z = 3"),
    "seen from below": laid(lattice() * [1, -1], "z = 0"),
    "folded over along a line": laid(np.abs(lattice() - [2, 0]), "z = 3"),
    "folded over in another plane": laid(np.abs(lattice() - [0, 1]), "x = 2"),
}


@pytest.mark.parametrize("fault", list(FAULTS))
def test_what_is_at_fault_is_found(fault):
    grid = FAULTS[fault]
    assert not is_sound(grid)
    with pytest.raises(GenerationFailed, match="not positively oriented") as caught:
        validate(grid)
    assert list(caught.value.cells) == orientation_of_cells(grid)[0].cells.tolist()
    if fault != "seen from below":  # which is a question of what the plane's upper side is
        with pytest.raises(GenerationFailed, match="folded or flat"):
            refuse_folds(grid, "")
    assert summary(grid) == pytest.approx(slow_summary(grid), rel=1e-9, nan_ok=True)


def test_what_a_structured_grid_cannot_have():
    """Points that are not finite are no grid's; all points belong to cells, and facets to the cells beside them."""
    points = lattice()
    points[1, 1] = np.nan
    with pytest.raises(InvalidGeometry):
        StructuredGrid(points)
    faults = {fault.name for fault in validate(laid(lattice(), "z = 0").to_mesh(), raise_=False)}
    assert not faults & {"orphan points", "conformity", "repeated cells"}


def test_corners_flat_but_for_rounding_take_the_long_way():
    """The exact predicate tells whether a corner that arithmetic cannot judge is positive."""
    for nudge in (-1e-16, 0.0, 1e-16, 1e-13):
        grid = moved((0, 0), (0.5, 0.5 - nudge), "z = 0")
        assert not is_sound(grid)
        assert bool(validate(grid, raise_=False)) == bool(orientation_of_cells(grid))


@pytest.mark.parametrize("attitude", list(ATTITUDES))
def test_poles_take_the_long_way(attitude):
    plane = lattice()
    plane[0] = plane[0].mean(axis=0)
    grid = laid(plane, attitude)
    assert sound_summary(grid) is None
    assert summary(grid) == pytest.approx(slow_summary(grid), rel=1e-9)


@pytest.mark.parametrize("scale", [1e-120, 1e-60, 1e-35, 1e-20, 1e20, 1e35, 1e60, 1e120])
def test_extreme_sizes_take_the_long_way(scale):
    good = jittered(1, 0.1, "z = 0")
    grid = good.with_points(good.points * scale)
    assert sound_summary(grid) is None or sound_summary(grid) == pytest.approx(sound_summary(good), rel=1e-9)
    assert validate(grid) == []


def test_closed_grids_are_summed_up_as_their_glued_cells():
    angle = np.linspace(0, 2 * np.pi, 9)
    angle, radius = np.meshgrid(-angle, [1.0, 1.5, 3.0], indexing="ij")
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)
    points[-1] = points[0]
    grid = StructuredGrid(points, periodic=(True, False, False))
    assert is_sound(grid)
    assert summary(grid) == pytest.approx(slow_summary(grid), rel=1e-12)
