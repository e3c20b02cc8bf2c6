"""Voronoi diagrams: cells are what is nearest, they conform and fill the domain, on any points."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial import ConvexHull, Delaunay, Voronoi, cKDTree

from meshcore import (
    Cancelled,
    InvalidGeometry,
    InvalidInput,
    Mesh,
    StructuredGrid,
    gallery,
    quality,
    voronoi_2d,
    voronoi_3d,
)
from meshcore.mesh import polygons
from meshcore.unstructured.convex_domain import within_loop, within_surface
from meshcore.unstructured.voronoi_cells import circumcentres, exact_circumcentre
from tests import naive, point_sets

RNG = np.random.default_rng(7)


def assert_fills(mesh, measure, surface=None):
    """Cells are positive, share their edges and faces two by two, and fill a domain of this area or volume."""
    assert (mesh.volumes > -1e-13 * measure).all()
    assert abs(mesh.volumes.sum() - measure) <= 1e-12 * measure
    pairs, row = polygons.edges(mesh.face_offsets, mesh.face_nodes)
    if mesh.dimension == 2:
        assert len(np.unique(pairs, axis=0)) == len(pairs)  # so no edge has more than two cells, one on each side
        lines = mesh.boundary
        assert np.bincount(lines.get("line").ravel()).max() == 2
        outline = np.linalg.norm(np.diff(lines.points[lines.get("line")], axis=1)[:, 0], axis=1).sum()
    else:
        back = mesh.neighbour[row] >= 0
        directed = np.concatenate([pairs, pairs[back][:, ::-1]])
        cell = np.concatenate([mesh.owner[row], mesh.neighbour[row[back]]])
        there = np.unique(np.column_stack([cell, directed]), axis=0)
        assert len(there) == len(directed)  # each cell is closed: every edge runs once forth and once back
        assert np.array_equal(there, np.unique(np.column_stack([cell, directed[:, ::-1]]), axis=0))
        outline = mesh.boundary.volumes.sum()
    if surface is not None:
        assert outline == pytest.approx(surface, rel=1e-11)
    assert len(np.unique(mesh.face_nodes)) == mesh.n_points


def box_of(mesh):
    """Area or volume, and outline, of the mesh's bounding box."""
    size = np.ptp(mesh.points, axis=0)[: mesh.dimension]
    return size.prod(), 2 * size.sum() if len(size) == 2 else 2 * (
        size[0] * size[1] + size[1] * size[2] + size[0] * size[2]
    )


def assert_diagram(mesh):
    assert_fills(mesh, *box_of(mesh))


# ---- against brute force


@settings(max_examples=80, deadline=None)
@given(arrays(np.float64, st.tuples(st.integers(1, 12), st.just(2)), elements=st.integers(0, 4).map(float)))
def test_areas_on_small_grids_are_those_of_fractions(points):
    mesh, report = voronoi_2d(points, box=(-1, -1, 5, 5))
    assert_fills(mesh, 36.0, 24.0)
    first = np.sort(np.unique(points, axis=0, return_index=True)[1])
    assert mesh.cell_data["site"].tolist() == first.tolist()
    assert report.counts["duplicates"] == len(points) - len(first)
    exact = naive.voronoi_areas(points[first].tolist(), ((-1, -1), (5, 5)))
    np.testing.assert_allclose(mesh.volumes, [float(area) for area in exact], rtol=1e-13)


@settings(max_examples=60, deadline=None)
@given(arrays(np.float64, st.tuples(st.integers(1, 10), st.just(2)), elements=st.floats(0, 1, width=32)))
def test_areas_of_any_points_are_those_of_fractions(points):
    points[np.abs(points) < 1e-30] = 0
    mesh, _ = voronoi_2d(points, box=(-0.5, -0.5, 1.5, 1.5))
    assert_fills(mesh, 4.0, 8.0)
    exact = naive.voronoi_areas(points[mesh.cell_data["site"]].tolist(), ((-0.5, -0.5), (1.5, 1.5)))
    np.testing.assert_allclose(mesh.volumes, [float(area) for area in exact], atol=1e-11)


def inside(mesh, cell, samples):
    """Whether each sample lies in a convex cell."""
    offsets, faces = mesh.cell_faces
    within = np.ones(len(samples), bool)
    if mesh.dimension == 2:
        nodes = mesh.face_nodes[mesh.face_offsets[cell] : mesh.face_offsets[cell + 1]]
        for a, b in zip(mesh.points[nodes], mesh.points[np.roll(nodes, -1)], strict=True):
            within &= (b[0] - a[0]) * (samples[:, 1] - a[1]) - (b[1] - a[1]) * (samples[:, 0] - a[0]) > 0
        return within
    for face in faces[offsets[cell] : offsets[cell + 1]]:
        corners = mesh.points[mesh.face_nodes[mesh.face_offsets[face] : mesh.face_offsets[face + 1]]]
        normal = np.cross(corners - corners[0], np.roll(corners - corners[0], -1, axis=0)).sum(axis=0)
        sign = 1 if mesh.owner[face] == cell else -1
        within &= sign * ((samples - corners.mean(axis=0)) @ normal) < 0
    return within


@pytest.mark.parametrize("make", [voronoi_2d, voronoi_3d])
def test_each_place_is_in_the_cell_of_its_nearest_site(make):
    dimension = 2 if make is voronoi_2d else 3
    sites = RNG.random((40, dimension))
    mesh, _ = make(sites, box=(*[0.0] * dimension, *[1.0] * dimension))
    samples = RNG.random((4000, dimension))
    nearest = cKDTree(sites).query(samples)[1]
    for cell in range(mesh.n_cells):
        np.testing.assert_array_equal(inside(mesh, cell, samples), nearest == mesh.cell_data["site"][cell])


@pytest.mark.parametrize("make", [voronoi_2d, voronoi_3d])
def test_inner_cells_and_neighbours_are_qhulls(make):
    dimension = 2 if make is voronoi_2d else 3
    sites = RNG.random((300, dimension))
    mesh, _ = make(sites, box=(*[-0.5] * dimension, *[1.5] * dimension))
    assert_diagram(mesh)
    peer = Voronoi(sites)
    compared = 0
    for site, region in enumerate(peer.point_region):
        corners = peer.vertices[peer.regions[region]]
        if -1 not in peer.regions[region] and (np.abs(corners - 0.5) < 1).all():
            assert mesh.volumes[site] == pytest.approx(ConvexHull(corners).volume, rel=1e-9)
            compared += 1
    assert compared > 100
    edges = {tuple(sorted(pair)) for cell in Delaunay(sites).simplices.tolist() for pair in naive.pairs(cell)}
    assert {tuple(pair) for pair in mesh.neighbours.tolist()} <= edges
    assert len(mesh.neighbours) > 0.9 * len(edges)


# ---- degenerate points


@pytest.mark.parametrize("name", point_sets.PLANE)
def test_point_sets_of_the_plane(name):
    assert_point_set(voronoi_2d, np.asarray(point_sets.PLANE[name](300, 2, np.random.default_rng(1)), float))


@pytest.mark.parametrize("name", point_sets.SPACE)
def test_point_sets_of_space(name):
    assert_point_set(voronoi_3d, np.asarray(point_sets.SPACE[name](300, 3, np.random.default_rng(1)), float))


def assert_point_set(make, points):
    mesh, report = make(points)
    assert mesh.n_cells == len(np.unique(points + 0.0, axis=0)) == len(points) - report.counts["duplicates"]
    low, high = mesh.bounds
    middle, size = 0.5 * low + 0.5 * high, (0.5 * high - 0.5 * low).max()
    plain = mesh.with_points((mesh.points - (middle if size < 1e200 else 0)) / size)
    measure, outline = box_of(plain)
    offset = np.abs(low).max() / size > 1e3  # then coordinates themselves are rounded
    if not offset:
        assert_fills(plain, measure, outline)
    assert plain.volumes.sum() == pytest.approx(measure, rel=1e-7 if offset else 1e-12)


@pytest.mark.parametrize("sites", [[[0.5, 0.5]], [[0.2, 0.5], [0.7, 0.5]], [[k / 10, 0.5] for k in range(1, 10)]])
def test_few_sites_and_sites_on_a_line_give_strips(sites):
    mesh, _ = voronoi_2d(sites, box=(0, 0, 1, 1))
    assert_diagram(mesh)
    assert mesh.n_cells == len(sites) and set(np.diff(mesh.face_offsets)) == {4}
    solid, _ = voronoi_3d([[*site, 0.25] for site in sites], box=(0, 0, 0, 1, 1, 1))
    assert_diagram(solid)
    assert set(np.diff(solid.cell_faces[0])) == {6}


def test_a_slanted_line_gives_parallel_cuts():
    sites = np.linspace([0.1, 0.2], [0.9, 0.7], 9)
    mesh, _ = voronoi_2d(sites, box=(0, 0, 1, 1))
    assert_diagram(mesh)
    assert mesh.neighbours.tolist() == [[k, k + 1] for k in range(8)]


def lattice(n, *offsets):
    cube = np.stack(np.meshgrid(*[np.arange(float(n))] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    return np.concatenate([cube + offset for offset in offsets])


def test_grids_give_squares_and_cubes():
    mesh, _ = voronoi_2d(lattice(4, 0)[::4, :2], margin=0.5)
    assert (mesh.volumes == 1).all() and mesh.n_points == 25
    solid, _ = voronoi_3d(lattice(4, 0), margin=0.5)
    np.testing.assert_allclose(solid.volumes, 1, rtol=1e-14)
    assert solid.n_points == 125 and set(np.diff(solid.face_offsets)) == {4}


def test_lattices_give_their_known_cells():
    body, _ = voronoi_3d(lattice(5, 0, 0.5))
    face, _ = voronoi_3d(lattice(5, [0, 0, 0], [0.5, 0.5, 0], [0.5, 0, 0.5], [0, 0.5, 0.5]))
    for mesh, sides, volume in ((body, {4: 6, 6: 8}, 1 / 2), (face, {4: 12}, 1 / 4)):
        assert_diagram(mesh)
        site = int(
            np.flatnonzero((mesh.centroids - 2 > -1e-9).all(axis=1) & (mesh.centroids - 2 < 1e-9).all(axis=1))[0]
        )
        offsets, faces = mesh.cell_faces
        own = np.diff(mesh.face_offsets)[faces[offsets[site] : offsets[site + 1]]]
        assert dict(zip(*np.unique(own, return_counts=True), strict=True)) == sides
        assert mesh.volumes[site] == pytest.approx(volume, rel=1e-14)


def test_sites_on_a_circle_meet_in_one_point():
    angle = 2 * np.pi * np.arange(64) / 64
    mesh, _ = voronoi_2d(np.column_stack([np.cos(angle), np.sin(angle)]))
    assert_diagram(mesh)
    assert np.bincount(mesh.face_nodes).max() == 64


def test_sites_closer_than_rounding_of_the_box_keep_their_cells():
    sites = 0.5 + np.array([[0, 0], [1, 0], [0, 1], [3, 2], [5, 7]]) * 2.0**-50
    mesh, _ = voronoi_2d(sites, box=(0, 0, 1, 1))
    assert mesh.n_cells == 5
    assert_fills(mesh, 1.0)


# ---- domains


def test_a_convex_loop_is_filled():
    loop = gallery.circle(24, radius=1.5)
    area = 24 * 0.5 * 1.5**2 * np.sin(2 * np.pi / 24)
    outline = 24 * 2 * 1.5 * np.sin(np.pi / 24)
    for boundary in (loop, loop.reoriented()):
        mesh, report = voronoi_2d(RNG.normal(size=(80, 2)), boundary)
        assert_fills(mesh, area, outline)
        assert report.counts["outside"] == 80 - mesh.n_cells > 0 and "outside the domain" in report.warnings[0]
    alone, _ = voronoi_2d([[0.1, 0.2]], loop)
    assert alone.n_points == 24
    assert_fills(alone, area, outline)


def test_a_loop_with_straight_sides_in_pieces():
    mesh, _ = voronoi_2d(RNG.random((30, 2)), gallery.square(7))
    assert_fills(mesh, 1.0, 4.0)


def test_convex_surfaces_are_filled():
    cube = StructuredGrid(np.stack(np.meshgrid(*[np.linspace(-1, 1, 4)] * 3, indexing="ij"), -1)).to_mesh().boundary
    mesh, _ = voronoi_3d(RNG.uniform(-1, 1, (50, 3)), cube)
    assert_fills(mesh, 8.0, 24.0)
    points = RNG.normal(size=(60, 3))
    hull = ConvexHull(points / np.linalg.norm(points, axis=1)[:, None])
    ball = Mesh(hull.points, {"triangle": hull.simplices.astype(np.int64)})
    mesh, report = voronoi_3d(RNG.uniform(-1, 1, (200, 3)), ball)
    assert_fills(mesh, hull.volume, hull.area)
    assert report.counts["outside"] > 50


def test_the_margin_is_a_length_or_a_share():
    sites = [[0, 0], [3, 4]]
    np.testing.assert_allclose(voronoi_2d(sites, margin=1.0).mesh.bounds[:, :2], [[-1, -1], [4, 5]])
    np.testing.assert_allclose(voronoi_2d(sites, margin="20%").mesh.bounds[:, :2], [[-1, -1], [4, 5]])
    np.testing.assert_allclose(voronoi_2d(sites, margin=0.0).mesh.volumes, 6, rtol=1e-14)


def test_sites_on_the_box_have_cells():
    mesh, _ = voronoi_2d([[0, 0], [1, 0], [1, 1], [0, 1], [0.5, 0]], box=(0, 0, 1, 1))
    assert_fills(mesh, 1.0, 4.0)
    assert mesh.n_cells == 5


def test_a_cell_lost_at_the_edge_is_no_duplicate():
    sites = [
        [2.061765254265412e-15, 6.367443734595952e-15, -1.3514540238473626e-15],
        [-9.453470308440097e-15, -1.1930542297196728e-14, -4.034111874840963e-15],
    ]
    mesh, report = voronoi_3d([*sites, sites[0]], box=(0, 0, 0, 1, 1, 1))
    assert_fills(mesh, 1.0, 6.0)
    assert mesh.cell_data["site"].tolist() == [0]
    assert (report.counts["duplicates"], report.counts["lost"], report.counts["outside"]) == (1, 1, 0)
    assert [warning[:7] for warning in report.warnings] == ["1 sites"] * 2


# ---- domains of many sides


def ball(facets):
    """Triangles of the convex hull of a spiral of points on a sphere, and its volume and area."""
    share = (np.arange(facets // 2 + 2) + 0.5) / (facets // 2 + 2)
    turn, height = np.pi * (1 + 5**0.5) * np.arange(len(share)), 1 - 2 * share
    across = np.sqrt(1 - height**2)
    hull = ConvexHull(np.column_stack([across * np.cos(turn), across * np.sin(turn), height]))
    return Mesh(hull.points, {"triangle": hull.simplices.astype(np.int64)}), hull.volume, hull.area


@pytest.mark.parametrize("sides, sites", [(10_000, 1), (10_000, 3), (10_000, 400), (500, 5000)])
def test_loops_of_many_sides_are_filled(sides, sites):
    angle = 2 * np.pi / sides
    mesh, _ = voronoi_2d(RNG.uniform(-0.7, 0.7, (sites, 2)), gallery.circle(sides))
    assert_fills(mesh, 0.5 * sides * np.sin(angle), 2 * sides * np.sin(angle / 2))
    assert mesh.n_cells == sites


@pytest.mark.parametrize("facets, sites", [(10_000, 1), (10_000, 20), (300, 1000)])
def test_surfaces_of_many_facets_are_filled(facets, sites):
    surface, volume, area = ball(facets)
    mesh, _ = voronoi_3d(RNG.uniform(-0.5, 0.5, (sites, 3)), surface)
    assert surface.n_cells == facets
    assert_fills(mesh, volume, area)
    assert mesh.n_cells == sites


@pytest.mark.parametrize("make", [voronoi_2d, voronoi_3d])
def test_cells_in_a_convex_domain_are_nearest_places(make):
    dimension = 2 if make is voronoi_2d else 3
    boundary = gallery.circle(40) if dimension == 2 else ball(60)[0]
    sites = RNG.uniform(-0.5, 0.5, (30, dimension))
    mesh, _ = make(sites, boundary)
    samples = RNG.uniform(-0.5, 0.5, (4000, dimension))
    nearest = cKDTree(sites).query(samples)[1]
    for cell in range(mesh.n_cells):
        np.testing.assert_array_equal(inside(mesh, cell, samples), nearest == mesh.cell_data["site"][cell])


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10_000), st.integers(2, 3), st.sampled_from([0, 1, 1e4]))
def test_the_first_plane_beyond_is_that_of_brute_force(seed, dimension, offset):
    rng = np.random.default_rng(seed)
    around = rng.normal(size=(int(rng.integers(4 * dimension, 200)), dimension)) * rng.choice([1, 0.01], dimension)
    hull = ConvexHull(around / np.linalg.norm(around, axis=1)[:, None])
    cells = {"line" if dimension == 2 else "triangle": hull.simplices.astype(np.int64)}
    domain = (within_loop if dimension == 2 else within_surface)(Mesh(hull.points + offset, cells))
    points = offset + 1.5 * rng.normal(size=(50, dimension))
    after = rng.integers(-1, domain.n_planes, 50)
    height = (points - domain.middle) @ domain.normals.T - domain.offsets
    clear = (np.abs(height) > 1e-6).all(axis=1)
    for least, found in (
        (np.full(50, -1), domain.first_beyond(points)),
        (after, domain.first_beyond(points, after=after)),
    ):
        beyond = (height > 0) & (np.arange(domain.n_planes) > least[:, None])
        first = np.where(beyond.any(axis=1), beyond.argmax(axis=1), domain.n_planes)
        np.testing.assert_array_equal(found[clear], first[clear])


@pytest.mark.parametrize("make", [voronoi_2d, voronoi_3d])
def test_clipping_can_be_cancelled_midway(make):
    boundary = gallery.circle(3000) if make is voronoi_2d else ball(1000)[0]
    told = []

    def stop_late(fraction, message):
        told.append(fraction)
        return fraction < 0.9

    with pytest.raises(Cancelled, match="clipping"):
        make(RNG.uniform(-0.5, 0.5, (200, 2 if make is voronoi_2d else 3)), boundary, progress=stop_late)
    assert told == sorted(told) and sum(fraction > 0.8 for fraction in told) > 2


# ---- what does not matter


@pytest.mark.parametrize("make", [voronoi_2d, voronoi_3d])
def test_powers_of_two_change_nothing_but_size(make):
    sites = RNG.random((50, 2 if make is voronoi_2d else 3))
    plain, _ = make(sites)
    for factor in (2.0**-900, 2.0**900):
        scaled, _ = make(sites * factor)
        np.testing.assert_array_equal(scaled.points, plain.points * factor)
        np.testing.assert_array_equal(scaled.face_nodes, plain.face_nodes)


@pytest.mark.parametrize("make", [voronoi_2d, voronoi_3d])
def test_the_order_of_sites_does_not_matter(make):
    sites = RNG.random((50, 2 if make is voronoi_2d else 3))
    order = RNG.permutation(50)
    plain, shuffled = make(sites).mesh, make(sites[order]).mesh
    np.testing.assert_allclose(plain.volumes[order], shuffled.volumes, rtol=1e-11)


def test_cells_can_be_cut_into_a_valid_mesh():
    solid, _ = voronoi_3d(RNG.random((30, 3)))
    assert quality.validate(solid.to_mesh()) == []
    flat, _ = voronoi_2d(RNG.random((30, 2)))
    assert quality.validate(flat.to_mesh()) == []


# ---- circumcentres


def test_circumcentres_of_slivers_have_all_their_digits():
    base = np.array([[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]], float)
    turn = np.linalg.qr(RNG.normal(size=(3, 3)))[0]
    slivers = np.stack([(base + 10.0**-k * RNG.normal(size=(4, 3))) @ turn for k in range(1, 16)])
    flip = np.linalg.det(slivers[:, 1:] - slivers[:, :1]) < 0
    slivers[flip] = slivers[flip][:, [0, 2, 1, 3]]
    found = circumcentres(slivers.reshape(-1, 3), np.arange(60).reshape(15, 4))
    for centre, corners in zip(found, slivers, strict=True):
        exact = exact_circumcentre(corners)
        assert np.linalg.norm(centre - exact) <= 1e-12 * np.linalg.norm(exact - corners[0])


# ---- refused


BAD = {
    "no points": ({"points": np.empty((0, 2))}, InvalidInput, "at least one"),
    "text": ({"points": "sites"}, InvalidInput, "points"),
    "nan": ({"points": [[np.nan, 0]]}, InvalidGeometry, "point 0"),
    "high": ({"points": [[0, 0, 1]]}, InvalidInput, "z reaches 1"),
    "one point, no extent": ({"points": [[1, 1]]}, InvalidInput, "has no extent"),
    "no width": ({"points": [[0, 0], [1, 0]], "margin": 0.0}, InvalidInput, "has no extent"),
    "turned box": ({"box": (1, 1, 0, 0)}, InvalidInput, "lower corner first"),
    "three numbers": ({"box": (1, 1, 0)}, InvalidInput, "needs 4 values"),
    "elsewhere": ({"box": (5, 5, 6, 6)}, InvalidInput, "none of the 2 points"),
    "negative": ({"margin": -1.0}, InvalidInput, "margin"),
    "no mesh": ({"boundary": 3}, InvalidInput, "boundary"),
    "not convex": ({"boundary": gallery.l_shape()}, InvalidGeometry, "is not convex: point"),
    "with a hole": ({"boundary": gallery.square_with_hole()}, InvalidGeometry, "is not convex"),
    "faces": ({"boundary": gallery.triangulated_square()}, InvalidInput, "needs line cells"),
    "flat": (
        {"boundary": Mesh([[0, 0], [1, 0], [2, 0]], {"line": [[0, 1], [1, 2], [2, 0]]})},
        InvalidGeometry,
        "encloses nothing",
    ),
    "open": ({"boundary": Mesh([[0, 0], [1, 0], [2, 1]], {"line": [[0, 1], [1, 2]]})}, InvalidGeometry, "one closed"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_refused_by_name(case):
    change, error, text = BAD[case]
    with pytest.raises(error, match=text):
        voronoi_2d(**{"points": [[0.2, 0.2], [0.3, 0.4]], **change})


def test_open_and_dented_surfaces_are_refused():
    points, cells = gallery.cloud_in_a_ball(20), {"triangle": [[0, 1, 2], [0, 3, 1], [1, 3, 2]]}
    corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    with pytest.raises(InvalidGeometry, match="closed surface"):
        voronoi_3d(points, Mesh(corners, cells))
    cube = StructuredGrid(np.stack(np.meshgrid(*[np.linspace(-1, 1, 3)] * 3, indexing="ij"), -1)).to_mesh().boundary
    dented = cube.with_points(np.where(cube.points == [[1, 0, 0]], [[0.5, 0, 0]], cube.points))
    dent = np.all(cube.points == [1, 0, 0], axis=1)
    dented = cube.with_points(np.where(dent[:, None], [[0.5, 0, 0]], cube.points))
    with pytest.raises(InvalidGeometry, match="is not convex"):
        voronoi_3d(points, dented)


@pytest.mark.parametrize("make", [voronoi_2d, voronoi_3d])
def test_can_be_cancelled(make):
    sites = RNG.random((50, 2 if make is voronoi_2d else 3))
    with pytest.raises(Cancelled):
        make(sites, progress=lambda fraction, message: fraction < 0.7)
