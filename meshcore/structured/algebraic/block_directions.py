"""The three projections whose Boolean sum fills a block: what is known along i, j and k (survey 2.4.1)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import product

import numpy as np

from ...errors import InvalidInput
from .blending import NEAR, Direction, boolean_sum
from .block_faces import AXES, PLACES, BlockFaces, end
from .sides import fractions_of


def directions_of(
    block: BlockFaces,
    blending: str,
    slopes: Mapping[str, np.ndarray] | None,
    surfaces: Mapping[tuple[str, int], np.ndarray],
) -> list[Direction]:
    """The projections along i, j and k, between faces and surfaces inside; cubic ones with slopes at the faces.

    Slopes that are not given at all are those of linear blending, turned to right angles with the faces.
    """
    directions = _linear_or_smooth(block, blending, surfaces)
    if blending == "cubic" and slopes is None:
        linear = boolean_sum([replace(d, smooth=False) for d in directions])
        return [replace(d, slopes=_normal(d, axis, linear), reach=NEAR) for axis, d in enumerate(directions)]
    if not slopes:
        return directions
    if unknown := set(slopes) - set(PLACES):
        raise InvalidInput(f"{sorted(unknown)[0]!r} is no face", parameter="slopes")
    return [replace(d, slopes=_given(slopes, axis, d)) for axis, d in enumerate(directions)]


def _linear_or_smooth(
    block: BlockFaces, blending: str, surfaces: Mapping[tuple[str, int], np.ndarray]
) -> list[Direction]:
    shape = [len(block.edge(axis, 0, 0)) for axis in range(3)]
    known = [{0: block.faces[end(a, 0)], shape[a] - 1: block.faces[end(a, 1)]} for a in range(3)]
    for key, surface in surfaces.items():
        axis, index = key if isinstance(key, tuple) and len(key) == 2 else (key, None)
        if axis not in tuple(AXES) or not isinstance(index, (int, np.integer)):
            raise InvalidInput(f"{key!r} is no axis and index, such as ('i', 5)", parameter="surfaces")
        a = AXES.index(axis)
        if not 0 < index < shape[a] - 1:
            raise InvalidInput(f"{axis} = {index} is not between 0 and {shape[a] - 1}", parameter="surfaces")
        known[a][int(index)] = _array(surface, known[a][0].shape, "surfaces")
    directions = []
    for axis in range(3):
        lengths = [fractions_of(block.edge(axis, a, b)) for a, b in product((0, 1), repeat=2)]
        even = np.arange(shape[axis]) / (shape[axis] - 1)
        parameters = even if blending == "linear" else np.mean(lengths, axis=0)
        directions.append(Direction(parameters, known[axis], smooth=blending == "cubic"))
    return directions


def _array(values, shape: tuple[int, ...], parameter: str) -> np.ndarray:
    try:
        array = np.asarray(values, float)
    except (TypeError, ValueError):
        raise InvalidInput("needs arrays of numbers", parameter=parameter) from None
    if array.shape != shape or not np.isfinite(array).all():
        raise InvalidInput(f"needs finite arrays of shape {shape}, got {array.shape}", parameter=parameter)
    return array


def _given(slopes: Mapping[str, np.ndarray], axis: int, direction: Direction) -> dict[int, np.ndarray]:
    last = len(direction.parameters) - 1
    faces = ((0, end(axis, 0)), (last, end(axis, 1)))
    return {k: _array(slopes[name], direction.known[k].shape, "slopes") for k, name in faces if name in slopes}


def _normal(direction: Direction, axis: int, points: np.ndarray) -> dict[int, np.ndarray]:
    """The steps of linear blending across the faces at both ends, turned to right angles with them."""
    layers = np.moveaxis(points, axis, 0)
    found = {}
    for k, step in ((0, layers[1] - layers[0]), (len(layers) - 1, layers[-1] - layers[-2])):
        face = direction.known[k]
        normal = np.cross(np.gradient(face, axis=0), np.gradient(face, axis=1))
        size = np.linalg.norm(normal, axis=-1)
        normal /= np.where(size > 0, size, 1.0)[..., None]
        length = np.linalg.norm(step, axis=-1)
        found[k] = (np.sign((step * normal).sum(axis=-1)) * length)[..., None] * normal
    return found
