"""Model inputs, used alike by tests, examples, benchmarks, `meshcore warmup` and the hosts' round trips."""

from .calls import arguments, warm_up
from .planar import (
    airfoil,
    airfoil_in_far_field,
    airfoils,
    circle,
    joined,
    l_shape,
    rough_ring,
    square,
    square_with_hole,
    sunflower,
    triangulated_square,
    wavy_sides,
)
from .surfaces import bumpy_ball, bumpy_torus, on_bumpy_torus, rough_tube, sides_on_torus, six_patches, wing_tip
from .volumes import blade_row, bricks, cloud_in_a_ball, dented_box, turbine_passage, twisted_cage

__all__ = [
    "airfoil",
    "airfoil_in_far_field",
    "airfoils",
    "arguments",
    "blade_row",
    "bricks",
    "bumpy_ball",
    "bumpy_torus",
    "circle",
    "cloud_in_a_ball",
    "dented_box",
    "joined",
    "l_shape",
    "on_bumpy_torus",
    "rough_ring",
    "rough_tube",
    "sides_on_torus",
    "six_patches",
    "square",
    "square_with_hole",
    "sunflower",
    "triangulated_square",
    "turbine_passage",
    "twisted_cage",
    "warm_up",
    "wavy_sides",
    "wing_tip",
]
