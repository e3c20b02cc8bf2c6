"""Transfinite interpolation of a block between six faces or twelve edges (survey 2.4.1, 2.6)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from itertools import product
from typing import Annotated, Literal, Union

import numpy as np

from ...errors import GenerationFailed, InvalidGeometry, InvalidInput
from ...geometry.curves import Curve, chains, polyline
from ...mesh import Mesh, StructuredGrid
from ...operation import Length, Param, Port, Relative, absolute, operation
from ...progress import Progress, advance, part_of, silent
from ...quality import measure, summary, validate
from ...report import Report, Result
from ...sizing import Spacing
from ...threads import available_threads, checked_threads, in_parts
from ..limits import check_extent
from ..poisson.winslow_3d import count_folded
from . import _transfinite_kernels as kernels
from .blending import Blending, boolean_sum
from .block_corners import refuse_corners
from .block_directions import directions_of
from .block_edges import Asked, arranged, checked_spacings, refuse_unequal, spanned
from .block_faces import AXES, PLACES, BlockFaces, across
from .block_parameters import (
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
from .overspill_volume import Cure, cured
from .quad_nets import cage_of, patch_of
from .sides import fractions_of

Law = Literal[
    "as given", "uniform", "geometric", "hyperbolic tangent", "hyperbolic sine", "cosine", "curvature", "poisson"
]
Face = Union[Mesh, StructuredGrid, np.ndarray]
"""A face of a block: a surface grid, (n, m, 3) points, or a mesh of quads in rows and columns."""
_FACE = "quads in rows and columns"
_WHOLE = "imin"
_CURE = (
    "space the points of opposite edges alike, ask for a cure, or cut the block there, above all where its boundary "
    "turns by 180 degrees or more"
)
_FEWEST = 32
"""Layers of a block below which threads cost more than they save."""


@operation("Transfinite Volume", category="Structured", output="grid")
def transfinite_volume(
    imin: Annotated[
        Union[Face, Sequence[Curve]],
        Port(f"Face at the start of i: {_FACE}; or the whole: a closed surface of quads", cells=("quad", "line")),
    ],
    imax: Annotated[Union[Face, None], Port(f"Face at the end of i: {_FACE}", cells=("quad",))] = None,
    jmin: Annotated[Union[Face, None], Port(f"Face at the start of j: {_FACE}", cells=("quad",))] = None,
    jmax: Annotated[Union[Face, None], Port(f"Face at the end of j: {_FACE}", cells=("quad",))] = None,
    kmin: Annotated[Union[Face, None], Port(f"Face at the start of k: {_FACE}", cells=("quad",))] = None,
    kmax: Annotated[Union[Face, None], Port(f"Face at the end of k: {_FACE}", cells=("quad",))] = None,
    *,
    cells_i: BlockCellsIParam = None,
    cells_j: BlockCellsJParam = None,
    cells_k: BlockCellsKParam = None,
    spacing_imin: SpacingIMinParam = None,
    spacing_imax: SpacingIMaxParam = None,
    spacing_jmin: SpacingJMinParam = None,
    spacing_jmax: SpacingJMaxParam = None,
    spacing_kmin: SpacingKMinParam = None,
    spacing_kmax: SpacingKMaxParam = None,
    law: Annotated[Law, Param("How points stand along the edges", group="Spacing")] = "as given",
    blending: Annotated[
        Blending,
        Param("By the edges' lengths, by counts of cells, or smooth and at right angles with the faces"),
    ] = "arc length",
    cure: Annotated[Cure, Param("What may be done about folded cells (overspill)")] = "none",
    tolerance: Annotated[Length, Param("Largest gap between edges that is closed", min=0, advanced=True)] = (
        Relative(1e-6)
    ),
    spacings: Mapping[str, Spacing] | None = None,
    slopes: Mapping[str, np.ndarray] | None = None,
    surfaces: Mapping[tuple[str, int], np.ndarray] | None = None,
    threads: int | None = None,
    progress: Progress = silent,
) -> Result:
    """Fill a block with hexahedra by transfinite interpolation between its six faces or twelve edges.

    Faces whose points are not asked to move are kept exactly. Faces may be given in any direction, and are turned; a
    left-handed block has its i reversed. From edges, faces are made first, then the volume.

    ::

              k  jmax behind        The faces imin and imax have j and k,
              |  /                  jmin and jmax i and k, kmin and kmax i and j.
        imin  | j
              |/____ i  imax
            jmin in front

    Parameters
    ----------
    imin : StructuredGrid, Mesh, (n, m, 3) float, or sequence of (n, 3) float
        A face; or alone, for all six: a closed surface of quads, whose corners are where three quads meet; or twelve
        edges, as a mesh of line cells whose chains meet by threes, or as a sequence. Then i, j and k run along x,
        y and z, as nearly as can be.
    imax, jmin, jmax, kmin, kmax : StructuredGrid, Mesh or (n, m, 3) float, optional
        The other faces. If faces that are named opposite are not, all are put into other places.
    cells_i, cells_j, cells_k : int, optional
        Cells along i, j and k. Left out, parallel edges must have as many points as each other.
    spacing_imin, spacing_imax, spacing_jmin, spacing_jmax, spacing_kmin, spacing_kmax : Length, optional
        Size of the cells that touch that face, measured along the four edges that end there.
    law : str
        Law of the points' spacing along all edges, see `Spacing`. "as given" keeps their own, or is a hyperbolic
        tangent where a size at an end is asked for.
    blending : {"arc length", "linear", "cubic"}
        Blending functions, as in `transfinite`.
    cure : {"none", "sides", "smoothing", "automatic"}
        What may be done where cells fold: move the points along the edges, to stand alike on those side by side, and
        with them those of the faces on these, which may also be smoothed; smooth the inside by the Laplace equations;
        or all in turn. Faces stay as they are if smoothing alone may be done. Not where slopes or surfaces inside are
        given, which would be lost. The report tells what was done.
    tolerance : Length
        Edges of faces, and ends of edges, that are no farther apart than this are joined.
    spacings : dict of str to Spacing, optional
        By axis ("i", "j" or "k"), the spacing of its four edges, from the face given as min to that given as max, in
        place of ``law`` and sizes of cells. From Python only.
    slopes : dict of str to (n, m, 3) float, optional
        For "cubic" blending: by the name of a face of the result, for each of its points the step to the next layer
        in the direction of the index. Blocks that share a face and its slopes join smoothly. From Python only.
    surfaces : dict of (str, int) to (n, m, 3) float, optional
        Coordinate surfaces inside, by their axis ("i", "j" or "k") and their index in the result. They must agree
        with the faces, and with each other, where they meet. From Python only.
    threads : int, optional
        By default as many as there are processors. The grid does not depend on it.
    progress : Progress, optional
        Called with fraction and message.

    Returns
    -------
    Result
        `StructuredGrid` of (ni, nj, nk) points whose faces are named as they were given, and the report.

    Raises
    ------
    InvalidInput
        If parallel edges differ in their number of points, or a spacing cannot be had.
    InvalidGeometry
        If faces do not meet, or are no grids; the message names the gap.
    GenerationFailed
        If cells are folded (overspill); `cells` are the folded ones, `partial` the grid.

    References
    ----------
    Survey, sections 2.4.1 and 2.6. W. J. Gordon and C. A. Hall, "Construction of curvilinear co-ordinate systems and
    applications to mesh generation", Int. J. Numer. Meth. Engng. 7 (1973). B. K. Soni, "Two- and three-dimensional
    grid generation for internal flow applications of computational fluid dynamics", AIAA 85-1526 (1985).

    Examples
    --------
    >>> from meshcore import gallery
    >>> grid, report = transfinite_volume(gallery.twisted_cage(6, 5, 4))
    >>> grid
    StructuredGrid(7 x 6 x 5 points)
    """
    given = dict(zip(PLACES, (imin, imax, jmin, jmax, kmin, kmax), strict=True))
    heights = (spacing_imin, spacing_imax, spacing_jmin, spacing_jmax, spacing_kmin, spacing_kmax)
    threads = checked_threads(threads)
    _refuse_without_cubic(slopes, blending)
    cells = cells_i, cells_j, cells_k
    read, diagonal = _read(given)
    asked = Asked(cells, law, dict(zip(PLACES, heights, strict=True)), diagonal, checked_spacings(spacings))
    block = _block(read, asked, blending, absolute(tolerance, diagonal))
    advance(progress, 0.2, "interpolating")
    points = _points(block, blending, slopes, surfaces, threads)
    done = []
    if cure != "none" and count_folded(points) and not (slopes or surfaces):
        redo = partial(_points, blending=blending, slopes=None, surfaces=None, threads=threads)
        points, done = cured(block, points, cure, redo, threads=threads, progress=part_of(progress, 0.3, 0.9))
    advance(progress, 0.9, "checking the grid")
    grid = StructuredGrid(points, names=block.names)
    _refuse_folds(grid, done)
    validate(grid)
    counts = {"points": grid.n_points, "hexahedra": grid.n_cells}
    return Result(grid, Report(counts=counts, quality=summary(grid), warnings=block.warnings + done))


def interpolated_volume(
    faces: Mapping[str, np.ndarray], *, blending: str = "arc length", threads: int | None = None
) -> np.ndarray:
    """The Boolean sum of linear projections between six faces that meet exactly.

    Parameters
    ----------
    faces : dict of str to (n, m, 3) float
        By name; "imin" and "imax" have indices (j, k), "jmin" and "jmax" (i, k), "kmin" and "kmax" (i, j).
    blending : {"arc length", "linear"}
        Whether the blending functions come from the lengths of the twelve edges, or from numbers of cells.
    threads : int, optional
        By default as many as there are processors. The points do not depend on it.

    Returns
    -------
    (ni, nj, nk, 3) float
        Points whose outermost layers are the faces, to the last bit.

    Raises
    ------
    InvalidGeometry
        If the lengths of edges are too different to be blended.

    Examples
    --------
    >>> cube = np.stack(np.meshgrid([0.0, 1, 2], [0.0, 1, 2], [0.0, 1, 2], indexing="ij"), axis=-1)
    >>> faces = {"imin": cube[0], "imax": cube[-1], "jmin": cube[:, 0], "jmax": cube[:, -1]}
    >>> faces |= {"kmin": cube[:, :, 0], "kmax": cube[:, :, -1]}
    >>> print(np.abs(interpolated_volume(faces) - cube).max())
    0.0
    """
    given = [np.ascontiguousarray(faces[place], float) for place in PLACES]
    (n_i, n_j), n_k = given[4].shape[:2], given[0].shape[1]
    points = np.empty((n_i, n_j, n_k, 3))
    converged = []
    if blending == "linear":
        flat = points.reshape(n_i, n_j, 3 * n_k)
        rows = [face.reshape(len(face), -1) for face in given[:4]]
        u, v, w = (np.arange(n) / (n - 1) for n in (n_i, n_j, n_k))

        def fill(start: int, stop: int) -> None:
            kernels.fill_by_number(flat, *rows, *given[4:], u, v, w, np.empty((2, 3 * n_k)), start, stop)

    else:
        block = BlockFaces(dict(zip(PLACES, given, strict=True)), {}, 0.0)
        lengths = [
            np.array([fractions_of(block.edge(axis, a, b)) for b, a in product((0, 1), repeat=2)]) for axis in range(3)
        ]

        rows = tuple(np.ascontiguousarray(face.swapaxes(1, 2)) for face in given[:4])
        across_k = tuple(given[4:])

        def fill(start: int, stop: int) -> None:
            work = np.empty((6, 3, n_k))
            converged.append(kernels.fill_by_length(points, across_k, rows, *lengths, work, start, stop))

    count = checked_threads(threads) or available_threads()
    if count == 1 or n_i < _FEWEST:
        fill(0, n_i)
    else:
        with ThreadPoolExecutor(count) as pool:
            in_parts(pool, count, fill, 0, n_i)
    if not all(converged):
        raise InvalidGeometry('has edges too unevenly spaced to be blended by length; choose blending="linear"')
    for place, face in zip(PLACES, given, strict=True):  # to the last bit
        np.moveaxis(points, AXES.index(place[0]), 0)[-1 if place.endswith("max") else 0] = face
    return points


def _refuse_folds(grid: StructuredGrid, done: list[str]) -> None:
    if not count_folded(grid.points):
        return
    refuse_corners(grid)
    folded = np.flatnonzero((measure(grid, "jacobian") <= 0).ravel(order="F"))
    i, j, k = np.unravel_index(folded[0], grid.cell_shape, order="F")
    x, y, z = grid.points[i, j, k]
    tried = "".join(f"{what}, " for what in done) + "which did not suffice; " if done else ""
    raise GenerationFailed(
        f"{len(folded)} of {grid.n_cells} cells are folded or flat, the first at i = {i}, j = {j}, k = {k} "
        f"near ({x:.6g}, {y:.6g}, {z:.6g}); {tried}{_CURE}",
        cells=folded,
        partial=grid,
    )


def _refuse_without_cubic(slopes: Mapping[str, np.ndarray] | None, blending: str) -> None:
    if slopes is not None and blending != "cubic":
        raise InvalidInput('are matched by blending="cubic" only', parameter="slopes")


def _read(given: Mapping[str, Face | None]) -> tuple[dict[str, np.ndarray] | list[np.ndarray], float]:
    """Faces by name, or a list of edges; and the diagonal of the bounding box."""
    missing = [name for name, face in given.items() if face is None]
    whole = given[_WHOLE]
    if missing and len(missing) < 5:
        raise InvalidInput("is missing; give all six faces, or the whole as imin", parameter=missing[0])
    if not missing:
        read = {name: _face(face, name) for name, face in given.items()}
        for name, face in read.items():
            check_extent(face.reshape(-1, 3), parameter=name)
        return read, _diagonal(read.values())
    if isinstance(whole, Mesh) and len(whole.get("quad")):
        read = cage_of(whole, _WHOLE)
        return read, _diagonal(read.values())
    if isinstance(whole, Mesh) and len(whole.get("line")):
        edges = [whole.points[chain] for chain in chains(whole)]
    elif isinstance(whole, Sequence) and not isinstance(whole, str):
        edges = [polyline(curve, _WHOLE) for curve in whole]
    else:
        raise InvalidInput(
            "is alone, but neither a closed surface of quads nor twelve edges; give the other faces, too",
            parameter=_WHOLE,
        )
    if not edges:
        raise InvalidGeometry("needs twelve edges, got none", parameter=_WHOLE)
    for edge in edges:
        check_extent(edge, parameter=_WHOLE)
    return edges, _diagonal(edges)


def _face(face: Face, name: str) -> np.ndarray:
    if isinstance(face, Mesh):
        return patch_of(face, name)
    try:
        grid = face if isinstance(face, StructuredGrid) else StructuredGrid(face)
    except InvalidInput as error:
        raise type(error)(str(error).partition(": ")[2], parameter=name) from None
    flat = [axis for axis in range(3) if grid.shape[axis] == 1]
    if len(flat) != 1:
        raise InvalidInput(f"needs a surface of one layer of points, got {grid.shape}", parameter=name)
    return grid.points.squeeze(axis=flat[0])


def _diagonal(parts) -> float:
    return check_extent(np.concatenate([part.reshape(-1, 3) for part in parts]), parameter=_WHOLE)


def _block(read: dict[str, np.ndarray] | list[np.ndarray], asked: Asked, blending: str, gap: float) -> BlockFaces:
    """The six faces, in their places, with the points that are asked for, joined."""
    if isinstance(read, list):
        edges = arranged(read, gap, _WHOLE)
        asked.check_size(edges)
        refuse_unequal(edges, asked.cells, _WHOLE)
        names = {place: place for place in PLACES}
        return spanned(edges, asked.fractions(edges, names), blending, gap).right_handed()
    block = BlockFaces.arranged(read, gap).right_handed()
    block.refuse_unequal(asked.cells)
    asked.check_size(block.edges)
    _refuse_repeats(block)
    fractions = asked.fractions(block.edges, block.names)
    return (block if fractions is None else block.resampled(fractions)).joined()


def _refuse_repeats(block: BlockFaces) -> None:
    for place, face in block.faces.items():
        for axis in range(2):
            rows = np.moveaxis(face, axis, 0)
            same = np.argwhere((rows[1:] == rows[:-1]).all(axis=-1))
            if len(same):
                k, m = same[0]
                x, y, z = rows[k, m]
                raise InvalidGeometry(
                    f"points {k} and {k + 1} along {AXES[across(place)[axis]]} coincide "
                    f"at ({x:.6g}, {y:.6g}, {z:.6g}); a face needs different points",
                    parameter=block.names[place],
                )


def _points(block: BlockFaces, blending: str, slopes, surfaces, threads: int | None) -> np.ndarray:
    """The points inside, by linear projections at once, or one after another where more is known than the faces."""
    if blending != "cubic" and not surfaces:
        return interpolated_volume(block.faces, blending=blending, threads=threads)
    points = boolean_sum(directions_of(block, blending, slopes, surfaces or {}))
    for (axis, index), surface in (surfaces or {}).items():
        away = float(np.abs(np.moveaxis(points, AXES.index(axis), 0)[index] - surface).max())
        if away > block.gap:
            raise InvalidGeometry(
                f"{axis} = {index} does not agree with the faces or another surface: {away:.6g} apart where they meet",
                parameter="surfaces",
            )
    return points
