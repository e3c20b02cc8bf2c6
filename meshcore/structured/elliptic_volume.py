"""Elliptic grids of blocks: edges as given, then faces, then the volume (survey 2.6)."""

from __future__ import annotations

import contextlib
from dataclasses import replace
from typing import Annotated, Literal, Union

import numpy as np

from ..errors import GenerationFailed, InvalidGeometry, InvalidInput
from ..mesh import Mesh, StructuredGrid
from ..operation import Param, Port, operation
from ..progress import Progress, part_of, silent
from ..quality import measure, summary
from ..report import Report, Result
from ..threads import checked_threads
from . import winslow_3d, winslow_surface
from .boundary_growth import LARGEST_GROWTH, blended, boundary_growth
from .cage import block_of_cage
from .limits import check_size

Control = Literal["none", "boundary spacing"]
_FACES = {"kept": 0.0, "smoothed": 0.2}  # and what part of the time they take


@operation("Elliptic Volume", category="Structured", output="grid")
def elliptic_volume(
    block: Annotated[
        Union[Mesh, StructuredGrid],
        Port("A block: closed cage of quads in rows and columns, or hexahedra", cells=("quad", "hexahedron")),
    ],
    *,
    control: Annotated[
        Control, Param("Whether the boundary's spacing is carried inside, or Laplace's equation evens it out")
    ] = "none",
    faces: Annotated[
        Literal["kept", "smoothed"],
        Param("Whether the points of the six faces stay, or are first smoothed on the surfaces through them"),
    ] = "kept",
    tolerance: Annotated[
        float | None,
        Param(
            "Residual to reach, as part of the start's; by default each point is within a thousandth of its spacing",
            min=0,
            max=1,
            advanced=True,
        ),
    ] = None,
    cycles: Annotated[int, Param("Multigrid cycles at most", min=1, soft_max=100, advanced=True)] = 50,
    growth: np.ndarray | None = None,
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
        k leave the point with the least number of the eight corners.
    control : {"none", "boundary spacing"}
        "boundary spacing" carries the spacing on the faces inside, as cells along walls need.
    faces : {"kept", "smoothed"}
        "smoothed" first makes elliptic grids on the bicubic surfaces through the faces' points; edges stay.
    tolerance : float, optional
        Residual to reach, as part of the start's. By default cycles go on until each point is within a thousandth of
        the local spacing of where it would end.
    cycles : int
        How many cycles to do at most; if they do not suffice, the report says so.
    growth : (3, ni, nj, nk) float, optional
        Control functions of your own, in place of `control`: logarithms of the growth from one cell to the next along
        i, j and k, between -2 and 2. In the survey's notation P = -2 tanh(growth[0] / 2), and likewise Q and R, with
        the indices as coordinates.
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
    part = _FACES[faces]
    points = grid.points
    if faces == "smoothed":
        points = _with_smooth_faces(points, control, cycles, part_of(progress, 0.0, part))
    if growth is not None:
        growth = _checked_growth(growth, control, grid.shape)
    elif control == "boundary spacing":
        growth = boundary_growth(blended(points, (0, 1, 2)))
    for start in (points, blended(points, (0, 1, 2))):  # from another start another solution may be found
        smooth, outcome = winslow_3d.solved(
            start,
            growth=growth,
            tolerance=tolerance,
            most=cycles,
            threads=threads,
            progress=part_of(progress, part, 1.0),
        )
        if not winslow_3d.count_folded(smooth):
            break
    result = grid.with_points(smooth)
    _refuse_folds(result)  # which is all that `validate` asks of a grid's hexahedra
    report = Report(
        counts={"points": result.n_points, "hexahedra": result.n_cells},
        quality=summary(result),
        iterations=outcome.cycles,
        residual=outcome.residuals[-1] / (outcome.residuals[0] or 1.0),
        converged=outcome.converged,
    )
    if not outcome.converged:
        report.warnings.append(
            f"stopped after {outcome.cycles} cycles, an estimated {outcome.error:.2g} spacings from the converged "
            "grid; allow more cycles or a larger tolerance"
        )
    return Result(result, report)


def _as_block(block: Mesh | StructuredGrid) -> StructuredGrid:
    """A right-handed grid in space; the inside of a cage is filled by transfinite interpolation."""
    if isinstance(block, Mesh):
        block = StructuredGrid(blended(block_of_cage(block), (0, 1, 2)))
    elif not isinstance(block, StructuredGrid):
        raise InvalidInput(f"needs a StructuredGrid or a Mesh, got {type(block).__name__}", parameter="block")
    if block.is_surface:
        raise InvalidInput(f"is a surface, {block!r}; give a grid of two or more layers of points", parameter="block")
    ni, nj, nk = block.shape
    check_size(ni * nj, nk, parameter="block")
    if not winslow_3d.is_left_handed(block.points):
        return block
    names = {"imin": "imax", "imax": "imin"}
    return replace(
        block,
        points=block.points[::-1],
        point_data={name: values[::-1] for name, values in block.point_data.items()},
        cell_data={name: values[::-1] for name, values in block.cell_data.items()},
        names={names.get(face, face): name for face, name in block.names.items()},
    )


def _checked_growth(growth: np.ndarray, control: Control, shape: tuple[int, int, int]) -> np.ndarray:
    if control != "none":
        raise InvalidInput(f"is given together with control = {control!r}; leave one of them out", parameter="growth")
    growth = np.ascontiguousarray(growth, float)
    if growth.shape != (3, *shape):
        raise InvalidInput(f"needs shape {(3, *shape)}, got {growth.shape}", parameter="growth")
    if not (np.abs(growth) <= LARGEST_GROWTH).all():  # false for NaN
        raise InvalidInput(
            f"must be between -{LARGEST_GROWTH:g} and {LARGEST_GROWTH:g}, got {growth.min():g} to {growth.max():g}",
            parameter="growth",
        )
    return growth


def _with_smooth_faces(points: np.ndarray, control: Control, cycles: int, progress: Progress) -> np.ndarray:
    """The block with each face a grid that is harmonic on the bicubic surface through its points, filled anew."""
    points = points.copy()
    for number in range(6):
        axis, end = divmod(number, 2)
        face = np.moveaxis(points, axis, 0)[-end]
        step = part_of(progress, number / 6, (number + 1) / 6)
        # A face may be a line or a point, as on the axis of a wedge.
        with contextlib.suppress(InvalidGeometry):
            face[...], _ = winslow_surface.smoothed(
                face, controlled=control == "boundary spacing", most=cycles, progress=step
            )
    return blended(points, (0, 1, 2))


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
