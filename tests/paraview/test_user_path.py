"""What a user does from loading the plugin to loading the state again, with a window on a virtual display."""

from __future__ import annotations

import pytest

from tests.display import DISPLAY

from .conftest import assert_passed, checks_of

SCRIPT = "user_path.py"


@pytest.mark.parametrize("check", checks_of(SCRIPT))
def test_user_path(host, check):
    assert_passed(host.run(SCRIPT, *DISPLAY, "pvpython"), check)
