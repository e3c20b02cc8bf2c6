"""The formats by extension, and the way in and out that is the same for all of them."""

from __future__ import annotations

import contextlib
import difflib
import inspect
import io
import os
import shutil
import tempfile
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple, Union

from ..errors import InvalidInput, MeshcoreError, MissingLibrary
from ..mesh import Mesh, MultiBlock, PolyhedralMesh, StructuredGrid
from .content import recognised
from .fit import FormatWarning, Holds, fitted

AnyMesh = Union[Mesh, PolyhedralMesh, StructuredGrid, MultiBlock]


@dataclass(frozen=True)
class Format:
    """A file format: its name, its extensions, what it holds, and the functions that read and write it."""

    name: str
    extensions: tuple[str, ...]
    description: str
    holds: Holds
    read: Callable[..., AnyMesh] | None
    write: Callable[..., None] | None

    @property
    def options(self) -> dict[str, Any]:
        """Keywords of the writer, with their defaults."""
        return _keywords(self.write)

    @property
    def read_options(self) -> dict[str, Any]:
        """Keywords of the reader, with their defaults."""
        return _keywords(self.read)


def _keywords(function: Callable | None) -> dict[str, Any]:
    if function is None:
        return {}
    parameters = inspect.signature(function).parameters.values()
    return {p.name: p.default for p in parameters if p.kind is inspect.Parameter.KEYWORD_ONLY}


def _check_options(format: Format, given: dict[str, Any], known: dict[str, Any]) -> None:
    if unknown := sorted(set(given) - set(known)):
        listed = ", ".join(known) or "none"
        raise InvalidInput(f"{format.name} has no such option; it has {listed}", parameter=unknown[0])


_FORMATS: dict[str, Format] = {}
_PACKED = {".gz", ".bz2", ".xz", ".zst", ".zip"}


def register(
    name: str,
    extensions: tuple[str, ...],
    description: str,
    holds: Holds,
    *,
    read: Callable[..., AnyMesh] | None = None,
    write: Callable[..., None] | None = None,
) -> None:
    """Make a format known by its extensions; each format's module ends in this call."""
    for extension in extensions:
        if extension in _FORMATS:
            raise TypeError(f"{extension} is registered twice")
        _FORMATS[extension] = Format(name, extensions, description, holds, read, write)


class FormatRow(NamedTuple):
    """One line of the table of formats."""

    extensions: str
    name: str
    reads: bool
    writes: bool
    description: str


def formats() -> list[FormatRow]:
    """The table of file formats, for the README and the command line.

    Examples
    --------
    >>> [row.name for row in formats() if ".stl" in row.extensions]
    ['STL']
    """
    different = dict.fromkeys(_FORMATS.values())
    return [
        FormatRow(" ".join(f.extensions), f.name, f.read is not None, f.write is not None, f.description)
        for f in different
    ]


def read(path: str | os.PathLike, **options: Any) -> AnyMesh:
    """Read a mesh, a structured grid or several, by the file's extension.

    Parameters
    ----------
    path : path
        A file; upper and lower case of the extension do not matter.
    **options
        What the format offers: ``base="name"`` of CGNS.

    Returns
    -------
    Mesh, PolyhedralMesh, StructuredGrid or MultiBlock
        As the file holds it. What a format and a Mesh name differently is told in the format's own module.

    Raises
    ------
    InvalidInput
        If the file is missing, empty, cut off, or not what its extension says. The message tells what and where.
    MissingLibrary
        If the format needs a library that is not installed.

    Examples
    --------
    >>> import meshcore as mc
    >>> from pathlib import Path
    >>> mc.io.read(Path(mc.__file__).parent / "data" / "rae2822.dat")
    Mesh(128 points, 128 line)
    """
    path = _as_path(path)
    if not path.exists():
        raise InvalidInput(f"{path} {_absence(path)}", parameter="path")
    if path.is_dir():
        raise InvalidInput(f"{path} is a folder; give a file in it", parameter="path")
    if not path.is_file():  # reading a pipe or a device could wait, or go on, for ever
        raise InvalidInput(f"{path} is a pipe or a device; write it to a file first", parameter="path")
    if path.suffix.lower() in _PACKED:
        raise InvalidInput(f"{path.name} is packed; unpack it first", parameter="path")
    format = _format_of(path)
    if format.read is None:
        raise InvalidInput(f"{path.name}: {format.name} can only be written", parameter="path")
    _check_options(format, options, format.read_options)
    try:
        with open(path, "rb") as file:
            head = file.read(512)
    except OSError as error:
        raise InvalidInput(f"{path} cannot be opened: {error.strerror or error}", parameter="path") from None
    if not head.strip(b" \t\r\n\0"):
        raise InvalidInput(f"{path.name} is empty; write it again", parameter="path")
    with _quiet(f"{path.name}:") as said:
        try:
            return format.read(path, **options)
        except MissingLibrary:
            raise
        # A damaged file makes a library raise anything, and meshio exit: all of it means that the file is bad.
        except (Exception, SystemExit) as error:
            raise InvalidInput(_complaint(path, format, head, error, said), parameter="path") from error


def write(path: str | os.PathLike, mesh: AnyMesh, **options: Any) -> None:
    """Write a mesh, a structured grid or several, by the file's extension.

    The file is written beside its place and moved there when it is complete, so that a failure leaves what was there.
    Cells that the format cannot hold are an error; data that it cannot hold are left out with a `FormatWarning`.

    Parameters
    ----------
    path : path
        Where to; an existing file is replaced.
    mesh : Mesh, PolyhedralMesh, StructuredGrid or MultiBlock
        Structured grids are written as quads or hexahedra where the format knows no structure.
    **options
        What the format offers, such as ``binary=False``.

    Raises
    ------
    InvalidInput
        If the format does not hold the mesh's cells, knows no such option, or the file cannot be written.

    Examples
    --------
    >>> import meshcore as mc, tempfile, pathlib
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = pathlib.Path(folder) / "square.vtu"
    ...     mc.io.write(file, mc.Mesh([[0, 0], [1, 0], [1, 1], [0, 1]], {"quad": [[0, 1, 2, 3]]}))
    ...     mc.io.read(file)
    Mesh(4 points, 1 quad)
    """
    path = _as_path(path)
    format = _format_of(path)
    if format.write is None:
        raise InvalidInput(f"{path.name}: {format.name} can only be read; write .vtu", parameter="path")
    _check_options(format, options, format.options)
    with _quiet(f"{path.name}:"):
        mesh = fitted(mesh, format.holds, format.name)
        path = resolved(path)  # a link stays a link, its target is replaced
        if path.is_dir():
            raise InvalidInput(f"{path} is a folder; give a file name", parameter="path")
        if not path.parent.is_dir():
            raise InvalidInput(f"the folder {path.parent} does not exist; make it first", parameter="path")
        if path.exists() and not os.access(path, os.W_OK):
            raise InvalidInput(f"{path} is write-protected", parameter="path")
        try:
            with _beside(path) as place:
                format.write(place, mesh, **options)
        except OSError as error:
            raise InvalidInput(f"{path} cannot be written: {error.strerror or error}", parameter="path") from None


@contextlib.contextmanager
def _beside(path: Path) -> Iterator[Path]:
    """A place of the same name in a new folder beside ``path``; what was written there is moved when all is well."""
    folder = Path(tempfile.mkdtemp(prefix=".meshcore-", dir=path.parent))
    try:
        yield folder / path.name
        for made in sorted(folder.rglob("*"), key=lambda p: p == folder / path.name):  # the named file comes last
            target = path.parent / made.relative_to(folder)
            if made.is_dir():
                target.mkdir(exist_ok=True)
            else:
                os.replace(made, target)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


@contextlib.contextmanager
def _quiet(prefix: str) -> Iterator[io.StringIO]:
    """Keep libraries from printing; what they warn of is passed on as `FormatWarning`, named by the file."""
    said = io.StringIO()
    with warnings.catch_warnings(record=True) as caught, contextlib.redirect_stdout(said):
        warnings.simplefilter("always")
        with contextlib.redirect_stderr(said):
            yield said
    for text in dict.fromkeys(str(w.message) for w in caught if not issubclass(w.category, DeprecationWarning)):
        warnings.warn(f"{prefix} {text}", FormatWarning, stacklevel=4)


def _as_path(path: Any) -> Path:
    try:
        if not str(path).strip() or "\0" in os.fspath(path):
            raise InvalidInput("needs a file name, got an empty one", parameter="path")
        return Path(path).expanduser()
    except (TypeError, RuntimeError):
        raise InvalidInput(f"needs a file name, got {path!r}", parameter="path") from None


def resolved(path: Path) -> Path:
    """The path without links in it; `InvalidInput` if they run in circles."""
    try:
        return path.resolve()
    except (OSError, RuntimeError):
        raise InvalidInput(f"{path} is a link that runs in circles", parameter="path") from None


def _format_of(path: Path) -> Format:
    extension = path.suffix.lower()
    if extension in _FORMATS:
        return _FORMATS[extension]
    near = difflib.get_close_matches(extension, _FORMATS, n=1)
    guess = f"; did you mean {near[0]}? Known" if near else "; known"
    what = f"the extension {extension!r} is unknown" if extension else "has no extension"
    raise InvalidInput(f"{path.name}: {what}{guess} are {' '.join(_FORMATS)}", parameter="path")


def _absence(path: Path) -> str:
    if not path.parent.is_dir():
        return f"does not exist; there is no folder {path.parent}"
    if path.is_symlink():
        return "is a link that leads nowhere"
    try:
        near = difflib.get_close_matches(path.name, os.listdir(path.parent), n=1)
    except OSError:
        return "does not exist"
    return f"does not exist; did you mean {near[0]}?" if near else "does not exist; check the name"


def _complaint(path: Path, format: Format, head: bytes, error: BaseException, said: io.StringIO) -> str:
    """One sentence: which file, as what, what is wrong, and what to do."""
    if isinstance(error, MeshcoreError):
        what = str(error)
    elif isinstance(error, MemoryError):
        what = "it promises more than fits into memory"
    elif isinstance(error, OSError) and error.strerror:
        what = error.strerror.lower()
    else:
        printed = said.getvalue().strip().splitlines()
        what = str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__
        what = printed[-1].strip() if isinstance(error, SystemExit) and printed else what
        what = f"it is damaged ({what.rstrip('.')})"
    found = recognised(head)
    own = {"STL", "PLY", "OFF", "a Gmsh mesh", "a Medit mesh", "an SU2 mesh", "a legacy VTK file"}
    if found == "an HDF5 file" and format.name == "CGNS":
        found = ""
    if found and not (found in own and format.name.split()[0] in found) and not found.startswith("a VTK XML"):
        return f"{path.name} is {found}, not {format.name}"
    return f"{path.name} cannot be read as {format.name}: {what}; check that it is complete and what its name says"
