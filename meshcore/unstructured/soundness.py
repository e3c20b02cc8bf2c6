"""The check that ends every triangulation of lines: what `quality.validate` asks of the mesh, where it costs little.

`quality.validate` sorts all edges of a mesh to find out who is whose neighbour, which takes as long as refinement
itself. The half-edges claim to know, so it is enough to check the claim, in one pass:

- each triangle is positive, exactly, by the coordinates that the mesh will have;
- each edge has one neighbour, which sees it from the other side, or lies on a line, and is the border of the mesh;
- each piece of a line beside the mesh is an edge of it, or several in a row, within rounding.

Positive triangles, glued edge to edge, and bordered by lines that are where they were, cover what is within these
once. The mesh itself has the same triangles by other numbers, one for each vertex that one of them uses (`assembly`),
so what holds here holds there: no orphan points, nothing twice. Coordinates are scaled back exactly, but for
numbers below 1e-308, which is why they are rounded as the mesh has them first. In a plane that leans, turning them into
space rounds once more; there no sign is exact.
"""

from __future__ import annotations

import numpy as np

from ..errors import GenerationFailed
from . import _soundness_kernels as kernels
from .constrained import ConstrainedTriangulation

# Share of the largest coordinate by which points on a piece may be off it. Splitting rounds by 1.5 * 2^-53, at most
# once a bisection, of which there are at most 53 before points coincide.
_ROUNDING = 2.0**-46
_FLAWS = {
    kernels.TURNED: "has turned a triangle over",
    kernels.TORN: "has torn triangles apart",
    kernels.LOST: "has lost a line",
}


def check(mesh: ConstrainedTriangulation, n_vertices: int, keep: np.ndarray) -> None:
    """Raise `GenerationFailed` if the triangulation is not sound.

    Parameters
    ----------
    mesh : ConstrainedTriangulation
        Faces may have been carved away.
    n_vertices : int
        Of those that there is room for.
    keep : (n_faces,) bool
        Faces that are meshed; the lines beside these are looked for.
    """
    whole = mesh.triangulation
    xy = whole.xy[: 2 * n_vertices]
    if mesh.exponent:
        xy = np.ldexp(np.ldexp(xy, -mesh.exponent), mesh.exponent)
    left, right = mesh.faces_beside
    largest = float(np.abs(xy.reshape(-1, 2)[mesh.pieces[:, :2]]).max(initial=0.0))
    leaving, entering = np.empty((2, n_vertices + len(mesh.pieces)), np.int32)
    flaw = kernels.flaw(
        xy, whole.origin, whole.twin, mesh.piece_of, whole.n_triangles, mesh.pieces, keep[left] | keep[right],
        _ROUNDING * largest, leaving, entering, whole.scratch.work,
    )  # fmt: skip
    if flaw != kernels.SOUND:
        raise GenerationFailed(f"the triangulation {_FLAWS[flaw]}; please report the input")
