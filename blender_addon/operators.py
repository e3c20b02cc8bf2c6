# SPDX-License-Identifier: GPL-3.0-or-later
"""One operator for each operation, made from the declarations; all share `OperationBase`.

Pressed in the interface, an operator computes in a thread of its own while the window stays alive: the status bar
tells how far it is and Esc cancels. Called from a script or from the redo panel, it computes at once. Blender's data
are read before and written after, always in the main thread.
"""

from __future__ import annotations

import functools
import sys
import traceback
from typing import Any

import bpy
import numpy as np

from . import inputs, properties, results, selection
from .convert import ReadingFailed, Source
from .jobs import COMPILING, Job

PREFIX = "meshcore."
QUICK = 0.25
"""Seconds that the window waits for a result before it becomes a background job."""
# Looking around goes on while a job runs; what could change the scene under it does not.
_LOOKING = ("MOUSEMOVE", "INBETWEEN_MOUSEMOVE", "MIDDLEMOUSE", "WHEEL", "TRACKPAD", "NDOF", "WINDOW_DEACTIVATE")


class OperationBase:
    """What the operators of all operations have in common; `bpy.types.Operator` is mixed in below it.

    Attributes
    ----------
    identifier : str
        The operation's name in meshcore's registry.
    declaration : dict
        Its label, inputs and parameters.
    """

    identifier = ""
    declaration: dict[str, Any] = {}

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Whether what is selected can be an input; if not, the tooltip says what to select."""
        if text := inputs.problem(context, cls.declaration):
            cls.poll_message_set(text)
            return False
        return True

    def invoke(self, context: Any, event: Any) -> set[str]:
        """Fill in lengths that depend on the input, and compute in the background."""
        try:
            self._sources = inputs.gather(context, self.declaration, self._chosen(), self._arrays())
            self._fill_lengths()
            self._job = Job(self._call(context))
        except Exception as error:  # whatever it is, the user gets one line and keeps the scene
            return self._failed(error)
        self._job.start()
        if self._job.wait(QUICK):
            return self._finish(context)
        manager = context.window_manager
        self._timer = manager.event_timer_add(0.1, window=context.window)
        manager.progress_begin(0, 100)
        manager.modal_handler_add(self)
        self._tell(context)
        return {"RUNNING_MODAL"}

    def modal(self, context: Any, event: Any) -> set[str]:
        """Show progress, and finish when the job has ended."""
        if event.type == "ESC":
            self._job.stop()
        if event.type != "TIMER":
            return {"PASS_THROUGH"} if event.type.startswith(_LOOKING) else {"RUNNING_MODAL"}
        self._tell(context)
        if not self._job.wait(0):
            return {"RUNNING_MODAL"}
        self._end_modal(context)
        return self._finish(context)

    def cancel(self, context: Any) -> None:
        """Blender ends the operator, as when a file is opened: let the thread stop and forget its result."""
        self._job.stop()
        self._end_modal(context)

    def execute(self, context: Any) -> set[str]:
        """Compute at once."""
        manager = context.window_manager
        manager.progress_begin(0, 100)
        context.workspace.status_text_set(f"meshcore: {COMPILING}")
        try:
            self._sources = inputs.gather(context, self.declaration, self._chosen(), self._arrays())
            self._job = Job(self._call(context), lambda fraction, message: manager.progress_update(int(100 * fraction)))
            self._job.run()
        except Exception as error:  # whatever it is, the user gets one line and keeps the scene
            return self._failed(error)
        finally:
            manager.progress_end()
            context.workspace.status_text_set(None)
        return self._finish(context)

    def draw(self, context: Any) -> None:
        """The redo panel: parameters under their headings, advanced ones last."""
        self.layout.use_property_split = True
        for name in inputs.by_name(self.declaration):
            self.layout.prop(self, name)
        draw_parameters(self.layout, self, self.declaration["params"])

    # ---- steps

    def _chosen(self) -> dict[str, str]:
        """The names of the objects that the properties choose."""
        return {name: getattr(self, name) for name in inputs.by_name(self.declaration)}

    def _arrays(self) -> list[str]:
        """The names of arrays that the properties ask for."""
        params = self.declaration["params"]
        return [
            getattr(self, name) for name, declared in params.items() if declared.get("array") and getattr(self, name)
        ]

    def _call(self, context: Any) -> functools.partial:
        """The operation with its inputs and parameters, ready for any thread."""
        import meshcore

        function = meshcore.operations()[self.identifier].function
        arguments = properties.values(self.declaration["params"], self)
        arguments |= self.extra(context, arguments)
        given = self._given()
        named = inputs.by_name(self.declaration)
        positional = [source.mesh for name, source in given.items() if name not in named]
        arguments |= {name: source.mesh for name, source in given.items() if name in named}
        return functools.partial(function, *positional, **arguments)

    def _given(self) -> dict[str, Source]:
        """The sources by the names of their inputs: the selected ones in order, and those chosen by name."""
        chosen = [name for name, ob in self._chosen().items() if ob]
        named = inputs.by_name(self.declaration)
        selected = [name for name in self.declaration["inputs"] if name not in named]
        return dict(zip([*selected[: len(self._sources) - len(chosen)], *chosen], self._sources, strict=True))

    def extra(self, context: Any, arguments: dict[str, Any]) -> dict[str, Any]:
        """More keyword arguments than the properties give; for hand-written operators."""
        return {}

    def _fill_lengths(self) -> None:
        """Show relative lengths as what they are for this input, unless the caller set them."""
        if not self._sources:
            return
        named = sum(map(bool, self._chosen().values()))
        corners = np.concatenate([source.mesh.bounds for source in self._sources[: len(self._sources) - named]])
        diagonal = float(np.linalg.norm(np.ptp(corners, axis=0)))
        for name, declared in self.declaration["params"].items():
            default = declared["default"]
            if isinstance(default, dict) and not self.properties.is_property_set(name):
                setattr(self, name, default["relative"] * diagonal)

    def _tell(self, context: Any) -> None:
        context.workspace.status_text_set(self._job.status)
        context.window_manager.progress_update(int(100 * self._job.fraction))

    def _end_modal(self, context: Any) -> None:
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.progress_end()
        context.workspace.status_text_set(None)

    def _finish(self, context: Any) -> set[str]:
        """Put the result into the scene, or tell why there is none."""
        if self._job.error is not None:
            return self._failed(self._job.error)
        try:
            result = self._job.result
            source = self._sources[0].name if self._sources else ""
            ob, warnings = results.show(context, self.declaration["label"], source, result)
        except Exception as error:  # whatever it is, the user gets one line and keeps the scene
            return self._failed(error)
        warnings = [*result.report.warnings, *warnings]
        counts = ", ".join(f"{number:,} {name}" for name, number in result.report.counts.items())
        text = f"{ob.name}: {counts}"
        self.report({"WARNING"} if warnings else {"INFO"}, "; ".join([text, *warnings]))
        return {"FINISHED"}

    def _failed(self, error: BaseException) -> set[str]:
        """One line for the user; the place of the fault selected; a traceback only for what nobody foresaw."""
        level, text = explain(error)
        if level == "ERROR":
            given = self._given() if getattr(self, "_sources", []) else {}
            marked, name = mark(error, list(given.values()), list(given))
            if marked:
                text += f" ({marked} {'vertex' if marked == 1 else 'vertices'} selected on {name})"
        self.report({level}, text)
        return {"CANCELLED"}


def explain(error: BaseException) -> tuple[str, str]:
    """How loud to report an error, and one line of text."""
    if isinstance(error, ReadingFailed):
        return "ERROR", str(error)
    try:
        from meshcore import Cancelled, MeshcoreError
    except ImportError as missing:
        return "ERROR", f"meshcore cannot be imported ({missing}); install the extension's zip for this version again"
    if isinstance(error, Cancelled):
        return "INFO", "Cancelled; nothing was changed"
    if isinstance(error, MeshcoreError):
        return "ERROR", " ".join(str(error).split())
    traceback.print_exception(error, file=sys.stderr)
    return "ERROR", f"Unexpected {type(error).__name__}: {error}; the console shows where, please report it"


def mark(error: BaseException, sources: list[Source], ports: list[str]) -> tuple[int, str]:
    """Select the vertices that an error names; return how many, and on which objects."""
    if isinstance(error, ReadingFailed):
        return selection.select_vertices(error.name, error.vertices), error.name
    if not sources:
        return 0, ""
    parameter = getattr(error, "parameter", "")
    number = ports.index(parameter) if parameter in ports[: len(sources)] else 0
    source = sources[number]
    points = np.unique(_points_of(error, source)).astype(int)
    marked, names, start = 0, [], 0
    for part in source.parts or (source,):
        here = points[(points >= start) & (points < start + part.mesh.n_points)] - start
        start += part.mesh.n_points
        if part.vertices is not None and len(here):
            marked += selection.select_vertices(part.name, part.vertices[here])
            names.append(part.name)
    return marked, " and ".join(names)


def _points_of(error: Any, source: Source) -> list[int]:
    """The points that an error names, or those of the cells that it names."""
    if not hasattr(error, "points"):  # other errors' cells are not those of an input
        return []
    points = list(error.points)
    cells = set() if points else set(error.cells)
    for _, nodes, where in source.mesh.blocks():
        points += [int(p) for c in cells & set(range(where.start, where.stop)) for p in nodes[c - where.start]]
    return points


def draw_parameters(layout: Any, properties_of: Any, params: dict[str, dict[str, Any]]) -> None:
    """Parameters as rows: those without a heading, those of each group in a box, advanced ones below."""
    layout.use_property_split = True
    groups: dict[tuple[bool, str], list[str]] = {}
    for name, declared in params.items():
        advanced = bool(declared.get("advanced"))
        heading = declared.get("group", "") or ("Advanced" if advanced else "")
        groups.setdefault((advanced, heading), []).append(name)
    for (_, heading), names in sorted(groups.items(), key=lambda item: item[0][0]):
        column = layout.box().column() if heading else layout.column()
        if heading:
            column.label(text=heading)
        for name in names:
            column.prop(properties_of, name)


def operator_class(identifier: str, declaration: dict[str, Any]) -> type:
    """The operator of one operation, on its hand-written base where there is one."""
    from .overrides import OVERRIDES

    body = {
        "__doc__": declaration["summary"],
        "__annotations__": {
            **{name: properties.object_name(port) for name, port in inputs.by_name(declaration).items()},
            **{name: properties.annotation(one) for name, one in declaration["params"].items()},
        },
        "identifier": identifier,
        "declaration": declaration,
        "bl_idname": PREFIX + identifier,
        "bl_label": declaration["label"],
        "bl_description": declaration["summary"].rstrip("."),
        "bl_options": {"REGISTER", "UNDO"},
    }
    base = OVERRIDES.get(identifier, OperationBase)
    return type(f"MESHCORE_OT_{identifier}", (base, bpy.types.Operator), body)


_registered: list[type] = []


def register() -> None:
    """Make and register the operators."""
    for identifier, declaration in properties.registry()["operations"].items():
        made = operator_class(identifier, declaration)
        bpy.utils.register_class(made)
        _registered.append(made)


def unregister() -> None:
    """Take the operators away."""
    while _registered:
        bpy.utils.unregister_class(_registered.pop())
