"""Layers from surfaces: exact spheres, sharp corners, edges, glued blocks, and surfaces that are none."""

from dataclasses import replace

import numpy as np
import pytest

import meshcore as mc
from meshcore import gallery, quality
from meshcore.errors import Cancelled, GenerationFailed, InvalidGeometry, InvalidInput
from meshcore.structured.marching import _layer_kernels as kernels
from meshcore.structured.marching import layer_equations, layer_marching
from meshcore.structured.marching.front_bends import concavity
from meshcore.structured.marching.front_edges import free_edges
from meshcore.structured.marching.layer_equations import LayerEquations
from meshcore.structured.marching.layer_heights import layer_heights
from meshcore.structured.marching.layer_marching import first_normals, marched
from meshcore.structured.marching.layer_surface import read_surface
from meshcore.threads import Workers
from tests import naive_layers as naive
from tests.named_sides import solid
from tests.surfaces import random_surfaces


def body(name, n=6):
    """Bodies of bricks, sheared where a corner of 60 degrees is wanted."""
    filled = np.ones((2 * n, 2 * n, n if name in ("ledge", "notch") else 2 * n), bool)
    if name in ("ledge", "notch"):  # one concave edge
        filled[n:, n:] = False
    elif name == "inner corner":  # three of them meet
        filled[n:, n:, n:] = False
    elif name == "saddles":  # two levels beside a groove
        filled[n:, n:, n:] = False
        filled[: n // 2, n:, :] = False
    mesh = gallery.bricks(filled, size=1 / n)
    if name == "notch":  # the right angle becomes 60 degrees
        x, y, z = mesh.points.T
        mesh = mesh.with_points(np.column_stack([x + 0.5 * y, np.sqrt(0.75) * y, z]))
    return mesh


def wavy_patch(n=9):
    u, v = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 2, 2 * n), indexing="ij")
    return mc.StructuredGrid(np.stack([u, v, 0.1 * np.sin(4 * u) * np.cos(3 * v)], axis=-1))


# ---- kernels beside their twins


@pytest.fixture(scope="module", params=["closed", "open"])
def front(request):
    surface = gallery.bumpy_ball(80) if request.param == "closed" else wavy_patch()
    graph = read_surface(surface).graph
    return graph, naive.rings(graph.faces.tolist(), len(graph.points))


def test_rings_agree_with_the_twin(front):
    graph, found = front
    for i, (ring, opened) in enumerate(found):
        mine = graph.ring[graph.start[i] : graph.start[i + 1]].tolist()
        shift = 0 if opened else mine.index(ring[0])
        assert mine[shift:] + mine[:shift] == ring
        assert graph.opened[i] == opened


def test_normals_weights_and_corners_agree_with_the_twins(front):
    graph, found = front
    n, hold = len(graph.points), free_edges(graph)
    topology = (graph.start, graph.ring, graph.opened)
    normal, weight, worst = np.empty((n, 3)), np.empty(len(graph.ring)), np.empty(n)
    kernels.normals(0, n, graph.points, *topology, hold.row, hold.projectors, kernels.SEEN, normal)
    assert np.abs(normal - naive.normals(graph.points, found)).max() < 1e-12
    kernels.ring_weights(0, n, graph.points, normal, *topology, np.zeros(n, np.int64), weight)
    for i, expected in enumerate(naive.ring_weights(graph.points, normal, found)):
        mine = weight[graph.start[i] : graph.start[i + 1]]
        assert np.abs(np.sort(mine) - np.sort(expected)).max() < 1e-9
    rng = np.random.default_rng(0)
    above = graph.points + 0.1 * normal + 0.05 * rng.normal(size=(n, 3))
    kernels.corner_volumes(0, n, 0.0, graph.points, above, *topology, worst)
    assert np.abs(worst - naive.corner_volumes(graph.points, above, found)).max() < 1e-12


@pytest.mark.parametrize("volume_smoothing", [0.0, 1.0])
@pytest.mark.parametrize("height", [0.01, 1.0])
def test_corrections_of_a_step_are_the_dense_solution(front, height, volume_smoothing, monkeypatch):
    graph, _found = front
    rng = np.random.default_rng(1)
    monkeypatch.setattr(layer_equations, "ENOUGH", 1e-13)
    monkeypatch.setattr(layer_equations, "ITERATIONS", 1000)
    n, hold, normal = len(graph.points), free_edges(graph), first_normals(graph)
    weight = rng.uniform(0.1, 1, len(graph.ring))
    weight /= np.repeat(np.add.reduceat(weight, graph.start[:-1]), np.diff(graph.start))
    strength, right = rng.uniform(0, 2, n), height * rng.normal(size=(n, 3))
    with Workers(1) as workers:
        equations = LayerEquations(graph, hold, workers, volume_smoothing)
        for part in (0.5, 1.0):  # the second step begins with the corrections of the first
            equations.right[:] = part * right
            rest, _ = equations.solve(part * height, graph.points, normal, weight, strength)
    spans = list(zip(graph.start[:-1], graph.start[1:], strict=True))
    rings = [(graph.ring[a:b].tolist(), bool(opened)) for (a, b), opened in zip(spans, graph.opened, strict=True)]
    expected = naive.stepped(
        graph.points, normal, rings, hold.free == 1, height, volume_smoothing, strength,
        [weight[a:b] for a, b in spans], right,
    )  # fmt: skip
    assert rest <= 1e-10 and np.abs(equations.solution - expected).max() < 1e-9 * height


# ---- spheres


def test_a_sphere_of_six_patches_is_radial_with_exact_heights():
    blocks, report = mc.hyperbolic_volume(gallery.six_patches(17), first_height=1e-4, layers=40, distance=10.0)
    assert report.converged and isinstance(blocks, mc.MultiBlock)
    for block in blocks.blocks:
        radius = np.linalg.norm(block.points, axis=-1)
        assert np.ptp(radius, axis=(0, 1)).max() < 1e-12 * 11
        assert np.abs(block.points / radius[..., None] - block.points[:, :, :1]).max() < 1e-12
        heights = np.diff(radius[0, 0])
        assert heights[0] == pytest.approx(1e-4, rel=1e-9)
        assert np.ptp(heights[1:] / heights[:-1]) < 1e-8
        assert block.names["kmin"] == "wall" and block.names["kmax"] == "outer"


def test_growth_is_what_was_asked():
    mesh, _ = mc.hyperbolic_volume(gallery.bumpy_ball(642, bump=0.1), first_height=1e-3, growth=1.2, layers=8)
    layers = mesh.points.reshape(9, -1, 3)
    heights = np.linalg.norm(np.diff(layers, axis=0), axis=2)
    assert np.abs(np.median(heights[1:] / heights[:-1], axis=1) - 1.2).max() < 0.02 * 1.2
    assert np.abs(heights[0] / 1e-3 - 1).max() < 0.03  # in hollows; elsewhere exact


def test_blocks_keep_meeting_point_by_point():
    given = gallery.six_patches(9)
    blocks, _ = mc.hyperbolic_volume(given, first_height=0.01, layers=5)
    for k in range(1, 6):
        for block, start in zip(blocks.blocks, given.blocks, strict=True):
            assert (block.points[:, :, 0] == start.points[:, :, 0]).all()
        flat = np.concatenate([block.points[:, :, k].reshape(-1, 3) for block in blocks.blocks])
        wall = np.concatenate([block.points[:, :, 0].reshape(-1, 3) for block in given.blocks])
        assert len(np.unique(flat, axis=0)) == len(np.unique(np.round(wall, 12), axis=0))


# ---- corners


@pytest.mark.parametrize("name", ["cube", "ledge", "inner corner", "saddles", "notch"])
def test_corners_do_not_fold(name):
    surface = body(name)
    mesh, report = mc.hyperbolic_volume(surface, first_height=1e-3, layers=40, distance=3.0)
    assert report.converged and report.counts["layers"] == 40
    assert quality.validate(mesh) == []
    assert (quality.measure(solid(mesh), "jacobian") > 0).all()
    assert (mesh.points[: surface.n_points] == surface.points).all()


def test_a_concave_edge_of_many_cells_does_not_fold_far_from_the_wall():
    """Dissipation must reach as far along the front as the front is from the wall, however many cells that is.

    Lines that meet at 60 degrees must be bent before they do, which takes equations that are solved.
    """
    graph = read_surface(body("notch", 32)).graph
    layers, outcome = marched(graph, layer_heights(3e-4, 1.2, layers=192, distance=5.0))
    assert len(layers) == 193 and outcome.worst > 0.05 and outcome.residual < 0.01


def test_convex_surfaces_keep_heights_and_right_angles():
    """No dissipation acts where lines spread, and the sharp edge of a wing's tip bears no more than a little."""
    heights = layer_heights(1e-4, 1.2, layers=60, distance=5.0)
    for surface in (body("cube", 10), gallery.wing_tip(40, 30, 4)):
        graph = read_surface(surface).graph
        layers, outcome = marched(graph, heights)
        assert len(layers) == 61 and outcome.residual < 0.01
        ways = np.diff(layers, axis=0)
        middle = 0.5 * (layers[1:] + layers[:-1])
        inside = graph.opened == 0
        for way, height, front in zip(ways[20:], heights[20:], middle[20:], strict=True):
            normal = first_normals(replace(graph, points=front))
            along = np.einsum("ij,ij->i", way, normal)[inside]
            assert np.quantile(np.abs(along / height - 1), 0.99) < 0.002
            assert np.median(along / np.linalg.norm(way[inside], axis=1)) > np.cos(np.radians(0.2))


def test_a_wing_tip_stays_on_its_plane_of_symmetry():
    wing = gallery.wing_tip(24, 12, 2)
    mesh, report = mc.hyperbolic_volume(wing, first_height=1e-3, layers=30, distance=1.0)
    assert report.converged and quality.validate(mesh) == []
    assert set(solid(mesh).cells) == {"wedge", "hexahedron"}
    root = wing.points[:, 2] == 0
    assert (mesh.points.reshape(31, -1, 3)[:, root, 2] == 0).all()
    assert not report.warnings


def test_a_wing_tip_is_marched_far_with_less_dissipation():
    mesh, report = mc.hyperbolic_volume(gallery.wing_tip(24, 12, 4), first_height=1e-4, layers=60, distance=5.0)
    assert report.converged and report.quality["total height"] == pytest.approx(5, rel=1e-3)
    assert (quality.measure(solid(mesh), "jacobian") > 0).all()


def test_symmetric_surfaces_get_symmetric_layers():
    mesh, _ = mc.hyperbolic_volume(body("ledge"), first_height=1e-3, layers=30, distance=2.0)
    mirrored = mesh.points[:, [1, 0, 2]]
    order, other = (np.lexsort(np.round(p, 6).T) for p in (mesh.points, mirrored))
    assert np.abs(mesh.points[order] - mirrored[other]).max() < 1e-10


@pytest.mark.parametrize("surface", [gallery.bumpy_ball(800), body("ledge", 4)])
def test_layers_do_not_depend_on_the_number_of_threads(surface, monkeypatch):
    for module in (layer_marching, layer_equations):
        monkeypatch.setattr(module, "NODES_A_THREAD", 64)
    one, *others = (mc.hyperbolic_volume(surface, first_height=1e-3, layers=20, threads=k) for k in (1, 2, 3))
    for other in others:
        assert (one.mesh.points == other.mesh.points).all() and one.report.iterations == other.report.iterations


def test_concavity_is_found():
    graph = read_surface(body("ledge")).graph
    bend, place = concavity(graph, np.array([1.0, 1.0, 0.5]))
    assert bend == pytest.approx(90) and place[:2] == pytest.approx([1, 1])
    assert concavity(read_surface(body("cube")).graph, np.zeros(3))[0] == 0


def test_a_march_that_must_stop_says_where():
    inside, report = mc.hyperbolic_volume(body("cube"), first_height=0.02, layers=60, other_side=True)
    assert not report.converged and 0 < report.counts["layers"] < 60
    assert "stopped after" in report.warnings[-1] and "inner angle of 90" in report.warnings[-1]
    assert quality.validate(inside) == []
    at = np.array([report.quality[f"stopped at {axis}"] for axis in "xyz"])
    marked = inside.selected(inside.cell_data["stopped"] > 0)
    assert np.linalg.norm(marked.points - at, axis=1).min() < 1e-12


def test_nothing_made_is_an_error():
    with pytest.raises(GenerationFailed, match="no layer could be made"):
        mc.hyperbolic_volume(body("cube"), first_height=5.0, layers=1, other_side=True)


def test_points_from_which_no_line_sees_all_faces_are_told():
    filled = np.zeros((2, 2, 2), bool)
    for brick in ((0, 0, 0), (1, 0, 0), (0, 0, 1), (0, 1, 1)):  # in the middle a ridge ends in a valley, three times
        filled[brick] = True
    surface = gallery.bricks(filled.repeat(2, 0).repeat(2, 1).repeat(2, 2), size=0.25)
    with pytest.raises(GenerationFailed, match="no line sees all faces") as caught:
        mc.hyperbolic_volume(surface, first_height=0.01, layers=3)
    assert (surface.points[list(caught.value.points)] == 0.5).all()


def test_layers_of_any_surface_are_sound_or_stop_with_the_place():
    """Sixty-four of `tests.surfaces`; a thousand are run by hand."""
    for k, (kind, surface) in enumerate(random_surfaces(64, 5)):
        rng = np.random.default_rng([5, k, 1])
        asked = {"first_height": mc.Relative(10 ** rng.uniform(-4, -2)), "layers": int(rng.integers(10, 30))}
        try:
            made, report = mc.hyperbolic_volume(surface, distance=mc.Relative(rng.uniform(0.3, 2)), threads=1, **asked)
        except GenerationFailed as error:
            assert "no layer could be made" in str(error) and error.points is not None, kind
            continue
        for block in made.blocks if isinstance(made, mc.MultiBlock) else (made,):
            assert quality.validate(block) == [], kind
        whole = report.counts["layers"] == asked["layers"]
        assert report.converged == whole and report.residual <= 0.01, kind
        assert whole or "stopped after" in report.warnings[-1], kind


def two_balls(gap):
    one = gallery.bumpy_ball(162, bump=0.0)
    points = np.concatenate([one.points, one.points + [2 + gap, 0.1, 0.2]])
    return mc.Mesh(points, {"triangle": np.concatenate([one.get("triangle"), one.get("triangle") + 162])})


def test_surfaces_that_would_meet_stop_before():
    mesh, report = mc.hyperbolic_volume(two_balls(0.5), first_height=0.02, layers=30)
    assert not report.converged and "would meet another part" in report.warnings[-1]
    assert 0.15 < report.quality["total height"] < 0.3
    assert quality.validate(mesh) == []
    _far, report = mc.hyperbolic_volume(two_balls(9.0), first_height=0.02, layers=15)
    assert report.converged


def test_a_surface_that_passes_through_itself_is_refused():
    with pytest.raises(InvalidGeometry, match="passes through itself"):
        mc.hyperbolic_volume(two_balls(-0.5), first_height=0.02, layers=3)


# ---- edges


@pytest.mark.parametrize("edges", ["automatic", "free", "splay", "constant y"])
def test_edges_of_open_surfaces(edges):
    given = wavy_patch()
    grid, report = mc.hyperbolic_volume(given, first_height=0.01, layers=12, edges=edges)
    assert isinstance(grid, mc.StructuredGrid) and grid.shape == (9, 18, 13)
    assert quality.validate(grid) == [] and report.converged
    rim = grid.points[:, [0, -1]] - given.points[:, [0, -1]]
    if edges == "constant y":
        assert np.abs(rim[..., 1]).max() == 0
    if edges == "splay":
        assert (rim[:, 0, 1:, 1] < 0).all() and (rim[:, 1, 1:, 1] > 0).all()


def test_straight_edges_of_a_flat_plate_stay_in_planes_and_free_ones_are_told():
    u, v = np.meshgrid(np.linspace(0, 1, 5), np.linspace(0, 1, 5), indexing="ij")
    plate = mc.StructuredGrid(np.stack([u, v, 0 * u], axis=-1))
    grid, report = mc.hyperbolic_volume(plate, first_height=0.1, growth=1.5, layers=4)
    assert np.abs(grid.points[..., :2] - plate.points[..., :2]).max() < 1e-15
    assert np.allclose(grid.points[2, 2, :, 2], [0, 0.1, 0.25, 0.475, 0.8125])
    ball = gallery.bumpy_ball(200)
    holed = ball.selected(~(ball.get("triangle") == 7).any(axis=1))
    _, report = mc.hyperbolic_volume(holed, first_height=0.01, layers=4)
    assert any("open" in text for text in report.warnings)


def test_the_other_side_of_a_patch():
    there, _ = mc.hyperbolic_volume(wavy_patch(), first_height=0.01, layers=3)
    back, _ = mc.hyperbolic_volume(wavy_patch(), first_height=0.01, layers=3, other_side=True)
    assert there.points[..., -1, 2].mean() > 0.02 and back.points[..., -1, 2].mean() < -0.02
    assert quality.validate(back) == []


# ---- bad input


def test_faces_are_turned_alike_and_outwards():
    ball = gallery.bumpy_ball(100)
    flip = np.zeros(ball.n_cells, bool)
    flip[::3] = True
    expected, _ = mc.hyperbolic_volume(ball, first_height=0.01, layers=3)
    mixed, report = mc.hyperbolic_volume(ball.reoriented(flip), first_height=0.01, layers=3)
    inward, other = mc.hyperbolic_volume(ball.reoriented(), first_height=0.01, layers=3)
    assert "turned to agree" in report.warnings[0] and "faced inwards" in other.warnings[0]
    assert np.abs(mixed.points - expected.points).max() < 1e-12
    assert np.abs(inward.points - expected.points).max() < 1e-12


def test_repeated_points_are_glued():
    ball = gallery.bumpy_ball(60)
    triangles = ball.get("triangle")
    loose = mc.Mesh(ball.points[triangles.ravel()], {"triangle": np.arange(triangles.size).reshape(-1, 3)})
    mesh, report = mc.hyperbolic_volume(loose, first_height=0.01, layers=2)
    assert mesh.n_points == 3 * 60 and "made one" in report.warnings[0]


def test_poles_of_grids_become_wedges():
    u, v = np.meshgrid(np.linspace(0, np.pi, 9), np.linspace(0, 2 * np.pi, 17), indexing="ij")
    ball = mc.StructuredGrid(np.stack([np.sin(u) * np.cos(v), np.sin(u) * np.sin(v), np.cos(u)], axis=-1))
    mesh, report = mc.hyperbolic_volume(ball, first_height=0.01, layers=3)
    assert len(mesh.get("wedge")) == 3 * 32 and quality.validate(mesh) == []
    assert any("pole" in text for text in report.warnings)


def moebius():
    turn = np.linspace(0, 2 * np.pi, 25)[:-1]
    rows = [np.column_stack([(2 + r * np.cos(turn / 2)) * np.cos(turn), (2 + r * np.cos(turn / 2)) * np.sin(turn),
                             r * np.sin(turn / 2)]) for r in (-0.5, 0.5)]  # fmt: skip
    k, after = np.arange(24), np.roll(np.arange(24), -1)
    quads = np.column_stack([k, after, after + 24, k + 24])
    quads[-1] = [23, 24, 0, 47]
    return mc.Mesh(np.concatenate(rows), {"quad": quads})


def test_surfaces_that_are_none_are_refused():
    two = [[0, 1, 2], [0, 3, 1], [0, 1, 4]]
    fan = mc.Mesh([[0, 0, 0], [0, 0, 1], [1, 0, 0], [0, 1, 0], [-1, -1, 0]], {"triangle": two})
    with pytest.raises(InvalidGeometry, match="more than two faces") as caught:
        mc.hyperbolic_volume(fan)
    assert caught.value.points == (0, 1)
    with pytest.raises(InvalidGeometry, match="one side only"):
        mc.hyperbolic_volume(moebius())
    touching = mc.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]], {"triangle": [[0, 1, 2], [0, 3, 4]]})
    with pytest.raises(InvalidGeometry, match="single point"):
        mc.hyperbolic_volume(touching)
    flat = mc.Mesh([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0]], {"triangle": [[0, 1, 2], [0, 2, 3]]})
    with pytest.raises(InvalidGeometry, match="flat"):
        mc.hyperbolic_volume(flat)
    with pytest.raises(InvalidInput, match="no faces"):
        mc.hyperbolic_volume(mc.Mesh(np.zeros((0, 3)), {}))
    with pytest.raises(InvalidInput, match="tetra"):
        mc.hyperbolic_volume(mc.Mesh(np.eye(4)[:, :3], {"tetra": [[0, 1, 2, 3]]}))
    with pytest.raises(InvalidInput, match="nk = 1"):
        mc.hyperbolic_volume(mc.StructuredGrid(np.zeros((2, 2, 2, 3))))


@pytest.mark.parametrize(
    "arguments",
    [
        {"first_height": 0.0},
        {"first_height": -1.0},
        {"first_height": float("nan")},
        {"growth": 0.9},
        {"growth": 3.5},
        {"layers": 0},
        {"layers": 10**9},
        {"edges": "plane"},
        {"edges": "sideways"},
        {"threads": 0},
        {"first_height": 1.0, "layers": 10, "distance": 2.0},
    ],
)
def test_bad_parameters_are_refused(arguments):
    with pytest.raises(InvalidInput):
        mc.hyperbolic_volume(gallery.bumpy_ball(60), **arguments)


def test_it_can_be_cancelled():
    with pytest.raises(Cancelled):
        mc.hyperbolic_volume(gallery.bumpy_ball(60), progress=lambda fraction, message: fraction < 0.3)


def test_march_returns_the_surface_first():
    graph = read_surface(gallery.bumpy_ball(60)).graph
    layers, outcome = marched(graph, [0.1, 0.1], threads=1)
    assert (layers[0] == graph.points).all() and len(layers) == 3 and outcome.steps == 2
