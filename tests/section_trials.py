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
        Share of the section's points whose first height is farther than 5 % from what was asked: both the length of
        the first cell's edge and the first point's distance from the section. In a notch lines run along the walls,
        and only the distance can be right; beside a right angle only the one or the other.
    lowest, highest : float
        Of the two that is nearer to what was asked, in shares of that.
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
    names, blocks = ("section",), [grid]
    if not isinstance(grid, StructuredGrid):
        names, blocks = grid.names, list(grid.blocks)
    axes, start = _axes(section)
    planes = [(block.points[:, :, 0] - start) @ axes.T for block in blocks]
    if _signed_area(planes[0]) < 0:  # a plane in space has no upper side
        planes = [plane * [1, -1] for plane in planes]
    wake = report.counts.get("wake", 0)
    ahead = report.counts.get("ahead", wake)
    lines = [block.points[ahead : len(block.points) - wake, :, 0] for block in blocks]
    walls = [line[:, 0] for line in lines]
    if names == ("lower", "upper"):
        lines[0] = lines[0][:, ::-1]
        walls = [line[:, 0] for line in lines]
    elif len(blocks) == 2:  # behind the base
        lines, walls = lines[:1], [walls[0], blocks[1].points[0, :, 0]]
    ratios = _first_heights(lines, _space(section), report.quality["first height"])
    if any(folded(plane).any() for plane in planes):
        return "folded", ratios
    outside = _outside(names, planes, wake > 0)
    if len(outside) < MOST_EDGES and len(crossings(outside)):
        return "overlaps", ratios
    spikes = any("straight back" in text for text in report.warnings)
    return "sound" if _kept(walls, _space(section), spikes) else "wall moved", ratios


def _outside(names: tuple[str, ...], planes: list[np.ndarray], has_wake: bool) -> np.ndarray:
    """(n, 2) the closed outer boundary of all blocks, counter-clockwise or not."""
    if names == ("lower", "upper"):
        below, above = planes
        lower = [below[0, :0:-1], below[:-1, 0], below[-1, :-1]]
        return np.vstack([*lower, above[-1, :-1], above[:0:-1, -1], above[0, :0:-1]])
    plane = planes[0]
    if not has_wake:
        return plane[:-1, -1]
    if len(planes) == 1:
        return np.vstack([plane[0, :-1], plane[:, -1], plane[-1, -2:0:-1]])
    behind = planes[1][-1, ::-1]
    return np.vstack([plane[0, :-1], plane[:, -1], plane[-1, -2:0:-1], behind[:-1]])


def _first_heights(lines: list[np.ndarray], section: np.ndarray, asked: float) -> np.ndarray:
    """(n,) in shares of what was asked: lengths of first edges, or their ends' distances from the section if better."""
    edges = np.concatenate([np.linalg.norm(line[:, 1] - line[:, 0], axis=1) for line in lines]) / asked
    ends = np.concatenate([line[:, 1] for line in lines])
    for k in np.flatnonzero(np.abs(edges - 1) > HEIGHT_WITHIN):
        distance = _distance(ends[k], section) / asked
        if abs(distance - 1) < abs(edges[k] - 1):
            edges[k] = distance
    return edges


def _distance(point: np.ndarray, section: np.ndarray) -> float:
    """From a point to the closed outline through (n, 3) points."""
    return to_edges(point, section, np.roll(section, -1, axis=0))


def to_edges(point: np.ndarray, start: np.ndarray, stop: np.ndarray) -> float:
    """From a point to the nearest of straight edges."""
    edge = stop - start
    t = np.clip(((point - start) * edge).sum(axis=1) / np.maximum((edge**2).sum(axis=1), 1e-300), 0, 1)
    return float(np.linalg.norm(start + t[:, None] * edge - point, axis=1).min())


def _kept(walls: list[np.ndarray], section: np.ndarray, spikes: bool) -> bool:
    """Whether all points of the section, but for spikes, are on the wall's edges, and all of those on its outline."""
    hair = 1e-9 * float(np.ptp(section, axis=0).max()) + 1e-15 * float(np.abs(section).max())
    points = np.concatenate(walls)
    lost = section[cKDTree(points).query(section)[0] > hair]
    new = points[cKDTree(section).query(points)[0] > hair]
    edges = np.stack([np.concatenate([w[:-1] for w in walls]), np.concatenate([w[1:] for w in walls])])
    return (spikes or all(to_edges(point, *edges) <= hair for point in lost)) and all(
        _distance(point, section) <= hair for point in new
    )


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
