"""Points that slide along the boundary until lines leave it at the angle asked: Neumann's condition (survey 2.5.1)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.fft import dst, idst, irfft, rfft

if TYPE_CHECKING:
    from .wall_control import Measured

_SHARE = 0.7  # of the promised step
_IN_A_STEP = 2.0  # factor by which the distance between neighbours may change
# Share of its first value that this distance keeps: at a corner that is not upright no foot of the first line is found,
# and points would run into it.
_LEAST = 0.2


class Slide:
    """The points of one side, as arc lengths along it.

    A wave of the points along the boundary dies away inside, as harmonic functions do: ``exp(-k n)`` after n lines,
    with k in radians per line. The edge that should be upright then leans by ``1 - exp(-k)`` of the wave, and each wave
    is moved by its lean over that share: long waves, which the first line hardly shows, as fast as short ones.

    Parameters
    ----------
    side : (2, n) float
        The boundary curve, through these points; they are where sliding starts.
    """

    def __init__(self, side: np.ndarray):
        self._curve = side.copy()
        self._length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(side, axis=1), axis=0))])
        self._at = self._length.copy()

    def step(self, lines: np.ndarray, found: Measured, angle: float, closed: bool) -> None:
        """Move the points towards the angle; ``lines`` (2, n, m) leave them, and are drawn along, less and less."""
        lean, wanted = np.radians(found.angle - 90.0), np.radians(np.asarray(angle) - 90.0)
        # By how far the first edge's end is ahead of where it should be, seen from its foot.
        wrong = found.height * (np.cos(lean) * np.tan(wanted) - np.sin(lean))
        step = _SHARE * _spread(wrong, float(np.median(found.height / found.spacing)), closed)
        gap, first = np.diff(self._at), np.diff(self._length)
        low = np.maximum(gap / _IN_A_STEP, first * _LEAST)
        stops = np.cumsum(np.clip(gap + np.diff(step), low, np.maximum(gap * _IN_A_STEP, low)))
        self._at[1:-1] = stops[:-1] * (self._length[-1] / stops[-1])
        way = np.stack([np.interp(self._at, self._length, x) for x in self._curve]) - lines[..., 0]
        lines += way[..., None] * np.linspace(1, 0, lines.shape[2])


def _spread(wrong: np.ndarray, ratio: float, closed: bool) -> np.ndarray:
    """(n,) steps that make up for what is wrong, wave by wave; ends stay."""
    n = len(wrong) - 1
    if closed:
        waves = rfft(wrong[:-1])
        waves[0] = 0.0  # turning all points together changes no angle
        waves[1:] /= -np.expm1(-2 * np.pi * np.arange(1, len(waves)) / n * ratio)
        around = irfft(waves, n)
        return np.concatenate([around - around[0], [0.0]])
    waves = dst(wrong[1:-1], type=1)
    waves /= -np.expm1(-np.pi * np.arange(1, n) / n * ratio)
    return np.concatenate([[0.0], idst(waves, type=1), [0.0]])
