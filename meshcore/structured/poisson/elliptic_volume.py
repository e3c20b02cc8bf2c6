"""Elliptic grids of blocks: edges, then faces, then the volume (survey 2.6)."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Annotated, Literal, Union

import numpy as np

from ...errors import GenerationFailed, InvalidGeometry, InvalidInput
from ...mesh import Mesh, StructuredGrid
from ...operation import Param, Port, operation
from ...progress import Progress, advance, part_of, silent
from ...quality import measure, summary, validate
from ...report import Report, Result
from ...sizing import Spacing
from ...threads import checked_threads
from ..algebraic.block_corners import refuse_corners
from ..algebraic.block_edges import Asked
from ..algebraic.block_faces import AXES, PLACES, end
from ..algebraic.block_parameters import (
    BlockCellsIParam,
    BlockCellsJParam,
    BlockCellsKParam,
    SpacingIMaxParam,
    SpacingIMinParam,
    SpacingJMaxParam,
    SpacingJMinParam,
    SpacingKMaxParam,
    SpacingKMinParam,
)
from ..algebraic.quad_nets import cage_of
from ..algebraic.transfinite_volume import interpolated_volume
from ..limits import check_extent, check_size
from . import winslow_3d, winslow_surface
from .block_problem import AskedOfBlock
from .block_regridding import asked_of_edges, regridded
from .block_unfolding import sound
from .control_functions import ControlFunction, from_boundary, from_user
from .elliptic_parameters import (
    FaceWallsParam,
    FirstHeightParam,
    LeanAtEdgesParam,
    MaxCyclesParam,
    ResidualParam,
    SlidingParam,
    WallAngleParam,
    asked_faces,
)
from .elliptic_problem import Found
from .periodic_faces import Pair, asked_axes, pairs_of
from .wall_control import Wall
from .wall_faces import mismatch, respaced

Control = Literal["none", "boundary spacing"]
Law = Literal["kept", "uniform", "geometric", "hyperbolic tangent", "hyperbolic sine", "cosine", "curvature", "poisson"]
_MISMATCH = 1.5  # between first heights at walls and on the faces around them, from which it is told
_FACES = {"kept": 0.01, "smoothed": 0.2, "respaced": 0.02}  # and what part of the time they take


@operation("Elliptic Volume", category="Structured", output="grid")
def elliptic_volume(
    block: Annotated[
        Union[Mesh, StructuredGrid],
        Port("A block: closed cage of quads in rows and columns, or hexahedra", cells=("quad", "hexahedron")),
    ],
    *,
    control: Annotated[
        Control, Param("Whether the boundary's spacing is carried inside, or lines spread evenly (Laplace)")
    ] = "boundary spacing",
    cells_i: BlockCellsIParam = None,
    cells_j: BlockCellsJParam = None,
    cells_k: BlockCellsKParam = None,
    edges: Annotated[
        Law, Param("Points of the twelve edges: kept, or gridded anew by a law, as by the 1D Poisson equation")
    ] = "kept",
    spacing_imin: SpacingIMinParam = None,
    spacing_imax: SpacingIMaxParam = None,
    spacing_jmin: SpacingJMinParam = None,
    spacing_jmax: SpacingJMaxParam = None,
    spacing_kmin: SpacingKMinParam = None,
    spacing_kmax: SpacingKMaxParam = None,
    faces: Annotated[
        Literal["kept", "smoothed", "respaced"],
        Param("Points of the six faces: kept, smoothed on their surfaces, or respaced to begin with the first heights"),
    ] = "kept",
    walls: FaceWallsParam = "none",
    first_height: FirstHeightParam = None,
    wall_angle: WallAngleParam = 90.0,
    lean_at_edges: LeanAtEdgesParam = False,
    sliding: SlidingParam = False,
    periodic: Annotated[
        Literal["none", "i", "j", "k", "i and j", "i and k", "j and k"],
        Param("Directions in which the last face is the first, moved or turned, and the grid runs on through both"),
    ] = "none",
    residual: ResidualParam = None,
    max_cycles: MaxCyclesParam = 60,
    each_wall: Sequence[Wall] = (),
    spacings: Mapping[str, Spacing] | None = None,
    control_functions: Sequence[ControlFunction] | None = None,
    threads: int | None = None,
    progress: Progress = silent,
) -> Result:
    """Fill a block with a smooth grid by the elliptic equations, or smooth the grid that it has.

    The coordinates i, j, k of the grid are harmonic functions in the block (with control, they solve Poisson's
    equation): corners and waves of the boundary fade away inside. The boundary's points are kept to the last bit,
    unless edges and faces are asked to be gridded anew, in the order edges, faces, volume.

    Parameters
    ----------
    block : StructuredGrid or Mesh
        A grid in space, whose inside is the start; or a closed cage of "quad" cells in rows and columns, as a cube that
        was subdivided and bent, or "hexahedron" cells of one block, of which only the surface matters. In these i, j,
        k run along x, y and z, as nearly as can be.
    control : {"none", "boundary spacing"}
        "boundary spacing" carries the spacing on the faces inside, as cells along walls need. Where that would fold
        cells it is weakened, and the report says so.
    cells_i, cells_j, cells_k : int, optional
        Cells along i, j and k, if they are to be others than are given: edges, and then faces, get new points.
    edges : {"kept", "uniform", "geometric", "hyperbolic tangent", "hyperbolic sine", "cosine", "curvature", "poisson"}
        Law of `Spacing` by which all edges are gridded anew; "poisson" is the one-dimensional Poisson equation. Points
        move along the cubic splines through an edge's points, those of faces on the bicubic surfaces through theirs.
    spacing_imin, spacing_imax, spacing_jmin, spacing_jmax, spacing_kmin, spacing_kmax : Length, optional
        Size of the cells that touch that face, measured along the four edges that end there, for laws that take it.
    faces : {"kept", "smoothed", "respaced"}
        "smoothed" first makes elliptic grids on the bicubic surfaces through the faces' points; edges stay. "respaced"
        moves points on the faces around walls, and on edges, along their lines, so that these begin with the first
        height that the wall asks.
    walls : {"none", "imin", ..., "kmax", "imin and imax", ..., "i and j", "i and k", "j and k", "all"}
        Faces at which control functions are found, while the grid is solved, so that lines leave the wall at an angle
        and the first cells have a height (Steger and Sorenson); "i and j" are the four faces across i and j. On the
        faces around a wall cells should begin with about that height, too: see ``faces``.
    first_height : Length, optional
        Length of the first edge at walls.
    wall_angle : float
        Degrees between the wall and the lines that leave it; other than 90, they lean in its first direction: that in
        which i grows, or j on faces across i.
    lean_at_edges : bool
        Whether lines near the edges of a wall lean as those on the faces beside it do, of which a fifth is left after a
        quarter of the wall's width; otherwise they are to turn within three cells, which they cannot where faces meet
        at acute angles.
    sliding : bool
        Whether the points of walls slide on the bicubic surfaces through them to make the angle (Neumann's condition),
        between their edges.
    periodic : {"none", "i", "j", "k", "i and j", "i and k", "j and k"}
        Directions in which the last face is the first, moved or turned about some axis, as between the blades of a row:
        the grid runs on through both, whose points are free and stay alike; those on their edges stay. Points that are
        not alike, but on blades, stay too, if they are not most. Where both faces coincide, as in O-type blocks, that
        is so by itself.
    residual : float, optional
        Residual to reach in units of the start's. Left out, cycles go on until each node is within about a thousandth
        of the local spacing from its converged place. Control at walls stops by angle and height instead.
    max_cycles : int
        Multigrid cycles after which to give up; the report says so.
    each_wall : sequence of Wall
        Walls one by one, each with heights and angles of its own, in place of ``walls``.
    spacings : dict of str to Spacing, optional
        By axis ("i", "j" or "k"), the spacing of its four edges, in place of ``edges``. From Python only.
    control_functions : P, Q and R, optional
        More control functions: each a number, an (ni, nj, nk) array, or a function of arrays of the indices i, j, k,
        between -2 and 2. They act as in ``g^11 (r_ii + P r_i)``, with the indices as coordinates.
    threads : int, optional
        How many threads share the work; all available cores if not given. The grid does not depend on it.
    progress : Progress, optional
        Called with fraction and message.

    Returns
    -------
    Result
        `StructuredGrid` of (ni, nj, nk) points, right-handed, and the report. A left-handed block is reversed along i,
        as `warnings` tell; faces are those of the result.

    Raises
    ------
    InvalidInput, InvalidGeometry
        If the block is a surface, or is no block; the message says what is missing.
    GenerationFailed
        If the boundary turns by 180 degrees or more at an edge, which is named, or cells stay folded for other reasons,
        such as a boundary that crosses itself; `cells` are these, `partial` the grid.

    Notes
    -----
    Nonlinear multigrid with zebra lines in three directions: work grows like the number of points. Cells that the
    discrete equations leave folded, as beside bulbs of few cells, are unfolded by minimising the distortion of cells
    with a barrier on the patch around them; the report tells how many.

    Angles and heights at walls are not judged at three nodes and two first heights beside the edges of a face, nor at
    two first heights beside its creases: lines must turn there to those of the next face, which stay as they are.

    References
    ----------
    Survey, section 2.6. J. F. Thompson, Z. U. A. Warsi, C. W. Mastin, "Numerical Grid Generation" (1985).
    J. L. Steger, R. L. Sorenson, J. Comput. Phys. 33 (1979). V. A. Garanzha, Comput. Math. Math. Phys. 40 (2000).

    Examples
    --------
    >>> box = np.stack(np.meshgrid(*[np.linspace(0, 1, 9)] * 3, indexing="ij"), axis=-1)
    >>> box[:, :, -1, 2] -= 0.3 * np.sin(np.pi * box[:, :, -1, 0]) * np.sin(np.pi * box[:, :, -1, 1])
    >>> grid, report = elliptic_volume(StructuredGrid(box))
    >>> grid, report.converged
    (StructuredGrid(9 x 9 x 9 points), True)
    """
    start, warnings = _as_block(block)
    heights = (spacing_imin, spacing_imax, spacing_jmin, spacing_jmax, spacing_kmin, spacing_kmax)
    ends = dict(zip(PLACES, heights, strict=True))
    start = _regridded(start, asked_of_edges(edges, (cells_i, cells_j, cells_k), ends, spacings, start.diagonal))
    if each_wall and walls != "none":
        raise InvalidInput("is given beside walls; give only one of them", parameter="each_wall")
    pairs = pairs_of(start.points, asked_axes(periodic), start.periodic)
    start = _closed(start, pairs)
    warnings += [pair.told for pair in pairs if pair.kept is not None]
    asked = AskedOfBlock(
        walls=asked_faces(
            walls,
            first_height,
            wall_angle,
            sliding,
            lean_at_edges,
            diagonal=start.diagonal,
            cuts=[end(pair.axis, side) for pair in pairs if pair.kept is None for side in (0, 1)],
        )
        or each_wall,
        pairs=pairs,
        residual=residual,
        most_cycles=max_cycles,
        threads=checked_threads(threads),
    )
    asked.check(start.points)
    advance(progress, 0.01, "smoothing")
    part = _FACES[faces]
    points, wanting = _with_faces(start.points, faces, control, asked, part_of(progress, 0.01, part))
    filled = _filled(points)
    growth = _growth(filled, control, control_functions)
    cuts = [end(pair.axis, side) for pair in pairs for side in (0, 1)]
    refuse_corners(start.with_points(filled), free=[*cuts, *(wall.side for wall in asked.walls if wall.slides)])
    found = sound(points, filled, growth, asked, part_of(progress, part, 1.0))
    warnings += wanting + _mismatched(found, asked) + found.warnings
    result = start.with_points(found.points)
    _refuse_folds(result)
    validate(result)
    report = Report(
        counts={"points": result.n_points, "hexahedra": result.n_cells},
        quality={**summary(result), **found.quality},
        iterations=len(found.history) - 1,
        residual=found.history[-1],
        converged=found.converged and not wanting,
        warnings=warnings,
        history=list(found.history),
    )
    return Result(result, report)


def _with_faces(
    points: np.ndarray, faces: str, control: Control, asked: AskedOfBlock, progress: Progress
) -> tuple[np.ndarray, list[str]]:
    """The block with its faces as they are asked for, and which of them have not converged."""
    if faces == "smoothed":
        return _with_smooth_faces(points, control, asked.pairs, asked.most_cycles, progress)
    return (_filled(respaced(points, asked.walls)) if faces == "respaced" else points), []


def _mismatched(found: Found, asked: AskedOfBlock) -> list[str]:
    """What users are told of heights on faces that differ too much from those of the walls beside."""
    if found.converged or (factor := mismatch(found.points, asked.walls)) <= _MISMATCH:
        return []
    return [
        f"on the faces around walls, first cells are up to {factor:.2g} times as high or low as asked: inside they "
        'cannot differ so much from one to the next; choose faces "respaced", or space the edges so'
    ]


def _as_block(block: Mesh | StructuredGrid) -> tuple[StructuredGrid, list[str]]:
    """A right-handed grid in space, and whether it was turned; a cage is filled by transfinite interpolation."""
    if isinstance(block, Mesh):
        surface = block.boundary if len(block.get("hexahedron")) else block
        block = StructuredGrid(interpolated_volume(cage_of(surface, "block"), blending="linear"))
    elif not isinstance(block, StructuredGrid):
        raise InvalidInput(f"needs a StructuredGrid or a Mesh, got {type(block).__name__}", parameter="block")
    if block.is_surface:
        raise InvalidInput(f"is a surface, {block!r}; give a grid of two or more layers of points", parameter="block")
    ni, nj, nk = block.shape
    check_extent(block.points.reshape(-1, 3), parameter="block")
    check_size(ni * nj, nk, parameter="block")
    if not winslow_3d.is_left_handed(block.points):
        return block, []
    return block.reversed_along_i(), ["the block was left-handed; its i is reversed: imin and imax have changed places"]


def _regridded(grid: StructuredGrid, asked: Asked | None) -> StructuredGrid:
    """The block with new points on its edges, its faces, and inside."""
    if asked is None:
        return grid
    counts = [(n or m) + 1 for n, m in zip(asked.cells, grid.cell_shape, strict=True)]
    check_size(*counts, parameter=f"cells_{AXES[int(np.argmax(counts))]}")
    points = regridded(grid.points, asked)
    if points.shape[:3] == grid.shape:
        return grid.with_points(points)
    return StructuredGrid(points, names=grid.names, periodic=grid.periodic)


def _filled(points: np.ndarray) -> np.ndarray:
    """The block with its inside interpolated between its faces."""
    faces = {f"{'ijk'[axis]}{end}": points.take(k, axis) for axis in range(3) for k, end in ((0, "min"), (-1, "max"))}
    return interpolated_volume(faces, blending="linear")


def _growth(points: np.ndarray, control: Control, functions: Sequence[ControlFunction] | None) -> np.ndarray | None:
    """Logarithms of growth of all control functions together, or None for Laplace's equation."""
    parts = []
    if control == "boundary spacing":
        parts.append(from_boundary(points))
    if functions is not None:
        parts.append(from_user(functions, points.shape[:3]))
    return sum(parts) if parts else None


def _closed(grid: StructuredGrid, pairs: Sequence[Pair]) -> StructuredGrid:
    """The grid, periodic where both faces of a pair coincide: not every file can say so."""
    points, periodic = grid.points.copy(), list(grid.periodic)
    for pair in pairs:
        if pair.motion.is_none and pair.kept is None:
            periodic[pair.axis] = True
            np.moveaxis(points, pair.axis, 0)[-1] = np.moveaxis(points, pair.axis, 0)[0]
    return replace(grid, points=points, periodic=tuple(periodic))


def _with_smooth_faces(
    points: np.ndarray, control: Control, pairs: Sequence[Pair], max_cycles: int, progress: Progress
) -> tuple[np.ndarray, list[str]]:
    """The block with each face a grid that is harmonic on the bicubic surface through its points, filled anew.

    With it, which faces have not converged.
    """
    points, warnings = points.copy(), []
    for number in range(6):
        axis, side = divmod(number, 2)
        if axis in [pair.axis for pair in pairs]:  # its points are free
            continue
        face = np.moveaxis(points, axis, 0)[-side]
        step = part_of(progress, number / 6, (number + 1) / 6)
        # A face may be a line or a point, as on the axis of a wedge.
        with contextlib.suppress(InvalidGeometry):
            face[...], outcome = winslow_surface.smoothed(
                face, controlled=control == "boundary spacing", most=max_cycles, progress=step
            )
            if not outcome.converged:
                warnings.append(
                    f"the face {end(axis, side)} has not converged after {outcome.cycles - 1} cycles: a node may be "
                    f"{outcome.error:.2g} of the local spacing from its place"
                )
    return _filled(points), warnings


def _refuse_folds(grid: StructuredGrid) -> None:
    if not winslow_3d.count_folded(grid.points):
        return
    folded = np.flatnonzero((measure(grid, "jacobian") <= 0).ravel(order="F"))
    i, j, k = np.unravel_index(folded[0], grid.cell_shape, order="F")
    x, y, z = grid.points[i, j, k]
    raise GenerationFailed(
        f"{len(folded)} of {grid.n_cells} cells are folded or flat, the first at i = {i}, j = {j}, k = {k} "
        f"near ({x:.6g}, {y:.6g}, {z:.6g}); look whether faces cross each other or are folded themselves there, "
        "smooth them, or take more cells",
        cells=folded,
        partial=grid,
    )
