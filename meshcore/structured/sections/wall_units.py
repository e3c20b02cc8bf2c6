"""First heights at walls from what the flow asks of them: y+ and the Reynolds number."""

from __future__ import annotations

import math

from ...errors import InvalidInput


def height_for(y_plus: float, reynolds: float, chord: float) -> float:
    """The first height at a wall for a value of y+, by the friction of a turbulent flat plate.

    ``y = y+ nu / u_tau`` with ``u_tau = U sqrt(c_f / 2)`` and ``c_f = 0.026 Re^(-1/7)``.

    Parameters
    ----------
    y_plus : float
        Height of the first point in wall units; about 1 where the viscous layer is resolved, 30 and more with wall
        functions.
    reynolds : float
        Reynolds number of the chord.
    chord : float
        Length of the chord.

    Returns
    -------
    float
        In the chord's unit.

    Raises
    ------
    InvalidInput
        If one is not positive.

    References
    ----------
    F. M. White, "Fluid Mechanics", 5th edition (2003), section 7.4: flat plates, the one-seventh power law.

    Examples
    --------
    >>> print(f"{height_for(1, 6.5e6, 1.0):.2g}")
    4.1e-06
    """
    for name, value in (("y_plus", y_plus), ("reynolds", reynolds)):
        if not 0 < value < math.inf:
            raise InvalidInput(f"must be greater than zero, got {value:g}", parameter=name)
    friction = 0.026 / reynolds ** (1 / 7)
    return y_plus * chord / (reynolds * math.sqrt(friction / 2))
