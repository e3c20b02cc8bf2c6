"""Transfinite blocks: faces kept, exact on what it is exact for, blind to how faces are given, same on any threads."""

from itertools import permutations, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import meshcore as mc
from meshcore import gallery, quality
from meshcore.errors import Cancelled, GenerationFailed, InvalidGeometry, InvalidInput
from meshcore.geometry.curves import lines_through
from meshcore.sizing import geometric
from meshcore.structured.algebraic.block_faces import PLACES, BlockFaces
from meshcore.structured.algebraic.sides import fractions_of
from meshcore.structured.algebraic.transfinite_volume import interpolated_volume
from tests import naive


def lattice(*parameters):
    return np.meshgrid(*parameters, indexing="ij")


def bent_block(n=6, m=5, layers=4, ratio=1.2):
    """Points of a block that no direction of it is straight in, with unequal spacing."""
    u, v, w = lattice(geometric(n, ratio=ratio), geometric(m, ratio=1 / ratio), geometric(layers, ratio=ratio))
    x = 2 * u + 0.2 * np.sin(2 * v) + 0.1 * w**2 + 0.3 * np.sin(2 * u) * np.sin(3 * v) * np.sin(2 * w)
    y = v * (1 + 0.3 * w) + 0.1 * np.sin(3 * u)
    z = 1.5 * w + 0.1 * u**2 * v
    return np.stack([x, y, z], axis=-1)


def faces_of(points):
    """The six faces by name."""
    p = points
    return dict(zip(PLACES, (p[0], p[-1], p[:, 0], p[:, -1], p[:, :, 0], p[:, :, -1]), strict=True))


def edges_of(points):
    """Twelve edges."""
    p, ends = points, tuple(product((0, -1), repeat=2))
    return [p[:, a, b] for a, b in ends] + [p[a, :, b] for a, b in ends] + [p[a, b] for a, b in ends]


def twisted(n=6, m=5, layers=4):
    """Faces of a block that is not the Boolean sum of them by accident."""
    return faces_of(bent_block(n, m, layers))


@pytest.mark.parametrize("blending", ["arc length", "linear", "cubic"])
def test_faces_are_reproduced_to_the_bit(blending):
    faces = twisted()
    grid, report = mc.transfinite_volume(**faces, blending=blending)
    for name, face in faces_of(grid.points).items():
        assert (face == faces[name]).all()
    assert grid.names == {place: place for place in PLACES} and not report.warnings
    assert report.counts == {"points": 7 * 6 * 5, "hexahedra": 6 * 5 * 4}


@pytest.mark.parametrize("blending", ["arc length", "linear"])
def test_equals_the_formula_point_by_point(blending):
    faces = twisted(5, 4, 3)
    shape = 6, 5, 4
    if blending == "linear":
        u, v, w = lattice(*(np.linspace(0, 1, n) for n in shape))
    else:
        block = BlockFaces(faces, {}, 0.0)
        edges = [[fractions_of(block.edge(a, p, q)) for p, q in ((0, 0), (1, 0), (0, 1), (1, 1))] for a in range(3)]
        u, v, w = naive.crossing_of_edges(*edges)
    expected = naive.gordon_hall(list(faces.values()), u, v, w)
    assert np.abs(interpolated_volume(faces, blending=blending) - expected).max() < 1e-13


@given(st.integers(0, 10**6))
def test_reproduces_what_is_linear_in_one_direction_at_a_time(seed):
    """P_u + P_v + P_w - ... is exact where (1 - P_u)(1 - P_v)(1 - P_w) of the map vanishes."""
    rng = np.random.default_rng(seed)
    u, v, w = lattice(np.linspace(0, 1, 6), np.linspace(0, 1, 5), np.linspace(0, 1, 7))
    c = rng.uniform(-1, 1, (6, 3, 1, 1, 1))
    terms = (np.sin(3 * u) * np.exp(v), np.exp(v) * np.cos(2 * w), np.sin(u) * np.cos(w))
    exact = sum(c[2 * n] * f + c[2 * n + 1] * f * x for n, (f, x) in enumerate(zip(terms, (w, u, v), strict=True)))
    exact = np.moveaxis(exact, 0, -1)
    assert np.abs(interpolated_volume(faces_of(exact), blending="linear") - exact).max() < 1e-13


def test_a_stretched_box_is_exact_whatever_its_spacing():
    x, y, z = lattice(geometric(9, ratio=1.5), geometric(7, ratio=0.6), geometric(8, ratio=1.3))
    for blending, shear in (("arc length", 1), ("cubic", 0)):
        exact = np.stack([2 * x, y + shear * x, 3 * z], axis=-1)
        grid, _ = mc.transfinite_volume(**faces_of(exact), blending=blending)
        assert np.abs(grid.points - exact).max() < 1e-12


def test_wall_spacing_reaches_the_inside_by_length():
    """Edges of different lengths, each with its own first cell: by length each row keeps it."""
    cage = gallery.twisted_cage(8, 8, 8)
    grid, _ = mc.transfinite_volume(cage, cells_k=16, spacing_kmin=0.004)
    heights = np.linalg.norm(grid.points[:, :, 1] - grid.points[:, :, 0], axis=-1)
    assert heights[0, 0] == pytest.approx(0.004, rel=0.01)
    assert heights.min() > 0.0035 and heights.max() < 0.0045


@pytest.mark.parametrize("blending", ["arc length", "linear"])
@pytest.mark.parametrize("threads", [2, 3, 7])
def test_any_number_of_threads_gives_the_same_points(blending, threads):
    faces = twisted(40, 9, 8)
    assert (
        interpolated_volume(faces, blending=blending, threads=threads)
        == interpolated_volume(faces, blending=blending, threads=1)
    ).all()


def turned(face, turn):
    swap, first, second = turn
    face = face.swapaxes(0, 1) if swap else face
    return face[:: -1 if first else 1, :: -1 if second else 1]


TURNS = list(product((False, True), repeat=3))


@settings(max_examples=60)
@given(st.tuples(*[st.sampled_from(TURNS)] * 6))
def test_faces_in_any_direction_are_turned_and_told(turns):
    faces = twisted()
    expected = mc.transfinite_volume(**faces).mesh.points
    given_ = {name: turned(face, turn) for (name, face), turn in zip(faces.items(), turns, strict=True)}
    grid, report = mc.transfinite_volume(**given_)
    assert (grid.points == expected).all()
    told = {text.split()[0] for text in report.warnings}
    assert told == {name for name, turn in zip(faces, turns, strict=True) if turn != (False, False, False)}


@pytest.mark.parametrize("order", list(permutations(range(6)))[::37])
def test_faces_in_any_order_find_their_places(order):
    faces = twisted()
    names = list(faces)
    grid, report = mc.transfinite_volume(*(faces[names[k]] for k in order))
    points = {tuple(p) for p in np.round(mc.transfinite_volume(**faces).mesh.points.reshape(-1, 3), 9)}
    assert {tuple(p) for p in np.round(grid.points.reshape(-1, 3), 9)} == points
    for place, name in grid.names.items():  # the face in this place is the one that was given under that name
        own = faces_of(grid.points)[place].reshape(-1, 3)
        given_ = faces[names[order[PLACES.index(name)]]].reshape(-1, 3)
        assert np.allclose(own[np.lexsort(own.T)], given_[np.lexsort(given_.T)], atol=1e-12)
    if order == tuple(range(6)):
        assert not report.warnings


def test_a_left_handed_block_is_turned_and_keeps_its_names():
    mirror = np.array([-1.0, 1, 1])
    faces = {name: face * mirror for name, face in twisted().items()}
    grid, report = mc.transfinite_volume(**faces)
    assert np.abs(grid.points[::-1] * mirror - mc.transfinite_volume(**twisted()).mesh.points).max() < 1e-13
    assert grid.names["imin"] == "imax" and grid.names["imax"] == "imin" and grid.names["kmin"] == "kmin"
    assert report.warnings == ["the faces make a left-handed block: i was reversed"]


@pytest.mark.parametrize("shape", [(1, 1, 1), (2, 1, 3), (6, 5, 4)])
def test_a_cage_is_the_six_faces_of_its_block(shape):
    points = bent_block(*shape)
    cage = mc.StructuredGrid(points).to_mesh().boundary.compacted()
    order = np.random.default_rng(3).permutation(cage.n_points)
    quads = np.argsort(order)[cage.get("quad")]
    flipped = np.where(
        np.arange(len(quads))[:, None] % 2, quads, quads[:, ::-1]
    )  # nor does it matter how quads are turned
    grid, _ = mc.transfinite_volume(mc.Mesh(cage.points[order], {"quad": flipped[::-1]}))
    assert (grid.points == mc.transfinite_volume(**faces_of(points)).mesh.points).all()


def test_meshes_of_quads_and_grids_are_faces_too():
    faces = twisted()
    expected = mc.transfinite_volume(**faces).mesh.points
    grids = {name: mc.StructuredGrid(face) for name, face in faces.items()}
    assert (mc.transfinite_volume(**grids).mesh.points == expected).all()
    meshes = {name: grid.to_mesh() for name, grid in grids.items()}
    assert (mc.transfinite_volume(**meshes).mesh.points == expected).all()


@given(st.permutations(range(12)), st.lists(st.booleans(), min_size=12, max_size=12))
@settings(max_examples=30)
def test_twelve_edges_in_any_order_and_direction(order, backwards):
    points = bent_block()
    edges = edges_of(points)
    expected = mc.transfinite_volume(edges).mesh.points
    mixed = [edges[k][::-1] if back else edges[k] for k, back in zip(order, backwards, strict=True)]
    assert (mc.transfinite_volume(mixed).mesh.points == expected).all()
    for a, b in zip(edges_of(expected), edges, strict=True):
        assert (a == b).all()


def test_edges_give_faces_and_then_the_volume():
    points = bent_block()
    edges = edges_of(points)
    mesh = wire(edges)
    grid, _ = mc.transfinite_volume(mesh)
    assert (grid.points == mc.transfinite_volume(edges).mesh.points).all()
    south, east, north, west = points[:, 0, 0], points[-1, :, 0], points[:, -1, 0], points[0, :, 0]
    face = mc.transfinite(south, east, north, west).mesh.points[:, :, 0]
    assert np.abs(grid.points[:, :, 0] - face).max() < 1e-13


def wire(edges):
    """Twelve edges as one mesh of lines, with one point a corner."""
    parts = [lines_through(edge) for edge in edges]
    joined = gallery.joined(*parts)
    points, number = np.unique(joined.points, axis=0, return_inverse=True)
    return mc.Mesh(points, {"line": number.ravel()[joined.get("line")]})


def test_cells_and_spacing_resample_edges_and_faces():
    for given_ in (twisted(), {"imin": edges_of(bent_block())}):
        grid, _ = mc.transfinite_volume(
            **given_, cells_i=12, cells_j=7, cells_k=9, spacing_jmin=0.01, spacing_kmax=0.02, law="hyperbolic tangent"
        )
        assert grid.cell_shape == (12, 7, 9)
        for i, k in product((0, -1), repeat=2):
            assert np.linalg.norm(grid.points[i, 1, k] - grid.points[i, 0, k]) == pytest.approx(0.01, rel=0.02)
        for i, j in product((0, -1), repeat=2):
            assert np.linalg.norm(grid.points[i, j, -2] - grid.points[i, j, -1]) == pytest.approx(0.02, rel=0.02)


def test_lines_leave_the_faces_at_right_angles_by_cubic_blending():
    points = bent_block(32, 30, 28, ratio=1.0)

    def slant(blending):
        grid = mc.transfinite_volume(**faces_of(points), blending=blending).mesh.points
        step = (-1.5 * grid[:, 0] + 2 * grid[:, 1] - 0.5 * grid[:, 2])[12:21, 10:19]
        face = points[:, 0]
        normal = np.cross(np.gradient(face, axis=0), np.gradient(face, axis=1))[12:21, 10:19]
        cosine = np.abs((step * normal).sum(-1)) / np.linalg.norm(step, axis=-1) / np.linalg.norm(normal, axis=-1)
        return np.degrees(np.arccos(np.clip(cosine, 0, 1))).max()

    assert slant("cubic") < 0.5 * slant("arc length")


def cubic_map(u, v, w):
    """A map that is cubic in each of u, v and w, and its derivatives along them."""
    rng = np.random.default_rng(2)
    c = rng.uniform(-0.05, 0.05, (3, 4, 4, 4))
    for axis in range(3):
        c[axis][tuple(int(a == axis) for a in range(3))] += 1
    value = np.polynomial.polynomial.polyval3d

    def at(coefficients):
        return np.stack([value(u, v, w, coefficients[x]) for x in range(3)], axis=-1)

    derivatives = [at(np.stack([np.polynomial.polynomial.polyder(c[x], axis=a) for x in range(3)])) for a in range(3)]
    return at(c), derivatives


def test_slopes_make_cubic_blending_exact_for_cubics():
    """So two blocks that share a face of such a map, and its slopes, join with continuous derivatives."""
    s = [np.linspace(0, 1, n) for n in (9, 8, 7)]
    exact, derivatives = cubic_map(*lattice(*s))
    faces = faces_of(exact)
    slopes = {}
    for axis, (low, high) in enumerate((PLACES[0:2], PLACES[2:4], PLACES[4:6])):
        step = derivatives[axis] / (len(s[axis]) - 1)
        slopes[low], slopes[high] = faces_of(step)[low], faces_of(step)[high]
    grid, _ = mc.transfinite_volume(**faces, blending="linear")
    assert np.abs(grid.points - exact).max() > 1e-3
    # Blending functions by length are not those of the map; by number they are.
    from meshcore.structured.algebraic.blending import Direction, boolean_sum

    directions = [
        Direction(
            s[a],
            {0: faces[PLACES[2 * a]], len(s[a]) - 1: faces[PLACES[2 * a + 1]]},
            {0: slopes[PLACES[2 * a]], len(s[a]) - 1: slopes[PLACES[2 * a + 1]]},
            True,
        )
        for a in range(3)
    ]
    assert np.abs(boolean_sum(directions) - exact).max() < 1e-12
    grid, _ = mc.transfinite_volume(**faces, blending="cubic", slopes=slopes)
    assert np.abs(grid.points - exact).max() < 0.02


@pytest.mark.parametrize("blending", ["arc length", "linear", "cubic"])
def test_surfaces_inside_are_kept_to_the_bit(blending):
    exact = bent_block(8, 7, 6)
    own = {"blending": blending, "slopes": {} if blending == "cubic" else None}
    plain = mc.transfinite_volume(**faces_of(exact), **own).mesh.points
    surfaces = {("i", 3): exact[3], ("k", 2): exact[:, :, 2], ("k", 4): exact[:, :, 4]}
    points = mc.transfinite_volume(**faces_of(exact), **own, surfaces=surfaces).mesh.points
    assert (points[3] == exact[3]).all() and (points[:, :, 2] == exact[:, :, 2]).all()
    for name, face in faces_of(points).items():
        assert (face == faces_of(exact)[name]).all()
    assert np.abs(points - exact).max() < 0.5 * np.abs(plain - exact).max()


def moved(faces, name, by):
    return {**faces, name: faces[name] + by}


def test_gaps_within_tolerance_are_closed():
    faces = twisted()
    grid, _ = mc.transfinite_volume(**moved(faces, "imax", [1e-4, 0, 0]), tolerance=0.001)
    assert np.abs(grid.points - mc.transfinite_volume(**faces).mesh.points).max() < 2e-4
    with pytest.raises(InvalidGeometry, match=r"imax: a corner at .* is 0\.0001 away"):
        mc.transfinite_volume(**moved(faces, "imax", [1e-4, 0, 0]))
    torn = {name: face.copy() for name, face in faces.items()}
    torn["jmax"][3, 0] += [0, 0.01, 0]
    with pytest.raises(InvalidGeometry, match=r"jmax and kmin are 0\.01 apart at their common edge"):
        mc.transfinite_volume(**torn)
    assert mc.transfinite_volume(**faces, tolerance=0).mesh.n_cells == 120


def replaced(name, face):
    return {**twisted(), name: face}


FACES = twisted()
NAN = FACES["jmin"].copy()
NAN[1, 1, 1] = np.nan
REPEATED = {name: np.concatenate([face[:2], face[1:]]) if name[0] != "i" else face for name, face in FACES.items()}
SHORT = {name: face[:-1] if name == "kmax" else face for name, face in FACES.items()}
CUBE = np.stack(lattice([0.0, 1], [0.0, 1], [0.0, 1]), axis=-1)


@pytest.mark.parametrize(
    ("inputs", "keywords", "error", "words"),
    [
        ({"imin": FACES["imin"]}, {}, InvalidInput, "imin: is alone"),
        ({k: v for k, v in FACES.items() if k != "kmax"}, {}, InvalidInput, "kmax: is missing"),
        (replaced("jmin", NAN), {}, InvalidGeometry, "jmin: point"),
        (replaced("jmin", np.zeros((3, 3))), {}, InvalidInput, "jmin: needs shape"),
        (replaced("jmin", "front"), {}, InvalidInput, "jmin: needs real numbers"),
        (replaced("jmin", FACES["jmin"][:1]), {}, InvalidInput, "jmin: needs at least 2 x 2 points"),
        (replaced("jmin", bent_block()), {}, InvalidInput, "jmin: needs a surface of one layer"),
        (replaced("jmin", gallery.triangulated_square()), {}, InvalidGeometry, "jmin: needs quads alone"),
        (replaced("jmin", FACES["kmin"]), {}, InvalidGeometry, "corner|opposite|block"),
        (replaced("jmin", FACES["jmin"][:, ::2]), {}, InvalidInput, "give cells_k to resample both"),
        (SHORT, {}, InvalidGeometry, "kmax: a corner|corner at"),
        (REPEATED, {}, InvalidGeometry, "points 1 and 2 along i coincide"),
        ({"imin": gallery.triangulated_square()}, {}, InvalidInput, "imin: is alone"),
        ({"imin": gallery.square(4)}, {}, InvalidGeometry, "needs the twelve edges of a block"),
        ({"imin": edges_of(bent_block())[:11]}, {}, InvalidGeometry, "needs the twelve edges of a block"),
        ({"imin": [CUBE[:, 0, 0]] * 12}, {}, InvalidGeometry, "needs the twelve edges of a block"),
        ({"imin": []}, {}, InvalidGeometry, "needs twelve edges, got none"),
        ({"imin": mc.StructuredGrid(CUBE[0]).to_mesh()}, {}, InvalidGeometry, "imin: is open"),
        (replaced("jmin", FACES["jmin"] * 1e200), {}, InvalidGeometry, "jmin: has an extent of"),
        ({"imin": [edge * 1e-200 for edge in edges_of(CUBE)]}, {}, InvalidGeometry, "imin: has an extent of"),
        (FACES, {"cells_i": 0}, InvalidInput, "cells_i: must be at least 1"),
        (FACES, {"cells_i": 10**6, "cells_j": 10**4}, InvalidInput, "cells_i: would make"),
        (FACES, {"spacing_imin": 9.0}, InvalidInput, "spacing_imin: 9 does not fit an edge"),
        (FACES, {"law": "cosine", "spacing_kmax": 0.1}, InvalidInput, "spacing_kmax: is no number of the law"),
        (FACES, {"law": "copied"}, InvalidInput, "law"),
        (FACES, {"tolerance": -1.0}, InvalidInput, "tolerance"),
        (FACES, {"threads": 0}, InvalidInput, "threads"),
        (FACES, {"blending": "quintic"}, InvalidInput, "blending"),
        (FACES, {"slopes": {"imin": FACES["imin"]}}, InvalidInput, "slopes: are matched"),
        (FACES, {"slopes": {"up": FACES["imin"]}, "blending": "cubic"}, InvalidInput, "slopes: 'up' is no face"),
        (FACES, {"slopes": {"imin": np.zeros((2, 2, 3))}, "blending": "cubic"}, InvalidInput, "slopes: needs finite"),
        (FACES, {"surfaces": {("i", 0): FACES["imin"]}}, InvalidInput, "i = 0 is not between"),
        (FACES, {"surfaces": {"i": FACES["imin"]}}, InvalidInput, "'i' is no axis and index"),
        (FACES, {"surfaces": {("i", 2): FACES["imin"][1:]}}, InvalidInput, "surfaces: needs finite"),
        (FACES, {"surfaces": {("i", 2): FACES["imin"]}}, InvalidGeometry, "does not agree with the faces"),
    ],
)
def test_bad_input_gets_a_clear_error(inputs, keywords, error, words):
    with pytest.raises(error, match=words):
        mc.transfinite_volume(**inputs, **keywords)


def test_overspill_is_refused_with_its_place():
    points = bent_block(10, 9, 8)
    faces = {name: face.copy() for name, face in faces_of(points).items()}
    faces["kmin"][2:8, 2:7, 2] += 3.0  # the floor pushed through the roof
    with pytest.raises(GenerationFailed, match="folded or flat, the first at i = 1") as caught:
        mc.transfinite_volume(**faces)
    assert caught.value.cells and isinstance(caught.value.partial, mc.StructuredGrid)


def test_edges_too_different_to_be_blended_by_length():
    """Opposite edges spaced against each other in all directions may leave no crossing: it says so, or is right."""
    t = [geometric(8, ratio=4.0), geometric(8, ratio=0.25)]
    edges = []
    for axis in range(3):
        for n, (a, b) in enumerate(product((0.0, 1.0), repeat=2)):
            edge = np.zeros((9, 3))
            edge[:, [x for x in range(3) if x != axis]] = a, b
            edge[:, axis] = t[(n + (n > 1)) % 2]
            edges.append(edge)
    try:
        grid, _ = mc.transfinite_volume(edges)
    except (InvalidGeometry, GenerationFailed):
        return
    assert np.isfinite(grid.points).all()


def test_stops_when_told():
    with pytest.raises(Cancelled):
        mc.transfinite_volume(gallery.twisted_cage(), progress=lambda fraction, message: False)


def bulb(n=12, bulge=0.1):
    return gallery.dented_box(n, depth=0.3, bulge=bulge)


# Harmonic faces draw points off the neck of a bulb, so moving points on faces cures only the thicker necks.
@pytest.mark.parametrize(("cure", "bulge"), [("sides", 0.08), ("smoothing", 0.1), ("automatic", 0.1)])
def test_overspill_in_a_block_is_cured_and_told(cure, bulge):
    with pytest.raises(GenerationFailed, match=r"folded or flat, .* ask for a cure"):
        mc.transfinite_volume(bulb(bulge=bulge), blending="linear")
    grid, report = mc.transfinite_volume(bulb(bulge=bulge), blending="linear", cure=cure)
    assert any(text.startswith("overspill: ") for text in report.warnings)
    assert (quality.measure(grid, "scaled_jacobian") > 0).all()
    sound, report = mc.transfinite_volume(gallery.dented_box(), cure=cure)
    assert not report.warnings and np.array_equal(sound.points, mc.transfinite_volume(gallery.dented_box()).mesh.points)


def test_smoothing_keeps_the_faces_to_the_last_bit():
    with pytest.raises(GenerationFailed) as error:
        mc.transfinite_volume(bulb(), blending="linear")
    start = error.value.partial.points
    points = mc.transfinite_volume(bulb(), blending="linear", cure="smoothing").mesh.points
    for axis in range(3):
        for end in (0, -1):
            assert np.array_equal(points.take(end, axis), start.take(end, axis))


def test_edges_of_unlike_parameters_are_made_alike():
    """Points crowd to the left below and to the right above: lines cross over a ridge between."""
    u, v, w = np.meshgrid(*[np.linspace(0, 1, 13)] * 3, indexing="ij")
    x = u + 0.95 * u * (1 - u) * (1 - 2 * w)
    z = w * (0.12 + 0.0 * x) + 1.2 * np.exp(-(((x - 0.5) / 0.2) ** 2))
    block = np.stack([x, v, z], axis=-1)
    faces = [block[0], block[-1], block[:, 0], block[:, -1], block[:, :, 0], block[:, :, -1]]
    with pytest.raises(GenerationFailed, match="folded or flat"):
        mc.transfinite_volume(*faces, blending="linear")
    grid, report = mc.transfinite_volume(*faces, blending="linear", cure="sides")
    assert report.warnings[0].startswith("overspill: points of")
    assert (quality.measure(grid, "scaled_jacobian") > 0).all()


def test_what_cannot_be_cured_in_a_block_is_refused_with_its_place():
    """An edge at which the boundary turns by 270 degrees is named, whatever is asked for."""
    t = np.linspace(0, 1, 9)[:, None]
    half = np.linspace(0, 1, 5)[:, None]

    def line(a, b, at=t):
        return np.array(a, float) + at * (np.array(b, float) - a)

    sides = [line((1, 1), (2, 1)), np.concatenate([line((2, 1), (2, 2), half)[:-1], line((2, 2), (0, 2), half)])]
    sides += [np.concatenate([line((1, 0), (0, 0), half)[:-1], line((0, 0), (0, 2), half)]), line((1, 1), (1, 0))]
    with pytest.raises(GenerationFailed) as error:
        mc.transfinite(*sides)
    flat = error.value.partial.points
    block = np.concatenate([flat + [0, 0, height] for height in np.linspace(0, 1, 5)], axis=2)
    faces = [block[0], block[-1], block[:, 0], block[:, -1], block[:, :, 0], block[:, :, -1]]
    for cure in ("none", "automatic"):
        with pytest.raises(GenerationFailed, match=r"boundary turns by 270 degrees at the .* of imin.* jmin") as error:
            mc.transfinite_volume(*faces, cure=cure)
        assert "cut the block there" in str(error.value) and len(error.value.cells)


def test_slopes_and_surfaces_are_not_cured_away():
    with pytest.raises(GenerationFailed, match="folded or flat"):
        grid = mc.transfinite_volume(gallery.dented_box()).mesh.points
        crossed = grid[:, :, 4].copy()
        crossed[3:-3, 3:-3, 2] = -0.5
        mc.transfinite_volume(gallery.dented_box(), surfaces={("k", 4): crossed}, cure="automatic")


def test_a_spacing_of_an_axis_is_that_of_its_edges_from_the_face_called_min():
    box = np.stack(lattice(np.linspace(0, 1, 5), np.linspace(0, 1, 4), np.linspace(0, 1, 4)), axis=-1)
    wanted = geometric(6, ratio=1.5)
    spacings = {"i": mc.Spacing("geometric", ratio=1.5)}
    grid, _ = mc.transfinite_volume(**faces_of(box), cells_i=6, spacings=spacings)
    assert np.allclose(grid.points[:, 1, 1, 0], wanted) and np.allclose(grid.points[0, :, 0, 1], box[0, :, 0, 1])
    swapped = faces_of(box) | {"imin": box[-1], "imax": box[0]}
    other, report = mc.transfinite_volume(**swapped, cells_i=6, spacings=spacings)
    assert other.names["imin"] == "imax" and report.warnings
    assert np.allclose(other.points[:, 1, 1, 0], 1 - wanted[::-1])
    by_edges, _ = mc.transfinite_volume(edges_of(box), cells_i=6, spacings=spacings)
    assert np.allclose(by_edges.points, grid.points)


@pytest.mark.parametrize(
    ("spacings", "said"),
    [
        ({"imin": mc.Spacing()}, "spacings: needs a Spacing for"),
        ({"k": 0.1}, "spacings: needs a Spacing for"),
        ([mc.Spacing()], "spacings: needs a dict"),
        ({"k": mc.Spacing("geometric", first=3.0)}, "spacings: .* change it or the number of cells"),
    ],
)
def test_spacings_that_cannot_be_are_refused(spacings, said):
    with pytest.raises(InvalidInput, match=said):
        mc.transfinite_volume(**twisted(), spacings=spacings)
