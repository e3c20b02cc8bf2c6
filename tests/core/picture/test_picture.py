"""Pictures: the mesh is where it should be, coloured as asked, and bad requests are refused."""

import subprocess
import sys

import numpy as np
import pytest
from PIL import Image

import meshcore as mc
from meshcore import gallery, quality
from meshcore.errors import InvalidInput, MissingLibrary
from meshcore.picture import histogram, picture

SMALL = (240, 160)


def pixels(path):
    return np.asarray(Image.open(path).convert("RGB")).astype(int)


def painted(image):
    """Which pixels are not white."""
    return (image < 250).any(axis=-1)


def test_a_planar_mesh_is_seen_from_above_and_fills_the_height(tmp_path):
    image = pixels(picture(gallery.l_shape(), tmp_path / "l.png", window=SMALL))
    assert image.shape == (160, 240, 3)
    triangles = gallery.triangulated_square(2)
    image = painted(pixels(picture(triangles, tmp_path / "deep" / "t.png", window=SMALL)))
    rows, columns = np.flatnonzero(image.any(axis=1)), np.flatnonzero(image.any(axis=0))
    assert abs(np.ptp(rows) - np.ptp(columns)) <= 3 and np.ptp(rows) > 140  # a square stays a square
    assert image[rows[1] : rows[-1], columns[1] : columns[-1]].all()


def test_zoom_shows_the_box_only(tmp_path):
    two = mc.Mesh([[0, 0], [1, 0], [1, 1], [0, 1]], {"triangle": [[0, 1, 2], [0, 2, 3]]})
    values = np.array([0.0, 1.0])
    box = ((0.6, 0.1), (0.9, 0.35))  # inside the first triangle
    image = pixels(picture(two, tmp_path / "zoom.png", window=(100, 100), zoom=box, scalars=values, edges=False))
    left = image[:, :50].reshape(-1, 3)
    assert np.ptp(left, axis=0).max() <= 2  # one colour all over
    assert left[0][2] > left[0][0]  # viridis begins blue


def test_edges_get_thinner_with_density_and_never_black_out(tmp_path):
    for n in (4, 40, 220):
        image = pixels(picture(gallery.triangulated_square(n), tmp_path / f"{n}.png", window=SMALL))
        inside = image[40:120, 90:150]
        assert 60 < inside.mean() < 250
        plain = pixels(picture(gallery.triangulated_square(n), tmp_path / "plain.png", window=SMALL, edges=False))
        assert np.ptp(plain[40:120, 90:150]) <= 40 and inside.std() > 1


def test_colours_by_data_and_by_measure(tmp_path):
    mesh = gallery.triangulated_square(6)
    grid, _ = mc.transfinite(*gallery.wavy_sides(8, 6))
    by_data = pixels(picture(mesh, tmp_path / "a.png", window=SMALL, scalars="front"))
    by_values = pixels(picture(mesh, tmp_path / "b.png", window=SMALL, scalars=mesh.point_data["front"]))
    assert (by_data[:, :150] == by_values[:, :150]).all()
    by_measure = pixels(picture(grid, tmp_path / "c.png", window=SMALL, scalars="scaled_jacobian"))
    plain = pixels(picture(grid, tmp_path / "d.png", window=SMALL))
    assert (by_measure != plain).any()


def test_marked_cells_are_red(tmp_path):
    mesh = gallery.triangulated_square(4)
    image = pixels(picture(mesh, tmp_path / "m.png", window=SMALL, marked=[5]))
    red = (image[..., 0] > 180) & (image[..., 2] < 110)
    share = red.sum() / painted(image).sum()
    assert share == pytest.approx(1 / 32, rel=0.4)
    with pytest.raises(InvalidInput, match="marked"):
        picture(mesh, tmp_path / "m.png", window=SMALL, marked=[99])


def test_curves_surfaces_volumes_and_blocks(tmp_path):
    cube = np.stack(np.meshgrid(*[np.linspace(0, 1, 4)] * 3, indexing="ij"), axis=-1)
    bent = cube[:, :, 0] + np.array([0, 0, 1]) * np.sin(3 * cube[:, :, 0, :1])
    flat = mc.StructuredGrid(cube[:, :, 0])
    beside = flat.with_points(flat.points + [1, 0, 0])
    shown = {
        "curve": gallery.airfoil("naca0012"),
        "volume": mc.StructuredGrid(cube),
        "surface": mc.StructuredGrid(bent),
        "blocks": mc.MultiBlock((flat, beside)),
        "mixed": mc.Mesh([[0, 0], [1, 0], [1, 1], [0, 1], [2, 0]], {"quad": [[0, 1, 2, 3]], "triangle": [[1, 4, 2]]}),
    }
    for name, mesh in shown.items():
        assert painted(pixels(picture(mesh, tmp_path / f"{name}.png", window=SMALL, title=name))).mean() > 0.005


def test_histogram_of_a_report(tmp_path):
    report = quality.report(gallery.triangulated_square(5), ["min_angle", "area"])
    assert painted(pixels(histogram(report, tmp_path / "h.png", window=(400, 200)))).mean() > 0.01
    with pytest.raises(InvalidInput, match="no measure"):
        histogram(quality.report(gallery.square()), tmp_path / "h.png")


@pytest.mark.parametrize(
    ("mesh", "keywords", "parameter"),
    [
        (mc.Mesh([[0, 0]], {}), {}, "mesh"),
        ("square", {}, "mesh"),
        (gallery.square(), {"scalars": "nothing"}, "scalars"),
        (gallery.square(), {"scalars": np.zeros(7)}, "scalars"),
        (gallery.square(), {"window": (0, 10)}, "window"),
        (gallery.square(), {"window": 7}, "window"),
        (gallery.square(), {"zoom": ((1, 1), (0, 0))}, "zoom"),
        (gallery.square(), {"zoom": ((0, 0), (float("nan"), 1))}, "zoom"),
    ],
)
def test_bad_requests_are_refused(tmp_path, mesh, keywords, parameter):
    with pytest.raises(InvalidInput) as caught:
        picture(mesh, tmp_path / "x.png", **keywords)
    assert caught.value.parameter == parameter
    assert not (tmp_path / "x.png").exists()


def test_without_pyvista(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyvista", None)
    with pytest.raises(MissingLibrary, match="pip install pyvista"):
        picture(gallery.square(), tmp_path / "x.png")


def test_without_a_display_and_without_a_word(tmp_path):
    code = (
        "import os; os.environ.pop('DISPLAY', None)\n"
        "from meshcore import gallery\nfrom meshcore.picture import picture\n"
        f"picture(gallery.square(), {str(tmp_path / 'p.png')!r}, window=(64, 64))\n"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    assert (run.returncode, run.stdout, run.stderr) == (0, "", "")
    assert painted(pixels(tmp_path / "p.png")).any()


def test_polygons_are_coloured_whole(tmp_path):
    mesh = mc.PolyhedralMesh.from_polygons(
        [[0, 0], [1, 0], [1, 1], [0.5, 1], [0, 1], [2, 0], [2, 1]], [[0, 1, 2, 3, 4], [1, 5, 6, 2]]
    )
    image = pixels(picture(mesh, tmp_path / "two.png", scalars=np.array([0.0, 1.0]), window=(300, 100), edges=False))
    solid = painted(image)[:, :250]
    rows, columns = np.flatnonzero(solid.any(axis=1)), np.flatnonzero(solid.any(axis=0))
    middle = (columns[0] + columns[-1]) // 2
    left = image[rows[3] : rows[-3], columns[3] : middle - 3].reshape(-1, 3)
    right = image[rows[3] : rows[-3], middle + 4 : columns[-3]].reshape(-1, 3)
    assert np.ptp(left, axis=0).max() <= 2 and np.ptp(right, axis=0).max() <= 2
    assert np.abs(left[0] - right[0]).max() > 100


def test_of_polyhedra_the_near_half_is_taken_away(tmp_path):
    mesh, _ = mc.voronoi_3d(gallery.cloud_in_a_ball(30))
    for scalars in (None, "volume", "site"):
        assert painted(pixels(picture(mesh, tmp_path / "cells.png", scalars=scalars, window=SMALL))).mean() > 0.2
    with pytest.raises(InvalidInput, match="volume"):
        picture(mesh, tmp_path / "cells.png", scalars="area")


def test_curves_and_points_are_drawn_over_a_mesh(tmp_path):
    square = gallery.triangulated_square(1)
    plain = pixels(picture(square, tmp_path / "plain.png", window=(100, 100)))
    line = mc.Mesh([[0.1, 0.5], [0.9, 0.5]], {"line": [[0, 1]]})
    point = mc.Mesh([[0.25, 0.75]], {"vertex": [[0]]})
    image = pixels(picture(square, tmp_path / "over.png", window=(100, 100), over=[line, point]))
    changed = (np.abs(image - plain) > 40).any(axis=-1)
    assert changed[48:52, 30:70].any(axis=0).all()  # the line, across the middle
    assert changed[20:35, 20:35].any() and not changed[60:90, 60:90].any()
    with pytest.raises(InvalidInput, match="over"):
        picture(square, tmp_path / "over.png", over=[square])
