"""Off-screen plotters, with or without a display, and what they show as a PNG file."""

from __future__ import annotations

import contextlib
import ctypes
import os
import sys
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InvalidInput, MeshcoreError, MissingLibrary

SUPERSAMPLING = 2
"""Pixels are drawn so many times as fine and averaged, so that lines may be thinner than a pixel."""
EDGE = "#1d3a57"
"""The colour of lines and bars."""


@contextlib.contextmanager
def plotter_of(window: tuple[int, int], shape: tuple[int, int] = (1, 1), weights: list[float] | None = None):
    """An off-screen pyvista plotter of ``window`` pixels, closed at the end."""
    width, height = _checked_window(window)
    try:
        import pyvista
    except ImportError:
        raise MissingLibrary("pyvista", "a picture") from None
    _refuse_without_graphics(pyvista.vtk_version_info)
    # VTK warns of a missing display before it turns to EGL or OSMesa, which do without.
    with pyvista.vtk_verbosity("off"):
        plotter = pyvista.Plotter(
            off_screen=True,
            window_size=(width * SUPERSAMPLING, height * SUPERSAMPLING),
            shape=shape,
            col_weights=weights,
            border=False,
            lighting="none",
        )
        try:
            plotter.set_background("white")
            yield plotter
        finally:
            plotter.close()


def _refuse_without_graphics(version: tuple[int, ...]) -> None:
    """Raise where VTK would bring the process down: on Linux without a display and without EGL or OSMesa."""
    if not sys.platform.startswith("linux") or os.environ.get("DISPLAY"):
        return
    if tuple(version) < (9, 4):
        raise MeshcoreError(
            f"there is no display, and VTK {'.'.join(map(str, version))} cannot draw without one; "
            "install vtk 9.4 or newer, or run under xvfb-run"
        )
    for library in ("libEGL.so.1", "libOSMesa.so.8", "libOSMesa.so.6"):
        with contextlib.suppress(OSError):
            ctypes.CDLL(library)
            return
    raise MeshcoreError(
        "there is no display, and neither EGL nor OSMesa to draw without one; "
        "install libegl1 (or libosmesa6), or run under xvfb-run"
    )


def _checked_window(window: Any) -> tuple[int, int]:
    try:
        width, height = (int(v) for v in window)
    except (TypeError, ValueError):
        width = height = 0
    if not (16 <= width <= 4096 and 16 <= height <= 4096):
        raise InvalidInput(f"needs a width and a height of 16 to 4096 pixels, got {window!r}", parameter="window")
    return width, height


def save(plotter: Any, path: str | os.PathLike) -> Path:
    """Write what the plotter shows, averaged down to the window's pixels."""
    from PIL import Image  # pyvista depends on it

    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    pixels = np.asarray(plotter.screenshot(return_img=True))[..., :3]
    height, width = (n // SUPERSAMPLING for n in pixels.shape[:2])
    fine = pixels[: height * SUPERSAMPLING, : width * SUPERSAMPLING].reshape(
        height, SUPERSAMPLING, width, SUPERSAMPLING, 3
    )
    Image.fromarray(fine.mean(axis=(1, 3)).round().astype(np.uint8)).save(path)
    return path
