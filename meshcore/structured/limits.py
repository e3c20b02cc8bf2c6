"""How large a structured grid may get: what would fill the memory is refused before it is made."""

from __future__ import annotations

from ..errors import InvalidInput

MAX_POINTS = 50_000_000


def check_size(n_i: int, n_j: int, n_k: int = 1, *, parameter: str) -> None:
    """Refuse a grid of more than `MAX_POINTS` points.

    Parameters
    ----------
    n_i, n_j, n_k : int
        Points along i, j and k.
    parameter : str
        The number to make smaller, for the message.

    Raises
    ------
    InvalidInput
        If the grid would be too large.

    Examples
    --------
    >>> check_size(1001, 501, parameter="cells_i")
    """
    if n_i * n_j * n_k > MAX_POINTS:
        raise InvalidInput(
            f"would make {n_i * n_j * n_k:.3g} points; at most {MAX_POINTS:,} are allowed, so make it smaller",
            parameter=parameter,
        )
