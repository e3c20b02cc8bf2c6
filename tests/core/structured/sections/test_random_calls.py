"""Random parameters of grids round sections: a sound grid, or an error that names the parameter or the place."""

import warnings

import numpy as np
import pytest

import meshcore as mc
from meshcore import gallery
from meshcore.errors import GenerationFailed, InvalidInput
from tests import naive
from tests.section_trials import METHODS
from tests.sections import random_sections

LAWS = ("uniform", "geometric", "hyperbolic tangent", "hyperbolic sine", "cosine", "curvature", "poisson", "copied")
SECTIONS = [gallery.airfoil("naca0012"), gallery.circle(5), gallery.circle(30)]
SECTIONS += [section for _, section in random_sections(9, 21)]


def length(rng):
    return float(10 ** (rng.uniform(-10, 1) if rng.random() < 0.4 else rng.uniform(-3, -1)))


OF_ALL = {
    "method": lambda rng: str(rng.choice(METHODS)),
    "law_i": lambda rng: str(rng.choice(LAWS)),
    "around": lambda rng: int(rng.choice([3, 4, 7, 30, 90])),
    "layers": lambda rng: int(rng.choice([1, 2, 3, 20])),
    "growth": lambda rng: float(rng.uniform(1.1, 3)),
    "radius": lambda rng: float(10 ** rng.uniform(0, 2)),
    "first_height": length,
    "leading_spacing": length,
    "trailing_spacing": length,
}
OF_C = {
    "wake": lambda rng: float(10 ** rng.uniform(-1, 1.5)),
    "wake_cells": lambda rng: int(rng.choice([1, 2, 3, 30])),
    "wake_growth": lambda rng: float(rng.uniform(1.1, 3)),
    "wake_spacing": length,
    "outflow_spacing": length,
    "wake_height": length,
    "wake_angle": lambda rng: float(rng.uniform(-45, 45)),
    "base": lambda rng: str(rng.choice(["block", "wrapped"])),
}


@pytest.mark.parametrize("seed", range(45))
def test_random_parameters_make_a_sound_grid_or_a_clear_error(seed):
    rng = np.random.default_rng([77, seed])
    make, own = ((mc.o_grid, {}), (mc.c_grid, OF_C), (mc.h_grid, {}))[seed % 3]
    keywords = {name: draw(rng) for name, draw in {**OF_ALL, **own}.items() if rng.random() < 0.35}
    section = SECTIONS[rng.integers(len(SECTIONS))]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            grid, _ = make(section, **keywords)
        except InvalidInput as error:
            assert error.parameter in {*keywords, "around", "first_height", "section"}, keywords
            return
        except GenerationFailed as error:
            assert len(error.cells) and error.partial is not None
            return
    for block in grid.blocks if isinstance(grid, mc.MultiBlock) else (grid,):
        assert (naive.cross_areas(block.points[:, :, 0]) > 0).all(), keywords
