"""Runs the refinement kernels: buffers that grow, rounds of a size field, and an end to what would not end."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..errors import GenerationFailed, InvalidInput
from ..geometry import predicates
from ..progress import Progress, advance, part_of
from . import _assembly_kernels as assembly_kernels
from . import _half_edge_kernels as half_edges
from . import _refinement_kernels as kernels
from . import _splitting_kernels as splitting_kernels
from .boundary_lines import edges_on_lines
from .constrained import ConstrainedTriangulation
from .domain import Domain
from .smoothing import HalfEdges, smooth_in_place
from .soundness import check
from .triangulation import Triangulation, grown

_STEPS_A_CHUNK = 20_000
MAX_TRIANGLES = 50_000_000
SPARE_POINTS = 500_000
"""Points that refinement may add beyond five times what size and area ask for, before it counts as endless."""
# Mean area of the triangles that refinement makes: of size^2, and of the largest area allowed.
_AREA_BY_SIZE = 0.2
_AREA_BY_MAX_AREA = 0.6
# Room reserved per triangle expected, and for how many at most; more is found when it is needed.
_RESERVE = 1.15
_MOST_RESERVED = 5_000_000
# As many as stay in the processor's cache beside each other. Where each block has few, the order matters more than
# that: triangles too large are then best taken as they come.
_TRIANGLES_A_BLOCK = 4096
# Longer than any scaled edge; its square does not overflow.
_LONGEST = 1e150


@dataclass
class Refinement:
    """How a refinement ended.

    Attributes
    ----------
    corners : (m, 3) int32
        Corners of the triangles, by vertex.
    tags : (m,) int
        Region of each triangle.
    xy : (n, 2) float
        Coordinates of the vertices, not scaled.
    splits, insertions : int
        Points added on lines and inside.
    poor : int
        Triangles that are still too large, or too thin without the excuse of a small input angle.
    exhausted : bool
        Whether refinement was stopped because it made too many points.
    """

    corners: np.ndarray
    tags: np.ndarray
    xy: np.ndarray
    splits: int
    insertions: int
    poor: int
    exhausted: bool


class Refiner:
    """Refines a constrained triangulation in place.

    Parameters
    ----------
    mesh : ConstrainedTriangulation
        Is used up.
    domain : Domain
        Which faces stay, and their largest areas.
    min_angle : float
        Degrees.
    size : float
        Largest edge length, possibly infinite.
    placement : {"automatic", "off-centre", "circumcentre", "lattice", "front"}
        Where points go inside; all but circumcentres mean off-centres here.
    split_boundary : bool
        Whether lines may get points.
    size_field : callable, optional
        (m, 2) places in the plane to (m,) largest edge lengths, already checked.
    is_filled : bool
        Whether the points inside are there already, but for a few.
    """

    def __init__(
        self,
        mesh: ConstrainedTriangulation,
        domain: Domain,
        *,
        min_angle: float,
        size: float,
        placement: str,
        split_boundary: bool,
        size_field: Callable[[np.ndarray], np.ndarray] | None,
        progress: Progress,
        is_filled: bool = False,
    ):
        self.mesh, self.domain, self.progress = mesh, domain, progress
        self.scale = 2.0**mesh.exponent
        self.size_field = size_field
        self.has_angle = min_angle > 0
        self.cosine2, lens, height = _angle_limits(min_angle)
        unjudged = (size * self.scale) ** 2 if size * self.scale < _LONGEST else np.inf
        circumcentres = placement == "circumcentre"
        # Twice the area, as the kernel computes it.
        self.area_limit = 2 * domain.max_area * self.scale**2
        area = assembly_kernels.common_limit(self.area_limit, domain.keep)
        height = 0.0 if circumcentres else height
        self.estimate = max(expected_triangles(mesh, domain, size), float(mesh.triangulation.n_triangles))
        self.limits = np.array(
            [self.cosine2, lens, height, unjudged, size_field is None, area, circumcentres, *self._blocks()]
        )
        self._carve()
        if self.has_angle and split_boundary:
            self.estimate += self._between_near_lines(min_angle)
        self.split_boundary = split_boundary
        n = len(mesh.triangulation.order)
        if is_filled:  # there are slots to spare
            self._allocate(n + n // 64 + 1024, 0)
        else:
            expected = int(_RESERVE * min(self.estimate, _MOST_RESERVED))
            self._allocate(max(n, expected // 2) + 1024, max(len(mesh.face), expected) + 1024)
        self._keep_lines()

    # ---- setting up

    def _blocks(self) -> tuple[float, float, float]:
        """The lower left corner of the domain, and the number of blocks per length."""
        xy = self.mesh.triangulation.xy.reshape(-1, 2)
        low, high = xy.min(axis=0), xy.max(axis=0)
        across = np.clip(np.sqrt(self.estimate / _TRIANGLES_A_BLOCK), 1.0, kernels.BLOCKS)
        return low[0], low[1], (1 - 1e-9) * across / (high - low).max()

    def _carve(self) -> None:
        mesh = self.mesh.triangulation
        self.free = np.empty(max(len(mesh.origin) // 4, 1), np.int32)
        self.n_free = half_edges.carve(
            mesh.origin, mesh.twin, mesh.n_triangles, self.mesh.face, self.domain.keep, self.free
        )

    def _allocate(self, vertices: int, slots: int) -> None:
        """Take over the triangulation's arrays, and make others, with room for so many vertices and triangles."""
        mesh = self.mesh.triangulation
        mesh.scratch.work = predicates.workspace()  # points that are added lie on no grid, even if the boundary's do
        vertices, slots = max(vertices, len(mesh.xy) // 2), max(slots, len(mesh.origin) // 4)
        self.acute = acute_vertices(mesh)
        self.xy, self.pieces = grown(mesh.xy, 2 * vertices), self.mesh.pieces
        self.origin, self.twin, self.piece_of = (
            grown(array, 4 * slots) for array in (mesh.origin, mesh.twin, self.mesh.piece_of)
        )
        self.face, self.free = grown(self.mesh.face, slots), grown(self.free, slots)
        self.stands_on, self.edge_limit = np.empty(vertices, np.int32), np.empty(slots)
        splitting_kernels.mark_ends(self.pieces, kernels.FREE_VERTEX, kernels.INPUT_VERTEX, self.stands_on)
        self.forget_sizes()
        self.head, self.tail = np.empty((2, kernels.BUCKETS), np.int32)
        self.queue = self.encroached = np.empty(0, np.int32)
        self.state = np.zeros(kernels.STATE_SIZE, np.int64)
        self.state[kernels.TRIANGLES] = mesh.n_triangles
        self.state[kernels.VERTICES] = len(mesh.order)
        self.state[kernels.FREE] = self.n_free

    def _keep_lines(self) -> None:
        """Mark lines as not to be split if they may not be; forget what else was marked so."""
        flags = self.origin[3::4]
        flags &= ~(half_edges.CONSTRAINED << 4)
        if not self.split_boundary:
            flags |= (flags & half_edges.CONSTRAINED) << 4

    def _between_near_lines(self, min_angle: float) -> float:
        """Triangles that the angle alone will make where the domain is narrow; raises if that is absurd."""
        mesh = self.mesh.triangulation
        triangles, width, length = assembly_kernels.narrow_parts(mesh.xy, mesh.origin, mesh.twin, mesh.n_triangles)
        if triangles > MAX_TRIANGLES:
            raise InvalidInput(
                f"{min_angle:g} would make about {triangles:.2g} triangles, since the domain is only "
                f"{width / self.scale:.3g} wide over a length of {length / self.scale:.3g}; at most {MAX_TRIANGLES:,} "
                "are allowed: set it to 0, which adds no points for shape, or divide these lines no further with "
                "split_boundary off",
                parameter="min_angle",
            )
        return triangles

    def live(self) -> tuple[np.ndarray, np.ndarray]:
        """(m, 3) int32 corners and (m,) int32 slots of the triangles."""
        triangulation = self.mesh.triangulation
        triangulation.xy, triangulation.origin, triangulation.twin = self.xy, self.origin, self.twin
        self.mesh.piece_of, self.mesh.face = self.piece_of, self.face
        triangulation.n_triangles = int(self.state[kernels.TRIANGLES])
        return triangulation.live()

    def areas(self, corners: np.ndarray) -> np.ndarray:
        """(m,) float: scaled areas of triangles."""
        a, b, c = self.xy.reshape(-1, 2)[corners.T]
        return 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])

    # ---- running

    def run(self, smoothing: int = 0) -> Refinement:
        """Refine until no triangle is poor, or the budget of points is spent; after rounds of smoothing do so again."""
        exhausted = self._refine_all(part_of(self.progress, 0.0, 0.8 if smoothing else 1.0))
        if smoothing and not exhausted:
            self._smooth(smoothing, part_of(self.progress, 0.8, 0.9))
            exhausted = self._refine_all(part_of(self.progress, 0.9, 1.0))
        # Whatever was not given up is as asked: each triangle was judged when it was made.
        poor = 0
        if exhausted or self.state[kernels.GIVEN_UP] or self.state[kernels.UNSPLIT]:
            self._queue_all(with_angle=True)
            poor = int(self.state[kernels.QUEUED])
        corners, slots = self.live()
        check(self.mesh, int(self.state[kernels.VERTICES]), self.domain.keep)
        xy = self.xy.reshape(-1, 2)[: self.state[kernels.VERTICES]]
        return Refinement(
            corners,
            self.domain.tag[self.face[slots]],
            np.ldexp(xy, -self.mesh.exponent) if self.mesh.exponent else xy,
            int(self.state[kernels.SPLITS]),
            int(self.state[kernels.INSERTIONS]),
            poor,
            exhausted,
        )

    def on_lines(self) -> tuple[np.ndarray, np.ndarray]:
        """(p, 2) vertices of the edges on lines, and the piece of each."""
        return edges_on_lines(self.origin, self.twin, self.piece_of, self.live()[1])

    def _refine_all(self, progress: Progress) -> bool:
        """Refine until no triangle is poor; whether the budget of points was spent first."""
        exhausted = False
        if self.size_field is not None:
            exhausted = self._size_rounds(progress, with_angle=False)
        if not exhausted:
            self._queue_all(with_angle=True)
            exhausted = self._refine(progress)
        if not exhausted and self.size_field is not None:
            exhausted = self._size_rounds(progress, with_angle=True)
        return exhausted

    def _smooth(self, rounds: int, progress: Progress) -> None:
        """Move vertices inside and flip edges; sizes are judged anew."""
        n = int(self.state[kernels.VERTICES])
        mesh = HalfEdges(
            self.xy,
            self.origin,
            self.twin,
            self.piece_of,
            n,
            int(self.state[kernels.TRIANGLES]),
            (self.stands_on[:n] != kernels.FREE_VERTEX).astype(np.uint8),
            self.edge_limit,
            self.face,
            self.area_limit,
            self.mesh.triangulation.scratch,
            is_delaunay=True,
        )
        smooth_in_place(mesh, rounds, progress)
        self._keep_lines()  # edges that were flipped have new marks
        self.forget_sizes()

    def forget_sizes(self) -> None:
        """Let the sizes of all triangles be judged anew."""
        self.edge_limit[:] = self.limits[kernels.EDGE2]

    def _size_rounds(self, progress: Progress, *, with_angle: bool) -> bool:
        """Judge the triangles made since the last round by the size field, and refine, until all pass."""
        while self._judge():
            self._queue_all(with_angle=with_angle)
            if self._refine(progress):
                return True
        return False

    def _judge(self) -> bool:
        """Set the limits of triangles that have none yet; whether one is beyond its own."""
        corners, slots = self.live()
        unjudged = self.limits[kernels.EDGE2]
        new = np.flatnonzero(self.edge_limit[slots] == unjudged)
        if not len(new):
            return False
        at = self.xy.reshape(-1, 2)[corners[new]]
        sizes = self.size_field(np.ldexp(at.mean(axis=1), -self.mesh.exponent)) * self.scale
        # One step below the value that means unjudged, so that no triangle is judged twice.
        limit = np.minimum(np.minimum(sizes, _LONGEST) ** 2, np.nextafter(unjudged, 0))
        self.edge_limit[slots[new]] = limit
        with np.errstate(divide="ignore", over="ignore"):
            needed = float((self.areas(corners) / (_AREA_BY_SIZE * self.edge_limit[slots])).sum())
        if needed > MAX_TRIANGLES:
            raise too_many(needed, "size_field")
        self.estimate = max(self.estimate, needed)
        longest2 = ((at - np.roll(at, 1, axis=1)) ** 2).sum(axis=2).max(axis=1)
        return bool((longest2 > limit).any())

    def _queue_all(self, *, with_angle: bool) -> None:
        self.limits[kernels.COSINE2] = self.cosine2 if with_angle else np.inf
        capacity = len(self.origin) // 4
        scratch = self.mesh.triangulation.scratch.size
        if len(self.queue) < 4 * (capacity + scratch):
            self.queue = np.empty(4 * (capacity + scratch), np.int32)
        if len(self.encroached) < 2 * (3 * capacity + 8 * scratch):
            self.encroached = np.empty(2 * (3 * capacity + 8 * scratch), np.int32)
        kernels.queue_all(
            self.xy, self.origin, self.twin, self.stands_on, self.pieces, self.face, self.edge_limit, self.area_limit,
            self.limits, self.queue, self.head, self.tail, self.encroached, self.state,
        )  # fmt: skip

    def _refine(self, progress: Progress) -> bool:
        """Refine what is queued; whether the budget of points was spent first."""
        scratch = self.mesh.triangulation.scratch
        budget = int(5 * max(self.estimate, len(self.mesh.triangulation.order))) + SPARE_POINTS
        while True:
            made = int(self.state[kernels.VERTICES])
            advance(progress, min(0.95, 2 * made / self.estimate), "refining")
            status = kernels.refine(
                self.xy, self.origin, self.twin, self.piece_of, self.stands_on, self.pieces, self.acute, self.face,
                self.edge_limit, self.area_limit, self.limits, self.queue, self.head, self.tail, self.encroached,
                self.free, scratch.cavity, scratch.stack, scratch.ring, scratch.ring_from, scratch.work, self.state,
                _STEPS_A_CHUNK,
            )  # fmt: skip
            if status == half_edges.DONE:
                return False
            if status == half_edges.FAILED:
                raise GenerationFailed("refinement met an impossible state; please report the lines")
            if made > budget:
                return True
            if status == half_edges.FULL:
                self._grow()

    def reserve(self, vertices: int, slots: int) -> None:
        """Make room for so many vertices, and triangles' slots; never less than there is."""
        if vertices > len(self.stands_on):
            self.xy = grown(self.xy, 2 * vertices)
            self.stands_on = grown(self.stands_on, vertices, kernels.FREE_VERTEX)
        if slots > len(self.face):
            self.origin, self.twin, self.piece_of = (
                grown(array, 4 * slots) for array in (self.origin, self.twin, self.piece_of)
            )
            self.face, self.free = grown(self.face, slots), grown(self.free, slots)
            self.edge_limit = grown(self.edge_limit, slots, self.limits[kernels.EDGE2])

    def _grow(self) -> None:
        """Make room in whatever buffer is nearly full."""
        state, scratch = self.state, self.mesh.triangulation.scratch
        if state[kernels.VERTICES] + 64 >= len(self.stands_on):
            self.reserve(2 * len(self.stands_on) + 1024, 0)
        elif 4 * state[kernels.TRIANGLES] + 1024 >= len(self.origin):
            self.reserve(0, 2 * (len(self.origin) // 4) + 1024)
        elif 4 * (state[kernels.QUEUED] + scratch.size) >= len(self.queue):
            self.queue = grown(self.queue, 2 * len(self.queue) + 8 * scratch.size)
        elif 2 * (state[kernels.ENCROACHED] + 4 * scratch.size) >= len(self.encroached):
            self.encroached = grown(self.encroached, 2 * len(self.encroached) + 16 * scratch.size)
        else:
            scratch.grow()


def expected_triangles(mesh: ConstrainedTriangulation, domain: Domain, size: float) -> float:
    """Triangles that limits, without the angle, will make of a domain.

    Parameters
    ----------
    mesh : ConstrainedTriangulation
        Not refined yet.
    domain : Domain
        What of it is meshed, and the largest areas.
    size : float
        Largest edge length.

    Raises
    ------
    InvalidInput
        If that is more than `MAX_TRIANGLES`.
    """
    scale = 2.0**mesh.exponent
    whole = mesh.triangulation
    area, shares = assembly_kernels.areas_kept(
        whole.xy, whole.origin, whole.n_triangles, mesh.face, domain.keep, 2 * domain.max_area * scale**2
    )
    by_area = shares / _AREA_BY_MAX_AREA
    edge = min(size * scale, _LONGEST)
    smallest = _AREA_BY_SIZE * edge * edge  # which underflows for sizes below 1e-160
    by_size = 0.5 * area / smallest if smallest > 0 else np.inf
    estimate = max(by_area, by_size)
    if estimate > MAX_TRIANGLES:
        raise too_many(estimate, "size" if by_size >= by_area else "max_area")
    return estimate


class TooMany(InvalidInput):
    """Limits would fill the memory."""


def too_many(estimate: float, parameter: str) -> TooMany:
    """The error for limits that would fill the memory."""
    return TooMany(
        f"would make about {estimate:.2g} triangles; at most {MAX_TRIANGLES:,} are allowed, so make it larger",
        parameter=parameter,
    )


@functools.lru_cache(maxsize=64)
def _angle_limits(min_angle: float) -> tuple[float, float, float]:
    """Squared cosine of the smallest angle, of that under which a point encroaches, and the off-centre's height.

    Points encroach within diametral lenses (Shewchuk 2002, section 3.4). The height is above the shortest edge, per its
    length; Triangle's factor 0.475 leaves a margin. Without a smallest angle no cosine reaches the limits.
    """
    if min_angle <= 0:
        return np.inf, 2.0, 0.0
    angle = np.radians(min_angle)
    return float(np.cos(angle) ** 2), float(np.cos(2 * angle) ** 2), float(0.475 / np.tan(angle / 2))


def acute_vertices(mesh: Triangulation) -> np.ndarray:
    """(n,) uint8: 1 for vertices where two pieces of segments meet at less than 60 degrees in live triangles."""
    acute = np.empty(len(mesh.order), np.uint8)
    splitting_kernels.mark_acute(mesh.xy, mesh.origin, mesh.twin, mesh.n_triangles, acute)
    return acute
