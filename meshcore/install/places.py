"""Where things are: the sources of the host adapters, the user's folders, the hosts' programs."""

from __future__ import annotations

import glob
import os
import shutil
import sys
from collections.abc import Iterable
from pathlib import Path

from ..errors import InvalidInput

PACKAGE = Path(__file__).resolve().parent.parent

_PVPYTHON = {
    "linux": ["/usr/bin/pvpython", "/opt/[Pp]ara[Vv]iew*/bin/pvpython", "~/[Pp]ara[Vv]iew*/bin/pvpython"],
    "darwin": [
        "/Applications/ParaView*.app/Contents/bin/pvpython",
        "~/Applications/ParaView*.app/Contents/bin/pvpython",
    ],
    "win32": ["C:/Program Files/ParaView*/bin/pvpython.exe"],
}
_BLENDER = {
    "linux": ["/usr/bin/blender", "/opt/blender*/blender", "~/blender*/blender", "/snap/bin/blender"],
    "darwin": ["/Applications/Blender*.app/Contents/MacOS/Blender"],
    "win32": ["C:/Program Files/Blender Foundation/Blender*/blender.exe"],
}


def adapter(name: str) -> Path:
    """Folder of a host adapter's sources: in a checkout beside the package, in an installed package within it.

    Raises
    ------
    InvalidInput
        If this copy of meshcore came without it.
    """
    for folder in (PACKAGE.parent / name, PACKAGE / "_hosts" / name):
        if folder.is_dir():
            return folder
    raise InvalidInput(f"this copy of meshcore has no {name}; install meshcore anew with pip")


def data_folder() -> Path:
    """The user's folder for what meshcore installs: ``MESHCORE_DATA_DIR``, or as the system has it."""
    if folder := os.environ.get("MESHCORE_DATA_DIR"):
        return Path(folder)
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local") / "meshcore"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Application Support" / "meshcore"
    return Path(os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share") / "meshcore"


def paraview_settings_folder() -> Path:
    """Where ParaView keeps its settings."""
    if sys.platform == "win32":
        return Path(os.environ.get("APPDATA") or Path.home() / "AppData" / "Roaming") / "ParaView"
    return Path(os.environ.get("XDG_CONFIG_HOME") or Path.home() / ".config") / "ParaView"


def pvpythons() -> list[Path]:
    """Every ParaView's Python on PATH and in the usual folders, newest name first."""
    return _programs("pvpython", _PVPYTHON.get(sys.platform, []))


def blenders() -> list[Path]:
    """Every Blender on PATH and in the usual folders, newest name first."""
    return _programs("blender", _BLENDER.get(sys.platform, []))


def chosen(given: Path | None, found: list[Path], program: str, option: str) -> Path:
    """The program that the user named, or the first that was found.

    Raises
    ------
    InvalidInput
        If there is none.
    """
    if given is not None:
        path = Path(shutil.which(str(given)) or given).expanduser().absolute()
        if not path.is_file():
            raise InvalidInput(f"{given}: there is no such program", parameter=option)
        return path
    if not found:
        raise InvalidInput(f"found no {program} on PATH or in the usual folders; tell where it is by --{option} PATH")
    return found[0]


def _programs(name: str, patterns: Iterable[str]) -> list[Path]:
    on_path = shutil.which(name)
    paths = [on_path] if on_path else []
    for pattern in patterns:
        paths += sorted(glob.glob(os.path.expanduser(pattern)), reverse=True)
    different: dict[Path, Path] = {}
    for path in paths:
        different.setdefault(Path(path).resolve(), Path(path))
    return list(different.values())
