"""Pictures of meshes and grids: edges and faces, coloured by values, and what is marked or drawn above."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InvalidInput
from ..io import to_pyvista
from ..mesh import CELL_TYPES, Mesh, MultiBlock, PolyhedralMesh, StructuredGrid
from ..quality import measure, measures
from .plotter import EDGE, SUPERSAMPLING, plotter_of, save

MARK = "#e4572e"
BLOCKS = ("#dde7f0", "#f4e3cf", "#dcefd9", "#efdcea", "#f5f0c8", "#d5eeee")
OVER = ("#2f6fb3", "#1c1c1c", "#c8371b", "#3f8f3a")
AWAY = (0.4, -1.0, 0.3)
"""Of volumes the half on this side of the middle is taken away."""
SCALE = 0.12
"""Share of a picture's width that the scale of its colours takes."""


def picture(
    mesh: Mesh | PolyhedralMesh | StructuredGrid | MultiBlock,
    path: str | os.PathLike,
    *,
    scalars: str | np.ndarray | None = None,
    window: tuple[int, int] = (1200, 900),
    zoom: Sequence[Sequence[float]] | None = None,
    edges: bool = True,
    title: str = "",
    marked: Sequence[int] = (),
    over: Sequence[Mesh] = (),
) -> Path:
    """Draw a mesh into a PNG file.

    Planar meshes are seen from above, in parallel projection. Surfaces in space are seen aslant. Of volumes the half
    towards the eye is taken away, cell by cell.

    Parameters
    ----------
    mesh : Mesh, PolyhedralMesh, StructuredGrid or MultiBlock
        What to draw; line cells are drawn as curves.
    path : path
        File to write; folders are made.
    scalars : str or (n_cells,) or (n_points,) float, optional
        Colours, with a scale: values, the name of a cell or point array, or of a quality measure of cells or grids.
    window : tuple of two int
        Width and height in pixels.
    zoom : (2, 2) float, optional
        Lower left and upper right corner of the part of a planar mesh to show.
    edges : bool
        Whether to draw the cells' edges. Their lines are the thinner the more there are.
    title : str
        Text above the picture.
    marked : sequence of int
        Cells drawn in red, such as those of `GenerationFailed`.
    over : sequence of Mesh
        Curves ("line" cells) and points ("vertex" cells) drawn above the mesh, each in a colour of its own.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InvalidInput
        If the mesh is empty, or scalars, window or zoom do not fit.
    MissingLibrary
        Without pyvista.
    MeshcoreError
        Where this machine cannot draw, with what to install.

    Examples
    --------
    >>> import tempfile
    >>> from meshcore import gallery
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     picture(gallery.triangulated_square(), f"{folder}/square.png", scalars="front", window=(200, 150)).name
    'square.png'
    """
    blocks = mesh.blocks if isinstance(mesh, MultiBlock) else (mesh,)
    if not all(isinstance(block, (Mesh, PolyhedralMesh, StructuredGrid)) for block in blocks):
        raise InvalidInput(f"needs a mesh or a grid, got {type(mesh).__name__}", parameter="mesh")
    parts = [b.to_mesh() if isinstance(b, StructuredGrid) else b for b in blocks]
    if not all(part.n_cells for part in parts):
        raise InvalidInput("has no cells to draw", parameter="mesh")
    box = _checked_zoom(zoom)
    coloured = None if scalars is None else _values(parts, blocks, scalars)
    shape, weights = ((1, 1), None) if coloured is None else ((1, 2), [1 - SCALE, SCALE])
    with plotter_of(window, shape, weights) as plotter:
        width = _line_width(parts, window, box)
        for number, part in enumerate(parts):
            values = None if coloured is None else coloured[number]
            actor = _add(plotter, part, BLOCKS[number % len(BLOCKS)], width if edges else 0.0, values)
        if coloured is not None:
            _add_scale(plotter, actor, scalars)
        if len(marked):
            _add_marked(plotter, parts[0], marked)
        for number, more in enumerate(over):
            _add_over(plotter, more, parts, OVER[number % len(OVER)])
        for part in parts:
            if isinstance(part, Mesh) and part.dimension == 2 and len(part.get("line")):
                _add_over(plotter, Mesh(part.points, {"line": part.get("line")}), parts, MARK)
        _look(plotter, parts, box, window[0] / window[1] * (1.0 if coloured is None else 1 - SCALE))
        _label(plotter, title)
        return save(plotter, path)


def _checked_zoom(zoom: Any) -> np.ndarray | None:
    if zoom is None:
        return None
    try:
        box = np.asarray(zoom, float)
    except (TypeError, ValueError):
        box = np.empty(0)
    if box.shape != (2, 2) or not np.isfinite(box).all() or (box[1] <= box[0]).any():
        raise InvalidInput(
            f"needs the lower left and the upper right corner, ((x, y), (x, y)), got {zoom!r}", parameter="zoom"
        )
    return box


def _values(parts: list[Mesh], blocks: Sequence, scalars: Any) -> list[np.ndarray]:
    """The values that colour each part."""
    if isinstance(scalars, str):
        return [_named(part, block, scalars) for part, block in zip(parts, blocks, strict=True)]
    values = np.asarray(scalars)
    if isinstance(blocks[0], StructuredGrid) and values.shape in (blocks[0].shape, blocks[0].cell_shape):
        values = blocks[0].flat(values)
    if len(parts) > 1 or values.shape not in ((parts[0].n_cells,), (parts[0].n_points,)):
        raise InvalidInput(
            f"needs {parts[0].n_cells} values for cells or {parts[0].n_points} for points of one mesh, "
            f"got shape {values.shape}",
            parameter="scalars",
        )
    return [values]


def _named(part: Mesh | PolyhedralMesh, block: Mesh | PolyhedralMesh | StructuredGrid, name: str) -> np.ndarray:
    """The values of a name: data, or a measure of the part, or of the grid that it was."""
    for data in (part.cell_data, part.point_data):
        if name in data:
            values = data[name]
            return np.linalg.norm(values.reshape(len(values), -1), axis=1) if values.ndim > 1 else values
    of_grid = measures("grid") if isinstance(block, StructuredGrid) else ()
    if name in of_grid:
        return block.flat(measure(block, name))
    if isinstance(part, PolyhedralMesh):
        own = {"area": 2, "volume": 3}
        if own.get(name) == part.dimension:
            return part.volumes
        offered = [key for key, dimension in own.items() if dimension == part.dimension]
    else:
        if any(name in measures(kind) for kind in part.cells):
            return measure(part, name)
        offered = sorted({*of_grid, *(m for kind in part.cells for m in measures(kind))})
    known = [*part.cell_data, *part.point_data, *offered]
    raise InvalidInput(f"{name!r} is neither data nor a measure; there are {', '.join(known)}", parameter="scalars")


def _line_width(parts: list[Mesh], window: tuple[int, int], box: np.ndarray | None) -> float:
    """Width of the edges' lines in pixels: a share of the typical visible edge."""
    points = np.concatenate([part.points for part in parts])
    shown = (
        box if box is not None and all(part.is_planar for part in parts) else np.array([points.min(0), points.max(0)])
    )
    extent = max((shown[1] - shown[0])[:2].max(), 1e-300)
    lengths = []
    for part in parts:
        middle = part.points[part.edges].mean(axis=1)
        inside = ((middle[:, :2] >= shown[0, :2]) & (middle[:, :2] <= shown[1, :2])).all(axis=1)
        ends = part.points[part.edges[inside if inside.any() else slice(None)]]
        lengths.append(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1))
    pixels = np.quantile(np.concatenate(lengths), 0.6) * 0.9 * min(window) / extent
    return float(np.clip(0.1 * pixels, 0.5, 1.3))


def _add(plotter: Any, part: Mesh | PolyhedralMesh, colour: str, width: float, values: np.ndarray | None) -> Any:
    """Add curves as lines, of volumes the far half, and faces with edges ``width`` pixels wide; return the actor."""
    part = replace(part, point_data={}, cell_data={}, field_data={})
    if isinstance(part, Mesh) and part.dimension > 1:
        part, values = _without_sides(part, values)
    if isinstance(part, PolyhedralMesh) and part.dimension == 3:
        part, values = _opened(part, values)
    data = to_pyvista(part)
    if values is not None:
        (data.cell_data if len(values) == part.n_cells else data.point_data)["values"] = values.astype(float)
    if part.dimension < 2:
        plotter.add_mesh(data, color=EDGE, line_width=2 * SUPERSAMPLING, lighting=False, **_colours(values))
        return
    if part.dimension == 3:
        data = data.clip(normal=AWAY, origin=data.center, crinkle=True).extract_surface(algorithm="dataset_surface")
    thick, opacity = max(width * SUPERSAMPLING, 1.0), 1.0 if width > 0.5 else 0.6
    of_polygons = isinstance(part, PolyhedralMesh) and part.is_planar and width > 0
    if of_polygons:  # VTK draws edges by the triangles of a polygon, and loses some beside sharp ones
        lines = Mesh(part.points + [0, 0, 1e-4 * part.diagonal], {"line": part.edges})
        plotter.add_mesh(to_pyvista(lines), color=EDGE, opacity=opacity, line_width=thick, lighting=False)
    return plotter.add_mesh(
        data,
        color=colour,
        show_edges=width > 0 and not of_polygons,
        edge_color=EDGE,
        edge_opacity=opacity,
        line_width=thick,
        lighting=not part.is_planar,
        **_colours(values),
    )


def _without_sides(part: Mesh, values: np.ndarray | None) -> tuple[Mesh, np.ndarray | None]:
    """The cells of highest dimension of a mesh that may have its lines or sides as cells too, and their values."""
    highest = {kind: CELL_TYPES[kind].dimension == part.dimension for kind in part.cells}
    inner = np.concatenate([np.full(len(cells), highest[kind]) for kind, cells in part.cells.items()])
    if inner.all():
        return part, values
    cells = {kind: cells for kind, cells in part.cells.items() if highest[kind]}
    return Mesh(part.points, cells), values[inner] if values is not None and len(values) == part.n_cells else values


def _opened(part: PolyhedralMesh, values: np.ndarray | None) -> tuple[PolyhedralMesh, np.ndarray | None]:
    """The surface of those polyhedra that lie in the half away from the eye, and its values."""
    far = (part.centroids - part.bounds.mean(axis=0)) @ AWAY <= 0
    if values is not None:
        part = part.with_cell_data(v=values) if len(values) == part.n_cells else part.with_point_data(v=values)
    kept = part.selected(far if far.any() else ~far)
    surface = kept.boundary
    if values is not None:
        values = kept.cell_data["v"][surface.cell_data["cell"]] if "v" in kept.cell_data else kept.point_data["v"]
    return replace(surface, point_data={}, cell_data={}), values


def _colours(values: np.ndarray | None) -> dict[str, Any]:
    """pyvista's arguments for coloured values; the limits are rounded, so that the scale's numbers are short."""
    if values is None:
        return {}
    finite = values[np.isfinite(values)]
    ends = np.array([finite.min(), finite.max()] if len(finite) else [0.0, 1.0])
    low, high = (float(f"{v:.3g}") if abs(v) > 1e-12 * np.abs(ends).max() else 0.0 for v in ends)
    if high <= low:  # all the same but for round-off
        low, high = low - 0.5 * (abs(low) or 1.0), high + 0.5 * (abs(high) or 1.0)
    return {
        "scalars": "values",
        "cmap": "viridis",
        "nan_color": "white",
        "clim": (low, high),
        "show_scalar_bar": False,
    }


def _add_scale(plotter: Any, actor: Any, name: Any) -> None:
    """The scale of an actor's colours, in the narrow part of the picture to the right."""
    letters = max(plotter.window_size[1] // 50, 8)
    title = name.replace("_", " ") if isinstance(name, str) else "values"
    plotter.subplot(0, 1)
    plotter.add_scalar_bar(
        title=title,
        mapper=actor.mapper,
        color="black",
        vertical=True,
        position_x=0.15,
        position_y=0.15,
        width=0.5,
        height=0.7,
        title_font_size=min(letters, 12 * letters // len(title)),
        label_font_size=letters,
        n_labels=5,
    )
    plotter.subplot(0, 0)


def _add_marked(plotter: Any, part: Mesh, marked: Sequence[int]) -> None:
    chosen = np.asarray(marked, dtype=np.int64)
    if chosen.min() < 0 or chosen.max() >= part.n_cells:
        raise InvalidInput(f"refers to cells beyond the {part.n_cells} there are", parameter="marked")
    some = part.selected(chosen)
    lift = np.array([0, 0, 1e-4 * part.diagonal]) if part.is_planar else 0.0
    data = to_pyvista(replace(some.with_points(some.points + lift), point_data={}, cell_data={}))
    plotter.add_mesh(data, color=MARK, show_edges=True, edge_color=EDGE, line_width=SUPERSAMPLING, lighting=False)


def _add_over(plotter: Any, more: Mesh, parts: list[Mesh], colour: str) -> None:
    """Curves and points a little above the planar mesh that they belong to."""
    if not isinstance(more, Mesh) or more.dimension > 1 or not more.n_cells:
        raise InvalidInput(f"needs meshes of line or vertex cells, got {more!r}", parameter="over")
    planar = more.is_planar and all(part.is_planar for part in parts)
    lift = np.array([0, 0, 2e-4 * max(part.diagonal for part in parts)]) if planar else 0.0
    size = {"line_width": 2 * SUPERSAMPLING, "point_size": 7 * SUPERSAMPLING, "render_points_as_spheres": True}
    plotter.add_mesh(to_pyvista(Mesh(more.points + lift, more.cells)), color=colour, lighting=False, **size)


def _look(plotter: Any, parts: list[Mesh], box: np.ndarray | None, aspect: float) -> None:
    """Set the camera: from above on planar meshes, aslant on others."""
    if not all(part.is_planar for part in parts):
        plotter.view_vector((-1.0, -2.0, 1.2) if parts[0].dimension < 3 else (0.8, -2.0, 1.2))
        plotter.enable_lightkit()
        plotter.camera.zoom(1.1)
        return
    if box is None:
        points = np.concatenate([part.points for part in parts])[:, :2]
        box = np.array([points.min(axis=0), points.max(axis=0)])
        box += 0.04 * np.ptp(box, axis=0).max() * np.array([[-1], [1]])
    middle, size = box.mean(axis=0), box[1] - box[0]
    camera = plotter.camera
    camera.enable_parallel_projection()
    far = 10 * max(size.max(), max(part.diagonal for part in parts))
    camera.focal_point, camera.position, camera.up = (*middle, 0.0), (*middle, far), (0.0, 1.0, 0.0)
    camera.parallel_scale = 0.5 * max(size[1], size[0] / aspect)
    camera.clipping_range = (0.5 * far, 1.5 * far)


def _label(plotter: Any, title: str) -> None:
    if title:
        plotter.add_text(
            title, position="upper_left", font_size=8 * SUPERSAMPLING, color="black", shadow=False, name="title"
        )
