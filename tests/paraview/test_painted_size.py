"""Sizes from a point array of the input or of a second input, inside ParaView."""

from __future__ import annotations

import pytest

from .conftest import assert_passed, checks_of

SCRIPT = "painted_size.py"


@pytest.mark.parametrize("check", checks_of(SCRIPT))
def test_painted_size(host, check):
    assert_passed(host.run(SCRIPT), check)
