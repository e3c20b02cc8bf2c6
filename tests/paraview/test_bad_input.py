"""Each bad input is answered by one line in ParaView, and the pipeline lives on."""

from __future__ import annotations

import pytest

from .conftest import assert_passed, checks_of

SCRIPT = "bad_input.py"


@pytest.mark.parametrize("check", checks_of(SCRIPT))
def test_bad_input(host, check):
    assert_passed(host.run(SCRIPT), check)
