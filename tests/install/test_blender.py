"""`meshcore install blender` in a clean home: installed, enabled, kept, used by a fresh Blender, removed."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from meshcore.errors import InvalidInput
from meshcore.install import blender, host
from tests.install.homes import Home, new_home

PREFERENCE = """
import bpy
bpy.context.preferences.view.show_splash = False
bpy.ops.wm.save_userpref()
"""
LOOK = """
import bpy
bpy.ops.wm.read_userpref()
made = None
if "bl_ext.user_default.meshcore" in bpy.context.preferences.addons:
    bpy.ops.mesh.primitive_plane_add(size=2)
    bpy.ops.meshcore.transfinite(cells_i=4, cells_j=3)
    made = len(bpy.context.view_layer.objects.active.data.polygons)
import json
print("LOOK", json.dumps([bpy.context.preferences.view.show_splash, made]))
"""
# What Blender's own program does with these words, by the parts of it that the bpy module carries.
PROGRAM = """#!{python}
import runpy, sys
import bpy
bpy.ops.wm.read_userpref()
words = sys.argv[1:]
if words[:2] == ["--command", "extension"]:
    import addon_utils
    from bl_pkg import bl_extension_cli
    sys.exit(bl_extension_cli.cli_extension_handler(words[2:]))
assert words[:4] == ["--background", "--python-exit-code", "1", "--python"] and words[5] == "--", words
runpy.run_path(words[4], run_name="__main__")
"""


def pythons(root: Path) -> list[Path]:
    """Those with bpy, made by tests/environments.py."""
    return sorted(root.glob(".envs/blender-*/bin/python"))


def pytest_generate_tests(metafunc):
    if "python" in metafunc.fixturenames:
        found = pythons(Path(__file__).resolve().parent.parent.parent)
        assert found, "no Python with bpy: python3 tests/environments.py blender-5.0"
        metafunc.parametrize("python", found, ids=lambda path: path.parent.parent.name, scope="module")


def look(home: Home, python: Path) -> list:
    """A fresh Blender: its splash screen's preference, and the faces of a patch that it makes."""
    script = home.folder.parent / "look.py"
    script.write_text(LOOK)
    done = home.run(python, script)
    told = [line for line in done.stdout.splitlines() if line.startswith("LOOK ")]
    assert told, done.stderr
    return json.loads(told[0][5:])


def state(home: Home, program: Path) -> dict[str, str]:
    """What doctor finds of Blender."""
    findings = json.loads(home.meshcore("doctor", "--json", "--pvpython", "/none", "--blender", program).stdout)
    return {row["check"]: row["state"] for row in findings if row["subject"].startswith("Blender")}


def whole_path(home: Home, python: Path, program: Path) -> None:
    """Install, look, use, remove, remove again; the user's own preference stays."""
    script = home.folder.parent / "preference.py"
    script.write_text(PREFERENCE)
    assert home.run(python, script).returncode == 0
    assert look(home, python) == [False, None]
    assert state(home, program) == {"Python": "ok", "extension": "fails"}
    done = home.meshcore("install", "blender", "--blender", program)
    assert done.returncode == 0, done.stderr
    folder = home.folder / "blender/extensions/user_default/meshcore"
    assert str(folder) in done.stdout and "meshcore uninstall blender" in done.stdout
    assert folder.is_dir() and not list(home.folder.rglob("numpy-*.dist-info"))
    assert state(home, program) == {"Python": "ok", "extension": "ok", "enabled": "ok", "libraries": "ok"}
    assert look(home, python) == [False, 12]
    done = home.meshcore("uninstall", "blender", "--blender", program)
    assert done.returncode == 0, done.stderr
    assert not folder.exists() and not list(home.folder.rglob("site-packages/numba"))
    assert look(home, python) == [False, None]
    again = home.meshcore("uninstall", "blender", "--blender", program)
    assert again.returncode == 0 and "nothing to undo" in again.stdout


def test_by_a_python_with_bpy(python, tmp_path_factory):
    whole_path(new_home(tmp_path_factory.mktemp("blender") / ""), python, python)


def test_by_blenders_own_command_line(root, tmp_path_factory):
    home, python = new_home(tmp_path_factory.mktemp("blender") / ""), pythons(root)[-1]
    program = home.folder / "bin" / "blender"
    program.parent.mkdir()
    program.write_text(PROGRAM.format(python=python))
    program.chmod(0o755)
    whole_path(home, python, program)


def test_programs_that_are_no_blender(home):
    for program, fault in (("/no/blender", "there is no such program"), ("pvpython", "not Blender's")):
        done = home.meshcore("install", "blender", "--blender", program)
        assert done.returncode == 1 and fault in done.stderr and done.stderr.count("\n") == 1


@pytest.mark.parametrize(
    ("platform", "machine", "name"),
    [
        ("linux-x86_64", "x86_64", "linux-x64"),
        ("win-amd64", "AMD64", "windows-x64"),
        ("macosx-11.0-arm64", "arm64", "macos-arm64"),
        ("macosx-10.15-x86_64", "x86_64", "macos-x64"),
    ],
)
def test_platforms_in_blenders_words(platform, machine, name):
    facts = {"platform": platform, "machine": machine}
    assert blender.platform_of(host.Host(Path("b"), "blender", "5.0", (3, 11), {}, facts)) == name


def test_a_platform_without_an_extension_is_refused():
    facts = {"platform": "freebsd-14-riscv64", "machine": "riscv64"}
    with pytest.raises(InvalidInput, match="not built for freebsd-14-riscv64"):
        blender.platform_of(host.Host(Path("b"), "blender", "5.0", (3, 11), {}, facts))
