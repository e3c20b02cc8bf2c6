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


class FourSided(OperationBase):
    """In Edit Mode, four selected vertices are the corners of the loop that the object's open edges make."""

    def extra(self, context: Any, arguments: dict[str, Any]) -> dict[str, Any]:
        """The corners, unless the redo panel gives others."""
        ob, source = context.active_object, self._sources[0]
        if ob.mode != "EDIT" or source.vertices is None or arguments.get("corners", NO_CORNERS) != NO_CORNERS:
            return {}
        if array(ob.data.edges, "select", bool).any():  # then these are the sides
            return {}
        chosen = np.flatnonzero(array(ob.data.vertices, "select", bool)[source.vertices])
        return {"corners": tuple(chosen.tolist())} if len(chosen) == len(NO_CORNERS) else {}


NO_CORNERS = (-1, -1, -1, -1)
OVERRIDES: dict[str, type[OperationBase]] = {"refined": Refined, "transfinite": FourSided, "elliptic": FourSided}
