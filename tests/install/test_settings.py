"""Editing ParaView's list of plugins leaves every other byte as it was."""

from __future__ import annotations

from pathlib import Path, PureWindowsPath

import pytest

from meshcore.install import paraview_settings as settings

KEY = settings.settings_key(Path("/usr/bin/paraview"))
XML = r"<?xml version=\"1.0\" ?>\n<Plugins>\n"
ONE = XML + r"  <Plugin name=\"Other\" filename=\"/o.so\" auto_load=\"0\" />\n</Plugins>\n"
TEXTS = {
    "none": "",
    "other section": "[General]\na=1\n",
    "other program": f'[PluginsList]\nLocal%3A\\opt\\paraview="{ONE}"\n',
    "other plugin": f'[A]\nb=2\n\n[PluginsList]\n{KEY}="{ONE}"\n\n[Z]\nc=3\n',
    "list at the start": f'[PluginsList]\n{KEY}="{ONE}"\n\n[Z]\nc=3\n',
    "remote list": f'[PluginsList]\ncs%3A\\\\host="{ONE}"\n',
    "bytes": '[Main]\nLayout="@ByteArray(\\0\\0\\0\\xff\xe9)"\n',
}


@pytest.mark.parametrize("text", TEXTS.values(), ids=TEXTS.keys())
def test_adding_and_removing_is_nothing(text):
    added = settings.added(text, KEY, "meshcore_plugin", Path("/home/x/meshcore_plugin.py"))
    assert added.count("meshcore_plugin.py") == 1 and added.count(f"{KEY}=") == 1
    assert added.count(settings.SECTION) == 1
    assert [line for line in text.splitlines() if line not in added.splitlines() and not line.startswith(KEY)] == []
    assert settings.removed(added, "meshcore_plugin") == text


@pytest.mark.parametrize("text", TEXTS.values(), ids=TEXTS.keys())
def test_adding_twice_is_adding_once(text):
    once = settings.added(text, KEY, "meshcore_plugin", Path("/old/meshcore_plugin.py"))
    assert settings.added(once, KEY, "meshcore_plugin", Path("/old/meshcore_plugin.py")) == once
    moved = settings.added(once, KEY, "meshcore_plugin", Path("/new/meshcore_plugin.py"))
    assert "/old/" not in moved and moved.count("/new/") == 1


@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_files_keep_their_bytes_and_rights(newline, tmp_path):
    file = tmp_path / "ParaView5.11.0.ini"
    before = TEXTS["bytes"].replace("\n", newline).encode("latin-1")
    file.write_bytes(before)
    file.chmod(0o600)
    settings.write(file, settings.added(settings.read(file), KEY, "demo", Path("/d.py")))
    assert b"demo" in file.read_bytes() and (b"\r\n" in file.read_bytes()) == (newline == "\r\n")
    assert file.stat().st_mode & 0o777 == 0o600
    settings.write(file, settings.removed(settings.read(file), "demo"))
    assert file.read_bytes() == before and list(tmp_path.iterdir()) == [file]


def test_a_file_that_we_made_goes_away(tmp_path):
    file = tmp_path / "new" / "ParaView5.11.0.ini"
    settings.write(file, settings.added(settings.read(file), KEY, "demo", Path("/d.py")))
    assert file.is_file()
    settings.write(file, settings.removed(settings.read(file), "demo"))
    assert not file.exists()


def test_names_in_qts_letters():
    windows = PureWindowsPath("C:/Program Files/ParaView 5.13/bin/paraview.exe")
    assert settings.settings_key(windows) == r"Local%3AC%3A\Program%20Files\ParaView%205.13\bin\paraview.exe"
    assert settings.settings_key(Path("/opt/é/ﬁ")) == r"Local%3A\opt\%E9\%UFB01"


def test_awkward_folders_stay_xml_and_ascii():
    added = settings.added("", KEY, "demo", Path('/a & "b" <ü>/d.py'))
    assert "/a &amp; &quot;b&quot; &lt;&#252;>/d.py" in added and added.isascii()
