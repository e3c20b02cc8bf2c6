"""Where refinement has its sizes from: arrays on a background or on the boundary, a callable, and their gradation."""

from __future__ import annotations

import numpy as np

from ..errors import InvalidInput
from ..geometry.plane import Plane
from ..mesh import Mesh
from ..progress import Progress, silent
from ..sizing.background import background_field, checked_sizes, only_array
from ..sizing.gradation import checked_gradation, limited
from ..sizing.on_curves import boundary_spacing
from ..sizing.size_field import SizeField, evaluated, smallest
from .constrained import ConstrainedTriangulation
from .domain import Domain
from .refiner import TooMany
from .sampled_field import gradual


class Sizing:
    """A size field over the plane of the boundary, which remembers where it was smallest.

    Parameters
    ----------
    field : callable
        Takes (m, 3) points of space, returns (m,) sizes.
    plane : Plane
        Of the boundary.
    parameter : str
        What errors call the sizes.
    """

    def __init__(self, field: SizeField, plane: Plane, parameter: str):
        self._field, self._plane, self._parameter = field, plane, parameter
        self._least, self._place = np.inf, np.zeros(3)

    def __call__(self, places: np.ndarray) -> np.ndarray:
        """(m,) sizes at (m, 2) places of the plane, checked."""
        points = self._plane.to_space(places)
        sizes = evaluated(self._field, points, self._parameter)
        if len(sizes) and sizes.min() < self._least:
            self._least, self._place = float(sizes.min()), points[sizes.argmin()]
        return sizes

    def explained(self, error: InvalidInput) -> InvalidInput:
        """The error of too many triangles, with the place of the smallest size."""
        if not isinstance(error, TooMany) or error.parameter != "size_field":
            return error
        place = ", ".join(f"{x:.6g}" for x in self._place)
        text = str(error).removeprefix("size_field: ")
        return InvalidInput(f"{text}; the smallest size is {self._least:.3g}, at ({place})", parameter=self._parameter)


def sizing(
    boundary: Mesh,
    background: Mesh | None,
    size_array: str,
    gradation: float | None,
    size_field: SizeField | None,
    plane: Plane,
    triangulation: ConstrainedTriangulation,
    domain: Domain,
    progress: Progress = silent,
) -> Sizing | None:
    """The size field that the arguments of `delaunay_refinement` ask for; None if they ask for none.

    Parameters
    ----------
    boundary, background, size_array, gradation, size_field
        As `delaunay_refinement` has them.
    plane : Plane
        Of the boundary.
    triangulation : ConstrainedTriangulation
        Of the boundary, not refined yet.
    domain : Domain
        Which of its faces are meshed.
    progress : Progress
        Looked at for cancellation.

    Raises
    ------
    InvalidInput
        If there is no such array, or sizes are not finite and greater than zero; it says where.
    """
    fields, names = [], []
    if gradation is not None:
        gradation = checked_gradation(gradation)
    if size_field is not None:
        names.append("size_field")
        if gradation is not None:
            size_field = gradual(size_field, _carrier(plane, triangulation, domain), plane, gradation, progress)
        fields.append(size_field)
    if background is not None:
        names.append("size_array" if size_array else "background")
        sizes = checked_sizes(background, size_array or only_array(background), "background")
        fields.append(
            background_field(background, sizes if gradation is None else limited(background, sizes, gradation))
        )
    elif size_array or (gradation is not None and size_field is None):
        names.append("size_array" if size_array else "gradation")
        carrier, graph = _carrier(plane, triangulation, domain), triangulation.graph
        sizes = (
            _painted(boundary, size_array, plane, triangulation)
            if size_array
            else boundary_spacing(Mesh(graph.points, {"line": graph.segments}))
        )
        fields.append(background_field(carrier, sizes if gradation is None else limited(carrier, sizes, gradation)))
    if not fields:
        return None
    return Sizing(fields[0] if len(fields) == 1 else smallest(*fields), plane, " or ".join(names))


def _carrier(plane: Plane, triangulation: ConstrainedTriangulation, domain: Domain) -> Mesh:
    """The meshed triangles between the boundary's own points: they carry sizes inwards, but not across holes."""
    corners, slots = triangulation.triangulation.live()
    kept = corners[domain.keep[triangulation.face[slots]]]
    cells = np.asarray(triangulation.triangulation.order)[kept].astype(np.int64)
    return Mesh(plane.to_space(triangulation.graph.points), {"triangle": cells})


def _painted(boundary: Mesh, name: str, plane: Plane, triangulation: ConstrainedTriangulation) -> np.ndarray:
    """(n,) sizes at the points of the graph: the boundary's, and at crossings of lines those between its ends."""
    sizes = checked_sizes(boundary, name, "size_array")
    graph = triangulation.graph
    values = np.where(graph.source >= 0, sizes[graph.source], np.inf)
    segment, end = np.nonzero(graph.source[graph.segments] < 0)
    crossing = graph.segments[segment, end]
    first = next(where.start for kind, _, where in boundary.blocks() if kind == "line")
    ends = boundary.get("line")[graph.line[segment] - first]
    places = plane.to_plane(boundary.points)  # ends may be merged with others in the graph
    whole = places[ends[:, 1]] - places[ends[:, 0]]
    part = graph.points[crossing] - places[ends[:, 0]]
    share = np.linalg.norm(part, axis=1) / np.linalg.norm(whole, axis=1)
    np.minimum.at(values, crossing, (1 - share) * sizes[ends[:, 0]] + share * sizes[ends[:, 1]])
    return values
