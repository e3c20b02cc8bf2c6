"""CGNS files of meshcore, opened by ParaView's own reader."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

import meshcore as mc
from tests.cut_grids import c_shape, turned_volumes

from .conftest import assert_passed, checks_of

SCRIPT = "cgns.py"


@pytest.fixture(scope="module")
def files(host):
    """Files in ParaView's folder, written here since its Python lacks h5py, and what is to be found in them."""
    names = {"jmin": "wall", "jmax": "far field", "imin": "outflow", "imax": "outflow"}
    made = {
        "plane.cgns": replace(c_shape(4, 10, 3), names=names),
        "volumes.cgns": turned_volumes((1, 2, 0), (True,) * 3),
    }
    expected = {}
    for name, grid in made.items():
        mc.io.write(host.folder / name, grid)
        families = list(dict.fromkeys(patch.name for patch in mc.patches(grid)))
        expected[name] = {"cells": grid.n_cells, "points": grid.n_points, "families": families}
    (host.folder / "cgns.json").write_text(json.dumps(expected))


@pytest.mark.parametrize("check", checks_of(SCRIPT))
def test_cgns(host, files, check):
    assert_passed(host.run(SCRIPT), check)
