"""`meshcore install blender`: builds the extension's zip for that Blender, and lets Blender itself install it."""

from __future__ import annotations

import importlib.util
import subprocess
import tempfile
from pathlib import Path
from types import ModuleType
from typing import Any

from ..errors import InvalidInput, MeshcoreError
from . import places
from .host import Host, ask
from .packages import Say

EXTENSION = "meshcore"
_SCRIPT = "blender_extension"
_PLATFORMS = {"linux": "linux", "win": "windows", "macosx": "macos"}
_MACHINES = {"x86_64": "x64", "amd64": "x64", "arm64": "arm64", "aarch64": "arm64"}


def install_blender(blender: Path | None, say: Say) -> Path:
    """Build the extension for a Blender and install it there, enabled.

    Parameters
    ----------
    blender : Path, optional
        Blender's program, or a Python that has the bpy module; searched for if None.
    say : callable
        Told what happens, a line at a time.

    Returns
    -------
    Path
        The folder in which Blender keeps the extension.

    Raises
    ------
    InvalidInput
        If there is no Blender, or none that the extension supports.
    MeshcoreError
        If pip, the build or Blender fails.
    """
    host = find(blender)
    say(f"{host.label} at {host.program}, Python {host.python_version}")
    builder = _builder()
    with tempfile.TemporaryDirectory() as folder:
        say(f"building the extension for Python {host.python_version} on {platform_of(host)}")
        try:
            zip_file = builder.build(folder, python=host.python_version, platform=platform_of(host))
        except ValueError as error:
            raise InvalidInput(f"{host.label}: {error}") from None
        except RuntimeError as error:
            raise MeshcoreError(str(error)) from None
        say(f"installing {zip_file.name} ({zip_file.stat().st_size / 1e6:.0f} MB)")
        state = _install(host, zip_file)
    if not (state["present"] and state["enabled"]):
        raise MeshcoreError(f"{host.label} took the extension but did not enable it; start it to see its message")
    say(f"installed and enabled in {state['folder']}")
    say("to undo: meshcore uninstall blender, or Edit > Preferences > Add-ons > meshcore > Uninstall")
    return Path(state["folder"])


def uninstall_blender(blender: Path | None, say: Say) -> bool:
    """Let Blender remove the extension; return whether it was there."""
    host = find(blender)
    before = state_of(host)
    if not before["present"]:
        say(f"nothing to undo: {host.label} has no {before['folder']}")
        return False
    if _is_program(host):
        _command(host, "remove", f"user_default.{EXTENSION}")
        after = state_of(host)
    else:
        after = host.run(_SCRIPT, "remove", EXTENSION)
    if after["present"]:
        raise MeshcoreError(f"{host.label} did not remove {after['folder']}; close Blender and try again")
    say(f"{host.label} removed {after['folder']}")
    return True


def find(blender: Path | None) -> Host:
    """A Blender, or a Python with bpy, asked for what it is."""
    program = places.chosen(blender, places.blenders(), "Blender", "blender")
    host = ask(program)
    if host.name != "blender":
        raise InvalidInput(f"{program} is {host.label}'s Python, not Blender's", parameter="blender")
    return host


def state_of(host: Host) -> dict[str, Any]:
    """Whether the extension is there, enabled, and finds its libraries."""
    return host.run(_SCRIPT, "state", EXTENSION)


def platform_of(host: Host) -> str:
    """A host's platform in the words of Blender's manifests: ``linux-x64``.

    Raises
    ------
    InvalidInput
        If the extension is not built for it.
    """
    system = host.facts["platform"].replace("_", "-").split("-")[0].rstrip("3264")
    machine = host.facts["machine"].lower()
    if system not in _PLATFORMS or machine not in _MACHINES:
        raise InvalidInput(f"{host.label}: the extension is not built for {host.facts['platform']}")
    return f"{_PLATFORMS[system]}-{_MACHINES[machine]}"


def _install(host: Host, zip_file: Path) -> dict[str, Any]:
    if not _is_program(host):
        return host.run(_SCRIPT, "install", EXTENSION, str(zip_file))
    _command(host, "install-file", "--repo", "user_default", "--enable", str(zip_file))
    return state_of(host)


def _is_program(host: Host) -> bool:
    return host.program.stem.lower().startswith("blender")


def _command(host: Host, *words: str) -> None:
    """Blender's own command line for extensions."""
    command = [str(host.program), "--command", "extension", *words]
    done = subprocess.run(command, capture_output=True, text=True, stdin=subprocess.DEVNULL)
    if done.returncode:
        said = (done.stderr or done.stdout).strip().splitlines()
        raise MeshcoreError(f"{host.label} failed: {' / '.join(said[-2:]) or 'no output'}")


def _builder() -> ModuleType:
    """The add-on's build script, which stands with its sources and is in no package."""
    script = places.adapter("blender_addon") / "build.py"
    specification = importlib.util.spec_from_file_location("meshcore_blender_build", script)
    if specification is None or not script.is_file():
        raise InvalidInput(f"{script} is missing; install meshcore anew")
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module
