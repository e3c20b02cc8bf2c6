"""Make the environments that the tests run in: `python3 tests/environments.py core meshlab blender-5.0 ...`.

Plain standard library, since it runs before anything is installed. Each environment is made once and again when
pyproject.toml changes; an absent host is an error, never a skip.
"""

from __future__ import annotations

import functools
import glob
import hashlib
import os
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FOLDER = ROOT / ".envs"
CORE = ROOT / ".venv"

HOST_NEEDS = ["numba", "scipy", "pytest", "meshio"]
BLENDER = {"blender-5.0": ("3.11", "bpy==5.0.*"), "blender-5.2": ("3.13", "bpy==5.2.*")}
PARAVIEW_PACKAGES = ["paraview", "python3-paraview", "python3-scipy", "xvfb", "xauth", "openmpi-bin"]
# What VTK's and Blender's wheels open at run time, even without a display.
GRAPHICS_PACKAGES = ["libgl1", "libopengl0", "libegl1", "libosmesa6", "libgomp1", "libxkbcommon0", "libsm6", "libice6"]
GRAPHICS_PACKAGES += ["libxrender1", "libxi6", "libxxf86vm1", "libxfixes3", "libxt6", "libxcursor1"]


def say(text: str) -> None:
    """One line that stands out of the installers' own."""
    print(f"-- {text}", flush=True)


def run(*command: str | Path, **options) -> None:
    """Run a command; leave with its output if it fails."""
    done = subprocess.run([str(c) for c in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, **options)
    if done.returncode:
        sys.stdout.write(done.stdout.decode(errors="replace"))
        sys.exit(f"failed with exit code {done.returncode}: {' '.join(map(str, command))}")


def python(version: str) -> str | None:
    """An interpreter of this version, from PATH or pyenv."""
    pyenv = os.environ.get("PYENV_ROOT", os.path.expanduser("~/.pyenv"))
    named = [shutil.which(f"python{version}"), shutil.which("python3"), f"/usr/bin/python{version}"]
    for candidate in [c for c in named if c] + sorted(glob.glob(f"{pyenv}/versions/{version}.*/bin/python")):
        tell = [candidate, "-c", "import sys; print('%d.%d' % sys.version_info[:2])"]
        try:
            found = subprocess.run(tell, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=False)
        except OSError:
            continue
        if found.stdout.decode().strip() == version:
            return candidate
    return None


@functools.cache
def apt_updated(prefix: tuple[str, ...]) -> None:
    """Refresh the package lists, once a run."""
    run(*prefix, "apt-get", "update", "-qq")


def apt(*packages: str) -> None:
    """Install the Debian packages that are missing, where that may be done."""
    state = ["dpkg-query", "-W", "-f", "${Package} ${db:Status-Status}\n", *packages]
    if shutil.which("dpkg-query") is None:
        return say(f"no apt here; make sure these are present: {' '.join(packages)}")
    listed = subprocess.run(state, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=False).stdout.decode()
    present = {line.split()[0] for line in listed.splitlines() if line.endswith(" installed")}
    missing = [p for p in packages if p not in present]
    if not missing:
        return None
    if os.geteuid() == 0:
        prefix = ()
    elif subprocess.run(["sudo", "-n", "true"], stderr=subprocess.DEVNULL, check=False).returncode == 0:
        prefix = ("sudo", "-n")
    else:
        sys.exit(f"needs Debian packages that you must install: sudo apt install {' '.join(missing)}")
    say(f"apt install {' '.join(missing)}")
    apt_updated(prefix)
    quiet = {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}
    return run(*prefix, "apt-get", "install", "-y", "-qq", "--no-install-recommends", *missing, env=quiet)


def stamp(folder: Path, *needs: str) -> tuple[Path, str]:
    """The file that tells an environment is ready, and what it must say."""
    text = (ROOT / "pyproject.toml").read_text() + "\n".join(needs)
    return folder / ".ready", hashlib.sha256(text.encode()).hexdigest()


def is_ready(folder: Path, *needs: str) -> bool:
    """Whether an environment was made from the present pyproject.toml."""
    file, text = stamp(folder, *needs)
    return file.exists() and file.read_text() == text


def venv(folder: Path, version: str, *needs: str) -> None:
    """Make a virtual environment with what it needs, unless it is ready."""
    if is_ready(folder, *needs):
        return
    interpreter = python(version)
    if interpreter is None:
        sys.exit(f"needs Python {version}, which is neither on PATH nor under pyenv")
    say(f"{folder.name}: Python {version} with {' '.join(needs)}")
    if subprocess.run([interpreter, "-c", "import ensurepip"], stderr=subprocess.DEVNULL, check=False).returncode:
        apt("python3-venv")  # Debian keeps ensurepip in a package of its own
    run(interpreter, "-m", "venv", "--clear", folder)
    run(folder / "bin/python", "-m", "pip", "install", "--quiet", "--upgrade", "pip")
    run(folder / "bin/python", "-m", "pip", "install", "--quiet", *needs, cwd=ROOT)
    file, text = stamp(folder, *needs)
    file.write_text(text)


def core() -> None:
    """The environment of the core, its tests, pictures and documentation."""
    apt(*GRAPHICS_PACKAGES)
    venv(CORE, "3.11", "-e", ".[test,docs]")


def meshlab() -> None:
    """MeshLab as a Python module."""
    apt(*GRAPHICS_PACKAGES)
    venv(FOLDER / "meshlab", "3.11", "pymeshlab", *HOST_NEEDS)


def blender(name: str) -> None:
    """One version of Blender as a Python module."""
    apt(*GRAPHICS_PACKAGES)
    version, package = BLENDER[name]
    venv(FOLDER / name, version, package, *HOST_NEEDS)


def paraview() -> None:
    """ParaView by apt, and beside it the two packages that its Python lacks."""
    apt(*GRAPHICS_PACKAGES, *PARAVIEW_PACKAGES)
    if shutil.which("pvpython") is None:
        sys.exit("needs ParaView: pvpython is not on PATH")
    folder = FOLDER / "paraview"
    needs = ["numba", "llvmlite"]
    if is_ready(folder, *needs):
        return
    say("paraview: numba and llvmlite for its Python")
    shutil.rmtree(folder, ignore_errors=True)
    pip = [CORE / "bin/python", "-m", "pip", "install", "--quiet", "--no-deps", "--target", folder]
    run(*pip, *needs)
    file, text = stamp(folder, *needs)
    file.write_text(text)


def wanted(names: list[str]) -> list[str]:
    """The environments of these names; "all" are those that this machine's Pythons allow."""
    if names != ["all"]:
        return names
    return ["core", "meshlab", *blenders(), "paraview"]


def blenders() -> list[str]:
    """Versions of Blender to test: 5.0 always, newer ones where their Python is on the machine."""
    return [name for name, (version, _) in BLENDER.items() if name == "blender-5.0" or python(version)]


def main(names: list[str]) -> None:
    """Make each environment that is named."""
    for name in wanted(names):
        if name in BLENDER:
            blender(name)
        elif name in ("core", "meshlab", "paraview"):
            globals()[name]()
        else:
            sys.exit(f"no environment {name!r}; there are all, core, meshlab, paraview, {', '.join(BLENDER)}")


if __name__ == "__main__":
    main(sys.argv[1:] or ["all"])
