"""Runs inside Blender, or a Python that has bpy: installs or removes an extension, and tells its state."""

import importlib
import importlib.util
import json
import os
import sys

REPOSITORY = "user_default"


def blender():
    """The modules bpy and addon_utils; the second can be found once the first is imported."""
    bpy = importlib.import_module("bpy")
    return bpy, importlib.import_module("addon_utils")


def load_preferences():
    """Read what the user has set: bpy as a module starts with factory settings, and would save those over them."""
    bpy, _ = blender()
    if bpy.app.module:
        bpy.ops.wm.read_userpref()


def preferences():
    """Blender's preferences, with the extension tools switched on."""
    bpy, addon_utils = blender()
    if not hasattr(bpy.types, "EXTENSIONS_OT_package_install_files"):
        addon_utils.enable("bl_pkg", default_set=False)
    return bpy.context.preferences


def repository():
    """The user's own repository of extensions: its position and its folder."""
    for number, candidate in enumerate(preferences().extensions.repos):
        if candidate.module == REPOSITORY:
            return number, candidate.directory
    raise SystemExit(f"this Blender has no repository {REPOSITORY}; add it in Preferences > Get Extensions")


def install(identifier, zip_file):
    """Install and enable, and keep it so."""
    bpy, addon_utils = blender()
    repository()
    bpy.ops.extensions.package_install_files(filepath=zip_file, repo=REPOSITORY, enable_on_install=True)
    if not addon_utils.check(module_of(identifier))[1]:
        addon_utils.enable(module_of(identifier), default_set=True)
    bpy.ops.wm.save_userpref()


def remove(identifier):
    """Disable and remove."""
    bpy, addon_utils = blender()
    number, folder = repository()
    addon_utils.disable(module_of(identifier), default_set=True)
    bpy.ops.extensions.package_uninstall(repo_index=number, repo_directory=folder, pkg_id=identifier)
    bpy.ops.wm.save_userpref()


def module_of(identifier):
    """The name under which Blender imports an extension."""
    return f"bl_ext.{REPOSITORY}.{identifier}"


def state(identifier):
    """Whether it is there, whether it is switched on, and which libraries are found."""
    _, addon_utils = blender()
    folder = os.path.join(repository()[1], identifier)
    module = module_of(identifier)
    return {
        "present": os.path.isdir(folder),
        "enabled": module in preferences().addons and addon_utils.check(module)[1],
        "libraries": {name: importlib.util.find_spec(name) is not None for name in ("numba", "scipy", "meshcore")},
        "folder": folder,
    }


if __name__ == "__main__":
    arguments = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:]
    load_preferences()
    if arguments[0] == "install":
        install(*arguments[1:])
    elif arguments[0] == "remove":
        remove(*arguments[1:])
    print("MESHCORE " + json.dumps(state(arguments[1])))
