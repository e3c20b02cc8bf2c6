"""What operations that march layers ask alike: their parameters, each declared once, and the heights these mean."""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np

from ...operation import Length, Param, Relative, absolute
from .layer_heights import layer_heights

FirstHeightParam = Annotated[Length, Param("Height of the first layer", group="Layers")]
GrowthParam = Annotated[
    float, Param("Height of each layer over the one before", min=1, max=3, soft_max=1.5, group="Layers")
]
LayersParam = Annotated[
    int | None, Param("Layers; by default as many as the distance needs", min=1, soft_max=500, group="Layers")
]
DistanceParam = Annotated[
    Length | None, Param("Sum of the heights; by default the surface's own size, or what layers make", group="Layers")
]
LargestHeightParam = Annotated[
    Length | None, Param("Heights grow up to this; by default without limit", group="Layers")
]
SplayParam = Annotated[
    float, Param("By how much edges that splay lean outwards", min=0, max=80, unit="degree", group="Edges")
]


def asked_heights(
    first_height: Length,
    growth: float,
    layers: int | None,
    distance: Length | None,
    largest_height: Length | None,
    *,
    diagonal: float,
) -> np.ndarray:
    """(layers,) float: heights as the parameters ask for them; lengths may be relative to ``diagonal``.

    Examples
    --------
    >>> asked_heights(0.1, 2.0, 3, None, None, diagonal=1.0)
    array([0.1, 0.2, 0.4])
    """
    if layers is None and distance is None:
        distance = Relative(1.0)
    return layer_heights(
        absolute(first_height, diagonal),
        growth,
        layers=layers,
        distance=None if distance is None else absolute(distance, diagonal),
        largest=math.inf if largest_height is None else absolute(largest_height, diagonal),
    )
