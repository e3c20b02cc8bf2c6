"""Measures by name, for meshes of any mixture of cells and for structured grids."""

from __future__ import annotations

import difflib

import numpy as np

from ..errors import InvalidInput
from ..mesh import CELL_TYPES, Mesh, StructuredGrid
from . import equiangle, hexahedron, lines, neighbours, pyramid, quad, tetra, triangle, wedge
from . import grid as grids
from .given import as_mesh
from .measure_table import SMALLER_IS_BETTER, Measure
from .vectors import corners

_MODULES = (triangle, quad, tetra, hexahedron, wedge, pyramid)
BY_KIND: dict[str, dict[str, Measure]] = {
    kind: {**module.MEASURES, "equiangle_skew": equiangle.measure_of(kind)}
    for kind, module in zip(("triangle", "quad", "tetra", "hexahedron", "wedge", "pyramid"), _MODULES, strict=True)
}
"""Kind of cell -> name -> `Measure`."""
OF_FACETS: dict[str, Measure] = {**neighbours.MEASURES, **lines.MEASURES}
"""Name -> `Measure` whose function takes the mesh and gives one number a facet."""


def measures(kind: str | None = None) -> tuple[str, ...]:
    """Names of the measures of one kind of cell, or of any; with those between a cell and its neighbours.

    Parameters
    ----------
    kind : str, optional
        "triangle", "quad", "tetra", "hexahedron", "wedge", "pyramid", or a curved kind, which is measured by its
        corners; or "grid", for what only a structured grid has.

    Raises
    ------
    InvalidInput
        If there is no such kind.

    Examples
    --------
    >>> measures("tetra")[:3]
    ('aspect_frobenius', 'aspect_gamma', 'aspect_ratio')
    """
    if kind is None:
        return tuple(sorted({name for table in (*BY_KIND.values(), OF_FACETS) for name in table}))
    if kind == "grid":
        return tuple(sorted(grids.MEASURES))
    if kind not in CELL_TYPES:
        raise InvalidInput(f"{kind!r} is no kind of cell; known are {', '.join(CELL_TYPES)}", parameter="kind")
    kind = corner_kind(kind)
    if kind not in BY_KIND:
        return ()
    without = lines.MEASURES.keys() if kind not in lines.KINDS else set()
    return tuple(sorted((BY_KIND[kind].keys() | OF_FACETS.keys()) - without))


def lookup(kind: str, name: str) -> Measure | None:
    """The measure of a kind of cell by name, if it has one."""
    return BY_KIND.get(corner_kind(kind), {}).get(name) or OF_FACETS.get(name)


def corner_kind(kind: str) -> str:
    """The kind made by the corners alone."""
    return CELL_TYPES[kind].linear or kind


def measure(mesh: Mesh | StructuredGrid, name: str) -> np.ndarray:
    """One measure of every cell.

    Parameters
    ----------
    mesh : Mesh or StructuredGrid
        Curved cells are measured by their corner nodes.
    name : str
        One of `measures`; of a grid also one of ``measures("grid")``.

    Returns
    -------
    (number of cells,) or (ni-1, nj-1, max(nk-1, 1)) float
        nan where the measure is not defined for the kind of cell. Infinite where Verdict answers its largest number.
        Of measures between neighbours the worst of the cell's facets.

    Raises
    ------
    InvalidInput
        If no kind of cell has such a measure.

    Examples
    --------
    >>> mesh = Mesh([[0, 0], [1, 0], [1, 1], [0, 1], [2, 0]], {"quad": [[0, 1, 2, 3]], "triangle": [[1, 4, 2]]})
    >>> measure(mesh, "min_angle").round(9).tolist(), measure(mesh, "taper").tolist()
    ([90.0, 45.0], [0.0, nan])
    """
    check_name(name, of_grid=isinstance(mesh, StructuredGrid))
    if isinstance(mesh, StructuredGrid):
        if name in grids.MEASURES:
            return grids.MEASURES[name].function(mesh)
        shape = mesh.cell_shape
        return measure(mesh.to_mesh(), name).reshape(shape[::-1]).swapaxes(0, 2).copy()
    mesh = as_mesh(mesh)
    if name in OF_FACETS:
        if mesh.dimension < 2:
            return np.full(mesh.n_cells, np.nan)
        worst = np.fmax if name in SMALLER_IS_BETTER else np.fmin
        return neighbours.per_cell(mesh, OF_FACETS[name].function(mesh), worst)
    values = np.full(mesh.n_cells, np.nan)
    for kind in {corner_kind(kind) for kind in mesh.cells} & BY_KIND.keys():
        # Cells of one kind are measured together: sizes are compared with their common mean.
        known = BY_KIND[kind].get(name)
        blocks = [block for block in mesh.blocks() if corner_kind(block[0]) == kind]
        if known and sum(len(cells) for _, cells, _ in blocks):
            nodes = np.concatenate([cells[:, : CELL_TYPES[kind].nodes] for _, cells, _ in blocks])
            where = np.concatenate([np.arange(place.start, place.stop) for *_, place in blocks])
            with np.errstate(over="ignore", under="ignore"):
                values[where] = known.function(corners(mesh.points, nodes))
    return values


def check_name(name: str, of_grid: bool = False) -> None:
    """Raise `InvalidInput`, with the nearest names, if no kind of cell, or of grid, has a measure of this name."""
    known = measures() + (measures("grid") if of_grid else ())
    if name in known:
        return
    if name in grids.MEASURES:
        raise InvalidInput(f"{name!r} is a measure of a StructuredGrid only", parameter="name")
    near = difflib.get_close_matches(str(name), known, n=3, cutoff=0.5) or known
    raise InvalidInput(f"{name!r} is no measure; try {', '.join(near)}", parameter="name")
