"""Random closed sections beside airfoils of four digits: five digits, Joukowski, measured, turbine blades, bodies."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tests.sections import chordwise


def random_bodies(number: int, seed: int) -> Iterator[tuple[str, np.ndarray]]:
    """Kind and (n, 2) closed loop, the last point of which is the first; of extent about one.

    Body k of a seed is the same whatever their number.
    """
    kinds = list(BODIES)
    for k in range(number):
        kind = kinds[k % len(kinds)]
        loop = BODIES[kind](np.random.default_rng([seed, k]))
        yield kind, np.vstack([loop, loop[:1]])


def _from_sides(x: np.ndarray, upper: np.ndarray, lower: np.ndarray, blunt: bool) -> np.ndarray:
    """Loop from the trailing edge over the upper side, both sides of which stand at the same x."""
    loop = np.vstack([np.column_stack([x, upper])[::-1], np.column_stack([x, lower])[1:]])
    return loop if blunt else loop[:-1]


def five_digits(rng: np.random.Generator) -> np.ndarray:
    """NACA 230xx and its kin, with blunt or sharp edges, 20 to 400 points."""
    n = int(rng.integers(11, 201))
    x = 0.5 - 0.5 * np.cos(np.linspace(0, np.pi, n))
    thick, m = rng.uniform(0.06, 0.24), rng.uniform(0.06, 0.39)
    k = rng.uniform(0.03, 0.2) / m**3  # a camber of some per cent
    line = np.where(x < m, k / 6 * (x**3 - 3 * m * x**2 + m**2 * (3 - m) * x), k * m**3 / 6 * (1 - x))
    blunt = bool(rng.random() < 0.5)
    last = 0.1015 if blunt else 0.1036
    half = 5 * thick * (0.2969 * np.sqrt(x) - 0.126 * x - 0.3516 * x**2 + 0.2843 * x**3 - last * x**4)
    return _from_sides(x, line + half, line - half, blunt)


def joukowski(rng: np.random.Generator) -> np.ndarray:
    """Cusped sections, evenly spaced on their circle."""
    centre = complex(-rng.uniform(0.05, 0.2), rng.uniform(0, 0.25))
    start = np.angle(1 - centre)
    angle = start + np.linspace(0, 2 * np.pi, int(rng.integers(30, 300)), endpoint=False)
    z = centre + abs(1 - centre) * np.exp(1j * angle)
    z = z + 1 / z
    return np.column_stack([z.real, z.imag]) / np.ptp(z.real)


def measured(rng: np.random.Generator) -> np.ndarray:
    """Bezier sides with the noise of a measurement, and an edge of finite thickness."""
    x = chordwise(rng)
    n = len(x)
    camber, thick, base = rng.uniform(-0.02, 0.1), rng.uniform(0.05, 0.16), rng.uniform(0.001, 0.02)
    half = thick * 1.5 * np.sqrt(x) * (1 - x) * (1 + rng.uniform(0, 1) * x) + base / 2 * x
    line = 4 * camber * x * (1 - x)
    noise = 10 ** rng.uniform(-5.5, -3.7) * rng.normal(size=(2, n)) * np.minimum(1, 20 * x * (1 - x))
    return _from_sides(x, line + half + noise[0], line - half + noise[1], True).round(5)


def turbine(rng: np.random.Generator) -> np.ndarray:
    """Blades that turn the flow by 60 to 120 degrees, with round edges."""
    turned = np.radians(rng.uniform(60, 120))
    nose, tail, most = rng.uniform(0.02, 0.06), rng.uniform(0.008, 0.03), rng.uniform(0.06, 0.12)
    n = int(rng.integers(25, 120))
    t = 0.5 - 0.5 * np.cos(np.linspace(0, np.pi, n))
    angle = turned * (0.5 - t)
    radius = 0.5 / np.sin(turned / 2)
    line = radius * np.column_stack([np.sin(-angle), np.cos(angle)])
    out = np.column_stack([np.sin(-angle), np.cos(angle)])
    half = nose + (tail - nose) * t + most * (4 * t * (1 - t)) ** 1.2 * (1 - 0.5 * t)
    upper, lower = line + half[:, None] * out, line - half[:, None] * out

    def cap(start: np.ndarray, stop: np.ndarray) -> np.ndarray:
        middle, arm = 0.5 * (start + stop), 0.5 * (start - stop)
        a = np.linspace(0, np.pi, int(rng.integers(8, 20)))[1:-1, None]
        return middle + np.cos(a) * arm + np.sin(a) * np.array([-arm[1], arm[0]])

    return np.vstack([upper[::-1], cap(upper[0], lower[0]), lower, cap(lower[-1], upper[-1])])


def ellipse(rng: np.random.Generator) -> np.ndarray:
    """Circles and ellipses down to a tenth as thick as long."""
    angle = np.linspace(0, 2 * np.pi, int(rng.integers(16, 200)), endpoint=False)
    return np.column_stack([np.cos(angle), rng.choice([1.0, rng.uniform(0.1, 1)]) * np.sin(angle)])


def _polygon(corners: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Corners alone, or with points on the sides, turned by any angle."""
    n = int(rng.choice([1, 4, 15, 30]))
    share = np.arange(n)[:, None] / n
    loop = np.concatenate([a + share * (b - a) for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)])
    turn = rng.uniform(0, 2 * np.pi) if rng.random() < 0.5 else 0.0
    c, s = np.cos(turn), np.sin(turn)
    return loop @ np.array([[c, s], [-s, c]])


def rectangle(rng: np.random.Generator) -> np.ndarray:
    """From squares to plates."""
    a = rng.choice([1.0, rng.uniform(0.05, 1)])
    return _polygon(np.array([[0, 0], [1, 0], [1, a], [0, a]]), rng)


def triangle(rng: np.random.Generator) -> np.ndarray:
    """No angle below twenty degrees or so."""
    return _polygon(np.array([[0, 0], [1, 0], [rng.uniform(0, 1), rng.uniform(0.35, 1)]]), rng)


def star(rng: np.random.Generator) -> np.ndarray:
    """With four to seven points."""
    m = int(rng.integers(4, 8))
    angle = np.pi * np.arange(2 * m) / m
    radius = np.where(np.arange(2 * m) % 2, rng.uniform(0.4, 0.8), 1.0)
    return _polygon(radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle)]), rng)


def ell(rng: np.random.Generator) -> np.ndarray:
    """L-shapes."""
    a, b = rng.uniform(0.2, 0.7, 2)
    return _polygon(np.array([[0, 0], [1, 0], [1, a], [b, a], [b, 1], [0, 1]]), rng)


def bay(rng: np.random.Generator) -> np.ndarray:
    """Smooth bodies with bays."""
    angle = np.linspace(0, 2 * np.pi, int(rng.integers(60, 250)), endpoint=False)
    waves = sum(rng.normal() / m**1.3 * np.cos(m * angle + rng.uniform(0, 7)) for m in range(2, 7))
    radius = np.maximum(1 + 0.3 * waves, 0.3)
    return radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])


BODIES = {
    "five digits": five_digits,
    "Joukowski": joukowski,
    "measured": measured,
    "turbine": turbine,
    "ellipse": ellipse,
    "rectangle": rectangle,
    "triangle": triangle,
    "star": star,
    "L-shape": ell,
    "bay": bay,
}
"""Makers of one loop each, (n, 2) counter-clockwise, the first point not repeated."""
