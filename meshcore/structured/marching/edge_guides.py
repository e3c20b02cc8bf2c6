"""What edges of a front move on: a given surface, or given curves."""

from __future__ import annotations

from typing import Union

import numpy as np

from ...errors import InvalidInput
from ...geometry.alternating_digital_tree import Nearest
from ...geometry.closest import FacetedSurface
from ...mesh import Mesh, MultiBlock, StructuredGrid
from .front_graph import at

NEAR = 1e-3
"""Distance from a guide, in units of the surface's diagonal, up to which an edge's point lies on it: facets of curved
guides cut corners. It keeps that distance."""
BEGINS = 1e-6
"""The same of curves, at whose ends or points those of edges stand."""


class Guide:
    """A surface and curves on which edges stay; each point on a curve if it begins on one, else on the surface.

    Beyond its edges the surface goes straight on, and so do curves.

    Parameters
    ----------
    given : Mesh or StructuredGrid
        Triangles, quads and lines.
    diagonal : float
        Size of the surface whose edges stay on it.

    Raises
    ------
    InvalidInput
        If it has no such cells.
    """

    def __init__(self, given: Union[Mesh, StructuredGrid, MultiBlock], diagonal: float):
        mesh = given.to_mesh() if isinstance(given, (StructuredGrid, MultiBlock)) else given
        if not isinstance(mesh, Mesh):
            raise InvalidInput(f"needs a Mesh or a StructuredGrid, got {type(mesh).__name__}", parameter="guide")
        lines = mesh.points[mesh.get("line")]
        lines = lines[(lines[:, 0] != lines[:, 1]).any(axis=1)]
        facets = len(mesh.get("triangle")) + len(mesh.get("quad"))
        if not facets and not len(lines):
            raise InvalidInput("needs triangles, quads or lines for edges to stay on", parameter="guide")
        self.diagonal = diagonal
        self._lines, self._nearest = lines, Nearest(lines) if len(lines) else None
        self._surface = FacetedSurface(mesh, "guide") if facets else None

    def on_curve(self, points: np.ndarray) -> np.ndarray:
        """(m,) bool: which of (m, 3) points lie on a curve."""
        if self._nearest is None:
            return np.zeros(len(points), bool)
        return self._nearest.query(points).distance <= BEGINS * self.diagonal

    def distance(self, points: np.ndarray) -> np.ndarray:
        """(m,) float: how far (m, 3) points are from the surface; those on curves are not."""
        away = np.full(len(points), np.inf) if self._surface is None else self._surface.closest(points).distance
        return np.where(self.on_curve(points), 0.0, away)

    def holds(self, points: np.ndarray) -> bool:
        """Whether all of (m, 3) points lie on curves or the surface."""
        return bool((self.distance(points) <= NEAR * self.diagonal).all())

    def heights(self, points: np.ndarray) -> np.ndarray:
        """(m,) float: how far above the surface points are that stay on it; an error if one is far from all."""
        away = self.distance(points)
        if (away > NEAR * self.diagonal).any():
            worst = int(np.argmax(away))
            how = f"as far as {away[worst]:.4g}" if np.isfinite(away[worst]) else "and no curve begins there"
            raise InvalidInput(
                f"does not hold the edge's point {at(points[worst])}: it passes by, {how}; {NEAR * self.diagonal:.4g} "
                "is allowed for a surface, and without one a curve must begin at each of the edge's points",
                parameter="guide",
            )
        if self._surface is None:
            return np.zeros(len(points))
        foot = self._surface.closest(points)
        heights = ((points - foot.points) * foot.normals).sum(axis=1)
        return np.where(self.on_curve(points), 0.0, heights)

    def constraints(
        self, points: np.ndarray, on_curve: np.ndarray, heights: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Where points belong, and what leads off there.

        Parameters
        ----------
        points : (m, 3) float
        on_curve : (m,) bool
            Which of them stay on curves.
        heights : (m,) float
            How far the others stay above the surface.

        Returns
        -------
        foot : (m, 3) float
            The nearest place on the curve, or at that height above the nearest of the surface.
        off : (m, 3, 3) float
            Projector onto the directions that lead off it.
        """
        foot, off = np.empty_like(points), np.empty((len(points), 3, 3))
        if on_curve.any():
            item, weights, _ = self._nearest.query(points[on_curve])
            ends = self._lines[item]
            along = ends[:, 1] - ends[:, 0]
            along /= np.linalg.norm(along, axis=1, keepdims=True)
            foot[on_curve] = np.einsum("mk,mkq->mq", weights, ends)
            off[on_curve] = np.eye(3) - along[:, :, None] * along[:, None]
        if not on_curve.all():
            found = self._surface.closest(points[~on_curve])
            foot[~on_curve] = found.points + heights[~on_curve, None] * found.normals
            off[~on_curve] = found.normals[:, :, None] * found.normals[:, None]
        return foot, off
