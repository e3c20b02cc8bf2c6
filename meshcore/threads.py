"""How many threads share a piece of work."""

from __future__ import annotations

import itertools
import numbers
import os
from collections.abc import Callable
from concurrent.futures import Executor, ThreadPoolExecutor

from .errors import InvalidInput

MOST_THREADS = 255
"""Parts are numbered by one byte."""


def checked_threads(threads: int | None) -> int | None:
    """A number of threads as the caller gave it, or None.

    Raises
    ------
    InvalidInput
        If it is no whole number from 1 to 255.

    Examples
    --------
    >>> checked_threads(2), checked_threads(None)
    (2, None)
    """
    if threads is None:
        return None
    if isinstance(threads, bool) or not isinstance(threads, numbers.Integral) or not 1 <= threads <= MOST_THREADS:
        raise InvalidInput(
            f"needs a whole number from 1 to {MOST_THREADS}, or None, got {threads!r}", parameter="threads"
        )
    return int(threads)


def available_threads() -> int:
    """How many threads can run at once: the cores that this process may use.

    Examples
    --------
    >>> available_threads() >= 1
    True
    """
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def in_parts(
    pool: Executor | None, parts: int, work: Callable[..., object], start: int, stop: int, *, grain: int = 1
) -> None:
    """Call ``work(first, last)`` on at most ``parts`` equal parts of ``range(start, stop)`` at once, and wait for all.

    The work must give the same whatever the parts are. Each but the last is a multiple of ``grain`` long.

    Examples
    --------
    >>> in_parts(None, 1, lambda first, last: print(first, last), 0, 5)
    0 5
    """
    grains = (stop - start) // grain
    stops = [*(start + grains * k // parts * grain for k in range(parts)), stop]
    parted = [(first, last) for first, last in itertools.pairwise(stops) if first < last]
    if pool is None or len(parted) < 2:
        for first, last in parted:
            work(first, last)
    else:
        for future in [pool.submit(work, first, last) for first, last in parted]:
            future.result()


class Workers:
    """Threads that share work whose result does not depend on how it is parted.

    Examples
    --------
    >>> with Workers(1) as workers:
    ...     workers.run(lambda first, last: print(first, last), 0, 5)
    0 5
    """

    def __init__(self, threads: int):
        self._threads = threads
        self._pool = ThreadPoolExecutor(threads) if threads > 1 else None

    def __enter__(self) -> Workers:
        return self

    def __exit__(self, *_: object) -> None:
        if self._pool is not None:
            self._pool.shutdown()

    def parts(self, most: int) -> int:
        """How many threads share work that is worth ``most``."""
        return min(self._threads, most)

    def run(
        self,
        work: Callable[[int, int], object],
        start: int,
        stop: int,
        *,
        most: int = MOST_THREADS,
        grain: int = 1,
    ) -> None:
        """Call ``work(first, last)`` on equal parts of ``range(start, stop)`` at once, and wait for all.

        Parameters
        ----------
        work : callable
            It must give the same whatever the parts are.
        start, stop : int
            Whole range.
        most : int
            How many threads the work is worth; what is small is done at one go.
        grain : int
            Each part but the last is a multiple of it long.
        """
        parts = self.parts(most)
        if parts < 2:
            work(start, stop)
        else:
            in_parts(self._pool, parts, work, start, stop, grain=grain)
