"""Install, enable, use, disable, enable again, remove; run by test_lifecycle in a Blender of its own.

Prints one JSON object of what it saw. Usage: python lifecycle.py ZIP, with BLENDER_USER_RESOURCES set.
"""

from __future__ import annotations

import importlib
import json
import os
import sys
from pathlib import Path

import bpy

MODULE = "bl_ext.user_default.meshcore"
HOME = Path(os.environ["BLENDER_USER_RESOURCES"])


def ours() -> list[str]:
    """Everything of the extension that Blender knows of."""
    found = [name for name in dir(bpy.types) if "meshcore" in name.lower()]
    found += [f"bpy.ops.meshcore.{name}" for name in dir(bpy.ops.meshcore)]
    found += ["Scene.meshcore"] * hasattr(bpy.types.Scene, "meshcore")
    for menu in (bpy.types.VIEW3D_MT_mesh_add, bpy.types.VIEW3D_MT_object):
        found += [f.__module__ for f in getattr(menu.draw, "_draw_funcs", []) if "meshcore" in f.__module__]
    return found


def use() -> list[int]:
    """One transfinite patch; its numbers of vertices and faces."""
    bpy.ops.mesh.primitive_plane_add(size=2)
    bpy.ops.meshcore.transfinite(cells_i=4, cells_j=3)
    data = bpy.context.view_layer.objects.active.data
    return [len(data.vertices), len(data.polygons)]


def main(zip_path: str) -> dict:
    """The whole life of the extension."""
    import addon_utils  # known once bpy is imported

    seen = {"before": ours()}
    bpy.ops.extensions.package_install_files(filepath=zip_path, repo="user_default", enable_on_install=True)
    seen["enabled"] = ours()
    heavy = {"meshcore", "numba", "scipy", "llvmlite"}
    seen["imported by enabling"] = sorted(heavy & sys.modules.keys())
    # The test's Python has numba and scipy of its own; Blender has only the bundled ones, so these go first.
    sys.path.insert(0, str(next(HOME.rglob("site-packages"))))
    seen["made"] = use()
    seen["compiled"] = sorted(bpy.ops.meshcore.compile_kernels())
    seen["bundled"] = sorted(n for n in heavy if Path(importlib.import_module(n).__file__).is_relative_to(HOME))
    seen["21 doubled"] = importlib.import_module("numba").njit(lambda x: 2 * x)(21)
    for turn in ("disabled", "disabled again"):
        addon_utils.disable(MODULE, default_set=True)
        seen[turn] = ours()
        addon_utils.enable(MODULE, default_set=True)
    seen["enabled again"] = ours()
    seen["made again"] = use()
    repository = next(r for r in bpy.context.preferences.extensions.repos if r.module == "user_default")
    bpy.ops.extensions.package_uninstall(repo_directory=repository.directory, pkg_id="meshcore")
    seen["removed"] = ours()
    seen["left on disk"] = [p.name for p in (HOME / "extensions/user_default").iterdir() if p.name == "meshcore"]
    return seen


if __name__ == "__main__":
    print("SEEN", json.dumps(main(sys.argv[1])))
