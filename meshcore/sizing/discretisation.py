"""Discretised curves: nodes at whole values of the integral of 1 / size (survey, 3.2.3)."""

from __future__ import annotations

import itertools
from typing import Annotated, Literal

import numpy as np

from ..errors import InvalidGeometry, InvalidInput
from ..geometry.curves import Curve, is_closed, lines_through
from ..geometry.parametric import ParametricCurve
from ..mesh import Mesh
from ..operation import Length, Param, Port, absolute, operation
from ..progress import Progress, advance, silent
from ..report import Report, Result
from .background import background_field, checked_sizes, only_array
from .gradation import checked_gradation, limited
from .metric import evaluated_metrics
from .metric import lengths as lengths_in_metric
from .size_field import SizeField, answered, evaluated
from .stretches import Stretch, stretches_of

MAX_LINES = 20_000_000
_MAX_SAMPLES = 1_000_000
# Sampling is refined until the number of cells that it tells changes by no more than this share.
_TOLERANCE = 1e-5
_DEFAULT_SHARE = 0.05
# Lengths of curves with larger coordinates could leave the doubles.
_FARTHEST = 1e300


@operation("Discretised Curve", category="Unstructured")
def discretised(
    curve: Annotated[
        Mesh, Port("Line cells: chains, loops, and nets of them, in the plane or in space", cells=("line",))
    ],
    background: Annotated[
        Mesh | None,
        Port("Triangles whose point array is the size wanted, over the curve", cells=("triangle", "quad")),
    ] = None,
    *,
    size: Annotated[
        Length | None, Param("Largest length of a line; 5% of the curve's extent if nothing is given")
    ] = None,
    size_array: Annotated[
        str, Param("Point array of sizes, of the background or else of the curve; empty for none", array=True)
    ] = "",
    gradation: Annotated[
        float | None, Param("Largest growth of the size per unit length, such as 0.2; no limit by default", min=0)
    ] = None,
    corner_angle: Annotated[
        float, Param("Points where the curve turns by more are corners, which stay", min=0, max=180, unit="degree")
    ] = 30.0,
    shape: Annotated[
        Literal["polyline", "spline"],
        Param("What runs between corners: the lines given, or a spline through their ends"),
    ] = "polyline",
    size_field: SizeField | None = None,
    progress: Progress = silent,
) -> Result:
    """Divide a curve into lines as long as a size field asks, keeping its corners.

    Between corners, a stretch of length l with sizes delta takes so many lines, and its nodes are where the scaled
    integral is whole::

        A_s = integral of 1 / delta from 0 to l        N_s = nint(A_s), at least 1

        N_s / A_s * (integral of 1 / delta from 0 to l_i) = i

    Corners are the points where the curve turns sharply, where it ends or branches, where "vertex" cells are, and where
    whole-number cell data (tags) or sets change; they are kept bit by bit. A closed curve gets three lines at least.

    Parameters
    ----------
    curve : Mesh
        "line" cells. From Python also a `meshcore.geometry.parametric.ParametricCurve` (a spline, an arc, any
        function), whose nodes lie on the curve itself; or (n, 3) points in order, closed if the last is the first.
    background : Mesh, optional
        Triangles or quads in a plane, or tetrahedra, with the sizes at their points.
    size : Length, optional
        No size is larger. Lengths of lines come near their sizes, from above and below, as N_s is rounded.
    size_array : str
        Point array of sizes: of the background; without one of the curve, and linear along it.
    gradation : float, optional
        Sizes grow no faster per unit length of the curve, and of the background's edges.
    corner_angle : float
        Degrees.
    shape : {"polyline", "spline"}
        Between corners new nodes lie on the lines given, or on a cubic spline through their ends.
    size_field : callable, optional
        Takes (m, 3) points, returns (m,) sizes, or (m, 3, 3) metrics (`meshcore.sizing.metric`), in which the length of
        each line comes to 1.
    progress : Progress, optional
        Called with fraction and message.

    Returns
    -------
    Result
        A `Mesh` of lines: corners first, then new points along each stretch. Lines keep the cell data and the sets of
        those that they lie on; decimal point data are interpolated.

    Raises
    ------
    InvalidInput
        If sizes are missing or not finite and greater than zero, or ask for more than 20 million lines.
    InvalidGeometry
        If the curve has no lines of any length.

    References
    ----------
    Survey, section 3.2.3. J. Peraire, M. Vahdati, K. Morgan, O. C. Zienkiewicz, "Adaptive remeshing for compressible
    flow computations", J. Comput. Phys. 72 (1987).

    Examples
    --------
    >>> from meshcore.gallery import square
    >>> mesh, report = discretised(square(), size_field=lambda points: 0.1 + 0.2 * points[:, 0])
    >>> mesh.n_cells  # 5.5, 3.3, 5.5 and 10 lines, rounded
    23
    """
    if callable(size_field) and gradation is not None:
        gradation = checked_gradation(gradation)
    mesh, stretches = _read(curve, corner_angle, shape)
    seen = np.concatenate([s.curve.points(s.samples(2 if mesh else 64)) for s in stretches])
    if np.abs(seen).max() > _FARTHEST:
        raise InvalidGeometry(
            f"has coordinates up to {np.abs(seen).max():g}; scale them to below {_FARTHEST:g}", parameter="curve"
        )
    extent = np.ptp(seen, axis=0)
    diagonal = float(extent.max() * np.linalg.norm(extent / extent.max()))
    if size is None and size_field is None and background is None and not size_array:
        size = _DEFAULT_SHARE * diagonal
    largest = np.inf if size is None else absolute(size, diagonal)
    wanted = _Wanted(mesh, background, size_array, size_field, gradation, largest)
    samples = _sampled(stretches, wanted, progress)
    counts = _counts(stretches, [total[-1] for _, total, _ in samples])
    advance(progress, 0.9, "placing nodes")
    nodes = [_nodes(*sample, count) for sample, count in zip(samples, counts, strict=True)]
    result = _assembled(mesh, stretches, nodes)
    sides = result.points[result.cells["line"]]
    length = _norms(sides[:, 1] - sides[:, 0])
    corners = len({int(c) for s in stretches for c in s.corners if c >= 0})
    report = Report(
        counts={"points": result.n_points, "lines": result.n_cells, "corners": corners},
        quality={"shortest line": float(length.min()), "longest line": float(length.max())},
    )
    return Result(result, report)


def _read(curve: Curve | ParametricCurve, corner_angle: float, shape: str) -> tuple[Mesh | None, list[Stretch]]:
    """The mesh of the curve, none for a parametric one, and its stretches between corners."""
    if isinstance(curve, ParametricCurve):
        knots = np.array([curve.start, curve.stop]) if curve.knots is None else np.asarray(curve.knots, float)
        ends = (0, 0) if curve.is_closed else (0, 1)
        return None, [Stretch(curve, knots, ends)]
    if not isinstance(curve, Mesh):
        points = Mesh(curve, {}).points
        closed = is_closed(points)
        curve = lines_through(points[:-1] if closed else points, closed=closed)
    stretches = stretches_of(curve, corner_angle, shape == "spline")
    if not stretches:
        raise InvalidGeometry("has no lines of any length; give a curve of line cells", parameter="curve")
    return curve, stretches


class _Wanted:
    """The sizes that the arguments ask for, at samples of the stretches."""

    def __init__(
        self,
        mesh: Mesh | None,
        background: Mesh | None,
        size_array: str,
        size_field: SizeField | None,
        gradation: float | None,
        largest: float,
    ):
        self.gradation = None if gradation is None else checked_gradation(gradation)
        self.largest, self.size_field = largest, size_field
        self.own: np.ndarray | None = None
        self.background: SizeField | None = None
        if background is not None:
            sizes = checked_sizes(background, size_array or only_array(background), "background")
            sizes = sizes if self.gradation is None else limited(background, sizes, self.gradation)
            self.background = background_field(background, sizes)
        elif size_array:
            if mesh is None:
                raise InvalidInput("a parametric curve has no arrays; give a size field", parameter="size_array")
            self.own = checked_sizes(mesh, size_array, "size_array")

    def sizes(
        self, stretches: list[Stretch], at: list[np.ndarray], points: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray | None]:
        """(m,) sizes at the samples of all stretches, one after the other, and (m, 3, 3) metrics or None."""
        sizes = np.full(len(points), self.largest)
        metrics = None
        if self.own is not None:
            along = [np.interp(t, s.knots, self.own[s.nodes]) for s, t in zip(stretches, at, strict=True)]
            sizes = np.minimum(sizes, np.concatenate(along))
        if self.background is not None:
            sizes = np.minimum(sizes, self.background(points))
        if self.size_field is not None:
            asked = answered(self.size_field, points)
            if asked.ndim == 3:
                metrics = evaluated_metrics(asked, points)
            else:
                sizes = np.minimum(sizes, evaluated(lambda _: asked, points))
        if self.gradation is not None:
            if metrics is not None:
                raise InvalidInput(
                    "limits sizes, but the size field returns metrics; leave it out", parameter="gradation"
                )
            sizes = _limited(stretches, at, points, sizes, self.gradation)
        return sizes, metrics


def _limited(
    stretches: list[Stretch], at: list[np.ndarray], points: np.ndarray, sizes: np.ndarray, gradation: float
) -> np.ndarray:
    """Sizes at samples, with their gradation limited along all stretches and through their common ends."""
    stops = np.cumsum([len(t) for t in at])
    starts = stops - [len(t) for t in at]
    vertex = np.arange(len(points))
    for s, start, stop in zip(stretches, starts, stops, strict=True):
        vertex[[start, stop - 1]] = len(points) + np.array(s.corners)
    _, first, number = np.unique(vertex, return_index=True, return_inverse=True)
    inner = np.setdiff1d(np.arange(1, len(points)), starts)
    lines = number[np.column_stack([inner - 1, inner])]
    least = np.full(len(first), np.inf)
    np.minimum.at(least, number, sizes)
    finite = np.where(np.isfinite(least), least, np.finfo(float).max)
    return limited(Mesh(points[first], {"line": lines}), finite, gradation)[number]


def _sampled(
    stretches: list[Stretch], wanted: _Wanted, progress: Progress
) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """For each stretch (k,) parameters, the (k,) integrals of 1 / size up to them, and the (k,) 1 / size there.

    The trapezoidal rule, on samples that are halved until the integrals stand.
    """
    fewest = max(2, 400_000 // sum(len(s.knots) for s in stretches))
    parts = [min(fewest, max(8, -(-128 // (len(s.knots) - 1)))) for s in stretches]
    before = None
    for round_ in itertools.count():
        advance(progress, 0.1 + 0.8 * min(round_ / 16, 1), "measuring the curve")
        at = [s.samples(k << round_) for s, k in zip(stretches, parts, strict=True)]
        points = np.concatenate([s.curve.points(t) for s, t in zip(stretches, at, strict=True)])
        sizes, metrics = wanted.sizes(stretches, at, points)
        found = _integrals(at, points, sizes, metrics)
        totals = np.array([total[-1] for _, total, _ in found])
        if not totals.sum() < MAX_LINES:
            least = points[sizes.argmin()]
            raise InvalidInput(
                f"would make about {totals.sum():.2g} lines; at most {MAX_LINES:,} are allowed, so make it larger; the "
                f"smallest size is {sizes.min():.3g}, at ({', '.join(f'{x:.6g}' for x in least)})",
                parameter="size",
            )
        steady = before is not None and np.abs(totals - before).max() <= _TOLERANCE * max(totals.max(), 1.0)
        dense = all(len(t) > 4 * total for t, total in zip(at, totals, strict=True))
        many = 2 * len(points) > _MAX_SAMPLES
        if (steady and (dense or many)) or (many and 2 * len(points) > min(8 * totals.sum(), 16 * _MAX_SAMPLES)):
            return found
        before = totals


def _integrals(at, points, sizes, metrics):
    """Parameters, integrals and integrand of each stretch."""
    found, start = [], 0
    for t in at:
        here = slice(start, start + len(t))
        start += len(t)
        length = _norms(np.diff(points[here], axis=0))
        least = float(sizes[here].min())
        unit = least if least < np.inf else 1.0  # 1 / size of less than 1e-308 would overflow
        rate = unit / sizes[here]
        with np.errstate(over="ignore"):  # that many lines are refused
            part = 0.5 * (rate[1:] + rate[:-1]) * (length / unit)
        if metrics is not None:
            m = metrics[here]
            part = np.maximum(part, lengths_in_metric(points[here][:-1], points[here][1:], m[:-1], m[1:]))
            rate = np.zeros(len(t))  # the length in the metric is taken as linear between samples
        found.append((t, np.concatenate([[0.0], np.cumsum(part)]), rate))
    return found


def _norms(vectors: np.ndarray) -> np.ndarray:
    """(n,) lengths of vectors whose squares may leave the doubles."""
    scale = float(np.abs(vectors).max(initial=0.0)) or 1.0
    return scale * np.linalg.norm(vectors / scale, axis=1)


def _counts(stretches: list[Stretch], totals: list[float]) -> list[int]:
    """N_s = nint(A_s), at least 1; loops get three lines, and no two stretches the same two ends by one line each."""
    counts = [max(1, int(np.floor(total + 0.5))) for total in totals]
    by_ends: dict[tuple[int, int], list[int]] = {}
    for k, s in enumerate(stretches):
        if s.corners[0] == s.corners[1]:
            counts[k] = max(counts[k], 3)
        elif counts[k] == 1:
            by_ends.setdefault((min(s.corners), max(s.corners)), []).append(k)
    for several in by_ends.values():
        # The shortest one may stay a single line: any other between its ends would be its double.
        for k in sorted(several, key=lambda k: (stretches[k].length, k))[1:]:
            counts[k] = 2
    return counts


def _nodes(at: np.ndarray, total: np.ndarray, rate: np.ndarray, count: int) -> np.ndarray:
    """(count + 1,) parameters where the scaled integral is whole."""
    wanted = np.arange(1, count) * (total[-1] / count)
    k = np.clip(np.searchsorted(total, wanted, side="right") - 1, 0, len(at) - 2)
    part = total[k + 1] - total[k]
    share = np.divide(wanted - total[k], part, out=np.zeros(len(k)), where=part > 0)
    # Between samples 1 / size is linear, its integral a parabola: its root, in a form that cannot cancel.
    low, high = rate[k] / (rate.max() or 1.0), rate[k + 1] / (rate.max() or 1.0)
    mean = 0.5 * (low + high)
    root = low + np.sqrt(np.maximum(low * low + 2 * (high - low) * mean * share, 0))
    share = np.where(root > 0, 2 * mean * share / np.where(root > 0, root, 1), share)
    return np.concatenate([at[:1], at[k] + share * (at[k + 1] - at[k]), at[-1:]])


def _assembled(mesh: Mesh | None, stretches: list[Stretch], nodes: list[np.ndarray]) -> Mesh:
    """The lines through the nodes, with the data of the lines and points they come from."""
    corners = np.unique([c for s in stretches for c in s.corners])
    ends = mesh.points if mesh is not None else stretches[0].curve.points(stretches[0].knots[[0, -1]])
    points, lines, of_line = [ends[corners]], [], []
    data = {n: [v[corners]] for n, v in (mesh.point_data if mesh else {}).items() if v.dtype.kind == "f"}
    count = len(corners)
    for s, t in zip(stretches, nodes, strict=True):
        inner = t[1:-1]
        points.append(s.curve.points(inner) if len(inner) else np.empty((0, 3)))
        first, last = np.searchsorted(corners, s.corners)
        chain = np.concatenate([[first], count + np.arange(len(inner)), [last]])
        count += len(inner)
        lines.append(np.column_stack([chain[:-1], chain[1:]]))
        of_line.append(s.line_at(0.5 * (t[:-1] + t[1:])))
        for name, parts in data.items():
            flat = mesh.point_data[name][s.nodes].reshape(len(s.nodes), -1)
            rows = np.column_stack([np.interp(inner, s.knots, column) for column in flat.T])
            parts.append(rows.reshape(len(inner), *mesh.point_data[name].shape[1:]))
    cells = {"line": np.concatenate(lines)}
    if mesh is None:
        return Mesh(np.concatenate(points), cells)
    owner = np.concatenate(of_line)
    return Mesh(
        np.concatenate(points),
        cells,
        {name: np.concatenate(parts) for name, parts in data.items()},
        {name: values[owner] for name, values in mesh.cell_data.items()},
        {name: np.flatnonzero(np.isin(owner, members)) for name, members in mesh.sets.items()},
        mesh.field_data,
    )
