"""Measures of single cells against VTK's copy of Verdict, and against what their definitions promise."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
import pyvista
from hypothesis import given, settings
from hypothesis import strategies as st
from vtkmodules.vtkFiltersVerdict import vtkMeshQuality

from meshcore import InvalidInput, Mesh, StructuredGrid, quality
from meshcore.mesh import CELL_TYPES
from meshcore.quality import tetra
from meshcore.quality.measures import OF_FACETS

_H = np.sqrt(3) / 2
IDEAL = {
    "triangle": [[0, 0, 0], [1, 0, 0], [0.5, _H, 0]],
    "quad": [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]],
    "tetra": [[0, 0, 0], [1, 0, 0], [0.5, _H, 0], [0.5, _H / 3, np.sqrt(2 / 3)]],
    "hexahedron": [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]],
    "wedge": [[0, 0, 0], [1, 0, 0], [0.5, _H, 0], [0, 0, 1], [1, 0, 1], [0.5, _H, 1]],
    "pyramid": [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, np.sqrt(0.5)]],
}
KINDS = tuple(IDEAL)
BETWEEN_CELLS = set(OF_FACETS)
EVERY = [(kind, name) for kind in KINDS for name in quality.measures(kind) if name not in BETWEEN_CELLS]
EQUIANGLE_SKEW = {kind: f"{kind.capitalize()}EquiangleSkew" for kind in KINDS} | {
    "tetra": "TetEquiangleSkew",
    "hexahedron": "HexEquiangleSkew",
}
UNDEFINED = -12345.0
VERDICT_MAX = 1e29  # Verdict answers 1e30, or a third or half of it, for infinity


def soup(kind, corners):
    """Cells with their own corners, (m, k, 3)."""
    corners = np.asarray(corners, float)
    return Mesh(corners.reshape(-1, 3), {kind: np.arange(corners[..., 0].size).reshape(corners.shape[:2])})


def shaken(kind, noise, count=200, seed=20):
    """Ideal cells with random displacements; large ones give slivers, folds and inverted cells."""
    ideal = np.array(IDEAL[kind])
    return ideal + noise * np.random.default_rng(seed).standard_normal((count, *ideal.shape))


def by_vtk(mesh, name):
    ((kind, cells),) = mesh.cells.items()
    table = np.column_stack([np.full(len(cells), cells.shape[1]), cells]).ravel()
    grid = pyvista.UnstructuredGrid(table, np.full(len(cells), CELL_TYPES[kind].vtk), mesh.points)
    if name == "equiangle_skew":  # pyvista has no name for it
        of_cell = getattr(vtkMeshQuality, EQUIANGLE_SKEW[kind])
        return np.array([of_cell(grid.GetCell(k)) for k in range(grid.n_cells)])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return np.asarray(grid.cell_quality(name, null_value=UNDEFINED).cell_data[name])


def as_vtk_would(kind, name, x, value):
    """Our values turned into those of VTK where Verdict's code departs from its manual, or rounds its constants."""
    if (kind, name) == ("tetra", "min_angle"):
        angles = tetra.dihedral_angles(x)  # edges 0-1, 0-2, 0-3, 1-2, 1-3, 2-3
        angles[:, [1, 4]] = 180 - angles[:, [1, 4]]
        return angles.min(axis=1)
    if (kind, name) == ("tetra", "collapse_ratio"):
        edges = np.linalg.norm(tetra.edges(x), axis=2)
        height = [tetra.jacobian(x) / (2 * area(x[:, face])) for face in ([0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3])]
        longest = [edges[:, used].max(axis=1) for used in ([0, 1, 4], [0, 2, 3], [1, 2, 5], [3, 4, 5])]
        return np.min([h / e for h, e in zip(height, longest, strict=True)], axis=0)
    if kind == "wedge" and name in ("condition", "max_aspect_frobenius"):
        exact = 4 / (3 * 1.5 ** (1 / 3))
        return np.maximum(value * exact / 1.16477, 1.0)
    if (kind, name) == ("wedge", "distortion"):
        return value * 2 * 0.433013 / 0.866025
    return value


def area(x):
    return np.linalg.norm(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), axis=1) / 2


def comparable(kind, name, x):
    """Cells for which Verdict's code does what it says."""
    if (kind, name) == ("pyramid", "shape"):  # it overlooks the longer one of the edges 0-1 and 1-2
        edges = np.linalg.norm(x[:, [1, 2, 3, 0, 4, 4, 4, 4]] - x[:, [0, 1, 2, 3, 0, 1, 2, 3]], axis=2)
        return edges.argmax(axis=1) > 1
    return np.ones(len(x), bool)


def agree(ours, vtk, tolerance=1e-9):
    infinite = np.isinf(ours)
    assert (np.abs(vtk[infinite]) >= VERDICT_MAX).all()
    assert (np.abs(vtk[~infinite]) < VERDICT_MAX).all()
    np.testing.assert_allclose(ours[~infinite], vtk[~infinite], rtol=tolerance, atol=tolerance)


@pytest.mark.parametrize("kind", KINDS)
def test_all_of_vtk_is_there_and_nothing_else(kind):
    mesh = soup(kind, [IDEAL[kind]])
    for name in quality.measures():
        if name not in BETWEEN_CELLS:
            offered = name in quality.measures(kind)
            assert offered == (by_vtk(mesh, name)[0] != UNDEFINED), name
            assert offered != np.isnan(quality.measure(mesh, name)[0]), name


@pytest.mark.parametrize("noise", [0.0, 0.1, 0.4, 3.0])
@pytest.mark.parametrize(("kind", "name"), EVERY)
def test_same_as_vtk(kind, name, noise):
    x = shaken(kind, noise)
    mesh = soup(kind, x)
    ours = as_vtk_would(kind, name, x, quality.measure(mesh, name))
    use = comparable(kind, name, x)
    assert use.sum() > 20 or noise == 0.0
    agree(ours[use], by_vtk(mesh, name)[use])


@pytest.mark.parametrize(("kind", "name"), EVERY)
def test_inverted_cells_as_vtk(kind, name):
    x = shaken(kind, 0.1)[..., ::-1].copy()  # a mirror image
    mesh = soup(kind, x)
    ours = as_vtk_would(kind, name, x, quality.measure(mesh, name))
    if kind == "tetra" and "size" in name:  # Verdict takes the cube root of the negative mean as a power: nan
        assert (ours == 0).all()
        return
    use = comparable(kind, name, x)
    agree(ours[use], by_vtk(mesh, name)[use])


def degenerate(kind):
    """Flattened, with two corners at one place, and shrunk to a point; coordinates are small whole numbers."""
    ideal = np.array(np.round(np.array(IDEAL[kind]) * 4), float)
    flat, thin, merged = ideal.copy(), ideal.copy(), ideal.copy()
    flat[:, 2] = 0
    thin[:, 1:] = 0
    merged[1] = merged[0]
    return {"flat": flat, "thin": thin, "merged": merged, "point": np.zeros_like(ideal)}


# Where there is no sensible answer, Verdict and meshcore give different ones; the modules say which and why.
ON_PURPOSE = {
    ("quad", "thin", "distortion"),
    *((kind, "point", "scaled_jacobian") for kind in ("tetra", "hexahedron", "wedge")),
    *((kind, how, "scaled_jacobian") for kind in ("hexahedron", "wedge") for how in ("flat", "thin", "merged")),
    *(("quad", how, name) for how in ("merged", "thin") for name in ("min_angle", "max_angle", "equiangle_skew")),
}


@pytest.mark.parametrize("how", ["flat", "thin", "merged", "point"])
@pytest.mark.parametrize(("kind", "name"), EVERY)
def test_degenerate_cells_have_an_answer(kind, name, how):
    """No nan, no warning; infinite or worst, never a good mark for what cannot be measured."""
    value = quality.measure(soup(kind, [degenerate(kind)[how]]), name)
    assert not np.isnan(value).any()


@pytest.mark.parametrize("kind", ["triangle", "quad"])
@pytest.mark.parametrize("how", ["thin", "merged"])
def test_degenerate_planar_cells_as_vtk(kind, how):
    mesh = soup(kind, [degenerate(kind)[how]])
    for name in quality.measures(kind):
        if name not in BETWEEN_CELLS and (kind, how, name) not in ON_PURPOSE:
            agree(quality.measure(mesh, name), by_vtk(mesh, name))


@pytest.mark.parametrize("kind", ["tetra", "hexahedron", "wedge", "pyramid"])
def test_flat_solids_have_no_volume_and_no_shape(kind):
    mesh = soup(kind, [degenerate(kind)["flat"]])
    assert quality.measure(mesh, "volume")[0] == 0
    assert quality.measure(mesh, "shape")[0] == 0
    assert quality.measure(mesh, "scaled_jacobian")[0] <= 0


def test_collapsed_quad_is_a_triangle():
    corners = np.array([[0, 0, 0], [2, 0, 0], [1, 3, 0], [1, 3, 0]], float)
    four, three = soup("quad", [corners]), soup("triangle", [corners[:3]])
    for name in ("min_angle", "max_angle", "condition", "scaled_jacobian", "distortion"):
        assert quality.measure(four, name)[0] == quality.measure(three, name)[0]
        if name != "distortion":
            agree(quality.measure(four, name), by_vtk(four, name))


UNITS = {"area": 2, "jacobian": None, "volume": 3, "dimension": 1}


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 10_000), st.sampled_from([1e-6, 0.3, 1e7]))
def test_measures_do_not_see_place_turn_or_scale(seed, scale):
    random = np.random.default_rng(seed)
    turn, _ = np.linalg.qr(random.standard_normal((3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    shift = random.standard_normal(3)
    for kind in KINDS:
        x = shaken(kind, 0.1, count=5, seed=seed)
        here, there = soup(kind, x), soup(kind, scale * (x @ turn.T + shift))
        for name in quality.measures(kind):
            if name in BETWEEN_CELLS:
                continue
            power = UNITS.get(name, 0)
            if power is None:
                power = 2 if kind == "quad" else 3
            expected = quality.measure(here, name) * scale**power
            np.testing.assert_allclose(
                quality.measure(there, name), expected, rtol=1e-7, atol=1e-7 * scale**power, err_msg=f"{kind} {name}"
            )


@pytest.mark.parametrize(("kind", "name"), EVERY)
def test_ideal_cell_has_the_best_value(kind, name):
    from meshcore.quality.measures import lookup

    ideal = quality.measure(soup(kind, [IDEAL[kind]]), name)[0]
    low, high = lookup(kind, name).acceptable
    assert low - 1e-12 <= ideal <= high + 1e-12
    # Of a warped quad all angles may be below 90 degrees, and random cells may be larger than the ideal one.
    if name not in UNITS and (kind, name) != ("quad", "max_angle"):
        worse = quality.measure(soup(kind, [1.0 * np.array(IDEAL[kind]), *shaken(kind, 0.2)]), name)
        smaller = name in quality.measure_table.SMALLER_IS_BETTER
        assert (worse >= ideal - 1e-9).all() if smaller else (worse <= ideal + 1e-9).all()


def test_min_angle_of_a_needle_keeps_its_digits():
    """Verdict's arc cosine gives 0 here."""
    mesh = soup("triangle", [[[0, 0, 0], [1, 0, 0], [1, 1e-9, 0]]])
    assert quality.measure(mesh, "min_angle")[0] == pytest.approx(np.degrees(1e-9), rel=1e-12)


def test_mixed_kinds_in_the_order_of_the_cells():
    points = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0]]
    mesh = Mesh(points, {"line": [[0, 1]], "quad": [[0, 1, 2, 3]], "triangle": [[1, 4, 2]]})
    area_ = quality.measure(mesh, "area")
    assert np.isnan(area_[0])
    assert area_[1:].tolist() == [1.0, 0.5]
    assert np.isnan(quality.measure(mesh, "aspect_gamma")).all()


def test_curved_cells_are_measured_by_their_corners_and_with_their_straight_fellows():
    points = [[0, 0], [1, 0], [0, 1], [0.5, -0.1], [0.5, 0.5], [0, 0.5], [3, 0], [0, 3]]
    mesh = Mesh(points, {"triangle6": [[0, 1, 2, 3, 4, 5]], "triangle": [[0, 6, 7]]})
    straight = Mesh(points, {"triangle": [[0, 1, 2], [0, 6, 7]]})
    for name in ("area", "relative_size_squared", "min_angle"):
        np.testing.assert_array_equal(quality.measure(mesh, name), quality.measure(straight, name))


def test_structured_grid_has_the_shape_of_its_cells():
    x, y, z = np.meshgrid(np.arange(4.0), np.arange(3.0) ** 2, np.arange(3.0), indexing="ij")
    grid = StructuredGrid(np.stack([x, y, z], axis=-1))
    volume = quality.measure(grid, "volume")
    assert volume.shape == grid.cell_shape
    assert volume[0, :, 0].tolist() == [1.0, 3.0]
    surface = StructuredGrid(np.stack([x, y, z], axis=-1)[:, :, :1])
    assert quality.measure(surface, "area").shape == surface.cell_shape == (3, 2, 1)


def test_unknown_names_say_what_is_near():
    mesh = soup("triangle", [IDEAL["triangle"]])
    with pytest.raises(InvalidInput, match="'min_angel' is no measure; try min_angle"):
        quality.measure(mesh, "min_angel")
    with pytest.raises(InvalidInput, match="no kind of cell"):
        quality.measures("heptagon")


def test_empty_meshes_have_empty_measures():
    mesh = Mesh(np.empty((0, 3)), {"triangle": np.empty((0, 3), int)})
    assert quality.measure(mesh, "min_angle").shape == (0,)
    assert quality.measure(mesh, "relative_size_squared").shape == (0,)
    assert quality.summary(mesh) == {}
