"""Conforming local refinement of triangle meshes (h-refinement, survey 4.1)."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np

from .. import quality
from ..errors import GenerationFailed, InvalidGeometry, InvalidInput
from ..mesh import Mesh
from ..operation import Param, Port, operation
from ..progress import Progress, advance, part_of, silent
from ..report import Report, Result
from .bisection import scaled_sides
from .cutting import Step, check_size, labelled, refined_once, triangles_in
from .estimate import checked_indicator, marked, refuse, triangles_of, variation

_KINDS = ("triangle", "line", "vertex")


@operation("Adaptive Refinement", category="Adaptive")
def refined(
    mesh: Annotated[Mesh, Port("Triangles, planar or in space; lines on their edges are cut too", cells=("triangle",))],
    marks: np.ndarray | None = None,
    *,
    indicator: Annotated[
        str,
        Param(
            "Cell array that says how much each triangle needs it, or point array whose variation does; "
            "empty refines everywhere",
            array=True,
        ),
    ] = "",
    fraction: Annotated[float, Param("Share of the indicator's sum that the cut triangles hold", min=0, max=1)] = 0.5,
    levels: Annotated[int, Param("How often the sizes of cut triangles are halved", min=1, soft_max=6)] = 1,
    progress: Progress = silent,
) -> Result:
    """Refine triangles where it is needed, without hanging nodes, with angles bounded over any number of calls.

    Newest-vertex bisection. At each level, a triangle that is marked is cut in four of half its size, its
    neighbours in two, three or four as conformity needs:

    ::

            0                 0
           / \\               /|\\
          /   \\      ->     3 | 5
         /     \\           / \\|/ \\
        1-------2         1---4---2

    Points of the input come first, unchanged; new points are middles of edges. Triangles far from marked ones stay.
    Each new triangle lies in one old triangle, has its cell data and is in its sets. Point data are interpolated
    linearly; whole numbers and flags are taken for tags: the smaller one of both ends. Line cells on edges are cut
    with them and keep their tags.

    On a mesh that was not refined before, the longest edge of each triangle is cut first. Then all triangles that can
    ever arise fall into four similarity classes per input triangle, and no angle gets below half of its smallest one.
    The state between calls is in the mesh: the first node of each triangle is its newest vertex, and the cell array
    "bisections" counts the cuts; keep both, and the bound holds over any number of calls.

    Parameters
    ----------
    mesh : Mesh
        "triangle" cells, also "line" and "vertex" ones.
    marks : (number of cells,) bool or (k,) int, optional
        Triangles to cut, as flags over all cells or as their numbers. Further levels cut their parts.
    indicator : str
        Name of a cell array: values not negative, largest where the error is. Or of a point array: its `variation`
        over each triangle. With several levels, a point array is interpolated; the parts of a triangle share its
        cell value by area.
    fraction : float
        The fewest triangles are cut that hold this share of the indicator's sum (Doerfler's marking). With a cell
        array of an error eta_T of which the squares add up, give it squared.
    levels : int
        Number of steps. Without marks and indicator each makes four triangles of one.
    progress : Progress, optional
        Called with fraction and message.

    Returns
    -------
    Result
        The `Mesh`, and the report.

    Raises
    ------
    InvalidInput
        If there are no triangles or cells of other kinds, marks or indicator do not fit the mesh, or the result would
        be too large.
    InvalidGeometry
        If a triangle has no area, is too small to be cut in floating-point numbers, or if the mesh has hanging nodes.

    References
    ----------
    Survey, section 4.1 and [38]. W. F. Mitchell, "A comparison of adaptive refinement techniques for elliptic
    problems", ACM Trans. Math. Softw. 15 (1989). P. Binev, W. Dahmen, R. DeVore, "Adaptive finite element methods
    with convergence rates", Numer. Math. 97 (2004). I. G. Rosenberg, F. Stenger, "A lower bound on the angles of
    triangles constructed by bisecting the longest side", Math. Comp. 29 (1975): the bound. M. Karkulik, D. Pavlicek,
    D. Praetorius, "On 2D newest vertex bisection", Constr. Approx. 38 (2013): any labels will do.

    Examples
    --------
    >>> from meshcore import gallery
    >>> square = gallery.triangulated_square(4)
    >>> refined(square).mesh
    Mesh(81 points, 128 triangle)
    >>> mesh, report = refined(square, indicator="front", levels=3)
    >>> len(mesh.cells["triangle"]) < 1000, round(report.quality["smallest angle (degree)"])
    (True, 45)
    """
    if not isinstance(mesh, Mesh):
        raise InvalidInput(f"needs a Mesh of triangles, got {type(mesh).__name__}", parameter="mesh")
    _check_kinds(mesh)
    sides = scaled_sides(mesh.points, triangles_of(mesh))
    refuse(mesh, np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1) <= 4 * np.finfo(float).eps)
    chosen = _Chosen(mesh, marks, indicator, fraction, levels)
    result, warnings, cut = labelled(mesh), [], 0
    for level in range(levels):
        advance(progress, 0.9 * level / levels, f"refining, level {level + 1} of {levels}")
        now = chosen.now(result)
        if not now.any():
            warnings.append(f"nothing to refine at level {level + 1}: {chosen.why_none}")
            break
        cut += int(now.sum())
        step = refined_once(result, now)
        chosen.inherit(result, step)
        result = step.mesh
    advance(part_of(progress, 0.9, 1.0), 0.0, "checking the mesh")
    warnings += _validated(result, mesh)
    counts = {"points": result.n_points, "triangles": len(result.cells["triangle"]), "marked": cut}
    return Result(result, Report(counts=counts, quality=quality.summary(_of_usual_size(result)), warnings=warnings))


class _Chosen:
    """Which triangles to cut, level after level: flags, shares of an indicator, or the variation of a point array."""

    def __init__(self, mesh: Mesh, marks: Any, indicator: str, fraction: float, levels: int):
        self.name, self.fraction = indicator, fraction
        self.flags: np.ndarray | None = None
        self.shares: np.ndarray | None = None
        self.why_none = "no triangle is marked"
        if marks is not None and indicator:
            raise InvalidInput(f"give marks or indicator={indicator!r}, not both", parameter="marks")
        if indicator:
            self.why_none = f"the sum of {indicator!r}, or the fraction, is zero"
            self.shares = _shares(mesh, indicator)
        else:
            self.flags = _flags(mesh, marks)
            # Marked triangles make four each, level after level: known before any work.
            check_size(int(self.flags.sum()) * 4 ** min(levels, 30))

    def now(self, mesh: Mesh) -> np.ndarray:
        """(number of triangles,) bool: triangles to cut at this level."""
        if self.flags is not None:
            return self.flags
        return marked(variation(mesh, self.name) if self.shares is None else self.shares, self.fraction)

    def inherit(self, before: Mesh, step: Step) -> None:
        """Go from the triangles of ``before`` to their parts."""
        parts = triangles_in(step.mesh)
        parents = step.parents[parts] - triangles_in(before).start
        if self.flags is not None:
            self.flags = self.flags[parents]
        if self.shares is not None:
            self.shares = self.shares[parents] * 0.5 ** step.cuts[parts]  # a half of the area each time


def _flags(mesh: Mesh, marks: Any) -> np.ndarray:
    """(number of triangles,) bool: the marked triangles; all without marks."""
    where = triangles_in(mesh)
    if marks is None:
        return np.ones(where.stop - where.start, bool)
    marks = np.asarray(marks)
    if marks.size == 0:
        return np.zeros(where.stop - where.start, bool)
    if marks.ndim != 1 or marks.dtype.kind not in "biu":
        raise InvalidInput(
            f"needs flags of all cells or numbers of cells, got {marks.dtype} of shape {marks.shape}", parameter="marks"
        )
    flags = np.zeros(mesh.n_cells, bool)
    if marks.dtype.kind == "b":
        if len(marks) != mesh.n_cells:
            raise InvalidInput(f"needs one flag per cell, that is {mesh.n_cells}, got {len(marks)}", parameter="marks")
        flags[:] = marks
    else:
        bad = marks[(marks < 0) | (marks >= mesh.n_cells)]
        if len(bad):
            raise InvalidInput(f"there is no cell {bad[0]}; cells go from 0 to {mesh.n_cells - 1}", parameter="marks")
        flags[marks] = True
    chosen = flags[where].copy()
    flags[where] = False
    if flags.any():
        cell = int(flags.argmax())
        kind = next(kind for kind, _, w in mesh.blocks() if w.start <= cell < w.stop)
        raise InvalidInput(f"cell {cell} is a {kind}; only triangles can be marked", parameter="marks")
    return chosen


def _shares(mesh: Mesh, indicator: str) -> np.ndarray | None:
    """(number of triangles,) float: the cell array; None if the name is that of a point array."""
    if indicator in mesh.cell_data:
        return checked_indicator(mesh.cell_data[indicator][triangles_in(mesh)])
    if indicator not in mesh.point_data:
        on_cells, at_points = (", ".join(data) or "none" for data in (mesh.cell_data, mesh.point_data))
        raise InvalidInput(
            f"there is no array {indicator!r}; on cells there are {on_cells}; at points {at_points}",
            parameter="indicator",
        )
    return None


def _check_kinds(mesh: Mesh) -> None:
    """Refuse cells that would not fit their refined neighbours."""
    other = [kind for kind, cells in mesh.cells.items() if len(cells) and kind not in _KINDS]
    if other:
        raise InvalidInput(
            f"has {len(mesh.cells[other[0]])} {other[0]} cells; only triangles are refined: "
            "convert them to triangles, or leave them out",
            parameter="mesh",
        )


def _validated(result: Mesh, mesh: Mesh) -> list[str]:
    """Warnings of faults that the input had already; an error for new ones, and for those that they grew from."""
    usual = _of_usual_size(mesh)
    outline = usual.boundary if usual.boundary.n_cells else None  # a closed surface has none
    faults = quality.validate(_of_usual_size(result), boundary=outline, raise_=False)
    if not faults:
        return []
    given = quality.validate(usual, raise_=False)
    new = [fault for fault in faults if fault.name not in {old.name for old in given}]
    if new and given:
        cause = given[0]
        raise InvalidGeometry(
            f"{cause}; repair it first, since in the refined mesh {new[0]}",
            parameter="mesh",
            points=cause.points,
            cells=cause.cells,
        )
    if new:
        cells = np.unique(np.concatenate([np.empty(0, int), *(f.cells for f in new if f.name != "boundary")]))
        raise GenerationFailed("; ".join(map(str, new)), cells=cells, partial=result)
    return [f"the mesh is as faulty as it was given: {fault}" for fault in faults]


def _of_usual_size(mesh: Mesh) -> Mesh:
    """The mesh, times a power of two if it is so large or small that products of lengths would leave the doubles."""
    exponent = int(np.frexp(np.abs(mesh.points).max(initial=0.0))[1])
    return mesh.with_points(np.ldexp(mesh.points, -exponent)) if abs(exponent) > 150 else mesh
