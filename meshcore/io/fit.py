"""What a format can hold, and the check that nothing is lost without a word."""

from __future__ import annotations

import warnings
from collections.abc import Sequence


class FormatWarning(UserWarning):
    """Something was changed or left out, because the file's format and a `Mesh` do not hold the same."""


def warn_dropped(what: str, names: Sequence[str], reason: str) -> None:
    """Warn, once for all, that some arrays are left out."""
    if names:
        listed = ", ".join(repr(name) for name in names)
        warnings.warn(f"{what} {listed} left out: {reason}", FormatWarning, stacklevel=3)
