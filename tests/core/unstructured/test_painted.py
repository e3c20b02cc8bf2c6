"""Refinement by sizes on a background mesh, on the boundary's own points, and with a limit of their gradation."""

import numpy as np
import pytest

from meshcore import Cancelled, InvalidGeometry, InvalidInput, Mesh, delaunay_refinement, gallery
from meshcore.geometry.curves import lines_through
from meshcore.sizing.background import background_field
from meshcore.sizing.gradation import limited
from meshcore.sizing.size_field import constant

BIG = Mesh([[-1, -1], [4, -1], [-1, 4]], {"triangle": [[0, 1, 2]]}, {"h": np.array([0.02, 0.27, 0.02])})


def wanted_on_big(points):
    return 0.02 + 0.05 * (points[:, 0] + 1)


def longest_edges(mesh):
    corners = mesh.points[mesh.cells["triangle"]]
    return np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)


def assert_sizes_follow(mesh, wanted):
    """No edge is longer than wanted at its triangle's middle, and most are not much shorter."""
    share = longest_edges(mesh) / wanted(mesh.centroids)
    assert share.max() <= 1 + 1e-9
    assert np.median(share) > 0.6


@pytest.mark.parametrize("name", ["h", ""], ids=["named", "the only one"])
def test_one_big_triangle_as_background(name):
    mesh, report = delaunay_refinement(gallery.square_with_hole(), BIG, size_array=name)
    assert report.converged
    assert_sizes_follow(mesh, wanted_on_big)


def test_a_mesh_of_an_earlier_computation_as_background():
    first, _ = delaunay_refinement(gallery.square_with_hole(), size=0.1)
    error = 1 + 20 * np.exp(-(((first.points[:, 0] + first.points[:, 1] - 0.7) / 0.1) ** 2))
    first = first.with_point_data(error=error, size=0.2 / error)
    second, _ = delaunay_refinement(gallery.square_with_hole(), first, size_array="size")
    assert_sizes_follow(second, background_field(first, "size"))


def test_sizes_on_the_boundary_are_carried_inwards_linearly():
    square = gallery.square().with_point_data(h=np.array([0.02, 0.2, 0.2, 0.02]))
    mesh, _ = delaunay_refinement(square, size_array="h")
    assert_sizes_follow(mesh, lambda points: 0.02 + 0.18 * points[:, 0])


def test_sizes_are_not_carried_across_a_hole():
    """Left of a slot that almost cuts the domain in two, nothing tells of the fine right side."""
    slot = Mesh([[0.48, -0.5], [0.52, -0.5], [0.52, 0.5], [0.48, 0.5]], gallery.square().cells)
    outer = Mesh([[0, -1], [1, -1], [1, 1], [0, 1]], gallery.square().cells)
    boundary = gallery.joined(outer, slot)
    sizes = np.where(boundary.points[:, 0] > 0.5, 0.02, 0.2)
    mesh, _ = delaunay_refinement(boundary.with_point_data(h=sizes), size_array="h", min_angle=25)
    middle, longest = mesh.centroids, longest_edges(mesh)
    right = (middle[:, 0] > 0.55) & (np.abs(middle[:, 1]) < 0.4)
    left = (middle[:, 0] < 0.3) & (np.abs(middle[:, 1]) < 0.2)
    assert longest[right].max() < 0.025
    assert np.median(longest[left]) > 0.08


def test_gradation_goes_around_a_hole_not_across_it():
    side = np.linspace(-0.5, 0.5, 5)
    slot = lines_through(
        np.concatenate([np.column_stack([np.full(5, 0.52), side]), np.column_stack([np.full(5, 0.48), side[::-1]])]),
        closed=True,
    )
    outer = Mesh([[0, -1], [1, -1], [1, 1], [0, 1]], gallery.square().cells)
    boundary = gallery.joined(outer, slot)
    sizes = np.where(boundary.points[:, 0] == 0.52, 0.02, 0.4)
    mesh, _ = delaunay_refinement(boundary.with_point_data(h=sizes), size_array="h", gradation=0.3, min_angle=0)
    corners = mesh.points[mesh.cells["triangle"]]
    beside = (corners == [0.48, 0.0, 0.0]).all(axis=2).any(axis=1)
    across, around = 0.02 + 0.3 * 0.04, 0.02 + 0.3 * 0.54
    assert 3 * across < 0.1 < around
    assert longest_edges(mesh)[beside].min() > 0.1


def test_a_tilted_boundary_is_meshed_as_a_flat_one():
    turn = np.linalg.qr(np.random.default_rng(4).normal(size=(3, 3)))[0]
    if np.linalg.det(turn) < 0:
        turn[:, 0] *= -1
    square = gallery.square_with_hole()
    sizes = np.random.default_rng(5).uniform(0.02, 0.2, square.n_points)
    tilted, _ = delaunay_refinement(square.with_points(square.points @ turn.T).with_point_data(h=sizes), size_array="h")
    flat, _ = delaunay_refinement(square.with_point_data(h=sizes), size_array="h")
    assert abs(tilted.n_cells / flat.n_cells - 1) < 0.05
    back, _ = delaunay_refinement(
        square.with_points(square.points @ turn.T), BIG.with_points(BIG.points @ turn.T), size_array="h"
    )
    assert_sizes_follow(back.with_points(back.points @ turn), wanted_on_big)


def test_gradation_lowers_what_grows_too_fast_on_the_background():
    background = gallery.triangulated_square(32)
    sizes = np.where(np.abs(background.points[:, 0] - 0.5) < 0.01, 0.01, 0.3)
    background = background.with_point_data(h=sizes)
    mesh, _ = delaunay_refinement(gallery.square(), background, size_array="h", gradation=0.2)
    assert_sizes_follow(mesh, background_field(background, limited(background, sizes, 0.2)))
    free, _ = delaunay_refinement(gallery.square(), background, size_array="h")
    assert free.n_cells < mesh.n_cells


def test_gradation_of_a_callable_holds_beside_what_it_asks_for():
    def step(points):
        return np.where(np.abs(points[:, 0] - 0.5) < 0.05, 0.02, 0.5)

    mesh, _ = delaunay_refinement(gallery.square(), size_field=step, gradation=0.25)
    away = np.maximum(np.abs(mesh.centroids[:, 0] - 0.5) - 0.05, 0)
    assert (longest_edges(mesh) <= step(mesh.centroids)).all()
    assert (longest_edges(mesh) <= 0.02 + 0.25 * (away + 2 / 128)).all()


def test_gradation_resolves_small_features_of_a_callable():
    centre = np.array([0.5123, 0.4377])

    def steep(points):
        return 0.0005 + 10 * np.linalg.norm(points[:, :2] - centre, axis=1)

    mesh, _ = delaunay_refinement(gallery.square(), size_field=steep, gradation=0.3)
    away = np.linalg.norm(mesh.centroids[:, :2] - centre, axis=1)
    # Ways along the edges of a triangulation are up to 1.6 times longer than straight ones.
    assert (longest_edges(mesh) <= 2 * 0.0005 + 1.6 * 0.3 * away).all()
    assert longest_edges(mesh).max() > 0.05


def test_a_callable_with_gradation_is_asked_in_the_domain_only():
    def round_the_hole(points):
        distance = np.linalg.norm(points[:, :2] - 0.5, axis=1)
        assert (distance > 0.15).all() and (np.abs(points[:, :2] - 0.5) <= 0.5).all()
        return 0.3 * distance

    hole = gallery.circle(64, radius=0.2, centre=(0.5, 0.5))
    mesh, _ = delaunay_refinement(gallery.joined(gallery.square(4), hole), size_field=round_the_hole, gradation=0.1)
    assert (longest_edges(mesh) <= round_the_hole(mesh.centroids)).all()


def test_the_smallest_size_explains_too_many_triangles_only():
    with pytest.raises(InvalidInput, match=r"is nan at \(.*greater than zero$"):
        delaunay_refinement(gallery.square(), size_field=lambda p: np.where(p[:, 0] > 0.9, np.nan, 0.05))
    with pytest.raises(InvalidInput, match=r"not callable$"):
        delaunay_refinement(gallery.square(), size_field=0.1)


def test_sizes_that_are_refused_are_not_sampled_finely_first():
    asked = []

    def field(points):
        asked.append(len(points))
        return np.full(len(points), 1e-7)

    with pytest.raises(InvalidInput, match=r"size_field: would make about"):
        delaunay_refinement(gallery.square(), size_field=field, gradation=0.2)
    assert sum(asked) < 50_000


def test_limiting_the_gradation_of_a_callable_can_be_cancelled():
    with pytest.raises(Cancelled, match="limiting the gradation"):
        delaunay_refinement(
            gallery.square(), size_field=constant(0.1), gradation=0.2, progress=lambda _, what: "gradation" not in what
        )


def test_gradation_alone_takes_the_spacing_of_the_boundary():
    hole = gallery.circle(64, radius=0.05, centre=(0.5, 0.5))
    mesh, _ = delaunay_refinement(gallery.joined(gallery.square(4), hole), gradation=0.3)
    spacing = 2 * 0.05 * np.sin(np.pi / 64)
    away = np.linalg.norm(mesh.centroids[:, :2] - 0.5, axis=1)
    near = away < 0.06
    assert longest_edges(mesh)[near].max() < spacing + 0.4 * 0.02
    assert longest_edges(mesh).max() <= 0.25


def test_all_sizes_given_hold_together():
    square = gallery.square()
    mesh, _ = delaunay_refinement(square, BIG, size_array="h", size=0.08, size_field=lambda p: 0.03 + p[:, 1])
    at = mesh.centroids
    wanted = np.minimum(np.minimum(wanted_on_big(at), 0.03 + at[:, 1]), 0.08)
    assert (longest_edges(mesh) <= wanted * (1 + 1e-9)).all()


def test_where_lines_cross_sizes_lie_between_those_of_their_ends():
    cross = Mesh(
        np.concatenate([gallery.square().points, [[0.1, 0.1, 0], [0.9, 0.9, 0], [0.1, 0.9, 0], [0.9, 0.1, 0]]]),
        {"line": np.concatenate([gallery.square().get("line"), [[4, 5], [6, 7]]])},
        {"h": np.array([0.2, 0.2, 0.2, 0.2, 0.2, 0.2, 0.02, 0.02])},
    )
    mesh, _ = delaunay_refinement(cross, size_array="h", crossings="split")
    middle = np.abs(mesh.centroids[:, :2] - 0.5).max(axis=1) < 0.05
    assert longest_edges(mesh)[middle].max() < 0.06


def test_where_lines_with_merged_ends_cross_sizes_lie_between_those_of_their_ends():
    lines = [[[0, 0], [1, 0]], [[1, 0], [1, 1]], [[1, 1], [0, 1]], [[0, 1], [0, 0]], [[0, 0], [1, 1]], [[1, 0], [0, 1]]]
    apart = Mesh(np.reshape(lines, (-1, 2)), {"line": np.arange(12).reshape(-1, 2)}, {"h": np.full(12, 0.2)})
    apart = apart.with_point_data(h=np.where(np.arange(12) >= 8, 0.02, 0.2))
    mesh, _ = delaunay_refinement(apart, size_array="h", crossings="split")
    middle = np.abs(mesh.centroids[:, :2] - 0.5).max(axis=1) < 0.05
    assert longest_edges(mesh)[middle].max() < 0.06


@pytest.mark.parametrize(
    "sizes, message",
    [
        ([0.1, 0.0, 0.1], r"'h' is 0 at point 1, \(4, -1, 0\)"),
        ([0.1, 0.1, -1.0], "'h' is -1 at point 2"),
        ([np.nan, np.nan, 1.0], r"'h' is nan at point 0, \(-1, -1, 0\) \(2 points in all\)"),
        ([np.inf, 1.0, 1.0], "'h' is inf at point 0"),
        ([[1.0, 2], [1, 2], [1, 2]], r"float64 of shape \(3, 2\); a size is one number"),
        (["a", "b", "c"], "a size is one number a point"),
    ],
)
def test_sizes_that_are_none_are_refused_with_their_place(sizes, message):
    background = Mesh(BIG.points, BIG.cells, {"h": np.array(sizes)})
    with pytest.raises(InvalidInput, match=message):
        delaunay_refinement(gallery.square(), background, size_array="h")
    if np.ndim(sizes) == 1 and not isinstance(sizes[0], str):
        boundary = gallery.square().with_point_data(h=np.append(sizes, 1.0))
        with pytest.raises(InvalidGeometry, match=message.split(r", \(")[0]) as caught:
            delaunay_refinement(boundary, size_array="h")
        assert len(caught.value.points)


def test_a_billion_triangles_are_refused_with_an_estimate_and_the_place():
    tiny = BIG.with_point_data(h=np.array([1e-6, 1e-6, 1e-6]))
    with pytest.raises(InvalidInput, match=r"about \d.*e\+1\d triangles.* smallest size is 1e-06, at \("):
        delaunay_refinement(gallery.square(), tiny, size_array="h")
    corner = gallery.square().with_point_data(h=np.full(4, 1e-7))
    with pytest.raises(InvalidInput, match=r"size_array: would make about"):
        delaunay_refinement(corner, size_array="h")


@pytest.mark.parametrize(
    "background, keywords, message",
    [
        (None, {"size_array": "heat"}, "no point array 'heat'; there are: none"),
        (BIG.with_point_data(g=np.ones(3)), {}, "name the point array .* there are: h, g"),
        (Mesh(BIG.points, BIG.cells), {}, "name the point array .* there are: none"),
        (Mesh(BIG.points, BIG.cells, {}, {"h": [1.0]}), {"size_array": "h"}, "it is an array on cells"),
        (Mesh(BIG.points, {"line": [[0, 1]]}, {"h": [1.0] * 3}), {"size_array": "h"}, "neither triangles nor"),
        ("a file", {"size_array": "h"}, "background: needs a Mesh, got str"),
        (None, {"gradation": -1.0}, "gradation: must be at least 0"),
        (None, {"gradation": 0.0}, "gradation: must be finite and greater than zero"),
        (None, {"gradation": np.nan}, "gradation: must be finite"),
    ],
)
def test_what_is_missing_or_wrong_is_named(background, keywords, message):
    with pytest.raises(InvalidInput, match=message):
        delaunay_refinement(gallery.square(), background, **keywords)
