"""Blender for these tests: the extension's zip built, installed into a user folder of its own, and enabled."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

USER_FOLDER = Path(tempfile.mkdtemp(prefix="meshcore-blender-"))
os.environ["BLENDER_USER_RESOURCES"] = str(USER_FOLDER)  # Blender reads it once, when bpy is imported
MODULE = "bl_ext.user_default.meshcore"
ZIP = "MESHCORE_BLENDER_ZIP"


@pytest.fixture(scope="session")
def python_version() -> str:
    """The Python that this Blender carries."""
    return f"{sys.version_info.major}.{sys.version_info.minor}"


@pytest.fixture(scope="session")
def zip_path(root: Path, python_version: str, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """The extension for this Python, built by a Python that has meshcore, or taken from MESHCORE_BLENDER_ZIP."""
    if ZIP in os.environ:
        yield Path(os.environ[ZIP])
        return
    folder = tmp_path_factory.mktemp("zip")
    core = root / ".venv/bin/python"
    command = [str(core if core.exists() else sys.executable), str(root / "blender_addon/build.py")]
    environment = {**os.environ, "PYTHONPATH": str(root)}
    done = subprocess.run(
        [*command, "--python", python_version, str(folder)], env=environment, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    yield next(folder.glob("*.zip"))
    shutil.rmtree(folder)  # a hundred megabytes


@pytest.fixture(scope="session", autouse=True)
def installed(zip_path: Path):
    """The extension installed and enabled; meshcore is the zip's, not the checkout's."""
    import bpy

    bpy.ops.extensions.package_install_files(filepath=str(zip_path), repo="user_default", enable_on_install=True)
    wheels = next(USER_FOLDER.rglob("site-packages"))
    sys.path.insert(0, str(wheels))
    yield sys.modules[MODULE]
    shutil.rmtree(USER_FOLDER, ignore_errors=True)


@pytest.fixture(autouse=True)
def empty_scene(installed):
    """Each test begins in Object Mode with nothing in the scene."""
    import bpy

    if bpy.context.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    for collection in (bpy.data.objects, bpy.data.meshes, bpy.data.curves, bpy.data.collections):
        for item in list(collection):
            collection.remove(item)
    yield


@pytest.fixture
def core():
    """The meshcore that the extension uses."""
    import meshcore

    return meshcore
