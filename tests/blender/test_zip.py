"""The extension's zip: what is in it, that Blender's own tool accepts it, and the rules its files keep."""

from __future__ import annotations

import ast
import importlib.util
import json
import subprocess
import sys
import zipfile
from pathlib import Path

import bpy
import pytest
import tomllib


@pytest.fixture(scope="module")
def build(root):
    """The build script as a module, loaded by its path as any caller may."""
    spec = importlib.util.spec_from_file_location("meshcore_blender_build", root / "blender_addon/build.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def small_zip(build, installed, tmp_path_factory) -> Path:
    """The zip without wheels."""
    return build.build(tmp_path_factory.mktemp("small"), wheels=False)


def sources(path: Path) -> dict[str, ast.Module]:
    """The zip's Python files, parsed."""
    with zipfile.ZipFile(path) as archive:
        names = [name for name in archive.namelist() if name.endswith(".py")]
        return {name: ast.parse(archive.read(name)) for name in names}


def test_blender_accepts_it(zip_path):
    scripts = Path(bpy.utils.system_resource("SCRIPTS"))
    tool = scripts / "addons_core/bl_pkg/cli/blender_ext.py"
    tags = scripts / "modules/_bpy_internal/extensions/tags.py"
    command = [sys.executable, str(tool), "validate", "--valid-tags", str(tags), str(zip_path)]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


def test_carries_the_wheels_that_blender_lacks_and_no_numpy(zip_path):
    with zipfile.ZipFile(zip_path) as archive:
        manifest = tomllib.loads(archive.read("blender_manifest.toml").decode())
        held = {"./" + name for name in archive.namelist() if name.endswith(".whl")}
    assert set(manifest["wheels"]) == held
    assert {name.split("/")[-1].split("-")[0] for name in held} == {"meshcore", "numba", "llvmlite", "scipy"}


def test_manifest_speaks_of_this_meshcore_and_this_blender(zip_path, core):
    with zipfile.ZipFile(zip_path) as archive:
        manifest = tomllib.loads(archive.read("blender_manifest.toml").decode())
    assert manifest["version"] == core.__version__
    assert manifest["license"] == ["SPDX:GPL-3.0-or-later"]
    assert tuple(map(int, manifest["blender_version_min"].split("."))) <= bpy.app.version
    if "blender_version_max" in manifest:
        assert bpy.app.version < tuple(map(int, manifest["blender_version_max"].split(".")))


def test_bundled_meshcore_is_whole(zip_path, root, tmp_path):
    with zipfile.ZipFile(zip_path) as archive:
        name = next(n for n in archive.namelist() if n.startswith("wheels/meshcore-"))
        archive.extract(name, tmp_path)
    with zipfile.ZipFile(tmp_path / name) as wheel:
        held = set(wheel.namelist())
        record = next(n for n in held if n.endswith("/RECORD"))
        listed = {line.split(",")[0] for line in wheel.read(record).decode().splitlines()}
    assert listed == held
    assert {path.relative_to(root).as_posix() for path in (root / "meshcore").rglob("*.py")} <= held


def test_operations_are_the_registry(zip_path, core):
    with zipfile.ZipFile(zip_path) as archive:
        held = json.loads(archive.read("operations.json"))
    assert held["operations"] == {k: op.declaration() for k, op in core.operations().items()}


def test_same_inputs_give_the_same_bytes(build, small_zip, tmp_path):
    assert build.build(tmp_path, wheels=False).read_bytes() == small_zip.read_bytes()


def test_every_module_is_in_the_zip(build, root, small_zip):
    here = {path.name for path in (root / "blender_addon").glob("*.py")}
    assert here - {"build.py"} == set(sources(small_zip))


@pytest.mark.parametrize(
    "arguments", [{"python": "3.9"}, {"platform": "amiga"}, {"platform": "macos-x64", "python": "3.13"}]
)
def test_unknown_target_is_named(build, tmp_path, arguments):
    with pytest.raises(ValueError, match=next(iter(arguments.values()))):
        build.build(tmp_path, **arguments)


def test_failed_download_tells_what_pip_said(build, tmp_path, monkeypatch):
    monkeypatch.setenv("PIP_INDEX_URL", "file:///nowhere")
    monkeypatch.setenv("PIP_EXTRA_INDEX_URL", "")
    monkeypatch.setenv("PIP_FIND_LINKS", "")
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    with pytest.raises(RuntimeError, match="No matching distribution"):
        build.build(tmp_path)
    assert not list(tmp_path.iterdir())


# ---- rules of the extension guidelines


def test_files_name_their_licence(root):
    for path in (root / "blender_addon").iterdir():
        if path.suffix in (".py", ".toml"):
            assert "SPDX-License-Identifier: GPL-3.0-or-later" in path.read_text(), path.name


def test_imports_are_relative_or_of_blender_and_numpy(small_zip):
    allowed = set(sys.stdlib_module_names) | {"bpy", "bmesh", "numpy", "__future__"}
    for name, tree in sources(small_zip).items():
        for node in tree.body:
            if isinstance(node, ast.Import):
                assert {alias.name.split(".")[0] for alias in node.names} <= allowed, name
            if isinstance(node, ast.ImportFrom) and not node.level:
                assert node.module.split(".")[0] in allowed, name


def test_no_paths_no_network_no_processes(small_zip):
    forbidden = {"subprocess", "pip", "ensurepip", "urllib", "requests", "socket", "http", "site"}
    for name, tree in sources(small_zip).items():
        for node in ast.walk(tree):
            if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "sys":
                assert node.attr != "path", name
            assert not (isinstance(node, ast.Name) and node.id == "__file__"), name
            if isinstance(node, ast.Import):
                assert not {alias.name.split(".")[0] for alias in node.names} & forbidden, name
            if isinstance(node, ast.ImportFrom) and not node.level:
                assert node.module.split(".")[0] not in forbidden, name


def test_nothing_runs_at_import(small_zip):
    for name, tree in sources(small_zip).items():
        calls = [n for n in tree.body if isinstance(n, ast.Expr) and isinstance(n.value, ast.Call)]
        loops = [n for n in tree.body if isinstance(n, (ast.For, ast.While, ast.With))]
        assert not calls + loops, name
