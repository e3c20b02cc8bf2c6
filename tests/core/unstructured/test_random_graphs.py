"""Refinement of random planar graphs with random options: what holds whatever is asked for."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from meshcore import InvalidInput, Mesh, constrained_delaunay, delaunay_refinement, quality
from tests.core.unstructured import invariants

PLACEMENTS = ["automatic", "off-centre", "circumcentre", "lattice", "front"]
SPAN = 8
LATTICE_REFUSES = {"size_array", "size_field", "gradation", "split_boundary"}


@st.composite
def graphs(draw):
    """Lines between points of a small grid, in a frame or not: crossing, touching, overlapping, repeated, dangling."""
    point = st.tuples(st.integers(1, SPAN - 1), st.integers(1, SPAN - 1))
    points = draw(st.lists(point, min_size=3, max_size=14))
    index = st.integers(0, len(points) - 1)
    loop = draw(st.booleans())
    lines = [(k, (k + 1) % len(points)) for k in range(len(points))] if loop else []
    lines += draw(st.lists(st.tuples(index, index), min_size=0 if loop else 1, max_size=8))
    if draw(st.booleans()) or not loop:
        n = len(points)
        points += [(0, 0), (SPAN, 0), (SPAN, SPAN), (0, SPAN)]
        lines += [(n + k, n + (k + 1) % 4) for k in range(4)]
    sizes = draw(st.lists(st.sampled_from([0.5, 1.0, 4.0]), min_size=len(points), max_size=len(points)))
    return Mesh(points, {"line": lines}, {"h": np.array(sizes)})


@st.composite
def options(draw):
    """Keywords of `delaunay_refinement`, each as often left out as given."""
    seed = st.tuples(st.floats(0.01, SPAN), st.floats(0.01, SPAN))
    given = {
        "size": st.sampled_from([0.4, 1.0, 20.0]),
        "max_area": st.sampled_from([0.1, 1.0]),
        "min_angle": st.sampled_from([0.0, 20.0, 28.0]),
        "smoothing": st.integers(1, 3),
        "gradation": st.sampled_from([0.2, 1.0]),
        "split_boundary": st.just(False),
        "size_array": st.just("h"),
        "size_field": st.just(lambda points: 0.3 + 0.2 * points[:, 0]),
        "holes": st.lists(seed, min_size=1, max_size=2),
        "regions": st.lists(st.tuples(*[st.floats(0.01, SPAN)] * 2, st.integers(1, 9), st.just(0.2)), max_size=2),
    }
    chosen = draw(st.sets(st.sampled_from(sorted(given)), max_size=4))
    placement = draw(st.sampled_from(PLACEMENTS))
    return {"placement": placement, **{name: draw(given[name]) for name in sorted(chosen)}}


@settings(max_examples=150, deadline=None)
@given(graphs(), options())
def test_what_is_made_of_a_graph_is_valid_and_as_asked(graph, keywords):
    marks = {name: keywords[name] for name in ("holes", "regions") if name in keywords}
    try:
        bare, _ = constrained_delaunay(graph, crossings="split", lines=True, **marks)
    except InvalidInput as error:  # no area, or a seed on a line: then both refuse
        with pytest.raises(type(error)):
            delaunay_refinement(graph, crossings="split", **keywords)
        return
    if keywords["placement"] == "lattice" and (
        not {"size", "max_area"} & set(keywords) or LATTICE_REFUSES & set(keywords)
    ):
        keywords["placement"] = "automatic"
    mesh, report = delaunay_refinement(graph, crossings="split", lines=True, **keywords)
    assert quality.validate(mesh) == []
    flat, plain = (Mesh(m.points, {"triangle": m.get("triangle")}) for m in (mesh, bare))
    assert float(invariants.area(flat)) == pytest.approx(float(invariants.area(plain)), rel=1e-12)
    drawn = Mesh(bare.points, {"line": bare.get("line")})
    chains = invariants.lines_as_edges(flat, drawn)
    pieces = {tuple(sorted(line)) for line in mesh.get("line").tolist()}
    assert {edge for chain in chains for edge in chain} == pieces
    assert report.converged == (not any("not as asked" in warning for warning in report.warnings))
    if not keywords.get("split_boundary", True):
        assert len(pieces) == len(bare.get("line"))
    if not report.converged:
        return
    longest = invariants.longest_edges(flat)
    assert longest.max() <= keywords.get("size", np.inf) * (1 + 1e-12)
    if "size_field" in keywords:
        assert (longest <= keywords["size_field"](flat.centroids) * (1 + 1e-9)).all()
    corners = flat.points[flat.get("triangle")]
    areas = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2]
    assert areas.max() <= keywords.get("max_area", np.inf) * (1 + 1e-12)
    if not any("small angles of the input" in warning for warning in report.warnings):
        assert invariants.angles(flat).min() >= keywords.get("min_angle", 30.0) - 1e-9
