"""Summaries and reports of a mesh's quality."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..mesh import CELL_TYPES, Mesh, StructuredGrid
from . import _triangle_kernels as kernels
from .block import sound_summary
from .given import as_mesh
from .grid import MEASURES as GRID_MEASURES
from .measure_table import SMALLER_IS_BETTER, Measure
from .measures import check_name, lookup, measure


def summary(mesh: Mesh | StructuredGrid) -> dict[str, float]:
    """What a generator's report says of quality, by the largest dimension of the cells.

    Parameters
    ----------
    mesh : Mesh or StructuredGrid
        Cells of lower dimension are left out.

    Returns
    -------
    dict of str to float
        In the plane and on surfaces: smallest and largest angle, mean radius ratio (1 is best), worst scaled
        Jacobian (1 is best, negative is inverted). In space: smallest dihedral angle of tetrahedra, mean shape and
        worst scaled Jacobian. Empty without such cells.

    Examples
    --------
    >>> from meshcore import gallery
    >>> {name: round(value, 3) for name, value in summary(gallery.triangulated_square(2)).items()}
    {'smallest angle (degree)': 45.0, 'largest angle (degree)': 90.0, 'mean radius ratio': 1.207, \
'worst scaled jacobian': 0.816}
    """
    if (fast := sound_summary(mesh)) is not None:
        return fast
    mesh = as_mesh(mesh)
    highest = mesh.cells
    if len(highest) > 1:
        highest = {kind: cells for kind, cells in highest.items() if CELL_TYPES[kind].dimension == mesh.dimension}
    if list(highest) == ["triangle"] and (fast := _summary_of_triangles(mesh)):
        return fast
    if mesh.dimension < 2:
        return {}
    planar = (
        ("smallest angle (degree)", "min_angle", np.min),
        ("largest angle (degree)", "max_angle", np.max),
        ("mean radius ratio", "radius_ratio", np.mean),
        ("worst scaled jacobian", "scaled_jacobian", np.min),
    )
    solid = (
        ("smallest dihedral angle (degree)", "min_angle", np.min),
        ("mean shape", "shape", np.mean),
        ("worst scaled jacobian", "scaled_jacobian", np.min),
    )
    top = Mesh(mesh.points, highest)
    values = {label: (measure(top, name), reduce) for label, name, reduce in (planar if mesh.dimension == 2 else solid)}
    found = {label: (v[~np.isnan(v)], reduce) for label, (v, reduce) in values.items()}
    return {label: float(reduce(v)) for label, (v, reduce) in found.items() if len(v)}


def _summary_of_triangles(mesh: Mesh) -> dict[str, float]:
    """The same by one fused pass; empty where numbers are extreme."""
    found = np.zeros(kernels.SUMMARY_SIZE)
    cells = mesh.cells["triangle"]
    if not len(cells) or not kernels.summarise(mesh.points, cells, found):
        return {}
    smallest, largest, ratios, worst = found.tolist()
    return {
        "smallest angle (degree)": smallest,
        "largest angle (degree)": largest,
        "mean radius ratio": ratios / len(cells),
        "worst scaled jacobian": worst,
    }


def triangles_below(mesh: Mesh, angle: float) -> int:
    """How many triangles have an angle below one above 0, in degrees.

    Examples
    --------
    >>> from meshcore import gallery
    >>> triangles_below(gallery.triangulated_square(2), 45.1)
    8
    """
    cotangent = float(1 / np.tan(np.radians(angle)))
    return kernels.count_below(mesh.points, mesh.get("triangle"), cotangent)


DEFAULT_MEASURES = {
    2: ("min_angle", "max_angle", "radius_ratio", "scaled_jacobian", "shape", "size_jump"),
    3: ("volume", "scaled_jacobian", "shape", "non_orthogonality", "face_skewness", "size_jump"),
}
OF_GRIDS = ("equiangle_skew", "max_edge_ratio")
"""What a structured grid is measured by besides, with all measures that only grids have."""
PERCENTILES = (1, 50, 99)
WORST = 10
BINS = 12
_BARS = " ▏▎▍▌▋▊▉█"


@dataclass(frozen=True, eq=False)
class Row:
    """One measure of all cells that have it.

    Attributes
    ----------
    name, unit : str
        Of the measure.
    count : int
        Cells that have it.
    minimum, mean, maximum : float
        Over these cells; the mean over the finite values.
    percentiles : tuple of float
        At `PERCENTILES`.
    acceptable : tuple of two float
        Range of well-shaped cells, of the first kind that has the measure.
    outside : int
        Cells outside the acceptable range of their own kind.
    worst : (at most WORST,) int
        Numbers of the worst cells, the worst first.
    histogram : tuple of (BINS,) int and (BINS + 1,) float
        Counts and edges over the finite values, ready for a bar chart.
    """

    name: str
    unit: str
    count: int
    minimum: float
    mean: float
    maximum: float
    percentiles: tuple[float, ...]
    acceptable: tuple[float, float]
    outside: int
    worst: np.ndarray
    histogram: tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True, eq=False)
class QualityReport:
    """The quality of a mesh, as numbers and as text.

    Attributes
    ----------
    mesh : str
        What was looked at.
    rows : dict of str to Row
        By the name of the measure.
    """

    mesh: str
    rows: dict[str, Row]

    def table(self) -> str:
        """The numbers, a line a measure."""
        titles = ("measure", "cells", "min", "mean", "max", *(f"{p}%" for p in PERCENTILES), "acceptable", "outside")
        lines = [titles]
        for row in self.rows.values():
            numbers = (row.minimum, row.mean, row.maximum, *row.percentiles)
            accepted = "{:.4g} to {:.4g}".format(*row.acceptable).replace("to inf", "up").replace("-inf to", "up to")
            label = f"{row.name} ({row.unit})" if row.unit else row.name
            lines.append((label, f"{row.count:,}", *(f"{v:.4g}" for v in numbers), accepted, f"{row.outside:,}"))
        widths = [max(len(line[k]) for line in lines) for k in range(len(titles))]
        return "\n".join(
            "  ".join([line[0].ljust(widths[0]), *(t.rjust(w) for t, w in zip(line[1:], widths[1:], strict=True))])
            for line in lines
        )

    def chart(self, name: str, width: int = 40) -> str:
        """The histogram of one measure as text."""
        row = self.rows[name]
        counts, edges = row.histogram
        unit = 8 * width / max(int(counts.max(initial=0)), 1)
        lines = [f"{name}, worst cells {', '.join(map(str, row.worst.tolist()))}"]
        for count, low, high in zip(counts.tolist(), edges[:-1], edges[1:], strict=True):
            full, part = divmod(max(round(count * unit), 1 if count else 0), 8)
            bar = "█" * full + _BARS[part].strip()
            lines.append(f"{low:>10.4g} {high:>10.4g}  {bar:<{width}}  {count:,}".rstrip())
        return "\n".join(lines)

    def __str__(self) -> str:
        charts = [self.chart(name) for name, row in self.rows.items() if row.histogram[0].sum()]
        return "\n\n".join([f"{self.mesh}\n{self.table()}", *charts])


def report(mesh: Mesh | StructuredGrid, measures: Sequence[str] | None = None) -> QualityReport:
    """Look at the quality of a mesh by several measures.

    Parameters
    ----------
    mesh : Mesh or StructuredGrid
        Any mixture of cells; sides that are cells too count only by measures that those they bound do not have.
    measures : sequence of str, optional
        Names; by default a choice that suits the largest dimension of the cells.

    Returns
    -------
    QualityReport
        Prints as a table and text histograms.

    Raises
    ------
    InvalidInput
        If a name is not known.

    Examples
    --------
    >>> from meshcore import gallery
    >>> print(report(gallery.triangulated_square(2), ["min_angle"]).table())
    measure             cells  min  mean  max  1%  50%  99%  acceptable  outside
    min_angle (degree)      8   45    45   45  45   45   45    30 to 60        0
    """
    if isinstance(measures, str):
        measures = (measures,)
    flat = as_mesh(mesh)
    for name in measures or ():
        check_name(name, of_grid=isinstance(mesh, StructuredGrid))
    names = _default_names(mesh, flat.dimension) if measures is None else tuple(measures)
    rows = ((name, _row(mesh, flat, name)) for name in names)
    return QualityReport(repr(mesh), {name: row for name, row in rows if row is not None})


def _default_names(mesh: Mesh | StructuredGrid, dimension: int) -> tuple[str, ...]:
    names = DEFAULT_MEASURES.get(dimension, ())
    if isinstance(mesh, StructuredGrid):
        names += OF_GRIDS + tuple(GRID_MEASURES)
    return names


def _row(given: Mesh | StructuredGrid, mesh: Mesh, name: str) -> Row | None:
    """The numbers of one measure of what was given, of which ``mesh`` has the cells, or None if no cell has it."""
    if isinstance(given, StructuredGrid) and name in GRID_MEASURES:
        tables = [(GRID_MEASURES[name], slice(0, mesh.n_cells))]
        values = given.flat(measure(given, name))
    else:
        tables = [(lookup(kind, name), where) for kind, _, where in mesh.blocks()]
        values = _of_highest(mesh, measure(mesh, name))
    cells = np.flatnonzero(~np.isnan(values))
    if not len(cells):
        return None
    low, high = np.full(mesh.n_cells, np.nan), np.full(mesh.n_cells, np.nan)
    for table, where in tables:
        if table:
            low[where], high[where] = table.acceptable
    first = next(table for table, where in tables if table and not np.isnan(values[where]).all())
    return _numbers(name, first, cells, values[cells], low[cells], high[cells])


def _of_highest(mesh: Mesh, values: np.ndarray) -> np.ndarray:
    """The values without those of sides that are cells too, where the cells that they bound have any."""
    inner = np.zeros(mesh.n_cells, bool)
    for kind, _, where in mesh.blocks():
        inner[where] = CELL_TYPES[kind].dimension == mesh.dimension
    return values if np.isnan(values[inner]).all() else np.where(inner, values, np.nan)


def _numbers(
    name: str, first: Measure, cells: np.ndarray, values: np.ndarray, low: np.ndarray, high: np.ndarray
) -> Row:
    """The numbers of the values that some cells have, of which each has its acceptable range."""
    slack = 1e-12 * np.where(np.isfinite(high), np.abs(high), 1.0)  # a perfect cell must not fail by rounding
    below, above = values < low - slack, values > high + slack
    # A value beyond the good end of the scale, such as a negative condition number, is worst of all.
    badness = np.where(below, np.inf, values) if name in SMALLER_IS_BETTER else np.where(above, np.inf, -values)
    finite = values[np.isfinite(values)]
    return Row(
        name,
        first.unit,
        len(cells),
        float(values.min()),
        float(finite.mean()) if len(finite) else float("nan"),
        float(values.max()),
        tuple(float(v) for v in np.percentile(values, PERCENTILES, method="nearest")),
        tuple(float(v) for v in first.acceptable),
        int((below | above).sum()),
        cells[np.argsort(-badness, kind="stable")[:WORST]],
        _histogram(finite),
    )


def _histogram(finite: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Counts and edges; a few bins only if all values are the same but for rounding."""
    if not len(finite):
        return np.zeros(BINS, int), np.linspace(0, 1, BINS + 1)
    low, high = float(finite.min()), float(finite.max())
    if high - low <= 1e-9 * max(abs(low), abs(high), np.finfo(float).tiny):
        middle, half = (low + high) / 2, max(abs(low) * 1e-3, 1e-3)
        low, high = middle - half, middle + half
    return np.histogram(finite, bins=BINS, range=(low, high))
