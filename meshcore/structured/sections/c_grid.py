"""C-grids: one block round a section and along both sides of its wake (survey 2.8.1, figure 12)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Annotated

import numpy as np

from ...geometry.curves import Curve
from ...geometry.section import Section
from ...mesh import Cut, StructuredGrid
from ...operation import Param, Port, Relative, absolute, operation
from ...progress import Progress, advance, part_of, silent
from ...report import Result
from ...sizing import Spacing
from ..limits import check_size
from . import section_parameters as parameters
from .base_block import base_points, with_base
from .c_front import Front, Wake, front_of
from .far_field import OuterCurve, c_shape, given_outer, half_box
from .lines_out import geometric_lines
from .section_front import BASE_CELLS
from .section_input import GivenSection, section_loop
from .section_march import layers_within, lines_by
from .section_points import Points, respaced_section
from .section_result import finished, scaled_jacobians
from .unwrapped import paths

_CURE = "make the section smoother or thinner, give more points around it, or take o_grid"
_BENDS = (0.3, 0.1, 0.03)
_EVENNESS = (0.7, 0.4, 1.0)
_PAST_BASE = 3.0
"""Heights over the section, in halves of a blunt base, from which on marches do not see its corners."""
_NAMES = {"imin": "outflow", "imax": "outflow", "jmin": "wall", "jmax": "far field"}


@operation("C Grid", category="Structured", output="grid or blocks")
def c_grid(
    section: parameters.SectionPort,
    outer: Annotated[Curve | None, Port("An open far field, its ends beside the wake's end", cells=("line",))] = None,
    *,
    far_field: Annotated[parameters.OpenFarField, Param("Shape of the far field: a C, or a box with corners")] = "C",
    radius: parameters.RadiusParam = 10.0,
    method: parameters.MethodParam = "hyperbolic",
    first_height: parameters.FirstHeightParam = Relative(0.001),
    y_plus: parameters.YPlusParam = None,
    reynolds: parameters.ReynoldsParam = 1e6,
    growth: parameters.GrowthParam = 1.15,
    layers: parameters.LayersParam = None,
    around: parameters.AroundParam = None,
    leading_spacing: parameters.LeadingParam = None,
    trailing_spacing: parameters.TrailingParam = None,
    law_i: parameters.LawIParam = "as given",
    wake: parameters.WakeParam = None,
    wake_cells: parameters.WakeCellsParam = None,
    wake_growth: parameters.WakeGrowthParam = 1.2,
    wake_spacing: parameters.WakeSpacingParam = None,
    outflow_spacing: parameters.OutflowSpacingParam = None,
    wake_height: parameters.WakeHeightParam = None,
    wake_angle: parameters.WakeAngleParam = 0.0,
    base: parameters.BaseParam = "block",
    spacings: Mapping[str, Spacing] | None = None,
    progress: Progress = silent,
) -> Result:
    """Wrap a C-grid of quadrilaterals around a section and its wake.

    The grid's j = 0 runs from the outflow along the wake to the trailing edge, clockwise round the section, and back
    along the wake, whose two sides are one line: a cut, which the grid knows. The trailing edge may be sharp, a cusp,
    or blunt. Behind a blunt one the two sides of the wake begin at its corners, and a second block stands between them.

    ::

             .--------------------.      i runs from the outflow below the wake round the section to that above it;
           /     .-----.          |      j runs out: jmin is the "wall" between the two sides of the cut "wake",
          |     ( wing  >---------|      jmax the "far field", imin and imax the "outflow"
           \\     '-----'          |
             '--------------------'

    Parameters
    ----------
    section : Mesh or (n, 3) float
        The closed loop, in any plane; in an upright one z is up. A narrow gap at the trailing edge is closed.
    outer : Mesh or (m, 3) float, optional
        A far field of your own: an open curve round the section, from beside the wake's end to beside it.
    far_field : {"C", "box"}
        The far field if there is no `outer`.
    radius : float
        Distance of the far field from mid-chord, in chords. The chord reaches from the trailing edge to the point
        farthest from it.
    method : {"transfinite", "elliptic", "hyperbolic", "parabolic"}
        Lines by interpolation between section and far field; that grid smoothed by the elliptic equations, with right
        angles and first heights held; marched off at right angles as far as the C is, the far field being where they
        arrive, or drawn onto a box or an `outer`; or marched onto the far field. The hyperbolic one has the least
        skewed cells. Where straight lines cross, lines of the parabolic march take their place.
    first_height : Length
        Distance of the first points from the section, and from the wake.
    y_plus : float, optional
        The first height in wall units instead, by the friction of a flat plate at `reynolds`.
    reynolds : float
        Reynolds number of the chord.
    growth : float
        Heights grow from cell to cell by no more than this factor, if `layers` is left out.
    layers : int, optional
        Cells along j. The growth then follows.
    around : int, optional
        Cells round the section, which is then resampled on a spline: densely where it bends, with its corners kept.
    leading_spacing, trailing_spacing : Length, optional
        Sizes of the cells at the nose and at the trailing edge.
    law_i : str
        Law of the points' spacing along each side from the trailing edge to the nose, see `Spacing`, whose end cells
        are `trailing_spacing` and `leading_spacing`. "as given" keeps the section's own points, or resamples it as told
        above; "copied" gives the lower side the spacing of the upper one. Corners are kept: the nearest points move
        onto them.
    wake : float, optional
        Length of the wake along the chord's direction, in chords.
    wake_cells : int, optional
        Cells along the wake.
    wake_growth : float
        Cells grow along the wake by no more than this factor, if `wake_cells` is left out.
    wake_spacing : Length, optional
        Length of the wake's first cells; by default the mean of the section's last ones.
    outflow_spacing : Length, optional
        Length of the wake's last cells, at the outflow. Along the wake points then stand by a hyperbolic tangent, as
        wherever a size at an end is asked for, otherwise by constant growth.
    wake_height : Length, optional
        Height of the first cells at the wake's end; from the trailing edge on heights change evenly with the distance.
    wake_angle : float
        Degrees from the chord's direction, counter-clockwise, of the wake's end. At the trailing edge it has the
        direction of the bisector, and turns within half a chord.
    base : {"block", "wrapped"}
        Behind a blunt trailing edge: a block of its own, whose "imin" is the base, or cells of the one block that go
        round the base to a wake that begins at its middle; at its corners these are skewed by 45 degrees and more.
    spacings : dict of str to Spacing, optional
        Laws of single sides, "upper" and "lower", from the trailing edge to the nose. From Python only.
    progress : Progress, optional
        Called with fraction and message.

    Returns
    -------
    Result
        `StructuredGrid` of (ni, nj, 1) points with its cut, or `MultiBlock` of it, "section", and the block "base", in
        which i runs downstream and j up; and the report.

    Raises
    ------
    InvalidInput
        If a length does not fit.
    InvalidGeometry
        If the section is open, crosses itself, is not in a plane, or without area; `points` tells where.
    GenerationFailed
        If cells are folded; `cells` and `partial` show where.

    Notes
    -----
    The transfinite grid, from which all others take their heights, is one between front and far field in the plane of a
    square root, which opens both into nearly straight lines (Jameson's parabolic coordinates), with lines normal to the
    section. Levels of the other methods are moved along their lines, or marched anew, until layers grow by one factor
    from the first height on.

    The wake stays where it is asked to be, near where the flow goes. Elliptic lines run through it at right angles,
    with cells of one height on both sides, as the equations would have it on a line that is free.

    References
    ----------
    Survey, section 2.8.1 (figure 12). A. Jameson, "Iterative solution of transonic flows over airfoils and wings",
    Comm. Pure Appl. Math. 27 (1974).

    Examples
    --------
    >>> from meshcore import gallery
    >>> grid, report = c_grid(gallery.airfoil("rae2822"), radius=5, first_height=1e-4)
    >>> grid.cuts[0].name, grid.names["jmin"]
    ('wake', 'wall')
    >>> c_grid(gallery.airfoil("naca0012"), radius=5).mesh.names
    ('section', 'base')
    """
    given = section_loop(section)
    if around is not None:
        check_size(around + 1, (layers or 1) + 1, parameter="around")
    points = Points.asked(given.diagonal, around, leading_spacing, trailing_spacing, law_i, spacings)
    shape = respaced_section(Section.of(given.loop), points)
    reach = radius * shape.chord
    height = parameters.wall_height(first_height, y_plus, reynolds, shape.loop, shape.chord, given.diagonal, reach)
    lengths = (wake_spacing, outflow_spacing, wake_height)
    sizes = (None if x is None else absolute(x, given.diagonal) for x in lengths)
    asked = Wake((wake or radius) * shape.chord, wake_cells, wake_growth, *sizes, wake_angle).checked(reach)
    front = front_of(shape, asked, height, growth, block=base == "block")
    curve = _outer_curve(given, shape, outer, far_field, reach, front.end)
    advance(progress, 0.1, "choosing lines")
    points = _best(front, curve, layers, growth, part_of(progress, 0.1, 0.5))
    step, past = part_of(progress, 0.5, 0.6), _past_base(front, points)
    onto = None if outer is None and far_field == "C" else lambda ends: curve.like(ends, front.opened.nose)
    method, points, told, changed = lines_by(
        method, points, closed=False, plane=given.plane, progress=step, kept=past, bound=outer is not None, onto=onto
    )
    grid = _block(front, points, given)
    counts = {"around": len(points) - 1 - 2 * front.wake, "wake": front.wake, "layers": grid.cell_shape[1], **changed}
    figures = {"first height": height, **({} if y_plus is None else {"y+": y_plus})}
    kept = np.ones(len(points)) if past else None  # lines fan out there
    warnings = [*given.warnings, *told]
    last = part_of(progress, 0.6, 1.0)
    result = finished(grid, method, kept, past, _CURE, counts, figures, warnings, last, front.heights)
    if not front.across:
        return result
    behind = base_points(*front.sides, front.heights[len(points) - 1 - front.wake :], front.across)
    return with_base(result, given.to_space(behind), _CURE)


def _block(front: Front, points: np.ndarray, given: GivenSection) -> StructuredGrid:
    """The block round the section, in space, and with its cut if it has one."""
    n, cuts = len(points) - 1, ()
    if not front.across:
        points[n - front.wake :, 0] = points[front.wake :: -1, 0]  # the cut, to the last bit
        place = ((0, 0, 0), (front.wake, 0, 0)), ((n, 0, 0), (n - front.wake, 0, 0))
        cuts = (Cut(*place, (-1, -2, 3), name="wake"),)
    return StructuredGrid(given.to_space(points), names=_NAMES, cuts=cuts)


def _past_base(front: Front, points: np.ndarray) -> int:
    """Layers of the transfinite grid that marches and smoothing keep: those that round a blunt base, if sound."""
    if not front.opened.shift.any():
        return 0
    n, wake = len(front.points), front.wake
    base = float(np.linalg.norm(front.points[wake] - front.points[wake + BASE_CELLS]))
    return layers_within(points, n // 2, _PAST_BASE * base, 2)


def _outer_curve(given: GivenSection, section: Section, outer, shape: str, reach: float, end: np.ndarray) -> OuterCurve:
    ahead = 0.5 * (section.nose + section.tail) - reach * section.direction
    if outer is not None:
        return OuterCurve.ahead_of(given_outer(outer, given.plane, section.loop, closed=False), section)
    return OuterCurve((c_shape if shape == "C" else half_box)(section, reach, end), ahead)


def _best(front: Front, curve: OuterCurve, layers: int | None, growth: float, progress: Progress) -> np.ndarray:
    """Points of the family's soundest grid."""
    best, chosen = np.inf, None
    tries = [(evenness, bend) for evenness in _EVENNESS for bend in _BENDS]
    for number, (evenness, bend) in enumerate(tries):
        advance(progress, number / len(tries), "choosing lines")
        stop = _ends(front, curve, evenness)
        levels = np.concatenate([[0.0], np.geomspace(1e-4, 1, 24)])
        t = np.broadcast_to(levels, (len(stop), len(levels)))
        sound = scaled_jacobians(front.opened.wrap(paths(front.opened, stop, bend, t)))
        worst = float(sound.min())
        score = float((sound**-2.0).mean()) if worst > 0 else 1e9 * (1 - worst)
        if score < best:
            best, chosen = score, (stop, bend)
    stop, bend = chosen
    # Beside a blunt base lines that are moved downstream take the levels of lines that are not.
    unmoved = replace(front.opened, shift=np.zeros((2, len(front.heights))))
    wrap = front.opened.wrap
    t, _ = geometric_lines(lambda t: wrap(paths(unmoved, stop, bend, t)), front.heights, layers, growth)
    points = front.opened.wrap(paths(front.opened, stop, bend, t))
    points[:, 0] = front.points
    return points


def _ends(front: Front, curve: OuterCurve, evenness: float) -> np.ndarray:
    """(n,) complex: where lines end on the far field, between as the front's points are opened and evenly by number."""
    xi, nose = front.opened.front.real, front.opened.nose
    number = np.arange(len(xi)) - nose
    low = number < 0
    share = (1 - evenness) * xi / np.where(low, -xi[0], xi[-1])
    share = share + evenness * number / np.where(low, nose, len(xi) - 1 - nose)
    share[nose], share[0], share[-1] = 0.0, -1.0, 1.0
    places = curve.at(np.clip(share, -1, 1))
    before = front.opened.unwrap(places[nose::-1], 1j)[::-1]
    return np.concatenate([before[:-1], front.opened.unwrap(places[nose:], 1j)])
