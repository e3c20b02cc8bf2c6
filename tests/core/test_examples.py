"""Every example runs, keeps the fact that it asserts, writes its pictures, and comes to the number known for it."""

import runpy
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
NUMBERS = {
    "advancing_front_points": None,
    "airfoil_sections": 3,
    "airfoil_three_ways": None,  # a triangulation's count is its maker's affair, not this test's
    "background_grid_and_sources": None,
    "background_of_an_earlier_computation": None,
    "blade_row": 24 * 60 * 24,
    "chapter_4_h_refinement": None,
    "circumcentre_refinement": None,
    "corners_of_the_boundary": 64 * 32,
    "curved_grid_smoothed": 64 * 32,
    "dented_box": 24**3,
    "figure_01_structured_and_unstructured": 24 * 12,
    "figure_02_two_block_grid": 2 * 40 * 24,
    "figure_04_mapping_of_boundaries": 25 * 13,
    "figure_05_transfinite_interpolation": 72 * 32,
    "figure_06_overspill": None,
    "figure_07_elliptic_boundaries": 160 * 80,
    "figure_08_control_functions": 60 * 30,
    "figure_03_grids_near_bodies": None,
    "figure_09_degenerate_points": 12 * 16 + 16 * 16,
    "figure_10_multiply_connected_block": None,
    "figure_11_o_grid": None,
    "marching_grids": None,
    "figure_12_c_grid": None,
    "figure_13_h_grid": None,
    "figure_14_halo_points": None,
    "figure_23_empty_circumcircles": None,
    "figure_24_sliver": 1,
    "figure_25_degenerate_points": 800,
    "figure_26_octahedron": 4,
    "figure_27_bowyer_watson": None,
    "figure_28_boundary_not_respected": None,
    "figure_29_constrained_delaunay": None,
    "flow_past_a_cylinder": 64 * 192,
    "grid_quality": None,
    "laplace_round_a_cylinder": 4 * 4 * 40 * 40,
    "layers_at_edges": 12 * 16 * (20 + 24),
    "layers_on_surfaces": 97992,
    "moving_grid": 48 * 48,
    "passage_between_six_faces": 24 * 20 * 20,
    "patch_on_a_scan": 48 * 40,
    "surface_between_four_curves": 32 * 24,
    "turbine_passage": 24 * 48 * 20,
}


def test_every_example_is_known():
    assert sorted(path.stem for path in EXAMPLES.glob("*.py")) == sorted(NUMBERS)


@pytest.mark.parametrize("name", NUMBERS)
def test_example(name, tmp_path):
    number = runpy.run_path(str(EXAMPLES / f"{name}.py"))["main"](tmp_path)
    pictures = list(tmp_path.glob("*.png"))
    assert pictures and all(path.stat().st_size > 3000 for path in pictures)
    assert number > 0 and number == (NUMBERS[name] or number)
