"""Random planar straight-line graphs for property tests."""

import numpy as np
from hypothesis import strategies as st

from meshcore import Mesh
from tests import naive


def loop_lines(n, start=0):
    """Lines around a loop of n points."""
    return [(start + k, start + (k + 1) % n) for k in range(n)]


def loops(*polygons):
    """Boundary of several closed polygons."""
    lines, start = [], 0
    for polygon in polygons:
        lines += loop_lines(len(polygon), start)
        start += len(polygon)
    return Mesh(np.concatenate([np.asarray(p, float) for p in polygons]), {"line": lines})


@st.composite
def framed_segments(draw, side=8, most=14):
    """A square frame with random segments between grid points inside, none crossing another; some touch."""
    wanted = draw(st.lists(st.tuples(*[st.integers(1, side - 1)] * 4), min_size=0, max_size=most))
    singles = draw(st.lists(st.tuples(*[st.integers(1, side - 1)] * 2), max_size=6))
    kept = []
    for a, b, c, d in wanted:
        new = ((a, b), (c, d))
        if new[0] != new[1] and not any(naive.segments_cross(*new, *old) for old in kept):
            kept.append(new)
    return frame_mesh(side, kept, singles)


def frame_mesh(side, segments, singles=()):
    """A square frame of four lines, segments, and single points as "vertex" cells."""
    corners = [(0, 0), (side, 0), (side, side), (0, side)]
    points = list(corners) + [p for segment in segments for p in segment] + list(singles)
    lines = loop_lines(4) + [(4 + 2 * k, 5 + 2 * k) for k in range(len(segments))]
    cells = {"line": lines}
    if singles:
        cells["vertex"] = [[len(points) - len(singles) + k] for k in range(len(singles))]
    return Mesh(np.array(points, float), cells)


@st.composite
def star_polygons(draw, most=24):
    """A polygon around the origin with random radii: sharp spikes and notches."""
    n = draw(st.integers(5, most))
    radii = draw(st.lists(st.floats(0.05, 1.0), min_size=n, max_size=n))
    offset = draw(st.floats(0, 6.0))
    angle = offset + 2 * np.pi * np.arange(n) / n
    return np.column_stack([np.cos(angle), np.sin(angle)]) * np.array(radii)[:, None]


def comb(teeth, height, width=0.5):
    """A comb with deep, narrow gaps."""
    points = [(0.0, 0.0), (float(teeth), 0.0)]
    for k in reversed(range(teeth)):
        top = 1.0 + height * (k % 2 == 0)
        points += [(k + width, top), (k + 0.0, top)]
    return np.array(points)
