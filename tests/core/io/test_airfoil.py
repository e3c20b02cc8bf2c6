"""Airfoil coordinates as users have them: two layouts, messy headers, one loop."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import meshcore as mc
from tests.core.io.round_trip import check, same

DATA = Path(mc.__file__).parent / "data"
NUMBERS = {"naca0012": 69, "rae2822": 128, "s1223": 299}  # different points, counted in the files


def section(n: int = 12, *, gap: float = 0.0, camber: float = 0.02) -> tuple[np.ndarray, np.ndarray]:
    """Upper and lower side from the nose, both with it, of a NACA-like section; ``gap`` opens the trailing edge."""
    x = 0.5 * (1 - np.cos(np.linspace(0, np.pi, n)))
    thick = 0.6 * (0.2969 * np.sqrt(x) - 0.126 * x - 0.3516 * x**2 + 0.2843 * x**3 - 0.1036 * x**4)
    thick[-1] = gap / 2
    line = 4 * camber * x * (1 - x)
    return np.column_stack([x, line + thick]), np.column_stack([x, line - thick])


def expected_loop(upper: np.ndarray, lower: np.ndarray) -> np.ndarray:
    """Once round from the trailing edge, each point once."""
    around = np.concatenate([upper[::-1], lower[1:]])
    return around[:-1] if (around[0] == around[-1]).all() else around


def signed_area(mesh: mc.Mesh) -> float:
    a, b = (mesh.points[mesh.cells["line"][:, k]] for k in (0, 1))
    return 0.5 * float((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum())


def assert_one_loop(mesh: mc.Mesh) -> None:
    """One closed loop, counter-clockwise, from the trailing edge, no point twice."""
    n = mesh.n_points
    start = np.arange(n)
    np.testing.assert_array_equal(mesh.cells["line"], np.column_stack([start, (start + 1) % n]))
    assert len(np.unique(mesh.points, axis=0)) == n
    assert signed_area(mesh) > 0
    assert mesh.points[0, 0] > mesh.points[:, 0].max() - 0.01 * np.ptp(mesh.points[:, 0])


@pytest.mark.parametrize("name", NUMBERS)
def test_shipped_sections(name: str, tmp_path: Path) -> None:
    mesh = mc.io.read(DATA / f"{name}.dat")
    assert_one_loop(mesh)
    assert mesh.n_points == NUMBERS[name]
    assert 0.05 < signed_area(mesh) < 0.1
    assert mesh.field_data["title"][0] == (DATA / f"{name}.dat").read_text().splitlines()[0].strip()
    check(tmp_path, ".dat", mesh)


def words(value: float, style: str) -> str:
    """A number as some program writes it; every style keeps all digits."""
    if style == "plain":
        return repr(float(value))
    return f"{value:.17e}".replace("e", {"exponent": "e", "fortran": "D", "small": "d"}[style])


messes = st.fixed_dictionaries(
    {
        "layout": st.sampled_from(["selig", "selig reversed", "lednicer", "lednicer without counts", "lednicer blank"]),
        "gap": st.sampled_from([0.0, 0.004]),
        "n": st.integers(5, 30),
        "scale": st.sampled_from([1.0, 100.0, 1e-3, 1234.5]),
        "style": st.sampled_from(["plain", "exponent", "fortran", "small"]),
        "between": st.sampled_from([" ", "\t", ",", ", ", ";", "   "]),
        "before": st.sampled_from(["", "  ", "\t"]),
        "after": st.sampled_from(["", "   ", " # a remark", "\t! remark", ","]),
        "newline": st.sampled_from(["\n", "\r\n", "\r"]),
        "titles": st.sampled_from(
            [
                [],
                ["RAE 2822"],
                ["Flügel Nº 7", "second line"],
                ["# a comment", "NACA 0012"],
                ["4412 64"],
                ["", "E387", ""],
            ]
        ),
        "encoding": st.sampled_from(["utf-8", "utf-8-sig", "utf-16", "latin-1"]),
        "end": st.sampled_from(["", "\n", "\n\n  \n"]),
    }
)


def layout_lines(mess: dict, upper: np.ndarray, lower: np.ndarray) -> list[str]:
    def row(point: list[float]) -> str:
        return mess["before"] + mess["between"].join(words(v, mess["style"]) for v in point) + mess["after"]

    def rows(points: np.ndarray) -> list[str]:
        return [row(point) for point in points.tolist()]

    around = np.concatenate([upper[::-1], lower[1:]])
    if mess["layout"] == "selig":
        return rows(around)
    if mess["layout"] == "selig reversed":
        return rows(around[::-1])
    counts = [f"  {len(upper)}.   {len(lower)}."] if mess["layout"] != "lednicer without counts" else []
    blank = [""] if mess["layout"] == "lednicer blank" else []
    return [*counts, *blank, *rows(upper), *blank, *rows(lower)]


@given(messes)
def test_any_mess_gives_the_same_loop(mess: dict) -> None:
    upper, lower = (mess["scale"] * side for side in section(mess["n"], gap=mess["gap"]))
    if mess["scale"] > 50 and mess["layout"].startswith("lednicer"):
        mess = {**mess, "layout": "lednicer without counts"}  # counts below the chord cannot be told from coordinates
    titles = [t for t in mess["titles"] if t != "4412 64" or mess["scale"] < 50]
    text = mess["newline"].join([*titles, *layout_lines(mess, upper, lower)]) + mess["end"].replace(
        "\n", mess["newline"]
    )
    with_title = next((t for t in titles if t.strip("# ") and t != "4412 64"), None)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "wing.dat"
        path.write_bytes(text.encode(mess["encoding"]))
        mesh = mc.io.read(path)
    assert_one_loop(mesh)
    expected = expected_loop(upper, lower)
    if mess["layout"] == "selig reversed" and mess["gap"]:
        expected = np.roll(expected, 1, axis=0)  # the file begins at the lower side's end
    np.testing.assert_array_equal(mesh.points[:, :2], expected)
    if with_title:
        assert mesh.field_data["title"][0] == with_title.strip("# ")


def test_loop_from_the_nose(tmp_path: Path) -> None:
    upper, lower = section()
    around = np.concatenate([lower, upper[-2:0:-1]])
    (tmp_path / "wing.dat").write_text("wing\n" + "\n".join(f"{x!r} {y!r}" for x, y in around.tolist()))
    mesh = mc.io.read(tmp_path / "wing.dat")
    assert_one_loop(mesh)
    assert mesh.n_points == len(around)


def test_written_loops_begin_at_the_trailing_edge(tmp_path: Path) -> None:
    upper, lower = section(gap=0.01)
    around = expected_loop(upper, lower)
    turned = mc.Mesh(
        np.roll(around, 5, axis=0)[::-1], {"line": [[k, (k + 1) % len(around)] for k in range(len(around))]}
    )
    mc.io.write(tmp_path / "wing.dat", turned, title="Mein Flügel")
    mesh = mc.io.read(tmp_path / "wing.dat")
    assert_one_loop(mesh)
    assert mesh.field_data["title"][0] == "Mein Flügel"
    assert {tuple(p) for p in mesh.points.tolist()} == {tuple(p) for p in turned.points.tolist()}


def test_sharp_edge_is_repeated_for_other_programs(tmp_path: Path) -> None:
    for gap, repeats in ((0.0, 2), (0.01, 1)):
        around = expected_loop(*section(gap=gap))
        mesh = mc.Mesh(around, {"line": [[k, (k + 1) % len(around)] for k in range(len(around))]})
        mc.io.write(tmp_path / "wing.dat", mesh)
        lines = (tmp_path / "wing.dat").read_text().splitlines()
        assert lines.count(lines[1]) == repeats
        found = mc.io.read(tmp_path / "wing.dat")
        same(mc.Mesh(found.points, found.cells), mesh)


def test_grid_line_of_mses(tmp_path: Path) -> None:
    upper, lower = section()
    rows = [f"{x!r} {y!r}" for x, y in expected_loop(upper, lower).tolist()]
    (tmp_path / "wing.dat").write_text("\n".join(["wing", "-2.0 3.0 -2.5 3.0", *rows]))
    assert mc.io.read(tmp_path / "wing.dat").n_points == len(rows)


@pytest.mark.parametrize(
    "prose",
    ["", "Drawn by N. N.,\n30% of it laminar, 0.5%c thin behind.", "It flies from 60,000 up to\n400,000 and more."],
)
def test_remarks_below_the_coordinates_are_none_of_them(tmp_path: Path, prose: str) -> None:
    rows = [f"{x!r} {y!r}" for x, y in expected_loop(*section()).tolist()]
    (tmp_path / "wing.dat").write_text("\n".join(["wing", *rows, "", prose]))
    assert mc.io.read(tmp_path / "wing.dat").n_points == len(rows)


@pytest.mark.parametrize("end", ["0.5", "\n0.5", "\nlower side\n0.5\n0.7 -0.1\n1 0", "0.5 below"])
def test_half_lines_beside_coordinates_are_refused(tmp_path: Path, end: str) -> None:
    rows = [f"{x!r} {y!r}" for x, y in expected_loop(*section()).tolist()]
    (tmp_path / "wing.dat").write_text("\n".join(["wing", *rows, end]))
    with pytest.raises(mc.InvalidInput, match="is half a line"):
        mc.io.read(tmp_path / "wing.dat")
