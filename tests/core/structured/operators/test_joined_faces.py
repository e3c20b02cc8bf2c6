"""Finite volumes through cuts: one flux for both sides, the same as inside, balances to round-off, and the order."""

from dataclasses import replace

import numpy as np
import pytest

import meshcore as mc
from meshcore import InvalidInput, MultiBlock, StructuredGrid, gallery
from meshcore.structured import FiniteVolumes
from tests.core.structured.operators.test_joined_lines import close, fields
from tests.curved_grids import order, planar_model, rms
from tests.cut_grids import c_shape, h_cylinder, h_shape, parabolic, quarter_turned, ring, turned_volumes

FLOW = np.array([1.0, -0.5, 0.7])


def with_cut(grid):
    return replace(grid, periodic=(False,) * 3, cuts=grid.joins)


def blocks_of(grid):
    return grid.blocks if isinstance(grid, MultiBlock) else (grid,)


def each(grid, values):
    """Values as lists of blocks, whether there are several or not."""
    return values if isinstance(grid, MultiBlock) else [values]


def middles(points):
    """(cells, 3) means of the corners of cells."""
    for axis in range(3):
        n = points.shape[axis]
        if n > 1:
            points = 0.5 * (np.take(points, range(n - 1), axis) + np.take(points, range(1, n), axis))
    return points


def of_cells(grid, function):
    """A function at the middles of the cells, as `FiniteVolumes` takes it."""
    values = [function(middles(block.points)) for block in blocks_of(grid)]
    return values if isinstance(grid, MultiBlock) else values[0]


def results(grid):
    volumes = FiniteVolumes(grid)
    values, vectors = of_cells(grid, lambda x: fields(x)[0]), of_cells(grid, lambda x: fields(x)[1])
    return (
        volumes.gradient(values),
        volumes.divergence(vectors),
        volumes.laplacian(values),
        volumes.convection(values, vectors, source=0.5),
    )


def polar(n):
    """A disk: lines out from its middle, where a side is collapsed to a point."""
    angle = 2 * np.pi * np.arange(3 * n + 1) / (3 * n)
    radius = np.linspace(0, 1, n + 1)
    points = radius[:, None, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    points[:, -1] = points[:, 0]
    grid = StructuredGrid(points, periodic=(False, True, False))
    return replace(grid, periodic=(False,) * 3, cuts=grid.joins)


GRIDS = {
    "ring": lambda: with_cut(ring(16, 7)),
    "C": lambda: c_shape(8, 16, 8, bend=0.01),
    "H": lambda: h_cylinder(8, bend=0.02),
    "hole": lambda: h_shape(5, bend=0.3),
    "disk": lambda: polar(8),
    "turned once": lambda: quarter_turned(1, 7, bend=0.5),
    "turned thrice": lambda: quarter_turned(3, 7, bend=0.5),
    "c_grid": lambda: mc.c_grid(gallery.airfoil("rae2822", cells=64), radius=2, first_height=0.01).mesh,
    "blunt c_grid": lambda: mc.c_grid(gallery.airfoil("naca0012"), radius=2, first_height=0.01).mesh,
    "h_grid": lambda: mc.h_grid(gallery.airfoil("rae2822"), radius=2, first_height=0.01).mesh,
    "slit": lambda: mc.h_grid(np.column_stack([np.linspace(0, 1, 9), np.zeros(9)]), radius=2, first_height=0.05).mesh,
    "volumes": lambda: boxes((1, 2, 0), (False, True, True)),
}


def boxes(axes, back):
    """`turned_volumes` with lines long enough for ghosts, and bent."""
    u, v, w = np.meshgrid(np.arange(13.0), np.arange(6.0), np.arange(7.0), indexing="ij")
    points = np.stack([u + 0.3 * np.sin(0.5 * v), v + 0.2 * np.cos(w), w + 0.2 * np.sin(0.4 * u)], axis=-1)
    small = turned_volumes(axes, back)  # whose cut tells the orientation
    turned = points[6:].transpose(*axes, 3)[tuple(slice(None, None, -1 if b else 1) for b in back)]
    ends = tuple(
        tuple(int(n) for n in np.argwhere((turned == points[6, j, k]).all(axis=-1))[0]) for j, k in ((0, 0), (5, 6))
    )
    cut = mc.Cut(((6, 0, 0), (6, 5, 6)), ends, small.cuts[0].transform, 0, 1)
    return MultiBlock((StructuredGrid(points[:7]), StructuredGrid(turned)), cuts=(cut,))


@pytest.mark.parametrize("name", GRIDS)
def test_what_flows_out_of_a_cell_flows_into_the_next_through_cuts_too(name):
    grid = GRIDS[name]()
    volumes = FiniteVolumes(grid)
    rng = np.random.default_rng(3)
    scalar = [rng.normal(size=block.cell_shape) for block in blocks_of(grid)]
    vectors = [rng.normal(size=(*block.cell_shape, 3)) for block in blocks_of(grid)]
    scalar, vectors = (v if isinstance(grid, MultiBlock) else v[0] for v in (scalar, vectors))
    for fluxes, rate in (
        (volumes.fluxes(vectors), volumes.divergence(vectors)),
        (volumes.diffusive_fluxes(scalar), volumes.laplacian(scalar)),
    ):
        out = size = 0.0
        for axis, (flux, mark) in enumerate(zip(fluxes, volumes.boundary, strict=True)):
            for part, edge in zip(each(grid, flux), each(grid, mark), strict=True):
                last = np.moveaxis(np.where(edge, part, 0.0), axis, 0)
                out += last[-1].sum() - last[0].sum()
                size += np.abs(part).sum()
        total = sum((r * v).sum() for r, v in zip(each(grid, rate), each(grid, volumes.volumes), strict=True))
        assert abs(total - out) < 1e-14 * size
        assert abs(total) > 1e-6 * size / grid.n_cells


@pytest.mark.parametrize("name", GRIDS)
def test_a_uniform_flow_is_kept_to_round_off(name):
    grid = GRIDS[name]()
    volumes = FiniteVolumes(grid)
    flat = blocks_of(grid)[0].is_surface
    flow = of_cells(grid, lambda x: np.broadcast_to(FLOW * [1, 1, not flat], x.shape))
    one = of_cells(grid, lambda x: np.ones(x.shape[:3]))
    sizes = [np.abs(v) for v in each(grid, volumes.volumes)]
    reach = max(block.diagonal for block in blocks_of(grid))
    for part, size in zip(each(grid, volumes.divergence(flow)), sizes, strict=True):
        assert np.abs(part * size).max() < 1e-15 * reach ** (1 if flat else 2)
    for part, size in zip(each(grid, volumes.gradient(one)), sizes, strict=True):
        assert np.abs(part * size[..., None]).max() < 1e-15 * reach ** (1 if flat else 2)


def test_a_ring_joined_by_a_cut_is_a_periodic_ring():
    grid = ring(16, 7)
    for a, b in zip(results(with_cut(grid)), results(grid), strict=True):
        close(a, b)


@pytest.mark.parametrize("turn", range(4))
def test_blocks_in_any_orientation_are_one_grid(turn):
    blocks = quarter_turned(turn, 7, bend=0.5)
    second = np.rot90(blocks.blocks[1].points, -turn)
    whole = StructuredGrid(np.concatenate([blocks.blocks[0].points, second[1:]]))
    for parts, expected in zip(results(blocks), results(whole), strict=True):
        close(np.concatenate([parts[0], np.rot90(parts[1], -turn)]), expected)


@pytest.mark.parametrize("axes, back", [((1, 2, 0), (False, True, True)), ((0, 2, 1), (False, False, True))])
def test_volumes_in_any_orientation_are_one_grid(axes, back):
    blocks = boxes(axes, back)
    again = tuple(slice(None, None, -1 if b else 1) for b in back)
    plain = blocks.blocks[1].points[again].transpose(*np.argsort(axes), 3)
    whole = StructuredGrid(np.concatenate([blocks.blocks[0].points, plain[1:]]))
    for parts, expected in zip(results(blocks), results(whole), strict=True):
        tail = range(3, parts[1].ndim)
        close(np.concatenate([parts[0], parts[1][again].transpose(*np.argsort(axes), *tail)]), expected)


def test_on_the_wake_of_a_c_grid_it_is_as_inside_a_plain_grid():
    grid = c_shape(18, 16, 14, bend=0.01)
    t = np.linspace(0, 1.5, 15)
    plain = StructuredGrid(parabolic(2.0 / 8 * np.arange(8, 27), np.concatenate([-t[:0:-1], t]), bend=0.01))
    for a, b in zip(results(grid), results(plain), strict=True):
        # Within five cells of the trailing edge and of the outer sides fluxes differ by nature.
        close(a[34 + 5 : 46, :8], b[5:12, 14:22])
        close(a[17 - 5 : 5 : -1, :8], b[5:12, 13:5:-1])


@pytest.mark.parametrize("make", [lambda n: c_shape(n, 2 * n, n, bend=0.02), lambda n: h_cylinder(n, bend=0.02)])
def test_the_order_is_kept_across_cuts(make):
    """Away from where the round wall meets the cuts, and the grid is singular."""
    sizes, errors = (24, 32, 48, 64), []
    for n in sizes:
        grid = make(n)
        volumes = FiniteVolumes(grid)
        value, slope, laplacian = (of_cells(grid, lambda x, k=k: planar_model(x)[k]) for k in range(3))
        vectors = of_cells(grid, lambda x: planar_model(x)[0][..., None] * FLOW * [1, 1, 0])
        away = [np.hypot(np.abs(x[..., 0]) - 1, x[..., 1]) > 1 for x in each(grid, of_cells(grid, lambda x: x))]
        found = volumes.gradient(value), volumes.laplacian(value), volumes.divergence(vectors)
        expected = slope, laplacian, of_cells(grid, lambda x: planar_model(x)[1] @ (FLOW * [1, 1, 0]))
        errors.append([])
        for parts, exact in zip(found, expected, strict=True):
            off = [f - e for f, e in zip(each(grid, parts), each(grid, exact), strict=True)]
            errors[-1].append(rms(np.concatenate([o[a].ravel() for o, a in zip(off, away, strict=True)])))
    for error in np.transpose(errors):
        assert order(sizes, error) > 1.8


def test_the_middle_of_a_polar_grid_is_a_cell_like_the_others():
    sizes, errors = (8, 12, 16, 24), []
    for n in sizes:
        grid = polar(n)
        value, slope, laplacian = (of_cells(grid, lambda x, k=k: planar_model(x)[k]) for k in range(3))
        volumes = FiniteVolumes(grid)
        errors.append([rms(volumes.gradient(value) - slope), rms(volumes.laplacian(value) - laplacian)])
        assert (
            np.abs(volumes.area_vectors[0][0]).max() == 0 and np.abs(volumes.diffusive_fluxes(value)[0][0]).max() == 0
        )
    assert order(sizes, np.transpose(errors)[0]) > 1.4 and order(sizes, np.transpose(errors)[1]) > 0.5


def test_cells_of_joined_blocks_grow_by_what_their_faces_sweep():
    before = h_cylinder(8, bend=0.02)
    after = h_cylinder(8, bend=0.025)
    volumes = FiniteVolumes(before)
    grown = [b - a for a, b in zip(volumes.volumes, FiniteVolumes(after).volumes, strict=True)]
    for swept, expected in zip(volumes.balance(volumes.swept(after)), grown, strict=True):
        assert np.abs(swept - expected).max() < 1e-14 and np.abs(expected).max() > 1e-4


@pytest.mark.parametrize(
    ("wrong", "text"),
    [
        (lambda g: FiniteVolumes(g, order=4), "order: is 4; through cuts"),
        (lambda g: FiniteVolumes(g).divergence(np.zeros((3, 3))), "needs a list of 2 arrays, one a block"),
        (lambda g: FiniteVolumes(g).laplacian([0.0, np.zeros((3, 3))]), r"values\[1\]"),
        (lambda g: FiniteVolumes(g).swept(g.blocks[0]), "moved: has shape"),
        (lambda g: FiniteVolumes(g).balance([[0.0, 0.0], [0.0]]), r"fluxes\[1\]"),
    ],
)
def test_bad_input_is_named(wrong, text):
    with pytest.raises(InvalidInput, match=text):
        wrong(h_cylinder(8))
