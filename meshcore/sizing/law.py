"""`Spacing`: a law and its numbers, as a value that every generator takes for its edges."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from ..errors import InvalidInput
from ..geometry.curves import Curve, arc_length, polyline
from ..operation import Length, absolute
from .along_curve import by_curvature, copied
from .hyperbolic_sine import hyperbolic_sine
from .poisson import poisson
from .spacing import cosine, geometric, hyperbolic_tangent, uniform

Law = Literal[
    "uniform", "geometric", "hyperbolic tangent", "hyperbolic sine", "cosine", "curvature", "poisson", "copied"
]
LAWS: tuple[str, ...] = get_args(Law)
WITH_ENDS = ("geometric", "hyperbolic tangent", "hyperbolic sine", "poisson")
"""Laws that take the lengths of the end cells."""


@dataclass(frozen=True)
class Spacing:
    """How points stand along an edge.

    Parameters
    ----------
    law : str
        "uniform"; "geometric" (a constant ratio); "hyperbolic tangent" and "hyperbolic sine" (Vinokur); "cosine";
        "curvature" (dense where the edge bends); "poisson" (the equation of elliptic edges); "copied" (from `source`).
    first, last : Length, optional
        Lengths of the first and last cell, for the laws that take them; "geometric" takes one of the two.
    ratio : float, optional
        Of "geometric", each cell over the one before it, in place of an end cell.
    ends : {"both", "first", "last"}
        Of "cosine", where cells are small.
    bend : float
        Of "curvature", the share of cells that follow the turning.
    control : tuple of float, optional
        Of "poisson", the control function at the points between the ends, in place of end cells.
    source : Mesh or (n, 3) float, optional
        Of "copied", the curve whose spacing is taken.

    Raises
    ------
    InvalidInput
        If the law is unknown, or a number is given that it does not take.

    References
    ----------
    Survey, section 2.6.

    Examples
    --------
    >>> Spacing("geometric", first=1.0).fractions(3, np.array([[0, 0], [7, 0]])) * 7
    array([0., 1., 3., 7.])
    >>> from meshcore import Relative
    >>> Spacing(last=Relative(0.1)).fractions(3, np.array([[0, 0], [2, 0]])).round(3)
    array([0. , 0.6, 0.9, 1. ])
    """

    law: Law = "hyperbolic tangent"
    first: Length | None = None
    last: Length | None = None
    ratio: float | None = None
    ends: Literal["both", "first", "last"] = "both"
    bend: float = 0.5
    control: tuple[float, ...] | None = None
    source: Curve | None = None

    def __post_init__(self) -> None:
        if self.law not in LAWS:
            raise InvalidInput(f"{self.law!r} is not one of {', '.join(LAWS)}", parameter="law")
        if self.law == "copied" and self.source is None:
            raise InvalidInput("is needed to copy a spacing; give the curve", parameter="source")
        takers = {"first": WITH_ENDS, "last": WITH_ENDS, "ratio": ("geometric",)}
        takers |= {"control": ("poisson",), "source": ("copied",)}
        for name, laws in takers.items():
            if getattr(self, name) is not None and self.law not in laws:
                raise InvalidInput(f"is no number of the law {self.law!r}; leave it out", parameter=name)
        if self.law == "geometric":
            given = [name for name in ("first", "last", "ratio") if getattr(self, name) is not None]
            if len(given) > 1:
                raise InvalidInput(
                    f"and {given[1]} are both given; a constant ratio takes one of them", parameter=given[0]
                )

    def fractions(self, cells: int, curve: Curve, *, diagonal: float | None = None) -> np.ndarray:
        """Where the points stand on a curve, as fractions of its length.

        Parameters
        ----------
        cells : int
            Number of cells.
        curve : Mesh or (n, 3) float
            The edge; its length measures the end cells.
        diagonal : float, optional
            What relative lengths are relative to; by default the diagonal of the curve's own bounding box.

        Returns
        -------
        (cells + 1,) float
            Fractions from 0 to 1, increasing.

        Raises
        ------
        InvalidInput
            If the law cannot have these numbers on this curve.
        """
        points = polyline(curve)
        if diagonal is None:
            diagonal = float(np.linalg.norm(np.ptp(points, axis=0)))
        length = arc_length(points)[-1]
        end = {
            name: absolute(value, diagonal) / length
            for name, value in (("first", self.first), ("last", self.last))
            if value is not None
        }
        if self.law == "uniform":
            return uniform(cells)
        if self.law == "geometric":
            return geometric(cells, ratio=self.ratio, **end) if end or self.ratio else uniform(cells)
        if self.law == "hyperbolic tangent":
            return hyperbolic_tangent(cells, **end)
        if self.law == "hyperbolic sine":
            return hyperbolic_sine(cells, **end)
        if self.law == "cosine":
            return cosine(cells, ends=self.ends)
        if self.law == "curvature":
            return by_curvature(cells, points, bend=self.bend)
        if self.law == "poisson":
            return poisson(cells, control=self.control, **end)
        return copied(cells, self.source)
