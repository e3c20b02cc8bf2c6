"""The README's picture can be drawn without a display, and shows a grid."""

from __future__ import annotations

import bpy
import numpy as np

from tests.blender.picture import render


def test_picture_shows_colours_edges_and_the_section(installed, tmp_path):
    file = render(tmp_path / "small.png", size=(160, 100), samples=2)
    image = bpy.data.images.load(str(file))
    pixels = np.array(image.pixels[:]).reshape(100, 160, 4)[:, :, :3]
    assert (pixels[45:55, 60:100] > 0.95).all(axis=2).any()  # through the section one sees the white behind
    assert (pixels[:, :, 2] - pixels[:, :, 0] > 0.2).mean() > 0.3  # most cells are good
    assert pixels.reshape(-1, 3).std(axis=0).min() > 0.05
