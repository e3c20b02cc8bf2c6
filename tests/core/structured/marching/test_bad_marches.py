"""Whatever planar marches are given, they answer with a sound grid or with an error that tells what is wrong."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import meshcore as mc
from meshcore.errors import MeshcoreError
from meshcore.structured.folds import folded_cells
from meshcore.structured.marching import parabolic_march
from meshcore.structured.marching.hyperbolic_march import Dissipation, marched

BAD = [np.nan, np.inf, -np.inf, 0.0, -1.0, 1e-300, 1e300, 5e-324, 1.7e308]
SIZES = st.one_of(st.sampled_from(BAD), st.floats(1e-6, 10.0))
PLACES = st.one_of(st.sampled_from([0.0, 1.0, np.nan, np.inf, 1e300, 1e-300, -1e160]), st.floats(-2, 2, width=16))
POINTS = st.lists(st.tuples(PLACES, PLACES), min_size=0, max_size=9)
RING = [(0.0, 0.0), (0.5, -0.1), (1.0, 0.0), (1.0, 1.0), (0.4, 1.2), (0.0, 1.0), (0.0, 0.0)]
MANY = settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])


def sound_or_refused(call):
    """The grid, all cells of which are sound, or None if it was refused."""
    try:
        grid, report = call()
    except MeshcoreError as error:
        assert len(str(error)) > 10
        return None
    assert np.isfinite(grid.points).all() and not folded_cells(grid.points[:, :, 0]).any()
    assert report.counts["layers"] == grid.shape[1] - 1
    return grid


@MANY
@given(POINTS, st.booleans(), st.booleans())
def test_any_front(points, closed, other_side):
    points = points + points[:1] if closed else points
    front = np.array(points, float).reshape(-1, 2)
    sound_or_refused(lambda: mc.hyperbolic(front, layers=4, other_side=other_side))
    sound_or_refused(lambda: mc.parabolic(front, np.array(RING) * 20 - 10, layers=4))


@MANY
@given(SIZES, SIZES, st.one_of(st.none(), st.integers(-2, 12), st.just(10**9)), st.one_of(st.none(), SIZES))
def test_any_heights(first, growth, layers, distance):
    asked = {"first_height": first, "growth": growth, "layers": layers}
    sound_or_refused(lambda: mc.hyperbolic(np.array(RING), distance=distance, **asked))
    sound_or_refused(lambda: mc.hyperbolic(np.array(RING), outer=np.array(RING) * 20 - 10, **asked))
    sound_or_refused(lambda: mc.parabolic(np.array(RING), np.array(RING) * 20 - 10, **asked))


@MANY
@given(SIZES, SIZES, SIZES, SIZES)
def test_any_smoothing(smoothing, implicitness, sharing, averaging):
    keywords = {"volume_smoothing": sharing, "volume_averaging": averaging}
    sound_or_refused(
        lambda: mc.hyperbolic(np.array(RING), layers=6, smoothing=smoothing, implicitness=implicitness, **keywords)
    )


@MANY
@given(st.lists(SIZES, min_size=0, max_size=6), POINTS)
def test_any_given_heights_and_outer_curve(heights, outer):
    given_heights = np.array(heights, float)
    sound_or_refused(lambda: mc.hyperbolic(np.array(RING), heights=given_heights))
    curve = np.array([*outer, *outer[:1]], float).reshape(-1, 2)
    sound_or_refused(lambda: mc.hyperbolic(np.array(RING), outer=curve, layers=5))
    sound_or_refused(lambda: mc.parabolic(np.array(RING), curve, layers=5))


@pytest.mark.parametrize("bad", [np.ones((3, 2)) * 1j, "front", None, [[0, 1], [2]], np.ones((4, 4)), 7, [["a", "b"]]])
def test_what_is_no_front_is_refused(bad):
    for call in (lambda: mc.hyperbolic(bad), lambda: mc.parabolic(bad, np.array(RING))):
        with pytest.raises(MeshcoreError):
            call()


@pytest.mark.parametrize("layers", [10**8, 10**15])
def test_layers_that_would_fill_the_memory_are_refused(layers):
    ring = np.array(RING)
    for call in (
        lambda: mc.hyperbolic(ring, layers=layers),
        lambda: mc.hyperbolic(ring, outer=ring * 20 - 10, layers=layers),
        lambda: mc.parabolic(ring, ring * 20 - 10, layers=layers),
        lambda: mc.hyperbolic(ring, first_height=1e-12, growth=1.0, distance=1.0),
    ):
        with pytest.raises(MeshcoreError):
            call()


@pytest.mark.parametrize("name", ["base", "implicitness", "volume_smoothing", "volume_averaging"])
@pytest.mark.parametrize("value", [np.nan, -0.1, 5.0])
def test_bad_dissipation(name, value):
    with pytest.raises(MeshcoreError, match=name):
        Dissipation(**{name: value})


@MANY
@given(POINTS, st.lists(SIZES, min_size=0, max_size=4), st.booleans())
def test_marches_of_arrays(points, heights, closed):
    front = np.array(points, float).reshape(-1, 2)
    for call in (
        lambda: marched(front, np.array(heights), closed=closed),
        lambda: parabolic_march.marched(front, front * 3 + 1, np.array(heights), closed=closed),
    ):
        try:
            with np.errstate(all="ignore"):  # extents are what operations refuse
                found = call()
        except MeshcoreError:
            continue
        assert np.isfinite(found.points).all()
