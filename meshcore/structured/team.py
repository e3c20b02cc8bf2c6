"""Python threads over kernels that let go of the interpreter's lock: who does which rows."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

_POINTS_WORTH_A_THREAD = 60_000


class Team:
    """Python threads that share the rows of a kernel; the result is the same for any number of them.

    Parameters
    ----------
    number : int
        Threads at most; small arrays are worked on by one.
    """

    def __init__(self, number: int):
        self.number = number
        self._pool = ThreadPoolExecutor(number) if number > 1 else None

    def __enter__(self) -> Team:
        return self

    def __exit__(self, *_: object) -> None:
        if self._pool:
            self._pool.shutdown()

    def share(self, run: Callable[[int, int, int], object], first: int, last: int, points: int, grain: int = 1) -> None:
        """Call ``run(thread, first, last)`` on disjoint parts, each a multiple of ``grain`` long but the last."""
        number = max(1, min(self.number, points // _POINTS_WORTH_A_THREAD, (last - first) // grain))
        if number == 1:
            run(0, first, last)
            return
        stops = first + np.arange(number + 1) * ((last - first) // grain) // number * grain
        stops[-1] = last
        parts = [self._pool.submit(run, k, int(stops[k]), int(stops[k + 1])) for k in range(number)]
        for part in parts:
            part.result()
