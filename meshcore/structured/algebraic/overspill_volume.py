"""The cure of overspill in blocks: edges made alike, faces smoothed, then the elliptic volume (survey 2.4.1)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import product
from typing import Literal

import numpy as np

from ...errors import InvalidGeometry
from ...progress import Progress, advance, part_of, silent
from ..folds import folded_cells
from ..poisson import winslow_3d, winslow_surface
from ..poisson.block_problem import AskedOfBlock
from ..poisson.block_unfolding import sound
from .blending import Patch
from .block_faces import BlockFaces
from .overspill import smoothed as in_plane
from .sides import fractions_of

Cure = Literal["none", "sides", "smoothing", "automatic"]
SHARES = (0.5, 1.0)
"""How far points of edges are moved towards the mean of the four that run side by side."""


def cured(
    block: BlockFaces,
    points: np.ndarray,
    cure: Cure,
    interpolated: Callable[[BlockFaces], np.ndarray],
    *,
    threads: int | None = None,
    progress: Progress = silent,
) -> tuple[np.ndarray, list[str]]:
    """The points of a block with fewer folded cells, none if that can be had, and what was done.

    Parameters
    ----------
    block : BlockFaces
        What the points were interpolated from.
    points : (ni, nj, nk, 3) float
        With folded cells.
    cure : {"none", "sides", "smoothing", "automatic"}
        Which remedy; "automatic" takes all in turn until no fold is left.
    interpolated : callable
        Makes the points of other faces.
    threads : int, optional
        By default as many as there are cores; the points do not depend on it.
    progress : Progress, optional
        Called with fraction and message.
    """
    done: list[str] = []
    folds = winslow_3d.count_folded(points)
    if folds and cure in ("sides", "automatic"):
        for faces, what in _with_other_sides(block):
            advance(progress, 0.2, "curing overspill: sides")
            moved = interpolated(faces)
            fewer = winslow_3d.count_folded(moved)
            if fewer < folds:
                points, folds, done = moved, fewer, [f"overspill: {what}"]
            if not folds:
                break
    if folds and cure in ("smoothing", "automatic"):
        found = sound(points, points, None, AskedOfBlock(threads=threads), part_of(progress, 0.3, 1.0))
        if winslow_3d.count_folded(found.points) < folds:
            what = "overspill: the inside was smoothed by the Laplace equations"
            points, done = found.points, [*done, what, *found.warnings]
    return points, done


def _with_other_sides(block: BlockFaces):
    """The block with points of its faces moved on them, in several ways, and what was done."""
    edges = {key: fractions_of(edge) for key, edge in block.edges.items()}
    for share in SHARES:
        fractions = {}
        for axis in range(3):
            keys = [(axis, *ends) for ends in product((0, 1), repeat=2)]
            mean = np.mean([edges[key] for key in keys], axis=0)
            fractions |= {key: (1 - share) * edges[key] + share * mean for key in keys}
        alike = block.resampled(fractions).joined()
        yield alike, "points of the edges were moved along them, and those of the faces with them"
        yield _smoothed(alike), "points of edges and faces were moved on them, and the faces smoothed"


def _smoothed(block: BlockFaces) -> BlockFaces:
    """The block with its faces made elliptic, in their planes or on the surfaces through them; edges stay."""
    return replace(block, faces={place: _smoothed_face(face) for place, face in block.faces.items()})


def _smoothed_face(face: np.ndarray) -> np.ndarray:
    if folded_cells(face).any():  # which only in a plane can be unfolded
        return in_plane(Patch(face[:, 0], face[-1], face[:, -1], face[0]), face)[1]
    try:
        return winslow_surface.smoothed(face)[0]
    except InvalidGeometry:  # a face may be a line, as on the axis of a wedge
        return face
