"""Random closed outlines with deep bays, where fronts that march outwards meet: horseshoes, Cs, spirals, combs."""

from collections.abc import Iterator

import numpy as np

KINDS = ("horseshoe", "narrow C", "spiral", "comb")


def random_outlines(number: int, seed: int) -> Iterator[tuple[str, np.ndarray]]:
    """Kind and (n, 2) clockwise loop, its first point not repeated.

    Outline k of a seed is the same whatever their number.
    """
    for k in range(number):
        kind = KINDS[k % len(KINDS)]
        yield kind, outline(np.random.default_rng([seed, k]), kind)


def outline(rng: np.random.Generator, kind: str) -> np.ndarray:
    """One loop of 60 to 400 points, turned by any angle."""
    n, angle = int(rng.integers(60, 401)), rng.uniform(0, 2 * np.pi)
    loop = {"horseshoe": horseshoe, "narrow C": narrow_c, "spiral": spiral, "comb": comb}[kind](rng, n)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return loop @ turn


def horseshoe(rng: np.random.Generator, n: int) -> np.ndarray:
    """A block of size 2 with a slot of parallel sides cut into it."""
    w, top = rng.uniform(0.1, 1.2) / 2, 1 - rng.uniform(0.4, 1.7)
    return subdivided([(-1, -1), (-1, 1), (-w, 1), (-w, top), (w, top), (w, 1), (1, 1), (1, -1)], n)


def narrow_c(rng: np.random.Generator, n: int) -> np.ndarray:
    """A ring with a gap, its ends round or cut off."""
    thick, round_ends = rng.uniform(0.1, 0.5), rng.random() < 0.5
    half = rng.uniform(0.05, 0.9) + round_ends * thick / (2 - thick)
    angle = np.linspace(half, 2 * np.pi - half, 200)
    outside = np.column_stack([np.cos(angle), np.sin(angle)])
    inside = (1 - thick) * outside[::-1]
    if not round_ends:
        return resampled(np.concatenate([outside, inside])[::-1], n)
    cap = np.linspace(0, np.pi, 12)[1:-1]
    caps = []
    for turn, way in ((-half, 1), (half, -1)):
        along, across = np.array([np.cos(turn), np.sin(turn)]), np.array([-np.sin(turn), np.cos(turn)])
        bent = np.cos(cap)[:, None] * along + np.sin(cap)[:, None] * across
        caps.append((1 - thick / 2) * along + way * thick / 2 * bent)
    return resampled(np.concatenate([outside, caps[0], inside, caps[1]])[::-1], n)


def spiral(rng: np.random.Generator, n: int) -> np.ndarray:
    """A band that winds 0.8 to 1.8 times round, its gap as wide as it is or less."""
    turns, pitch = rng.uniform(0.8, 1.8), rng.uniform(0.25, 0.5)
    thick = pitch * rng.uniform(0.3, 0.7)
    angle = np.linspace(0, 2 * np.pi * turns, 400)
    radius = 0.4 + pitch * angle / (2 * np.pi)
    way = np.column_stack([np.cos(angle), np.sin(angle)])
    loop = np.concatenate([(radius + thick / 2)[:, None] * way, ((radius - thick / 2)[:, None] * way)[::-1]])
    return resampled(loop[::-1], n)


def comb(rng: np.random.Generator, n: int) -> np.ndarray:
    """A bar with two to five teeth of any length."""
    teeth, gap = int(rng.integers(2, 6)), rng.uniform(0.15, 0.6)
    corners = [(0.0, 0.0)]
    x = 0.0
    for k in range(teeth):
        length, width = rng.uniform(0.3, 1.2), rng.uniform(0.15, 0.5)
        corners += [(x, length + 0.3), (x + width, length + 0.3)]
        x += width
        if k < teeth - 1:
            corners += [(x, 0.3), (x + gap, 0.3)]
            x += gap
    return subdivided([*corners, (x, 0.0)], n)


def subdivided(corners, n: int) -> np.ndarray:
    """About n points on a polygon, evenly on each side, corners kept."""
    corners = np.asarray(corners, float)
    after = np.roll(corners, -1, axis=0)
    length = np.linalg.norm(after - corners, axis=1)
    counts = np.maximum(1, np.round(n * length / length.sum()).astype(int))
    shares = [np.arange(m)[:, None] / m for m in counts]
    return np.concatenate([a + s * (b - a) for a, b, s in zip(corners, after, shares, strict=True)])


def resampled(loop: np.ndarray, n: int) -> np.ndarray:
    """n points evenly along a closed loop, the first kept."""
    ring = np.concatenate([loop, loop[:1]])
    along = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(ring, axis=0), axis=1))])
    at = along[-1] * np.arange(n) / n
    return np.column_stack([np.interp(at, along, ring[:, 0]), np.interp(at, along, ring[:, 1])])
