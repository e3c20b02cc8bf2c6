"""Progress of long work: a callback that is told how far things are and may say stop."""

from __future__ import annotations

from collections.abc import Callable

from .errors import Cancelled

Progress = Callable[[float, str], "bool | None"]
"""``progress(fraction, message)``; returning False cancels the work."""


def silent(fraction: float, message: str) -> bool:
    """Report nothing, never cancel.

    Examples
    --------
    >>> silent(0.5, "half way")
    True
    """
    return True


def advance(progress: Progress, fraction: float, message: str) -> None:
    """Report to ``progress``; raise `Cancelled` if it answers False.

    Examples
    --------
    >>> advance(silent, 0.5, "half way")
    """
    if progress(min(max(float(fraction), 0.0), 1.0), message) is False:
        raise Cancelled(f"cancelled while {message}")


def forwards(progress: Progress) -> Progress:
    """The progress of work whose steps may be repeated: it waits where it is until they are farther than before.

    Examples
    --------
    >>> seen = []
    >>> bar = forwards(lambda fraction, message: seen.append(fraction))
    >>> for fraction in (0.2, 0.6, 0.4, 0.8):
    ...     advance(bar, fraction, "trying")
    >>> seen
    [0.2, 0.6, 0.6, 0.8]
    """
    if progress is silent:
        return silent
    farthest = 0.0

    def report(fraction: float, message: str) -> bool | None:
        nonlocal farthest
        farthest = max(farthest, fraction)
        return progress(farthest, message)

    return report


def part_of(progress: Progress, start: float, stop: float) -> Progress:
    """The progress of a step that spans ``start`` to ``stop`` of the whole work.

    Examples
    --------
    >>> seen = []
    >>> step = part_of(lambda fraction, message: seen.append(fraction), 0.5, 1.0)
    >>> advance(step, 0.5, "in the second half")
    >>> seen
    [0.75]
    """
    if progress is silent:
        return silent
    return lambda fraction, message: progress(start + (stop - start) * fraction, message)
