"""How the control of walls went, in figures and in words."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Controlled:
    """How the control of walls went.

    Attributes
    ----------
    history : tuple of float
        Residuals, in units of the start's.
    angle, height : float
        Largest errors where they count: degrees, and a share of the height.
    converged : bool
        Whether all of these are small enough.
    good : float, optional
        Share of the points that count where both errors are.
    judged : float
        Share of the points that count.
    asked : (bool, bool)
        Whether angles, and whether first heights are asked for.
    """

    history: tuple[float, ...]
    angle: float
    height: float
    converged: bool
    good: float | None = None
    judged: float = 1.0
    asked: tuple[bool, bool] = (True, True)

    @property
    def quality(self) -> dict[str, float]:
        """What reports say."""
        angles, heights = self.asked
        quality = {"error of wall angles (degree)": float(self.angle)} if angles else {}
        quality |= {"error of first heights (%)": 100 * float(self.height)} if heights else {}
        quality |= {"points at walls that are judged (%)": 100 * self.judged}
        return quality if self.good is None else {**quality, "points at walls as asked (%)": 100 * self.good}

    @property
    def warnings(self) -> list[str]:
        """What users are told."""
        if self.converged:
            return []
        after = f" after {len(self.history) - 2} steps" if len(self.history) > 2 else ""
        angles, heights = self.asked
        off = [f"angles are off by up to {self.angle:.3g} degrees"] if angles else []
        off += [f"heights {'' if angles else 'are off '}by up to {self.height:.1%}"] if heights else []
        return [
            f"walls not controlled{after}: {', '.join(off)}"
            + ("" if self.good is None else f", {self.good:.2%} of the points that are judged are as asked")
            + "; space the sides that end at walls by the first height, take more cells, or ask for less"
        ]
