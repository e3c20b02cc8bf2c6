"""Grids on curved surfaces, inside ParaView."""

from __future__ import annotations

import pytest

from .conftest import assert_passed, checks_of

SCRIPT = "surfaces.py"


@pytest.mark.parametrize("check", checks_of(SCRIPT))
def test_surfaces(host, check):
    assert_passed(host.run(SCRIPT), check)
