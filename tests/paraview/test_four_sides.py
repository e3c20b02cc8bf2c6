"""Four-sided patches from what ParaView's users have."""

from __future__ import annotations

import pytest

from .conftest import assert_passed, checks_of

SCRIPT = "four_sides.py"


@pytest.mark.parametrize("check", checks_of(SCRIPT))
def test_four_sides(host, check):
    assert_passed(host.run(SCRIPT), check)
