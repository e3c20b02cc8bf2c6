"""Size fields on a background mesh: sizes at its points, linear between them (survey, 3.2.3)."""

from __future__ import annotations

import numpy as np

from ..errors import InvalidGeometry, InvalidInput
from ..geometry.location import Locator
from ..mesh import Mesh
from .size_field import SizeField


def background_field(mesh: Mesh, sizes: str | np.ndarray, *, parameter: str = "background") -> SizeField:
    """A size field given by the sizes at the points of a background mesh.

    Inside a cell sizes are interpolated linearly between its corners; outside the mesh, the nearest place of it
    counts. The background can be one large triangle, a coarse mesh, or the mesh of an earlier computation, whose error
    says how large the next one's cells may be.

    Parameters
    ----------
    mesh : Mesh
        Triangles and quads in a plane, or tetrahedra.
    sizes : str or (n,) float
        Name of a point array, or a size for each point; finite and greater than zero where there are cells.
    parameter : str
        What errors call the mesh.

    Returns
    -------
    SizeField
        Called with (m, 3) points; a million of them on a million cells take seconds.

    Raises
    ------
    InvalidInput
        If there is no such array, it has not one number a point, or the mesh has other cells.
    InvalidGeometry
        If a size is not finite or not greater than zero; it names where.

    References
    ----------
    Survey, section 3.2.3. J. Peraire, M. Vahdati, K. Morgan, O. C. Zienkiewicz, "Adaptive remeshing for compressible
    flow computations", J. Comput. Phys. 72 (1987).

    Examples
    --------
    >>> triangle = Mesh([[-9, -9], [9, -9], [0, 9]], {"triangle": [[0, 1, 2]]}, {"size": [0.1, 0.1, 1.0]})
    >>> field = background_field(triangle, "size")
    >>> field(np.array([[0.0, 0.0, 0.0], [0.0, 20.0, 0.0]])).round(6)
    array([0.55, 1.  ])
    """
    values = checked_sizes(mesh, sizes, parameter)
    locator = Locator(mesh, parameter)
    return lambda points: locator.interpolated(values, points)


def sizes_at_points(mesh: Mesh, name: str, parameter: str = "size_array") -> np.ndarray:
    """(n,) float: a point array by name, if it can be a size at all.

    Raises
    ------
    InvalidInput
        If there is none of this name, or it has not one number a point; the message lists what there is.

    Examples
    --------
    >>> sizes_at_points(Mesh([[0, 0]], {}, {"h": [2]}), "h")
    array([2.])
    """
    if name not in mesh.point_data:
        there = ", ".join(mesh.point_data) or "none"
        hint = "; it is an array on cells: convert it to points" if name in mesh.cell_data else ""
        raise InvalidInput(f"there is no point array {name!r}{hint}; there are: {there}", parameter=parameter)
    values = mesh.point_data[name]
    if values.dtype.kind not in "iufb" or values.size != mesh.n_points:
        raise InvalidInput(
            f"point array {name!r} has {values.dtype} of shape {values.shape}; a size is one number a point",
            parameter=parameter,
        )
    return values.reshape(-1).astype(float)


def checked_sizes(mesh: Mesh, sizes: str | np.ndarray, parameter: str = "sizes") -> np.ndarray:
    """(n,) float: sizes at a mesh's points, all of those that cells use finite and greater than zero.

    Raises
    ------
    InvalidInput
        If there is no such array, or not one number a point.
    InvalidGeometry
        If a size is not finite or not greater than zero; it names the point and its place.

    Examples
    --------
    >>> checked_sizes(Mesh([[0, 0], [1, 0]], {"line": [[0, 1]]}), [1, 2])
    array([1., 2.])
    """
    if not isinstance(mesh, Mesh):
        raise InvalidInput(f"needs a Mesh, got {type(mesh).__name__}", parameter=parameter)
    if isinstance(sizes, str):
        what = f"point array {sizes!r}"
        values = sizes_at_points(mesh, sizes, parameter)
    else:
        what = "the size"
        try:
            values = np.array(sizes, dtype=np.float64)
        except (TypeError, ValueError):
            raise InvalidInput("needs a number for each point of the mesh", parameter=parameter) from None
        if values.shape != (mesh.n_points,):
            raise InvalidInput(
                f"needs one size a point, that is shape ({mesh.n_points},), got {values.shape}", parameter=parameter
            )
    used = np.zeros(mesh.n_points, bool)
    for cells in mesh.cells.values():
        used[cells] = True
    bad = np.flatnonzero(used & ~(np.isfinite(values) & (values > 0)))
    if len(bad):
        place = ", ".join(f"{x:.6g}" for x in mesh.points[bad[0]])
        more = f" ({len(bad):,} points in all)" if len(bad) > 1 else ""
        raise InvalidGeometry(
            f"{what} is {values[bad[0]]:g} at point {bad[0]}, ({place}){more}; sizes must be finite and greater than "
            "zero",
            parameter=parameter,
            points=bad,
        )
    values[~used] = np.where(np.isfinite(values[~used]), values[~used], np.inf)
    return values


def only_array(background: Mesh) -> str:
    """The name of a background's one array that can be a size.

    Raises
    ------
    InvalidInput
        If there is none, or more than one.

    Examples
    --------
    >>> only_array(Mesh([[0, 0]], {}, {"h": [0.5], "velocity": [[1.0, 0.0]]}))
    'h'
    """
    there = background.point_data if isinstance(background, Mesh) else {}
    usable = [name for name, v in there.items() if v.dtype.kind in "fiu" and v.size == background.n_points]
    if isinstance(background, Mesh) and len(usable) != 1:
        names = ", ".join(usable or there) or "none"
        raise InvalidInput(
            f"name the point array of the background that holds the sizes; there are: {names}", parameter="size_array"
        )
    return usable[0] if usable else ""
