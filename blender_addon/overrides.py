# SPDX-License-Identifier: GPL-3.0-or-later
"""Hand-written operators for operations whose generated one is poor.

To override an operation, write a class that derives from `operators.OperationBase` and `bpy.types.Operator` and put it
into `OVERRIDES` by the operation's identifier. It is registered, shown in menus and panel, and tested in place of
the generated one; ``identifier``, ``declaration``, ``bl_idname`` and ``bl_label`` it must bring itself.
"""

from __future__ import annotations

OVERRIDES: dict[str, type] = {}
