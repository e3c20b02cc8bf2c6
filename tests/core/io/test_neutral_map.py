"""Neutral maps beside PLOT3D's grids: names and cuts come back, and what lies is left out with a warning."""

from __future__ import annotations

import itertools
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import meshcore as mc
from meshcore import Cut
from tests.core.io.round_trip import grid, round_trip, same
from tests.cut_grids import c_shape, h_shape, on_a_step, quarter_turned, ring, turned_volumes

NAMED = {"jmin": "wall", "jmax": "far field", "imin": "Öffnung #1"}
TURNS = list(itertools.product(itertools.permutations(range(3)), itertools.product([False, True], repeat=3)))


def same_joins(found: mc.StructuredGrid | mc.MultiBlock, expected: mc.StructuredGrid | mc.MultiBlock) -> None:
    same(found, expected)
    assert found.cuts == expected.cuts
    if isinstance(expected, mc.MultiBlock):
        assert [block.cuts for block in found.blocks] == [block.cuts for block in expected.blocks]


@pytest.mark.parametrize(
    "made",
    [
        replace(ring(12, 3), names={"jmin": "wall", "jmax": "far field"}),
        replace(c_shape(4, 10, 3), names=NAMED),
        h_shape(3),
        on_a_step(),
        *map(quarter_turned, range(4)),
    ],
)
@pytest.mark.parametrize("extension", [".p3d", ".xyz"])
def test_names_and_cuts_come_back(made, extension, tmp_path):
    same_joins(round_trip(tmp_path, extension, made), made)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["mesh.nmf", f"mesh{extension}"]


@pytest.mark.parametrize(("order", "back"), TURNS)
def test_volumes_turned_in_any_way(order, back, tmp_path):
    made = turned_volumes(order, back)
    same_joins(round_trip(tmp_path, ".p3d", made), made)


def test_a_map_of_another_program(tmp_path: Path):
    """Unquoted types, commas, other cases, faces without a name, and no blanks where none must be."""
    c = c_shape(4, 10, 3)
    mc.io.write(tmp_path / "c.p3d", c)
    (tmp_path / "c.nmf").write_text(
        "# ==== Neutral Map File ====\n# Block#  IDIM  JDIM  KDIM\n 1\n\n  1   19   4   1\n# ----\n"
        "WALL, 1, 5, 1, 1, 5, 15\nFARFIELD 1 6 1 1 1 19 # the outer one\n"
        "'one-to-one' 1 5 1 1 1 5 1 5 1 1 19 15 .false.\n"
    )
    found = mc.io.read(tmp_path / "c.p3d")
    assert found.names == {"jmin": "WALL", "jmax": "FARFIELD"}
    assert found.cuts == (replace(c.cuts[0], name=""),)


def test_sides_that_are_moved_are_two_boundaries(tmp_path: Path):
    plain = grid(layers=1)
    straight = plain.with_points(np.stack(np.meshgrid([0, 1, 2, 4.0], [0, 1, 3.0], [0], indexing="ij"), axis=-1))
    cut = Cut(((0, 0, 0), (0, 2, 0)), ((3, 0, 0), (3, 2, 0)), translation=(4, 0, 0), name="pitch")
    with pytest.warns(mc.io.FormatWarning, match="'pitch'"):
        mc.io.write(tmp_path / "row.p3d", replace(straight, cuts=(cut,)))
    assert mc.io.read(tmp_path / "row.p3d").names == {"imin": "pitch", "imax": "pitch donor"}


def test_without_boundaries_no_map_is_written(tmp_path: Path):
    mc.io.write(tmp_path / "c.p3d", c_shape(4, 10, 3), boundaries=False)
    assert [p.name for p in tmp_path.iterdir()] == ["c.p3d"]
    assert mc.io.read(tmp_path / "c.p3d").cuts == ()


BAD = {
    "": "empty",
    "x": "a number of blocks",
    "2\n1 19 4 1\n1 19 4 1\n": "for 2 blocks",
    "1\n1 19 5 1\n": "block of",
    "1\n1 19 4 1\nwall 1 7 1 1 1 19": "no face 7",
    "1\n1 19 4 1\nwall 2 5 1 1 1 19": "block 2",
    "1\n1 19 4 1\nwall 1 5 1 1 1 20": "beyond a block",
    "1\n1 19 4 1\nwall 1 5 1 1 0 20": "beyond a block",
    "1\n1 19 4 1\nwall 1 5 1 1 a 20": "'a' is not",
    "1\n1 19 4 1\nwall 1 5\n": "3 columns",
    "1\n1 19 4 1\none-to-one 1 5 1 1 1 5\n": "7 columns",
    "1\n1 19 4 1\none-to-one 1 5 1 1 1 5 1 5 1 1 19 16 FALSE": "same shape",
}


@pytest.mark.parametrize("text", BAD)
def test_a_bad_map_is_left_out_and_told(text, tmp_path: Path):
    c = c_shape(4, 10, 3)
    mc.io.write(tmp_path / "c.p3d", c)
    (tmp_path / "c.nmf").write_text(text)
    with pytest.warns(mc.io.FormatWarning, match=BAD[text]):
        found = mc.io.read(tmp_path / "c.p3d")
    same(found, replace(c, cuts=()))


def test_a_join_of_places_apart_is_left_out_and_told(tmp_path: Path):
    c = c_shape(4, 10, 3)
    mc.io.write(tmp_path / "c.p3d", c)
    (tmp_path / "c.nmf").write_text("1\n1 19 4 1\nwall 1 6 1 1 1 19\none-to-one 1 3 1 4 1 1 1 4 1 4 1 1 FALSE\n")
    with pytest.warns(mc.io.FormatWarning, match="is allowed"):
        found = mc.io.read(tmp_path / "c.p3d")
    assert found.names == {"jmax": "wall"} and not found.cuts and not any(found.periodic)


def test_of_two_names_of_a_face_the_larger_is_kept(tmp_path: Path):
    mc.io.write(tmp_path / "c.p3d", c_shape(4, 10, 3))
    (tmp_path / "c.nmf").write_text("1\n1 19 4 1\nlip 1 6 1 1 1 3\nouter 1 6 1 1 3 19\n")
    with pytest.warns(mc.io.FormatWarning, match="'lip'"):
        assert mc.io.read(tmp_path / "c.p3d").names == {"jmax": "outer"}


@given(st.dictionaries(st.sampled_from(["imin", "imax", "jmin", "jmax", "kmin", "kmax"]), st.text(max_size=12)))
def test_any_names(names):
    plain = {face: " ".join(name.replace("\0", "").split()) for face, name in names.items()}
    plain = {face: name if "'" not in name else name.replace('"', "'") for face, name in plain.items()}
    plain = {face: name for face, name in plain.items() if name not in ("", "boundary")}
    with tempfile.TemporaryDirectory() as folder:
        mc.io.write(Path(folder) / "box.p3d", replace(grid(), names=names))
        assert mc.io.read(Path(folder) / "box.p3d").names == plain
