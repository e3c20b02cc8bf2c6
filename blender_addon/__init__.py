# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshcore in Blender: an operator for every operation, a panel, and tools to look at the result's quality.

Nothing happens at import, and neither meshcore nor numba is imported before a button is pressed.
"""

from . import operators, panels, preferences, properties, selection, volume

_MODULES = (properties, preferences, operators, selection, volume, panels)


def register() -> None:
    """Blender calls this when the extension is enabled."""
    for module in _MODULES:
        module.register()


def unregister() -> None:
    """Blender calls this when the extension is disabled: what `register` added goes."""
    for module in reversed(_MODULES):
        module.unregister()
