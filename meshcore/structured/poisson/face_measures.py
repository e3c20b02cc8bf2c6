"""What lines that leave a face of a block are like: their angles and the lengths of their first edges."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..algebraic.block_faces import AXES, across
from .wall_control import CORNER_REACH, SHARP

NEAR_EDGE = 3
"""Nodes beside an edge of a face that are not judged: one more than in the plane, lines turning about two edges."""
_FLAT = 1e-6  # sine between a face's lines below which it has no normal there
_TINY = 1e-300
_EASING = 6  # power of the distance from the opposite edge with which a lean at an edge falls off
_LARGEST_SLOPE = 3.0
Closed = tuple[bool, bool, bool]


@dataclass
class FaceMeasures:
    """What a wall in space has: arrays over the nodes of the face.

    Attributes
    ----------
    angle : (2, na, nb) float
        Degrees from the face's lines, in which its first and its second index grow, to the line that leaves it, as far
        as it leans along each: the line runs along ``normal + cot(angle[0]) a + cot(angle[1]) b`` with unit vectors.
    height : (na, nb) float
        Length of the line's first edge.
    spacing : (2, na, nb) float
        Mean length of the two edges of the face at the node, along each index.
    frame : (3, 3, na, nb) float
        Unit vectors along each index of the face, and its normal into the block, by component.
    counts : (na, nb) bool
        Whether the node is not close to an edge of the face where another face begins, nor to a crease; if all are,
        that are not on an edge.
    """

    angle: np.ndarray
    height: np.ndarray
    spacing: np.ndarray
    frame: np.ndarray
    counts: np.ndarray

    def off(self, angle: np.ndarray) -> np.ndarray:
        """(na, nb) degrees between the lines and those at the ``angle`` asked, (2, na, nb) or fewer."""
        have, wanted = (_direction(np.radians(a)) for a in (self.angle, np.broadcast_to(angle, self.angle.shape)))
        a, b, normal = self.frame
        have, wanted = (v[0] * a + v[1] * b + v[2] * normal for v in (have, wanted))
        sine, cosine = np.linalg.norm(np.cross(have, wanted, axis=0), axis=0), (have * wanted).sum(axis=0)
        return np.degrees(np.arctan2(sine, cosine))

    def eased(self, angle: np.ndarray, closed: tuple[bool, bool]) -> np.ndarray:
        """(2, na, nb) angles that are those measured at the face's edges, and fall off from there to ``angle``."""
        lean = np.clip(_slope(self.angle), -_LARGEST_SLOPE, _LARGEST_SLOPE) - _slope(angle)
        eased = np.zeros(lean.shape)
        for axis in (axis for axis in (1, 2) if not closed[axis - 1]):  # the Boolean sum of what both pairs ask
            steps = self.spacing[axis - 1][None]
            part = np.cumsum(steps, axis=axis) - steps.take([0], axis)
            part /= np.maximum(part.take([-1], axis), _TINY)
            rest = lean - eased
            eased += (1 - part) ** _EASING * rest.take([0], axis) + part**_EASING * rest.take([-1], axis)
        return np.degrees(np.arctan2(1.0, _slope(angle) + eased))


def _slope(angle: np.ndarray) -> np.ndarray:
    return np.cos(np.radians(angle)) / np.maximum(np.sin(np.radians(angle)), _FLAT)


def _direction(angle: np.ndarray) -> np.ndarray:
    """(3, na, nb) parts along a, b and the normal of a vector at the angles; below the face, it points down."""
    down = np.sin(angle).min(axis=0) < 0
    lean = np.cos(angle) / np.maximum(np.abs(np.sin(angle)), _FLAT)
    return np.stack([*lean, np.where(down, -1.0, 1.0)])


def axis_of(face: str) -> int:
    """0, 1, 2 for faces across i, j, k.

    Examples
    --------
    >>> axis_of("kmax")
    2
    """
    return AXES.index(face[0])


def from_face(values: np.ndarray, face: str) -> np.ndarray:
    """A view of (..., ni, nj, nk) values as (..., na, nb, outwards from the face).

    Examples
    --------
    >>> from_face(np.arange(24).reshape(2, 3, 4), "kmax")[1, 2]
    array([23, 22, 21, 20])
    """
    view = np.moveaxis(values, values.ndim - 3 + axis_of(face), -1)
    return view[..., ::-1] if face.endswith("max") else view


def facing(face: str) -> float:
    """1 if the product of a face's lines points into a right-handed block, else -1."""
    return (-1.0 if face[0] == "j" else 1.0) * (-1.0 if face.endswith("max") else 1.0)


def measured(
    x: np.ndarray,
    face: str,
    sign: float = 1.0,
    closed: Closed = (False,) * 3,
    wall: np.ndarray | None = None,
) -> FaceMeasures:
    """`FaceMeasures` of a face of a block.

    Parameters
    ----------
    x : (3, ni, nj, nk) float
        The block. Along directions that are closed its last layer repeats the second, after the one that repeats the
        first.
    face : str
        "imin", "imax", "jmin", "jmax", "kmin" or "kmax".
    sign : float
        1 if the block is right-handed, else -1.
    closed : tuple of three bool
        Along which directions the block runs on from its end to its beginning.
    wall : (na, nb) bool, optional
        Which nodes of the face are a wall, if not all are; it has edges, too.

    Examples
    --------
    >>> x = np.stack(np.meshgrid([0, 1, 2, 3], [0, 1, 2, 3], [0, 0.5, 1], indexing="ij"))
    >>> found = measured(x, "kmin")
    >>> found.angle[:, 1, 1], float(found.height[1, 1]), found.spacing[:, 1, 1]
    (array([90., 90.]), 0.5, array([1., 1.]))
    """
    view = from_face(x, face)
    points, edge = view[..., 0], view[..., 1] - view[..., 0]
    along = [_along(points, axis) for axis in (1, 2)]
    (a, spacing_a, turn_a), (b, spacing_b, turn_b) = along
    normal = np.cross(a, b, axis=0)
    sine = np.linalg.norm(normal, axis=0)
    normal *= sign * facing(face) / np.maximum(sine, _TINY)
    height, out, cosine = np.linalg.norm(edge, axis=0), (edge * normal).sum(axis=0), (a * b).sum(axis=0)
    in_a, in_b = ((v * edge).sum(axis=0) for v in (a, b))
    square = np.maximum(sine, _FLAT) ** 2
    parts = np.stack([in_a - cosine * in_b, in_b - cosine * in_a]) / square
    ends = [closed[axis] for axis in across(face)]
    counts = sine > _FLAT
    for axis, (turn, closes) in enumerate(zip((turn_a, turn_b), ends, strict=True)):
        ends_here = turn > SHARP if wall is None else (turn > SHARP) | ~_padded(wall, ends)
        counts &= _away_from(ends_here, points, height, axis, closes)
    if not counts.any():  # better judged too strictly than not at all
        counts = _inner(sine > _FLAT, ends) if wall is None else (sine > _FLAT) & _padded(wall, ends)
    found = FaceMeasures(
        np.degrees(np.arctan2(out, parts)),
        height,
        np.stack([spacing_a, spacing_b]),
        np.stack([a, b, normal]),
        counts,
    )
    return _without_ghosts(found, ends)


def _inner(values: np.ndarray, ends: list[bool]) -> np.ndarray:
    """Without the first and last of directions that do not run on."""
    inner = np.zeros_like(values)
    at = tuple(slice(None) if closed else slice(1, -1) for closed in ends)
    inner[at] = values[at]
    return inner


def _padded(values: np.ndarray, ends: list[bool]) -> np.ndarray:
    return np.pad(values, [(0, int(closed)) for closed in ends], mode="edge")


def _along(wall: np.ndarray, axis: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Unit tangents along an axis of a (3, na, nb) face, mean lengths of edges, and turns in radians.

    The tangent is that of the parabola through three nodes, at a sharp corner the bisector.
    """
    step = np.diff(wall, axis=axis)
    first, last = step.take([0], axis), step.take([-1], axis)
    after, before = np.concatenate([step, last], axis), np.concatenate([first, step], axis)
    long_after, long_before = (np.maximum(np.linalg.norm(v, axis=0), _TINY) for v in (after, before))
    ahead, behind = after / long_after, before / long_before
    turn = np.arctan2(np.linalg.norm(np.cross(ahead, behind, axis=0), axis=0), (ahead * behind).sum(axis=0))
    weight = np.where(turn > SHARP, 0.5, long_before / (long_after + long_before))
    tangent = weight * ahead + (1 - weight) * behind
    return tangent / np.maximum(np.linalg.norm(tangent, axis=0), _TINY), 0.5 * (long_after + long_before), turn


def _away_from(sharp: np.ndarray, wall: np.ndarray, height: np.ndarray, axis: int, closed: bool) -> np.ndarray:
    """(na, nb) bool: nodes that along an axis are not close to a crease, nor to an end, where another face begins."""
    sharp, height = np.moveaxis(sharp, axis, 0).copy(), np.moveaxis(height, axis, 0)
    if not closed:
        sharp[[0, -1]] = True
    length = np.zeros(sharp.shape)
    np.cumsum(np.linalg.norm(np.diff(np.moveaxis(wall, axis + 1, 1), axis=1), axis=0), axis=0, out=length[1:])
    number = np.broadcast_to(np.arange(float(len(sharp)))[:, None], sharp.shape)
    nodes, way = (_distance(at, sharp, closed) for at in (number, length))
    return np.moveaxis((nodes > NEAR_EDGE) & (way > CORNER_REACH * height), 0, axis)


def _distance(at: np.ndarray, sharp: np.ndarray, closed: bool) -> np.ndarray:
    """(n, m) distances along the first axis from places ``at`` to the nearest sharp ones."""
    if closed:
        period, inner, repeated = at[-2] - at[0], at[1:-1], np.concatenate([sharp[1:-1]] * 3)
        distance = _distance(np.concatenate([inner - period, inner, inner + period]), repeated, False)
        distance = distance[len(inner) : 2 * len(inner)]
        return np.concatenate([distance[-1:], distance, distance[:1]])
    earlier = np.maximum.accumulate(np.where(sharp, at, -np.inf), axis=0)
    later = np.minimum.accumulate(np.where(sharp, at, np.inf)[::-1], axis=0)[::-1]
    return np.minimum(at - earlier, later - at)


def _without_ghosts(found: FaceMeasures, ends: list[bool]) -> FaceMeasures:
    """Without the last layer of closed directions, the first being what its image is."""
    for axis, closed in zip((-2, -1), ends, strict=True):
        if closed:
            for name, values in vars(found).items():
                rows = np.moveaxis(values, axis, 0)[:-1].copy()
                rows[0] = rows[-1]
                setattr(found, name, np.moveaxis(rows, 0, axis))
    return found
