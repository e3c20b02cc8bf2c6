"""A user's whole path: a project in, a script, a filter, a script, a mesh or project out, read again."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pymeshlab
import pytest

import meshlab_filters
from meshcore import gallery, io
from meshlab_filters.__main__ import main
from tests.meshlab.conftest import add

GREEN = "compute_selection_by_condition_per_face"


def script(path, *calls):
    """A MeshLab script as MeshLab itself saves it."""
    recorder = pymeshlab.MeshSet(verbose=False)
    recorder.add_mesh(pymeshlab.Mesh(np.eye(3), np.array([[0, 1, 2]], np.int32)))
    for name, parameters in calls:
        recorder.apply_filter(name, **parameters)
    recorder.save_filter_script(str(path))
    return path


@pytest.fixture
def project(tmp_path):
    """Two plates, the second one current."""
    ms = pymeshlab.MeshSet(verbose=False)
    add(ms, gallery.triangulated_square(2), "small plate")
    add(ms, gallery.triangulated_square(5), "large plate")
    meshlab_filters.save(ms, tmp_path / "plates.mlp")
    return tmp_path / "plates.mlp"


def run(*arguments):
    return main([str(a) for a in arguments])


def test_projects_keep_all_layers(project):
    ms = pymeshlab.MeshSet(verbose=False)
    meshlab_filters.load(ms, project)
    assert [m.face_number() for m in ms] == [8, 50]
    assert [m.label() for m in ms] == ["small plate", "large plate"]


def test_project_script_filter_script_project(project, tmp_path, capsys):
    pre = script(tmp_path / "pre.mlx", ("compute_matrix_from_translation", {"axisx": 4.0, "freeze": True}))
    post = script(tmp_path / "post.mlx", (GREEN, {"condselect": "fi < 7"}), ("meshing_remove_selected_faces", {}))
    out = tmp_path / "out.mlp"
    assert run(project, out, "--filter", "refined", "-p", "levels=1", "--layer", "0", "--pre", pre, "--post", post) == 0
    assert "triangles: 32" in capsys.readouterr().out
    ms = pymeshlab.MeshSet(verbose=False)
    meshlab_filters.load(ms, out)
    assert [m.face_number() for m in ms] == [8, 50, 32 - 7]
    assert ms.mesh_number() == 3
    new = list(ms)[2]
    assert new.vertex_matrix()[:, 0].min() == pytest.approx(4)
    assert new.has_face_scalar()


def test_face_scalars_survive_in_ply(project, tmp_path):
    out = tmp_path / "fine.ply"
    assert run(project, out, "--filter", "delaunay_refinement", "-p", "size=10%", "-p", "min_angle=25") == 0
    ms = pymeshlab.MeshSet(verbose=False)
    ms.load_new_mesh(str(out))
    assert ms.current_mesh().has_face_scalar()
    assert 0.2 < ms.current_mesh().face_scalar_array().min() <= ms.current_mesh().face_scalar_array().max() <= 1.16


def test_other_formats_are_written_by_meshcore(tmp_path):
    io.write(tmp_path / "square.vtu", gallery.square(4))
    assert run(tmp_path / "square.vtu", tmp_path / "out.vts", "--filter", "transfinite", "-p", "corners=0,4,8,12") == 0
    assert io.read(tmp_path / "out.vts").cell_shape == (4, 4, 1)


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (["IN", "out.ply", "--filter", "refine"], 1, "no filter 'refine'; try refined"),
        (["nothing.ply", "out.ply", "--filter", "refined"], 1, "no such file"),
        (["IN", "nowhere/out.ply", "--filter", "refined"], 1, "no such folder"),
        (["IN", "out.vtu", "--filter", "compute_quality_per_face"], 1, "makes no mesh"),
        (["IN", "out.ply", "--filter", "refined", "-p", "levels"], 1, "needs KEY=VALUE"),
        (["IN", "out.ply", "--filter", "refined", "-p", "levels=many"], 1, "levels: cannot read 'many' as int"),
        (["IN", "out.ply", "--filter", "refined", "-p", "levels=0"], 1, "levels: must be at least 1"),
        (["IN", "out.ply", "--filter", "refined", "--pre", "none.mlx"], 1, "no such script"),
        (["IN", "out.ply", "--filter", "refined", "--pre", "broken.mlx"], 1, "is no MeshLab script"),
        (["IN", "out.ply", "--filter", "refined", "--pre", "empty.mlx"], 1, "has no filters"),
        (["IN", "out.ply", "--filter", "refined", "--pre", "unknown.mlx"], 1, "MeshLab's own filters only"),
        (["IN", "out.ply", "--filter", "refined", "--layer", "7"], 1, "no layer with the id or label 7"),
        (["lost.mlp", "out.ply", "--filter", "refined"], 1, "names 'gone.ply', which is not there"),
        (["broken.mlp", "out.ply", "--filter", "refined"], 1, "is no MeshLab project"),
        (["IN", "out.ply"], 2, "filter is missing"),
    ],
)
def test_failures_are_one_line_and_an_exit_code(project, tmp_path, monkeypatch, capsys, arguments, code, message):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "broken.mlx").write_text("not xml")
    (tmp_path / "broken.mlp").write_text("not xml")
    (tmp_path / "empty.mlx").write_text("<!DOCTYPE FilterScript>\n<FilterScript>\n</FilterScript>\n")
    (tmp_path / "unknown.mlx").write_text('<FilterScript>\n <filter name="Make It Nice"/>\n</FilterScript>\n')
    (tmp_path / "lost.mlp").write_text(
        '<MeshLabProject><MeshGroup><MLMesh filename="gone.ply" label="x"/></MeshGroup></MeshLabProject>'
    )
    assert run(*[project if a == "IN" else a for a in arguments]) == code
    written = capsys.readouterr().err
    assert message in written
    assert written.startswith("meshlab_filters: ")
    assert written.count("\n") == 1
    assert not (tmp_path / "out.ply").exists()


def test_as_a_module(project, tmp_path):
    command = [sys.executable, "-m", "meshlab_filters"]
    done = subprocess.run([*command, "--list"], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0
    assert "delaunay_refinement" in done.stdout
    done = subprocess.run([*command, "--parameters", "refined"], capture_output=True, text=True, timeout=120)
    assert "fraction : float = 0.5" in done.stdout
    out = tmp_path / "fine.ply"
    done = subprocess.run(
        [*command, str(project), str(out), "--filter", "refined"], capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stderr
    assert out.exists()
