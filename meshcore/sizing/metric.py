"""Metrics: size, stretching and its directions as symmetric positive-definite matrices.

The survey's mesh parameters at a point are the node spacing delta, stretchings s and their directions alpha (3.2.3).
As a metric M they measure an edge e by sqrt(e M e): 1 for length s delta along alpha, and for length delta across.
Generators that know no directions take `smallest_sizes`, and the metric stays in ``point_data`` for those that do.
"""

from __future__ import annotations

import numpy as np

from ..errors import InvalidInput
from ..geometry.location import Locator
from ..mesh import Mesh
from .background import checked_sizes

# Squares of sizes beyond these would leave the doubles.
_SMALLEST, _LARGEST = 1e-100, 1e100


def metric(size: np.ndarray, stretching: np.ndarray = 1.0, direction: np.ndarray | None = None) -> np.ndarray:
    """Metrics from node spacings, stretchings and their directions.

    Parameters
    ----------
    size : (n,) float
        Node spacing delta, across the stretching.
    stretching : (n,) or (n, k) float
        Factors s: along its direction the spacing is ``s * size``.
    direction : (n, 3) or (n, k, 3) float, optional
        Directions alpha of any length, those of one point at right angles; all arguments may be given once for all
        points.

    Returns
    -------
    (n, 3, 3) float
        Symmetric and positive definite, with eigenvalues ``1 / spacing^2``.

    Raises
    ------
    InvalidInput
        If sizes or stretchings are not between 1e-100 and 1e100, directions are zero or not at right angles.

    References
    ----------
    Survey, section 3.2.3. J. Peraire, M. Vahdati, K. Morgan, O. C. Zienkiewicz, "Adaptive remeshing for compressible
    flow computations", J. Comput. Phys. 72 (1987).

    Examples
    --------
    >>> metric(0.5, 4.0, [0, 2, 0])
    array([[[4.  , 0.  , 0.  ],
            [0.  , 0.25, 0.  ],
            [0.  , 0.  , 4.  ]]])
    """
    size = np.atleast_1d(np.asarray(size, float))
    stretching = np.asarray(stretching, float)
    stretching = stretching.reshape(-1, 1) if stretching.ndim < 2 else stretching
    if direction is None:
        if (stretching != 1).any():
            raise InvalidInput("a stretching needs a direction", parameter="direction")
        direction = np.tile(np.eye(3)[:1], (1, stretching.shape[1], 1))
    direction = np.asarray(direction, float)
    direction = np.atleast_2d(direction)[:, None] if direction.ndim < 3 else direction
    if direction.shape[1:] != (stretching.shape[1], 3):
        raise InvalidInput(
            f"needs shape (n, {stretching.shape[1]}, 3), one direction a stretching, got {direction.shape}",
            parameter="direction",
        )
    for name, values in (("size", size), ("stretching", stretching), ("stretching", stretching * size[:, None])):
        if not ((values > _SMALLEST) & (values < _LARGEST)).all():
            bad = values[~((values > _SMALLEST) & (values < _LARGEST))][0]
            raise InvalidInput(f"must be between {_SMALLEST:g} and {_LARGEST:g}, got {bad:g}", parameter=name)
    length = np.linalg.norm(direction, axis=2, keepdims=True)
    if not (np.isfinite(length) & (length > 0)).all():
        raise InvalidInput("directions must be finite and longer than zero", parameter="direction")
    unit = direction / length
    products = np.einsum("nkx,nlx->nkl", unit, unit) - np.eye(unit.shape[1])
    if (np.abs(products) > 1e-6).any():
        raise InvalidInput("directions of one point must be at right angles", parameter="direction")
    across = 1 / size**2
    along = 1 / (stretching * size[:, None]) ** 2 - across[:, None]
    return across[:, None, None] * np.eye(3) + np.einsum("nk,nkx,nky->nxy", along, unit, unit)


def spacings(metrics: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Spacings along the principal directions of metrics, smallest first, and these directions.

    Parameters
    ----------
    metrics : (n, 3, 3) float
        Symmetric positive-definite matrices.

    Returns
    -------
    sizes : (n, 3) float
        Lengths that measure 1.
    directions : (n, 3, 3) float
        Unit vectors; row k is the direction of size k.

    Raises
    ------
    InvalidInput
        If a matrix is not symmetric and positive definite.

    Examples
    --------
    >>> sizes, directions = spacings(metric(0.5, 4.0, [0, 2, 0]))
    >>> sizes, np.abs(directions[0, 2])
    (array([[0.5, 0.5, 2. ]]), array([0., 1., 0.]))
    """
    values, vectors = _decomposed(metrics)
    return 1 / np.sqrt(values[:, ::-1]), vectors.transpose(0, 2, 1)[:, ::-1]


def _decomposed(metrics: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues in ascending order, and the matrices whose columns are the eigenvectors."""
    metrics = np.asarray(metrics, float)
    if metrics.shape[-2:] != (3, 3):
        raise InvalidInput(f"needs shape (n, 3, 3), got {metrics.shape}", parameter="metrics")
    scale = np.abs(metrics).max(axis=(-2, -1), initial=0.0)
    even = np.abs(metrics - np.swapaxes(metrics, -1, -2)).max(axis=(-2, -1)) <= 1e-9 * scale
    if not (np.isfinite(scale) & even).all():
        bad = np.argwhere(~(np.isfinite(scale) & even))[0]
        raise InvalidInput(f"metric {bad.tolist()} is not finite and symmetric", parameter="metrics")
    values, vectors = np.linalg.eigh(metrics / np.where(scale > 0, scale, 1)[..., None, None])
    if not (values > 0).all():
        bad = np.argwhere(~(values > 0).all(axis=-1))[0]
        raise InvalidInput(f"metric {bad.tolist()} is not positive definite", parameter="metrics")
    return values * scale[..., None], vectors


def evaluated_metrics(metrics: np.ndarray, points: np.ndarray, parameter: str = "size_field") -> np.ndarray:
    """(m, 3, 3) float: what a field of metrics returned at (m, 3) points, checked.

    Raises
    ------
    InvalidInput
        If there is not one 3 x 3 matrix a point, or one is not finite, symmetric and positive definite; it says where.

    Examples
    --------
    >>> evaluated_metrics(np.tile(4 * np.eye(3), (2, 1, 1)), np.zeros((2, 3))).shape
    (2, 3, 3)
    """
    metrics = np.asarray(metrics, float)
    if metrics.shape != (len(points), 3, 3):
        raise InvalidInput(
            f"must return shape ({len(points)}, 3, 3), one metric a point, got {metrics.shape}", parameter=parameter
        )
    scale = np.abs(metrics).max(axis=(1, 2), initial=0.0)
    finite = np.isfinite(scale)
    with np.errstate(invalid="ignore"):  # infinite ones were found already
        symmetric = np.abs(metrics - metrics.transpose(0, 2, 1)).max(axis=(1, 2)) <= 1e-9 * scale
    definite = _positive_definite(metrics / np.where(finite & (scale > 0), scale, 1)[:, None, None])
    faults = (
        (~finite, "is not finite"),
        (~symmetric, "is not symmetric"),
        (~definite, "is not positive definite; its eigenvalues are 1 / spacing^2, greater than zero"),
        (
            ~((scale >= _LARGEST**-2) & (scale <= _SMALLEST**-2)),
            f"asks for spacings beyond {_SMALLEST:g} to {_LARGEST:g}",
        ),
    )
    for faulty, fault in faults:
        if faulty.any():
            at = int(faulty.argmax())
            place = ", ".join(f"{x:.6g}" for x in points[at])
            raise InvalidInput(f"the metric {metrics[at].tolist()} at ({place}) {fault}", parameter=parameter)
    return metrics


def _positive_definite(metrics: np.ndarray) -> np.ndarray:
    """(n,) bool: whether the pivots of each matrix are greater than zero; far cheaper than eigenvalues."""
    (a, b, c), (d, e), f = metrics[:, 0].T, metrics[:, 1, 1:].T, metrics[:, 2, 2]
    with np.errstate(all="ignore"):
        second = d - b * b / a
        third = f - c * c / a - (e - b * c / a) ** 2 / second
    return (a > 0) & (second > 0) & (third > 0)


def _composed(values: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    return np.einsum("...xk,...k,...yk->...xy", vectors, values, vectors)


def interpolated(metrics: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Means of metrics, by the mean of their logarithms.

    This keeps them positive definite, commutes with inversion, and between sizes of one direction it is the geometric
    mean, so that neither end is favoured.

    Parameters
    ----------
    metrics : (n, k, 3, 3) float
        Metrics at k corners.
    weights : (n, k) float
        Their weights, with the sum 1.

    Returns
    -------
    (n, 3, 3) float

    Raises
    ------
    InvalidInput
        If a matrix is not symmetric and positive definite.

    References
    ----------
    V. Arsigny, P. Fillard, X. Pennec, N. Ayache, "Log-Euclidean metrics for fast and simple calculus on diffusion
    tensors", Magn. Reson. Med. 56 (2006).

    Examples
    --------
    >>> ends = np.array([metric([0.1, 0.4])])
    >>> spacings(interpolated(ends, np.array([[0.5, 0.5]])))[0].round(9)
    array([[0.2, 0.2, 0.2]])
    """
    values, vectors = _decomposed(metrics)
    mean = np.einsum("nkxy,nk->nxy", _composed(np.log(values), vectors), np.asarray(weights, float))
    values, vectors = np.linalg.eigh(mean)
    return _composed(np.exp(values), vectors)


def intersection(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Metrics that ask for no larger spacing in any direction than both of two metrics do.

    In the common basis in which both are diagonal, the larger eigenvalue counts.

    Parameters
    ----------
    first, second : (n, 3, 3) float
        Symmetric positive-definite matrices.

    Returns
    -------
    (n, 3, 3) float

    Raises
    ------
    InvalidInput
        If a matrix is not symmetric and positive definite.

    References
    ----------
    F. Alauzet, P. J. Frey, "Estimateur d'erreur geometrique et metriques anisotropes pour l'adaptation de maillage",
    INRIA report 4759 (2003).

    Examples
    --------
    >>> both = intersection(metric(1.0, 0.1, [1, 0, 0]), metric(1.0, 0.2, [0, 1, 0]))
    >>> spacings(both)[0].round(9)
    array([[0.1, 0.2, 1. ]])
    """
    values, vectors = _decomposed(first)
    root = _composed(np.sqrt(values), vectors)
    inverse = _composed(1 / np.sqrt(values), vectors)
    _decomposed(second)
    common, basis = np.linalg.eigh(inverse @ np.asarray(second, float) @ inverse)
    return root @ _composed(np.maximum(common, 1.0), basis) @ root


def lengths(start: np.ndarray, stop: np.ndarray, at_start: np.ndarray, at_stop: np.ndarray) -> np.ndarray:
    """Lengths of edges in metrics that vary along them.

    With the lengths a and b of the edge in the metrics at its ends, the size between them varies geometrically, and the
    integral is ``(a - b) / log(a / b)``.

    Parameters
    ----------
    start, stop : (n, 3) float
        Ends of the edges.
    at_start, at_stop : (n, 3, 3) float
        Metrics there.

    Returns
    -------
    (n,) float
        1 where an edge is as long as wanted.

    References
    ----------
    F. Alauzet, "Size gradation control of anisotropic meshes", Finite Elem. Anal. Des. 46 (2010).

    Examples
    --------
    >>> lengths(np.zeros((1, 3)), np.array([[1.0, 0, 0]]), metric(0.5), metric(0.5))
    array([2.])
    """
    edge = np.asarray(stop, float) - np.asarray(start, float)
    a, b = (np.sqrt(np.maximum(np.einsum("nx,nxy,ny->n", edge, m, edge), 0)) for m in (at_start, at_stop))
    mean = 0.5 * (a + b)
    ratio = np.divide(a - b, mean, out=np.zeros(len(mean)), where=mean > 0)
    # (a - b) / log(a / b) = mean * x / artanh(x), x = (a - b) / (a + b); by its series where that is 0 / 0.
    x = np.clip(0.5 * ratio, -1 + 1e-16, 1 - 1e-16)
    small = np.abs(x) < 1e-4
    return mean * np.where(small, 1 - x * x / 3, np.where(small, 1.0, x) / np.arctanh(np.where(small, 0.5, x)))


def metric_field(mesh: Mesh, metrics: str | np.ndarray):
    """A field of metrics on a background mesh: `interpolated` inside its cells, the nearest place outside.

    Parameters
    ----------
    mesh : Mesh
        Triangles and quads in a plane, or tetrahedra.
    metrics : str or (n, 3, 3) float
        Name of a point array of shape (n, 3, 3) or (n, 9), or the metrics; a plain size a point counts in all
        directions.

    Returns
    -------
    callable
        Takes (m, 3) points, returns (m, 3, 3) metrics.

    Raises
    ------
    InvalidInput
        If there is no such array, or a matrix is not symmetric and positive definite.

    Examples
    --------
    >>> from meshcore.gallery import triangulated_square
    >>> square = triangulated_square(2)
    >>> square = square.with_point_data(metric=metric(0.1 + square.points[:, 0], 3.0, [0, 1, 0]))
    >>> field = metric_field(square, "metric")
    >>> spacings(field(np.array([[0.5, 0.2, 0.0]])))[0].round(6)
    array([[0.6, 0.6, 1.8]])
    """
    values = mesh.point_data.get(metrics) if isinstance(metrics, str) else np.asarray(metrics, float)
    if isinstance(metrics, str) and (values is None or values.size != 9 * mesh.n_points):
        values = metric(checked_sizes(mesh, metrics, "metrics"))  # also says what is missing
    values = np.asarray(values, float).reshape(-1, 3, 3)
    values, vectors = _decomposed(values)
    logarithms = _composed(np.log(values), vectors)
    locator = Locator(mesh)

    def field(points: np.ndarray) -> np.ndarray:
        values, vectors = np.linalg.eigh(locator.interpolated(logarithms, points))
        return _composed(np.exp(values), vectors)

    return field


def smallest_sizes(metrics: np.ndarray) -> np.ndarray:
    """(n,) float: the smallest spacing in any direction, for generators that know no directions.

    Parameters
    ----------
    metrics : (n, 3, 3) float
        Symmetric positive-definite matrices.

    Examples
    --------
    >>> smallest_sizes(metric(0.5, 4.0, [0, 2, 0]))
    array([0.5])
    """
    return spacings(metrics)[0][:, 0]
