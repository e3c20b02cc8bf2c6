"""What a file holds, whatever its name says: text decoded, foreign content recognised."""

from __future__ import annotations

import re
from pathlib import Path

from ..errors import InvalidInput

_SIGNATURES = (
    (b"\x89PNG", "a PNG picture"),
    (b"\xff\xd8\xff", "a JPEG picture"),
    (b"GIF8", "a GIF picture"),
    (b"%PDF", "a PDF document"),
    (b"PK\x03\x04", "a zip archive"),
    (b"\x1f\x8b", "a gzip archive; unpack it first"),
    (b"\x89HDF", "an HDF5 file"),
    (b"CDF", "a NetCDF file"),
    (b"ISO-10303-21", "a STEP file"),
    (b"BLENDER", "a Blender file"),
    (b"\x7fELF", "a program"),
    (b"solid", "STL"),
    (b"ply", "PLY"),
    (b"OFF", "OFF"),
    (b"$MeshFormat", "a Gmsh mesh"),
    (b"MeshVersionFormatted", "a Medit mesh"),
    (b"# vtk DataFile", "a legacy VTK file"),
    (b"NDIME", "an SU2 mesh"),
)


def recognised(data: bytes) -> str:
    """What the first bytes of a file say it is; empty if they say nothing.

    Examples
    --------
    >>> recognised(b"<!DOCTYPE html>")
    'an HTML page'
    """
    start = data[:512].lstrip(b"\xef\xbb\xbf \t\r\n")
    lower = start.lower()
    if lower.startswith((b"<!doctype html", b"<html")):
        return "an HTML page"
    if b"<VTKFile" in start:
        kind = re.search(rb'type\s*=\s*["\'](\w+)', start)
        return f"a VTK XML file ({kind.group(1).decode()})" if kind else "a VTK XML file"
    return next((what for signature, what in _SIGNATURES if data.startswith(signature)), "")


def text_of(path: Path) -> str:
    """The text of a file: UTF-8, UTF-16 with its mark, or else Latin-1.

    Raises
    ------
    InvalidInput
        If the file is binary.
    """
    data = path.read_bytes()
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        return data.decode("utf-16", errors="replace").replace("\r\n", "\n").replace("\r", "\n")
    if b"\0" in data:
        raise InvalidInput("it is binary, and the format is text")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("latin-1")
    return text.replace("\r\n", "\n").replace("\r", "\n")


_FORTRAN_EXPONENT = re.compile(r"(?<=[\d.])[dD](?=[+-]?\d)")


def number(word: str) -> float | None:
    """A word as a finite or infinite number, Fortran's ``1.0D-3`` included; None if it is none.

    Examples
    --------
    >>> number("1.5D-1"), number("wing")
    (0.15, None)
    """
    if "_" in word:  # Python's own 1_000 is no number in any file format
        return None
    try:
        return float(word)
    except ValueError:
        pass
    try:
        return float(_FORTRAN_EXPONENT.sub("e", word))
    except ValueError:
        return None


def floats(words: list[str], line: int) -> list[float]:
    """Words as numbers; `InvalidInput` names the line and the word that is none."""
    try:
        if not any("_" in word for word in words):
            return list(map(float, words))
    except ValueError:
        pass  # Fortran's exponents, or no numbers at all
    values = []
    for word in words:
        value = number(word)
        if value is None:
            raise InvalidInput(f"line {line}: {word!r} is not a number")
        values.append(value)
    return values


def whole(word: str, line: int, what: str) -> int:
    """A word as a whole number; `InvalidInput` names the line and what was expected."""
    try:
        return int(word.replace("_", "?"))
    except ValueError:
        raise InvalidInput(f"line {line}: {word!r} is not {what}, a whole number") from None


def exact(value: float) -> str:
    """The shortest text that reads back as the same number."""
    return repr(float(value))
