"""Geometry made in ParaView, through meshcore, back in ParaView, read again."""

from __future__ import annotations

import pytest

from .conftest import assert_passed, checks_of

SCRIPT = "round_trip.py"


@pytest.mark.parametrize("check", checks_of(SCRIPT))
def test_round_trip(host, check):
    assert_passed(host.run(SCRIPT), check)
