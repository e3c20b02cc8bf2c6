"""What the command line shows beside its results: a progress bar, tables, and where an error lies."""

from __future__ import annotations

import argparse
import difflib
import sys
import time
from collections.abc import Iterable, Sequence
from typing import Any, NoReturn, TextIO

from ..errors import MeshcoreError

SHOWN_PLACES = 3


class Parser(argparse.ArgumentParser):
    """Tells wrong usage in one line, with the flag that may have been meant, instead of after a page of flags.

    Examples
    --------
    >>> import contextlib, io
    >>> parser = Parser(prog="meshcore")
    >>> _ = parser.add_argument("--first-height")
    >>> with contextlib.redirect_stderr(io.StringIO()) as said, contextlib.suppress(SystemExit):
    ...     parser.parse_args(["--firstheight", "1"])
    >>> said.getvalue().split(" (")[0]
    'meshcore: error: unrecognized arguments: --firstheight; did you mean --first-height?'
    """

    def error(self, message: str) -> NoReturn:
        """Leave with exit code 2 and one line."""
        self.exit(2, f"{self.prog}: error: {message} ({self.prog} --help tells all)\n")

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """As argparse does; but flags that this parser does not know are no business of the one above."""
        found, left = super().parse_known_args(args, namespace)
        for word in left:
            flag = word.split("=")[0]
            if flag.startswith("--"):
                near = difflib.get_close_matches(flag, self._option_string_actions, 1)
                meant = f"; did you mean {near[0]}?" if near else ""
                self.error(f"unrecognized arguments: {flag}{meant}")
        return found, left


class PlainBar:
    """A progress bar of one line that is drawn over and over.

    Examples
    --------
    >>> import io
    >>> stream = io.StringIO()
    >>> with PlainBar(stream, width=4) as bar:
    ...     bar(0.5, "half way")
    True
    >>> stream.getvalue().startswith("\\r[##  ]  50% half way")
    True
    """

    def __init__(self, stream: TextIO, width: int = 30):
        self.stream, self.width = stream, width
        self._longest, self._last, self._message = 0, -1.0, ""

    def __enter__(self) -> PlainBar:
        return self

    def __exit__(self, *exception: object) -> None:
        self.stream.write("\r" + " " * self._longest + "\r")
        self.stream.flush()

    def __call__(self, fraction: float, message: str) -> bool:
        now = time.monotonic()
        if now - self._last < 0.05 and message == self._message:
            return True  # a terminal cannot show more, and slow ones would hold up the work
        self._last, self._message = now, message
        done = round(fraction * self.width)
        line = f"[{'#' * done}{' ' * (self.width - done)}] {fraction:4.0%} {message}"[:100]
        self._longest = max(self._longest, len(line))
        self.stream.write("\r" + line.ljust(self._longest))
        self.stream.flush()
        return True


class RichBar:
    """The same by rich, which knows the terminal's width and colours."""

    def __init__(self, stream: TextIO):
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn

        columns = (BarColumn(), TaskProgressColumn(), TimeElapsedColumn(), TextColumn("{task.description}"))
        self._bar = Progress(*columns, console=Console(file=stream), transient=True)
        self._task = self._bar.add_task("", total=1.0)

    def __enter__(self) -> RichBar:
        self._bar.start()
        return self

    def __exit__(self, *exception: object) -> None:
        self._bar.stop()

    def __call__(self, fraction: float, message: str) -> bool:
        self._bar.update(self._task, completed=fraction, description=message)
        return True


class NoBar:
    """Nothing at all, for scripts and pipes.

    Examples
    --------
    >>> with NoBar() as bar:
    ...     bar(0.5, "half way")
    True
    """

    def __enter__(self) -> NoBar:
        return self

    def __exit__(self, *exception: object) -> None:
        pass

    def __call__(self, fraction: float, message: str) -> bool:
        return True


def progress_bar(quiet: bool = False, stream: TextIO | None = None) -> PlainBar | RichBar | NoBar:
    """The best bar that ``stream`` (by default stderr) can show; none if it is no terminal.

    Examples
    --------
    >>> type(progress_bar(quiet=True)).__name__
    'NoBar'
    """
    stream = stream or sys.stderr
    if quiet or not stream.isatty():
        return NoBar()
    try:
        return RichBar(stream)
    except ImportError:
        return PlainBar(stream)


def table(rows: Iterable[Sequence[Any]], header: Sequence[str] = ()) -> str:
    """Rows in columns, two blanks apart.

    Examples
    --------
    >>> print(table([("a", 1), ("long name", 22)], header=("name", "value")))
    name       value
    ---------  -----
    a          1
    long name  22
    """
    lines = [[str(value) for value in row] for row in rows]
    if header:
        widths = [max(len(line[k]) for line in [list(header), *lines]) for k in range(len(header))]
        lines = [list(header), ["-" * width for width in widths], *lines]
    if not lines:
        return ""
    widths = [max(len(line[k]) for line in lines) for k in range(len(lines[0]))]
    padded = (
        "  ".join(value.ljust(width) for value, width in zip(line, widths, strict=True)).rstrip() for line in lines
    )
    return "\n".join(padded)


def places(error: MeshcoreError, inputs: dict[str, Any]) -> list[str]:
    """Where an error lies, in coordinates of the input that it names, a line a place.

    Parameters
    ----------
    error : MeshcoreError
        Its `points` and `cells`, if it has any, are numbers within the input called ``error.parameter``.
    inputs : dict of str to Mesh or StructuredGrid
        What was read from the files.

    Examples
    --------
    >>> from meshcore import InvalidGeometry, gallery
    >>> error = InvalidGeometry("is bad", parameter="boundary", points=(2,))
    >>> places(error, {"boundary": gallery.square()})
    ['at point 2: (1, 1, 0)']
    """
    given = inputs.get(getattr(error, "parameter", ""))
    if given is None and len(inputs) == 1:
        given = next(iter(inputs.values()))
    points, cells = getattr(error, "points", ()), getattr(error, "cells", ())
    if not points and getattr(error, "partial", None) is not None:
        given = error.partial
    if given is None or not hasattr(given, "points"):
        return []
    lines = _listed("point", points, getattr(given, "flat", lambda a: a)(given.points))
    return lines or _listed("cell", cells, getattr(given, "centroids", ()))


def _listed(what: str, numbers: Sequence[int], coordinates: Any) -> list[str]:
    """``at point 3: (x, y, z)`` for the first few numbers."""
    known = [k for k in numbers if 0 <= k < len(coordinates)]
    lines = [f"at {what} {k}: ({', '.join(f'{x:.6g}' for x in coordinates[k])})" for k in known[:SHOWN_PLACES]]
    if len(known) > SHOWN_PLACES:
        lines.append(f"and at {len(known) - SHOWN_PLACES} more {what}s")
    return lines
