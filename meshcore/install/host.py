"""A host's Python, asked by running a script in it."""

from __future__ import annotations

import json
import os
import re
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import InvalidInput, MeshcoreError

INSIDE = Path(__file__).with_name("inside")
_MARK = "MESHCORE "
_VARIABLES_OF_OURS = ("PYTHONPATH", "PYTHONHOME", "VIRTUAL_ENV", "__PYVENV_LAUNCHER__")


@dataclass(frozen=True)
class Host:
    """A ParaView's or a Blender's Python and what it told of itself.

    Attributes
    ----------
    program : Path
        What is run: pvpython, blender, or a Python that has bpy.
    name, version : str
        "paraview" or "blender", and its version.
    python : tuple of int
        Version of its Python.
    libraries : dict of str to str or None
        Versions of numpy, scipy, numba, llvmlite and meshcore as they import there.
    facts : dict
        All that the probe told.
    """

    program: Path
    name: str
    version: str
    python: tuple[int, ...]
    libraries: dict[str, str | None]
    facts: dict[str, Any]

    @property
    def label(self) -> str:
        """As people say it: ``ParaView 5.11.0``."""
        return f"{'ParaView' if self.name == 'paraview' else 'Blender'} {self.version}"

    @property
    def python_version(self) -> str:
        """Major and minor version of its Python: ``3.11``."""
        return f"{self.python[0]}.{self.python[1]}"

    def run(self, script: str, *arguments: str, timeout: float = 300) -> Any:
        """Run one of our scripts in this host; what it prints after the mark, as JSON."""
        return run_in(self.program, script, *arguments, timeout=timeout)


def ask(program: Path) -> Host:
    """Ask a host's Python for its versions and libraries.

    Raises
    ------
    InvalidInput
        If the program does not run, or is neither ParaView's Python nor Blender.
    """
    facts = run_in(program, "probe")
    if not facts["host"]:
        raise InvalidInput(f"{program} is a Python, but neither ParaView's nor one with Blender's bpy")
    if facts["implementation"] != "cpython":
        raise InvalidInput(f"{program} runs {facts['implementation']}, numba needs CPython")
    return Host(program, facts["host"], facts["version"], tuple(facts["python"]), facts["libraries"], facts)


def run_in(program: Path, script: str, *arguments: str, timeout: float = 300) -> Any:
    """Run a script of `inside` by pvpython, blender or python, without our own Python's settings.

    Returns
    -------
    object
        What the script printed as JSON in a line that begins with ``MESHCORE``.

    Raises
    ------
    InvalidInput
        If the program cannot be run.
    MeshcoreError
        If it fails, hangs or prints no such line; with the last lines that it said.
    """
    file = str(INSIDE / f"{script}.py")
    command = [str(program), file, *arguments]
    if program.stem.lower().startswith("blender"):
        command = [str(program), "--background", "--python-exit-code", "1", "--python", file, "--", *arguments]
    clean = {name: value for name, value in os.environ.items() if name not in _VARIABLES_OF_OURS}
    try:
        done = subprocess.run(command, env=clean, capture_output=True, timeout=timeout, stdin=subprocess.DEVNULL)
    except OSError as error:
        raise InvalidInput(f"{program} does not run: {error.strerror or error}") from None
    except subprocess.TimeoutExpired:
        raise MeshcoreError(f"{program} did not answer within {timeout:g} seconds") from None
    lines = done.stdout.decode(errors="replace").splitlines()
    told = [line for line in lines if line.startswith(_MARK)]
    if done.returncode or not told:
        said = [line for line in (*lines, *done.stderr.decode(errors="replace").splitlines()) if line.strip()]
        raise MeshcoreError(f"{program} failed (exit code {done.returncode}): {' / '.join(said[-3:]) or 'no output'}")
    return json.loads(told[-1][len(_MARK) :])


def release(version: str) -> tuple[int, ...]:
    """The leading numbers of a version, for comparing.

    Examples
    --------
    >>> release("1.24.2") >= release("1.24"), release("2.0.0rc1")
    (True, (2, 0, 0))
    """
    return tuple(int(number) for number in re.match(r"[\d.]*", version).group().split(".") if number)
