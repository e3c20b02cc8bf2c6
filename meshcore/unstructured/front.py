"""Points by an advancing front inside the Delaunay triangulation: lengths wanted, lines discretised, the front driven.

Edges of the front's triangles are at most sqrt(2) times as long as wanted, since no accepted triangle has a larger
circle. So it aims at a share of what a limit allows, and the limits hold almost without further points.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ..errors import GenerationFailed, InvalidGeometry
from ..progress import Progress, advance, part_of
from . import _front_kernels as kernels
from . import _half_edge_kernels as half_edges
from . import _refinement_kernels as refinement_kernels
from .constrained import ConstrainedTriangulation, constrained
from .domain import Domain, Seeds, domain
from .line_division import Division, Ground, divided
from .refiner import MAX_TRIANGLES, Refiner, too_many
from .triangulation import grown

Lengths = Callable[[np.ndarray], np.ndarray]

_STEPS_A_CHUNK = 20_000
# Largest circumradius of an accepted triangle, and least distance of a new point from others, per wanted length. The
# equilateral triangle has 0.577; Rebay accepts 1.5 times that, but at 1.22 fewer gaps are left to be closed badly.
_ACCEPTED_RADIUS = 0.5 * np.sqrt(2)
_NEAREST = 0.7
# Wanted length per largest edge allowed: below 1 / sqrt(2), for lengths that vary.
_SHARE_OF_SIZE = 0.68
# Wanted length per square root of the largest area allowed: the largest triangle of the accepted radius just fits.
_SHARE_OF_ROOT_OF_AREA = float(np.sqrt(4 / (3 * np.sqrt(3) * _ACCEPTED_RADIUS**2)))
# How much the wanted length may grow a unit of distance, from lines that are finer than asked for.
_GROWTH = 0.3
# Length wanted at the ends of lines, per mean length of these lines, where limits allow more.
_PER_LINE = 1.1
# The ground's edges per wanted length: lengths are linear between its vertices.
_COARSENESS = 4.0
# No point where it sees a line under more than this, in degrees.
_WIDEST_VIEW = 140.0
_EQUILATERAL = float(np.sqrt(3) / 4)


class Front:
    """Fills a domain with points: first on its lines, then inside.

    Parameters
    ----------
    mesh : ConstrainedTriangulation
        Is used up; afterwards ``mesh`` and ``parts`` have the one with divided lines.
    parts : Domain
        Which faces are meshed, and their largest areas.
    marks : Seeds
        Holes and regions.
    max_area : float
        Of all faces, possibly infinite.
    size : float
        Largest edge length, possibly infinite.
    size_field : callable, optional
        (m, 2) places in the plane to (m,) largest edge lengths, already checked.
    split_boundary : bool
        Whether lines may get points.
    progress : Progress
        Called with fraction and message.

    Attributes
    ----------
    mesh, parts
        What is to be refined, with divided lines.
    owner : (k,) int
        Piece that each point divides that was put on lines.
    """

    def __init__(
        self,
        mesh: ConstrainedTriangulation,
        parts: Domain,
        marks: Seeds,
        max_area: float,
        *,
        size: float,
        size_field: Lengths | None,
        split_boundary: bool,
        progress: Progress,
    ):
        self.size, self.size_field, self.progress = size, size_field, progress
        self.mesh, self.parts = mesh, parts
        limits = self._limits()
        self.is_limited = size_field is not None or bool(np.isfinite(limits[parts.keep]).any())
        coarse = self._coarse()
        self.ground = None
        if size_field is not None:
            self.ground = _ground_of(coarse, _SHARE_OF_SIZE * size_field(_places(coarse)) * coarse.scale)
        self.estimate = 0.0
        if self.is_limited:
            self.estimate = self._checked_estimate(coarse, limits)
        division = None
        if split_boundary and self.is_limited:
            division = divided(mesh, parts, limits, self.ground, coarse)
        self._rebuild(division, marks, max_area)

    def _limits(self) -> np.ndarray:
        """(n_faces,) float: length wanted in each face, by size and area."""
        return np.minimum(_SHARE_OF_SIZE * self.size, _SHARE_OF_ROOT_OF_AREA * np.sqrt(self.parts.max_area))

    def _coarse(self) -> Refiner:
        """The lines as they are, refined so far that sizes are linear within triangles."""
        field = self.size_field
        coarse = Refiner(
            self.mesh,
            replace(self.parts, max_area=np.full(len(self.parts.max_area), np.inf)),
            min_angle=0.0,
            size=np.inf,
            placement="circumcentre",
            split_boundary=True,
            size_field=None if field is None else lambda places: _COARSENESS * _SHARE_OF_SIZE * field(places),
            progress=part_of(self.progress, 0.0, 0.1),
        )
        if field is not None:
            coarse.run()
        return coarse

    def _checked_estimate(self, coarse: Refiner, limits: np.ndarray) -> float:
        """Triangles that the front will make; raises if that is absurd."""
        corners, slots = coarse.live()
        length = limits[coarse.face[slots]] * coarse.scale
        by_area = _SHARE_OF_ROOT_OF_AREA * np.sqrt(self.parts.max_area) < _SHARE_OF_SIZE * self.size
        parameter = "max_area" if by_area[self.parts.keep].any() else "size"
        if self.ground is not None:
            field = self.ground.length[corners].mean(axis=1)
            parameter = "size_field" if (field < length).any() else parameter
            length = np.minimum(length, field)
        with np.errstate(divide="ignore", over="ignore"):  # squares of lengths below 1e-160 underflow
            estimate = float((coarse.areas(corners) / (_EQUILATERAL * length**2)).sum())
        if estimate > MAX_TRIANGLES:
            raise too_many(estimate, parameter)
        return estimate

    def _rebuild(self, division: Division | None, marks: Seeds, max_area: float) -> None:
        """Triangulate the divided lines; if rounding made them cross, the lines as they were."""
        step = part_of(self.progress, 0.1, 0.2)
        mesh = None
        if division is not None:
            with contextlib.suppress(InvalidGeometry):
                mesh = constrained(division.graph, split_crossings=False, parameter="boundary", progress=step)
        if mesh is None:
            self.mesh = constrained(self.mesh.graph, split_crossings=True, parameter="boundary", progress=step)
            self.parts = domain(self.mesh, marks, max_area)
            self.owner = np.empty(0, np.int64)
            if self.ground is not None:
                self.ground.near = self.ground.near[: len(self.mesh.graph.points)]
            return
        self.parts = domain(mesh, marks, max_area)
        self.owner = division.owner
        self.mesh = _with_whole_pieces(mesh, division)

    # ---- the points inside

    def advance(self, refiner: Refiner) -> None:
        """Put the front's points into the triangulation that the refiner holds."""
        if len(self.owner):
            on_lines = self.mesh.triangulation.vertex_of[-len(self.owner) :]
            refiner.stands_on[on_lines] = self.owner
        refiner.state[refinement_kernels.SPLITS] += len(self.owner)
        limits = self._limits() * refiner.scale
        wanted = self._wanted(refiner, limits)
        ground = self._ground(refiner, wanted)
        estimate = self.estimate
        if not self.is_limited:
            corners, _ = refiner.live()
            length = wanted[corners].mean(axis=1)
            estimate = float((refiner.areas(corners) / (_EQUILATERAL * length**2)).sum())
        estimate = min(estimate, MAX_TRIANGLES)
        refiner.reserve(int(0.55 * estimate) + len(wanted) + 1024, int(1.1 * estimate) + len(refiner.face) + 1024)
        rules = np.zeros(4)
        rules[kernels.ACCEPTED] = _ACCEPTED_RADIUS**2
        rules[kernels.NEAREST] = _NEAREST**2
        rules[kernels.GROWTH] = _GROWTH if self.is_limited else np.inf
        rules[kernels.LENS] = np.cos(np.radians(_WIDEST_VIEW)) ** 2
        _run(refiner, wanted, limits, ground, rules, estimate, part_of(self.progress, 0.2, 1.0))

    def _wanted(self, refiner: Refiner, limits: np.ndarray) -> np.ndarray:
        """(n,) float: length wanted at each vertex on lines."""
        xy = refiner.xy.reshape(-1, 2)[: refiner.state[refinement_kernels.VERTICES]]
        corners, slots = refiner.live()
        wanted = np.full(len(xy), np.inf)
        for k in range(3):
            np.minimum.at(wanted, corners[:, k], limits[refiner.face[slots]])
        if self.size_field is not None:
            used = np.unique(corners)
            field = _SHARE_OF_SIZE * self.size_field(np.ldexp(xy[used], -self.mesh.exponent)) * refiner.scale
            wanted[used] = np.minimum(wanted[used], field)
        ends = _line_edges(refiner, corners, slots)
        length = np.repeat(np.linalg.norm(xy[ends[:, 1]] - xy[ends[:, 0]], axis=1), 2)
        count = np.bincount(ends.ravel(), minlength=len(xy))
        total = np.bincount(ends.ravel(), length, minlength=len(xy))
        spacing = np.divide(total, count, out=np.full(len(xy), np.inf), where=count > 0)
        wanted = np.minimum(wanted, spacing * (_PER_LINE if self.is_limited else 1.0))
        graded = _graded(wanted, xy, corners)
        return graded if self.is_limited else np.where(np.isfinite(wanted), wanted, graded)

    def _ground(self, refiner: Refiner, wanted: np.ndarray) -> Ground:
        """The ground in the refiner's scale, with a triangle near each of its vertices."""
        if self.size_field is None and self.is_limited:
            none = np.empty(0, np.int32)
            return Ground(np.empty(0), none, none, np.empty(0), np.full(len(wanted), -1, np.int32), 0)
        if self.ground is None:
            return _ground_of(refiner, wanted)
        shift = self.mesh.exponent - self.ground.exponent
        return replace(
            self.ground,
            xy=np.ldexp(self.ground.xy, shift),
            length=np.ldexp(self.ground.length, shift),
            near=self.ground.near[self.mesh.triangulation.order],
        )


def _with_whole_pieces(mesh: ConstrainedTriangulation, division: Division) -> ConstrainedTriangulation:
    """The mesh of divided lines, with the lines as they were for pieces: refinement then knows their corners."""
    stop = np.cumsum(division.count)
    start = stop - division.count
    whole = np.repeat(np.arange(len(stop)), division.count)[mesh.pieces[:, 2]]
    segments, vertex_of = mesh.graph.segments, mesh.triangulation.vertex_of
    pieces = np.column_stack([vertex_of[segments[start, 0]], vertex_of[segments[stop - 1, 1]], start])
    _, first = np.unique(whole, return_index=True)
    beside = tuple(faces[first] for faces in mesh.faces_beside)
    piece_of = np.where(mesh.piece_of >= 0, whole[mesh.piece_of], -1).astype(np.int32)
    merged = replace(mesh, pieces=pieces.astype(np.int32), piece_of=piece_of)
    merged.faces_beside = beside  # from half-edges it could be told of undivided pieces only
    return merged


def _places(refiner: Refiner) -> np.ndarray:
    """(n, 2) float: the vertices of a refiner, not scaled."""
    xy = refiner.xy.reshape(-1, 2)[: refiner.state[refinement_kernels.VERTICES]]
    return np.ldexp(xy, -refiner.mesh.exponent)


def _line_edges(refiner: Refiner, corners: np.ndarray, slots: np.ndarray) -> np.ndarray:
    """(k, 2) int: ends of the edges on lines, some of them twice."""
    flags = refiner.origin[4 * slots + 3]
    return np.concatenate([corners[(flags >> k & 1) == 1][:, [k, (k + 1) % 3]] for k in range(3)])


def _ground_of(refiner: Refiner, length: np.ndarray) -> Ground:
    """A copy of what a refiner holds, with a length at each vertex."""
    corners, slots = refiner.live()
    near = np.full(len(length), 4 * slots[0], np.int32)
    for k in range(3):
        near[corners[:, k]] = 4 * slots
    used = 4 * int(refiner.state[refinement_kernels.TRIANGLES])
    return Ground(
        refiner.xy[: 2 * len(length)].copy(),
        refiner.origin[:used].copy(),
        refiner.twin[:used].copy(),
        length,
        near,
        refiner.mesh.exponent,
    )


def _graded(wanted: np.ndarray, xy: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Lengths that grow from vertex to vertex no faster than the front's, over the triangulation's edges."""
    a, b = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]]).T
    step = _GROWTH * np.linalg.norm(xy[a] - xy[b], axis=1)
    graded = wanted.copy()
    for _ in range(100):
        before = graded.copy()
        np.minimum.at(graded, a, before[b] + step)
        np.minimum.at(graded, b, before[a] + step)
        if (graded == before).all():
            break
    return graded


def _run(
    refiner: Refiner,
    wanted: np.ndarray,
    limits: np.ndarray,
    ground: Ground,
    rules: np.ndarray,
    estimate: float,
    progress: Progress,
) -> None:
    """Advance the front until no triangle is large."""
    theirs = (refinement_kernels.TRIANGLES, refinement_kernels.VERTICES, refinement_kernels.FREE)
    ours = (kernels.TRIANGLES, kernels.VERTICES, kernels.FREE)
    state = np.zeros(kernels.STATE_SIZE, np.int64)
    state[list(ours)] = refiner.state[list(theirs)]
    first = int(state[kernels.VERTICES])
    scratch = refiner.mesh.triangulation.scratch
    near = ground.near
    head = np.full(kernels.BUCKETS, -1, np.int32)
    tail = np.full(kernels.BUCKETS, -1, np.int32)
    queue = np.empty(0, np.int32)
    status = half_edges.FULL
    while status != half_edges.DONE:
        advance(progress, 0.95 * 2 * (state[kernels.VERTICES] - first) / max(estimate, 1.0), "advancing the front")
        if status == half_edges.FULL:
            if state[kernels.VERTICES] + 64 >= len(refiner.stands_on):
                refiner.reserve(2 * len(refiner.stands_on), 0)
            if 4 * state[kernels.TRIANGLES] + 1024 >= len(refiner.origin):
                refiner.reserve(0, 2 * len(refiner.face))
            wanted = grown(wanted, len(refiner.stands_on))
            near = grown(near, len(refiner.stands_on))
            if len(queue):
                queue = grown(queue, 2 * len(queue))
                scratch.grow()
            else:
                queue = np.empty(4 * (int(state[kernels.TRIANGLES]) + 65_536), np.int32)
                kernels.queue_all(
                    refiner.xy, refiner.origin, refiner.twin, wanted, rules[kernels.ACCEPTED], queue, head, tail, state
                )
        status = kernels.advance_front(
            refiner.xy, refiner.origin, refiner.twin, refiner.piece_of, refiner.face, wanted, limits, near, ground.xy,
            ground.origin, ground.twin, ground.length, queue, head, tail, refiner.free, scratch.cavity, scratch.stack,
            scratch.ring, scratch.ring_from, scratch.work, rules, state, _STEPS_A_CHUNK,
        )  # fmt: skip
        if state[kernels.VERTICES] > MAX_TRIANGLES:
            raise GenerationFailed(f"the front passed {MAX_TRIANGLES:,} points; give a size or larger ones")
    kernels.forget(refiner.origin, state[kernels.TRIANGLES])
    refiner.state[list(theirs)] = state[list(ours)]
    refiner.state[refinement_kernels.INSERTIONS] += state[kernels.VERTICES] - first
    refiner.forget_sizes()
