"""Text in bulk reads as words one by one would, and names the line at fault."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import meshcore as mc
from meshcore.io.lines import Lines, rows_of, wrapped

WORDS = [
    "1",
    "-2",
    "+3",
    "0.5",
    "1e-300",
    "1D2",
    "nan",
    "inf",
    "1_0",
    "x",
    "99999999999999999999",
    "1.",
    "0x1",
    "1e400",
]


@given(st.lists(st.lists(st.floats(), min_size=3, max_size=3), max_size=40))
def test_every_digit_comes_back(values):
    table = np.array(values).reshape(-1, 3)
    found = Lines.of(rows_of(table)).table(3, "a row")
    np.testing.assert_array_equal(found, table)
    words = wrapped(table.ravel(), 4).split()
    np.testing.assert_array_equal(np.array(words, float), table.ravel())
    assert all(word == repr(float(value)) for word, value in zip(words, table.ravel(), strict=True))


@given(st.lists(st.integers(-(2**63), 2**63 - 1)), st.lists(st.floats(width=32)))
def test_whole_and_single_numbers_come_back(whole, single):
    n = min(len(whole), len(single))
    ints, floats = np.array(whole[:n], np.int64), np.array(single[:n], np.float32)
    lines = Lines.of(rows_of(ints, floats))
    np.testing.assert_array_equal(lines.whole(1, "a row")[:, 0], ints)
    np.testing.assert_array_equal(lines.table(1, "a row", first=1)[:, 0].astype(np.float32), floats)


def slow(words: list[str], kind: type) -> list:
    """As Python reads the words; None for those that are no number of a file."""
    found = []
    for word in words:
        try:
            found.append(None if "_" in word else kind(word.replace("D", "e") if kind is float else word))
        except ValueError:
            found.append(None)
    return found


@given(st.lists(st.lists(st.sampled_from(WORDS), min_size=1, max_size=4), min_size=1, max_size=4))
def test_odd_words_are_read_or_named(rows):
    """Whatever stands in a column, it is read as Python reads it, or its line is named."""
    lines = Lines.of("\n\n".join(" ".join(row) for row in rows))
    for kind, read in ((float, lines.table), (int, lines.whole)):
        expected = [slow(row[:2], kind) for row in rows]
        wrong = [
            k for k, row in enumerate(expected) if len(row) < 2 or None in row or (kind is int and max(row) > 2**62)
        ]
        if not wrong:
            np.testing.assert_array_equal(read(2, "a row"), np.array(expected))
            continue
        short = [k for k, row in enumerate(rows) if len(row) < 2]
        with pytest.raises(mc.InvalidInput, match=f"line {2 * (short or wrong)[0] + 1}:"):
            read(2, "a row")


def test_comments_and_blank_lines_do_not_count():
    lines = Lines.of("1 2 # 3\n \t\n# 4\n5 6")
    assert list(lines) == [(1, ["1", "2"]), (4, ["5", "6"])]
    assert lines[np.array([1, 0])].numbers == [4, 1]
    assert list(lines[1:]) == [(4, ["5", "6"])]
    assert lines[:0].table(3, "a row").shape == (0, 3)


def test_rows_of_any_length():
    lines = Lines.of("3 7 8 9\nx 2 4 5\n1 6")
    values, offsets = lines.ragged(np.array([3, 1, 1]), "a row", first=np.array([1, 3, 1]))
    assert values.tolist() == [7, 8, 9, 5, 6] and offsets.tolist() == [0, 3, 4, 5]
    with pytest.raises(mc.InvalidInput, match=r"line 3: a row needs 10\d* words, got 2"):
        lines.ragged(np.array([1, 1, 10**12]), "a row")


def test_a_list_behind_a_list(tmp_path):
    """Lists of any length, and what stands behind them, in PLY's text."""
    header = "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n"
    header += "element face 3\nproperty list uchar int other\nproperty list uchar int vertex_indices\n"
    header += "property float area\nend_header\n"
    points = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n2 0 0\n"
    (tmp_path / "a.ply").write_text(header + points + "0 3 0 1 2 0.5\n2 9 9 4 0 1 2 3 1\n1 4 3 1 4 2 0.25\n")
    mesh = mc.io.read(tmp_path / "a.ply")
    assert mesh.cells["triangle"].tolist() == [[0, 1, 2], [1, 4, 2]] and mesh.cells["quad"].tolist() == [[0, 1, 2, 3]]
    assert mesh.cell_data["area"].tolist() == [0.5, 0.25, 1]
    (tmp_path / "a.ply").write_text(header + points + "0 3 0 1 2 0.5\n2 9 9 4 0 1 2 3 1\n1 4 -3 1 4 2 0.25\n")
    with pytest.raises(mc.InvalidInput, match="line 8: a list has a negative length"):
        mc.io.read(tmp_path / "a.ply")


def test_kinds_that_alternate(tmp_path):
    """Gmsh lists elements in any order, each with tags of its own number."""
    elements = ["1 15 1 7 1", "2 2 2 5 1 1 2 3", "3 2 0 1 3 4", "4 3 2 6 1 1 2 3 4", "5 2 2 5 1 2 3 4"]
    nodes = ["1 0 0 0", "2 1 0 0", "3 1 1 0", "4 0 1 0"]
    text = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$Nodes", "4", *nodes, "$EndNodes", "$Elements", "5", *elements]
    (tmp_path / "a.msh").write_text("\n".join([*text, "$EndElements", ""]))
    mesh = mc.io.read(tmp_path / "a.msh")
    assert mesh.cells["triangle"].tolist() == [[0, 1, 2], [0, 2, 3], [1, 2, 3]]
    assert mesh.cell_data["tag"].tolist() == [7, 5, 0, 5, 6]
    for wrong in ("5 2 2 5 1 2 3", "5 2 -1 5 1 2 3 4"):
        (tmp_path / "a.msh").write_text("\n".join([*text[:-1], wrong, "$EndElements", ""]))
        with pytest.raises(mc.InvalidInput, match="ends within an element"):
            mc.io.read(tmp_path / "a.msh")
