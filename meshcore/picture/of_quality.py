"""Pictures of quality: histograms of its measures."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InvalidInput
from ..quality import QualityReport
from .plotter import EDGE, SUPERSAMPLING, plotter_of, save

if TYPE_CHECKING:
    import pyvista


def histogram(report: QualityReport, path: str | os.PathLike, *, window: tuple[int, int] = (1200, 800)) -> Path:
    """Draw the histograms of a quality report into a PNG file, one panel a measure.

    Parameters
    ----------
    report : QualityReport
        From `meshcore.quality.report`.
    path : path
        File to write; folders are made.
    window : tuple of two int
        Width and height in pixels.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InvalidInput
        If the report is empty.
    MissingLibrary
        Without pyvista.
    MeshcoreError
        Where this machine cannot draw, with what to install.

    Examples
    --------
    >>> import tempfile
    >>> from meshcore import gallery, quality
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     histogram(quality.report(gallery.triangulated_square()), f"{folder}/quality.png").name
    'quality.png'
    """
    rows = [row for row in report.rows.values() if row.histogram[0].sum()]
    if not rows:
        raise InvalidInput("has no measure to draw", parameter="report")
    columns = min(len(rows), 3)
    with plotter_of(window, shape=(-(-len(rows) // columns), columns)) as plotter:
        for number, row in enumerate(rows):
            plotter.subplot(*divmod(number, columns))
            plotter.add_chart(_chart(row))
        return save(plotter, path)


def _chart(row: Any) -> pyvista.Chart2D:
    """Bars of one measure's histogram."""
    import pyvista

    counts, bounds = row.histogram
    x = 0.5 * (np.asarray(bounds[:-1]) + np.asarray(bounds[1:]))
    chart = pyvista.Chart2D(x_label=f"{row.name} ({row.unit})" if row.unit else row.name, y_label="cells")
    chart.bar(x, np.asarray(counts, float), color=EDGE)
    for axis in (chart.x_axis, chart.y_axis):
        axis.label_size, axis.tick_label_size = 16 * SUPERSAMPLING, 13 * SUPERSAMPLING
        axis.tick_count = 5
    return chart
