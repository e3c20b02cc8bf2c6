"""Point location against trying every cell in exact numbers, and the search of the nearest against brute force."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from meshcore import InvalidGeometry, InvalidInput, Mesh, gallery
from meshcore.geometry.alternating_digital_tree import Nearest, Tree
from meshcore.geometry.location import Locator, locate
from tests import naive

KINDS = {2: "triangle", 3: "tetra"}


def soup(seed, dimension, *, values=5, count=12):
    """Cells between whole numbers: overlapping, inverted, flat and repeated ones among them."""
    rng = np.random.default_rng(seed)
    points = rng.integers(0, values, (14, dimension)).astype(float)
    cells = np.array([rng.choice(14, dimension + 1, replace=False) for _ in range(count)])
    return points, np.concatenate([cells, cells[:3]])


def box_of_tetrahedra(n):
    """A cube of n^3 cubes, each cut in six tetrahedra along its diagonal (Kuhn), so that all faces match."""
    i, j, k = (a.ravel() for a in np.meshgrid(*[np.arange(n)] * 3, indexing="ij"))
    cells = []
    for path in ((0, 1, 2), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0)):
        at, corners = np.array([i, j, k]), []
        for axis in (*path, None):
            corners.append((at[0] * (n + 1) + at[1]) * (n + 1) + at[2])
            if axis is not None:
                at = at + np.eye(3, dtype=int)[axis][:, None]
        cells.append(np.column_stack(corners))
    grid = np.meshgrid(*[np.arange(n + 1) / n] * 3, indexing="ij")
    mesh = Mesh(np.column_stack([g.ravel() for g in grid]), {"tetra": np.concatenate(cells)})
    a, b, c, d = mesh.points[mesh.cells["tetra"]].transpose(1, 0, 2)
    return mesh.reoriented(np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) < 0)


@pytest.mark.parametrize("dimension", [2, 3])
@settings(max_examples=40)
@given(seed=st.integers(0, 10**6), exponent=st.sampled_from([0, -900, 900, 3]))
def test_the_cell_is_the_first_that_holds_the_point(dimension, seed, exponent):
    points, cells = soup(seed, dimension)
    rng = np.random.default_rng(seed + 1)
    middles = points[cells[:, :2]].mean(axis=1)
    queries = np.concatenate([0.5 * rng.integers(-2, 12, (12, dimension)), points[:5], middles[:8]])
    expected, weights = naive.located(points, cells, queries)
    try:
        found = locate(Mesh(np.ldexp(points, exponent), {KINDS[dimension]: cells}), np.ldexp(queries, exponent))
    except InvalidGeometry:
        assert set(expected) == {-1}  # all cells are flat
        return
    assert found.cell.tolist() == expected
    for share, exact in zip(found.barycentric, weights, strict=True):
        assert np.isnan(share).all() if exact is None else np.allclose(share, np.array(exact, float), atol=1e-14)


@pytest.mark.parametrize("mesh", [gallery.triangulated_square(9), box_of_tetrahedra(4)], ids=["plane", "space"])
@pytest.mark.parametrize("offset", [0.0, 1e8])
def test_no_point_is_lost_between_cells(mesh, offset):
    rng = np.random.default_rng(3)
    dimension = mesh.dimension
    inside = (mesh.points[:, :dimension] % 1 > 0).all(axis=1)
    points = mesh.points.copy()
    points[inside, :dimension] += rng.uniform(-0.01, 0.01, (inside.sum(), dimension))
    mesh = mesh.with_points(points + offset)
    a, b = mesh.points[mesh.edges].transpose(1, 0, 2)
    share = rng.random((len(a), 1))
    queries = np.concatenate([mesh.points, np.clip(a + share * (b - a), a.min(axis=0), a.max(axis=0))])
    cell, weights = locate(mesh, queries)
    assert (cell >= 0).all()
    assert (weights >= 0).all() and np.abs(weights.sum(axis=1) - 1).max() < 1e-15
    corners = mesh.cells[KINDS[dimension]][cell]
    back = np.einsum("mkx,mk->mx", mesh.points[corners], weights)
    assert np.abs(back - queries).max() < 1e-15 * (1 + 4 * offset)


def test_centroids_lie_in_their_cells_whatever_the_numbering():
    mesh = box_of_tetrahedra(5)
    order = np.random.default_rng(1).permutation(mesh.n_cells)
    lines = mesh.edges[:7]
    mixed = Mesh(mesh.points, {"line": lines, "tetra": mesh.cells["tetra"][order]})
    assert (locate(mixed, mixed.centroids[7:]).cell == np.arange(7, 7 + len(order))).all()


def test_a_tilted_plane_takes_projections():
    turn = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    flat = gallery.triangulated_square(6)
    tilted = flat.with_points(flat.points @ turn.T + 3)
    off = tilted.centroids + 0.25 * turn[:, 2]
    assert (locate(tilted, off).cell == np.arange(flat.n_cells)).all()


def test_quads_are_interpolated_and_refused_where_weights_have_no_meaning():
    mesh = Mesh([[0, 0], [2, 0], [2, 1], [0, 1], [3, 0]], {"triangle": [[1, 4, 2]], "quad": [[0, 1, 2, 3]]})
    values = 1 + mesh.points[:, 0] - 2 * mesh.points[:, 1]
    queries = np.array([[1.5, 0.25], [0.5, 0.75], [2.25, 0.5]])
    assert np.allclose(Locator(mesh).interpolated(values, queries), 1 + queries[:, 0] - 2 * queries[:, 1])
    assert Locator(mesh).locate(queries).cell.tolist() == [1, 1, 0]
    with pytest.raises(InvalidInput, match="has 1 quad cells"):
        locate(mesh, queries)


@pytest.mark.parametrize("dimension", [2, 3])
@settings(max_examples=40)
@given(seed=st.integers(0, 10**6))
def test_points_outside_get_the_nearest_place(dimension, seed):
    mesh = gallery.triangulated_square(3) if dimension == 2 else box_of_tetrahedra(2)
    queries = np.random.default_rng(seed).uniform(-2, 3, (40, 3))
    if dimension == 2:
        queries[:, 2] = 0
    cell, weights = locate(mesh, queries, nearest=True)
    place = np.einsum("mkx,mk->mx", mesh.points[mesh.cells[KINDS[dimension]][cell]], weights)
    assert np.abs(place - np.clip(queries, 0, [1, 1, dimension - 2])).max() < 1e-14
    inside = locate(mesh, queries).cell
    assert (cell[inside >= 0] == inside[inside >= 0]).all()


@pytest.mark.parametrize("corners", [1, 2, 3])
@settings(max_examples=40)
@given(seed=st.integers(0, 10**6), flat=st.booleans())
def test_the_nearest_is_the_nearest_of_all(corners, seed, flat):
    rng = np.random.default_rng(seed)
    simplices = rng.integers(0, 6, (20, corners, 3)).astype(float)  # some without length or area
    queries = 0.5 * rng.integers(-4, 16, (8, 3))
    if flat:
        simplices[..., 2] = 0
    item, weights, distance = Nearest(simplices).query(queries)
    for k, q in enumerate(queries):
        every = np.array([naive.nearest_on_simplex(s, q) for s in simplices])
        assert abs(distance[k] - every.min()) < 1e-12
        assert abs(every[item[k]] - every.min()) < 1e-12
        assert abs(np.linalg.norm(weights[k] @ simplices[item[k]] - q) - distance[k]) < 1e-12
    assert (weights >= -1e-12).all()


@pytest.mark.parametrize("scale", [1e-300, 1e-150, 1e150, 1e300])
def test_sizes_beyond_the_square_root_of_the_doubles(scale):
    mesh = gallery.triangulated_square(4)
    mesh = mesh.with_points(scale * mesh.points)
    cell, weights = locate(mesh, scale * np.array([[0.3, 0.4], [1.5, 0.3]]), nearest=True)
    assert cell[0] == locate(gallery.triangulated_square(4), [[0.3, 0.4]]).cell[0]
    corners = mesh.points[mesh.cells["triangle"][cell[1]]] / scale
    assert np.allclose(weights[1] @ corners, [1, 0.3, 0])
    far = locate(mesh, [[1.7e308, 0.0], [-1.7e308, 1e-308]], nearest=True)
    assert (far.cell >= 0).all() and (locate(mesh, [[1.7e308, 0.0]]).cell == -1).all()


def test_the_tree_stays_shallow_on_boxes_that_cannot_be_told_apart():
    same = np.zeros((5000, 2))
    shrinking = 2.0 ** -np.arange(1000.0)[:, None] * [1, 1]
    low = np.concatenate([same, shrinking])
    tree = Tree(low, low + 1)
    assert sorted(tree.order) == list(range(6000))
    leaves = tree.right <= 0
    assert (-tree.right[leaves]).sum() == 6000 and -tree.right.min() <= 4
    depth = np.zeros(len(tree.right), int)
    for node in np.flatnonzero(~leaves):
        depth[[node + 1, tree.right[node]]] = depth[node] + 1
    assert depth.max() < 96 + 31


def test_many_and_few_queries_agree():
    mesh = gallery.triangulated_square(30)
    queries = np.random.default_rng(8).uniform(-0.2, 1.2, (5000, 2))
    cell, weights = locate(mesh, queries, nearest=True)
    for part in np.array_split(np.arange(5000), 10):
        again = locate(mesh, queries[part], nearest=True)
        assert (again.cell == cell[part]).all() and (again.barycentric == weights[part]).all()


@pytest.mark.parametrize(
    "mesh, points, message",
    [
        (Mesh([[0, 0], [1, 0], [1, 1]], {"line": [[0, 1]]}), [[0, 0]], "neither triangles nor tetrahedra"),
        (Mesh(np.random.default_rng(0).random((6, 3)), {"wedge": [range(6)]}), [[0, 0]], "has 1 wedge cells"),
        (Mesh([[0, 0], [1, 1], [2, 2]], {"triangle": [[0, 1, 2]]}), [[0, 0]], "none of which has an area"),
        ("a file", [[0, 0]], "needs a Mesh, got str"),
        (gallery.triangulated_square(), [[0, np.nan]], "point 0 is .0.0, nan."),
        (gallery.triangulated_square(), [[0, 1, 2, 3]], r"needs shape \(m, 2\) or \(m, 3\)"),
        (gallery.triangulated_square(), [["a", "b"]], "needs real numbers"),
        (gallery.triangulated_square(), [[1, 2j]], "needs real numbers"),
    ],
)
def test_bad_input_is_named(mesh, points, message):
    with pytest.raises(InvalidInput, match=message):
        locate(mesh, points)


def test_no_points_and_surfaces():
    cell, weights = locate(gallery.triangulated_square(), np.empty((0, 3)), nearest=True)
    assert cell.shape == (0,) and weights.shape == (0, 3)
    roof = Mesh([[0, 0, 0], [1, 0, 1], [1, 1, 0], [0, 1, 1]], {"triangle": [[0, 1, 2], [0, 2, 3]]})
    with pytest.raises(InvalidGeometry, match="is not planar"):
        locate(roof, [[0, 0, 0]])
