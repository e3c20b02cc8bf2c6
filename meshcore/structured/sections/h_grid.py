"""H-grids: two blocks, above and below a section, a slab or a slit, nearly Cartesian (survey 2.8.1, figure 13)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import Annotated

import numpy as np

from ...geometry.curves import Curve
from ...mesh import Cut, MultiBlock, StructuredGrid
from ...operation import Port, Relative, operation
from ...progress import Progress, advance, part_of, silent
from ...quality import summary, validate
from ...report import Report, Result
from ...sizing import Spacing
from ..folds import refuse_folds
from ..layer_report import layers_told, worst_skew
from . import section_parameters as parameters
from .first_heights import with_first_heights
from .h_lines import evenly_growing, interpolated
from .h_march import lines_of, past_base
from .h_regions import Region, box_regions, given_regions
from .h_sides import sides_of
from .section_march import Lines
from .section_points import Points
from .section_result import scaled_jacobians
from .section_smoothing import smoothed, wall_of

_CURE = "make the section smoother or thinner, give more points around it, or take c_grid or o_grid"
_WORSE = 0.2
"""Share of the march's worst scaled Jacobian that elliptic grids must have."""
_NAMES = {"imin": "inflow", "imax": "outflow", "jmin": "wall", "jmax": "far field"}


@operation("H Grid", category="Structured", output="blocks")
def h_grid(
    section: parameters.SectionOrSlitPort,
    outer: Annotated[Curve | None, Port("A closed far field of four sides round the section", cells=("line",))] = None,
    *,
    radius: parameters.RadiusParam = 10.0,
    method: parameters.MethodParam = "transfinite",
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
    wake_growth: parameters.WakeGrowthParam = 1.2,
    flow: parameters.FlowParam = 0.0,
    spacings: Mapping[str, Spacing] | None = None,
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
        A closed loop, or an open line: a slit from its first point to its last. In an upright plane z is up.
    outer : Mesh or (m, 3) float, optional
        A far field of your own in place of the box: a closed curve round the section, such as a channel. Inflow, top,
        outflow and bottom meet at its four corners, the points farthest towards those of its bounding box.
    radius : float
        Distance of the box from mid-chord, in chords: ahead, above and below.
    method : {"transfinite", "elliptic", "hyperbolic", "parabolic"}
        Lines by interpolation between front (section and cuts) and far field; lines that the elliptic equations smooth,
        with right angles and first heights held at section and cuts; marched off section and cuts at right angles, and
        from a quarter of the way on drawn onto the far field; or marched onto it. Where straight lines cross, lines of
        the parabolic march take their place.
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
    law_i : str
        Law of the points' spacing along each side from the trailing edge to the nose, see `Spacing`, whose end cells
        are `trailing_spacing` and `leading_spacing`. "as given" keeps the section's own points, or resamples it as told
        above; "copied" gives the lower side the spacing of the upper one. Corners are kept: the nearest points move
        onto them.
    wake : float, optional
        Length of the box behind the section, in chords.
    wake_growth : float
        Cells grow by no more than this factor along the wake, and ahead of the nose.
    flow : float
        Degrees from the chord, counter-clockwise, to the direction of the box.
    spacings : dict of str to Spacing, optional
        Laws of single sides, "upper" and "lower", from the trailing edge to the nose. From Python only.
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
        If the section crosses itself, is not in a plane, or without extent; if the far field has not four sides round
        it.
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
    sides = sides_of(
        section,
        flow,
        lambda diagonal: Points.asked(diagonal, around, leading_spacing, trailing_spacing, law_i, spacings),
    )
    chord = float(np.linalg.norm(sides.upper.points[-1] - sides.upper.points[0]))
    both = np.vstack([sides.lower.points, sides.upper.points])
    if outer is None:
        reach = radius * chord
        regions = box_regions(sides, reach, (wake or radius) * chord, wake_growth)
    else:
        regions = given_regions(sides, outer, wake_growth)
        reach = min(float(region.top[:, 1].min() - region.front[:, 1].max()) for region in regions)
    height = parameters.wall_height(first_height, y_plus, reynolds, both, chord, sides.diagonal, reach)
    warnings, blocks = list(sides.warnings), []
    changed: Counter[str] = Counter()
    for region, name, step in zip(regions, ("below", "above"), ((0.0, 0.5), (0.5, 1.0)), strict=True):
        advance(progress, step[0], "choosing lines")
        lines = _lines(region, method, height, layers, growth, part_of(progress, *step))
        changed.update(lines.counts)
        warnings += [f"{name} the section: {text}" for text in lines.warnings]
        local = lines.points @ region.axes
        spatial = sides.plane.to_space(local.reshape(-1, 2)).reshape(*local.shape[:2], 3)
        blocks.append(StructuredGrid(spatial, names=_NAMES))
    grid = _joined(blocks, regions)
    for block in grid.blocks:
        refuse_folds(block, _CURE)
        validate(block)
    walls = [block.points[region.nose : region.tail + 1, :, 0] for block, region in zip(blocks, regions, strict=True)]
    counts = {"points": grid.n_points, "quads": grid.n_cells, "layers": blocks[0].cell_shape[1]}
    counts |= {"ahead": regions[0].nose, "wake": len(regions[0].front) - 1 - regions[0].tail, **changed}
    told = {} if y_plus is None else {"y+": y_plus}
    reached = [{**layers_told(wall, height), **worst_skew(block)} for wall, block in zip(walls, blocks, strict=True)]
    quality = {**summary(grid.to_mesh()), **told, **{name: _both(name, *reached) for name in reached[0]}}
    return Result(grid, Report(counts=counts, quality=quality, warnings=warnings))


def _both(name: str, below: dict[str, float], above: dict[str, float]) -> float:
    """A figure of two blocks: the worse of theirs, but the mean of total heights."""
    if name == "total height":
        return 0.5 * (below[name] + above[name])
    return (min if name.startswith("least") else max)(below[name], above[name])


def _lines(region: Region, method: str, height: float, layers: int | None, growth: float, progress: Progress) -> Lines:
    """The lines of one block, in its region."""
    points = interpolated(region, height, layers, growth)
    kept = past_base(region, points)
    lines = lines_of(method, region, points, height, kept, part_of(progress, 0.0, 0.4))
    told: list[str] = []
    whole = np.concatenate([lines.points, np.zeros((*lines.points.shape[:2], 1))], axis=2)
    outside = StructuredGrid(whole[:, kept:], names=_NAMES)
    if lines.method == "elliptic":
        kept_angles = np.ones(len(whole)) if kept else _at_corners(region)
        outside, told = _smoothed(outside, kept_angles, part_of(progress, 0.4, 1.0))
    made = np.concatenate([lines.points[:, :kept], outside.points[:, :, 0, :2]], axis=1)
    fanned = kept > 0 and method != "transfinite"
    made = _begun_at(evenly_growing(region, made, height, fanned), height)
    beyond = "beyond the layers that round the edge: " if kept else ""
    return lines._replace(points=made, warnings=[*lines.warnings, *(beyond + text for text in told)])


def _begun_at(points: np.ndarray, height: float) -> np.ndarray:
    """Lines that begin at the height asked for, where cells stay sound; inflow and outflow stay."""
    heights = np.full(len(points), height)
    heights[[0, -1]] = np.linalg.norm(points[[0, -1], 1] - points[[0, -1], 0], axis=1)
    spatial = np.concatenate([points, np.zeros((*points.shape[:2], 1))], axis=2)
    return with_first_heights(spatial, heights)[..., :2]


def _smoothed(grid: StructuredGrid, kept: np.ndarray, progress: Progress) -> tuple[StructuredGrid, list[str]]:
    """The elliptic equations' grid, its front held or else free, unless cells get much worse; what is to be told."""
    least = _WORSE * scaled_jacobians(grid.points[:, :, 0, :2]).min()
    found, _, told = smoothed(grid, wall_of(grid, kept), _CURE, progress)
    if scaled_jacobians(found.points[:, :, 0, :2]).min() > least:
        return found, told
    found, _, told = smoothed(grid, None, _CURE, progress)
    if scaled_jacobians(found.points[:, :, 0, :2]).min() > least:
        return found, ["held angles and heights made cells much worse; they were left free", *told]
    return grid, ["the elliptic equations made cells much worse; the parabolic march stays"]


def _at_corners(region: Region) -> np.ndarray:
    """(n,) float: where lines keep their angles, 1 at the corners of the front and the next points."""
    corners = np.unique([region.nose, region.first, region.last, region.tail])
    return (np.abs(np.arange(len(region.front))[:, None] - corners) < 2).any(axis=1).astype(float)


def _joined(blocks: list[StructuredGrid], regions: tuple[Region, Region]) -> MultiBlock:
    """Both blocks, the lower one turned upright, made to meet to the last bit, with their cuts."""
    upper = blocks[1]
    points = blocks[0].points[:, ::-1].copy()
    (n, m, _, _), k = points.shape, upper.shape[0]
    ahead, wake = regions[0].nose, n - 1 - regions[0].tail
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
    names = {**_NAMES, "jmin": _NAMES["jmax"], "jmax": _NAMES["jmin"]}
    lower = StructuredGrid(points, names=names)
    return MultiBlock((lower, upper), ("lower", "upper"), (before, behind))
