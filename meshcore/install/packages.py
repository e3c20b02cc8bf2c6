"""The libraries that a host's Python lacks, by pip, into a folder of our own."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

from ..errors import InvalidInput, MeshcoreError, MissingLibrary
from .host import Host, release
from .places import PACKAGE

FLOORS = {"numpy": "1.24", "scipy": "1.10", "numba": "0.60"}
PYTHON_FLOOR = (3, 10)

Say = Callable[[str], None]
"""Is told, a line at a time, what an installer does."""


def present(host: Host) -> dict[str, str]:
    """The libraries that a host has in versions that meshcore can use.

    Raises
    ------
    InvalidInput
        If its Python or its numpy is too old. Its numpy cannot be replaced: the host itself works with it.
    """
    if host.python < PYTHON_FLOOR:
        raise InvalidInput(
            f"{host.label} has Python {host.python_version}; meshcore needs {_dotted(PYTHON_FLOOR)} or newer"
        )
    usable = {}
    for name, floor in FLOORS.items():
        version = host.libraries[name]
        if version and not version.startswith("broken") and release(version) >= release(floor):
            usable[name] = version
        elif name == "numpy" and version:
            raise InvalidInput(f"{host.label} has numpy {version}; meshcore needs {floor} or newer: take a newer one")
    return usable


def lacking(host: Host) -> list[str]:
    """What pip would install, as ``name==version``, to fit what the host has.

    Raises
    ------
    MeshcoreError
        If pip finds no versions that fit.
    """
    usable = present(host)
    if len(usable) == len(FLOORS):
        return []
    wanted = [f"{name}>={floor}" for name, floor in FLOORS.items() if name not in usable]
    # A host's numpy may be a build that no index has; its series is what others are built against.
    wanted += [f"{name}=={_dotted(release(version)[:2])}.*" for name, version in usable.items()]
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "report.json"
        options = ["--dry-run", "--ignore-installed", "--target", folder, "--report", str(report)]
        _pip("install", *options, *_target_options(host), *wanted)
        found = [item["metadata"] for item in json.loads(report.read_text(encoding="utf-8"))["install"]]
    return [f"{item['name']}=={item['version']}" for item in found if item["name"].lower() not in usable]


def put(host: Host, folder: Path, say: Say) -> list[str]:
    """Fill a folder with what the host lacks, and with this meshcore; return what was put there.

    Parameters
    ----------
    host : Host
        Whose Python it is for.
    folder : Path
        Made anew.
    say : callable
        Told what happens.
    """
    say(f"asking pip what fits {host.label}: Python {host.python_version}, numpy {host.libraries['numpy']}")
    missing = lacking(host)
    folder.mkdir(parents=True)
    if missing:
        say(f"pip install {' '.join(missing)}")
        _pip("install", "--no-deps", "--no-compile", "--target", str(folder), *_target_options(host), *missing)
    shutil.copytree(PACKAGE, folder / "meshcore", ignore=shutil.ignore_patterns("__pycache__", "_hosts"))
    # pvpython writes no bytecode, so without this each start would compile hundreds of files.
    say("compiling bytecode")
    host.run("bytecode", str(folder))
    return [*missing, "meshcore"]


def _target_options(host: Host) -> list[str]:
    """pip's words for a Python other than the one that runs it."""
    version = host.python_version
    abi = "cp" + host.facts["abi"].split("-")[1] if host.facts["abi"].startswith("cpython-") else ""
    options = ["--only-binary=:all:", "--implementation", "cp", "--python-version", version]
    options += ["--abi", abi or f"cp{version.replace('.', '')}"]
    for tag in platform_tags(host.facts):
        options += ["--platform", tag]
    return options


def platform_tags(facts: dict) -> list[str]:
    """Platform tags of wheels that run where a probe told these facts, best first.

    Examples
    --------
    >>> platform_tags({"platform": "linux-x86_64", "glibc": "2.18", "machine": "x86_64", "macos": ""})
    ['manylinux_2_18_x86_64', 'manylinux_2_17_x86_64', 'manylinux2014_x86_64']
    >>> platform_tags({"platform": "win-amd64", "glibc": "", "machine": "AMD64", "macos": ""})
    ['win_amd64']
    """
    machine = facts["machine"]
    if facts["macos"]:
        major = release(facts["macos"])[0]
        return [f"macosx_{major}_0_{machine}"]
    if facts["glibc"]:
        newest = release(facts["glibc"])[1]
        return [f"manylinux_2_{k}_{machine}" for k in range(newest, 16, -1)] + [f"manylinux2014_{machine}"]
    return [facts["platform"].replace("-", "_").replace(".", "_")]


def _pip(*arguments: str) -> None:
    command = [sys.executable, "-m", "pip", *arguments[:1], "--quiet", "--disable-pip-version-check", *arguments[1:]]
    done = subprocess.run(command, capture_output=True, text=True, stdin=subprocess.DEVNULL)
    if "No module named pip" in done.stderr:
        raise MissingLibrary("pip", "installing into a host")
    if done.returncode:
        errors = [line for line in done.stderr.splitlines() if line.startswith("ERROR")] or done.stderr.splitlines()
        raise MeshcoreError(f"pip failed: {' '.join(errors[-2:]) or 'no output'}; check the network and try again")


def _dotted(numbers: tuple[int, ...]) -> str:
    return ".".join(map(str, numbers))
