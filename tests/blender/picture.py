"""The README's picture of Blender: an O-grid around an airfoil, faces coloured by quality, rendered without a display.

Usage, with a Python that has bpy, and an empty folder for Blender's settings:
``BLENDER_USER_RESOURCES=$(mktemp -d) python -m tests.blender.picture ZIP docs/pictures/blender.png``.
"""

from __future__ import annotations

import sys
from pathlib import Path

import bpy
import numpy as np

SIZE = (800, 470)


def o_grid_of_airfoil():
    """An airfoil as a mesh of edges, and the operator's grid around it."""
    from meshcore import gallery

    section = gallery.airfoil()
    data = bpy.data.meshes.new("Airfoil")
    data.from_pydata(section.points.tolist(), section.get("line").tolist(), [])
    ob = bpy.data.objects.new("Airfoil", data)
    bpy.context.scene.collection.objects.link(ob)
    bpy.context.view_layer.objects.active = ob
    bpy.context.view_layer.update()
    bpy.ops.meshcore.o_grid(radius=1.6, first_height=0.008, growth=1.18)
    ob.hide_render = True
    return bpy.context.view_layer.objects.active


def glowing(name, colour=(0, 0, 0, 1)):
    """A material that needs no lamp; its nodes, links and emission, for what is to colour it."""
    material = bpy.data.materials.new(name)
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    light, output = nodes.new("ShaderNodeEmission"), nodes.new("ShaderNodeOutputMaterial")
    light.inputs["Color"].default_value = colour
    links.new(light.outputs["Emission"], output.inputs["Surface"])
    return material, light


def colour_by_quality(ob):
    """A material of the face attribute "quality", red to blue, and dark lines along the edges."""
    quality, light = glowing("quality")
    nodes, links = quality.node_tree.nodes, quality.node_tree.links
    attribute, ramp = nodes.new("ShaderNodeAttribute"), nodes.new("ShaderNodeValToRGB")
    attribute.attribute_name = "quality"
    ramp.color_ramp.elements[0].position, ramp.color_ramp.elements[0].color = 0.45, (0.80, 0.12, 0.03, 1)
    ramp.color_ramp.elements[1].position, ramp.color_ramp.elements[1].color = 1.0, (0.05, 0.22, 0.50, 1)
    ramp.color_ramp.elements.new(0.85).color = (0.55, 0.75, 0.72, 1)
    links.new(attribute.outputs["Fac"], ramp.inputs["Fac"])
    links.new(ramp.outputs["Color"], light.inputs["Color"])
    ob.data.materials.append(quality)
    ob.data.materials.append(glowing("edges", (0.01, 0.01, 0.02, 1))[0])
    wire = ob.modifiers.new("edges", "WIREFRAME")
    wire.use_replace, wire.use_relative_offset = False, True
    wire.thickness, wire.material_offset = 0.035, 1


def render(path: Path, size: tuple[int, int] = SIZE, samples: int = 16) -> Path:
    """Render the grid from obliquely above."""
    ob = o_grid_of_airfoil()
    colour_by_quality(ob)
    scene = bpy.context.scene
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.collection.objects.link(camera)
    camera.location, camera.rotation_euler = (0.5, -1.15, 1.35), (np.radians(41), 0, 0)
    camera.data.lens = 36
    scene.camera = camera
    scene.world = scene.world or bpy.data.worlds.new("World")
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (1, 1, 1, 1)
    scene.view_settings.view_transform = "Standard"
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.device = samples, False, "CPU"
    scene.render.resolution_x, scene.render.resolution_y = size
    scene.render.image_settings.file_format = "PNG"
    scene.render.image_settings.color_mode = "RGB"
    scene.render.image_settings.compression = 100
    scene.render.dither_intensity = 0
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    return path


if __name__ == "__main__":
    bpy.ops.extensions.package_install_files(filepath=sys.argv[1], repo="user_default", enable_on_install=True)
    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.object.delete()
    render(Path(sys.argv[2]).resolve())
