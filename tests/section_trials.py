"""A section put through `o_grid`, `c_grid` or `h_grid`, and what came of it, judged without meshcore's own checks."""

from __future__ import annotations

import inspect
import time
import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from meshcore import MeshcoreError, StructuredGrid
from meshcore.structured import c_grid, h_grid, o_grid
from tests.soundness import crossings, folded

MAKERS = {"O": o_grid, "C": c_grid, "H": h_grid}
METHODS = ("transfinite", "elliptic", "hyperbolic", "parabolic")
HEIGHT_WITHIN = 0.05
MOST_EDGES = 1500
"""Of a boundary that is tested for crossings pair by pair."""


@dataclass
class Trial:
    """What became of a section.

    Attributes
    ----------
    word : str
        "sound", or what is wrong: "folded", "overlaps", "wall moved", "refused", "no MeshcoreError"; "crosses" if the
        section crosses itself and that was told.
    text : str
        Of the refusal, or the report's warnings.
    heights : float
        Share of the section's points whose first height is farther than 5 % from what was asked.
    lowest, highest : float
        First heights in shares of what was asked.
    converged : bool
        As reported.
    seconds : float
        Of the processor.
    """

    word: str
    text: str = ""
    heights: float = 0.0
    lowest: float = 1.0
    highest: float = 1.0
    converged: bool = True
    seconds: float = 0.0


def methods(topology: str) -> tuple[str, ...]:
    """The methods that a topology's operation has."""
    return METHODS if "method" in inspect.signature(MAKERS[topology]).parameters else METHODS[:1]


def tried(topology: str, method: str, section: np.ndarray, **options: Any) -> Trial:
    """A section by an operation; nothing is raised."""
    if methods(topology) != METHODS[:1]:
        options["method"] = method
    began = time.process_time()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            grid, report = MAKERS[topology](section, **options)
    except MeshcoreError as error:
        seconds = time.process_time() - began
        text = f"{type(error).__name__}: {error}"
        crosses = len(section) < MOST_EDGES and len(crossings(_loop(section))) > 0
        return Trial("crosses" if crosses else "refused", text, converged=False, seconds=seconds)
    except Exception as error:
        text = f"{type(error).__name__}: {error}"
        return Trial("no MeshcoreError", text, converged=False, seconds=time.process_time() - began)
    seconds = time.process_time() - began
    word, ratios = _judged(grid, section, report)
    wrong = float((np.abs(ratios - 1) > HEIGHT_WITHIN).mean())
    found = float(ratios.min()), float(ratios.max())
    return Trial(word, "; ".join(report.warnings), wrong, *found, report.converged is not False, seconds)


def _judged(grid: Any, section: np.ndarray, report: Any) -> tuple[str, np.ndarray]:
    """A word, and the first heights at the section in shares of what was asked."""
    blocks = [grid] if isinstance(grid, StructuredGrid) else list(grid.blocks)
    axes, start = _axes(section)
    planes = [(block.points[:, :, 0] - start) @ axes.T for block in blocks]
    if _signed_area(planes[0]) < 0:  # a plane in space has no upper side
        planes = [plane * [1, -1] for plane in planes]
    wake = report.counts.get("wake", 0)
    lines = [block.points[report.counts.get("ahead", wake) : len(block.points) - wake, :, 0] for block in blocks]
    if len(blocks) == 2:
        lines[0] = lines[0][:, ::-1]
    heights = np.concatenate([np.linalg.norm(line[:, 1] - line[:, 0], axis=1) for line in lines])
    ratios = heights / report.quality["first height"]
    if any(folded(plane).any() for plane in planes):
        return "folded", ratios
    outside = _outside(planes, wake > 0)
    if len(outside) < MOST_EDGES and len(crossings(outside)):
        return "overlaps", ratios
    kept = _kept(np.concatenate([line[:, 0] for line in lines]), _space(section))
    return "sound" if kept else "wall moved", ratios


def _outside(planes: list[np.ndarray], has_wake: bool) -> np.ndarray:
    """(n, 2) the closed outer boundary of all blocks, counter-clockwise or not."""
    if len(planes) == 2:
        below, above = planes
        lower = [below[0, :0:-1], below[:-1, 0], below[-1, :-1]]
        return np.vstack([*lower, above[-1, :-1], above[:0:-1, -1], above[0, :0:-1]])
    plane = planes[0]
    return np.vstack([plane[0, :-1], plane[:, -1], plane[-1, -2:0:-1]]) if has_wake else plane[:-1, -1]


def _kept(wall: np.ndarray, section: np.ndarray) -> bool:
    """Whether all points of the section are on the wall, and no point of the wall is off the section's outline."""
    hair = 1e-9 * float(np.ptp(section, axis=0).max()) + 1e-15 * float(np.abs(section).max())
    if cKDTree(wall).query(section)[0].max() > hair:
        return False
    new = wall[cKDTree(section).query(wall)[0] > hair]
    a, edge = section, np.roll(section, -1, axis=0) - section
    for point in new:
        t = np.clip(((point - a) * edge).sum(axis=1) / np.maximum((edge**2).sum(axis=1), 1e-300), 0, 1)
        if np.linalg.norm(a + t[:, None] * edge - point, axis=1).min() > hair:
            return False
    return True


def _space(section: np.ndarray) -> np.ndarray:
    return section if section.shape[1] == 3 else np.column_stack([section, 0 * section[:, 0]])


def _axes(section: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(2, 3) axes of a section's plane, and its first point; x and y, and 0, for a plane one."""
    if section.shape[1] == 2:
        return np.eye(3)[:2], np.zeros(3)
    return np.linalg.svd(section - section.mean(axis=0))[2][:2], section[0]


def _loop(section: np.ndarray) -> np.ndarray:
    """(n, 2) different points of a section."""
    axes, start = _axes(section)
    flat = (_space(section) - start) @ axes.T
    fresh = np.linalg.norm(flat - np.roll(flat, 1, axis=0), axis=1) > 1e-10 * np.ptp(flat)
    return flat[fresh]


def _signed_area(points: np.ndarray) -> float:
    """Of all cells."""
    p, q = points[1:, 1:] - points[:-1, :-1], points[:-1, 1:] - points[1:, :-1]
    return float((p[..., 0] * q[..., 1] - p[..., 1] * q[..., 0]).sum())
