"""Summaries and reports."""

from __future__ import annotations

import numpy as np
import pytest

from meshcore import InvalidInput, Mesh, MultiBlock, StructuredGrid, gallery, quality


def test_summary_of_triangles():
    found = quality.summary(gallery.triangulated_square(3))
    assert found == {
        "smallest angle (degree)": pytest.approx(45),
        "largest angle (degree)": pytest.approx(90),
        "mean radius ratio": pytest.approx((1 + np.sqrt(2)) / 2),
        "worst scaled jacobian": pytest.approx(np.sqrt(2 / 3)),
    }


def test_summary_looks_at_the_highest_dimension_only():
    square = gallery.triangulated_square(2)
    with_lines = Mesh(square.points, {"line": square.boundary.get("line"), **square.cells})
    assert quality.summary(with_lines) == quality.summary(square)
    assert quality.summary(gallery.circle()) == {}


def test_sides_that_are_cells_too_do_not_count_beside_what_they_bound():
    points = np.array([[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0], [0, 0, 1], [2, 0, 1], [2, 1, 1], [0, 1, 1.0]])
    solid = Mesh(points, {"hexahedron": [range(8)]})
    sided = Mesh(points, {"quad": [[0, 3, 2, 1]], "hexahedron": [range(8)]}, sets={"wall": [0]})
    found = quality.report(sided, ["scaled_jacobian", "volume", "area"]).rows
    assert {name: row.count for name, row in found.items()} == {"scaled_jacobian": 1, "volume": 1, "area": 1}
    assert found["scaled_jacobian"].worst.tolist() == [1]  # by its number in the mesh
    assert found["area"].mean == 2
    assert found["volume"].mean == quality.report(solid, ["volume"]).rows["volume"].mean


def test_summary_of_solids_and_grids():
    x = np.stack(np.meshgrid(*[np.arange(3.0)] * 3, indexing="ij"), axis=-1)
    assert quality.summary(StructuredGrid(x)) == {"mean shape": 1.0, "worst scaled jacobian": 1.0}
    tetra = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], {"tetra": [[0, 1, 2, 3]]})
    assert quality.summary(tetra)["smallest dihedral angle (degree)"] == pytest.approx(
        np.degrees(np.arctan(np.sqrt(2)))
    )


def one_bad():
    """Equal squares, but number 3 is crushed and number 5 is inverted."""
    grid = StructuredGrid(np.stack(np.meshgrid(np.arange(4.0), np.arange(4.0), indexing="ij"), axis=-1)).to_mesh()
    cells = grid.get("quad").copy()
    points = np.concatenate([grid.points, [[0.0, 1.05, 0.0], [1.0, 1.05, 0.0]]])
    cells[3, 2:] = [17, 16]
    cells[5] = cells[5, ::-1]
    return Mesh(points, {"quad": cells})


def test_worst_cells_come_first():
    report = quality.report(one_bad(), ["max_edge_ratio", "area"])
    assert report.rows["max_edge_ratio"].worst[0] == 3
    assert report.rows["max_edge_ratio"].maximum == pytest.approx(20)
    assert report.rows["max_edge_ratio"].outside == 1


def test_inverted_cells_are_worst_even_where_small_is_good():
    tetra = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    mesh = Mesh(tetra, {"tetra": [[0, 1, 2, 3], [0, 2, 1, 3]]})
    row = quality.report(mesh, ["condition"]).rows["condition"]
    assert row.minimum < 0
    assert row.worst[0] == 1
    assert row.outside == 1


def test_histogram_holds_every_finite_cell():
    mesh = gallery.triangulated_square(5)
    mesh = mesh.with_points(
        mesh.points + 0.05 * np.random.default_rng(3).standard_normal(mesh.points.shape) * [1, 1, 0]
    )
    for row in quality.report(mesh).rows.values():
        counts, edges = row.histogram
        assert counts.sum() == row.count == mesh.n_cells
        assert len(edges) == len(counts) + 1
        assert edges[0] <= row.minimum <= row.percentiles[0] <= row.percentiles[1] <= row.percentiles[2] <= row.maximum
        assert edges[-1] >= row.maximum


def test_text_names_what_counts():
    text = str(quality.report(one_bad(), ["scaled_jacobian", "min_angle"]))
    assert "Mesh(18 points, 9 quad)" in text
    assert "min_angle (degree)" in text
    assert "worst cells" in text
    assert "█" in text
    assert all(len(line) < 120 for line in text.splitlines())


def test_degenerate_and_infinite_values_do_not_break_the_report():
    mesh = Mesh([[0, 0], [1, 0], [2, 0], [0, 1]], {"triangle": [[0, 1, 2], [0, 1, 3]]})
    report = quality.report(mesh, "aspect_ratio")
    assert np.isinf(report.rows["aspect_ratio"].maximum)
    assert np.isfinite(report.rows["aspect_ratio"].mean)
    assert report.rows["aspect_ratio"].worst[0] == 0
    assert "inf" in str(report)


def test_a_report_of_nothing_and_of_unknown_names():
    assert quality.report(gallery.circle()).rows == {}
    assert str(quality.report(Mesh(np.empty((0, 3)), {})))
    with pytest.raises(InvalidInput, match="no measure"):
        quality.report(gallery.triangulated_square(2), ["beauty"])


@pytest.mark.parametrize(
    "ask", [quality.report, quality.summary, quality.validate, lambda mesh: quality.measure(mesh, "area")]
)
def test_what_is_no_mesh_is_refused_by_name(ask):
    with pytest.raises(InvalidInput, match="mesh: needs a Mesh or StructuredGrid, got NoneType"):
        ask(None)
    grid = StructuredGrid(np.zeros((2, 2, 1, 3)))
    with pytest.raises(InvalidInput, match="got MultiBlock; give one of its blocks"):
        ask(MultiBlock([grid]))
