"""Discretised curves: N_s = nint(A_s), equal integrals between nodes, corners and tags kept."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from meshcore import InvalidGeometry, InvalidInput, Mesh, discretised, gallery
from meshcore.geometry.curves import chains, lines_through
from meshcore.geometry.parametric import ParametricCurve, arc, spline
from meshcore.sizing.metric import lengths, metric


def wave(points):
    return 0.05 + 0.04 * np.sin(5 * points[:, 0]) * np.cos(3 * points[:, 1])


def integral(field, a, b):
    """Integral of 1 / size along a straight line, by an adaptive rule of scipy's."""
    length = np.linalg.norm(b - a)
    return length * quad(lambda t: 1 / field((a + t * (b - a))[None])[0], 0, 1, epsabs=1e-11, epsrel=1e-11)[0]


def line_integrals(mesh, field):
    return np.array([integral(field, *mesh.points[line]) for line in mesh.get("line")])


@pytest.mark.parametrize("length", [0.4, 1.0, 7.3])
def test_a_straight_line_takes_the_nearest_whole_number_and_equal_integrals(length):
    line = lines_through([[0, 0, 0], [0.6 * length, 0, 0.8 * length]])
    mesh, _ = discretised(line, size_field=wave)
    total = integral(wave, *line.points)
    assert mesh.n_cells == round(total)
    parts = line_integrals(mesh, wave)
    assert np.abs(parts / (total / mesh.n_cells) - 1).max() < 2e-4


def test_the_error_of_the_integrals_falls_with_the_square_of_the_step():
    """Samples grow with the number of lines, so finer sizes sample the same wave more finely."""
    errors = []
    for shrink in (20, 80, 320):
        mesh, _ = discretised(lines_through([[0, 0], [1, 0]]), size_field=lambda p, s=shrink: wave(p) / s)
        assert mesh.n_cells == round(shrink * integral(wave, np.zeros(3), np.array([1.0, 0, 0])))
        x = mesh.points[:, 0][np.argsort(mesh.points[:, 0])]
        exact = np.array([integral(wave, np.zeros(3), np.array([at, 0.0, 0.0])) for at in x[1 :: len(x) // 15]])
        errors.append(
            np.abs(exact * mesh.n_cells / exact_total() - np.arange(1, len(x), len(x) // 15)).max() / mesh.n_cells
        )
    assert errors[0] < 1e-5 and errors[2] < errors[0]
    assert errors[2] < 1e-6


def exact_total():
    return integral(wave, np.zeros(3), np.array([1.0, 0, 0]))


@settings(max_examples=30)
@given(seed=st.integers(0, 10**6), size=st.floats(0.02, 1.0), shape=st.sampled_from(["polyline", "spline"]))
def test_corners_stay_to_the_bit_and_lines_have_the_size(seed, size, shape):
    rng = np.random.default_rng(seed)
    corners = np.array([[0, 0], [2, 0], [2.5, 1.5], [0.5, 1.2]]) + rng.uniform(-0.2, 0.2, (4, 2))
    steps = np.linspace(0, 1, 6)[:-1, None]
    points = np.concatenate([a + steps * (b - a) for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)])
    mesh, report = discretised(lines_through(points, closed=True), size=size, shape=shape)
    assert report.counts["corners"] == 4
    kept = {tuple(p) for p in mesh.points[:, :2]}
    assert all(tuple(c) in kept for c in points[::5])
    sides = np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1)
    assert mesh.n_cells == np.maximum(np.floor(sides / size + 0.5), 1).sum()
    ends = mesh.points[mesh.get("line")]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    assert length.sum() == pytest.approx(sides.sum())
    assert len(chains(mesh)) == 1 and (np.bincount(mesh.get("line").ravel()) == 2).all()


def test_smooth_loops_and_arcs_keep_their_nodes_on_the_curve():
    polygon = gallery.circle(60, radius=2.0)
    on_spline, _ = discretised(polygon, size=0.13, shape="spline")
    assert np.abs(np.linalg.norm(on_spline.points, axis=1) - 2).max() < 2e-5
    on_lines, _ = discretised(polygon, size=0.13)
    assert np.linalg.norm(on_lines.points, axis=1).min() > 2 * np.cos(np.pi / 60) - 1e-12
    assert on_lines.n_cells == round(60 * 4 * np.sin(np.pi / 60) / 0.13)
    circle, _ = discretised(arc([1, 1], 2.0), size=0.13)
    assert circle.n_cells == on_spline.n_cells == round(4 * np.pi / 0.13)
    assert np.abs(np.linalg.norm(circle.points[:, :2] - 1, axis=1) - 2).max() < 1e-14
    angle = np.sort(np.arctan2(*(circle.points[:, :2] - 1).T))
    assert np.abs(np.diff(angle) - 2 * np.pi / circle.n_cells).max() < 1e-6


def test_the_spline_converges_with_fourth_order():
    errors = []
    for n in (8, 16, 32, 64):
        angle = np.linspace(0, 2 * np.pi, n, endpoint=False)
        curve = spline(np.column_stack([2 * np.cos(angle), 2 * np.sin(angle)]), closed=True)
        points = curve.points(np.linspace(curve.start, curve.stop, 1001))
        errors.append(np.abs(np.linalg.norm(points, axis=1) - 2).max())
        assert curve.is_closed
    assert np.log2(np.array(errors[:-1]) / errors[1:]).min() > 3.7


def test_any_function_is_a_curve():
    helix = ParametricCurve(lambda t: np.column_stack([np.cos(t), np.sin(t), t]), 0, 4 * np.pi)
    mesh, report = discretised(helix, size=0.1)
    assert mesh.n_cells == round(4 * np.pi * np.sqrt(2) / 0.1)
    assert np.abs(np.diff(np.sort(mesh.points[:, 2])) - 4 * np.pi / mesh.n_cells).max() < 1e-6
    assert report.counts["corners"] == 2


@pytest.mark.parametrize("size", [0.5, 5.0, 1e9])
def test_closed_curves_get_three_lines_at_least(size):
    for curve in (gallery.circle(40), arc([0, 0], 1.0)):
        mesh, _ = discretised(curve, size=size)
        assert mesh.n_cells >= 3
    lens = Mesh([[0, 0], [1, 0], [0.5, 0.1], [0.5, -0.1]], {"line": [[0, 2], [2, 1], [1, 3], [3, 0]]})
    mesh, _ = discretised(lens, size=9.0, corner_angle=25)
    assert mesh.n_cells == 3
    assert len(np.unique(np.sort(mesh.get("line"), axis=1), axis=0)) == 3
    drop, _ = discretised(gallery.circle(40), size=9.0, corner_angle=5)
    assert drop.n_cells == 40


def test_tags_sets_and_vertex_cells_are_kept():
    square = gallery.square(4)
    tag = np.repeat([7, 8, 8, 9], 4)
    tag[1] = 5
    boundary = Mesh(
        square.points,
        {"line": square.get("line"), "vertex": [[10]]},
        {"h": square.points[:, 0]},
        {"tag": np.append(tag, 0), "load": np.linspace(0, 1, 17)},
        {"lid": np.arange(8, 12)},
    )
    mesh, report = discretised(boundary, size=0.1)
    assert report.counts["corners"] == 4 + 2 + 1
    ends = mesh.points[mesh.get("line")]
    middle = ends.mean(axis=1)
    assert set(mesh.cell_data["tag"][middle[:, 1] == 0]) == {7, 5}
    assert ((middle[mesh.cell_data["tag"] == 5, 0] - 0.375) ** 2 < 0.125**2).all()
    for value in (7, 5, 8, 9):
        length = np.linalg.norm(np.diff(ends, axis=1)[:, 0], axis=1)[mesh.cell_data["tag"] == value].sum()
        assert length == pytest.approx({7: 0.75, 5: 0.25, 8: 2, 9: 1}[value])
    assert np.allclose(middle[mesh.sets["lid"]][:, 1], 1) and len(mesh.sets["lid"]) == 10
    assert np.allclose(mesh.point_data["h"], mesh.points[:, 0])
    assert (mesh.points == boundary.points[10]).all(axis=1).any()


def test_nets_keep_their_branches():
    net = Mesh([[0, 0], [1, 0], [2, 0], [1, 1], [1, 1.5]], {"line": [[0, 1], [1, 2], [1, 3], [3, 4]]})
    mesh, report = discretised(net, size=0.25)
    assert mesh.n_cells == 4 + 4 + 6 and report.counts["corners"] == 4
    assert sorted(np.bincount(mesh.get("line").ravel()))[-1] == 3
    flower = Mesh(
        np.concatenate([gallery.circle(20, centre=(1, 0)).points - [2, 0, 0], [[-3, 0, 0]]]),
        {"line": np.concatenate([gallery.circle(20).get("line"), [[10, 20]]])},
    )
    mesh, report = discretised(flower, size=0.3, corner_angle=60)
    assert report.counts["corners"] == 2


def test_sizes_on_the_curve_on_a_background_and_their_gradation():
    line = lines_through([[0, 0], [1, 0], [2, 0]]).with_point_data(h=np.array([0.01, 0.2, 0.2]))
    own, _ = discretised(line, size_array="h")
    assert own.n_cells == round(np.log(20) / 0.19 + 5)
    assert discretised(line, size_array="h", gradation=0.05)[0].n_cells == round(np.log(1 + 2 * 0.05 / 0.01) / 0.05)
    big = Mesh([[-9, -9], [9, -9], [0, 9]], {"triangle": [[0, 1, 2]]}, {"h": np.array([0.1, 0.1, 0.1])})
    assert discretised(line, big)[0].n_cells == 20
    both, _ = discretised(line, big, size_field=lambda p: np.where(p[:, 0] < 1, 0.02, 1.0), size=0.5)
    assert abs(both.n_cells - (50 + 10)) <= 1


def test_gradation_reaches_around_corners_and_along_branches():
    corner = lines_through([[0, 0], [1, 0], [1, 1]])
    mesh, _ = discretised(corner, size_field=lambda p: np.where(p[:, 0] < 0.999, 0.01, 0.5), gradation=0.2)
    ends = mesh.points[mesh.get("line")]
    length = np.linalg.norm(np.diff(ends, axis=1)[:, 0], axis=1)
    y = ends.mean(axis=1)[:, 1]
    assert (length[y > 0] < 1.1 * (0.01 + 0.2 * y[y > 0])).all()


def test_a_metric_measures_each_line_as_one():
    def field(points):
        return metric(0.02 + 0.1 * points[:, 0], 5.0, [1, 0, 0])

    mesh, _ = discretised(gallery.square(), size_field=field)
    ends = mesh.points[mesh.get("line")]
    measured = lengths(ends[:, 0], ends[:, 1], field(ends[:, 0]), field(ends[:, 1]))
    across = np.abs(np.diff(ends, axis=1)[:, 0, 1]) > 0
    along = ~across
    assert np.ptp(measured[along]) < 0.02 and np.abs(measured[along] - 1).max() < 0.15
    assert across.sum() == 50 + round(1 / 0.12)
    with pytest.raises(InvalidInput, match="gradation: limits sizes"):
        discretised(gallery.square(), size_field=field, gradation=0.2)


@pytest.mark.parametrize("scale", [1e-310, 1e-200, 1e-30, 1e150, 1e299])
def test_the_unit_does_not_matter(scale):
    shape = gallery.l_shape(3)
    usual, report = discretised(shape, size=0.07)
    scaled, of_scaled = discretised(shape.with_points(scale * shape.points), size=0.07 * scale)
    assert (scaled.get("line") == usual.get("line")).all()
    assert np.allclose(scaled.points / scale, usual.points, atol=1e-9)
    for name, length in report.quality.items():
        assert of_scaled.quality[name] / scale == pytest.approx(length)


def test_repeated_points_and_lines_are_passed_over():
    points = [[0, 0], [1, 0], [1, 0], [1, 1]]
    mesh, _ = discretised(Mesh(points, {"line": [[0, 1], [1, 2], [2, 3], [0, 1]]}), size=0.25)
    assert mesh.n_cells == 8
    from_array, _ = discretised(np.array([[0.0, 0], [1, 0], [1, 1], [0, 0]]), size=0.5)
    assert from_array.n_cells == 2 + 2 + 3


def test_many_lines_of_one_length_take_few_samples():
    asked = []

    def field(points):
        asked.append(len(points))
        return np.full(len(points), 2e-6)

    mesh, _ = discretised(Mesh([[0, 0], [1, 0]], {"line": [[0, 1]]}), size_field=field)
    assert mesh.n_cells == 500_000
    assert max(asked) < 2 * mesh.n_cells


@pytest.mark.parametrize(
    "curve, keywords, message",
    [
        (Mesh([[0, 0], [1, 1]], {}), {}, "no lines of any length"),
        (Mesh([[0, 0], [0, 0]], {"line": [[0, 1]]}), {}, "no lines of any length"),
        (gallery.square(), {"size": 1e-12}, r"about 4e\+12 lines; .* smallest size is 1e-12, at \("),
        (gallery.square().with_points(gallery.square().points * 1e308), {}, r"up to 1e\+308; scale them to below"),
        (gallery.square(), {"size_array": "h"}, "no point array 'h'"),
        (gallery.square(), {"size_field": lambda p: p[:, 0]}, r"size_field: is 0 at \(0, 0, 0\)"),
        (gallery.square(), {"size_field": lambda p: 1j + p[:, 0]}, "size_field: failed on .*: it returned complex"),
        (gallery.square(), {"size_field": lambda p: np.full(len(p), 1e-320)}, "would make about inf lines"),
        (gallery.square(), {"size_field": lambda p: 1 / 0 if len(p) > 9 else p}, "division"),
        (gallery.square().with_point_data(h=np.array([1, 1, np.nan, 1])), {"size_array": "h"}, "is nan at point 2"),
        (gallery.square(), {"gradation": 0.0}, "gradation: must be finite and greater"),
        (arc([0, 0], 1.0), {"size_array": "h"}, "parametric curve has no arrays"),
        (ParametricCurve(lambda t: t, 0, 1), {}, r"must return shape"),
        (ParametricCurve(lambda t: np.column_stack([1 / t, t]), 0, 1), {}, r"at parameter 0"),
    ],
)
@pytest.mark.filterwarnings("ignore:divide by zero")
def test_bad_input_is_named(curve, keywords, message):
    with pytest.raises((InvalidInput, ZeroDivisionError), match=message):
        discretised(curve, **keywords)


NOT_METRICS = {
    "nan": (np.diag([4.0, np.nan, 4.0]), r"at \(0, 0, 0\) is not finite"),
    "infinite": (np.diag([4.0, 4.0, np.inf]), "is not finite"),
    "not symmetric": ([[4, 1, 0], [0, 4, 0], [0, 0, 4]], "is not symmetric"),
    "negative": (np.diag([4.0, -1.0, 4.0]), "is not positive definite"),
    "indefinite by its corners": ([[1, 2, 0], [2, 1, 0], [0, 0, 1]], "is not positive definite"),
    "flat in a slanted direction": (np.ones((3, 3)), "is not positive definite"),
    "zero": (np.zeros((3, 3)), "is not positive definite"),
    "too small": (1e300 * np.eye(3), "asks for spacings beyond"),
    "two by two": (np.eye(2), r"must return shape \(\d+, 3, 3\), one metric a point, got \(\d+, 2, 2\)"),
}


@pytest.mark.parametrize("case", NOT_METRICS)
def test_what_is_no_metric_is_refused(case):
    matrix, message = NOT_METRICS[case]
    with pytest.raises(InvalidInput, match="size_field: .*" + message):
        discretised(gallery.square(), size_field=lambda p: np.tile(np.asarray(matrix, float), (len(p), 1, 1)))


def test_fields_of_the_wrong_number_of_metrics_are_refused():
    with pytest.raises(InvalidInput, match=r"got \(1, 3, 3\)"):
        discretised(gallery.square(), size_field=lambda p: np.eye(3)[None])
    with pytest.raises(InvalidInput, match="failed on"):
        discretised(gallery.square(), size_field=lambda p: [np.eye(3), 1])


def test_the_fault_of_a_metric_is_named_where_it_is():
    def field(p):
        return np.where(p[:, :1, None] > 0.7, -1.0, 4.0) * np.eye(3)

    with pytest.raises(InvalidInput, match=r"at \((0\.7\d*|1), 0, 0\) is not positive"):
        discretised(Mesh([[0, 0], [1, 0]], {"line": [[0, 1]]}), size_field=field)


def test_strong_stretching_is_a_metric():
    turned = metric(0.01, [1e6], [[[1, 1, 0]]])
    line = Mesh([[0, 0], [1, -1]], {"line": [[0, 1]]})
    mesh, _ = discretised(line, size_field=lambda p: np.tile(turned, (len(p), 1, 1)))
    assert mesh.n_cells == round(np.sqrt(2) / 0.01)


def test_bad_curves_are_named():
    with pytest.raises(InvalidInput, match="radius: must be finite and greater"):
        arc([0, 0], -1.0)
    with pytest.raises(InvalidInput, match="start < stop"):
        arc([0, 0], 1.0, 90, 0)
    with pytest.raises(InvalidGeometry, match="at least 3 different points, got 2"):
        spline([[0, 0], [1, 0], [0, 0]], closed=True)
    assert np.allclose(spline([[0, 0], [1, 0]]).points(np.array([0.25])), [[0.25, 0, 0]])
