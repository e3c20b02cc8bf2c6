"""A small, typical call of each operation, for tests and for compiling ahead."""

from __future__ import annotations

from typing import Any

from ..errors import InvalidInput
from ..geometry.curves import lines_through
from ..operation import operations
from ..progress import Progress, advance, part_of, silent
from .planar import airfoil, circle, rough_ring, square_with_hole, sunflower, triangulated_square, wavy_sides
from .surfaces import bumpy_ball
from .volumes import cloud_in_a_ball, dented_box, twisted_cage


def arguments(identifier: str) -> tuple[tuple[Any, ...], dict[str, Any]]:
    """A small, typical call of an operation: positional inputs and keywords.

    Raises
    ------
    InvalidInput
        If the gallery has none for it: each operation needs one, or it cannot be warmed up.

    Examples
    --------
    >>> inputs, keywords = arguments("delaunay_refinement")
    >>> inputs[0]
    Mesh(45 points, 45 line)
    """
    calls: dict[str, tuple[tuple[Any, ...], dict[str, Any]]] = {
        "hyperbolic": ((airfoil("naca0012"),), {"first_height": 0.002, "growth": 1.25}),
        "parabolic": (
            (airfoil("naca0012"), circle(48, radius=2.0, centre=(0.5, 0.0))),
            {"first_height": 0.004, "growth": 1.25},
        ),
        "hyperbolic_volume": ((bumpy_ball(),), {"first_height": 0.01, "layers": 10}),
        "o_grid": ((airfoil("naca0012"),), {"radius": 4.0, "first_height": 0.01, "growth": 1.3}),
        "c_grid": ((airfoil("naca0012"),), {"radius": 4.0, "first_height": 0.005, "growth": 1.3}),
        "h_grid": ((airfoil("naca0012"),), {"radius": 3.0, "first_height": 0.01, "growth": 1.3}),
        "elliptic_volume": ((dented_box(depth=0.6, bulge=0.1),), {"edges": "poisson", "spacing_kmin": 0.05}),
        "elliptically_smoothed": ((rough_ring(),), {}),
        "transfinite": (tuple(lines_through(side) for side in wavy_sides()), {}),
        "transfinite_volume": ((twisted_cage(),), {}),
        "elliptic": (tuple(lines_through(side) for side in wavy_sides()), {}),
        "constrained_delaunay": ((square_with_hole(),), {}),
        "delaunay_3d": ((cloud_in_a_ball(),), {}),
        "discretised": ((square_with_hole(),), {"size": 0.08, "gradation": 0.5}),
        "delaunay_2d": ((square_with_hole(),), {}),
        "delaunay_refinement": ((square_with_hole(),), {"min_angle": 30.0}),
        "voronoi_2d": ((sunflower(), circle(24, radius=1.1)), {}),
        "voronoi_3d": ((cloud_in_a_ball(60),), {}),
        "smoothed": ((triangulated_square(),), {"rounds": 2}),
        "refined": ((triangulated_square(),), {"indicator": "front", "levels": 2}),
    }
    if identifier not in calls:
        raise InvalidInput(f"the gallery has no model call of {identifier!r}; add one to gallery.arguments")
    return calls[identifier]


def warm_up(progress: Progress = silent) -> dict[str, float]:
    """Make the model call of each operation, which compiles what it needs; seconds by operation.

    Raises
    ------
    Cancelled
        If ``progress`` answers False.
    """
    seconds = {}
    known = operations()
    for number, (name, operation) in enumerate(known.items()):
        step = part_of(progress, number / len(known), (number + 1) / len(known))
        advance(step, 0.0, f"compiling {operation.label}")
        positional, keywords = arguments(name)
        seconds[name] = operation.function(*positional, **keywords, progress=step).report.seconds
    advance(progress, 1.0, "compiled")
    return seconds
