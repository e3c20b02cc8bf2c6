"""Sections of every kind that users have, at random: airfoils by formula, measured ones, blades, vehicles, bad cases.

Each maker takes a generator of random numbers and gives (n, 2) different points once round; `random_of` draws from
all of them, and `as_brought` treats a loop as files and other programs do.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from tests import bodies
from tests.airfoil_families import AIRFOILS

Maker = Callable[[np.random.Generator], np.ndarray]


# ---- bodies of few corners


def _outline(rng: np.random.Generator, corners: np.ndarray) -> np.ndarray:
    """Corners alone, or with points between: as many on each side, or evenly by length."""
    corners = np.asarray(corners, float)
    kind, n = int(rng.integers(3)), int(rng.choice([2, 5, 12, 30]))
    if kind == 0:
        return corners
    ends = np.roll(corners, -1, axis=0)
    length = np.linalg.norm(ends - corners, axis=1)
    counts = (
        np.full(len(corners), n) if kind == 1 else np.maximum(1, np.round(4 * n * length / length.sum())).astype(int)
    )
    return np.concatenate(
        [a + np.arange(c)[:, None] / c * (b - a) for a, b, c in zip(corners, ends, counts, strict=True)]
    )


def wedge(rng: np.random.Generator) -> np.ndarray:
    """Triangles that point forward or backward, 2 to 60 degrees."""
    half = np.tan(np.radians(rng.uniform(1, 30)))
    return _outline(rng, [[0, 0], [1, -half], [1, half]] if rng.random() < 0.5 else [[1, 0], [0, half], [0, -half]])


def diamond(rng: np.random.Generator) -> np.ndarray:
    """Double wedges, 2 to 50 % thick."""
    half, at = rng.uniform(0.01, 0.25), rng.uniform(0.2, 0.8)
    return _outline(rng, [[1, 0], [at, half], [0, 0], [at, -half]])


def plate(rng: np.random.Generator) -> np.ndarray:
    """Flat plates, 0.1 to 2 % thick: square or round or sharp ends."""
    half = 0.5 * 10 ** rng.uniform(-3, -1.7)
    kind = int(rng.integers(3))
    if kind == 0:
        return _outline(rng, [[0, -half], [1, -half], [1, half], [0, half]])
    if kind == 1:
        return _outline(rng, [[0, 0], [0.1, -half], [0.9, -half], [1, 0], [0.9, half], [0.1, half]])
    a = np.linspace(-np.pi / 2, np.pi / 2, int(rng.integers(4, 16)))
    cap = half * np.column_stack([np.cos(a), np.sin(a)])
    x = np.linspace(0, 1, int(rng.integers(10, 80)))[1:-1]
    top = np.column_stack([x, 0 * x + half])
    return np.vstack([cap + [1, 0], top[::-1], -cap, top * [1, -1]])


def ellipse(rng: np.random.Generator) -> np.ndarray:
    """Circles, and ellipses to a hundredth as thick as long, evenly by angle."""
    angle = np.linspace(0, 2 * np.pi, int(rng.integers(8, 250)), endpoint=False) + rng.choice([0, rng.uniform(0, 1)])
    return np.column_stack([np.cos(angle), rng.choice([1.0, 10 ** rng.uniform(-2, 0)]) * np.sin(angle)])


def regular(rng: np.random.Generator) -> np.ndarray:
    """Regular polygons of three to eight sides, and any triangle that is not too flat."""
    if rng.random() < 0.3:
        return _outline(rng, [[0, 0], [1, 0], [rng.uniform(-0.5, 1.5), rng.uniform(0.05, 1)]])
    angle = 2 * np.pi * np.arange(n := int(rng.integers(3, 9))) / n
    return _outline(rng, np.column_stack([np.cos(angle), np.sin(angle)]))


def star(rng: np.random.Generator) -> np.ndarray:
    """Stars of four to nine points."""
    m = int(rng.integers(4, 10))
    angle, radius = np.pi * np.arange(2 * m) / m, np.where(np.arange(2 * m) % 2, rng.uniform(0.3, 0.9), 1.0)
    return _outline(rng, radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle)]))


def gear(rng: np.random.Generator) -> np.ndarray:
    """Gears of 6 to 20 teeth."""
    m, depth = int(rng.integers(6, 21)), rng.uniform(0.05, 0.25)
    angle = 2 * np.pi * (np.arange(m)[:, None] + np.array([0, 0.15, 0.5, 0.65])) / m
    radius = np.broadcast_to([1 - depth, 1, 1, 1 - depth], angle.shape).ravel()
    return _outline(rng, radius[:, None] * np.column_stack([np.cos(angle.ravel()), np.sin(angle.ravel())]))


def ell(rng: np.random.Generator) -> np.ndarray:
    """L, T and step shapes."""
    a, b = rng.uniform(0.15, 0.8, 2)
    if rng.random() < 0.4:
        return _outline(rng, [[-1, 0], [1, 0], [1, a], [b, a], [b, 1], [-b, 1], [-b, a], [-1, a]])
    return _outline(rng, [[0, 0], [1, 0], [1, a], [b, a], [b, 1], [0, 1]])


def vehicle(rng: np.random.Generator) -> np.ndarray:
    """Cars and trucks in profile."""
    h, b, w = rng.uniform(0.15, 0.3), rng.uniform(0.1, 0.25), rng.uniform(0.02, 0.12)
    if rng.random() < 0.5:
        top = [[1, 0], [1, h], [0.9, h + 0.3 * w], [0.75, h + b], [0.45, h + b], [0.3, h], [0.02, 0.8 * h], [0, 0.1]]
    else:
        top = [[1, 0], [1, h + b], [0.3, h + b], [0.3, h], [0.27, h], [0.22, h + 0.7 * b], [0.02, h], [0, 0]]
    return _outline(rng, top)


def deck(rng: np.random.Generator) -> np.ndarray:
    """Bridge decks: boxes with fairings, and with kerbs."""
    d, e = rng.uniform(0.05, 0.15), rng.uniform(0.05, 0.2)
    corners = [[-1, 0], [-1 + e, -d], [1 - e, -d], [1, 0], [1 - 0.5 * e, 0.3 * d], [-1 + 0.5 * e, 0.3 * d]]
    if rng.random() < 0.4:
        k = rng.uniform(0.02, 0.06)
        kerb = [[0.8, 0.3 * d], [0.8, 0.3 * d + k], [0.76, 0.3 * d + k], [0.76, 0.3 * d]]
        corners = [*corners[:5], *[p for p in kerb if p[0] < 1 - 0.5 * e - 0.01], corners[5]]
    return _outline(rng, corners)


def kinked(rng: np.random.Generator) -> np.ndarray:
    """Polygons that can be seen whole from inside, of 5 to 40 unequal corners."""
    n = int(rng.integers(5, 41))
    angle = 2 * np.pi * (np.arange(n) + rng.uniform(-0.35, 0.35, n)) / n
    radius = rng.uniform(rng.uniform(0.35, 0.9), 1.0, n)
    return _outline(rng, np.column_stack([radius * np.cos(angle), rng.uniform(0.2, 1) * radius * np.sin(angle)]))


def pocket(rng: np.random.Generator) -> np.ndarray:
    """U and C shapes: bays up to three times as deep as wide, with sharp or round walls."""
    if rng.random() < 0.5:
        a, depth = rng.uniform(0.15, 0.35), rng.uniform(0.2, 0.8)
        return _outline(rng, [[0, 0], [1, 0], [1, 1], [1 - a, 1], [1 - a, 1 - depth], [a, 1 - depth], [a, 1], [0, 1]])
    mouth, thick = np.radians(rng.uniform(40, 120)), rng.uniform(0.1, 0.4)
    angle = np.linspace(mouth, 2 * np.pi - mouth, int(rng.integers(20, 80)))
    ring = np.column_stack([np.cos(angle), np.sin(angle)])
    return np.vstack([ring, (1 - thick) * ring[::-1]])


def sail(rng: np.random.Generator) -> np.ndarray:
    """Thin arcs, 0.3 to 3 % thick and curved by up to 120 degrees."""
    turned, half = np.radians(rng.uniform(10, 120)), 0.5 * 10 ** rng.uniform(-2.5, -1.5)
    angle = np.linspace(-turned / 2, turned / 2, int(rng.integers(10, 100)))
    line = np.column_stack([np.sin(angle), np.cos(angle)]) / (2 * np.sin(turned / 2))
    out = np.column_stack([np.sin(angle), np.cos(angle)])
    return np.vstack([(line + half * out)[::-1], line - half * out])


def few(rng: np.random.Generator) -> np.ndarray:
    """Three to seven points anywhere round a middle."""
    n = int(rng.integers(3, 8))
    angle = np.sort(2 * np.pi * (np.arange(n) + rng.uniform(-0.4, 0.4, n)) / n)
    return rng.uniform(0.4, 1, n)[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])


FAMILIES: dict[str, Maker] = {
    **AIRFOILS,
    "turbine": bodies.turbine,
    "wedge": wedge,
    "diamond": diamond,
    "plate": plate,
    "ellipse": ellipse,
    "regular": regular,
    "star": star,
    "gear": gear,
    "L, T": ell,
    "vehicle": vehicle,
    "deck": deck,
    "kinked": kinked,
    "bay": bodies.bay,
    "pocket": pocket,
    "sail": sail,
    "few points": few,
}


# ---- as they are brought


def as_brought(rng: np.random.Generator, loop: np.ndarray) -> np.ndarray:
    """(n, 2 or 3) points as a user has them: half of them as made, others turned, moved, scaled, rounded, doubled."""
    closed = np.vstack([loop, loop[:1]])
    if rng.random() < 0.5:
        return closed
    if rng.random() < 0.3:
        loop = loop.round(int(rng.integers(4, 8)))
    if rng.random() < 0.3:
        loop = np.roll(loop, int(rng.integers(len(loop))), axis=0)
    if rng.random() < 0.3:
        loop = loop[::-1]
    if rng.random() < 0.3:
        loop = np.repeat(loop, 1 + (rng.random(len(loop)) < 0.1), axis=0)
    if rng.random() < 0.4:
        c, s = np.cos(a := rng.uniform(0, 2 * np.pi)), np.sin(a)
        loop = loop @ np.array([[c, s], [-s, c]])
    if rng.random() < 0.2:
        loop = loop + rng.uniform(-1, 1, 2) * 10 ** rng.uniform(0, 4)
    if rng.random() < 0.3:
        loop = loop * 10 ** rng.uniform(-6, 6)
    closed = np.vstack([loop, loop[:1]])
    if rng.random() < 0.1:  # a plane of any attitude
        return closed @ np.linalg.qr(rng.normal(size=(3, 3)))[0][:2]
    return closed


def random_of(number: int, seed: int, families: dict[str, Maker] = FAMILIES) -> Iterator[tuple[str, np.ndarray]]:
    """Family and points of section k of a seed, the same whatever their number, families in turn."""
    names = list(families)
    for k in range(number):
        yield names[k % len(names)], section_of(names[k % len(names)], seed, k)


def section_of(family: str, seed: int, k: int) -> np.ndarray:
    """Section k of a seed."""
    rng = np.random.default_rng([seed, k])
    return as_brought(rng, FAMILIES[family](rng))
