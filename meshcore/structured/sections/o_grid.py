"""Grids of one block wrapped around a section: the O-grid (survey 2.8.1)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated

import numpy as np

from ...errors import InvalidInput
from ...geometry.curves import Curve
from ...geometry.section import Section as SectionShape
from ...mesh import StructuredGrid
from ...operation import Param, Port, Relative, operation
from ...progress import Progress, advance, part_of, silent
from ...report import Result
from ...sizing import Spacing, cells_for_growth, geometric
from ..limits import check_size
from . import section_parameters as parameters
from .far_field import FarField, PolarCurve, box_corners, given_outer
from .lines_out import check_heights
from .rays import Section, at_height, paths, ray_directions, to_far_field
from .section_input import GivenSection, section_loop, with_own_outer
from .section_march import lines_by
from .section_points import Points
from .section_result import finished, scaled_jacobians

_CURE = "make the section smoother or less re-entrant, move the far field, or give more points around it"
_WIDTHS = (0.03, 0.06, 0.12)
_EVENNESS = (1.0, 0.7, 0.4, 0.2, 0.05)
_BENDS = (0.4, 0.15)
UNEVEN = 0.1
"""Weight of an uneven far field beside skewed cells, when rays are chosen."""


@operation("O Grid", category="Structured", output="grid")
def o_grid(
    section: parameters.SectionPort,
    outer: Annotated[Curve | None, Port("A closed far field round the section", cells=("line",))] = None,
    *,
    far_field: Annotated[FarField, Param("Shape of the far field: a circle, or a box with corners")] = "circle",
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
    cut: Annotated[
        int, Param("Point of the section where the grid is cut; -1 finds the sharpest", min=-1, advanced=True)
    ] = -1,
    spacings: Mapping[str, Spacing] | None = None,
    progress: Progress = silent,
) -> Result:
    """Wrap an O-grid of quadrilaterals around a closed section, out to a circle, a box or a given curve.

    Grid lines leave the section at right angles. The points of the section are kept exactly, unless others are asked
    for.

    ::

             .---------.         i runs around the section, clockwise, from the cut and back to it (periodic)
           /   .-----.   \\       j runs out: jmin is the "wall", jmax the "far field"
          |   ( wing  >---|  <- cut, along the trailing edge's bisector
           \\   '-----'   /
             '---------'

    Parameters
    ----------
    section : Mesh or (n, 3) float
        The closed loop, in a plane of any attitude. A narrow gap at the trailing edge is closed. A mesh of two loops,
        one round the other, is the section and its `outer`.
    outer : Mesh or (m, 3) float, optional
        A far field of your own: a closed curve that can be seen whole from mid-chord.
    far_field : {"circle", "box"}
        The far field if there is no `outer`, about mid-chord.
    radius : float
        Its radius, or half its width, in chords. The chord is the section's greatest extent.
    method : {"transfinite", "elliptic", "hyperbolic", "parabolic"}
        Lines by interpolation between section and far field; that grid smoothed by the elliptic equations, with right
        angles and first heights held; marched off at right angles as far as the circle is, the far field being where
        they arrive, or drawn onto a box or an `outer`; or marched onto the far field. The hyperbolic one has by far the
        least skewed cells. Where straight lines cross, lines of the parabolic march take their place.
    first_height : Length
        Distance of the first points from the section.
    y_plus : float, optional
        The first height in wall units instead, by the friction of a flat plate at `reynolds`.
    reynolds : float
        Reynolds number of the chord.
    growth : float
        Heights grow from cell to cell by no more than this factor, if `layers` is left out.
    layers : int, optional
        Cells along j. The growth then follows.
    around : int, optional
        Cells along i: the section is resampled on a cubic spline, densely where it bends, with its corners kept.
    leading_spacing, trailing_spacing : Length, optional
        Sizes of the cells at the nose and at the cut.
    law_i : str
        Law of the points' spacing along each side from the trailing edge to the nose, see `Spacing`, whose end cells
        are `trailing_spacing` and `leading_spacing`. "as given" keeps the section's own points, or resamples it as told
        above; "copied" gives the lower side the spacing of the upper one. Corners are kept: the nearest points move
        onto them.
    cut : int
        Number of the point where i begins; -1 takes the sharpest turn, an airfoil's trailing edge.
    spacings : dict of str to Spacing, optional
        Laws of single sides, "upper" and "lower", from the trailing edge to the nose. From Python only.
    progress : Progress, optional
        Called with fraction and message.

    Returns
    -------
    Result
        `StructuredGrid` of (ni, nj, 1) points, periodic in i, and the report.

    Raises
    ------
    InvalidInput
        If a length does not fit, or `cut` is no point of the section.
    InvalidGeometry
        If the section is open, not in a plane, or without area.
    GenerationFailed
        If no choice of rays gives sound cells, as around deep bays; `cells` and `partial` show where.

    Notes
    -----
    The transfinite grid, from which all others take their heights, is the projection P_t between wall and circle, with
    the derivative matched at the wall, so that lines are normal to it. Where rays meet the far field is a blend of arc
    length and of the section's positive turning; of a small family of blends that with the best corners and an even
    circle is taken.

    References
    ----------
    Survey, sections 2.4.1 and 2.8.1 (figure 11).

    Examples
    --------
    >>> from meshcore import gallery
    >>> grid, report = o_grid(gallery.circle(24), radius=3, layers=8)
    >>> grid, grid.names["jmin"]
    (StructuredGrid(25 x 9 points), 'wall')
    """
    section, own_outer = with_own_outer(section) if outer is None else (section, None)
    outer = own_outer if outer is None else outer
    given = section_loop(section)
    warnings = list(given.warnings)
    loop = given.begun_at(cut)
    chord, centre = _chord(loop)
    if around is not None:
        check_size(around + 1, (layers or 1) + 1, parameter="around")
    asked = Points.asked(given.diagonal, around, leading_spacing, trailing_spacing, law_i, spacings)
    loop = _on_points(asked, given, loop, cut)
    reach = radius * chord
    height = parameters.wall_height(first_height, y_plus, reynolds, loop, chord, given.diagonal, reach)
    far = PolarCurve(centre, reach)
    if outer is not None or far_field == "box":
        shape = SectionShape.of(given.loop)
        closed = (
            box_corners(shape, reach) if outer is None else given_outer(outer, given.plane, shape.loop, closed=True)
        )
        far = PolarCurve(centre, closed)
    points = _wrapped(loop, far, chord, height, growth, layers, part_of(progress, 0.0, 0.6))
    points = points[::-1]  # clockwise, so that i, j are right-handed
    step = part_of(progress, 0.6, 0.8)
    onto = None if far.circle else lambda ends: far.in_order(far.onto(ends[::-1]))[::-1]
    method, points, told, changed = lines_by(
        method, points, closed=True, plane=given.plane, progress=step, bound=outer is not None, onto=onto
    )
    warnings += told
    names = {"jmin": "wall", "jmax": "far field"}
    grid = StructuredGrid(given.to_space(points), names=names, periodic=(True, False, False))
    counts = {"around": grid.cell_shape[0], "layers": grid.cell_shape[1], **changed}
    figures = {"first height": height, **({} if y_plus is None else {"y+": y_plus})}
    return finished(grid, method, None, 0, _CURE, counts, figures, warnings, part_of(progress, 0.8, 1.0))


def _on_points(asked: Points, given: GivenSection, loop: np.ndarray, cut: int) -> np.ndarray:
    """The loop on the points asked for; laws see a blunt edge as C-grids do, unless the cut is the user's own."""
    shape = SectionShape.of(given.loop)
    if cut != -1 or not asked.by_law or shape.edge != "blunt":
        return asked.on(loop)
    found = asked.on(shape.loop, shape.lower)
    return np.roll(found, -int(np.argmin(np.abs(found - loop[0]).sum(axis=1))), axis=0)


def _chord(loop: np.ndarray) -> tuple[float, np.ndarray]:
    """Length and middle of a section's chord: from the point farthest from its cut to the point farthest from that."""
    far = loop[np.argmax(np.linalg.norm(loop - loop[0], axis=1))]
    away = np.linalg.norm(loop - far, axis=1)
    other = loop[np.argmax(away > (1 - 1e-9) * away.max())]  # of both corners of a base that of the cut
    return float(np.linalg.norm(other - far)), 0.5 * (far + other)


def _wrapped(loop, far, chord, height, growth, layers, progress) -> np.ndarray:
    """(n + 1, layers + 1, 2) points, counter-clockwise from the wall to the far field."""
    around = Section.of(loop)
    advance(progress, 0.1, "choosing rays")
    rays, bend = _best_rays(around, far, chord, height)
    advance(progress, 0.5, "interpolating")
    reach = to_far_field(around, rays, bend, far)
    first = at_height(around, rays, bend, height)
    check_heights(first, reach)
    first = first / reach
    if layers is None:
        layers = cells_for_growth(float(first.min()), growth)
    check_size(len(loop) + 1, layers + 1, parameter="layers")
    try:
        fractions = np.array([geometric(layers, first=f) for f in first[:-1]])
    except InvalidInput as error:
        raise InvalidInput(
            f"{height:.6g} does not fit {layers} layers over {far.least:.6g}: {error}", parameter="first_height"
        ) from None
    fractions = np.vstack([fractions, fractions[:1]])
    points = paths(around, rays, bend, fractions * reach[:, None])
    points[:-1, -1] = far.in_order(far.onto(points[:-1, -1]))
    points[:, 0] = around.points
    points[-1] = points[0]  # the cut, to the last bit
    return points


def _best_rays(around: Section, far: PolarCurve, chord: float, height: float) -> tuple[np.ndarray, float]:
    """Rays and bending distance of the family with the soundest corners; if none is sound, the least folded."""
    best: tuple[float, np.ndarray, float] | None = None
    for width in _WIDTHS:
        for evenness in _EVENNESS:
            rays = ray_directions(around, width, evenness)
            uneven = len(around.turn) * float(((np.diff(rays) / (2 * np.pi)) ** 2).sum())
            for bend in _BENDS:
                reach = to_far_field(around, rays, bend * chord, far)[:, None]
                levels = np.geomspace(min(height, 0.1 * far.least) / far.least, 1, 24)
                soundness = scaled_jacobians(
                    paths(around, rays, bend * chord, np.concatenate([[0.0], levels]) * reach)[::-1]
                )
                worst = float(soundness.min())
                # A fold outweighs everything; among sound grids, the mean of 1 / J^2 dislikes thin corners.
                score = float((soundness**-2.0).mean()) + UNEVEN * uneven if worst > 0 else 1e9 * (1 - worst) + uneven
                if best is None or score < best[0]:
                    best = (score, rays, bend * chord)
    return best[1], best[2]
