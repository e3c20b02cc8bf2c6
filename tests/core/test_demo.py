"""The shipped airfoils and the demo's own pieces; the whole demo runs as an example."""

import numpy as np
import pytest

import meshcore as mc
from meshcore import demo, gallery, io
from meshcore.errors import Cancelled, InvalidInput, MeshcoreError


@pytest.mark.parametrize("name", gallery.airfoils())
def test_shipped_airfoils_are_loops_of_chord_one(name):
    loop = gallery.airfoil(name)
    assert loop.n_points == loop.n_cells and loop.is_planar
    assert np.ptp(loop.points[:, 0]) == pytest.approx(1, abs=0.01)
    assert gallery.airfoil(name, cells=75).n_cells == 75


def test_an_airfoil_in_its_far_field():
    domain = gallery.airfoil_in_far_field("s1223", radius=4, outer=20)
    outer = np.unique(domain.get("line")[domain.cell_data["tag"] == 1])
    assert len(outer) == 20
    assert np.abs(np.hypot(domain.points[outer, 0] - 0.5, domain.points[outer, 1]) - 4).max() < 1e-12
    mesh, _ = mc.delaunay_refinement(domain, min_angle=25)
    assert np.hypot(*(mesh.centroids[:, :2] - [0.5, 0]).T).max() < 4


def test_unknown_airfoils_are_refused(tmp_path):
    with pytest.raises(InvalidInput, match="naca0012, rae2822, s1223"):
        gallery.airfoil("clarky")
    with pytest.raises(MeshcoreError):
        demo.run(tmp_path / "out", airfoil=tmp_path / "missing.dat")


def test_the_demo_takes_a_file_and_stops_when_told(tmp_path):
    io.write(tmp_path / "section.vtu", gallery.airfoil("naca0012"))
    seen = []

    def stop(fraction, message):
        seen.append(fraction)
        return len(seen) < 6

    with pytest.raises(Cancelled):
        demo.run(tmp_path / "out", stop, airfoil=tmp_path / "section.vtu")
    assert max(seen) < 1 / 3


def test_progress_never_runs_back_in_the_block():
    seen = []
    demo.block(gallery.airfoil(), progress=lambda fraction, message: seen.append(fraction))
    assert seen == sorted(seen) and len(seen) >= 3


def test_the_table_has_a_column_a_mesh():
    table = demo.comparison({"a": gallery.triangulated_square(2), "b": gallery.triangulated_square(3)}).splitlines()
    assert table[0].split() == ["a", "b"]
    assert table[2].split() == ["cells", "8", "18"]
