"""One step of conforming refinement of a mesh: cut edges, and give the parts what their parents had."""

from __future__ import annotations

import os
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..errors import InvalidGeometry, InvalidInput
from ..mesh import Mesh
from ..mesh.topology import edge_keys
from .bisection import Edges, Parts, bisected, closed, edges_of, halved, longest_edge_first, ragged

COUNTER = "bisections"
"""Cell array that counts the cuts each cell comes from; where it is, node 0 of a triangle is its newest vertex."""

MAX_TRIANGLES = 100_000_000
"""Largest mesh that is tried, if memory suffices."""

BYTES = 500
"""Memory that refining, checking and summing up take for each triangle of the result, at their peak."""


class Step(NamedTuple):
    """A refined mesh, and for each of its cells the cell that it is part of and how often that was halved for it."""

    mesh: Mesh
    parents: np.ndarray
    cuts: np.ndarray


def labelled(mesh: Mesh) -> Mesh:
    """The mesh with the newest vertex of each triangle first: as it is if counted, else opposite the longest edge."""
    if COUNTER in mesh.cell_data:
        counts = mesh.cell_data[COUNTER]
        if counts.ndim != 1 or counts.dtype.kind not in "iuf" or not ((counts >= 0) & (counts == counts // 1)).all():
            raise InvalidInput(
                f"cell array {COUNTER!r} must hold one whole number per cell, as refined() writes it; "
                "remove or rename it",
                parameter="mesh",
            )
        return mesh.with_cell_data(**{COUNTER: counts.astype(np.int64)})
    triangles = longest_edge_first(mesh.points, mesh.cells["triangle"])
    counted = mesh.with_cell_data(**{COUNTER: np.zeros(mesh.n_cells, np.int64)})
    return replace(counted, cells={**mesh.cells, "triangle": triangles})


def triangles_in(mesh: Mesh) -> slice:
    """Where the triangles stand among all cells."""
    return next(where for kind, _, where in mesh.blocks() if kind == "triangle")


def check_size(count: int) -> None:
    """Refuse a mesh that would not fit, before memory runs out."""
    limit = min(MAX_TRIANGLES, _memory() // BYTES)
    if count > limit:
        raise InvalidInput(
            f"would make {count:.3g} triangles or more, and {limit:.3g} is the limit on this machine; "
            "ask for fewer levels, or mark fewer triangles",
            parameter="levels",
        )


def _memory() -> int:
    """Bytes of memory of this machine; if it does not tell, enough for `MAX_TRIANGLES`."""
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, ValueError, OSError):  # not a POSIX system, or one that does not know
        return MAX_TRIANGLES * BYTES


def refined_once(mesh: Mesh, marks: np.ndarray) -> Step:
    """Cut the marked triangles in four and others as conformity needs, each edge at most once.

    Parameters
    ----------
    mesh : Mesh
        As from `labelled`.
    marks : (number of triangles,) bool
        Triangles to cut.

    Returns
    -------
    Step
        Points of ``mesh`` come first, then the middles of edges.
    """
    edges = edges_of(mesh.cells["triangle"], mesh.n_points)
    cut = np.zeros(len(edges.keys), bool)
    cut[edges.of_triangle[marks]] = True
    cut = closed(cut, edges)
    check_size(len(marks) + int(cut[edges.of_triangle].sum()))

    middles = np.full(len(cut), -1)
    middles[cut] = mesh.n_points + np.arange(cut.sum())
    ends = np.column_stack(np.divmod(edges.keys[cut], mesh.n_points))
    cells, parents, cuts = _cut_cells(mesh, edges, middles)
    counts = np.bincount(parents, minlength=mesh.n_cells)
    cell_data = {name: values[parents] for name, values in mesh.cell_data.items()}
    cell_data[COUNTER] = cell_data[COUNTER] + cuts
    last = np.cumsum(counts)
    return Step(
        replace(
            mesh,
            points=_middle_points(mesh, ends),
            cells=cells,
            point_data={name: _interpolated(values, ends) for name, values in mesh.point_data.items()},
            cell_data=cell_data,
            sets={name: ragged((last - counts)[members], last[members]) for name, members in mesh.sets.items()},
        ),
        parents,
        cuts,
    )


def _cut_cells(mesh: Mesh, edges: Edges, middles: np.ndarray) -> tuple[dict[str, np.ndarray], np.ndarray, np.ndarray]:
    """Parts of all cells, kind by kind, and over all kinds their parents and cuts."""
    cells, parents, cuts = {}, [], []
    for kind, nodes, where in mesh.blocks():
        if kind == "triangle":
            parts = bisected(nodes, middles[edges.of_triangle])
        elif kind == "line":
            parts = halved(nodes, _middles_of(nodes, mesh.n_points, edges, middles))
        else:
            parts = Parts(nodes, np.arange(len(nodes)), np.zeros(len(nodes), np.int64))
        cells[kind] = parts.nodes
        parents.append(where.start + parts.parents)
        cuts.append(parts.cuts)
    return cells, np.concatenate(parents), np.concatenate(cuts)


def _middles_of(lines: np.ndarray, n_points: int, edges: Edges, middles: np.ndarray) -> np.ndarray:
    """(k,) int: middle of the edge that each line lies on; -1 where it is not cut, or no triangle has the edge."""
    keys = edge_keys(lines, n_points)
    at = np.minimum(np.searchsorted(edges.keys, keys), len(edges.keys) - 1)
    return np.where(edges.keys[at] == keys, middles[at], -1)


def _middle_points(mesh: Mesh, ends: np.ndarray) -> np.ndarray:
    """Points of the mesh, then the middles of the given pairs."""
    a, b = mesh.points[ends[:, 0]], mesh.points[ends[:, 1]]
    middle = 0.5 * a + 0.5 * b
    stuck = np.flatnonzero((middle == a).all(axis=1) | (middle == b).all(axis=1))
    if len(stuck):
        raise InvalidGeometry(
            f"an edge at {a[stuck[0]].tolist()} is too short to be cut: its middle rounds to one of its ends; "
            "ask for fewer levels",
            parameter="levels",
            points=ends[stuck[0]],
        )
    return np.concatenate([mesh.points, middle])


def _interpolated(values: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """Point data with the values at middles: the mean of numbers; of tags (whole numbers, flags) the smaller one.

    So a tag stays where both ends have it, and the background tag 0 wins over that of a boundary.
    """
    a, b = values[ends[:, 0]], values[ends[:, 1]]
    if values.dtype.kind in "fc":
        middle = (0.5 * a + 0.5 * b).astype(values.dtype)
    elif values.dtype.kind in "biu":
        middle = np.minimum(a, b)
    else:
        middle = a
    return np.concatenate([values, middle])
