"""Sections as users bring them: one simple counter-clockwise loop in a plane, or a refusal that says where."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from ...errors import InvalidGeometry, InvalidInput
from ...geometry.curves import Curve, chains, is_closed, numbered_polyline, turning
from ...geometry.plane import Plane, fitted_plane, seen_upright
from ...geometry.section import Section, doubled_area
from ...mesh import Mesh
from ...mesh.extent import bounds
from ..crossings import TOUCH, refuse_crossings
from ..limits import check_extent

_GAP = 0.05
"""Of the extent: the widest gap at a trailing edge that is closed by a straight base."""
_SAME = 1e-10
"""Of the extent: points in a row that are nearer are one."""
_EQUAL = 1e-6
"""Radians: turns that differ by less are equal."""
_ROUNDED = 4 * 2.3e-16
"""Of the largest coordinate, which rounds: with `TOUCH` of the diagonal, a point nearer to an edge is on it."""


@dataclass(eq=False)
class GivenSection:
    """A section's loop in its plane.

    Attributes
    ----------
    loop : (n, 2) float
        Different points, counter-clockwise; the last is joined to the first.
    number : (n,) int
        The numbers that the user has for them.
    diagonal : float
        Of the section's bounding box.
    plane : Plane
        Where it lies.
    warnings : list of str
        What was changed.
    """

    loop: np.ndarray
    number: np.ndarray
    diagonal: float
    plane: Plane
    warnings: list[str] = field(default_factory=list)

    def to_space(self, points: np.ndarray) -> np.ndarray:
        """(ni, nj, 3) float: points (ni, nj, 2) of the plane in space."""
        return self.plane.to_space(points.reshape(-1, 2)).reshape(*points.shape[:2], 3)

    def begun_at(self, cut: int) -> np.ndarray:
        """(n, 2) float: the loop from the user's point number ``cut``; from the sharpest if it is -1."""
        if cut == -1:
            start = self._sharpest()
        elif cut in self.number:
            start = int(np.flatnonzero(self.number == cut)[0])
        else:
            raise InvalidInput(f"{cut} is no point of the section; -1 finds the sharpest", parameter="cut")
        return np.roll(self.loop, -start, axis=0)

    def _sharpest(self) -> int:
        """Number of the sharpest point; of equal ones, whose order is rounding's, where a `Section` begins, or else the
        rearmost along x."""
        turn = turning(self.loop)
        alike = np.flatnonzero(turn > turn.max() - _EQUAL)
        section = Section.of(self.loop)
        first = int(np.flatnonzero((self.loop == section.loop[0]).all(axis=1))[0])
        return first if first in alike else int(alike[np.argmax(self.loop[alike, 0])])


def with_own_outer(section: Curve) -> tuple[Curve, Curve | None]:
    """A section, and the curve round it if the mesh has both: two closed loops, one in the other's box.

    Examples
    --------
    >>> from meshcore import gallery
    >>> with_own_outer(gallery.airfoil_in_far_field("naca0012", outer=32))
    (Mesh(101 points, 69 line), Mesh(101 points, 32 line))
    """
    pieces = chains(section) if isinstance(section, Mesh) and len(section.get("line")) else []
    if len(pieces) != 2 or any(piece[0] != piece[-1] for piece in pieces):
        return section, None
    boxes = [bounds(section.points[piece]) for piece in pieces]
    for (inner, outer), (box, round_it) in ((pieces, boxes), (pieces[::-1], boxes[::-1])):
        extent = np.ptp(round_it, axis=0)
        wide = extent > _SAME * extent.max()  # the plane may be one of two coordinates
        if ((box[0] > round_it[0]) & (box[1] < round_it[1]))[wide].all():
            return _alone(section, inner), _alone(section, outer)
    return section, None


def _alone(mesh: Mesh, piece: np.ndarray) -> Mesh:
    """One of a mesh's curves; its points keep their numbers."""
    return replace(mesh, cells={"line": np.column_stack([piece[:-1], piece[1:]])}, cell_data={}, sets={})


def section_loop(curve: Curve) -> GivenSection:
    """Clean a section: repeated points are left out, a narrow gap is closed, a clockwise one is turned, and told.

    Raises
    ------
    InvalidGeometry
        If it is open, has fewer than three different points or no area, is not planar, or crosses itself; `points`
        tells where.
    """
    points, number, warnings = _closed(curve)
    points = points[:-1]
    extent = float(np.ptp(points, axis=0).max())
    fresh = (np.abs(points - np.roll(points, 1, axis=0)) > _SAME * extent).any(axis=1)
    fresh = fresh if fresh.any() else np.arange(len(points)) == 0
    if repeats := int((~fresh).sum()):
        warnings.append(f"{repeats} repeated points of the section were left out")
    points, number = points[fresh], number[fresh]
    if len(points) < 3:
        raise InvalidGeometry(f"needs at least three different points, got {len(points)}", parameter="section")
    diagonal = check_extent(points, parameter="section")
    plane = seen_upright(fitted_plane(points, parameter="section"))
    loop = plane.to_plane(points)
    hair = TOUCH * diagonal + _ROUNDED * float(np.abs(points).max())
    kept = _without_spikes(loop, hair)
    if len(kept) < 3:
        raise InvalidGeometry(f"encloses no area (extent {diagonal:.6g}); give a simple loop", parameter="section")
    if spikes := len(loop) - len(kept):
        warnings.append(f"{spikes} points of the section were left out, at which it goes straight back")
        loop, number = loop[kept], number[kept]
    refuse_crossings(loop, number, plane, hair, closed=True, parameter="section")
    if doubled_area(loop) < 0:
        loop, number = loop[::-1], number[::-1]
        if abs(plane.normal[2]) > 0.5:  # in other planes neither side is the upper one
            warnings.append("the section runs clockwise; it was turned")
    return GivenSection(loop, number, diagonal, plane, warnings)


def _closed(curve: Curve) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """Points of the curve, the last repeating the first, numbers of all but the last, and what was done."""
    points, number = numbered_polyline(curve, "section")
    check_extent(points, parameter="section")
    extent = float(np.ptp(points, axis=0).max())
    if is_closed(points) or (np.abs(points[-1] - points[0]) <= _SAME * extent).all():
        return points, number[:-1], []
    gap = float(np.linalg.norm(points[-1] - points[0]))
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    if len(points) < 4 or gap > _GAP * extent or (gap > 0.99 * float(np.median(steps)) and _is_round(points)):
        raise InvalidGeometry(
            f"is open: its ends are {gap:.4g} apart; close the loop", parameter="section", points=number[[0, -1]]
        )
    warnings = [f"the section was open by {gap:.4g} and has been closed by a straight line"]
    return np.vstack([points, points[:1]]), number, warnings


def _is_round(points: np.ndarray) -> bool:
    """Whether the ends of an open polyline go towards each other, as if a point were missing, and make no edge."""
    first, last, across = points[1] - points[0], points[-1] - points[-2], points[0] - points[-1]

    def cosine(a: np.ndarray, b: np.ndarray) -> float:
        return float(a @ b) / max(float(np.linalg.norm(a) * np.linalg.norm(b)), 1e-300)

    return cosine(last, across) > 0.7 and cosine(across, first) > 0.7


def _without_spikes(loop: np.ndarray, hair: float) -> np.ndarray:
    """Numbers of the points without those at which the outline goes back where it came from.

    Rounded coordinates do that at noses, and where the sides of a cusp have become one line. A spike has no width, so
    that what the loop encloses stays the same.
    """
    kept = np.arange(len(loop))
    while len(kept) > 2:
        points = loop[kept]
        before, after = np.roll(points, 1, axis=0) - points, np.roll(points, -1, axis=0) - points
        short, long = np.linalg.norm(before, axis=1), np.linalg.norm(after, axis=1)
        cross = np.abs(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0])
        width = cross / np.maximum(np.maximum(short, long), 1e-300)
        same = np.linalg.norm(before, axis=1) <= hair
        tip = same | ((width <= hair) & ((before * after).sum(axis=1) > 0))
        tip &= ~(np.roll(tip, 1) & (np.arange(len(tip)) > 0))  # of two neighbours one at a time
        if not tip.any():
            break
        kept = kept[~tip]
    return kept
