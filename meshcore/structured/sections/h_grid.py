"""H-grids: two blocks, above and below a section, a slab or a slit, nearly Cartesian (survey 2.8.1, figure 13)."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np

from ...errors import InvalidGeometry
from ...geometry.curves import Curve, arc_length, is_closed, polyline, turning
from ...geometry.plane import Plane, fitted_plane
from ...geometry.section import Section
from ...mesh import Cut, MultiBlock, StructuredGrid
from ...operation import Relative, absolute, operation
from ...progress import Progress, advance, silent
from ...quality import summary, validate
from ...report import Report, Result
from ...sizing import cells_for_growth, geometric
from ..folds import FLAT, refuse_folds
from ..limits import check_extent, check_size
from . import section_parameters as parameters
from .lines_out import geometric_lines
from .section_front import respaced_section
from .section_input import section_loop
from .section_march import Lines, lines_by
from .section_result import scaled_jacobians
from .section_smoothing import smoothed
from .unwrapped import free_reach, leaving, normals, shifts_beyond

_CURE = "make the section smoother or thinner, give more points around it, or take c_grid or o_grid"
_BENDS = (0.3, 0.1, 0.03)
_STEEP = np.radians(45)
"""Slope from the flow's direction from which on the front of a section counts as a step."""
_LEVEL = 1e-6
"""Of the extent: how far the points of a flat front or rear may be apart along the flow."""


@operation("H Grid", category="Structured", output="blocks")
def h_grid(
    section: parameters.SectionOrSlitPort,
    *,
    radius: parameters.RadiusParam = 10.0,
    first_height: parameters.FirstHeightParam = Relative(0.001),
    y_plus: parameters.YPlusParam = None,
    reynolds: parameters.ReynoldsParam = 1e6,
    growth: parameters.GrowthParam = 1.15,
    layers: parameters.LayersParam = None,
    around: parameters.AroundParam = None,
    leading_spacing: parameters.LeadingParam = None,
    trailing_spacing: parameters.TrailingParam = None,
    wake: parameters.WakeParam = None,
    wake_growth: parameters.WakeGrowthParam = 1.2,
    flow: parameters.FlowParam = 0.0,
    progress: Progress = silent,
) -> Result:
    """Make an H-grid of quadrilaterals round a section in a box: a block above it and a block below.

    Lines i run with the flow, over and under the section; before and behind it the two blocks are joined by cuts. The
    section may be an airfoil, a slab with flat ends, or a slit without thickness.

    ::

        +-----------------------------+      "upper" and "lower": i runs from the "inflow" to the "outflow",
        |   |   |   |  |  |   |   |   |      j upwards; jmin of the upper and jmax of the lower block are the "wall"
        +---+---+---(=====)---+---+---+      between the two cuts "ahead" and "wake"; the rest is the "far field"
        |   |   |   |  |  |   |   |   |
        +-----------------------------+

    Parameters
    ----------
    section : Mesh or (n, 3) float
        A closed loop, or an open line: a slit from its first point to its last.
    radius : float
        Distance of the box from mid-chord, in chords: ahead, above and below.
    first_height : Length
        Distance of the first points from the section.
    y_plus : float, optional
        The first height in wall units instead, by the friction of a flat plate at `reynolds`.
    reynolds : float
        Reynolds number of the chord.
    growth : float
        Heights grow from cell to cell by no more than this factor, if `layers` is left out.
    layers : int, optional
        Cells along j of each block.
    around : int, optional
        Cells round the section, which is then resampled on a spline.
    leading_spacing, trailing_spacing : Length, optional
        Sizes of the cells at the nose and at the trailing edge.
    wake : float, optional
        Length of the box behind the section, in chords.
    wake_growth : float
        Cells grow by no more than this factor along the wake, and ahead of the nose.
    flow : float
        Degrees from the chord, counter-clockwise, to the direction of the box.
    progress : Progress, optional
        Called with fraction and message.

    Returns
    -------
    Result
        `MultiBlock` of two blocks with their cuts, and the report.

    Raises
    ------
    InvalidInput
        If a length does not fit.
    InvalidGeometry
        If the section crosses itself, is not in a plane, or without extent.
    GenerationFailed
        If cells are folded; `cells` and `partial`, one block, show where.

    References
    ----------
    Survey, section 2.8.1 (figures 10 and 13).

    Examples
    --------
    >>> from meshcore import gallery
    >>> blocks, report = h_grid(gallery.airfoil("rae2822"), radius=3, first_height=0.005)
    >>> blocks.names, [cut.name for cut in blocks.cuts]
    (('lower', 'upper'), ['ahead', 'wake'])
    """
    chains, plane, frame, diagonal, warnings = _chains(section, around, leading_spacing, trailing_spacing, flow)
    chord = float(np.linalg.norm(chains[0].points[-1] - chains[0].points[0]))
    both = np.vstack([chain.points for chain in chains])
    height = parameters.wall_height(first_height, y_plus, reynolds, both, chord, diagonal, radius * chord)
    reach, behind = radius * chord, (wake or radius) * chord
    ahead_line, wake_line = _lines_of_cuts(chains, reach, behind, wake_growth)
    blocks, ratios = [], []
    split: Counter[str] = Counter()
    for number, chain in enumerate(chains):
        advance(progress, 0.1 + 0.4 * number, "choosing lines")
        lower = number == 0
        up = np.array([1, -1]) if lower else np.array([1, 1])
        points, ratio = _half(chain, ahead_line * up, wake_line * up, reach, height, layers, growth)
        method, points, told, changed = _uncrossed(points, len(ahead_line) - 1, len(wake_line) - 1)
        ratios.append(ratio)
        split.update(changed)
        local = points[:, ::-1] * up if lower else points
        spatial = plane.to_space((local @ frame).reshape(-1, 2)).reshape(*local.shape[:2], 3)
        far, wall = ("jmin", "jmax") if lower else ("jmax", "jmin")
        names = {"imin": "inflow", "imax": "outflow", far: "far field", wall: "wall"}
        block = StructuredGrid(spatial, names=names)
        if method == "elliptic":
            block, _, more = smoothed(block, None, _CURE, silent)
            told += more
        warnings += [f"{'below' if lower else 'above'} the section: {text}" for text in told]
        blocks.append(block)
        refuse_folds(blocks[-1], _CURE)
        validate(blocks[-1])
    grid = _joined(blocks, len(ahead_line) - 1, len(wake_line) - 1)
    counts = {"points": grid.n_points, "quads": grid.n_cells, "layers": blocks[0].cell_shape[1]}
    counts |= {"ahead": len(ahead_line) - 1, "wake": len(wake_line) - 1, **split}
    told = {"first height": height, **({} if y_plus is None else {"y+": y_plus}), "largest growth": max(ratios)}
    quality = {**summary(grid.to_mesh()), **told}
    return Result(grid, Report(counts=counts, quality=quality, warnings=warnings))


@dataclass(frozen=True)
class _Chain:
    """One side of a section, from nose to tail, x along the flow and y away from the section.

    Attributes
    ----------
    points : (n, 2) float
        From the middle of the front, or the nose, to the middle of the rear, or the trailing edge.
    first, last : int
        Where the steps of its front and rear end and begin.
    """

    points: np.ndarray
    first: int
    last: int


def _chains(section: Curve, around, leading, trailing, flow: float):
    """Lower and upper side (the lower one upside down), plane, axes of the flow (2, 2), diagonal, and warnings."""
    points = polyline(section, "section")
    if not is_closed(points) and not _narrow(points):
        return _slit(points, flow)
    given = section_loop(section)
    lead, trail = (None if x is None else absolute(x, given.diagonal) for x in (leading, trailing))
    if around is not None:
        check_size(around + 1, 2, parameter="around")
    shape = respaced_section(Section.of(given.loop), around, lead, trail)
    loop = shape.loop
    along = _turned(shape.direction, flow)
    if shape.edge == "round" or len(np.flatnonzero(np.abs(turning(loop)) > np.radians(60))) > 3:
        along = _turned(np.array([1.0, 0.0]), flow)  # bodies without a trailing edge, and slabs
    frame = np.array([along, [-along[1], along[0]]])
    local = loop @ frame.T
    tail = _end(local, shape.lower if shape.edge == "blunt" else None)
    nose = _end(local * [-1, 1], None)
    upper = _side(local, nose, tail)
    lower = _side(local[::-1] * [1, -1], *((len(local) - 1 - a, len(local) - 1 - b) for b, a in (nose, tail)))
    return (lower, upper), given.plane, frame, given.diagonal, list(given.warnings)


def _narrow(points: np.ndarray) -> bool:
    """Whether an open line is a section whose trailing edge is open, rather than a slit."""
    gap = float(np.linalg.norm(points[-1] - points[0]))
    return len(points) > 3 and gap < 0.05 * float(np.ptp(points, axis=0).max())


def _slit(points: np.ndarray, flow: float):
    diagonal = check_extent(points, parameter="section")
    straight = np.ptp(points - points[0], axis=0).max() > 0
    try:
        plane = fitted_plane(points, parameter="section")
    except InvalidGeometry:
        if not straight:
            raise
        plane = Plane(np.zeros(3), np.eye(3)[:2])
    line = plane.to_plane(points)
    line = line if line[0, 0] <= line[-1, 0] else line[::-1]
    along = _turned((line[-1] - line[0]) / np.linalg.norm(line[-1] - line[0]), flow)
    frame = np.array([along, [-along[1], along[0]]])
    local = line @ frame.T
    if (np.diff(local[:, 0]) <= 0).any():
        raise InvalidGeometry("is a slit that turns back against the flow; make it shallower", parameter="section")
    n = len(local) - 1
    return (_Chain(local * [1, -1], 0, n), _Chain(local, 0, n)), plane, frame, diagonal, []


def _turned(direction: np.ndarray, degrees: float) -> np.ndarray:
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([c * direction[0] - s * direction[1], s * direction[0] + c * direction[1]])


def _end(local: np.ndarray, lower: int | None) -> tuple[int, int]:
    """Numbers of the lower and the upper corner of the rear of a counter-clockwise loop; the same if it is a point."""
    if lower is not None:
        return lower, 0
    x = local[:, 0]
    rear = np.flatnonzero(x > x.max() - _LEVEL * np.ptp(x))
    order = rear[np.argsort(local[rear, 1])]
    return int(order[0]), int(order[-1])


def _side(local: np.ndarray, nose: tuple[int, int], tail: tuple[int, int]) -> _Chain:
    """The upper side of a counter-clockwise loop: from the middle of its front over the top to that of its rear.

    ``nose`` and ``tail`` are the lower and upper corners of front and rear.
    """
    n = len(local)
    count = (nose[1] - tail[1]) % n
    top = local[(nose[1] - np.arange(count + 1)) % n]
    edges = np.linalg.norm(np.diff(top, axis=0), axis=1)
    front = _face(0.5 * (local[nose[0]] + local[nose[1]]), top[0], edges[0])
    rear = _face(top[-1], 0.5 * (local[tail[0]] + local[tail[1]]), edges[-1])
    points = np.vstack([front[:-1], top, rear[1:]])
    first, last = len(front) - 1, len(points) - len(rear)
    if first == 0:
        first = _steep_until(points)
    if last == len(points) - 1:
        last = len(points) - 1 - _steep_until(points[::-1] * [-1, 1])
    return _Chain(points, first, max(last, first))


def _face(start: np.ndarray, stop: np.ndarray, size: float) -> np.ndarray:
    """Points of half a flat front or rear, in cells of about a size; one point where there is none."""
    length = float(np.linalg.norm(stop - start))
    if length == 0:
        return start[None]
    cells = int(np.clip(round(length / size), 2, 200))
    return start + np.linspace(0, 1, cells + 1)[:, None] * (stop - start)


def _steep_until(points: np.ndarray) -> int:
    """Number of the point up to which a side rises steeply from its nose; 0 if it does not."""
    edge = np.diff(points, axis=0)
    steep = np.arctan2(edge[:, 1], edge[:, 0]) > _STEEP
    return int(np.argmin(steep)) if not steep.all() else len(points) // 2


def _lines_of_cuts(chains: tuple[_Chain, _Chain], reach: float, behind: float, growth: float):
    """(k, 2) points ahead of the section, from the inflow to it, and behind it, of the upper side."""
    upper = chains[1].points
    middle = 0.5 * (upper[0, 0] + upper[-1, 0])
    sizes = [min(np.linalg.norm(c.points[k[0]] - c.points[k[1]]) for c in chains) for k in ((0, 1), (-1, -2))]
    ahead = _growing(reach - (middle - upper[0, 0]), sizes[0], growth)
    wake = _growing(behind, sizes[1], growth)
    return (
        upper[0] + np.column_stack([-ahead[::-1], 0 * ahead]),
        upper[-1] + np.column_stack([wake, 0 * wake]),
    )


def _growing(length: float, first: float, growth: float) -> np.ndarray:
    share = min(first / length, 0.2)
    return length * geometric(max(2, cells_for_growth(share, growth)), first=share)


def _half(
    chain: _Chain, ahead: np.ndarray, wake: np.ndarray, reach: float, height: float, layers: int | None, growth: float
) -> tuple[np.ndarray, float]:
    """(n, layers + 1, 2) points of one block, j away from the section, and the largest growth."""
    front = np.vstack([ahead[:-1], chain.points, wake[1:]])
    nose, tail = len(ahead) - 1, len(ahead) - 1 + len(chain.points) - 1
    first, last = nose + chain.first, nose + chain.last
    n, shifts = len(front) - 1, []
    if last < tail:
        shifts.append(shifts_beyond(front, last, tail))
    if first > nose:
        shifts.append(shifts_beyond(front[::-1] * [-1, 1], n - first, n - nose)[:, ::-1] * [[-1], [1]])
    for amount, _ in shifts:
        amount[[0, -1]] = 0.0
    normal = normals(front)
    normal[: first + (first > nose)] = normal[last + (last == tail) :] = 1j
    free = free_reach(front, np.unique([nose, first, last, tail]))
    w, up = front[:, 0] + 1j * front[:, 1], np.full(len(front), 1j)
    top = 0.5 * (chain.points[0, 1] + chain.points[-1, 1]) + reach
    chord, still = float(np.ptp(chain.points[:, 0])), np.zeros((2, len(front)))

    def lines(t: np.ndarray, bend: float, moved: list[np.ndarray]) -> np.ndarray:
        d = t * (top - w.imag)[:, None]
        turned = leaving(normal, free, still, bend * chord, d) * (1 - t) ** 2
        # Lines that begin above each other stay side by side up to the far field.
        found = w[:, None] + 1j * d + turned + sum(leaving(up, free, shift, bend * chord, d) for shift in moved)
        return np.stack([found.real, found.imag], axis=-1)

    levels = np.broadcast_to(np.concatenate([[0.0], np.geomspace(1e-4, 1, 24)]), (len(w), 25))
    worst = [scaled_jacobians(lines(levels, bend, shifts)).min() for bend in _BENDS]
    bend = _BENDS[int(np.argmax(worst))]
    heights = np.full(len(w), height)
    # Beside steps lines that are moved sideways take the levels of lines that are not.
    t, ratio = geometric_lines(lambda t: lines(t, bend, []), heights, layers, growth)
    points = lines(t, bend, shifts)
    points[:, 0] = front
    return points, ratio


def _uncrossed(points: np.ndarray, ahead: int, wake: int) -> Lines:
    """Lines of a block that march instead where they crossed, onto a far field along which they keep their order.

    ``ahead`` and ``wake`` are the cells before and behind the section.
    """
    if (scaled_jacobians(points) > FLAT).all():
        return Lines("transfinite", points, [], {})
    points, last = points.copy(), len(points) - 1 - wake
    length = arc_length(points[ahead : last + 1, 0])
    start, stop = points[[ahead, last], 0, 0]
    points[:, -1, 0] = points[:, 0, 0]
    points[ahead : last + 1, -1, 0] = start + (stop - start) * length / length[-1]
    return lines_by("transfinite", points, closed=False, progress=silent)


def _joined(blocks: list[StructuredGrid], ahead: int, wake: int) -> MultiBlock:
    """Both blocks, made to meet to the last bit, with their cuts."""
    lower, upper = blocks
    (n, m, _), k = lower.shape, upper.shape[0]
    points = lower.points.copy()
    points[: ahead + 1, -1] = upper.points[: ahead + 1, 0]
    points[n - 1 - wake :, -1] = upper.points[k - 1 - wake :, 0]
    before = Cut(((0, m - 1, 0), (ahead, m - 1, 0)), ((0, 0, 0), (ahead, 0, 0)), (1, 2, 3), 0, 1, name="ahead")
    behind = Cut(
        ((n - 1 - wake, m - 1, 0), (n - 1, m - 1, 0)),
        ((k - 1 - wake, 0, 0), (k - 1, 0, 0)),
        (1, 2, 3),
        0,
        1,
        name="wake",
    )
    return MultiBlock((lower.with_points(points), upper), ("lower", "upper"), (before, behind))
