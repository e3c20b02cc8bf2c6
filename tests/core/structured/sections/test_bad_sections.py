"""Sections spoilt at random: each gets a sound grid or a `MeshcoreError`, never a warning of arithmetic or a crash."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import meshcore as mc
from meshcore import gallery
from meshcore.geometry.curves import polyline

SPECIAL = [np.nan, np.inf, -np.inf, 1e300, 1e-300, 1e154, 5e-324, 0.0, 1e18]
NUMBERS = [0, -1, 5e-324, 1e300, np.nan, np.inf, 1.0, 3.5, 1e9, "a", None, True, 0.1, 10**9, 2**70]
NAMES = ["first_height", "y_plus", "reynolds", "growth", "layers", "around", "leading_spacing", "radius", "method"]


def spoilt(rng: np.random.Generator, p: np.ndarray) -> np.ndarray:
    """(n, 3) points with one fault of many kinds."""
    i, j, one = *rng.integers(len(p), size=2), p.copy()
    one[i, rng.integers(3)] = rng.choice(SPECIAL)
    same, kinked = p.copy(), p.copy()
    same[i], kinked[i, :2] = p[j], p[i, :2] + rng.normal(size=2)
    off = p + [0, 0, 1] * rng.normal(size=p.shape) * 10 ** rng.uniform(-12, 0)
    faults = [one, same, kinked, off, p[:-1], p[: rng.integers(4)], p * [1, 0, 1], rng.permutation(p), p[::-1]]
    faults += [p * 10.0 ** rng.uniform(-320, 300), p + 10.0 ** rng.uniform(0, 20), p[:, : rng.integers(3)]]
    faults += [np.vstack([p, p[1:]]), np.vstack([p, p[::-1]]), np.repeat(p, 2, axis=0), p[None], p.astype(complex)]
    return faults[rng.integers(len(faults))]


@pytest.mark.parametrize("make", [mc.o_grid, mc.c_grid, mc.h_grid])
def test_spoilt_sections_and_numbers_get_a_grid_or_an_error_that_says_so(make):
    made = refused = 0
    for seed in range(60):
        rng = np.random.default_rng(seed)
        section = polyline([gallery.circle(16), gallery.airfoil("naca0012"), gallery.square(3)][seed % 3])
        section = spoilt(rng, section) if seed % 4 else section
        options = {str(rng.choice(NAMES)): NUMBERS[rng.integers(len(NUMBERS))] for _ in range(seed % 3)}
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            try:
                make(section, **options)
                made += 1
            except mc.MeshcoreError as error:
                assert len(str(error)) > 20
                refused += 1
    assert made > 5 and refused > 20
