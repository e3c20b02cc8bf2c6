"""The `meshcore` command: one subcommand per operation, straight from the registry, and a few for files and hosts.

Exit codes: 0 done, 1 an error that meshcore explains, 2 wrong usage, 130 stopped by Ctrl-C.
"""

from __future__ import annotations

import argparse
import os
import sys
import warnings
from collections.abc import Sequence
from typing import Any

from .. import __version__
from ..errors import Cancelled, MeshcoreError
from ..operation import operations
from . import commands, hosts, terminal

__all__ = ["main", "parser"]


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command line and return its exit code.

    Parameters
    ----------
    argv : sequence of str, optional
        The words after ``meshcore``; by default those of the process.

    Returns
    -------
    int
        0 done, 1 an error that was explained on stderr, 130 stopped by Ctrl-C. Wrong usage leaves by SystemExit(2).

    Examples
    --------
    >>> main(["transfinite", "missing.vtp", "-o", "out.vts", "--cells-i", "40"])
    1
    """
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")  # a terminal without block letters must not end the work
    arguments = parser().parse_args(argv)
    inputs: dict[str, Any] = {}
    try:
        with warnings.catch_warnings():
            _tell_warnings()
            code = arguments.run(arguments, inputs)
        sys.stdout.flush()
        return code or 0
    except (KeyboardInterrupt, Cancelled):
        return _say("cancelled", 130)
    except BrokenPipeError:
        # Who read our output has gone, as in `meshcore list | head`; nobody is left to be told.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except (MeshcoreError, OSError, MemoryError) as error:
        if arguments.debug:
            raise
        code = _say(f"error: {_one_line(error)}", 1)
        for line in terminal.places(error, inputs):
            print(f"  {line}", file=sys.stderr)
        return code


def _tell_warnings() -> None:
    """Show what meshcore warns of as a line of its own; what libraries warn their callers of is not for the user."""

    def show(message: Any, category: type[Warning], *place: Any) -> None:
        if category.__module__.startswith("meshcore."):
            _say(f"warning: {' '.join(str(message).split())}", 0)

    warnings.simplefilter("always")
    warnings.showwarning = show


def _say(text: str, code: int) -> int:
    print(f"meshcore: {text}", file=sys.stderr)
    return code


def _one_line(error: BaseException) -> str:
    if isinstance(error, OSError) and error.strerror:
        return f"{error.filename}: {error.strerror}" if error.filename else error.strerror
    if isinstance(error, MemoryError):
        return "not enough memory for a mesh of this size; ask for larger cells"
    text = " ".join(str(error).split())
    return text.removeprefix("path: ")  # the text itself names the file


def parser() -> argparse.ArgumentParser:
    """The whole command line.

    Examples
    --------
    >>> arguments = parser().parse_args(["transfinite", "loop.vtp", "-o", "g.vts", "--cells-i", "40"])
    >>> arguments.operation.label
    'Transfinite Interpolation'
    """
    root = terminal.Parser(
        prog="meshcore",
        description="Structured, unstructured and adaptive mesh generation.",
        epilog="meshcore COMMAND --help tells all of a command; meshcore list tells the operations and file formats.",
    )
    root.add_argument("--version", action="version", version=f"meshcore {__version__}")
    subparsers = root.add_subparsers(metavar="COMMAND", required=True)
    for operation in operations().values():
        commands.add_operation(subparsers, operation)
    commands.add_file_commands(subparsers)
    hosts.add_host_commands(subparsers)
    return root
