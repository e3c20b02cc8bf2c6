"""What reports tell of layers is measured on the grid."""

import numpy as np
import pytest

import meshcore as mc
from meshcore import gallery
from meshcore.structured.layer_report import layers_told

TOLD = ("first height", "least first height / asked", "largest first height / asked", "largest growth", "total height")


def _calls():
    nose, sharp = gallery.airfoil("naca0012"), gallery.airfoil("rae2822")
    for method in ("transfinite", "elliptic", "hyperbolic", "parabolic"):
        yield mc.c_grid, (sharp,), {"method": method, "radius": 4}
        yield mc.o_grid, (nose,), {"method": method, "radius": 4}
    yield mc.hyperbolic, (nose,), {"first_height": 1e-3, "layers": 30}
    yield mc.parabolic, (nose, gallery.circle(48, radius=2.0, centre=(0.5, 0.0))), {"first_height": 1e-3}


@pytest.mark.parametrize(("call", "inputs", "keywords"), [*_calls()])
def test_heights_and_growth_are_those_of_the_grid(call, inputs, keywords):
    grid, report = call(*inputs, **keywords)
    wake = report.counts.get("wake", 0)
    lines = grid.points[wake : grid.shape[0] - wake, :, 0]
    height = np.linalg.norm(np.diff(lines, axis=1), axis=-1)
    asked = keywords.get("first_height", 0.001 * inputs[0].diagonal)
    share = height[:, 0] / asked
    found = [asked, share.min(), share.max(), (height[:, 1:] / height[:, :-1]).max(), height.sum(axis=1).mean()]
    told = [report.quality[name] for name in TOLD]
    assert told[:4] == pytest.approx(found[:4], rel=1e-9)
    assert told[4] == pytest.approx(found[4], rel=1e-2)  # closed grids hold their cut's line twice
    angle = mc.quality.line_angle(grid)[:, 1:-1].min()
    assert report.quality["worst skew of lines (degree)"] == pytest.approx(90 - angle)


def test_layers_off_a_surface_tell_the_same():
    grid, report = mc.hyperbolic_volume(gallery.six_patches(), first_height=0.01, layers=10)
    heights = [np.linalg.norm(np.diff(block.points, axis=2), axis=-1) for block in grid.blocks]
    assert report.quality["first height"] == 0.01
    assert report.quality["largest growth"] == pytest.approx(max((h[..., 1:] / h[..., :-1]).max() for h in heights))
    assert report.quality["least first height / asked"] == pytest.approx(min(h[..., 0].min() for h in heights) / 0.01)


def test_a_single_layer_has_no_growth():
    told = layers_told(np.array([[[0.0, 0.0], [0.0, 0.1]]]), 0.2)
    assert told["largest growth"] == 1.0 and told["least first height / asked"] == 0.5
