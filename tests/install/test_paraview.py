"""`meshcore install paraview` in a clean home: what it puts where, what ParaView then shows, and what is left."""

from __future__ import annotations

import json
import re
import shutil
import sys
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import NamedTuple

import pytest

import meshcore as mc
from meshcore import install
from meshcore.errors import InvalidInput, MeshcoreError
from meshcore.install import host, packages, paraview, places
from tests.display import DISPLAY
from tests.install.homes import Home, new_home

OTHER = r"  <Plugin name=\"Other\" filename=\"/opt/other.so\" auto_load=\"1\" />\n"
SETTINGS = rf"""[General]
CustomFilters=<CustomFilterDefinitions/>\n

[PluginsList]
Local%3A\usr\bin\paraview="<?xml version=\"1.0\" ?>\n<Plugins>\n{OTHER}</Plugins>\n"
cs%3A\\server%3A11111%3A\usr\bin\paraview="<?xml version=\"1.0\" ?>\n<Plugins>\n{OTHER}</Plugins>\n"

[pqMultiBlockInspectorWidget]
ShowHints=true
"""
OFFERED = """
import paraview.simple as simple, sys
print("OFFERED", *[name for name in dir(simple) if name.startswith("meshcore")])
print("PYTHONPATH", [path for path in sys.path if "packages" in path])
"""
MESHES = """
import paraview.simple as simple
loop = simple.PolyLineSource(Points=[0, 0, 0, 2, 0, 0, 2, 1, 0, 0, 1, 0], Closed=1)
grid = simple.meshcoreTransfiniteInterpolation(South=loop, CellsI=5, CellsJ=4)
grid.UpdatePipeline()
print("CELLS", grid.GetDataInformation().GetNumberOfCells())
import numpy, scipy, numba
print("NUMPY", numpy.__file__)
print("NUMBA", numba.__file__)
"""
WINDOW = """
import paraview.simple as simple
with open({file!r}, "w") as file:
    print("OFFERED", *[name for name in dir(simple) if name.startswith("meshcore")], file=file)
"""


class Installed(NamedTuple):
    """A home before and after an installation, and what was said."""

    home: Home
    before: dict[str, bytes]
    said: str


def offered(home: Home) -> set[str]:
    """What a fresh pvpython shows of meshcore."""
    script = home.folder.parent / "offered.py"
    script.write_text(OFFERED)
    done = home.run("pvpython", script)
    assert done.returncode == 0, done.stderr
    return set(next(line for line in done.stdout.splitlines() if line.startswith("OFFERED")).split()[1:])


def wanted() -> set[str]:
    return {"meshcore" + entry.label.replace(" ", "").replace("-", "") for entry in mc.operations().values()}


@pytest.fixture(scope="module")
def installed(tmp_path_factory) -> Installed:
    """A home with settings of its user's own, into which meshcore was installed twice."""
    home = new_home(tmp_path_factory.mktemp("paraview") / "")
    version = host.ask(places.pvpythons()[0]).version
    settings = home.folder / f".config/ParaView/ParaView{version}.ini"
    settings.parent.mkdir(parents=True)
    settings.write_text(SETTINGS)
    (home.folder / ".local/share/meshcore").mkdir(parents=True)
    (home.folder / ".local/share/meshcore/notes.txt").write_text("the user's own")
    before = home.files()
    assert not offered(home)
    first = home.meshcore("install", "paraview")
    assert first.returncode == 0, first.stderr
    return Installed(home, before, first.stdout)


def folder_of(home: Home) -> Path:
    return next((home.folder / ".local/share/meshcore").glob("paraview-*"))


def test_it_says_what_it_did_and_how_to_undo_it(installed):
    for path in (
        folder_of(installed.home),
        *installed.home.folder.rglob("*.pth"),
        *installed.home.folder.rglob("*.ini"),
    ):
        assert str(path) in installed.said
    assert "meshcore uninstall paraview" in installed.said and "numba==" in installed.said


def test_a_fresh_pvpython_shows_and_runs_the_operations(installed, tmp_path):
    assert wanted() <= offered(installed.home)
    script = tmp_path / "meshes.py"
    script.write_text(MESHES)
    done = installed.home.run("pvpython", script)
    told = dict(line.split(maxsplit=1) for line in done.stdout.splitlines() if line.split()[0].isupper())
    assert told["CELLS"] == "20", done.stderr
    assert str(installed.home.folder) in told["NUMBA"] and str(installed.home.folder) not in told["NUMPY"]


def test_pvbatch_shows_the_operations_too(installed, tmp_path):
    script = tmp_path / "offered.py"
    script.write_text(OFFERED)
    done = installed.home.run("pvbatch", script)
    assert wanted() <= set(done.stdout.split())


def test_the_window_loads_the_plugin_at_start_and_keeps_it(installed, tmp_path):
    home = new_home(tmp_path / "")
    ignored = shutil.ignore_patterns("packages")
    shutil.copytree(installed.home.folder, home.folder, ignore=ignored, dirs_exist_ok=True)
    script, file = tmp_path / "window.py", tmp_path / "window.txt"
    script.write_text(WINDOW.format(file=str(file)))
    command = [*DISPLAY, "paraview", f"--script={script}", "--exit", f"--test-directory={tmp_path}"]
    home.run(*command)
    assert wanted() <= set(file.read_text().split())
    file.unlink()
    home.run(*command)  # the window has written its settings anew
    assert wanted() <= set(file.read_text().split())


def test_only_what_was_lacking_is_put_there(installed):
    names = {path.name for path in (folder_of(installed.home) / "packages").iterdir()}
    assert {"numba", "llvmlite", "meshcore"} <= names
    assert not {"numpy", "scipy"} & names


def test_the_settings_keep_all_that_was_there(installed):
    text = next(installed.home.folder.rglob("*.ini")).read_text()
    lost = [line for line in SETTINGS.splitlines() if line not in text]
    assert lost == [SETTINGS.splitlines()[4]]  # the list that has one plugin more
    quoted = re.search(r'^Local.*?="(.*)"$', text, flags=re.MULTILINE).group(1)
    plugins = ET.fromstring(quoted.replace(r"\"", '"').replace(r"\n", "\n"))
    assert [plugin.get("name") for plugin in plugins] == ["Other", "meshcore_plugin"]
    assert Path(plugins[1].get("filename")).is_file() and plugins[1].get("auto_load") == "1"


def test_other_pythons_are_left_alone(installed):
    code = "import os, inspect, sys; print(os.environ.get('PV_PLUGIN_CONFIG_FILE'), sys.path)"
    done = installed.home.run("python3", "-c", code)
    assert done.stdout.startswith("None ") and "packages" not in done.stdout.replace("-packages", "")


def test_doctor_finds_it_in_order(installed):
    words = [*DISPLAY, *installed.home.meshcore("--version").args[:3], "doctor", "--json"]
    findings = json.loads(installed.home.run(*words).stdout)
    states = {row["check"]: row["state"] for row in findings if row["subject"].startswith("ParaView")}
    assert states == dict.fromkeys(["Python", "operations at start", "meshcore and numba", "picture"], "ok"), findings


def test_installing_again_replaces_it_and_uninstalling_leaves_nothing(installed):
    again = installed.home.meshcore("install", "paraview")
    assert again.returncode == 0, again.stderr
    assert wanted() <= offered(installed.home)
    done = installed.home.meshcore("uninstall", "paraview")
    assert done.returncode == 0, done.stderr
    assert installed.home.files() == installed.before
    assert not offered(installed.home)
    nothing = installed.home.meshcore("uninstall", "paraview")
    assert nothing.returncode == 0 and "nothing to undo" in nothing.stdout


# ---- what cannot be


def fake_host(**changes) -> host.Host:
    libraries = {"numpy": "1.26.4", "scipy": None, "numba": None, "llvmlite": None, "meshcore": None}
    libraries |= changes.pop("libraries", {})
    facts = {"abi": "cpython-311-x86_64-linux-gnu", "glibc": "2.36", "machine": "x86_64", "macos": ""}
    python = changes.pop("python", (3, 11, 2))
    return host.Host(Path("pvpython"), "paraview", "5.13.0", python, libraries, facts | changes)


def test_a_python_that_is_too_old_is_refused():
    with pytest.raises(InvalidInput, match=r"Python 3\.9; meshcore needs 3\.10"):
        packages.present(fake_host(python=(3, 9, 5)))


def test_a_numpy_that_is_too_old_is_refused_not_replaced():
    with pytest.raises(InvalidInput, match=r"has numpy 1\.21\.1; meshcore needs 1\.24"):
        packages.present(fake_host(libraries={"numpy": "1.21.1"}))


def test_a_scipy_that_is_too_old_or_broken_is_lacking():
    assert packages.present(fake_host(libraries={"scipy": "1.9.3"})) == {"numpy": "1.26.4"}
    assert packages.present(fake_host(libraries={"scipy": "broken: numpy.core"})) == {"numpy": "1.26.4"}


def test_what_is_lacking_fits_the_numpy_that_is_there():
    names = {item.split("==")[0] for item in packages.lacking(fake_host())}
    assert names == {"scipy", "numba", "llvmlite"}
    assert packages.lacking(fake_host(libraries={"scipy": "1.11.0", "numba": "0.60.0"})) == []


def test_what_no_index_has_is_an_error_in_pips_words():
    with pytest.raises(MeshcoreError, match="pip failed: ERROR"):
        packages.lacking(fake_host(libraries={"numpy": "97.5.0"}))


def test_the_floors_are_the_packages_own(root):
    text = (root / "pyproject.toml").read_text()
    dependencies = re.search(r"^dependencies = (\[.*\])$", text, flags=re.MULTILINE).group(1)
    assert json.loads(dependencies) == [f"{name}>={floor}" for name, floor in packages.FLOORS.items()]
    assert f'requires-python = ">={".".join(map(str, packages.PYTHON_FLOOR))}"' in text


@pytest.mark.parametrize(
    ("program", "fault"),
    [
        ("/no/such/pvpython", "there is no such program"),
        ("{python}", "neither ParaView's nor"),
        ("{file}", "does not run"),
    ],
)
def test_a_program_that_is_no_paraview(home, program, fault):
    file = home.folder / "pvpython"
    file.write_text("no program")
    before = home.files()
    done = home.meshcore("install", "paraview", "--pvpython", program.format(file=file, python=sys.executable))
    assert done.returncode == 1 and fault in done.stderr and done.stderr.count("\n") == 1
    assert home.files() == before


@pytest.mark.parametrize("step", ["packages.put", "paraview.register", "paraview.unseen"])
def test_a_failure_on_the_way_leaves_nothing(step, tmp_path, monkeypatch):
    def fails(*args):
        raise MeshcoreError("the network is gone")

    for name in ("MESHCORE_DATA_DIR", "XDG_CONFIG_HOME", "HOME"):
        monkeypatch.setenv(name, str(tmp_path / name))
    monkeypatch.setattr(packages, "put", lambda host, folder, say: folder.mkdir(parents=True) or ["numba==1"])
    monkeypatch.setattr(paraview, "unseen", lambda host: [])
    monkeypatch.setattr(f"meshcore.install.{step}", fails)
    with pytest.raises(MeshcoreError, match="network is gone"):
        install.install_paraview(None, lambda line: None)
    assert not [path for path in tmp_path.rglob("*") if path.is_file() and ".cache" not in path.parts]
    assert not (tmp_path / "MESHCORE_DATA_DIR").exists()


def test_a_paraview_without_the_operations_after_all_is_an_error(tmp_path, monkeypatch):
    for name in ("MESHCORE_DATA_DIR", "XDG_CONFIG_HOME", "HOME"):
        monkeypatch.setenv(name, str(tmp_path / name))
    monkeypatch.setattr(packages, "put", lambda host, folder, say: folder.mkdir(parents=True) or [])
    monkeypatch.setattr(paraview, "unseen", lambda host: ["Transfinite Interpolation"])
    with pytest.raises(MeshcoreError, match="started without Transfinite Interpolation"):
        install.install_paraview(None, lambda line: None)
    assert not (tmp_path / "MESHCORE_DATA_DIR").exists()
