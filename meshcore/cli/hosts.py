"""Commands on hosts: install, uninstall, doctor."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from . import commands, files, terminal

_MESHLAB = """MeshLab loads no plugins in Python, so there is nothing to put into it. Filters on pymeshlab's MeshSets:
  pip install pymeshlab
  python -m meshlab_filters --help"""


def add_host_commands(subparsers: Any) -> None:
    """install, uninstall and doctor."""
    for name, run, help in (
        ("install", run_install, "Put meshcore into ParaView or Blender, for this user."),
        ("uninstall", run_uninstall, "Take meshcore out of ParaView or Blender."),
    ):
        command = commands.add_command(subparsers, name, run, help, epilog=f"example:\n  meshcore {name} paraview")
        command.add_argument("host", choices=["paraview", "blender", "meshlab"])
        if name == "install":
            command.add_argument("--pvpython", type=Path, metavar="PATH", help="ParaView's Python, where not found")
        command.add_argument(
            "--blender", type=Path, metavar="PATH", help="Blender's program, or a Python that has bpy, where not found"
        )
    command = commands.add_command(subparsers, "doctor", run_doctor, "Tell what works in each host, and the cures.")
    command.add_argument("--pvpython", type=Path, metavar="PATH", help="look at this ParaView only")
    command.add_argument("--blender", type=Path, metavar="PATH", help="look at this Blender only")


def run_install(arguments: argparse.Namespace, inputs: commands.Inputs) -> None:
    """Install into one host."""
    from .. import install

    say = _teller(arguments)
    if arguments.host == "meshlab":
        print(_MESHLAB)
        return
    if arguments.host == "paraview":
        folder = install.install_paraview(arguments.pvpython, say)
    else:
        folder = install.install_blender(arguments.blender, say)
    if arguments.json:
        files.print_json({"host": arguments.host, "folder": folder})


def run_uninstall(arguments: argparse.Namespace, inputs: commands.Inputs) -> None:
    """Undo an installation."""
    from .. import install

    say = _teller(arguments)
    if arguments.host == "meshlab":
        print("there is nothing of meshcore in MeshLab; pip uninstall pymeshlab removes its Python module")
        return
    if arguments.host == "paraview":
        removed = install.uninstall_paraview(say)
    else:
        removed = install.uninstall_blender(arguments.blender, say)
    if arguments.json:
        files.print_json({"host": arguments.host, "removed": bool(removed)})


def run_doctor(arguments: argparse.Namespace, inputs: commands.Inputs) -> int:
    """A table of what works; exit code 1 if anything that is there does not."""
    from .. import install

    with terminal.progress_bar(arguments.quiet) as bar:
        findings = install.doctor(arguments.pvpython, arguments.blender, bar)
    failing = sum(finding.state == "fails" for finding in findings)
    if arguments.json:
        files.print_json([finding._asdict() for finding in findings])
    elif not arguments.quiet:
        print(terminal.table(findings, header=("where", "what", "state", "found")))
        print(f"\n{failing} of {len(findings)} fail" if failing else "\nall that is here works")
    return 1 if failing else 0


def _teller(arguments: argparse.Namespace):
    """Prints what an installer tells, on stderr where stdout is for JSON."""

    def say(line: str) -> None:
        if not arguments.quiet:
            print(line, file=sys.stderr if arguments.json else sys.stdout, flush=True)

    return say
