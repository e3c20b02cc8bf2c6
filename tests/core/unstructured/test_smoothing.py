"""Guarded smoothing: what it keeps, what it never makes worse, and that it makes meshes better."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import meshcore
from meshcore import InvalidGeometry, InvalidInput, Mesh, delaunay_refinement, quality, smoothed
from meshcore.gallery import square, square_with_hole, triangulated_square
from meshcore.unstructured import _smoothing_kernels as kernels
from tests import naive
from tests.core.unstructured import invariants
from tests.core.unstructured.planar_graphs import loops, star_polygons


def on_outline(mesh):
    """(n,) bool."""
    on = np.zeros(mesh.n_points, bool)
    on[mesh.boundary.cells["line"].ravel()] = True
    return on


def shaken(n, seed, share=0.45):
    """A triangulated square with its inner points moved at random, as far as triangles allow."""
    mesh = triangulated_square(n)
    rng = np.random.default_rng(seed)
    points = mesh.points.copy()
    inner = np.flatnonzero(~on_outline(mesh))
    for v in inner:
        for _ in range(5):
            moved = points.copy()
            moved[v, :2] += share / n * rng.uniform(-1, 1, 2)
            around = mesh.cells["triangle"][(mesh.cells["triangle"] == v).any(axis=1)]
            if all(naive.side(*(moved[k, :2].tolist() for k in cell)) > 0 for cell in around.tolist()):
                points = moved
                break
    return Mesh(points, mesh.cells)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("rounds", [1, 4])
def test_what_is_kept_and_what_gets_better(seed, rounds):
    rough = shaken(6, seed)
    mesh, report = smoothed(rough, rounds=rounds)
    invariants.assert_is_triangulation(mesh)
    invariants.assert_constrained_delaunay(mesh, rough.boundary)
    outline = on_outline(rough)
    assert (mesh.points[outline] == rough.points[outline]).all()
    assert (on_outline(mesh) == outline).all()
    assert float(invariants.area(mesh)) == pytest.approx(1, rel=1e-13)
    assert mesh.n_cells == rough.n_cells and invariants.euler(mesh) == invariants.euler(rough)
    assert invariants.angles(mesh).min() > invariants.angles(rough).min()
    assert report.counts["points moved"] == (mesh.points != rough.points).any(axis=1).sum() > 0


@settings(max_examples=40)
@given(star_polygons(), st.sampled_from([0.0, 12.0, 30.0]), st.integers(1, 3), st.integers(-30, 30))
def test_the_smallest_angle_never_gets_smaller(polygon, min_angle, rounds, exponent):
    rough = delaunay_refinement(loops(np.ldexp(polygon, exponent)), min_angle=min_angle).mesh
    mesh, _ = smoothed(rough, rounds=rounds)
    invariants.assert_is_triangulation(mesh)
    assert invariants.angles(mesh).min() >= invariants.angles(rough).min() - 1e-9
    assert float(invariants.area(mesh)) == pytest.approx(float(invariants.area(rough)), rel=1e-12)
    outline = on_outline(rough)
    assert (mesh.points[outline] == rough.points[outline]).all()
    again, _ = smoothed(mesh, rounds=rounds)
    assert invariants.angles(again).min() >= invariants.angles(mesh).min() - 1e-9


@pytest.mark.parametrize("min_angle", [20.0, 30.0])
def test_smoothing_of_refined_meshes(min_angle):
    keywords = {"min_angle": min_angle, "size": 0.05, "placement": "off-centre"}
    rough, before = delaunay_refinement(square_with_hole(), **keywords)
    _, after = smoothed(rough, rounds=5)
    name = "smallest angle (degree)"
    wanted = 35  # what the project asks of smoothing, after fronts; more than Delaunay refinement can reach
    assert after.quality[name] > wanted
    assert after.quality["mean radius ratio"] < before.quality["mean radius ratio"]
    mesh, whole = delaunay_refinement(square_with_hole(), smoothing=5, **keywords)
    assert whole.quality[name] > wanted
    assert invariants.longest_edges(mesh).max() <= 0.05
    invariants.assert_constrained_delaunay(mesh, square_with_hole())


def test_a_vertex_in_a_convex_ring_goes_to_the_mean():
    """One free vertex, far off the middle of a regular polygon, with every angle above the search's threshold."""
    ring = [[np.cos(t), np.sin(t)] for t in 2 * np.pi * np.arange(6) / 6]
    mesh = Mesh([*ring, [0.3, 0.1]], {"triangle": [[k, (k + 1) % 6, 6] for k in range(6)]})
    moved = smoothed(mesh, rounds=1).mesh
    assert moved.points[6] == pytest.approx([0, 0, 0], abs=1e-15)


def test_the_notch_where_laplacian_smoothing_fails():
    """The survey's figure 31: the mean of the neighbours lies outside their polygon."""
    ring = np.array([[0, 0], [1, 0], [6, -5], [6.2, -4.8], [1.2, 1.2], [-4.8, 6.2], [-5, 6], [0, 1]], float)
    centre = [0.6, 0.6]
    n = len(ring)
    mesh = Mesh([*ring, centre], {"triangle": [[k, (k + 1) % n, n] for k in range(n)]})
    assert quality.validate(mesh, raise_=False) == []
    result = smoothed(mesh, rounds=3).mesh
    invariants.assert_is_triangulation(result)
    assert invariants.angles(result).min() >= invariants.angles(mesh).min()


@settings(max_examples=200)
@given(st.integers(0, 10_000))
def test_the_kernel_judges_stars_as_the_law_of_sines_does(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(3, 10))
    turn = np.sort(rng.uniform(0, 2 * np.pi, n))
    ring = np.column_stack([np.cos(turn), np.sin(turn)]) * rng.uniform(0.5, 2, n)[:, None]
    centre = rng.uniform(-0.3, 0.3, 2)
    angle = naive.smallest_angle_of_star(centre.tolist(), ring.tolist())
    found = kernels.worst_angle(*centre, np.append(ring.ravel(), [0.0, 0.0]), n, np.inf, np.inf)
    if angle <= 0:
        assert found < 0
    else:
        assert found == pytest.approx(np.sin(angle) ** 2, rel=1e-9)
    radius = np.hypot(*(ring - centre).T).max()
    assert kernels.worst_angle(*centre, np.append(ring.ravel(), [0.0, 0.0]), n, 0.99 * radius**2, np.inf) < 0


def test_regions_sets_lines_and_fixed_points_stay():
    rough = shaken(8, 3)
    left = np.isin(rough.cells["triangle"], np.flatnonzero(triangulated_square(8).points[:, 0] > 0.51)).any(axis=1) == 0
    line = [[4 * 9 + k, 4 * 9 + k + 1] for k in range(8)]
    pinned = np.zeros(rough.n_points)
    pinned[[20, 21, 30]] = 1
    mesh = Mesh(
        rough.points,
        {"triangle": rough.cells["triangle"], "line": line, "vertex": [[50]]},
        point_data={"pinned": pinned, "height": rough.points[:, 0] + 2 * rough.points[:, 1]},
        cell_data={"region": np.append(left.astype(int), np.zeros(9, int)), "error": np.ones(rough.n_cells + 9)},
        sets={"some": np.flatnonzero(rough.centroids[:, 1] < 0.3)},
    )
    result, report = smoothed(mesh, fixed="pinned", rounds=3)
    for kept in (20, 21, 30, 50, *np.unique(line)):
        assert (result.points[kept] == mesh.points[kept]).all()
    assert {tuple(sorted(e)) for e in line} <= {tuple(e) for e in result.edges.tolist()}
    assert (result.cells["line"] == mesh.cells["line"]).all() and (result.cells["vertex"] == [[50]]).all()
    areas = quality.measure(result, "area")[: rough.n_cells], quality.measure(mesh, "area")[: rough.n_cells]
    for members in (left, np.isin(np.arange(rough.n_cells), mesh.sets["some"])):
        assert areas[0][members].sum() == pytest.approx(areas[1][members].sum(), rel=1e-12)
    assert list(result.cell_data) == ["region"] and any("'error' is left out" in w for w in report.warnings)
    assert result.point_data["height"] == pytest.approx(result.points[:, 0] + 2 * result.points[:, 1], abs=1e-12)
    assert (result.point_data["pinned"] == pinned).mean() > 0.5


def test_a_mesh_in_a_tilted_plane():
    flat = shaken(6, 1)
    turn = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
    for matrix in (turn, turn[:, [1, 0, 2]]):  # seen from both sides
        tilted = flat.with_points(flat.points @ matrix.T + [3.0, -2.0, 5.0])
        mesh, report = smoothed(tilted)
        outline = on_outline(flat)
        assert (mesh.points[outline] == tilted.points[outline]).all()
        back = (mesh.points - [3.0, -2.0, 5.0]) @ matrix
        assert np.abs(back[:, 2]).max() < 1e-14
        assert report.quality["smallest angle (degree)"] > invariants.angles(flat).min() + 5


@pytest.mark.parametrize("power", [-900, -40, 40, 900])
def test_scale_does_not_matter(power):
    rough = shaken(5, 2)
    one, other = (smoothed(rough.with_points(np.ldexp(rough.points, p))).mesh for p in (0, power))
    assert (np.ldexp(one.points, power) == other.points).all()
    assert (one.cells["triangle"] == other.cells["triangle"]).all()


def test_the_same_again():
    one, other = (smoothed(shaken(6, 4)).mesh for _ in range(2))
    assert (one.points == other.points).all() and (one.cells["triangle"] == other.cells["triangle"]).all()


def test_bad_input_is_refused():
    good = triangulated_square(3)
    quad = Mesh([[0, 0], [1, 0], [1, 1], [0, 1]], {"quad": [[0, 1, 2, 3]]})
    with pytest.raises(InvalidInput, match="smooths triangles only, got quad"):
        smoothed(quad)
    with pytest.raises(InvalidInput, match="needs a Mesh"):
        smoothed(good.points)
    with pytest.raises(InvalidInput, match="needs triangles"):
        smoothed(square())
    with pytest.raises(InvalidInput, match="is no point array of the mesh: 'x'; there are: front"):
        smoothed(good, fixed="x")
    with pytest.raises(InvalidInput, match="rounds"):
        smoothed(good, rounds=0)
    with pytest.raises(InvalidInput, match="must have one value a point"):
        smoothed(good.with_point_data(v=np.zeros((good.n_points, 2))), fixed="v")
    with pytest.raises(InvalidGeometry, match="belongs to no cell"):
        smoothed(Mesh([*good.points, [5, 5, 0]], good.cells))
    turned = Mesh(good.points, {"triangle": good.cells["triangle"][:, ::-1]})
    with pytest.raises(InvalidGeometry, match="is no valid mesh"):
        smoothed(turned)
    bent = good.points.copy()
    bent[5, 2] = 0.3
    with pytest.raises(InvalidGeometry):
        smoothed(Mesh(bent, good.cells))
    twice = Mesh(good.points, {"triangle": [*good.cells["triangle"], good.cells["triangle"][0]]})
    with pytest.raises(InvalidGeometry, match="is no valid mesh"):
        smoothed(twice)


def test_progress_can_cancel():
    for word in ("checking", "smoothing", "flipping"):
        with pytest.raises(meshcore.Cancelled):
            smoothed(triangulated_square(4), progress=lambda fraction, message, word=word: word not in message)


def test_two_parts_that_touch_in_a_point():
    one = triangulated_square(3)
    points = np.concatenate([one.points, one.points[1:] + [1, 1, 0]])
    number = np.concatenate([[15], np.arange(16, 31)])
    both = Mesh(points, {"triangle": np.concatenate([one.cells["triangle"], number[one.cells["triangle"]]])})
    mesh = smoothed(both).mesh
    assert float(invariants.area(mesh)) == pytest.approx(2, rel=1e-13)
