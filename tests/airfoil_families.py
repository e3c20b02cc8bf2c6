"""Random airfoils: by formula (NACA, conformal maps, Bezier, PARSEC, Kulfan's), and measured ones as users treat them.

Each maker takes a generator of random numbers and gives (n, 2) different points once round.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from scipy.special import comb

from meshcore import gallery
from meshcore.geometry.curves import polyline
from tests.sections import bernstein, waves

# ---- airfoils by formula


def _stations(rng: np.random.Generator, least: int = 6, most: int = 160) -> np.ndarray:
    """Fractions of the chord: few or many, more or less dense at both ends."""
    t = np.linspace(0, 1, int(np.exp(rng.uniform(np.log(least), np.log(most)))))
    share = rng.choice([1.0, rng.uniform(0.3, 1.0)])
    return share * (0.5 - 0.5 * np.cos(np.pi * t)) + (1 - share) * t


def _airfoil(rng: np.random.Generator, x: np.ndarray, half: np.ndarray, line: np.ndarray) -> np.ndarray:
    """Both sides at right angles to a mean line or along y; closed, or open by up to a tenth of the chord."""
    if rng.random() < 0.4:
        half = half + 0.5 * x * 10 ** rng.uniform(-4, -1)
    slope = np.gradient(line, x) if rng.random() < 0.5 else 0 * x
    size = np.hypot(1, slope)
    normal = np.column_stack([-slope / size, 1 / size])
    middle = np.column_stack([x, line])
    loop = np.vstack([(middle + half[:, None] * normal)[::-1], (middle - half[:, None] * normal)[1:]])
    return loop if half[-1] > 1e-12 else loop[:-1]


def _half_thickness(x: np.ndarray, thick: float) -> np.ndarray:
    """Of the four- and five-digit sections, closed behind."""
    return np.maximum(
        5 * thick * (0.2969 * np.sqrt(x) - 0.126 * x - 0.3516 * x**2 + 0.2843 * x**3 - 0.1036 * x**4), 0
    ) * (x < 1)


def naca4(rng: np.random.Generator) -> np.ndarray:
    """All four digits: camber to 9.5 % anywhere, 1 to 40 % thick."""
    x = _stations(rng)
    camber, at, thick = rng.uniform(0, 0.095), rng.uniform(0.1, 0.9), np.exp(rng.uniform(np.log(0.01), np.log(0.4)))
    ahead = camber / at**2 * (2 * at * x - x**2)
    behind = camber / (1 - at) ** 2 * (1 - 2 * at + 2 * at * x - x**2)
    return _airfoil(rng, x, _half_thickness(x, thick), np.where(x < at, ahead, behind))


def naca5(rng: np.random.Generator) -> np.ndarray:
    """Five digits, with and without reflex."""
    x = _stations(rng)
    m, k = rng.uniform(0.06, 0.4), 1.0
    line = np.where(x < m, k / 6 * (x**3 - 3 * m * x**2 + m**2 * (3 - m) * x), k * m**3 / 6 * (1 - x))
    if rng.random() < 0.5:  # reflex: what the moment's zero asks of the camber's place p
        ratio = (3 * (m - 0.75 * m) ** 2 - m**3) / (1 - m) ** 3
        shared = -ratio * (1 - m) ** 3 * x - m**3 * x + m**3
        line = k / 6 * np.where(x < m, (x - m) ** 3 + shared, ratio * (x - m) ** 3 + shared)
    line = line * rng.uniform(0.01, 0.05) / np.abs(line).max()
    return _airfoil(rng, x, _half_thickness(x, rng.uniform(0.05, 0.3)), line)


def naca6(rng: np.random.Generator) -> np.ndarray:
    """The six-series' mean line a = 0 to 1 (Abbott and von Doenhoff 1959), and the modified thickness of NACA 492."""
    x = _stations(rng)
    a, lift, thick = rng.uniform(0, 0.98), rng.uniform(-0.3, 1.0), rng.uniform(0.04, 0.22)
    most, radius = rng.uniform(0.3, 0.6), rng.uniform(0.2, 1.2)
    d1 = (2.24 - 5.42 * most + 12.3 * most**2) / 10 / (1 - 0.878 * most)
    d2 = (0.294 - 2 * (1 - most) * d1) / (1 - most) ** 2
    d3 = (-0.196 + (1 - most) * d1) / (1 - most) ** 3
    a0 = 0.2969 * radius
    p = 0.2 * (1 - most) ** 2 / (0.588 - 2 * d1 * (1 - most))
    a1 = 0.3 / most - 15 / 8 * a0 / np.sqrt(most) - most / 10 / p
    a2 = -0.3 / most**2 + 5 / 4 * a0 / most**1.5 + 1 / 5 / p
    a3 = 0.1 / most**3 - 0.375 * a0 / most**2.5 - 1 / 10 / p / most
    ahead = a0 * np.sqrt(x) + a1 * x + a2 * x**2 + a3 * x**3
    behind = d1 * (1 - x) + d2 * (1 - x) ** 2 + d3 * (1 - x) ** 3
    half = 5 * thick * np.maximum(np.where(x < most, ahead, behind), 0.01 * x * (1 - x))
    u, v = np.abs(a - x), 1 - x
    log = lambda z: np.log(np.maximum(z, 1e-300))  # noqa: E731
    g = -(a**2 * (0.5 * log(a) - 0.25) + 0.25) / (1 - a)
    h = (0.5 * (1 - a) ** 2 * log(1 - a) - 0.25 * (1 - a) ** 2) / (1 - a) + g
    both = 0.5 * u**2 * log(u) - 0.5 * v**2 * log(v) + 0.25 * v**2 - 0.25 * u**2
    line = lift / (2 * np.pi * (a + 1)) * (both / (1 - a) - x * log(x) + g - h * x)
    return _airfoil(rng, x, half, line)


def karman_trefftz(rng: np.random.Generator) -> np.ndarray:
    """Conformal sections with trailing edges of 0 (Joukowski's cusp) to 40 degrees."""
    centre = complex(-rng.uniform(0.02, 0.25), rng.uniform(-0.1, 0.35))
    n = 2 - np.radians(rng.choice([0.0, rng.uniform(0, 40)])) / np.pi
    angle = np.angle(1 - centre) + np.linspace(0, 2 * np.pi, int(rng.integers(12, 300)), endpoint=False)
    z = centre + abs(1 - centre) * np.exp(1j * angle)
    z[0] = 1.0
    ratio = np.zeros(len(z), complex)
    away = (z[1:] - 1) / (z[1:] + 1)
    ratio[1:] = np.abs(away) ** n * np.exp(1j * n * np.unwrap(np.angle(away)))  # not the principal branch
    w = n * (1 + ratio) / (1 - ratio)
    return np.column_stack([w.real, w.imag]) / np.ptp(w.real)


def bezier(rng: np.random.Generator) -> np.ndarray:
    """Two Bezier curves of random degree from a common nose, possibly of much camber."""
    t = 0.5 - 0.5 * np.cos(np.pi * np.linspace(0, 1, int(rng.integers(8, 150))))
    order = int(rng.integers(4, 9))
    basis = np.stack([comb(order, k) * t**k * (1 - t) ** (order - k) for k in range(order + 1)])
    at = np.concatenate([[0.0], np.sort(rng.uniform(0, 1, order - 1)), [1.0]])
    at[1] = 0.0
    up, low = rng.uniform(0.01, 0.2, (2, order + 1))
    line = rng.uniform(-0.05, 0.25, order + 1)
    for ends in (up, low, line):
        ends[[0, -1]] = 0.0
    up[-1] = low[-1] = rng.choice([0.0, rng.uniform(0, 0.02)])
    x = at @ basis
    upper, lower = (line + up) @ basis, (line - low) @ basis
    loop = np.vstack([np.column_stack([x, upper])[::-1], np.column_stack([x, lower])[1:]])
    return loop if up[-1] > 0 else loop[:-1]


def parsec(rng: np.random.Generator) -> np.ndarray:
    """Sobieczky's PARSEC: six powers of sqrt(x) for each side, from nose radius, crest, curvature and edge."""
    x = _stations(rng, 12)
    radius, at = rng.uniform(0.003, 0.03), rng.uniform(0.25, 0.5, 2)
    crest = np.array([rng.uniform(0.04, 0.1), -rng.uniform(0.02, 0.08)])
    bend = np.array([-rng.uniform(0.3, 0.8), rng.uniform(0.3, 0.8)])
    angle, wedge, base = np.radians(rng.uniform(-12, 2)), np.radians(rng.uniform(3, 20)), rng.choice([0, 0.004])
    power = np.arange(6) + 0.5
    sides = []
    for side, sign in enumerate((1, -1)):
        a = at[side]
        rows = [
            np.ones(6),
            a**power,
            power,
            power * a ** (power - 1),
            power * (power - 1) * a ** (power - 2),
            np.eye(6)[0],
        ]
        given = [
            sign * base / 2,
            crest[side],
            np.tan(angle - sign * wedge / 2),
            0,
            bend[side],
            sign * (2 * radius) ** 0.5,
        ]
        sides.append(np.linalg.solve(rows, given) @ x[None] ** power[:, None])
    loop = np.vstack([np.column_stack([x, sides[0]])[::-1], np.column_stack([x, sides[1]])[1:]])
    return loop if base else loop[:-1]


def class_shape(rng: np.random.Generator) -> np.ndarray:
    """Kulfan's class and shape functions with random coefficients, and waves."""
    x = _stations(rng)
    half, line = bernstein(rng, x)
    if rng.random() < 0.3:
        half = half * (1 + waves(rng, x, 0.2))
    return _airfoil(rng, x, half, line)


# ---- measured, and what happens to airfoils


@cache
def _airfoils() -> tuple[np.ndarray, ...]:
    return tuple(polyline(gallery.airfoil(name))[:-1, :2] for name in gallery.airfoils())


def _shipped(rng: np.random.Generator) -> np.ndarray:
    return _airfoils()[int(rng.integers(len(_airfoils())))].copy()


def measured(rng: np.random.Generator) -> np.ndarray:
    """One of the twelve as it is."""
    return _shipped(rng)


def decimated(rng: np.random.Generator) -> np.ndarray:
    """One of the twelve on 20 to 60 of its points, evenly or at random."""
    loop = _shipped(rng)
    n = min(len(loop), int(rng.integers(20, 61)))
    if rng.random() < 0.5:
        return loop[np.linspace(0, len(loop), n, endpoint=False).astype(int)]
    return loop[np.sort(rng.choice(len(loop), n, replace=False))]


def noisy(rng: np.random.Generator) -> np.ndarray:
    """One of the twelve with noise of 1e-6 to 3e-4 chords."""
    loop = _shipped(rng)
    return loop + 10 ** rng.uniform(-6, -3.5) * rng.normal(size=loop.shape)


def thickened(rng: np.random.Generator) -> np.ndarray:
    """One of the twelve made up to three times as thick, or a tenth, with a camber of its own."""
    loop = _shipped(rng)
    loop[:, 1] *= np.exp(rng.uniform(np.log(0.1), np.log(3.0)))
    loop[:, 1] += rng.uniform(-0.15, 0.15) * 4 * loop[:, 0] * (1 - loop[:, 0])
    return loop


def cut_off(rng: np.random.Generator) -> np.ndarray:
    """One of the twelve that ends at 70 to 99 % of its chord."""
    loop = _shipped(rng)
    end = rng.uniform(0.7, 0.99)
    kept = loop[loop[:, 0] < end - 1e-3]
    start, stop = (np.interp(end, *side.T) for side in _two_sides(loop))
    return np.vstack([[end, start], kept, [end, stop]])


def _two_sides(loop: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The upper and the lower side, each with growing x."""
    nose = int(np.argmin(loop[:, 0]))
    upper, lower = loop[: nose + 1][::-1], np.vstack([loop[nose:], loop[:1]])
    return upper[np.argsort(upper[:, 0])], lower[np.argsort(lower[:, 0])]


def flapped(rng: np.random.Generator) -> np.ndarray:
    """One of the twelve whose rear is turned down at a kink."""
    loop = _shipped(rng)
    hinge, angle = rng.uniform(0.6, 0.85), np.radians(rng.uniform(5, 40))
    back = np.clip((loop[:, 0] - hinge) / rng.uniform(0.01, 0.1), 0, 1) * angle
    arm = loop - [hinge, 0]
    c, s = np.cos(-back), np.sin(-back)
    return np.column_stack([c * arm[:, 0] - s * arm[:, 1], s * arm[:, 0] + c * arm[:, 1]]) + [hinge, 0]


def iced(rng: np.random.Generator) -> np.ndarray:
    """One of the twelve with one or two horns at its nose, along the normal there."""
    loop = _shipped(rng)
    spacing = np.linalg.norm(np.diff(np.vstack([loop, loop[:1]]), axis=0), axis=1)
    at = np.concatenate([[0.0], np.cumsum(spacing)])
    fine = np.linspace(0, at[-1], int(rng.integers(150, 500)), endpoint=False)
    loop = np.column_stack([np.interp(fine, at, np.append(x, x[0])) for x in loop.T])
    nose = fine[np.argmin(loop[:, 0])]
    along = np.roll(loop, -1, axis=0) - np.roll(loop, 1, axis=0)
    normal = np.column_stack([along[:, 1], -along[:, 0]]) / np.linalg.norm(along, axis=1)[:, None]
    for side in (-1, 1)[: int(rng.integers(1, 3))]:
        width = rng.uniform(0.006, 0.02)
        bump = np.exp(-(((fine - nose - side * rng.uniform(0.01, 0.05)) / width) ** 2))
        loop = loop + rng.uniform(0.005, 0.04) * bump[:, None] * normal
    return loop


def many(rng: np.random.Generator) -> np.ndarray:
    """Airfoils of 500 to 5000 points."""
    n = int(np.exp(rng.uniform(np.log(250), np.log(2500))))
    x = 0.5 - 0.5 * np.cos(np.pi * np.linspace(0, 1, n))
    half, line = _half_thickness(x, rng.uniform(0.08, 0.2)), 4 * rng.uniform(0, 0.06) * x * (1 - x)
    return np.vstack([np.column_stack([x, line + half])[::-1], np.column_stack([x, line - half])[1:-1]])


AIRFOILS = {
    "NACA 4": naca4,
    "NACA 5": naca5,
    "NACA 6": naca6,
    "Karman-Trefftz": karman_trefftz,
    "Bezier": bezier,
    "PARSEC": parsec,
    "class, shape": class_shape,
    "measured": measured,
    "decimated": decimated,
    "noisy": noisy,
    "thickened": thickened,
    "cut off": cut_off,
    "flapped": flapped,
    "iced": iced,
    "many points": many,
}
