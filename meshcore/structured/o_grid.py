"""Grids of one block wrapped around a section: the O-grid (survey 2.8.1)."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from ..errors import InvalidInput
from ..geometry.curves import Curve
from ..mesh import StructuredGrid
from ..operation import Length, Param, Port, Relative, absolute, operation
from ..progress import Progress, advance, silent
from ..quality import summary, validate
from ..report import Report, Result
from ..sizing import cells_for_growth, geometric
from ..sizing.around_loop import respaced_loop
from .folds import refuse_folds
from .limits import check_size
from .rays import Section, at_height, paths, ray_directions, to_circle
from .section_input import section_loop
from .section_result import scaled_jacobians

_CURE = "make the section smoother or less re-entrant, move the far field, or give more points around it"
_WIDTHS = (0.03, 0.06, 0.12)
_EVENNESS = (1.0, 0.7, 0.4, 0.2, 0.05)
_BENDS = (0.4, 0.15)
UNEVEN = 0.1
"""Weight of an uneven far field beside skewed cells, when rays are chosen."""


@operation("O Grid", category="Structured", output="grid")
def o_grid(
    section: Annotated[Curve, Port("One closed loop in a plane, such as an airfoil", cells=("line",))],
    *,
    radius: Annotated[float, Param("Radius of the far field, in chords", min=1, soft_max=100)] = 10.0,
    first_height: Annotated[Length, Param("Height of the cells at the section", group="Spacing")] = Relative(0.001),
    growth: Annotated[
        float, Param("Growth of cell heights that sets the number of layers", min=1.001, max=3, group="Spacing")
    ] = 1.15,
    layers: Annotated[
        int | None, Param("Cells from the section out; by default as many as growth needs", min=1, soft_max=500)
    ] = None,
    around: Annotated[
        int | None, Param("Cells around the section; by default its own points", min=3, soft_max=1000)
    ] = None,
    cut: Annotated[
        int, Param("Point of the section where the grid is cut; -1 finds the sharpest", min=-1, advanced=True)
    ] = -1,
    progress: Progress = silent,
) -> Result:
    """Wrap an O-grid of quadrilaterals around a closed section, out to a circle.

    Grid lines leave the section at right angles and end evenly on the circle. The points of the section are kept
    exactly, unless `around` asks for others.

    ::

             .---------.         i runs around the section, clockwise, from the cut and back to it (periodic)
           /   .-----.   \\       j runs out: jmin is the "wall", jmax the "far field"
          |   ( wing  >---|  <- cut, along the trailing edge's bisector
           \\   '-----'   /
             '---------'

    Parameters
    ----------
    section : Mesh or (n, 3) float
        The closed loop, in a plane of any attitude; if it is open it is refused.
    radius : float
        Radius of the far field's circle about mid-chord, in chords. The chord is the section's greatest extent.
    first_height : Length
        Distance of the first points from the section.
    growth : float
        Heights grow from cell to cell by no more than this factor, if `layers` is left out.
    layers : int, optional
        Cells along j. The growth then follows.
    around : int, optional
        Cells along i: the section is resampled on a cubic spline, densely where it bends, with its corners kept.
    cut : int
        Number of the point where i begins; -1 takes the sharpest turn, an airfoil's trailing edge.
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
    The grid is the projection P_t of transfinite interpolation between wall and circle, with the derivative matched
    at the wall, so that lines are normal to it. Where rays meet the circle is a blend of arc length and of the
    section's positive turning; of a small family of blends that with the best corners and an even circle is taken.

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
    given = section_loop(section)
    loop, diagonal, warnings = given.begun_at(cut), given.diagonal, given.warnings
    if around is not None:
        check_size(around + 1, (layers or 1) + 1, parameter="around")
        loop = respaced_loop(loop, around)
    height = absolute(first_height, diagonal)
    points, ratio = _wrapped(loop, radius, height, growth, layers, progress)
    flat = points[::-1]  # clockwise, so that i, j are right-handed
    grid = StructuredGrid(
        given.to_space(flat), names={"jmin": "wall", "jmax": "far field"}, periodic=(True, False, False)
    )
    advance(progress, 0.9, "checking the grid")
    refuse_folds(grid, _CURE)
    validate(grid)
    counts = {
        "points": grid.n_points,
        "quads": grid.n_cells,
        "around": grid.cell_shape[0],
        "layers": grid.cell_shape[1],
    }
    return Result(grid, Report(counts=counts, quality={**summary(grid), "largest growth": ratio}, warnings=warnings))


def _chord(loop: np.ndarray) -> tuple[float, np.ndarray]:
    """Length and middle of a section's chord: from the point farthest from its cut to the point farthest from that."""
    far = loop[np.argmax(np.linalg.norm(loop - loop[0], axis=1))]
    other = loop[np.argmax(np.linalg.norm(loop - far, axis=1))]
    return float(np.linalg.norm(other - far)), 0.5 * (far + other)


def _wrapped(loop, chords, height, growth, layers, progress) -> tuple[np.ndarray, float]:
    """(n + 1, layers + 1, 2) points, counter-clockwise from the wall to the circle, and the largest growth."""
    around = Section.of(loop)
    chord, centre = _chord(loop)
    radius = chords * chord
    if height >= 0.5 * radius:
        raise InvalidInput(
            f"is {height:.6g}, but the far field has a radius of only {radius:.6g}; make it smaller",
            parameter="first_height",
        )
    advance(progress, 0.1, "choosing rays")
    if height <= np.finfo(float).eps * (radius + np.abs(loop).max()):
        raise InvalidInput(
            f"is {height:.6g}, which is lost in rounding beside a far field of radius {radius:.6g}; "
            "make it larger, the radius smaller, or move the section to the origin",
            parameter="first_height",
        )
    rays, bend = _best_rays(around, centre, radius, chord, height)
    advance(progress, 0.5, "interpolating")
    reach = to_circle(around, rays, bend, centre, radius)
    first = at_height(around, rays, bend, height) / reach
    if layers is None:
        layers = cells_for_growth(float(first.min()), growth)
    check_size(len(loop) + 1, layers + 1, parameter="layers")
    try:
        fractions = np.array([geometric(layers, first=f) for f in first[:-1]])
    except InvalidInput as error:
        raise InvalidInput(
            f"{height:.6g} does not fit {layers} layers over {radius:.6g}: {error}", parameter="first_height"
        ) from None
    fractions = np.vstack([fractions, fractions[:1]])
    points = paths(around, rays, bend, fractions * reach[:, None])
    away = points[:, -1] - centre
    points[:, -1] = centre + radius * away / np.linalg.norm(away, axis=1)[:, None]
    points[:, 0] = around.points
    points[-1] = points[0]  # the cut, to the last bit
    steps = np.diff(fractions, axis=1)
    ratio = float((steps[:, 1:] / steps[:, :-1]).max()) if layers > 1 else 1.0
    return points, ratio


def _best_rays(
    around: Section, centre: np.ndarray, radius: float, chord: float, height: float
) -> tuple[np.ndarray, float]:
    """Rays and bending distance of the family with the soundest corners; if none is sound, the least folded."""
    best: tuple[float, np.ndarray, float] | None = None
    for width in _WIDTHS:
        for evenness in _EVENNESS:
            rays = ray_directions(around, width, evenness)
            uneven = len(around.turn) * float(((np.diff(rays) / (2 * np.pi)) ** 2).sum())
            for bend in _BENDS:
                reach = to_circle(around, rays, bend * chord, centre, radius)[:, None]
                levels = np.geomspace(min(height, 0.1 * radius) / radius, 1, 24)
                soundness = scaled_jacobians(
                    paths(around, rays, bend * chord, np.concatenate([[0.0], levels]) * reach)[::-1]
                )
                worst = float(soundness.min())
                # A fold outweighs everything; among sound grids, the mean of 1 / J^2 dislikes thin corners.
                score = float((soundness**-2.0).mean()) + UNEVEN * uneven if worst > 0 else 1e9 * (1 - worst) + uneven
                if best is None or score < best[0]:
                    best = (score, rays, bend * chord)
    return best[1], best[2]
