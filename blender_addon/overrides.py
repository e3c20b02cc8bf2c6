# SPDX-License-Identifier: GPL-3.0-or-later
"""Hand-written operators for operations whose generated one is poor.

To override an operation, derive a class from `OperationBase` and put it into `OVERRIDES` by the operation's
identifier. Properties, names and limits still come from the declaration; what the class defines takes precedence.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .convert import array
from .operators import OperationBase


class Refined(OperationBase):
    """In Edit Mode, the selected faces are refined."""

    def extra(self, context: Any, arguments: dict[str, Any]) -> dict[str, Any]:
        """Marks on the triangles of selected faces, unless an indicator is named or all or none are selected."""
        ob, source = context.active_object, self._sources[0]
        if ob.mode != "EDIT" or source.faces is None or arguments.get("indicator"):
            return {}
        marks = array(ob.data.polygons, "select", bool)[source.faces]
        return {"marks": marks} if marks.any() and not np.all(marks) else {}


OVERRIDES: dict[str, type[OperationBase]] = {"refined": Refined}
