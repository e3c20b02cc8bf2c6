"""Elliptic grids of blocks: edges as given, then faces, then the volume (survey 2.6)."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from typing import Annotated, Literal, Union

import numpy as np

from ..errors import GenerationFailed, InvalidGeometry, InvalidInput
from ..mesh import Mesh, StructuredGrid
from ..operation import Param, Port, operation
from ..progress import Progress, advance, part_of, silent
from ..quality import measure, summary, validate
from ..report import Report, Result
from ..threads import checked_threads
from . import winslow_3d, winslow_surface
from .control_functions import ControlFunction, from_boundary, from_user
from .elliptic_parameters import MaxCyclesParam, ResidualParam
from .limits import check_size
from .quad_nets import cage_of
from .transfinite_volume import interpolated_volume

Control = Literal["none", "boundary spacing"]
_HALVINGS = 3  # of control functions that fold the grid
_FACES = {"kept": 0.01, "smoothed": 0.2}  # and what part of the time they take


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
    faces: Annotated[
        Literal["kept", "smoothed"],
        Param("Whether the points of the six faces stay, or are first smoothed on the surfaces through them"),
    ] = "kept",
    residual: ResidualParam = None,
    max_cycles: MaxCyclesParam = 60,
    control_functions: Sequence[ControlFunction] | None = None,
    threads: int | None = None,
    progress: Progress = silent,
) -> Result:
    """Fill a block with a smooth grid by the elliptic equations, or smooth the grid that it has.

    The coordinates i, j, k of the grid are harmonic functions in the block (with control, they solve Poisson's
    equation): corners and waves of the boundary fade away inside. The boundary's points are kept to the last bit.

    Parameters
    ----------
    block : StructuredGrid or Mesh
        A grid in space, whose inside is the start; or a closed cage of "quad" cells in rows and columns, as a cube that
        was subdivided and bent, or "hexahedron" cells of one block, of which only the surface matters. In these i, j,
        k run along x, y and z, as nearly as can be.
    control : {"none", "boundary spacing"}
        "boundary spacing" carries the spacing on the faces inside, as cells along walls need. Where that would fold
        cells it is weakened, and the report says so.
    faces : {"kept", "smoothed"}
        "smoothed" first makes elliptic grids on the bicubic surfaces through the faces' points; edges stay.
    residual : float, optional
        Residual to reach in units of the start's. Left out, cycles go on until each node is within about a thousandth
        of the local spacing from its converged place.
    max_cycles : int
        Multigrid cycles after which to give up; the report says so.
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
        `StructuredGrid` of (ni, nj, nk) points, right-handed, and the report.

    Raises
    ------
    InvalidInput, InvalidGeometry
        If the block is a surface, or is no block; the message says what is missing.
    GenerationFailed
        If cells are folded, as at corners of the boundary beyond 180 degrees; `cells` are these, `partial` the grid.

    References
    ----------
    Survey, section 2.6. J. F. Thompson, Z. U. A. Warsi, C. W. Mastin, "Numerical Grid Generation" (1985).

    Examples
    --------
    >>> box = np.stack(np.meshgrid(*[np.linspace(0, 1, 9)] * 3, indexing="ij"), axis=-1)
    >>> box[:, :, -1, 2] -= 0.3 * np.sin(np.pi * box[:, :, -1, 0]) * np.sin(np.pi * box[:, :, -1, 1])
    >>> grid, report = elliptic_volume(StructuredGrid(box))
    >>> grid, report.converged
    (StructuredGrid(9 x 9 x 9 points), True)
    """
    checked_threads(threads)
    grid = _as_block(block)
    advance(progress, 0.01, "smoothing")
    part = _FACES[faces]
    points = grid.points
    if faces == "smoothed":
        points = _with_smooth_faces(points, control, max_cycles, part_of(progress, 0.01, part))
    filled = _filled(points)
    growth = _growth(filled, control, control_functions)
    warnings = []
    # If cells are folded, another start may lead to another solution; and weaker control folds less.
    tries = [(points, 1.0), (filled, 1.0)] + [(filled, 0.5**k) for k in range(1, _HALVINGS + 1) if growth is not None]
    for number, (start, strength) in enumerate(tries):
        span = [1 - (1 - part) * 0.5**k for k in (number, number + 1)]
        smooth, outcome = winslow_3d.solved(
            start,
            growth=growth if growth is None else strength * growth,
            tolerance=residual,
            most=max_cycles,
            threads=threads,
            progress=part_of(progress, *span),
        )
        if not winslow_3d.count_folded(smooth):
            if strength < 1:
                warnings.append(f"control acts with {strength:g} of its strength: with more of it cells would fold")
            break
    result = grid.with_points(smooth)
    _refuse_folds(result)
    validate(result)
    if not outcome.converged:
        warnings.append(
            f"stopped after {outcome.cycles} cycles, an estimated {outcome.error:.2g} spacings from the converged "
            "grid; allow more cycles or a larger residual"
        )
    report = Report(
        counts={"points": result.n_points, "hexahedra": result.n_cells},
        quality=summary(result),
        iterations=outcome.cycles,
        residual=outcome.residuals[-1] / (outcome.residuals[0] or 1.0),
        converged=outcome.converged,
        warnings=warnings,
    )
    return Result(result, report)


def _as_block(block: Mesh | StructuredGrid) -> StructuredGrid:
    """A right-handed grid in space; the inside of a cage is filled by transfinite interpolation."""
    if isinstance(block, Mesh):
        surface = block.boundary if len(block.get("hexahedron")) else block
        block = StructuredGrid(interpolated_volume(cage_of(surface, "block"), blending="linear"))
    elif not isinstance(block, StructuredGrid):
        raise InvalidInput(f"needs a StructuredGrid or a Mesh, got {type(block).__name__}", parameter="block")
    if block.is_surface:
        raise InvalidInput(f"is a surface, {block!r}; give a grid of two or more layers of points", parameter="block")
    ni, nj, nk = block.shape
    check_size(ni * nj, nk, parameter="block")
    return block.reversed_along_i() if winslow_3d.is_left_handed(block.points) else block


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


def _with_smooth_faces(points: np.ndarray, control: Control, max_cycles: int, progress: Progress) -> np.ndarray:
    """The block with each face a grid that is harmonic on the bicubic surface through its points, filled anew."""
    points = points.copy()
    for number in range(6):
        axis, end = divmod(number, 2)
        face = np.moveaxis(points, axis, 0)[-end]
        step = part_of(progress, number / 6, (number + 1) / 6)
        # A face may be a line or a point, as on the axis of a wedge.
        with contextlib.suppress(InvalidGeometry):
            face[...], _ = winslow_surface.smoothed(
                face, controlled=control == "boundary spacing", most=max_cycles, progress=step
            )
    return _filled(points)


def _refuse_folds(grid: StructuredGrid) -> None:
    if not winslow_3d.count_folded(grid.points):
        return
    folded = np.flatnonzero((measure(grid, "jacobian") <= 0).ravel(order="F"))
    i, j, k = np.unravel_index(folded[0], grid.cell_shape, order="F")
    x, y, z = grid.points[i, j, k]
    raise GenerationFailed(
        f"{len(folded)} of {grid.n_cells} cells are folded or flat, the first at i = {i}, j = {j}, k = {k} "
        f"near ({x:.6g}, {y:.6g}, {z:.6g}); smooth the faces, move their points apart, take more cells, or cut the "
        "block where its boundary turns by 180 degrees or more",
        cells=folded,
        partial=grid,
    )
