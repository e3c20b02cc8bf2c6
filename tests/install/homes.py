"""A clean home folder, and programs run as its user."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple


class Home(NamedTuple):
    """A home folder and the environment in which it is the user's."""

    folder: Path
    environment: dict[str, str]

    def run(self, *words, timeout=400) -> subprocess.CompletedProcess:
        """Run a program as the user of this home."""
        return subprocess.run(
            [str(word) for word in words],
            env=self.environment,
            cwd=self.folder,
            capture_output=True,
            text=True,
            timeout=timeout,
        )

    def meshcore(self, *words) -> subprocess.CompletedProcess:
        """Run the command line as the user of this home."""
        return self.run(sys.executable, "-m", "meshcore", *words)

    def files(self) -> dict[str, bytes]:
        """Everything in the home by its path, but what the hosts themselves write there."""
        found = {}
        for path in sorted(self.folder.rglob("*")):
            name = path.relative_to(self.folder).as_posix()
            if not name.startswith((".rustup", ".cache", ".config/matplotlib")) and "__pycache__" not in name:
                found[name] = path.read_bytes() if path.is_file() else b"a folder"
        return found


def new_home(folder: Path) -> Home:
    """An empty home; downloads and compiled kernels are still shared, since they are no part of what is tested."""
    caches = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    folder = folder.resolve()
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "PV_", "XDG_"))}
    environment.pop("MESHCORE_DATA_DIR", None)
    environment |= {"HOME": str(folder), "XDG_CACHE_HOME": caches, "BLENDER_USER_RESOURCES": str(folder / "blender")}
    (folder / "blender").mkdir()
    return Home(folder, environment)
