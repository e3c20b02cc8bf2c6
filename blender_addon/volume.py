# SPDX-License-Identifier: GPL-3.0-or-later
"""Volume cells in Blender, which knows faces only: kept beside a mesh that shows their surface, or a cut.

All points are vertices of the Blender mesh. The cells are ID properties of it, int32 arrays by kind, so they are saved
with the file, as are sets of cells; the faces shown tell by their attribute "cell" which cell they belong to. Named
sides, which are sets of faces, are vertex groups too.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import bpy
import numpy as np

if TYPE_CHECKING:
    from meshcore import Mesh

CELLS, CELL_DATA, POINTS = "meshcore_cells", "meshcore_cell_data", "meshcore_points"
SETS = "meshcore_sets"
OWNER = "cell"
FACES = ("triangle", "quad", "triangle6", "quad8", "quad9")


def store(data: Any, mesh: Mesh) -> list[str]:
    """Keep the cells of ``mesh`` in a Blender mesh that has its points, and show their surface."""
    from . import convert

    data[POINTS] = mesh.n_points
    data[CELLS] = {kind: nodes.astype(np.int32).ravel() for kind, nodes in mesh.cells.items() if len(nodes)}
    numbers = {name: _storable(values) for name, values in mesh.cell_data.items() if values.dtype.kind in "iufb"}
    data[CELL_DATA] = {name[:63]: values.ravel() for name, values in numbers.items()}
    data[SETS] = {name[:63]: members.astype(np.int32) for name, members in mesh.sets.items() if len(members)}
    show(data, mesh, np.ones(mesh.n_cells, bool))
    lost = [f"cell data {name!r} are no numbers and are left out" for name in mesh.cell_data if name not in numbers]
    return lost + convert.add_data(data, "POINT", mesh.point_data)


def _storable(values: np.ndarray) -> np.ndarray:
    return values.astype(np.float64 if values.dtype.kind == "f" else np.int32)


def kinds(data: Any) -> set[str]:
    """Kinds of the volume cells kept in a Blender mesh; none if it keeps none."""
    return set(data[CELLS].keys()) if CELLS in data else set()


def stored(data: Any) -> Mesh | None:
    """The volume mesh kept in a Blender mesh, in its local coordinates; None without one.

    Raises
    ------
    ReadingFailed
        If vertices were added or removed since: the cells would refer to wrong ones.
    """
    if CELLS not in data:
        return None
    from meshcore import Mesh
    from meshcore.mesh import CELL_TYPES

    from . import convert

    if len(data.vertices) != data[POINTS]:
        raise convert.ReadingFailed(
            f"{data.name} had {data[POINTS]} vertices when its cells were made and has {len(data.vertices)} now; "
            "undo that edit or make the mesh again"
        )
    cells = {kind: np.array(flat, np.int64).reshape(-1, CELL_TYPES[kind].nodes) for kind, flat in data[CELLS].items()}
    n = sum(map(len, cells.values()))
    cell_data = {name: _shaped(np.array(flat), n) for name, flat in data[CELL_DATA].items()}
    points = convert.array(data.vertices, "co", np.float32, 3).astype(float)
    sets = {name: np.array(members) for name, members in data[SETS].items()} if SETS in data else {}
    return Mesh(points, cells, point_data=convert.attributes(data, "POINT"), cell_data=cell_data, sets=sets)


def sides(mesh: Mesh) -> dict[str, list[int]]:
    """The vertices of each set that has none but faces of a volume mesh, by name; none of other meshes."""
    if mesh.dimension < 3:
        return {}
    found = {}
    for name, members in mesh.sets.items():
        nodes, count = [np.empty(0, np.int64)], 0
        for kind, cells, where in mesh.blocks():
            if kind in FACES:
                some = members[(members >= where.start) & (members < where.stop)] - where.start
                nodes.append(cells[some].ravel())
                count += len(some)
        if count == len(members) > 0:
            found[name] = np.unique(np.concatenate(nodes)).tolist()
    return found


def is_solid(mesh: Mesh) -> np.ndarray:
    """(number of cells,) bool: which cells are volumes."""
    solid = np.zeros(mesh.n_cells, bool)
    for kind, _, where in mesh.blocks():
        solid[where] = kind not in ("vertex", "line", *FACES)
    return solid


def _shaped(flat: np.ndarray, n: int) -> np.ndarray:
    return flat if len(flat) == n else flat.reshape(n, -1)


def show(data: Any, mesh: Mesh, keep: np.ndarray) -> None:
    """Make the faces of a Blender mesh the surface of some of its cells, each face's owner in "cell"."""
    from . import convert

    number = np.flatnonzero(keep & is_solid(mesh))
    nodes, owner = _surface(mesh, number)
    _clear_faces(data, mesh)
    convert.add_faces(data, [nodes[k] for k in nodes])
    faces = {OWNER: owner.astype(np.int32)}
    faces |= {name: values[owner] for name, values in mesh.cell_data.items() if values.dtype.kind in "iufb"}
    convert.add_data(data, "FACE", faces)


def _surface(mesh: Mesh, number: np.ndarray) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Facets of only one of the cells ``number``, as nodes by kind, and the cell of each."""
    from meshcore import Mesh

    chosen = np.isin(np.arange(mesh.n_cells), number)
    cells = {kind: nodes[chosen[where]] for kind, nodes, where in mesh.blocks() if chosen[where].any()}
    surface = Mesh(mesh.points, cells).boundary
    return surface.cells, number[surface.cell_data["cell"]] if surface.n_cells else np.empty(0, int)


def _clear_faces(data: Any, mesh: Mesh) -> None:
    """Drop faces and edges; clearing drops the vertices and their attributes too, so they are put back."""
    from . import convert

    points = convert.array(data.vertices, "co", np.float32, 3)
    data.clear_geometry()
    convert.add_points(data, points)
    convert.add_data(data, "POINT", mesh.point_data)


def _groups(ob: Any) -> dict[str, dict[float, list[int]]]:
    """For each vertex group its vertices by their weight."""
    groups: dict[str, dict[float, list[int]]] = {group.name: {} for group in ob.vertex_groups}
    by_index = list(groups.values())
    for k, vertex in enumerate(ob.data.vertices if groups else ()):
        for one in vertex.groups:
            by_index[one.group].setdefault(one.weight, []).append(k)
    return groups


def _restore_groups(ob: Any, groups: dict[str, dict[float, list[int]]]) -> None:
    """Give an object its vertex groups back, which it loses with its geometry."""
    for name, weights in groups.items():
        group = ob.vertex_groups.get(name) or ob.vertex_groups.new(name=name)
        for weight, vertices in weights.items():
            group.add(vertices, weight, "REPLACE")


class MESHCORE_OT_cut_view(bpy.types.Operator):
    """Show the volume cells on one side of a plane only, to look inside; the cells themselves stay"""

    bl_idname = "meshcore.cut_view"
    bl_label = "Cut View"
    bl_options = {"REGISTER", "UNDO"}

    axis: bpy.props.EnumProperty(
        name="Axis", description="Normal of the plane, in the object's own axes", items=[(a, a, "") for a in "XYZ"]
    )
    position: bpy.props.FloatProperty(
        name="Position",
        description="Where the plane lies in the object's bounding box; at 1 all cells are shown",
        default=0.5,
        min=0,
        max=1,
        subtype="FACTOR",
    )
    other_side: bpy.props.BoolProperty(name="Other Side", description="Keep the cells beyond the plane instead")

    @classmethod
    def poll(cls, context: Any) -> bool:
        """A mesh with volume cells, in Object Mode."""
        ob = context.active_object
        if ob is None or ob.type != "MESH" or CELLS not in ob.data or ob.mode != "OBJECT":
            cls.poll_message_set("Select a mesh with volume cells made by meshcore, in Object Mode")
            return False
        return True

    def execute(self, context: Any) -> set[str]:
        """Rebuild the faces shown."""
        from .convert import ReadingFailed

        data = context.active_object.data
        try:
            mesh = stored(data)
        except ReadingFailed as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        axis = "XYZ".index(self.axis)
        low, high = mesh.bounds[:, axis]
        below = mesh.centroids[:, axis] <= low + self.position * (high - low)
        keep, solid = ~below if self.other_side else below, is_solid(mesh)
        groups = _groups(context.active_object)
        show(data, mesh, keep)
        _restore_groups(context.active_object, groups)
        self.report({"INFO"}, f"{int((keep & solid).sum()):,} of {int(solid.sum()):,} cells shown")
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory((MESHCORE_OT_cut_view,))
