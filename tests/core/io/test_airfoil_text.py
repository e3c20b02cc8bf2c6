"""Sections' files as they are found: notes behind the coordinates, decimal commas, tables, several elements, lies."""

from __future__ import annotations

import os
import warnings
from pathlib import Path

import numpy as np
import pytest

import meshcore as mc
from meshcore.cli import main
from tests.core.io.test_airfoil import expected_loop, section


def around(n: int = 12, **shape: float) -> np.ndarray:
    return expected_loop(*section(n, **shape))


def rows(points: np.ndarray, between: str = " ") -> str:
    return "\n".join(between.join(map(repr, point)) for point in np.asarray(points).tolist())


def read(folder: Path, text: str | bytes) -> tuple[np.ndarray, list[str]]:
    """The loop, and what was told."""
    path = folder / "wing.dat"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        mesh = mc.io.read(path)
    return mesh.points[:, :2], [str(warning.message) for warning in said]


def refused(folder: Path, text: str | bytes) -> str:
    with pytest.raises(mc.InvalidInput) as caught:
        read(folder, text)
    assert "\n" not in str(caught.value)
    return str(caught.value)


NOTES = {
    "prose": ("\n\nA fine wing.\nhttp://example.org/wing?p=1\n", 0),
    "half a line of it": ("\n\n20 nov 2005\nthickness 7 %", 0),
    "percent": ("\n\n9%_1.4%_CM0=0.015 and more\n28/12/2005", 0),
    "two numbers and words": ("\nsuited for\n400,000 and more.", 0),
    "points that were changed": ("\nchanged\n0.0 0.00102 -> 0.00001 0.00102\n0.9 -0.15 -> 0.99 -0.149", 0),
    "two numbers alone": ("\nNovi Sad\n2010 1\n", 1),
    "a point with an arrow": ("\n\nby L.\n\n0.12048\t-0.03012->0.30119", 0),
}


@pytest.mark.parametrize("name", NOTES)
def test_notes_behind_the_coordinates_are_no_points(name: str, tmp_path: Path) -> None:
    notes, numbers = NOTES[name]
    points = around()
    found, said = read(tmp_path, "wing\n" + rows(points) + notes)
    np.testing.assert_array_equal(found, points)
    assert sum(text.count("'line ") for text in said) == numbers  # each line of nothing but numbers is told


@pytest.mark.parametrize(
    "end", ["\n0.97", "\n0.97 ", "\n0.97 -", "\n0.97 O.1", "\nO.97 0.1", "\n0.97 *****", "\n0.9.7 1"]
)
def test_a_line_cut_off_among_the_points_is_an_error(end: str, tmp_path: Path) -> None:
    points = around()
    assert f"line {len(points) + 2}" in refused(tmp_path, "wing\n" + rows(points) + end)
    half = len(points) // 2
    assert f"line {half + 2}" in refused(tmp_path, "wing\n" + rows(points[:half]) + end + "\n" + rows(points[half:]))


def test_notes_among_the_points_are_an_error(tmp_path: Path) -> None:
    points = around()
    text = "wing\n" + rows(points[:9]) + "\n\n20 nov 2005\n" + rows(points[9:])
    assert "line 12: '20 nov 2005' is half a line" in refused(tmp_path, text)


@pytest.mark.parametrize("between", ["\t", ";", " ; ", "  "])
def test_decimal_commas(between: str, tmp_path: Path) -> None:
    points = around(30) + 1e-5  # numbers such as 1e-05, which have no comma
    text = rows(points, between).replace(".", ",")
    assert "e-05" in text
    found, said = read(tmp_path, "wing 1.5\n" + text)
    np.testing.assert_array_equal(found, points)
    assert not said


def test_minus_signs_of_typesetters(tmp_path: Path) -> None:
    points = around()
    found, _ = read(tmp_path, "wing\n" + rows(points).replace("-", "\N{MINUS SIGN}"))
    np.testing.assert_array_equal(found, points)


def test_tables_with_open_ordinates_and_brackets(tmp_path: Path) -> None:
    points = around(gap=0.0042)
    lines = rows(points).split("\n")
    lines[0], lines[-1] = "1.0 (0.0021)", "1.0 (-0.0021)"
    found, _ = read(tmp_path, "\n".join(["NACA", "1.0000   ......", *lines[:11], "0.0000  ......", *lines[11:]]))
    np.testing.assert_array_equal(found, points)


def test_words_behind_points(tmp_path: Path) -> None:
    points = around()
    lines = rows(points).split("\n")
    lines[0] += " trailing edge"
    lines[11] += " nose"
    found, _ = read(tmp_path, "\n".join(["wing", *lines]))
    np.testing.assert_array_equal(found, points)


@pytest.mark.parametrize("head", ["wing\n12. 12.\n\n", "12 12\n", "wing\n"])
@pytest.mark.parametrize("between", ["\n", "\n\n", "\nlower side\n"])
def test_two_blocks(head: str, between: str, tmp_path: Path) -> None:
    upper, lower = section(12)
    found, said = read(tmp_path, head + rows(upper) + between + rows(lower))
    np.testing.assert_array_equal(found, expected_loop(upper, lower))
    assert not said


def test_told_lengths_part_the_blocks(tmp_path: Path) -> None:
    """A side of few points has no great jump to the other; its length is told."""
    upper, lower = np.array([[0.4, 0.1], [1.0, 0.0]]), np.array([[0.0, 0.0], [0.4, -0.1], [1.0, 0.0]])
    found, _ = read(tmp_path, "wedge\n2 3\n" + rows(upper) + "\n" + rows(lower))
    np.testing.assert_array_equal(found, [[1.0, 0.0], [0.4, 0.1], [0.0, 0.0], [0.4, -0.1]])


@pytest.mark.parametrize("title", ["wing\n", ""])
@pytest.mark.parametrize("counts", ["10. 12.", "12 13", "2 2", "1e18 1e18"])
def test_lengths_that_lie(title: str, counts: str, tmp_path: Path) -> None:
    upper, lower = section(12)
    if counts == "1e18 1e18" and not title:
        counts = "12 11"
    text = title + counts + "\n" + rows(upper) + "\n" + rows(lower)
    assert "but there are 24" in refused(tmp_path, text)


SEPARATORS = {
    "999": ("\n999. 999.\n", "999 999 stands between"),
    "blank": ("\n\n", "a second one begins there"),
    "text": ("\nflap\n", "a second one begins there"),
    "nothing": ("\n", "closed before it"),
}


@pytest.mark.parametrize("name", SEPARATORS)
def test_several_elements(name: str, tmp_path: Path) -> None:
    points = around()
    closed = np.concatenate([points, points[:1]])
    flap = 0.3 * closed + [0.7, -0.2]  # its trailing edge is below that of the wing
    between, what = SEPARATORS[name]
    text = refused(tmp_path, "wing\n" + rows(closed) + between + rows(flap))
    assert "several elements" in text
    assert what in text


@pytest.mark.parametrize("scale", [1e-200, 1e200])
def test_any_scale(scale: float, tmp_path: Path) -> None:
    points = around() * scale
    np.testing.assert_array_equal(read(tmp_path, rows(points))[0], points)


LIES = {
    "three columns": rows(np.column_stack([around(), np.full(22, 0.3)])),
    "numbered points": "\n".join(f"{k} {row}" for k, row in enumerate(rows(around()).split("\n"))),
    "all in one line": " ".join(rows(around()).split()),
    "no lines": '{"x": [1, 0, 1], "y": [0, 0.1, 0]}',
    "one point": "wing\n0 0\n",
    "two points": "wing\n0 0\n1 0\n",
    "nan": "wing\n" + rows(around()).replace("0.0", "nan", 1),
    "a line": "wing\n" + rows(np.column_stack([np.linspace(0, 1, 9), np.zeros(9)])),
    "half": "wing\n" + rows(around()[:11]),
    "binary": bytes(range(256)),
    "UTF-16 without a mark": rows(around()).encode("utf-16-le"),
    "gzip": b"\x1f\x8b\x08\x00" + bytes(50),
}


@pytest.mark.parametrize("name", LIES)
def test_lies_are_one_line_on_the_command_line(name: str, tmp_path: Path, capfd: pytest.CaptureFixture) -> None:
    path = tmp_path / "wing.dat"
    path.write_bytes(LIES[name] if isinstance(LIES[name], bytes) else LIES[name].encode())
    assert main(["o-grid", str(path), "--quiet", "-o", str(tmp_path / "grid.vts")]) == 1
    said = capfd.readouterr().err
    assert said.startswith("meshcore: error: wing.dat")
    assert said.count("\n") == 1
    assert not (tmp_path / "grid.vts").exists()


def test_paths_that_are_no_files(tmp_path: Path, capfd: pytest.CaptureFixture) -> None:
    (tmp_path / "circle.dat").symlink_to(tmp_path / "circle.dat")
    (tmp_path / "nowhere.dat").symlink_to(tmp_path / "missing.dat")
    os.mkfifo(tmp_path / "pipe.dat")
    (tmp_path / "wing.dat.gz").write_bytes(b"\x1f\x8b")
    expected = {"circle.dat": "circles", "nowhere.dat": "nowhere", "pipe.dat": "pipe", "wing.dat.gz": "unpack it"}
    for name, what in expected.items():
        assert main(["o-grid", str(tmp_path / name), "--quiet", "-o", str(tmp_path / "grid.vts")]) == 1
        said = capfd.readouterr().err
        assert what in said, said
        assert said.count("\n") == 1
