"""Arrays that grow, and the buffers that the kernels of planar triangulations need while they run."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..geometry import predicates


def grown(array: np.ndarray, size: int, fill: float = 0) -> np.ndarray:
    """A longer copy of an array along its first axis; the array itself if it is long enough."""
    if len(array) >= size:
        return array
    longer = np.zeros((size, *array.shape[1:]), array.dtype)  # no memory is touched before it is used
    longer[: len(array)] = array
    if fill:
        longer[len(array) :] = fill
    return longer


@dataclass
class Scratch:
    """Buffers that kernels need while they run; nothing is kept in them between calls that end with DONE.

    Parameters
    ----------
    quantum : float
        Of the coordinates, see `predicates.workspace`.
    """

    quantum: float = 0.0
    size: int = 4096
    stack: np.ndarray = field(init=False)
    ring: np.ndarray = field(init=False)
    ring_from: np.ndarray = field(init=False)
    cavity: np.ndarray = field(init=False)
    work: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        self.stack = np.empty(4 * self.size, np.int32)
        self.ring = np.empty(self.size, np.int32)
        self.ring_from = np.empty(self.size, np.int32)
        self.cavity = np.empty(self.size, np.int32)
        self.work = predicates.workspace(self.quantum)

    def grow(self) -> None:
        """Double the buffers; their content is kept."""
        self.size *= 2
        self.stack = grown(self.stack, 4 * self.size)
        for name in ("ring", "ring_from", "cavity"):
            setattr(self, name, grown(getattr(self, name), self.size))
