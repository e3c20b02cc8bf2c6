"""Sections: their trailing edges, noses and chords."""

import numpy as np
import pytest

from meshcore import gallery
from meshcore.errors import InvalidGeometry
from meshcore.geometry.curves import polyline
from meshcore.geometry.section import Section, winds_round
from meshcore.structured.sections.section_input import section_loop
from tests.airfoil_families import noisy
from tests.section_families import section_of


def joukowski(n=80, offset=-0.1 + 0.08j):
    """A section with a cusp at x = 2."""
    radius = abs(1 - offset)
    start = np.angle(1 - offset)
    z = offset + radius * np.exp(1j * (start + 2 * np.pi * np.arange(n) / n))
    z[0] = 1
    w = z + 1 / z
    return np.column_stack([w.real, w.imag])


@pytest.mark.parametrize(
    ("loop", "edge"),
    [
        (polyline(gallery.airfoil("rae2822"))[:-1, :2], "sharp"),
        (polyline(gallery.airfoil("naca0012"))[:-1, :2], "blunt"),
        (joukowski(200), "cusped"),
        (gallery.circle(24).points[:, :2], "round"),
    ],
)
@pytest.mark.parametrize("start", [0, 17])
@pytest.mark.parametrize("way", [1, -1])
def test_trailing_edges_are_found_from_anywhere_in_any_direction(loop, edge, start, way):
    section = Section.of(np.roll(loop, start, axis=0)[::way])
    assert section.edge == edge
    if edge != "round":
        right = loop[:, 0].max()
        assert section.tail[0] == pytest.approx(right) and section.chord == pytest.approx(np.ptp(loop[:, 0]), rel=5e-3)
        assert section.bisector @ [1, 0] > 0.98 and section.direction @ [1, 0] > 0.99
    if edge == "blunt":
        assert section.base == pytest.approx(0.00252) and section.loop[0, 1] > 0 > section.loop[section.lower, 1]


def test_the_radius_of_a_nose():
    section = Section.of(polyline(gallery.airfoil("naca0012"))[:-1, :2])
    assert section.nose_radius == pytest.approx(1.1019 * 0.12**2, rel=0.7)  # of the middle of a wider part
    assert Section.of(gallery.circle(60).points[:, :2]).nose_radius == pytest.approx(1, rel=0.05)


def test_a_flat_loop_is_none():
    with pytest.raises(InvalidGeometry, match="no area"):
        Section.of(np.array([[0.0, 0], [1, 0], [2, 0]]))


@pytest.mark.parametrize(
    ("family", "seed", "k"), [("noisy", 500, 40), ("plate", 500, 49), ("ellipse", 300, 50), ("pocket", 200, 89)]
)
def test_the_focus_is_inside_however_thin_or_bent_the_nose(family, seed, k):
    section = Section.of(section_loop(section_of(family, seed, k)).loop)
    assert winds_round(section.loop, section.focus)


def test_noise_at_the_nose_is_no_trailing_edge():
    for k in range(28):
        loop = noisy(np.random.default_rng([500, k + 1]))
        assert Section.of(loop).tail[0] > 0.9
    assert Section.of(section_loop(section_of("noisy", 500, 40)).loop).tail[0] > 0.9


def test_an_edge_that_is_rounded_by_few_points_is_no_base():
    cap = np.radians([85, 0, -85])
    loop = np.vstack(
        [np.column_stack([1 + 0.01 * np.cos(cap), 0.01 * np.sin(cap)]), [[0.3, -0.05], [0, 0], [0.3, 0.05]]]
    )
    section = Section.of(loop)
    assert section.edge != "blunt" and section.tail[0] > 1
    flat = Section.of(np.insert(loop, 1, 0.5 * (loop[0] + loop[2]), axis=0)[[0, 1, 3, 4, 5, 6]])
    assert flat.edge == "blunt" and flat.base == pytest.approx(0.02 * np.sin(np.radians(85)))
