"""Polygons and polyhedra on the command line: made, drawn, measured, converted, and given to what takes meshes."""

import pytest

import meshcore as mc
from meshcore import cli, gallery


@pytest.fixture
def call(capsys):
    """Run a command line in this process: exit code, stdout, stderr."""

    def run(*words):
        code = cli.main([str(word) for word in words])
        return code, *capsys.readouterr()

    return run


@pytest.fixture
def files(tmp_path):
    """Sites and a boundary."""
    mc.io.write(tmp_path / "sites.vtu", gallery.sunflower(30))
    mc.io.write(tmp_path / "circle.vtp", gallery.circle(24, radius=1.1))
    return tmp_path


def test_cells_within_a_boundary_are_written_drawn_and_measured(files, call):
    made, drawn = files / "cells.vtu", files / "cells.png"
    words = ("voronoi-2d", files / "sites.vtu", files / "circle.vtp", "-o", made, "--picture", drawn, "--histogram")
    code, out, _ = call(*words)
    assert code == 0 and "30" in out and "triangle" in out
    mesh = mc.io.read(made)
    assert isinstance(mesh, mc.PolyhedralMesh)
    direct = mc.voronoi_2d(gallery.sunflower(30), gallery.circle(24, radius=1.1)).mesh
    assert (mesh.points == direct.points).all() and (mesh.face_nodes == direct.face_nodes).all()
    assert drawn.stat().st_size > 3000
    code, out, _ = call("quality", made)
    assert code == 0 and "triangle" in out


def test_polyhedra_are_converted(files, call):
    mc.io.write(files / "ball.vtu", gallery.cloud_in_a_ball(20))
    box = ("--box", "-2", "-2", "-2", "2", "2", "2")
    assert call("voronoi-3d", files / "ball.vtu", "-o", files / "cells.vtu", *box)[0] == 0
    assert mc.io.read(files / "cells.vtu").volumes.sum() == pytest.approx(64)
    assert call("convert", files / "cells.vtu", files / "cells.vtk")[0] == 0
    assert mc.io.read(files / "cells.vtk").n_cells == 20
    code, _, err = call("convert", files / "cells.vtu", files / "faces.obj")
    assert code == 0 and "20 polyhedra" in err
    code, _, err = call("convert", files / "cells.vtu", files / "cells.stl")
    assert code == 1 and "PolyhedralMesh" in err


def test_a_format_that_holds_no_polygons_is_refused_before_the_work(files, call):
    code, _, err = call("voronoi-2d", files / "sites.vtu", "-o", files / "cells.stl")
    assert code == 1 and "PolyhedralMesh" in err


def test_polygons_are_given_as_triangles_to_what_takes_a_mesh(files, call):
    assert call("voronoi-2d", files / "sites.vtu", "-o", files / "cells.vtu")[0] == 0
    assert call("refined", files / "cells.vtu", "-o", files / "fine.vtu")[0] == 0
    assert mc.io.read(files / "fine.vtu").n_cells > mc.io.read(files / "cells.vtu").to_mesh().n_cells
