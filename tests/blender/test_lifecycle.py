"""The zip in a fresh Blender: installed, enabled, used, disabled, enabled again, removed."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys

import pytest


@pytest.fixture(scope="module")
def seen(root, zip_path, tmp_path_factory):
    """What tests/blender/lifecycle.py saw."""
    home = tmp_path_factory.mktemp("home")
    environment = {**os.environ, "BLENDER_USER_RESOURCES": str(home)}
    environment.pop("PYTHONPATH", None)
    command = [sys.executable, str(root / "tests/blender/lifecycle.py"), str(zip_path)]
    done = subprocess.run(command, env=environment, cwd=home, capture_output=True, text=True, timeout=300)
    shutil.rmtree(home)  # the unpacked wheels are large
    line = next((one for one in done.stdout.splitlines() if one.startswith("SEEN ")), None)
    assert line, done.stdout[-2000:] + done.stderr[-2000:]
    return json.loads(line[5:])


def test_enabling_adds_operators_menus_panels_and_settings(seen):
    assert seen["before"] == []
    enabled = seen["enabled"]
    for name in ("MESHCORE_OT_transfinite", "VIEW3D_PT_meshcore", "MESHCORE_MT_operations", "Scene.meshcore"):
        assert name in enabled
    assert enabled.count("bl_ext.user_default.meshcore.panels") == 2


def test_enabling_imports_nothing_heavy(seen):
    assert seen["imported by enabling"] == []


def test_the_bundled_libraries_work(seen):
    assert seen["bundled"] == ["llvmlite", "meshcore", "numba", "scipy"]
    assert seen["made"] == [20, 12]
    assert seen["compiled"] == ["FINISHED"]
    assert seen["21 doubled"] == 42


def test_disabling_twice_takes_everything_away(seen):
    assert seen["disabled"] == seen["disabled again"] == []
    assert seen["enabled again"] == seen["enabled"]
    assert seen["made again"] == [20, 12]


def test_removing_leaves_nothing(seen):
    assert seen["removed"] == []
    assert seen["left on disk"] == []
