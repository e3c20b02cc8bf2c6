"""`meshcore install paraview`: the packages that its Python lacks, and a plugin that loads at start.

What is put where, all of it for one version of ParaView, all of it removed by `uninstall_paraview`:

- a folder in the user's data folder with `packages/`, the plugin file, and two small files that start it;
- in the user's site-packages of ParaView's Python one line in a `.pth` file, which pvpython and pvbatch read at start;
- one entry in the list of plugins in ParaView's settings, which the window reads at start.
"""

from __future__ import annotations

import contextlib
import json
import re
import shutil
from pathlib import Path
from xml.sax.saxutils import quoteattr

from ..errors import InvalidInput, MeshcoreError
from . import packages, paraview_settings, places
from .host import Host, ask
from .packages import Say

PLUGIN = "meshcore_plugin"
_RECORD = "installed.json"


def install_paraview(pvpython: Path | None, say: Say) -> Path:
    """Install meshcore into a ParaView, for this user; an earlier installation is replaced.

    Parameters
    ----------
    pvpython : Path, optional
        ParaView's Python; searched for if None.
    say : callable
        Told what happens, a line at a time.

    Returns
    -------
    Path
        The folder that was made.

    Raises
    ------
    InvalidInput
        If there is no ParaView, or its Python or numpy is too old.
    MeshcoreError
        If pip or ParaView fails, or ParaView does not show the operations afterwards; nothing is left behind.
    """
    host = find(pvpython)
    folder = folder_of(host.version)
    source = places.adapter("paraview_plugin") / f"{PLUGIN}.py"
    if not source.is_file():
        raise InvalidInput(f"{source} is missing; `make paraview-plugin` writes it")
    say(f"{host.label} at {host.program}")
    if folder.is_dir():
        remove(folder, say)
        host = ask(host.program)  # what it has of its own, without what we had put there
    try:
        put = packages.put(host, folder / "packages", say)
        _copy_plugin(source, folder)
        record = register(host, folder, put)
        if missing := unseen(host):
            raise MeshcoreError(f"{host.label} started without {', '.join(missing)}; `meshcore doctor` tells more")
    except BaseException:  # Ctrl-C, too: half an installation is worse than none
        remove(folder, lambda line: None)
        raise
    say(f"put {', '.join(put)} into {folder}")
    for file in record["files"]:
        say(f"wrote {file}")
    for file in record["settings"]:
        say(f"added the plugin to {file}; ParaView must be closed meanwhile, or it writes its old list back")
    if not host.facts["user_site"]:
        say(f"this ParaView's Python reads no user's packages: for pvpython, set PV_PLUGIN_CONFIG_FILE={_list(folder)}")
    say("the operations are in Sources and Filters > meshcore from the next start on")
    say("to undo: meshcore uninstall paraview")
    return folder


def uninstall_paraview(say: Say) -> int:
    """Remove what `install_paraview` put anywhere, for every version; return how many versions there were."""
    folders = installed()
    for folder in folders:
        remove(folder, say)
    if not folders:
        say(f"nothing to undo: there is no {places.data_folder() / 'paraview-*'}")
    return len(folders)


def find(pvpython: Path | None) -> Host:
    """ParaView's Python, asked for what it is."""
    program = places.chosen(pvpython, places.pvpythons(), "ParaView", "pvpython")
    host = ask(program)
    if host.name != "paraview":
        raise InvalidInput(f"{program} is {host.label}'s Python, not ParaView's", parameter="pvpython")
    return host


def folder_of(version: str) -> Path:
    """Our folder for a version of ParaView."""
    return places.data_folder() / f"paraview-{version}"


def installed() -> list[Path]:
    """Our folders of all versions of ParaView."""
    return sorted(folder for folder in places.data_folder().glob("paraview-*") if folder.is_dir())


def register(host: Host, folder: Path, put: list[str]) -> dict[str, list[str]]:
    """Make ParaView load the plugin at start; return, and keep in the folder, what was changed outside of it."""
    record: dict[str, list[str]] = {"files": [], "settings": [], "folders": []}
    plugin = folder / f"{PLUGIN}.py"
    entry = f'<Plugin name="{PLUGIN}" filename={quoteattr(str(plugin))} auto_load="1" />'
    _list(folder).write_text(f'<?xml version="1.0"?>\n<Plugins>{entry}</Plugins>\n', encoding="utf-8")
    (folder / "start.py").write_text(_start(host, folder, put), encoding="utf-8")
    if host.facts["user_site"]:
        record["files"].append(str(Path(host.facts["user_site"]) / f"meshcore-paraview-{host.version}.pth"))
    window = window_of(host.program)
    if window:
        record["settings"].append(str(places.paraview_settings_folder() / f"ParaView{host.version}.ini"))
    for file in map(Path, record["files"] + record["settings"]):
        record["folders"] += [str(parent) for parent in file.parents if not parent.exists()]
    (folder / _RECORD).write_text(json.dumps(record, indent=1), encoding="utf-8")
    for file in map(Path, record["files"]):
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(_pth(host, folder / "start.py"), encoding="ascii")
    for file in map(Path, record["settings"]):
        text = paraview_settings.read(file)
        key = paraview_settings.settings_key(window)
        paraview_settings.write(file, paraview_settings.added(text, key, PLUGIN, plugin))
    return record


def remove(folder: Path, say: Say) -> None:
    """Undo `register` and delete the folder, if it is there."""
    if not folder.is_dir():
        return
    record_file = folder / _RECORD
    record = json.loads(record_file.read_text(encoding="utf-8")) if record_file.is_file() else {}
    for file in map(Path, record.get("files", [])):
        if file.is_file():
            file.unlink()
            say(f"removed {file}")
    for file in map(Path, record.get("settings", [])):
        text = paraview_settings.read(file)
        if (without := paraview_settings.removed(text, PLUGIN)) != text:
            paraview_settings.write(file, without)
            say(f"took the plugin out of {file}")
    shutil.rmtree(folder)
    say(f"removed {folder}")
    for made in sorted({*record.get("folders", []), str(folder.parent)}, key=len, reverse=True):
        with contextlib.suppress(OSError):
            Path(made).rmdir()  # only if nothing else has come into it


def unseen(host: Host) -> list[str]:
    """Labels of the operations that a fresh pvpython does not offer."""
    from ..operation import operations

    labels = [f"meshcore {operation.label}" for operation in operations().values()]
    offered = host.run("paraview_sees", json.dumps(labels))
    return [label for label in labels if label not in offered]


def window_of(pvpython: Path) -> Path | None:
    """The ParaView with a window that stands beside a pvpython."""
    folder = pvpython.resolve().parent
    names = [folder / f"paraview{pvpython.suffix}", folder.parent / "MacOS" / "paraview"]
    return next((name for name in names if name.is_file()), None)


def _copy_plugin(source: Path, folder: Path) -> None:
    """The plugin under its file's name: ParaView's window forgets that any other loads at start."""
    text = source.read_text(encoding="utf-8")
    text = re.sub(r"^paraview_plugin_name = .*$", f'paraview_plugin_name = "{PLUGIN}"', text, flags=re.MULTILINE)
    (folder / f"{PLUGIN}.py").write_text(text, encoding="utf-8")


def _list(folder: Path) -> Path:
    return folder / "plugins.xml"


def _pth(host: Host, start: Path) -> str:
    """A line that Python runs at start; it does nothing in any Python but ParaView's, or when our folder is gone."""
    here = ascii(str(Path(host.facts["executable"]).parent))
    return (
        f"import os, sys; start = {str(start)!a}; os.path.dirname(sys.executable) == {here} "
        "and os.path.isfile(start) and exec(compile(open(start, encoding='utf-8').read(), start, 'exec'))\n"
    )


def _start(host: Host, folder: Path, put: list[str]) -> str:
    """What ParaView's Python does before ParaView looks for plugins."""
    lines = [
        "# Written by `meshcore install paraview`, removed by `meshcore uninstall paraview`.",
        "import os",
        f"plugins = {str(_list(folder))!a}",
        "given = os.environ.get('PV_PLUGIN_CONFIG_FILE')",
        "if not given or plugins not in given.split(os.pathsep):",
        "    os.environ['PV_PLUGIN_CONFIG_FILE'] = given + os.pathsep + plugins if given else plugins",
    ]
    if any(host.libraries.get(item.split("==")[0]) for item in put):
        lines += ["import sys", f"sys.path.insert(0, {str(folder / 'packages')!a})  # newer than the host's own"]
    if not host.facts["getargspec"]:
        lines += [
            "# ParaView up to 5.11 asks for a function that Python 3.11 dropped, and loads no Python plugin without.",
            "import inspect",
            "inspect.__dict__.setdefault('getargspec', inspect.getfullargspec)",
        ]
    return "\n".join(lines) + "\n"
