"""Local refinement: conforming, nested, with bounded angles, and worth its while."""

import numpy as np
import pytest
import scipy.spatial
from hypothesis import given, settings
from hypothesis import strategies as st

import meshcore as mc
from meshcore import Mesh, gallery, quality
from meshcore.adapt import bisection, cutting, gradient_jump, marked, refined
from meshcore.errors import Cancelled, GenerationFailed, InvalidGeometry, InvalidInput
from tests import naive


def scattered(n, seed):
    """Delaunay triangles of random points in a square: all shapes, some bad."""
    points = np.random.default_rng(seed).random((n, 2))
    triangles = scipy.spatial.Delaunay(points).simplices.astype(np.int64)
    a, b, c = points[triangles].transpose(1, 0, 2)
    area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    triangles[area < 0] = triangles[area < 0][:, [0, 2, 1]]
    return Mesh(points, {"triangle": triangles})


def tilted(mesh):
    """The mesh in a plane that is parallel to no axis."""
    x, y, _ = mesh.points.T
    return mesh.with_points(np.column_stack([x, y, 0.3 * x + 0.7 * y + 2]))


def twice_areas(mesh):
    """(m, 3) float: normals, as long as twice the areas."""
    a, b, c = (mesh.points[mesh.cells["triangle"][:, k]] for k in range(3))
    return np.cross(b - a, c - a)


def angles(mesh):
    """(m, 3) float: radians."""
    corners = mesh.points[mesh.cells["triangle"]]
    to_next, to_last = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
    return np.arctan2(np.linalg.norm(np.cross(to_next, to_last), axis=2), (to_next * to_last).sum(axis=2))


def numbered(mesh):
    return mesh.with_cell_data(parent=np.arange(mesh.n_cells))


def triangle_sets(mesh):
    return {frozenset(map(tuple, corners)) for corners in mesh.points[mesh.cells["triangle"]].tolist()}


def check_refinement(before, after):
    """All that must hold between a mesh with cell array "parent" and its refinement."""
    parents = after.cell_data["parent"] - cutting.triangles_in(before).start
    parents = parents[cutting.triangles_in(after)]
    # The old points come first; points are not doubled; triangles look the way their parents do.
    np.testing.assert_array_equal(after.points[: before.n_points], before.points)
    assert len(np.unique(after.points, axis=0)) == after.n_points
    normals, parent_normals = twice_areas(after), twice_areas(before)
    assert ((normals * parent_normals[parents]).sum(axis=1) > 0).all()
    # Each triangle lies in its parent, and together they fill it.
    origin, u, v = before.points[before.cells["triangle"][parents]].transpose(1, 0, 2)
    frame = np.stack([u - origin, v - origin, parent_normals[parents]], axis=2)
    corners = after.points[after.cells["triangle"]] - origin[:, None]
    local = np.linalg.solve(frame[:, None], corners[..., None])[..., 0]
    assert local[..., :2].min() > -1e-9 and local[..., :2].sum(axis=2).max() < 1 + 1e-9
    area = np.bincount(parents, np.linalg.norm(normals, axis=1), len(parent_normals))
    np.testing.assert_allclose(area, np.linalg.norm(parent_normals, axis=1), rtol=1e-9)
    # No node hangs: edges have two triangles, or one on an old boundary edge.
    facets = after.facets
    assert facets.shared.max() <= 2
    outer, old = after.boundary.get("line"), before.boundary.get("line")
    assert len(outer) >= len(old)
    length, old_length = (
        np.linalg.norm(np.diff(m.points[lines], axis=1)[:, 0], axis=1) for m, lines in ((after, outer), (before, old))
    )
    assert length.sum() == pytest.approx(old_length.sum(), rel=1e-9)
    ends = before.points[old]
    for line in after.points[outer[:: max(1, len(outer) // 50)]]:
        detour = np.linalg.norm(line[:, None] - ends[None, :, 0], axis=2)
        detour += np.linalg.norm(line[:, None] - ends[None, :, 1], axis=2)
        assert (np.abs(detour - old_length).max(axis=0) < 1e-9).any(), "a boundary edge lies on none of the old"


@settings(deadline=None, max_examples=60)
@given(st.integers(4, 40), st.integers(0, 10**6), st.floats(0, 1), st.integers(1, 3), st.booleans())
def test_any_marks_on_any_mesh(n, seed, share, rounds, in_space):
    """Against the book, and every invariant, over several rounds of random marks."""
    first = scattered(n, seed)
    mesh, rng = tilted(first) if in_space else first, np.random.default_rng(seed)
    smallest = angles(mesh).min()
    for _ in range(rounds):
        before = numbered(mesh)
        marks = rng.random(mesh.n_cells) < share
        after, _ = refined(before, marks)
        check_refinement(before, after)
        order = bisection.longest_edge_first(mesh.points, mesh.cells["triangle"])
        triangles = mesh.points[mesh.cells["triangle"] if "bisections" in mesh.cell_data else order].tolist()
        triangles = [tuple(map(tuple, t)) for t in triangles]
        expected = naive.newest_vertex_refined(triangles, [t for t, m in zip(triangles, marks, strict=True) if m])
        assert triangle_sets(after) == {frozenset(t) for t in expected}
        assert len(expected) == after.n_cells
        assert not np.isin(np.flatnonzero(marks), after.cell_data["parent"][_unique_parents(after)]).any()
        assert angles(after).min() >= smallest / 2 - 1e-9
        mesh = after


def _unique_parents(mesh):
    """Cells that are all of their parent."""
    return np.bincount(mesh.cell_data["parent"])[mesh.cell_data["parent"]] == 1


@pytest.mark.parametrize("in_space", [False, True])
def test_angles_stay_above_half_over_35_levels(in_space):
    """Rosenberg and Stenger's bound, and four similarity classes a triangle, towards a point on an edge."""
    mesh = tilted(scattered(30, 5)) if in_space else scattered(30, 5)
    mesh = mesh.with_cell_data(root=np.arange(mesh.n_cells))
    smallest = angles(mesh).min()
    target = mesh.points[mesh.cells["triangle"][7]].mean(axis=0)
    seen = [set() for _ in range(mesh.n_cells)]
    for _ in range(35):
        nearest = np.argsort(np.linalg.norm(mesh.centroids - target, axis=1))[:3]
        mesh, _ = refined(mesh, nearest)
        found = angles(mesh)
        assert found.min() >= smallest / 2 * (1 - 1e-6)
        for root, shape in zip(mesh.cell_data["root"], np.sort(found, axis=1).round(3), strict=True):
            seen[root].add(tuple(shape.tolist()))
    assert mesh.cell_data["bisections"].max() >= 60
    assert max(map(_distinct, seen)) <= 4
    assert mesh.facets.shared.max() == 2


def _distinct(shapes):
    """How many shapes there are up to rounding."""
    kept = []
    for shape in map(np.array, sorted(shapes)):
        if not any(np.abs(shape - other).max() < 5e-3 for other in kept):
            kept.append(shape)
    return len(kept)


def test_the_bound_needs_the_state():
    """Without newest vertices, cuts through any edge make needles: the test above can fail."""
    mesh = gallery.triangulated_square(1)
    smallest = angles(mesh).min()
    for _ in range(6):
        mesh, _ = refined(mesh, [0])
        wrong = mesh.cells["triangle"][:, [1, 2, 0]]
        mesh = Mesh(mesh.points, {"triangle": wrong}, cell_data=mesh.cell_data)
    assert angles(mesh).min() < smallest / 2


def test_far_triangles_are_untouched():
    mesh = gallery.triangulated_square(40)
    after, report = refined(mesh, [1600])
    assert report.counts["marked"] == 1
    assert len(triangle_sets(mesh) - triangle_sets(after)) < 12
    far = np.linalg.norm(after.centroids - mesh.centroids[1600], axis=1) > 0.15
    assert (after.cell_data["bisections"][far] == 0).all()


def test_uniform_levels_make_four_of_one():
    mesh = numbered(scattered(50, 3))
    once, _ = refined(mesh)
    assert once.n_cells == 4 * mesh.n_cells
    assert (once.cell_data["bisections"] == 2).all()
    check_refinement(mesh, once)
    twice, report = refined(mesh, levels=2)
    assert triangle_sets(twice) == triangle_sets(refined(once).mesh)
    assert report.counts == {"points": twice.n_points, "triangles": 16 * mesh.n_cells, "marked": 5 * mesh.n_cells}


def test_the_state_survives_reordering_and_selection():
    """Newest vertices go with their triangles, whatever becomes of the others."""
    mesh, rng = refined(scattered(40, 9), levels=1).mesh, np.random.default_rng(2)
    order = rng.permutation(mesh.n_cells)
    shuffled = Mesh(
        mesh.points, {"triangle": mesh.cells["triangle"][order]}, cell_data={"bisections": np.full(mesh.n_cells, 2.0)}
    )
    assert triangle_sets(refined(shuffled).mesh) == triangle_sets(refined(mesh).mesh)
    half = mesh.centroids[:, 0] < 0.5
    assert triangle_sets(refined(mesh.selected(half)).mesh) < triangle_sets(refined(mesh).mesh)


def test_a_levels_parts_are_cut_on():
    """Marks over several levels are the same as marking the parts again."""
    mesh = numbered(gallery.triangulated_square(6))
    at_once, _ = refined(mesh, [10, 50], levels=3)
    stepwise = mesh
    for _ in range(3):
        stepwise, _ = refined(stepwise, np.isin(stepwise.cell_data["parent"], [10, 50]))
    assert triangle_sets(at_once) == triangle_sets(stepwise)


def square_with_lines():
    """Triangles with tagged boundary lines before them, a line inside, a line on no edge, and a vertex cell."""
    square = gallery.triangulated_square(3)
    outline = square.boundary.cells["line"]
    lines = np.concatenate([outline, [[5, 10]], [[0, 15]]])
    n, m = len(lines), len(square.cells["triangle"])
    return Mesh(
        square.points,
        {"line": lines, "triangle": square.cells["triangle"], "vertex": np.array([[0]])},
        point_data={
            "linear": square.points @ [2.0, -3.0, 0.0] + 1,
            "vector": square.points[:, :2] * [1.0, 4.0],
            "tag": np.where(square.points[:, 0] == 0, 7, 0),
            "flag": square.points[:, 1] == 0,
            "name": np.array([f"p{k}" for k in range(square.n_points)]),
        },
        cell_data={"tag": np.arange(n + m + 1), "pair": np.arange(2 * (n + m + 1)).reshape(-1, 2)},
        sets={"south": np.flatnonzero((square.points[outline][:, :, 1] == 0).all(axis=1)), "some": [n + 1, n + 4]},
        field_data={"holes": np.zeros((0, 2))},
    )


def test_lines_and_data_follow():
    before = numbered(square_with_lines())
    lines, triangles = (w for _, _, w in list(before.blocks())[:2])
    after, _ = refined(before, [triangles.start, triangles.start + 9], levels=2)
    check_refinement(before, after)
    kinds = {kind: (cells, where) for kind, cells, where in after.blocks()}
    assert list(kinds) == ["line", "triangle", "vertex"]
    # Lines: the outline is the boundary still, each piece within its parent, in its direction, with its tag.
    pieces, where = kinds["line"]
    tag = after.cell_data["tag"][where]
    outer = {frozenset(line) for line in after.boundary.cells["line"].tolist()}
    assert {frozenset(line) for line, t in zip(pieces.tolist(), tag, strict=True) if t < lines.stop - 2} == outer
    for t, parent in enumerate(before.points[before.cells["line"]]):
        mine = after.points[pieces[tag == t]]
        np.testing.assert_allclose(np.diff(mine, axis=1).sum(axis=0)[0], parent[1] - parent[0], atol=1e-14)
        along = (mine - parent[0]) @ (parent[1] - parent[0])
        assert (along[:, 1] > along[:, 0]).all()
    assert (tag == lines.stop - 1).sum() == 1, "the line on no edge is left alone"
    assert (tag == lines.stop - 2).sum() > 1, "the line inside is cut with its edge"
    # Data.
    np.testing.assert_allclose(after.point_data["linear"], after.points @ [2.0, -3.0, 0.0] + 1, atol=1e-14)
    np.testing.assert_allclose(after.point_data["vector"], after.points[:, :2] * [1.0, 4.0], atol=1e-14)
    assert set(after.point_data["tag"]) == {0, 7}
    np.testing.assert_array_equal(after.point_data["tag"] == 7, after.points[:, 0] == 0)
    np.testing.assert_array_equal(after.point_data["flag"], after.points[:, 1] == 0)
    assert after.point_data["name"].shape == (after.n_points,)
    np.testing.assert_array_equal(after.cell_data["pair"][:, 0], 2 * after.cell_data["tag"])
    for name, members in before.sets.items():
        np.testing.assert_array_equal(after.sets[name], np.flatnonzero(np.isin(after.cell_data["parent"], members)))
    assert after.field_data["holes"].shape == (0, 2)


def octahedron():
    points = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], float)
    return Mesh(points, {"triangle": scipy.spatial.ConvexHull(points).simplices})


def outward(mesh):
    flip = (twice_areas(mesh) * mesh.centroids).sum(axis=1) < 0
    return mesh.reoriented(flip)


def test_a_closed_surface_stays_closed():
    mesh, report = refined(outward(octahedron()), [0, 3], levels=4)
    assert not mesh.boundary.n_cells
    assert report.warnings == []
    assert np.linalg.norm(twice_areas(mesh), axis=1).sum() / 2 == pytest.approx(4 * np.sqrt(3))
    volume = (mesh.points[mesh.cells["triangle"][:, 0]] * twice_areas(mesh)).sum() / 6
    assert volume == pytest.approx(4 / 3)


def test_faults_of_the_input_are_told_not_hidden():
    """Three triangles on one edge are refined, and said to be no manifold; so is a point without cells."""
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [5, 5, 5]]
    fins = Mesh(points, {"triangle": [[0, 1, 2], [1, 0, 3], [0, 1, 4]]})
    mesh, report = refined(fins, [0])
    assert mesh.n_points > 6 and mesh.facets.shared.max() == 3
    assert any("as faulty as it was given" in text and "more than two" in text for text in report.warnings)
    assert any("belongs to no cell" in text for text in report.warnings)


def test_hanging_nodes_of_the_input_are_refused():
    """Cut, the edge with the hanging node would get a second point at the same place."""
    points = [[0, 0], [1, 0], [2, 0], [1, 1], [1, -1]]
    mesh = Mesh(points, {"triangle": [[0, 2, 3], [0, 4, 1], [4, 2, 1]]})
    with pytest.raises(InvalidGeometry, match=r"mesh: 1 point hangs on edges: point 1 .* repair it first") as caught:
        refined(mesh)
    assert caught.value.points == (1,)


def test_indicators_choose():
    mesh = gallery.triangulated_square(16)
    steep, report = refined(mesh, indicator="front", fraction=0.6, levels=3)
    radius = np.linalg.norm(steep.centroids, axis=1)
    small = steep.cell_data["bisections"] >= 5
    assert small.any() and np.abs(radius[small] - 0.7).max() < 0.2
    assert (steep.cell_data["bisections"][np.abs(radius - 0.7) > 0.35] < 4).all()
    assert report.quality["smallest angle (degree)"] == pytest.approx(45)
    # A cell array, and the marks that it stands for.
    eta = np.random.default_rng(4).random(mesh.n_cells)
    by_name, _ = refined(mesh.with_cell_data(eta=eta), indicator="eta", fraction=0.3)
    by_marks, _ = refined(mesh, marked(eta, 0.3))
    assert triangle_sets(by_name) == triangle_sets(by_marks)
    np.testing.assert_array_equal(np.unique(by_name.cell_data["eta"]), np.unique(eta))


def test_parts_share_a_cell_value_by_area():
    """A value spread evenly is refined evenly: no triangle is cut twice before its equals were."""
    mesh = gallery.triangulated_square(4)
    even = mesh.with_cell_data(eta=np.ones(mesh.n_cells))
    after, _ = refined(even, indicator="eta", fraction=0.5, levels=4)
    counts = after.cell_data["bisections"]
    assert counts.max() - counts.min() <= 3
    peak = mesh.with_cell_data(eta=np.where(np.arange(mesh.n_cells) == 5, 1000.0, 1.0))
    after, _ = refined(peak, indicator="eta", fraction=0.5, levels=4)
    assert after.cell_data["bisections"][after.cell_data["eta"] == 1000].min() >= 5
    assert (after.cell_data["bisections"] == 0).any()


def test_nothing_to_refine_is_a_warning():
    mesh = gallery.triangulated_square(3)
    for arguments in (
        {"marks": []},
        {"marks": np.zeros(18, bool)},
        {"indicator": "flat"},
        {"indicator": "front", "fraction": 0.0},
    ):
        after, report = refined(mesh.with_point_data(flat=np.ones(16)), **arguments)
        assert triangle_sets(after) == triangle_sets(mesh)
        assert "nothing to refine at level 1" in report.warnings[0]


SQUARE = gallery.triangulated_square(2)


@pytest.mark.parametrize(
    ("mesh", "arguments", "message"),
    [
        (Mesh([[0, 0], [1, 0], [1, 1], [0, 1]], {"quad": [[0, 1, 2, 3]]}), {}, "mesh: has 1 quad cells"),
        (gallery.square(), {}, "mesh: has no triangles"),
        (Mesh(np.zeros((0, 3)), {}), {}, "mesh: has no triangles"),
        (SQUARE, {"indicator": "pressure"}, "no array 'pressure'; on cells there are none; at points front"),
        (SQUARE, {"marks": [0], "indicator": "front"}, "not both"),
        (SQUARE, {"marks": [-1]}, "marks: there is no cell -1; cells go from 0 to 7"),
        (SQUARE, {"marks": [8]}, "marks: there is no cell 8"),
        (SQUARE, {"marks": np.ones(5, bool)}, "one flag per cell, that is 8, got 5"),
        (SQUARE, {"marks": [0.5]}, "marks: needs flags"),
        (SQUARE, {"marks": np.ones((8, 1), bool)}, "marks: needs flags"),
        (SQUARE, {"marks": "all"}, "marks: needs flags"),
        (SQUARE, {"fraction": 1.5}, "fraction: must be at most 1"),
        (SQUARE, {"fraction": float("nan")}, "fraction: must be finite"),
        (SQUARE, {"levels": 0}, "levels: must be at least 1"),
        (SQUARE, {"levels": 1.5}, "levels: needs a whole number"),
        (SQUARE, {"levels": 40}, "levels: would make .* triangles or more, .* fewer levels"),
        (SQUARE, {"levels": 10**9}, "levels: would make"),
        (SQUARE.with_cell_data(bisections=np.full(8, -1)), {}, "'bisections' must hold one whole number"),
        (SQUARE.with_cell_data(bisections=np.full(8, np.nan)), {}, "'bisections' must hold one whole number"),
        (SQUARE.with_cell_data(bisections=np.array(["a"] * 8)), {}, "'bisections' must hold one whole number"),
        (square_with_lines(), {"marks": [0]}, "cell 0 is a line; only triangles"),
    ],
)
def test_bad_input_is_refused(mesh, arguments, message):
    with pytest.raises(InvalidInput, match=message):
        refined(mesh, **arguments)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (np.array([1, 1, np.nan, 1, 1, 1, 1, 1.0]), "indicator: cell 2 has nan"),
        (np.array([1, 1, 1, 1, 1, -2.0, 1, 1]), "indicator: cell 5 has -2.0"),
        (np.array([1, np.inf, 1, 1, 1, 1, 1, 1.0]), "indicator: cell 1 has inf"),
        (np.ones((8, 2)), "indicator: needs one number per cell"),
        (np.array(["x"] * 8), "indicator: needs numbers"),
    ],
)
def test_bad_indicators_are_refused(values, message):
    with pytest.raises(InvalidInput, match=message):
        refined(SQUARE.with_cell_data(eta=values), indicator="eta")


def test_bad_point_arrays_are_refused():
    bad = np.where(np.arange(9) == 4, np.nan, 1.0)
    with pytest.raises(InvalidInput, match="point 4 has"):
        refined(SQUARE.with_point_data(u=bad), indicator="u")
    with pytest.raises(InvalidInput, match="needs numbers"):
        refined(SQUARE.with_point_data(u=np.array(["x"] * 9)), indicator="u")


@pytest.mark.parametrize("corners", [[[0, 0], [1, 1], [2, 2]], [[0, 0], [1, 0], [0.5, 1e-18]], [[3, 3]] * 3])
def test_triangles_without_area_are_refused(corners):
    mesh = Mesh([*corners, [9, 8], [9, 9], [8, 9]], {"line": [[3, 4]], "triangle": [[3, 4, 5], [0, 1, 2]]})
    with pytest.raises(InvalidGeometry, match=r"cell 2 at .* has no area") as caught:
        refined(mesh)
    assert caught.value.cells == (2,)


def test_edges_beyond_floating_point_are_refused():
    """Near (1, 1) doubles end after about 50 halvings; the message says where, and nothing is tangled."""
    mesh = gallery.triangulated_square(1).with_points([[1, 1], [1, 2], [2, 1], [2, 2]])
    with pytest.raises(InvalidGeometry, match="too short to be cut") as caught:
        for _ in range(70):
            nearest = np.linalg.norm(mesh.centroids - [1, 1, 0], axis=1).argmin()
            mesh, _ = refined(mesh, [nearest])
    assert len(caught.value.points) == 2
    assert mesh.cell_data["bisections"].max() > 80


@pytest.mark.parametrize("scale", [1e-300, 1e-160, 1e150, 1e300])
def test_scale_does_not_matter(scale):
    mesh = scattered(30, 12)
    small = bisection.longest_edge_first(scale * mesh.points, mesh.cells["triangle"])
    np.testing.assert_array_equal(small, bisection.longest_edge_first(mesh.points, mesh.cells["triangle"]))
    after, report = refined(mesh.with_points(scale * mesh.points), [3], levels=3)
    expected, expected_report = refined(mesh, [3], levels=3)
    np.testing.assert_array_equal(after.cells["triangle"], expected.cells["triangle"])
    np.testing.assert_allclose(after.points, scale * expected.points, rtol=1e-12)
    assert report.quality == pytest.approx(expected_report.quality)
    assert report.warnings == []


def test_progress_and_cancelling():
    seen = []
    refined(SQUARE, levels=3, progress=lambda fraction, message: seen.append((fraction, message)))
    assert [f for f, _ in seen] == sorted(f for f, _ in seen)
    assert seen[0] == (0.0, "refining, level 1 of 3")
    with pytest.raises(Cancelled):
        refined(SQUARE, levels=3, progress=lambda fraction, message: fraction < 0.5)


def test_new_faults_are_errors(monkeypatch):
    """Should a step ever leave a fault that was not there, the mesh is not handed out as if it were good."""

    def inside_out(triangles, middles):
        parts = bisection.bisected(triangles, middles)
        return parts._replace(nodes=parts.nodes[:, [0, 2, 1]])

    monkeypatch.setattr(cutting, "bisected", inside_out)
    with pytest.raises(GenerationFailed, match="not positively oriented") as caught:
        refined(SQUARE)
    assert len(caught.value.cells) == 32 and isinstance(caught.value.partial, Mesh)


def test_it_is_an_operation():
    op = mc.operations()["refined"]
    assert list(op.inputs) == ["mesh"] and list(op.params) == ["indicator", "fraction", "levels"]
    assert op.params["indicator"].array and mc.refined is op.function
    inputs, keywords = gallery.arguments("refined")
    mesh, _ = op.function(*inputs, **keywords)
    assert quality.validate(mesh) == []


# ---- worth its while: Laplace's equation on an L, whose solution r^(2/3) sin(2 theta / 3) has a singular slope


def l_domain():
    square = gallery.triangulated_square(4)
    square = square.with_points(2 * square.points - [1, 1, 0])
    return square.selected(~(square.centroids[:, :2] > 0).all(axis=1))


def exact(points):
    """Solution and its slope; the L is without its upper right quarter, so the angle starts at the y axis."""
    x, y = points[..., 0], points[..., 1]
    theta = np.mod(np.arctan2(y, x) - np.pi / 2, 2 * np.pi)
    theta = np.where(theta > 1.75 * np.pi, 0.0, theta)  # rounding just below the first side
    radius = np.hypot(x, y)
    factor = 2 / 3 * np.maximum(radius, 1e-300) ** (-1 / 3)
    direction = 2 / 3 * theta - (theta + np.pi / 2)
    slope = np.stack([factor * np.sin(direction), factor * np.cos(direction)], axis=-1)
    return radius ** (2 / 3) * np.sin(2 / 3 * theta), slope


def solved(mesh):
    """Finite element solution, and the error of its slope in the L2 norm."""
    triangles = mesh.cells["triangle"]
    on_boundary = np.full(mesh.n_points, np.nan)
    rim = np.unique(mesh.boundary.cells["line"])
    on_boundary[rim] = exact(mesh.points[rim])[0]
    solution = naive.poisson(mesh.points, triangles, on_boundary)
    corners = mesh.points[triangles][:, :, :2]
    frame = corners[:, 1:] - corners[:, :1]
    slope = np.linalg.solve(frame, np.diff(solution[triangles], axis=1, prepend=0)[:, 1:].cumsum(axis=1)[..., None])
    # Sixteen parts a triangle, each by its centroid.
    parts, parents = triangles, np.arange(len(triangles))
    fine, _ = refined(Mesh(mesh.points, {"triangle": parts}, cell_data={"parent": parents}), levels=2)
    area = np.linalg.norm(twice_areas(fine), axis=1) / 2
    off = exact(fine.centroids)[1] - slope[fine.cell_data["parent"], :, 0]
    return solution, np.sqrt((area * (off**2).sum(axis=1)).sum())


def rate(counts, errors):
    return np.polyfit(np.log(counts), np.log(errors), 1)[0]


def test_adaptive_refinement_restores_the_rate_of_smooth_solutions():
    """Error of the slope: N^-1/3 by uniform refinement, N^-1/2 by adaptive, and the indicator follows it."""
    mesh, counts, errors = l_domain(), [], []
    assert np.linalg.norm(twice_areas(mesh), axis=1).sum() / 2 == pytest.approx(3)
    for _ in range(5):
        mesh, _ = refined(mesh)
        counts.append(mesh.n_points)
        errors.append(solved(mesh)[1])
    assert rate(counts[1:], errors[1:]) == pytest.approx(-1 / 3, abs=0.03)
    uniform = np.interp(np.log(3000), np.log(counts), errors)

    mesh, counts, errors, ratios = l_domain(), [], [], []
    while mesh.n_points < 5000:
        solution, error = solved(mesh)
        eta = gradient_jump(mesh, solution)
        counts.append(mesh.n_points)
        errors.append(error)
        ratios.append(np.linalg.norm(eta) / error)
        mesh, _ = refined(mesh, marked(eta**2, 0.5))
    late = np.array(counts) > 100
    assert rate(np.array(counts)[late], np.array(errors)[late]) == pytest.approx(-0.5, abs=0.03)
    assert angles(mesh).min() == pytest.approx(np.pi / 4)
    assert np.interp(np.log(3000), np.log(counts), errors) < 0.4 * uniform
    assert max(ratios) / min(ratios) < 1.5, "the indicator is equivalent to the error"


@pytest.mark.parametrize("wrong", [None, 3, "mesh.vtu", mc.o_grid(gallery.circle(8), layers=4).mesh])
def test_what_is_no_mesh_is_refused_by_name(wrong):
    with pytest.raises(InvalidInput, match=f"mesh: needs a Mesh of triangles, got {type(wrong).__name__}"):
        refined(wrong)
