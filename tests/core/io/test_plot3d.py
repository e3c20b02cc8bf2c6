"""PLOT3D: every layout is told apart by content alone."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import meshcore as mc
from tests.core.io.round_trip import check, grid, round_trip, same


def with_iblank(block: mc.StructuredGrid) -> mc.StructuredGrid:
    return block.with_point_data(iblank=np.arange(block.n_points).reshape(block.shape) % 3 - 1)


FORMS = [{"binary": False}, {"record_markers": True}, {"record_markers": False}]


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("iblank", [False, True])
@pytest.mark.parametrize(("layers", "planar"), [(3, False), (1, False), (1, True)])
@pytest.mark.parametrize("extension", [".xyz", ".p3d", ".x", ".g"])
def test_round_trip(extension: str, layers: int, planar: bool, iblank: bool, form: dict, tmp_path: Path) -> None:
    block = grid(layers=layers)
    other = mc.StructuredGrid(block.points[:, :2] + [0.3, 0, 0])
    block, other = (with_iblank(block), with_iblank(other)) if iblank else (block, other)
    check(tmp_path, extension, block, planar=planar, **form)
    check(tmp_path, extension, mc.MultiBlock((block, other)), planar=planar, **form)


def foreign(blocks: list[np.ndarray], iblank: list[np.ndarray] | None, layout: dict) -> bytes:
    """A file as a Fortran or C program writes it, made value by value; blocks are (ni, nj[, nk], dimension)."""
    order, real = layout["order"], layout["real"]
    sizes = [n for b in blocks for n in b.shape[:-1]]
    records = [np.array([len(blocks)], order + "i4").tobytes()] if layout["many"] else []
    records.append(np.array(sizes, order + "i4").tobytes())
    for k, block in enumerate(blocks):
        content = b""
        for axis in range(block.shape[-1]):
            content += block[..., axis].ravel(order="F").astype(order + real).tobytes()
        if iblank:
            content += iblank[k].ravel(order="F").astype(order + "i4").tobytes()
        records.append(content)
    if not layout["markers"]:
        return b"".join(records)

    def marked(record: bytes) -> bytes:
        marker = len(record).to_bytes(layout["markers"], {"<": "little", ">": "big"}[order])
        return marker + record + marker

    return b"".join(map(marked, records))


layouts = st.fixed_dictionaries(
    {
        "order": st.sampled_from("<>"),
        "real": st.sampled_from(["f4", "f8"]),
        "markers": st.sampled_from([0, 4, 8]),
        "many": st.booleans(),
        "iblank": st.booleans(),
        "sizes": st.one_of(
            st.lists(st.tuples(st.integers(2, 6), st.integers(2, 5), st.integers(1, 4)), min_size=1, max_size=3),
            st.lists(st.tuples(st.integers(2, 6), st.integers(2, 5)), min_size=1, max_size=3),
        ),
    }
)


@given(layouts, st.integers(0, 2**31))
def test_every_layout_of_other_programs(layout: dict, seed: int) -> None:
    sizes = layout["sizes"] if layout["many"] else layout["sizes"][:1]
    chance = np.random.default_rng(seed)
    blocks = [chance.normal(size=(*size, len(size))).astype(layout["real"]) for size in sizes]
    iblank = [chance.integers(-1, 3, size) for size in sizes] if layout["iblank"] else None
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "grid.xyz"
        path.write_bytes(foreign(blocks, iblank, layout))
        found = mc.io.read(path)
    found_blocks = found.blocks if isinstance(found, mc.MultiBlock) else (found,)
    assert len(found_blocks) == len(blocks)
    for k, (a, b) in enumerate(zip(found_blocks, blocks, strict=True)):
        shape = (*b.shape[:-1], 1)[:3]
        assert a.shape == shape
        np.testing.assert_array_equal(a.points[..., : b.shape[-1]], b.astype(float).reshape(*shape, -1))
        if iblank:
            np.testing.assert_array_equal(a.point_data["iblank"], iblank[k].reshape(shape))
        else:
            assert not a.point_data


def test_text_of_fortran(tmp_path: Path) -> None:
    """Repeated values, D exponents, commas, lines of any length."""
    (tmp_path / "grid.p3d").write_text("  1\n 3, 2, 1\n 0.0D+00 1.0D0 2.0d0 0.\n1 2\n3*0.0, 3*1.5D-1\n 6*0.0\n")
    found = mc.io.read(tmp_path / "grid.p3d")
    np.testing.assert_array_equal(found.points[:, 0, 0], [[0, 0, 0], [1, 0, 0], [2, 0, 0]])
    np.testing.assert_array_equal(found.points[:, 1, 0, 1], [0.15] * 3)


def test_a_surface_along_any_axis(tmp_path: Path) -> None:
    """The single layer becomes k; a single row of points is a curve."""
    (tmp_path / "grid.x").write_text("1 2 3\n" + " ".join(map(str, range(18))))
    assert mc.io.read(tmp_path / "grid.x").shape == (2, 3, 1)
    (tmp_path / "grid.x").write_text("4 1 1\n" + " ".join(map(str, range(12))))
    assert mc.io.read(tmp_path / "grid.x").cells["line"].tolist() == [[0, 1], [1, 2], [2, 3]]


def test_what_is_left_out_is_named(tmp_path: Path) -> None:
    rich = mc.StructuredGrid(grid().points, {"u": grid().points}, {}, {"jmin": "wall"})
    with pytest.warns(mc.io.FormatWarning, match="'u'"):
        mc.io.write(tmp_path / "grid.xyz", mc.MultiBlock((rich,), ("wing",)))


def test_planar_needs_a_plane(tmp_path: Path) -> None:
    with pytest.raises(mc.InvalidInput, match="planar"):
        mc.io.write(tmp_path / "grid.xyz", grid(), planar=True)


def test_one_block_alone_comes_back_alone(tmp_path: Path) -> None:
    same(round_trip(tmp_path, ".xyz", mc.MultiBlock((grid(),))), grid())
