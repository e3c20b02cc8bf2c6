# SPDX-License-Identifier: GPL-3.0-or-later
"""The extension's preferences: which versions run, where compiled kernels are kept, and a button to compile them."""

from __future__ import annotations

import sys
from typing import Any

import bpy

from .jobs import Job


class MESHCORE_OT_compile_kernels(bpy.types.Operator):
    """Compile all kernels now, so that the first mesh does not have to wait for it"""

    bl_idname = "meshcore.compile_kernels"
    bl_label = "Compile Kernels"
    bl_options = {"REGISTER"}

    def execute(self, context: Any) -> set[str]:
        """Run each operation on a small model."""
        manager = context.window_manager
        manager.progress_begin(0, 100)
        context.workspace.status_text_set("meshcore: compiling")
        job = Job(compile_all, lambda fraction, message: manager.progress_update(int(100 * fraction)))
        try:
            job.run()
        finally:
            manager.progress_end()
            context.workspace.status_text_set(None)
        return self._finish(job)

    def invoke(self, context: Any, event: Any) -> set[str]:
        """The same in a thread, with progress in the status bar."""
        self._job = Job(compile_all)
        self._job.start()
        self._timer = context.window_manager.event_timer_add(0.1, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: Any, event: Any) -> set[str]:
        """Wait for the thread; Esc stops it."""
        if event.type == "ESC":
            self._job.stop()
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        context.workspace.status_text_set(self._job.status)
        if not self._job.wait(0):
            return {"RUNNING_MODAL"}
        context.window_manager.event_timer_remove(self._timer)
        context.workspace.status_text_set(None)
        return self._finish(self._job)

    def cancel(self, context: Any) -> None:
        """Blender ends the operator."""
        self._job.stop()
        context.window_manager.event_timer_remove(self._timer)
        context.workspace.status_text_set(None)

    def _finish(self, job: Job) -> set[str]:
        from .operators import explain

        if job.error is not None:
            level, text = explain(job.error)
            self.report({level}, text)
            return {"CANCELLED"}
        self.report({"INFO"}, f"Kernels of {job.result} operations are compiled")
        return {"FINISHED"}


def compile_all(progress: Any) -> int:
    """Run every operation on its model input; return how many."""
    from meshcore.gallery import warm_up

    return len(warm_up(progress))


def versions() -> list[str]:
    """Lines of what runs; only what is imported already, since drawing must not import numba."""
    lines = [f"Python {sys.version.split()[0]}"]
    for name in ("numpy", "scipy", "numba", "meshcore"):
        module = sys.modules.get(name)
        lines.append(f"{name} {module.__version__}" if module else f"{name}: loaded at the first use")
    kernels = sys.modules.get("meshcore._numba")
    lines.append(f"Compiled kernels: {kernels.cache_folder()}" if kernels else "Compiled kernels: not loaded yet")
    return lines


class MESHCORE_AP_preferences(bpy.types.AddonPreferences):
    """Shown under Edit > Preferences > Add-ons."""

    bl_idname = __package__

    def draw(self, context: Any) -> None:
        """Versions, and the button."""
        for line in versions():
            self.layout.label(text=line)
        self.layout.operator_context = "INVOKE_DEFAULT"
        self.layout.operator("meshcore.compile_kernels")


register, unregister = bpy.utils.register_classes_factory((MESHCORE_OT_compile_kernels, MESHCORE_AP_preferences))
