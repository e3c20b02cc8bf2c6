"""`meshcore doctor`: what works in each host, what does not, and the cure."""

from __future__ import annotations

import importlib.util
import os
import platform
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

from .. import __version__
from ..errors import MeshcoreError
from ..progress import Progress, advance, silent
from . import blender, packages, paraview, places
from .host import Host

_EXTRAS = {
    "meshio": "file formats of other meshers",
    "h5py": "CGNS files",
    "pyvista": "pictures",
    "rich": "a better progress bar",
}
_DRAW = "import sys; from meshcore import gallery; from meshcore.picture import picture; "
_DRAW += "picture(gallery.triangulated_square(2), sys.argv[1], window=(64, 64))"


class Finding(NamedTuple):
    """One thing that was tried.

    Attributes
    ----------
    subject : str
        meshcore, or a host by name and version.
    check : str
        What was tried.
    state : {"ok", "fails", "absent"}
        "absent" is for what is optional or not on this machine; only "fails" is a fault.
    detail : str
        What was found, and the cure where something fails.
    """

    subject: str
    check: str
    state: str
    detail: str


def doctor(
    pvpython: Path | None = None, blender_program: Path | None = None, progress: Progress = silent
) -> list[Finding]:
    """Try what works here: meshcore itself, each ParaView, each Blender, MeshLab.

    Parameters
    ----------
    pvpython, blender_program : Path, optional
        Only this ParaView, only this Blender; by default all that are found.
    progress : Progress
        Called with fraction and message.

    Returns
    -------
    list of Finding
        All that was tried; nothing raises because a host is broken.
    """
    steps: list[tuple[str, Callable[[], Iterator[Finding]]]] = [("meshcore", _itself)]
    for program in [pvpython] if pvpython else places.pvpythons() or [None]:
        steps.append(("ParaView", lambda program=program: _paraview(program)))
    for program in [blender_program] if blender_program else places.blenders() or [None]:
        steps.append(("Blender", lambda program=program: _blender(program)))
    steps.append(("MeshLab", _meshlab))
    findings = []
    for number, (name, look) in enumerate(steps):
        advance(progress, number / len(steps), f"looking at {name}")
        findings += look()
    return findings


def _itself() -> Iterator[Finding]:
    subject = f"meshcore {__version__}"
    yield Finding(subject, "Python", "ok", f"{platform.python_version()} at {sys.executable}")
    yield _tried(subject, "kernels", _compiles, "reinstall numba: pip install --force-reinstall numba")
    yield _tried(subject, "kernel cache", _cache, "set MESHCORE_CACHE_DIR to a folder that can be written")
    for name, purpose in _EXTRAS.items():
        found = importlib.util.find_spec(name) is not None
        state, detail = ("ok", purpose) if found else ("absent", f"pip install {name}: {purpose}")
        yield Finding(subject, name, state, detail)
    if importlib.util.find_spec("pyvista"):
        yield _tried(subject, "picture", _picture, "install libgl1 and libegl1, or run under xvfb-run -a")


def _compiles() -> str:
    import numba

    from ..gallery import arguments
    from ..operation import operations

    positional, keywords = arguments("refined")
    operations()["refined"].function(*positional, **keywords)
    return f"numba {numba.__version__}"


def _cache() -> str:
    from .._numba import _user_cache, cache_folder

    if _user_cache() not in cache_folder().parents:
        raise MeshcoreError(f"{_user_cache()} cannot be written, so {cache_folder()} is used")
    return str(cache_folder())


def _picture() -> str:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "picture.png"
        # In a process of its own, since VTK ends the process where it cannot draw.
        done = subprocess.run([sys.executable, "-c", _DRAW, str(file)], capture_output=True, text=True, timeout=120)
        if done.returncode or not file.is_file():
            raise MeshcoreError((done.stderr.strip().splitlines() or [f"exit code {done.returncode}"])[-1])
    return "drawn without a window"


def _paraview(program: Path | None) -> Iterator[Finding]:
    if program is None:
        yield Finding("ParaView", "found", "absent", "no pvpython on PATH or in the usual folders; --pvpython PATH")
        return
    try:
        host = paraview.find(program)
        usable = packages.present(host)
    except MeshcoreError as error:
        yield Finding("ParaView", "found", "fails", str(error))
        return
    yield Finding(host.label, "Python", "ok", f"{host.python_version} at {host.program}, {_versions(usable)}")
    folder = paraview.folder_of(host.version)
    cure = "meshcore install paraview"
    yield _tried(host.label, "operations at start", lambda: _offered(host, folder), cure)
    yield _tried(host.label, "meshcore and numba", lambda: _runs(host, folder), cure)
    yield _draws(host)


def _offered(host: Host, folder: Path) -> str:
    if missing := paraview.unseen(host):
        if not host.facts["getargspec"] and not folder.is_dir():
            raise MeshcoreError("it loads no Python plugin at all, since its Python has no inspect.getargspec")
        raise MeshcoreError(f"without {', '.join(missing)}")
    return "all"


def _runs(host: Host, folder: Path) -> str:
    told: dict[str, Any] = host.run("paraview_works", str(folder / "packages"))
    if told["meshcore"] != __version__:
        raise MeshcoreError(f"it has meshcore {told['meshcore']}, this is {__version__}")
    return f"numba {told['numba']}, kernels in {told['cache']}"


def _draws(host: Host) -> Finding:
    with tempfile.TemporaryDirectory() as folder:
        try:
            host.run("paraview_draws", str(Path(folder) / "picture.png"), timeout=120)
        except MeshcoreError as error:
            if sys.platform.startswith("linux") and not os.environ.get("DISPLAY"):
                return Finding(host.label, "picture", "absent", "there is no display; run it under xvfb-run -a")
            return Finding(host.label, "picture", "fails", str(error))
    return Finding(host.label, "picture", "ok", "drawn")


def _blender(program: Path | None) -> Iterator[Finding]:
    if program is None:
        yield Finding("Blender", "found", "absent", "no blender on PATH or in the usual folders; --blender PATH")
        return
    try:
        host = blender.find(program)
        state = blender.state_of(host)
    except MeshcoreError as error:
        yield Finding("Blender", "found", "fails", str(error))
        return
    numpy = f"numpy {host.libraries['numpy']}"
    yield Finding(host.label, "Python", "ok", f"{host.python_version} at {host.program}, {numpy}")
    cure = f"meshcore install blender --blender {host.program}"
    if not state["present"]:
        yield Finding(host.label, "extension", "fails", f"not installed; {cure}")
        return
    yield Finding(host.label, "extension", "ok", state["folder"])
    if state["enabled"]:
        yield Finding(host.label, "enabled", "ok", "in Preferences > Add-ons")
    else:
        yield Finding(host.label, "enabled", "fails", "switch it on in Preferences > Add-ons")
    missing = [name for name, found in state["libraries"].items() if not found]
    if missing:
        yield Finding(host.label, "libraries", "fails", f"without {', '.join(missing)}; {cure}")
    else:
        yield Finding(host.label, "libraries", "ok", ", ".join(state["libraries"]))


def _meshlab() -> Iterator[Finding]:
    if importlib.util.find_spec("pymeshlab") is None:
        cure = "MeshLab has no Python plugins; pip install pymeshlab beside meshcore, then import meshlab_filters"
        yield Finding("MeshLab", "pymeshlab", "absent", cure)
        return
    yield Finding("MeshLab", "pymeshlab", "ok", "installed")
    found = importlib.util.find_spec("meshlab_filters") is not None
    state, detail = ("ok", "installed") if found else ("fails", "part of meshcore: pip install . in a checkout")
    yield Finding("MeshLab", "meshlab_filters", state, detail)


def _versions(libraries: dict[str, str]) -> str:
    return ", ".join(f"{name} {version}" for name, version in libraries.items())


def _tried(subject: str, check: str, look: Callable[[], str], cure: str) -> Finding:
    try:
        return Finding(subject, check, "ok", look())
    except Exception as error:  # whatever breaks is what the doctor is there to tell
        return Finding(subject, check, "fails", f"{' '.join(str(error).split())}; {cure}")
