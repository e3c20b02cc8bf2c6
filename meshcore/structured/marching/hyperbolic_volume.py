"""Layers of hexahedra and wedges marched from a surface (survey 2.7.1)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, Union

import numpy as np

from ...errors import GenerationFailed, InvalidGeometry
from ...mesh import Mesh, MultiBlock, StructuredGrid
from ...operation import Param, Port, Relative, absolute, operation
from ...progress import Progress, advance, part_of, silent
from ...quality import summary, validate
from ...report import Report, Result
from ...threads import checked_threads
from ..layer_report import layers_told
from ..limits import check_size
from .edge_conditions import EdgeChoice, FrontEdges, front_edges
from .front_bends import concavity, is_concave
from .front_crossing import clear_layers, emptied_layer, overlapping_node
from .front_graph import FrontGraph, at
from .layer_cuts import with_cuts
from .layer_marching import Outcome, first_normals, least_corner, marched
from .layer_sides import with_sides
from .layer_surface import LayerSurface, read_surface
from .marching_parameters import (
    DistanceParam,
    FirstHeightParam,
    GrowthParam,
    LargestHeightParam,
    LayersParam,
    SplayParam,
    asked_heights,
)
from .outer_surface import OuterSurface

_CURE = "give the surface more points there, ask for less distance, or round the corner"


@operation("Extrude Hyperbolic", category="Structured", output="as given")
def hyperbolic_volume(
    surface: Annotated[
        Union[Mesh, StructuredGrid, MultiBlock],
        Port("The surface to march from: triangles and quads, closed or open", cells=("triangle", "quad")),
    ],
    guide: Annotated[
        Union[Mesh, StructuredGrid, None],
        Port("Surface or curves that edges stay on", cells=("triangle", "quad", "line"), named=True),
    ] = None,
    outer: Annotated[
        Union[Mesh, StructuredGrid, None],
        # Cells in another order than the surface's: hosts call the first input just that only if no other is alike.
        Port(
            "Surface to end at: closed round a closed one, a shell over an open one",
            cells=("quad", "triangle"),
            named=True,
        ),
    ] = None,
    *,
    first_height: FirstHeightParam = Relative(0.001),
    growth: GrowthParam = 1.15,
    layers: LayersParam = None,
    distance: DistanceParam = None,
    largest_height: LargestHeightParam = None,
    other_side: Annotated[bool, Param("March into a closed surface, or to the back of an open one")] = False,
    edges: Annotated[
        EdgeChoice,
        Param("What edges of an open surface do: planes of symmetry found, or all alike", group="Edges"),
    ] = "automatic",
    each_edge: Annotated[
        str,
        Param("What single edges do, by their names: imin = plane, zmax = splay 20, vertex 7 = free", group="Edges"),
    ] = "",
    splay: SplayParam = 15.0,
    volume_smoothing: Annotated[
        float,
        Param("Off hollow surfaces: 1 widens all cells of a layer alike, 0 keeps heights", min=0, max=1, advanced=True),
    ] = 1.0,
    threads: int | None = None,
    progress: Progress = silent,
) -> Result:
    """March layers of hexahedra and wedges off a surface, at right angles and with given heights.

    The surface's points are kept exactly. Grids, blocks and meshes are glued into one front of nodes with their
    neighbours around, so corners of three, five or more patches and triangles are like any other place. Closed
    surfaces are marched outwards, open ones to the side from which their faces are counter-clockwise. No parameter
    needs a choice: dissipation finds concave corners by itself, and layers that would fold are made in smaller steps.

    ::

           _____________
          /  _________  \\
         /  /         \\  \\      each layer of nodes is a copy of the surface's:
        |  |  surface  |  |     quads become hexahedra, triangles wedges
         \\  \\_________/  /
          \\_____________/

    Parameters
    ----------
    surface : Mesh, StructuredGrid or MultiBlock
        Quads and triangles in space; blocks share their edges point by point. Points that coincide are glued, faces
        turned alike, closed surfaces that face inwards turned; the report tells.
    first_height : Length
        Height of the first layer.
    growth : float
        Each height over the one before. With a distance and no number of layers, the largest that is allowed.
    layers : int, optional
        Number of layers.
    distance : Length, optional
        Sum of the heights. With `layers`, growth follows from both.
    largest_height : Length, optional
        Heights stay below.
    other_side : bool
        March into a closed surface, or to the back of an open one.
    guide : Mesh or StructuredGrid, optional
        A surface, such as a wall next to this one, or curves, on which edges stay that ask for it or lie on it. Beyond
        its end it goes straight on.
    outer : Mesh or StructuredGrid, optional
        Where layers end, in place of a distance. They are marched half of the least way, and then turn by and by to it,
        as those of `parabolic`. With no number of layers, it is such that heights grow by `growth` on the longest way.
    edges : {"automatic", "free", "plane", "constant x", "constant y", "constant z", "splay", "guide", "periodic"}
        What the edges of an open surface do. "automatic" makes those periodic at which the surface has cuts that move
        points, keeps those on the guide that lie on it, and finds planes of symmetry: sides in a plane that the surface
        meets within 30 degrees of a right angle; other sides are free. "constant x" keeps x at all edges. "periodic"
        edges are each other's image, moved or turned, in pairs.
    each_edge : str
        What single edges do, in place of `edges`: names and conditions as in "imin = periodic, imax = periodic,
        zmin = constant z". An edge ends at corners of more than 40 degrees. Its names are those of a grid's sides,
        "imin" to "jmax", alone or after the block's name, and what the grid calls them; those of the sets of a mesh's
        line cells, and their tags, as "tag 3"; "vertex 7" is the edge of a mesh with that point; "xmin" to "zmax" an
        edge all of which lies where the surface has its least x, or its largest z. Where two meet, both hold.
    splay : float
        Degrees by which edges that splay lean outwards.
    volume_smoothing : float
        How far cells of a layer widen alike where the surface is hollow anywhere: 1 shares all of it, so that layers
        grow in hollows and lag behind bulges, and fronts round off; 0 keeps the heights that were asked, at each point
        as well as dissipation lets it. Layers of convex surfaces keep their heights always.
    threads : int, optional
        How many threads share the work; all available cores if not given. The layers do not depend on it.
    progress : Progress, optional
        Called with fraction and message.

    Returns
    -------
    Result
        From a `StructuredGrid` (ni, nj, 1) one of (ni, nj, layers + 1), whose faces kmin and kmax are "wall" and
        "outer", and whose cuts tell the periodic edges; from a `MultiBlock` one of such blocks; from a `Mesh` one of
        "hexahedron" and "wedge" cells, with the number of the layer in ``cell_data["layer"]``, and with the faces of
        its boundary as "triangle" and "quad" cells, each in one of its ``sets``: "outer"; those of the surface, as
        the first set of the given mesh that has them is called, or their tag, as "tag 3", or "wall"; and those above
        edges. These have the name of the mesh's set or tag of line cells; or "periodic" and "periodic donor"; or that
        by which `each_edge` speaks of them; or "xmin" to "zmax" if all of the edge lies there; or "boundary". If the
        march had to stop there are fewer layers, `converged` is False, a warning says at which point, layer and
        concavity, and ``cell_data["stopped"]`` marks the cells there.

    Raises
    ------
    InvalidInput
        If heights do not fit each other, or edges are spoken of that are not there.
    InvalidGeometry
        If the surface has edges of more than two faces, one side only, or flat faces; `points` says where.
    GenerationFailed
        If not even one layer could be made.

    Notes
    -----
    Lines orthogonal to the layers, and cell volumes of height times area, are Chan and Steger's equations. Each step
    solves them at its end, linearised about the front, on any ring of neighbours; normals are weighted so that they are
    radial on spheres. Where the surface is hollow, dissipation in proportion to a cell's height over its width acts in
    whole where the front is concave or narrows, and grows with the distance, so that it rounds corners alike at all
    distances; heights near them differ from what was asked. Steps whose equations are not solved to a hundredth of
    their height are split, or not made; `residual` tells what was left. Lines stand 30 degrees above all faces around
    them where they can. Where cells would fold at a few nodes whatever the steps, these and those around move to where
    the cells' corners are like those of the surface's faces.

    References
    ----------
    Survey, section 2.7.1. W. M. Chan, J. L. Steger, "Enhancements of a three-dimensional hyperbolic grid generation
    scheme", Appl. Math. Comput. 51 (1992).

    Examples
    --------
    >>> from meshcore import gallery
    >>> mesh, report = hyperbolic_volume(gallery.bumpy_ball(), first_height=0.01, layers=10)
    >>> mesh, report.converged
    (Mesh(1782 points, 3200 wedge, 640 triangle), True)
    >>> {name: len(faces) for name, faces in mesh.sets.items()}
    {'wall': 320, 'outer': 320}

    One sector of a hub, whose sides are each other turned:

    >>> asked = "imin = periodic, imax = periodic, jmin = constant z"
    >>> hub, _ = hyperbolic_volume(gallery.hub_sector(), first_height=0.01, layers=5, each_edge=asked)
    >>> hub, hub.cuts[0].name
    (StructuredGrid(13 x 17 x 6 points), 'periodic')
    """
    checked_threads(threads)
    ready = read_surface(surface, other_side=other_side)
    graph = ready.graph
    diagonal = float(np.linalg.norm(np.ptp(graph.points, axis=0)))
    check_size(len(graph.points), 1 if layers is None else layers + 1, parameter="layers")
    beyond = None if outer is None else OuterSurface(outer, ready, distance, largest_height)
    if beyond is None:
        heights = asked_heights(first_height, growth, layers, distance, largest_height, diagonal=diagonal)
    else:
        heights = beyond.heights(absolute(first_height, diagonal), growth, layers)
    check_size(len(graph.points), len(heights) + 1, parameter="layers")
    front = front_edges(ready, first_normals(graph), edges, each_edge, splay, guide)
    made, outcome = _layers(ready, front, heights, beyond, volume_smoothing, threads, progress)
    warnings = [*ready.warnings, *front.warnings, *([] if beyond is None else beyond.warnings)]
    if outcome.stopped_at >= 0:
        warnings.append(_told_stop(graph, made, outcome, len(heights)))
        if len(made) == 1:
            at = np.flatnonzero(ready.number == outcome.stopped_at)
            raise GenerationFailed(f"no layer could be made: {warnings[-1]}", parameter="surface", points=at)
    layered = ready.layered(made)
    if isinstance(layered, Mesh):
        result, untold = with_sides(ready, front.sides, front.called, layered)
    else:
        result, untold = with_cuts(ready, front.pairs, layered)
    return _reported(ready, result, made, heights, outcome, warnings + untold)


def _layers(
    ready: LayerSurface,
    front: FrontEdges,
    heights: np.ndarray,
    beyond: OuterSurface | None,
    volume_smoothing: float,
    threads: int | None,
    progress: Progress,
) -> tuple[np.ndarray, Outcome]:
    """The layers of the surface's nodes that are sound and do not meet, up to an outer surface if there is one."""
    part = 0.8 if beyond is None else 0.4
    layers, outcome = marched(
        front.graph,
        heights if beyond is None else heights[: beyond.marching],
        hold=front.hold,
        volume_smoothing=volume_smoothing,
        threads=threads,
        progress=part_of(progress, 0.0, part),
    )
    advance(progress, part, "checking the layers")
    made, outcome.stopped_at = front.of_surface(layers, outcome.stopped_at)
    made = _without_crossings(ready, made, outcome)
    if beyond is not None:
        made = beyond.joined(front, layers[: len(made)], heights, outcome, part_of(progress, part, 0.8))
    return made, outcome


def _without_crossings(ready: LayerSurface, made: np.ndarray, outcome: Outcome) -> np.ndarray:
    """The layers up to where the front meets itself, or fronts of several surfaces meet."""
    graph = ready.graph
    if ready.is_closed and not ready.inwards and not graph.part.any() and not is_concave(graph):
        return made  # convex: layers widen forever
    if ready.is_closed and ready.inwards and (left := emptied_layer(graph, made)) < len(made):
        step = np.linalg.norm(made[left] - made[left - 1], axis=1)
        outcome.stopped_at, outcome.why = int(np.argmax(step)), "would fill more than the inside, seen"
        made = made[:left]
    if len(made) == 1:
        return made
    clear, node = clear_layers(graph, made)
    if node < 0:
        return made
    if clear == 0 and (crossing := overlapping_node(graph, graph.points[None])) >= 0:
        raise InvalidGeometry(
            f"passes through itself near {at(graph.points[crossing])}; separate or unite its parts",
            parameter="surface",
            points=ready.points_at(crossing),
        )
    outcome.stopped_at, outcome.why = node, "would meet another part of the front"
    return made[: clear + 1]


def _reported(
    ready: LayerSurface,
    result: Union[Mesh, StructuredGrid, MultiBlock],
    made: np.ndarray,
    heights: np.ndarray,
    outcome: Outcome,
    warnings: list[str],
) -> Result:
    count = len(made) - 1
    blocks = result.blocks if isinstance(result, MultiBlock) else (result,)
    worst = least_corner(ready.graph, made)
    if isinstance(result, Mesh) and worst <= 0:
        raise GenerationFailed("cells of the layers are folded", partial=result)
    for block in blocks if not isinstance(result, Mesh) else ():
        validate(block)
    quality = {
        **layers_told(made.swapaxes(0, 1), float(heights[0])),
        "worst corner (degree)": math.degrees(math.asin(min(worst, 1.0))),
        **({} if isinstance(result, Mesh) else _summary(blocks)),
    }
    counts = {
        "points": sum(block.n_points for block in blocks),
        "cells": len(ready.graph.faces) * count,
        "layers": count,
    }
    if outcome.steps > count:
        counts["steps"] = outcome.steps
    if outcome.stopped_at >= 0:
        quality.update(
            {f"stopped at {axis}": float(x) for axis, x in zip("xyz", made[-1, outcome.stopped_at], strict=True)}
        )
        result = ready.marked(result, outcome.stopped_at)
    report = Report(
        counts=counts, quality=quality, iterations=outcome.products, residual=outcome.residual,
        converged=outcome.stopped_at < 0, warnings=warnings,
    )  # fmt: skip
    return Result(result, report)


def _summary(blocks: Sequence[StructuredGrid]) -> dict[str, float]:
    """The blocks' quality together: worst of the worst, mean of the means."""
    found, cells = [summary(block) for block in blocks], [block.n_cells for block in blocks]
    return {
        name: min(q[name] for q in found)
        if name.startswith("worst")
        else float(np.average([q[name] for q in found], weights=cells))
        for name in found[0]
    }


def _told_stop(graph: FrontGraph, made: np.ndarray, outcome: Outcome, asked: int) -> str:
    """The warning of a march that stopped: where, and why."""
    node = outcome.stopped_at
    bend, place = concavity(graph, graph.points[node])
    why = f"; nearest concavity: an inner angle of {180 - bend:.0f} degrees at {at(place)}" if bend else ""
    return (
        f"stopped after {len(made) - 1} of {asked} layers: layer {len(made)} {outcome.why} near {at(made[-1, node])}, "
        f"above the surface's point {at(graph.points[node])}{why}; {_CURE}"
    )
