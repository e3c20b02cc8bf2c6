"""The biharmonic alternative: exact on polynomials, second order, slopes as asked."""

import numpy as np
import pytest

import meshcore as mc
from meshcore import Wall, gallery
from meshcore.errors import InvalidInput
from meshcore.structured.poisson import biharmonic as module
from meshcore.structured.poisson.biharmonic import biharmonic, solve
from meshcore.structured.poisson.wall_control import measured
from meshcore.structured.poisson.winslow import orientation
from tests.core.structured.poisson.test_winslow import annulus, distance, wavy


def with_lost_interior(grid):
    lost = grid.copy()
    lost[2:-2, 2:-2] += np.random.default_rng(4).normal(size=lost[2:-2, 2:-2].shape)
    return lost


def test_cubic_polynomials_are_exact():
    s, t = np.meshgrid(np.linspace(0, 1, 15), np.linspace(0, 1, 22), indexing="ij")
    exact = np.stack([s + 0.3 * s**3 - 0.2 * s * t**2, t + 0.1 * s**3 * t - 0.4 * t**3], axis=-1)
    assert distance(biharmonic(with_lost_interior(exact)), exact) < 1e-10


def test_converges_at_second_order():
    errors = []
    for n in (17, 33, 65):
        s, t = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, n), indexing="ij")
        z = s + 1j * t
        exact = np.stack([(np.conj(z) * np.exp(z)).real, (np.conj(z) * np.exp(z)).imag], axis=-1)
        found = with_lost_interior(exact)
        solve(found, (1.0, 1.0), False)
        errors.append(distance(found, exact))
    assert np.log2(errors[1] / errors[2]) > 1.8


@pytest.mark.parametrize("side", ["south", "east", "north", "west"])
def test_the_next_line_has_angle_and_height_as_asked(side):
    start = wavy(30, 26, 0.08)
    for angle in (90.0, 70.0):
        found = biharmonic(start, [Wall(side, 0.02, angle)])
        have = measured(np.ascontiguousarray(np.moveaxis(found, -1, 0)), side, 1.0, False)
        assert np.abs(have.angle - angle)[2:-2].max() < 1e-9
        assert np.abs(have.height - 0.02)[2:-2].max() < 1e-12
    assert all((found[line] == start[line]).all() for line in (np.s_[0], np.s_[-1], np.s_[:, 0], np.s_[:, -1]))


def test_rings_are_cyclic():
    start = annulus(24, 12, radii=np.geomspace(1, 3, 13))
    spoilt = start.copy()
    spoilt[:, 2:-2] *= 1.1
    found = biharmonic(spoilt, cyclic=True)
    assert (found[0] == found[-1]).all()
    radii = np.linalg.norm(found, axis=-1)
    assert np.ptp(radii, axis=0).max() < 1e-12 and (np.diff(radii[0]) > 0).all()
    walled = biharmonic(start, [Wall("south", 0.05)], cyclic=True)
    have = measured(np.ascontiguousarray(np.moveaxis(walled, -1, 0)), "south", orientation(start), True)
    assert np.abs(have.angle - 90).max() < 1e-9 and np.abs(have.height - 0.05).max() < 1e-12


def test_as_an_equation_of_the_operation():
    sides = gallery.wavy_sides(40, 30)
    grid, report = mc.elliptic(*sides, equation="biharmonic", walls="south and north", first_height=0.02)
    assert report.converged
    assert (grid.points[:, 0, 0] == sides[0]).all()
    heights = np.linalg.norm(grid.points[:, 1, 0] - grid.points[:, 0, 0], axis=1)
    assert np.abs(heights[2:-2] - 0.02).max() < 1e-12


def test_too_many_points_are_refused(monkeypatch):
    monkeypatch.setattr(module, "MOST_POINTS", 100)
    with pytest.raises(InvalidInput, match="at most 100"):
        biharmonic(wavy(20, 20))
