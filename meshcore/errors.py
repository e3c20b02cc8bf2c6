"""Every error that meshcore raises on purpose.

::

    MeshcoreError
    ├── InvalidInput(ValueError)          .parameter
    │   └── InvalidGeometry               .points, .cells: where, for the host to highlight
    ├── GenerationFailed(RuntimeError)    .parameter, .points: where; .cells, .partial
    ├── MissingLibrary(ImportError)       .library
    └── Cancelled

A message says what was wrong, the value, and the cure.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any


class MeshcoreError(Exception):
    """Base of all errors that meshcore raises on purpose."""


class InvalidInput(MeshcoreError, ValueError):
    """A parameter, an array or a file is not what the function can work with.

    Attributes
    ----------
    parameter : str
        Name of the faulty parameter; empty if the fault lies between several.
    """

    def __init__(self, message: str, *, parameter: str = ""):
        super().__init__(f"{parameter}: {message}" if parameter else message)
        self.parameter = parameter


class InvalidGeometry(InvalidInput):
    """The input's geometry is at fault.

    Attributes
    ----------
    points, cells : tuple of int
        Where: numbers of points and cells of the input, possibly empty.
    """

    def __init__(self, message: str, *, parameter: str = "", points: Sequence[int] = (), cells: Sequence[int] = ()):
        super().__init__(message, parameter=parameter)
        self.points = tuple(int(p) for p in points)
        self.cells = tuple(int(c) for c in cells)


class GenerationFailed(MeshcoreError, RuntimeError):
    """A generator could not make the mesh that was asked for.

    Attributes
    ----------
    parameter : str
        The input that `points` belong to; may be empty.
    points : tuple of int
        Points of the input where it could not.
    cells : tuple of int
        Faulty cells of `partial`.
    partial : Mesh, StructuredGrid or None
        What was reached, for inspection.
    """

    def __init__(
        self,
        message: str,
        *,
        parameter: str = "",
        points: Sequence[int] = (),
        cells: Sequence[int] = (),
        partial: Any = None,
    ):
        super().__init__(message)
        self.parameter = parameter
        self.points = tuple(int(p) for p in points)
        self.cells = tuple(int(c) for c in cells)
        self.partial = partial


class MissingLibrary(MeshcoreError, ImportError):
    """An optional library that this call needs is not installed.

    Attributes
    ----------
    library : str
        Its name as the package index knows it.
    """

    def __init__(self, library: str, purpose: str):
        super().__init__(f"{purpose} needs {library}, which this Python does not have: pip install {library}")
        self.library = library


class Cancelled(MeshcoreError):
    """The progress callback asked to stop."""

    def __init__(self, message: str = "cancelled"):
        super().__init__(message)
