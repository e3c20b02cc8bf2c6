"""Random closed sections such as users bring: NACA four digits, waves on them, Bernstein shapes; any trailing edge."""

from collections.abc import Iterator

import numpy as np
from scipy.special import comb

KINDS = ("NACA", "waves", "Bernstein")
EDGES = ("sharp", "blunt", "cusped")


def random_sections(number: int, seed: int) -> Iterator[tuple[str, np.ndarray]]:
    """Kind with trailing edge, and (n, 2) closed loop from the trailing edge over the upper side; the chord is 1.

    Section k of a seed is the same whatever their number.
    """
    for k in range(number):
        kind, edge = KINDS[k % 3], EDGES[k // 3 % 3]
        yield f"{kind}, {edge}", section(np.random.default_rng([seed, k]), kind, edge)


def section(rng: np.random.Generator, kind: str, edge: str) -> np.ndarray:
    """One loop, with 48 to 320 points, whole or rounded as in files."""
    x = chordwise(rng)
    half, middle = four_digits(rng, x) if kind != "Bernstein" else bernstein(rng, x)
    if kind == "waves":
        half = half * (1 + waves(rng, x, 0.15))
        middle = middle + 0.05 * x * (1 - x) * waves(rng, x, 0.5)
    if edge == "cusped":
        half = half * (1 - x**4)
    if edge == "blunt":
        half = half + x * rng.uniform(0.0005, 0.01)
    loop = np.vstack([np.column_stack([x, middle + half])[::-1], np.column_stack([x, middle - half])[1:]])
    if edge != "cusped" and rng.random() < 0.5:  # a cusp rounded is a seam
        loop = loop.round(int(rng.integers(4, 7)))
    return np.vstack([loop if edge == "blunt" else loop[:-1], loop[:1]])


def chordwise(rng: np.random.Generator) -> np.ndarray:
    """Fractions of the chord, closer together at both ends."""
    t = np.linspace(0, 1, int(rng.integers(25, 161)))
    share = rng.uniform(0.5, 1.0)
    return share * (0.5 - 0.5 * np.cos(np.pi * t)) + (1 - share) * t**1.5


def four_digits(rng: np.random.Generator, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Half thickness, closed behind, and mean line of a random NACA four-digit section."""
    thick, camber, at = rng.uniform(0.04, 0.25), rng.uniform(0, 0.06), rng.uniform(0.2, 0.7)
    half = 5 * thick * (0.2969 * np.sqrt(x) - 0.126 * x - 0.3516 * x**2 + 0.2843 * x**3 - 0.1036 * x**4)
    ahead = camber / at**2 * (2 * at * x - x**2)
    behind = camber / (1 - at) ** 2 * (1 - 2 * at + 2 * at * x - x**2)
    return half, np.where(x < at, ahead, behind)


def bernstein(rng: np.random.Generator, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Half thickness and mean line by random Bernstein coefficients (Kulfan's class and shape functions)."""
    basis = np.stack([comb(5, k) * x**k * (1 - x) ** (5 - k) for k in range(6)])
    half = np.sqrt(x) * (1 - x) * (rng.uniform(0.06, 0.3, 6) @ basis)
    return half, x * (1 - x) * (rng.uniform(-0.1, 0.25, 6) @ basis)


def waves(rng: np.random.Generator, x: np.ndarray, height: float) -> np.ndarray:
    """A smooth random function, mostly within ``height``."""
    return height * sum(rng.normal() / k * np.sin(k * np.pi * x + rng.uniform(0, 2 * np.pi)) for k in range(1, 5)) / 2
