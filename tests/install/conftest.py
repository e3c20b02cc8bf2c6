"""A clean home folder for each test that asks for one."""

from __future__ import annotations

import pytest

from tests.install.homes import Home, new_home


@pytest.fixture
def home(tmp_path) -> Home:
    """A home of one test."""
    return new_home(tmp_path)
