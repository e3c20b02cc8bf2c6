"""The `meshcore` command: operations by files, help, exit codes, bad values, and what it leaves behind."""

from __future__ import annotations

import argparse
import io as text_io
import json
import os
import subprocess
import sys
import types
import warnings
from dataclasses import replace
from typing import Annotated, Literal

import numpy as np
import pytest

import meshcore as mc
from meshcore import cli, gallery, operation
from meshcore.cli import commands, flags, terminal
from meshcore.geometry.curves import lines_through, polyline
from meshcore.operation import Length, Param, Port, Relative

OPERATIONS = list(mc.operations())
PNG = b"\x89PNG\r\n\x1a\n"


@pytest.fixture
def call(capsys):
    """Run a command line in this process: exit code, stdout, stderr."""

    def run(*words) -> tuple[int, str, str]:
        try:
            code = cli.main([str(word) for word in words])
        except SystemExit as leave:
            code = leave.code
        out, err = capsys.readouterr()
        return code, out, err

    return run


@pytest.fixture
def loop(tmp_path):
    """A file with a closed square loop."""
    path = tmp_path / "loop.vtp"
    mc.io.write(path, gallery.square(8))
    return path


def model_files(name, folder) -> list:
    """The gallery's inputs of an operation, as files."""
    inputs, _ = gallery.arguments(name)
    paths = []
    for number, mesh in enumerate(inputs):
        paths.append(folder / f"input{number}.vtu")
        mc.io.write(paths[-1], mesh)
    return paths


def words_of(keywords) -> list[str]:
    """Keywords as flags."""
    words = []
    for name, value in keywords.items():
        words += ["--" + name.replace("_", "-"), *map(str, value if isinstance(value, tuple) else (value,))]
    return words


def leftovers(folder) -> list[str]:
    """Temporary folders that should be gone."""
    return [path.name for path in folder.rglob("*") if "meshcore-" in path.name]


# ---- operations


@pytest.mark.parametrize("name", OPERATIONS)
def test_an_operation_gives_by_files_what_it_gives_by_a_call(name, tmp_path, call):
    operation = mc.operations()[name]
    inputs, keywords = gallery.arguments(name)
    output = tmp_path / ("out.vts" if operation.output == "grid" else "out.vtu")
    paths = model_files(name, tmp_path)
    code, out, err = call(name.replace("_", "-"), *paths, "-o", output, "--json", *words_of(keywords))
    assert (code, err) == (0, "")
    expected, report = operation.function(*inputs, **keywords)
    expected = expected.to_mesh() if isinstance(expected, mc.MultiBlock) else expected
    written = mc.io.read(output)
    np.testing.assert_allclose(written.points, expected.points, rtol=0, atol=1e-14)
    assert written.n_cells == expected.n_cells
    told = json.loads(out)
    assert (told["operation"], told["counts"], told["output"]) == (operation.label, report.counts, str(output))
    assert not leftovers(tmp_path)


@pytest.mark.parametrize("suffix", ["vts", "vtm", "xyz"])
def test_layers_of_grids_and_blocks_are_grids_and_blocks(suffix, tmp_path, call):
    blocks = gallery.six_patches(5)
    given = blocks.blocks[0] if suffix == "vts" else blocks
    mc.io.write(tmp_path / f"in.{suffix}", given)
    paths = [tmp_path / f"{name}.{suffix}" for name in ("in", "out")]
    code, _, err = call("hyperbolic-volume", paths[0], "-o", paths[1], "--layers", "3", "--histogram")
    assert code == 0 and "error" not in err  # PLOT3D warns that it does not hold names of faces
    written = mc.io.read(paths[1])
    assert type(written) is type(given) and written.n_points == 4 * given.n_points
    code, _, err = call("hyperbolic-volume", paths[0], "-o", tmp_path / "out.stl", "--layers", "3")
    assert code and "error" in err and not (tmp_path / "out.stl").exists()


def test_inputs_that_are_named_have_a_flag(tmp_path, call):
    """So that lines can be given with a loop alone, in place of four sides."""
    x = np.linspace(0, 1, 9)
    line = lines_through(np.column_stack([0.5 + 0.05 * np.sin(np.pi * x), x]))
    mc.io.write(tmp_path / "loop.vtp", gallery.square(8))
    mc.io.write(tmp_path / "line.vtp", line)
    words = (tmp_path / "loop.vtp", "--lines", tmp_path / "line.vtp", "-o", tmp_path / "out.vts", "--quiet")
    assert call("transfinite", *words)[0] == 0
    written = mc.io.read(tmp_path / "out.vts")
    expected = mc.transfinite(gallery.square(8), lines=line).mesh
    np.testing.assert_allclose(written.points, expected.points, rtol=0, atol=1e-14)
    assert np.abs(expected.points - mc.transfinite(gallery.square(8)).mesh.points).max() > 0.04


@pytest.mark.parametrize("name", OPERATIONS)
def test_help_tells_each_parameter_with_limits_and_default(name, call):
    code, out, err = call(name.replace("_", "-"), "--help")
    text = " ".join(out.split())
    assert (code, err) == (0, "")
    assert mc.operations()[name].summary in text and f"meshcore {name.replace('_', '-')}" in text
    for port in mc.operations()[name].inputs.values():
        assert port.description in text
    for param in mc.operations()[name].params.values():
        assert f"--{param.name.replace('_', '-')}" in text
        assert flags.help_text(param) in text


def test_report_histogram_and_picture(loop, tmp_path, call):
    picture = tmp_path / "p.png"
    code, out, err = call("transfinite", loop, "-o", tmp_path / "g.vts", "--picture", picture, "--histogram")
    assert (code, err) == (0, "")
    assert out.startswith("Transfinite Interpolation\n") and "quads" in out and "min_angle" in out
    assert picture.read_bytes().startswith(PNG) and picture.stat().st_size > 5000


def test_flags_have_other_spellings_and_a_picture_without_a_name_stands_beside_the_output(tmp_path, call):
    section = tmp_path / "rae2822.dat"
    points = polyline(gallery.airfoil("rae2822"))
    section.write_text("RAE 2822\n" + "\n".join(f"{x:.7f} {y:.7f}" for x, y, _ in points))
    line = f"c-grid {section} -o {tmp_path}/rae2822.vts --first-height 1e-5 --yplus 1 --reynolds 6.5e6 --picture"
    code, out, err = call(*line.split())
    assert (code, err) == (0, "") and "4.138e-06" in out
    assert (tmp_path / "rae2822.png").read_bytes().startswith(PNG)
    assert call(*line.replace("yplus", "y-plus").replace(" --picture", " --json").split())[0] == 0


def test_quiet_prints_nothing(loop, tmp_path, call):
    assert call("transfinite", loop, "-o", tmp_path / "g.vts", "--quiet") == (0, "", "")
    assert mc.io.read(tmp_path / "g.vts").shape == (9, 9, 1)


def test_cells_and_lengths_arrive(loop, tmp_path, call):
    call("transfinite", loop, "-o", tmp_path / "g.vts", "--cells-i", "40", "--cells-j", "20", "--tolerance", "1%")
    assert mc.io.read(tmp_path / "g.vts").shape == (41, 21, 1)


def test_sizes_of_a_second_file_or_of_the_first_reach_the_operation(loop, tmp_path, call):
    corners = [[-1, -1], [4, -1], [-1, 4]]
    background = mc.Mesh(corners, {"triangle": [[0, 1, 2]]}, {"h": np.array([0.04, 0.29, 0.04])})
    mc.io.write(tmp_path / "sizes.vtu", background)
    out = tmp_path / "out.vtu"
    code, _, err = call("delaunay-refinement", loop, tmp_path / "sizes.vtu", "--size-array", "h", "-o", out, "--quiet")
    assert (code, err) == (0, "")
    assert mc.io.read(out).n_cells == mc.delaunay_refinement(gallery.square(8), background, size_array="h")[0].n_cells
    painted = gallery.square(8).with_point_data(h=0.02 + 0.1 * gallery.square(8).points[:, 0])
    mc.io.write(tmp_path / "painted.vtp", painted)
    words = ("--size-array", "h", "--gradation", "0.3", "-o", out, "--quiet")
    assert call("delaunay-refinement", tmp_path / "painted.vtp", *words)[0] == 0
    direct = mc.delaunay_refinement(painted, size_array="h", gradation=0.3)[0]
    assert mc.io.read(out).n_cells == direct.n_cells
    code, _, err = call("discretised", loop, tmp_path / "sizes.vtu", "--size-array", "heat", "-o", out)
    assert code == 1 and "no point array 'heat'; there are: h" in err


def test_an_input_between_others_may_be_left_out(tmp_path, call):
    mc.io.write(tmp_path / "boundary.vtp", gallery.square_with_hole())
    mc.io.write(tmp_path / "seeds.vtp", mc.Mesh([[0.5, 0.5]], {"vertex": [[0]]}, {"tag": [7]}))
    words = ["delaunay-refinement", tmp_path / "boundary.vtp", "-", tmp_path / "seeds.vtp", "-o", tmp_path / "out.vtu"]
    assert call(*words)[0] == 0
    assert 7 in mc.io.read(tmp_path / "out.vtu").cell_data["region"]
    assert "; - in its place where others follow" in " ".join(call("delaunay-refinement", "--help")[1].split())


def test_holes_of_a_poly_file_reach_the_operation(tmp_path, call):
    """A point between the outline and an inner square empties what the even-odd rule alone would fill."""
    outline = gallery.joined(gallery.square(), gallery.square(size=0.25))
    inner = outline.with_points(outline.points + [0.25, 0.25, 0] * (np.arange(8) >= 4)[:, None])
    mc.io.write(tmp_path / "h.poly", replace(inner, field_data={"holes": np.array([[0.1, 0.1]])}))
    code, _, err = call("delaunay-refinement", tmp_path / "h.poly", "-o", tmp_path / "out.vtu")
    assert (code, err) == (0, "")
    area = mc.quality.measure(mc.io.read(tmp_path / "out.vtu"), "area").sum()
    assert area == pytest.approx(0.25**2)


@pytest.mark.parametrize(
    ("words", "fault"),
    [
        (["--min-angle", "200"], "min_angle: must be at most 34, got 200"),
        (["--min-angle", "nan"], "min_angle: must be finite, got nan"),
        (["--size", "0"], "size: must be greater than zero, got 0"),
        (["--max-area=-1"], "max_area: must be"),
    ],
)
def test_absurd_parameters_of_a_real_operation(words, fault, loop, tmp_path, call):
    code, out, err = call("delaunay-refinement", loop, "-o", tmp_path / "out.vtu", *words)
    assert (code, out) == (1, "") and err.startswith(f"meshcore: error: {fault}") and err.count("\n") == 1
    assert not (tmp_path / "out.vtu").exists()


def test_structured_file_for_an_input_that_is_a_mesh(tmp_path, call):
    grid = mc.StructuredGrid(np.stack(np.meshgrid([0.0, 1], [0.0, 1], indexing="ij"), axis=-1))
    mc.io.write(tmp_path / "grid.vts", grid)
    code, _, err = call("transfinite", tmp_path / "grid.vts", "-o", tmp_path / "g.vts")
    assert code == 1 and "south" in err  # refused by the operation, for it has no lines; not by the reader


# ---- every kind of parameter


@pytest.fixture
def every_kind():
    """An operation with a parameter of each kind, registered for one test."""

    @operation.operation("Every Kind", category="Structured")
    def every_kind(
        mesh: Annotated[mc.Mesh, Port("Any 100% good mesh")],
        *,
        flag: Annotated[bool, Param("A switch")] = True,
        count: Annotated[int, Param("A count", min=1)] = 3,
        angle: Annotated[float, Param("An angle", min=0, max=34, unit="degree")] = 30.0,
        size: Annotated[Length, Param("A size, 100% sure")] = Relative(0.05),
        maybe: Annotated[Length | None, Param("A size or none")] = 0.5,
        choice: Annotated[Literal["one", "two words"], Param("A choice")] = "one",
        name: Annotated[str, Param("A name")] = "",
        pair: Annotated[tuple[float, float], Param("Two numbers")] = (1.0, 2.0),
        perhaps: Annotated[tuple[int, int, int] | None, Param("Three numbers or none")] = None,
        progress: mc.Progress = mc.silent,
    ) -> mc.Result:
        """Do nothing, 100% of it."""
        return mc.Result(mesh, mc.Report())

    yield mc.operations()["every_kind"]
    operation._REGISTRY.pop("every_kind")


def parsed(operation, *words):
    """Values that a command line gives to an operation."""
    parser = argparse.ArgumentParser()
    flags.add_params(parser, operation)
    return flags.values(parser.parse_args(words), operation)


def test_defaults_are_those_of_the_signature(every_kind):
    assert parsed(every_kind) == {name: param.default for name, param in every_kind.params.items()}


@pytest.mark.parametrize(
    ("words", "name", "value"),
    [
        (["--no-flag"], "flag", False),
        (["--flag"], "flag", True),
        (["--count", "7"], "count", 7),
        (["--angle", "2e1"], "angle", 20.0),
        (["--size", "0.1"], "size", 0.1),
        (["--size", "2%"], "size", Relative(0.02)),
        (["--maybe", "none"], "maybe", None),
        (["--maybe", "3%"], "maybe", Relative(0.03)),
        (["--choice", "two words"], "choice", "two words"),
        (["--name", "pressure"], "name", "pressure"),
        (["--pair", "-1", "2.5"], "pair", (-1.0, 2.5)),
        (["--perhaps", "none"], "perhaps", None),
        (["--perhaps", "1", "2", "3"], "perhaps", (1, 2, 3)),
    ],
)
def test_words_become_values(every_kind, words, name, value):
    got = parsed(every_kind, *words)[name]
    assert got == value and type(got) is type(value)


@pytest.mark.parametrize(
    "words",
    [
        ["--count", "2.5"],
        ["--angle", "wide"],
        ["--size", "2percent"],
        ["--size", "x%"],
        ["--angle", "none"],
        ["--choice", "three"],
        ["--pair", "1"],
        ["--pair", "1", "2", "3"],
        ["--perhaps"],
        ["--unknown", "1"],
        ["--coun", "3"],
    ],
)
def test_words_that_mean_nothing_are_wrong_usage(every_kind, words, loop, tmp_path, call):
    code, out, err = call("every-kind", loop, "-o", tmp_path / "out.vtu", *words)
    assert (code, out) == (2, "") and "error: " in err.splitlines()[-1]
    assert not (tmp_path / "out.vtu").exists()


@pytest.mark.parametrize(
    ("words", "fault"),
    [
        (["--angle", "200"], "angle: must be at most 34, got 200"),
        (["--angle", "nan"], "angle: must be finite, got nan"),
        (["--angle", "inf"], "angle: must be finite, got inf"),
        (["--count", "0"], "count: must be at least 1, got 0"),
        (["--size", "0"], "size: must be greater than zero, got 0"),
        (["--size=-3%"], "size: must be greater than zero, got -3%"),
        (["--perhaps", "1", "2"], "perhaps: needs 3 values, got (1, 2)"),
    ],
)
def test_values_beyond_the_limits_are_refused_before_any_file_is_read(every_kind, words, fault, tmp_path, call):
    code, out, err = call("every-kind", tmp_path / "missing.vtp", "-o", tmp_path / "out.vtu", *words)
    assert (code, out) == (1, "")
    assert err.startswith(f"meshcore: error: {fault}") and err.count("\n") == 1


def test_percent_signs_in_texts_do_no_harm(every_kind, call):
    code, out, _ = call("every-kind", "--help")
    text = " ".join(out.split())
    assert code == 0 and "100% sure (default 5%)" in text and "100% good" in text and "100% of it" in text


# ---- files that are refused


@pytest.mark.parametrize(
    ("words", "fault"),
    [
        (["transfinite", "{folder}/lop.vtp", "-o", "{folder}/g.vts"], "did you mean loop.vtp?"),
        (["transfinite", "{folder}", "-o", "{folder}/g.vts"], "is a folder"),
        (["transfinite", "{loop}", "-o", "{folder}/g.vtx"], "the extension '.vtx' is unknown"),
        (["transfinite", "{loop}", "-o", "{folder}/g"], "has no extension"),
        (["transfinite", "{loop}", "-o", "{folder}/g.stl"], "STL does not hold"),
        (["transfinite", "{loop}", "-o", "{loop}"], "is named twice"),
        (["transfinite", "{loop}", "-o", "{folder}/../{name}/loop.vtp"], "is named twice"),
        (["transfinite", "{loop}", "-o", "{folder}/no/g.vts"], "does not exist"),
        (["transfinite", "{loop}", "-o", "{folder}"], "is a folder"),
        (["transfinite", "{loop}", "-o", "{loop}/g.vts"], "does not exist"),
        (["transfinite", "{loop}", "-o", "{folder}/g.vts", "--picture", "{folder}/p.jpg"], "pictures are PNG"),
        (["transfinite", "{loop}", "-o", "{folder}/g.vts", "--picture", "{folder}/no/p.png"], "does not exist"),
        (["quality", "{folder}/none.vtu"], "does not exist"),
        (["quality", "{loop}", "--measure", "beauty"], "'beauty' is no measure"),
        (["convert", "{loop}", "{loop}"], "is named twice"),
        (["convert", "{loop}", "{folder}/c.zip"], "the extension '.zip' is unknown"),
    ],
)
def test_files_are_refused_in_one_line(words, fault, loop, tmp_path, call):
    names = {"folder": tmp_path, "loop": loop, "name": tmp_path.name}
    before = loop.read_bytes()
    code, out, err = call(*[word.format(**names) for word in words])
    assert (code, out) == (1, "")
    assert err.startswith("meshcore: error: ") and fault in err and err.count("\n") == 1
    assert loop.read_bytes() == before
    assert [path.name for path in tmp_path.iterdir()] == ["loop.vtp"]


def test_a_file_that_is_not_what_it_says(tmp_path, call):
    (tmp_path / "lie.vtp").write_text("this is no mesh")
    code, _, err = call("transfinite", tmp_path / "lie.vtp", "-o", tmp_path / "g.vts")
    assert code == 1 and err.startswith("meshcore: error: lie.vtp") and err.count("\n") == 1


def test_a_refused_output_is_told_before_the_work(every_kind, loop, tmp_path, call, monkeypatch):
    done = []
    monkeypatch.setattr(commands.files, "read", lambda *a: done.append(a))
    assert call("every-kind", loop, "-o", tmp_path / "out.nothing")[0] == 1
    assert call("every-kind", loop, "-o", tmp_path / "out.vts")[0] == 1  # for structured grids only
    assert not done


def test_a_fault_in_the_geometry_tells_where(tmp_path, call):
    mc.io.write(tmp_path / "open.vtp", mc.Mesh([[0.25, 0], [1, 0], [1, 1]], {"line": [[0, 1], [1, 2]]}))
    (tmp_path / "g.vts").write_text("what was here before")
    code, out, err = call("transfinite", tmp_path / "open.vtp", "-o", tmp_path / "g.vts")
    assert (code, out) == (1, "")
    assert err.splitlines()[0].startswith("meshcore: error: south: is open")
    assert err.splitlines()[1:] == ["  at point 0: (0.25, 0, 0)", "  at point 2: (1, 1, 0)"]
    assert (tmp_path / "g.vts").read_text() == "what was here before" and not leftovers(tmp_path)


def test_long_lists_of_places_are_cut():
    error = mc.InvalidGeometry("is bad", parameter="mesh", cells=range(5))
    lines = terminal.places(error, {"mesh": gallery.square(8)})
    assert lines[0].startswith("at cell 0: (") and lines[-1] == "and at 2 more cells" and len(lines) == 4
    assert terminal.places(mc.InvalidGeometry("is bad", points=(99,)), {"mesh": gallery.square()}) == []
    assert terminal.places(mc.MeshcoreError("no place"), {}) == []


# ---- exit codes


@pytest.mark.parametrize("words", [[], ["nonsense"], ["transfinite"], ["transfinite", "a.vtp"], ["quality"]])
def test_wrong_usage_is_exit_code_2(words, call):
    code, out, err = call(*words)
    assert (code, out) == (2, "") and err.startswith("meshcore") and len(err.splitlines()) == 1
    assert "error: " in err and "--help tells all" in err


def test_the_flag_that_may_have_been_meant_is_named(call):
    code, _, err = call("c-grid", "section.dat", "-o", "out.vtm", "--firstheight", "1e-5")
    assert code == 2 and "unrecognized arguments: --firstheight; did you mean --first-height?" in err


def test_version(call):
    assert call("--version") == (0, f"meshcore {mc.__version__}\n", "")


def test_debug_shows_the_traceback(tmp_path):
    with pytest.raises(mc.InvalidInput, match="does not exist"):
        cli.main(["transfinite", str(tmp_path / "no.vtp"), "-o", str(tmp_path / "g.vts"), "--debug"])


@pytest.mark.parametrize("stop", [KeyboardInterrupt(), mc.Cancelled()])
def test_ctrl_c_is_130_and_leaves_the_old_file(stop, every_kind, loop, tmp_path, call, monkeypatch):
    def interrupted(*args, **keywords):
        raise stop

    object.__setattr__(every_kind, "function", interrupted)
    (tmp_path / "out.vtu").write_text("what was here before")
    code, out, err = call("every-kind", loop, "-o", tmp_path / "out.vtu")
    assert (code, out, err) == (130, "", "meshcore: cancelled\n")
    assert (tmp_path / "out.vtu").read_text() == "what was here before" and not leftovers(tmp_path)


def test_too_little_memory_is_an_error_of_one_line(every_kind, loop, tmp_path, call):
    def greedy(*args, **keywords):
        raise MemoryError

    object.__setattr__(every_kind, "function", greedy)
    code, _, err = call("every-kind", loop, "-o", tmp_path / "out.vtu")
    assert code == 1 and "not enough memory" in err and err.count("\n") == 1


# ---- the other commands


def test_list_tells_every_operation_and_format(call):
    code, out, err = call("list")
    assert (code, err) == (0, "")
    for name, entry in mc.operations().items():
        assert name.replace("_", "-") in out and entry.summary in out
    for row in mc.io.formats():
        assert row.extensions in out and row.description in out


def test_list_as_json_is_the_registry(call):
    told = json.loads(call("list", "--json")[1])
    assert list(told["operations"]) == OPERATIONS
    assert told["operations"]["transfinite"]["params"]["cells_i"]["min"] == 1
    assert {row["name"] for row in told["formats"]} == {row.name for row in mc.io.formats()}


def test_quality_table_histogram_and_json(tmp_path, call):
    mesh = gallery.triangulated_square(4)
    mc.io.write(tmp_path / "m.vtu", mesh)
    code, out, err = call("quality", tmp_path / "m.vtu", "--measure", "min_angle", "--measure", "area")
    assert (code, err) == (0, "") and "min_angle" in out and "area" in out and "█" not in out
    assert "█" in call("quality", tmp_path / "m.vtu", "--histogram")[1]
    told = json.loads(call("quality", tmp_path / "m.vtu", "--measure", "area", "--json")[1])
    assert told["area"]["count"] == 32 and told["area"]["minimum"] == pytest.approx(1 / 32)


def test_quality_picture_is_coloured(tmp_path, call):
    mc.io.write(tmp_path / "m.vtu", gallery.triangulated_square(4))
    words = ["quality", tmp_path / "m.vtu", "--measure", "min_angle", "--picture", tmp_path / "q.png", "--quiet"]
    assert call(*words) == (0, "", "")
    assert (tmp_path / "q.png").read_bytes().startswith(PNG)


def test_quality_of_a_grid_has_lines_for_directions_and_walls(tmp_path, call):
    grid, _ = mc.o_grid(gallery.circle(24), radius=3, layers=8)
    mc.io.write(tmp_path / "g.vts", grid)
    code, out, _ = call("quality", tmp_path / "g.vts")
    for name in ("line_angle", "growth_i", "growth_j", "first_height_jmin", "face_angle_jmax", "equiangle_skew"):
        assert code == 0 and name in out
    words = ["quality", tmp_path / "g.vts", "--measure", "growth_j", "--picture", tmp_path / "q.png", "--quiet"]
    assert call(*words) == (0, "", "")
    assert (tmp_path / "q.png").read_bytes().startswith(PNG)
    code, _, err = call("quality", tmp_path / "g.vts", "--measure", "growth_l")
    assert code == 1 and "'growth_l' is no measure; try" in err and "growth_i" in err


def test_quality_pictures_are_one_for_each_measure(tmp_path, call):
    mc.io.write(tmp_path / "g.vts", mc.transfinite(*gallery.wavy_sides(6, 4)).mesh)
    words = ["quality", tmp_path / "g.vts", "--pictures", tmp_path / "all", "--quiet"]
    measures = ["line_angle", "first_height_jmin", "growth_i", "jacobian"]
    assert call(*words, *(word for name in measures for word in ("--measure", name)))[0] == 0
    assert {file.name for file in (tmp_path / "all").iterdir()} == {f"{name}.png" for name in measures}
    code, _, err = call("quality", tmp_path / "g.vts", "--pictures", tmp_path / "g.vts")
    assert code == 1 and "cannot be a folder" in err


def test_quality_of_blocks_is_told_block_by_block(tmp_path, call):
    grid, _ = mc.transfinite(gallery.square(4))
    blocks = mc.MultiBlock((grid, grid.with_points(grid.points + [1, 0, 0])), ("left", "right"))
    mc.io.write(tmp_path / "b.vtm", blocks)
    code, out, _ = call("quality", tmp_path / "b.vtm")
    assert code == 0 and "left: StructuredGrid" in out and "right: StructuredGrid" in out
    code, _, err = call("transfinite", tmp_path / "b.vtm", "-o", tmp_path / "g.vts")
    assert code == 1 and "holds 2 blocks" in err


def test_convert_keeps_the_mesh_and_warns_of_what_is_lost(tmp_path, call):
    mesh = gallery.triangulated_square(3)
    mc.io.write(tmp_path / "m.vtu", mesh)
    code, out, err = call("convert", tmp_path / "m.vtu", tmp_path / "m.off")
    assert code == 0 and "18 triangle" in out
    assert err.startswith("meshcore: warning: m.off: ") and "'front'" in err and err.count("\n") == 1
    back = mc.io.read(tmp_path / "m.off")
    np.testing.assert_allclose(back.points, mesh.points)
    np.testing.assert_array_equal(back.get("triangle"), mesh.get("triangle"))


def test_warmup_runs_every_operation_and_cleans_stale_caches(tmp_path, call, monkeypatch):
    stale, other = tmp_path / "kernels-old", tmp_path / "kernels-recent"
    (tmp_path / "kernels-now").mkdir()
    stale.mkdir()
    other.mkdir()
    os.utime(stale, (0, 0))
    monkeypatch.setattr("meshcore._numba.cache_folder", lambda: tmp_path / "kernels-now")
    code, out, err = call("warmup")
    assert (code, err) == (0, "")
    assert all(entry.label in out for entry in mc.operations().values())
    assert f"kept in {tmp_path / 'kernels-now'}" in out and "removed 1 folder of older versions" in out
    assert not stale.exists() and other.exists()


def test_demo_runs_in_the_folder_that_is_named(tmp_path, call, monkeypatch):
    stand_in = types.SimpleNamespace(run=lambda folder, progress: f"wrote to {folder}")
    monkeypatch.setitem(sys.modules, "meshcore.demo", stand_in)
    assert call("demo", tmp_path) == (0, f"wrote to {tmp_path}\n", "")


# ---- the terminal


class Terminal(text_io.StringIO):
    def isatty(self) -> bool:
        return True


def test_a_bar_is_shown_on_a_terminal_only(monkeypatch):
    assert type(terminal.progress_bar(stream=text_io.StringIO())) is terminal.NoBar
    assert type(terminal.progress_bar(True, Terminal())) is terminal.NoBar
    assert type(terminal.progress_bar(stream=Terminal())) is terminal.RichBar
    monkeypatch.setitem(sys.modules, "rich.console", None)
    assert type(terminal.progress_bar(stream=Terminal())) is terminal.PlainBar


@pytest.mark.parametrize("bar", [terminal.PlainBar, terminal.RichBar])
def test_a_bar_shows_the_message_and_clears_up(bar):
    stream = Terminal()
    with bar(stream) as progress:
        assert progress(0.25, "reading") is True
        assert progress(1.0, "writing") is True
    assert "writing" in stream.getvalue()


def test_plain_bar_leaves_an_empty_line():
    stream = Terminal()
    with terminal.PlainBar(stream) as progress:
        progress(0.5, "a long message " * 20)
    last = stream.getvalue().split("\r")[-2]
    assert last.strip() == "" and len(last) <= 100


# ---- as a process


def run(*words, **options) -> subprocess.CompletedProcess:
    return subprocess.run(
        [sys.executable, "-m", "meshcore", *map(str, words)], capture_output=True, text=True, timeout=120, **options
    )


def test_process_help_and_exit_codes(tmp_path, loop):
    assert run("--help").returncode == 0
    assert run("transfinite", loop, "-o", tmp_path / "g.vts").returncode == 0
    assert run("transfinite", loop).returncode == 2
    failed = run("transfinite", tmp_path / "no.vtp", "-o", tmp_path / "h.vts")
    assert failed.returncode == 1 and "Traceback" not in failed.stderr


def test_help_imports_no_heavy_library():
    code = "import sys, meshcore.cli; meshcore.cli.parser().format_help(); print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not {"pyvista", "meshio", "vtkmodules", "matplotlib", "rich"} & set(done.stdout.split())


def test_a_reader_that_goes_away_is_no_traceback():
    process = subprocess.Popen(
        [sys.executable, "-m", "meshcore", "list", "--json"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    process.stdout.close()
    with process.stderr as stream:
        told = stream.read()
    assert process.wait(timeout=60) == 1 and told == ""


def test_warnings_of_libraries_are_not_shown(every_kind, loop, tmp_path, call):
    def warns(mesh, **keywords):
        warnings.warn("of a library", RuntimeWarning, stacklevel=1)
        return mc.Result(mesh, mc.Report("Every Kind"))

    object.__setattr__(every_kind, "function", warns)
    code, _, err = call("every-kind", loop, "-o", tmp_path / "out.vtu")
    assert (code, err) == (0, "")


@pytest.mark.parametrize("extension", ["su2", "p3d", "cgns"])
def test_a_c_grid_has_its_boundaries_in_the_files_of_flow_solvers(extension, tmp_path, call):
    mc.io.write(tmp_path / "section.vtp", gallery.airfoil("naca0012"))
    made = tmp_path / f"c.{extension}"
    code, _, err = call("c-grid", tmp_path / "section.vtp", "-o", made, "--radius", 3)
    assert (code, err) == (0, "")
    code, _, err = call("convert", made, tmp_path / "again.su2")
    assert (code, err) == (0, "")
    assert set(mc.io.read(tmp_path / "again.su2").sets) == {"wall", "far_field", "outflow"}


def test_a_format_without_its_library_is_refused_before_the_work(tmp_path, call, monkeypatch):
    monkeypatch.setitem(sys.modules, "h5py", None)
    mc.io.write(tmp_path / "section.vtp", gallery.airfoil("naca0012"))
    code, _, err = call("c-grid", tmp_path / "section.vtp", "-o", tmp_path / "c.cgns")
    assert code != 0 and "pip install h5py" in err and not leftovers(tmp_path)


def test_blocks_are_not_lost_for_a_file_of_one_grid(tmp_path, call):
    loop = gallery.airfoil("naca0012")  # whose base has a block of its own
    mc.io.write(tmp_path / "section.vtp", loop)
    code, out, _ = call("c-grid", tmp_path / "section.vtp", "-o", tmp_path / "c.vts", "--around", 60, "--layers", 12)
    assert code == 0 and "c.vts would hold one grid only: the 2 blocks are in" in " ".join(out.split())
    assert len(mc.io.read(tmp_path / "c.vtm").blocks) == 2 and not (tmp_path / "c.vts").exists()
