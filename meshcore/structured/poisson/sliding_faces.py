"""Points that slide on a face of a block until lines leave it at the angle asked: Neumann's condition in space."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.fft import dstn, idstn

from ...geometry.surfaces import SplineSurface
from .surface_levels import corner_jacobians

if TYPE_CHECKING:
    from .face_measures import FaceMeasures

_SHARE = 0.7  # of the promised step
_LARGEST = 0.25  # step, in cells of the face: neighbours keep half of their distance
# Share of their first area that corners of the face's cells keep: points would run into edges that are not upright.
_LEAST = 0.2


class FaceSlide:
    """The points of one face, as parameters of the bicubic surface through those that were given; its edges stay.

    As in the plane (`sliding.Slide`), each wave of the points is moved by its lean over ``1 - exp(-k)``, the share of
    it that the first edges show: with m and p half waves over M and N cells of size a and b,
    ``k = pi h sqrt((m / M a)^2 + (p / N b)^2)``.

    Parameters
    ----------
    face : (3, na, nb) float
        The points where sliding starts.
    """

    def __init__(self, face: np.ndarray):
        self._surface = SplineSurface(np.moveaxis(face, 0, -1))
        self._at = np.moveaxis(self._surface.parameters, -1, 0).copy()
        self._area = self._areas(self._at)

    def step(self, lines: np.ndarray, found: FaceMeasures, angle: np.ndarray) -> None:
        """Move the points towards the angles, and with them the ``lines`` (3, na, nb, m) that leave them."""
        lean = np.cos(np.radians(found.angle)) / np.maximum(np.sin(np.radians(found.angle)), 0.1)
        wanted = np.cos(np.radians(angle)) / np.sin(np.radians(angle))
        # By how many cells the first edge's end is ahead of where it should be, seen from its foot.
        out = found.height / np.sqrt(1 + (lean**2).sum(axis=0))
        wrong = out * (lean - wanted) / found.spacing
        steps = np.zeros(wrong.shape)
        flatness = [float(np.median(found.height / spacing)) for spacing in found.spacing]
        steps[:, 1:-1, 1:-1] = np.clip(_SHARE * _spread(wrong[:, 1:-1, 1:-1], flatness), -_LARGEST, _LARGEST)
        change = sum(np.gradient(self._at, axis=1 + d) * steps[d] for d in range(2))
        self._at += self._held_back(change)
        way = np.moveaxis(self._surface.points(*self._at), -1, 0) - lines[..., 0]
        way[:, [0, -1]] = way[:, :, [0, -1]] = 0.0
        lines += way[..., None] * np.linspace(1, 0, lines.shape[3])

    @staticmethod
    def _areas(at: np.ndarray) -> np.ndarray:
        return corner_jacobians(np.moveaxis(at, 0, -1))

    def _held_back(self, change: np.ndarray) -> np.ndarray:
        """The change, less of it or none for points of cells that would become too small."""
        for _ in range(6):
            small = (self._areas(self._at + change) <= _LEAST * self._area).any(axis=0)
            if not small.any():
                return change
            touched = np.zeros(change.shape[1:], bool)
            for a in (slice(None, -1), slice(1, None)):
                for b in (slice(None, -1), slice(1, None)):
                    touched[a, b] |= small
            change = np.where(touched, 0.4 * change, change)
        return np.where(touched, 0.0, change)


def _spread(wrong: np.ndarray, flatness: list[float]) -> np.ndarray:
    """(2, n, m) steps inside a face that make up for what is wrong, wave by wave; edges stay."""
    waves = dstn(wrong, type=1, axes=(1, 2))
    numbers = [np.pi * np.arange(1, n + 1) / (n + 1) * flat for n, flat in zip(wrong.shape[1:], flatness, strict=True)]
    return idstn(waves / -np.expm1(-np.hypot(numbers[0][:, None], numbers[1])), type=1, axes=(1, 2))
