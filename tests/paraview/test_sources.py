"""What the plugin has beyond the registry: models, quality, reader, writer."""

from __future__ import annotations

import pytest

from .conftest import assert_passed, checks_of

SCRIPT = "sources.py"


@pytest.mark.parametrize("check", checks_of(SCRIPT))
def test_sources(host, check):
    assert_passed(host.run(SCRIPT), check)
