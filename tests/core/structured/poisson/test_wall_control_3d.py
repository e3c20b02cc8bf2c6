"""Angle and first height at faces of blocks: measured where they are known, and reached where they are asked."""

import numpy as np
import pytest

import meshcore as mc
from meshcore import InvalidInput, StructuredGrid, Wall
from meshcore.mesh.structured_grid import FACES
from meshcore.structured.algebraic.blending import blended
from meshcore.structured.poisson.block_problem import AskedOfBlock, solved
from meshcore.structured.poisson.face_measures import NEAR_EDGE, axis_of, facing, from_face, measured
from meshcore.structured.poisson.wall_faces import mismatch, respaced
from meshcore.structured.poisson.winslow_3d import count_folded


def box(*cells):
    return np.stack(np.meshgrid(*[np.linspace(0, 1, n + 1) for n in cells], indexing="ij"), axis=-1)


def bent(n):
    """A block with waves on all faces."""
    u, v, w = np.moveaxis(box(n, n + 4, n + 2), -1, 0)
    wave = 0.12 * np.sin(2.5 * u + 1) * np.cos(2 * v)
    return blended(np.stack([u + 0.2 * v * w, v + wave, w + wave + 0.1 * u], axis=-1), (0, 1, 2))


def passage(n):
    """A twisted, curved passage."""
    u, v, w = np.moveaxis(box(n, n, n), -1, 0)
    p, q, turn = (u - 0.5) * (1 + 0.3 * np.sin(np.pi * w)), v - 0.5 + 0.15 * np.sin(2 * np.pi * u) * v, 1.2 * w
    x, y = p * np.cos(turn) - q * np.sin(turn), p * np.sin(turn) + q * np.cos(turn)
    return blended(np.stack([x + 0.4 * np.sin(2 * w), y, 2.5 * w + 0.2 * u * np.sin(3 * v)], axis=-1), (0, 1, 2))


def cap(n, turned=15.0):
    """Between two caps of spheres, of which the outer one is turned."""
    u, v, w = np.moveaxis(box(n, n, n), -1, 0)
    x, y = np.tan(1.0 * (u - 0.5)), np.tan(1.0 * (v - 0.5))
    turn = np.radians(turned) * w
    direction = np.stack([x * np.cos(turn) - y * np.sin(turn), x * np.sin(turn) + y * np.cos(turn), 1 + 0 * x], axis=-1)
    return direction / np.linalg.norm(direction, axis=-1, keepdims=True) * (1 + 0.8 * w[..., None])


def inside(points):
    return np.ascontiguousarray(np.moveaxis(points, -1, 0))


def naive_angles(points, face):
    """(na, nb) degrees between each first edge and the face's normal, node by node with parabolas."""
    lines = np.moveaxis(points, axis_of(face), 2)
    lines = lines[:, :, ::-1] if face.endswith("max") else lines
    found = np.full(lines.shape[:2], np.nan)
    for a in range(1, lines.shape[0] - 1):
        for b in range(1, lines.shape[1] - 1):
            here, tangents = lines[a, b, 0], []
            for before, after in ((lines[a - 1, b, 0], lines[a + 1, b, 0]), (lines[a, b - 1, 0], lines[a, b + 1, 0])):
                s, t = np.linalg.norm(here - before), np.linalg.norm(after - here)
                at = np.array([-s, 0, t])
                tangents.append(np.polyfit(at, np.array([before, here, after]), 2)[1])
            normal = np.cross(*tangents) * facing(face)
            edge = lines[a, b, 1] - here
            found[a, b] = np.degrees(np.arccos(normal @ edge / np.linalg.norm(normal) / np.linalg.norm(edge)))
    return found


@pytest.mark.parametrize("face", FACES)
def test_a_sheared_block_has_the_angles_of_its_shear(face):
    i, j, k = np.meshgrid(np.arange(11.0), 2 * np.arange(12.0), 1.5 * np.arange(15.0), indexing="ij")
    points = np.stack([i + 0.5 * j, j, k + 0.25 * j], axis=-1)
    found = measured(inside(points), face)
    inner = found.counts
    assert inner.any() and not inner[: NEAR_EDGE + 1].any() and not inner[:, -NEAR_EDGE - 1 :].any()
    length = {"i": 1, "j": np.sqrt(4 + 1 + 0.25), "k": 1.5}[face[0]]
    assert abs(found.height - length).max() < 1e-12
    if face[0] == "j":
        up = 1 if face == "jmin" else -1
        for angle, lean in zip(found.angle, (0.5, 0.25), strict=True):
            assert abs(angle - np.degrees(np.arctan2(1, up * lean))).max() < 1e-9
        assert abs(found.off(90.0) - np.degrees(np.arctan(np.hypot(0.5, 0.25)))).max() < 1e-9
        assert abs(found.spacing[0] - 1).max() < 1e-12 and abs(found.spacing[1] - 1.5).max() < 1e-12


@pytest.mark.parametrize("face", FACES)
def test_angles_are_those_of_the_naive_twin(face):
    points = passage(8) + 0.005 * np.random.default_rng(3).standard_normal((9, 9, 9, 3))
    found = measured(inside(points), face)
    expected = naive_angles(points, face)
    inner = np.isfinite(expected)
    np.testing.assert_allclose(found.off(90.0)[inner], expected[inner], atol=1e-6)
    mirrored = measured(
        inside(points[::-1]), face.replace("imin", "x").replace("imax", "imin").replace("x", "imax"), -1
    )
    np.testing.assert_allclose(
        np.sort(mirrored.off(90.0)[1:-1, 1:-1].ravel()), np.sort(found.off(90.0)[1:-1, 1:-1].ravel()), atol=1e-9
    )


def test_views_lead_away_from_the_face():
    values = np.arange(24).reshape(2, 3, 4)
    assert from_face(values, "imax")[0, 0].tolist() == [12, 0]
    assert from_face(values, "jmin")[0, 0].tolist() == [0, 4, 8]
    assert np.shares_memory(from_face(values, "kmax"), values)


def test_a_closed_block_is_measured_across_its_cut():
    t, r, z = np.meshgrid(2 * np.pi * np.arange(18) / 16, np.linspace(1, 2, 9), np.linspace(0, 1, 12), indexing="ij")
    x = np.stack([r * np.cos(t), r * np.sin(t), z])  # its last layer repeats the second
    found = measured(x, "jmin", -1.0, (True, False, False))
    assert found.counts.shape == (17, 12) and found.counts[:, 4:-4].all() and not found.counts[:, :4].any()
    assert found.off(90.0).max() < 1e-9
    assert np.ptp(found.spacing[0]) < 1e-12


def test_creases_are_left_out_across_a_cut_too():
    t = 2 * np.pi * np.arange(26) / 24
    radius = 1 + 0.9 * np.exp(-(((t + 1) % (2 * np.pi) - 1) ** 2) * 40)  # a spike at the cut
    x = np.stack([np.outer(radius * np.cos(t), np.ones(12)), np.outer(radius * np.sin(t), np.ones(12))])
    x = np.stack([*x, np.outer(np.ones(26), np.linspace(0, 1, 12))])
    block = np.stack([x, x * np.array([1.01, 1.01, 1])[:, None, None]], axis=2)
    counts = measured(block, "jmin", -1.0, (True, False, False)).counts[:, 6]
    assert not counts[[0, 1, 2, -1, -2, -3]].any() and counts[8:-8].all()


@pytest.mark.parametrize("shape", [bent, passage, cap])
@pytest.mark.parametrize("face", ["kmin", "imax", "jmin"])
def test_walls_come_to_be_as_asked(shape, face):
    start, height = shape(24), 0.01
    grid, report = mc.elliptic_volume(
        StructuredGrid(start), walls=face, first_height=height, faces="respaced", lean_at_edges=True
    )
    assert report.converged and not report.warnings
    assert report.quality["error of wall angles (degree)"] < 1 and report.quality["error of first heights (%)"] < 5
    points = grid.points
    off = naive_angles(points, face)
    middle = np.s_[9:-9, 9:-9]  # where lines at the edges are not felt
    assert off[middle].max() < 1.5 + 0.2 * naive_angles(start, face)[[1, -2], 1:-1].max()
    lines = np.moveaxis(points, axis_of(face), 0)[:: -1 if face.endswith("max") else 1]
    heights = np.linalg.norm(lines[1] - lines[0], axis=-1)[4:-4, 4:-4]
    assert abs(heights / height - 1).max() < 0.05
    plain, _ = mc.elliptic_volume(StructuredGrid(start), faces="respaced", walls=face, first_height=None)
    assert (count_folded(points) == 0) and plain.shape == grid.shape


def test_lines_leave_a_sphere_along_its_radii_and_the_second_layer_is_a_sphere():
    start = cap(32)
    grid, report = mc.elliptic_volume(StructuredGrid(start), walls="kmin", first_height=0.004, faces="respaced")
    inner = grid.points[4:-4, 4:-4]
    first, second = inner[:, :, 0], inner[:, :, 1]
    assert abs(np.linalg.norm(second, axis=-1) - 1.004).max() < 0.05 * 0.004
    apart = np.linalg.norm(np.cross(first, second), axis=-1) / np.linalg.norm(second, axis=-1)
    assert np.degrees(np.arctan(apart / 0.004)).max() < 1.2
    assert report.converged
    assert (grid.points[:, :, 0] == start[:, :, 0]).all() and (grid.points[:, :, -1] == start[:, :, -1]).all()


def test_height_alone_leaves_the_angle_and_angle_alone_the_height():
    start = StructuredGrid(passage(20))
    x = {}
    for name, wall in {
        "plain": None,
        "height": Wall("jmin", 0.01, None),
        "angle": Wall("jmin", None, 90.0),
    }.items():
        asked = () if wall is None else (wall,)
        grid, _ = mc.elliptic_volume(start, each_wall=asked, control="none")
        x[name] = measured(inside(grid.points), "jmin")
    counts = x["plain"].counts
    assert abs(x["height"].height / 0.01 - 1)[counts].max() < 0.05
    assert x["height"].off(90.0)[counts].max() > 5
    assert x["angle"].off(90.0)[counts].max() < 2 < x["plain"].off(90.0)[counts].max()
    assert np.median(x["angle"].height / x["plain"].height) > 0.5


def test_other_angles_and_heights_over_the_face():
    start = box(24, 24, 24)
    heights = 0.01 * (1 + box(24, 24, 1)[:, :, 0, 0])
    wall = Wall("kmin", heights, (70.0, 100.0))
    grid, _ = mc.elliptic_volume(StructuredGrid(start), each_wall=[wall], faces="respaced")
    edge = (grid.points[:, :, 1] - grid.points[:, :, 0])[5:-5, 5:-5]
    assert abs(edge[..., 0] / edge[..., 2] - 1 / np.tan(np.radians(70))).max() < np.tan(np.radians(1.5))
    assert abs(edge[..., 1] / edge[..., 2] - 1 / np.tan(np.radians(100))).max() < np.tan(np.radians(1.5))
    assert abs(np.linalg.norm(edge, axis=-1) / heights[5:-5, 5:-5] - 1).max() < 0.05
    one, _ = mc.elliptic_volume(StructuredGrid(start), walls="kmin", wall_angle=75.0, control="none")
    edge = (one.points[:, :, 1] - one.points[:, :, 0])[6:-6, 6:-6]
    assert abs(np.degrees(np.arctan2(edge[..., 2], edge[..., 0])) - 75).max() < 1.5
    assert abs(np.degrees(np.arctan2(edge[..., 2], edge[..., 1])) - 90).max() < 1.5


def test_all_faces_of_a_box_that_fit_each_other():
    t = 0.5 * (1 + np.tanh(2.2 * np.linspace(-1, 1, 25)) / np.tanh(2.2))
    points = np.stack(np.meshgrid(t, t, t, indexing="ij"), axis=-1)
    points += 0.05 * np.sin(np.pi * points[..., [1, 2, 0]]) ** 2 * np.sin(np.pi * points[..., [2, 0, 1]]) ** 2
    grid, report = mc.elliptic_volume(StructuredGrid(blended(points, (0, 1, 2))), walls="all", first_height=t[1])
    assert report.converged
    for face in FACES:
        found = measured(inside(grid.points), face)
        assert found.off(90.0)[found.counts].max() < 1
        assert abs(found.height / t[1] - 1)[found.counts].max() < 0.05


def test_grids_do_not_depend_on_threads():
    start = passage(40)
    asked = [AskedOfBlock([Wall("imin", 0.005)], threads=threads) for threads in (1, 3)]
    one, other = (solved(start, None, a).points for a in asked)
    assert (one == other).all()


def test_where_faces_do_not_fit_it_is_told_and_the_best_is_kept():
    grid, report = mc.elliptic_volume(StructuredGrid(passage(16)), walls="kmin", first_height=0.002)
    assert not report.converged
    assert "on the faces around walls, first cells are up to" in report.warnings[0]
    assert "% of the points that are judged are as asked" in report.warnings[1]
    assert count_folded(grid.points) == 0


def test_where_all_nodes_are_near_edges_all_inside_are_judged():
    start = box(6, 6, 6)
    start[1:-1, 1:-1, -1, 2] += 0.1
    found = measured(inside(start), "kmin")
    assert found.counts[1:-1, 1:-1].all() and found.counts.sum() == 25
    _, report = mc.elliptic_volume(StructuredGrid(start), walls="kmin", first_height=0.9)
    assert not report.converged and report.quality["error of first heights (%)"] > 5


def test_walls_with_edges_that_are_points_need_no_height():
    t, r, z = np.moveaxis(box(8, 8, 8), -1, 0)
    wedge = np.stack([r * np.cos(t), -r * np.sin(t), z], axis=-1)
    asked = AskedOfBlock([Wall(face) for face in FACES])
    asked.check(wedge)
    found = measured(inside(wedge), "kmin")
    assert np.isfinite(found.off(90.0)).all()
    with pytest.raises(InvalidInput, match="is 1 at imin, where a whole line is"):
        AskedOfBlock([Wall("imin", 1.0)]).check(wedge)


def test_lines_on_faces_around_a_wall_begin_with_its_height():
    start = passage(16)
    walls = [Wall("kmin", 0.01), Wall("jmax", 0.02)]
    assert mismatch(start, walls) > 5
    new = respaced(start, walls)
    assert mismatch(new, walls) < 1.05  # the edges of jmax are bent, its chords shorter than arcs
    assert (new[::16, ::16, ::16] == start[::16, ::16, ::16]).all()
    new = respaced(start, walls[:1])
    for layer in (0, -1):
        assert (new[:, :, layer] == start[:, :, layer]).all()
    assert (new[1:-1, 1:-1] == start[1:-1, 1:-1]).all() and (new[0, 0, 1:-2] != start[0, 0, 1:-2]).any(axis=-1).all()
    with pytest.raises(InvalidInput, match="first_height: no spacing of 16 cells begins with those of kmin and kmax"):
        respaced(box(16, 16, 16), [Wall("kmin", 0.6), Wall("kmax", 0.6)])


def test_left_handed_blocks_are_turned_and_told():
    start = passage(12)[::-1]
    grid, report = mc.elliptic_volume(StructuredGrid(start), walls="imin", first_height=0.02, faces="respaced")
    assert "imin and imax have changed places" in report.warnings[0]
    found = measured(inside(grid.points), "imin")
    assert abs(found.height / 0.02 - 1)[found.counts].max() < 0.05


def test_bad_walls_are_named():
    grid = StructuredGrid(box(8, 8, 8))

    def refused(message, **keywords):
        with pytest.raises(InvalidInput, match=message):
            mc.elliptic_volume(grid, **keywords)

    refused("walls: 'south and north' is not one of", walls="south and north")
    refused("first_height: is given, but no walls", first_height=0.1)
    refused("first_height: is 1 at kmin, where a whole line is 1 long", walls="kmin", first_height=1.0)
    refused("first_height: must be greater than zero, got -0.1", walls="kmin", first_height=-0.1)
    refused("first_height: must be greater than zero, got 0", walls="kmin", first_height=0.0)
    refused("walls: south is no face", each_wall=[Wall("south")])
    refused("imin is named twice", each_wall=[Wall("imin"), Wall("imin", 0.1)])
    refused(r"first heights of imin need shape \(9, 9\), got \(9, 8\)", each_wall=[Wall("imin", np.ones((9, 8)))])
    refused(r"angles of imin need shape \(2, 9, 9\)", each_wall=[Wall("imin", None, np.ones((9, 9)))])
    refused("each_wall: is given beside walls", walls="kmin", each_wall=[Wall("imin")])
    refused("wall_angle: must be at least 10", walls="kmin", wall_angle=0.0)
    with pytest.raises(InvalidInput, match="is no side; sides are south"):
        Wall("up")
    with pytest.raises(InvalidInput, match="the first height must be a positive number"):
        Wall("kmin", np.array([[1.0, np.nan]]))
    square = StructuredGrid(box(8, 8, 1)[:, :, :1])
    with pytest.raises(InvalidInput, match="imin is a face of blocks"):
        mc.elliptically_smoothed(square, each_wall=[Wall("imin")])


@pytest.mark.parametrize("cells", [(1, 1, 1), (2, 2, 2), (2, 5, 3), (4, 4, 1)])
def test_walls_of_blocks_almost_without_inside(cells):
    grid, _ = mc.elliptic_volume(StructuredGrid(box(*cells)), walls="all", first_height=0.2)
    assert grid.n_cells == np.prod(cells)
    assert count_folded(grid.points) == 0
