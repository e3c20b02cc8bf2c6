"""The interface's way to run an operator: a thread, a timer, the status bar, Esc.

Background Blender has no window that sends events, so `invoke` and `modal` are called as Blender would call them,
on a stand-in for the operator's instance.
"""

from __future__ import annotations

import threading
import time
import types

import bpy
import numpy as np
import pytest

from tests.blender import scene

SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
LOOP = [(0, 1), (1, 2), (2, 3), (3, 0)]


class Manager:
    """A window manager that takes notes."""

    def __init__(self):
        self.seen = []

    def __getattr__(self, name):
        return lambda *arguments, **keywords: self.seen.append((name, *arguments)) or name


class Status:
    """A workspace whose status bar can be read."""

    def __init__(self):
        self.texts = []

    def status_text_set(self, text):
        """As Blender's."""
        self.texts.append(text)


class Context:
    """Blender's context, but for the window manager and the status bar."""

    def __init__(self):
        self.window_manager, self.workspace, self.window = Manager(), Status(), None

    def __getattr__(self, name):
        return getattr(bpy.context, name)


@pytest.fixture
def operators(installed):
    """The add-on's operators."""
    return scene.addon("operators")


@pytest.fixture
def job(operators, core, monkeypatch):
    """An operator's stand-in on a closed square, whose operation waits until it is let go or stopped."""
    gate = threading.Event()
    operation = core.operations()["transfinite"]
    threads = []

    def slow(*inputs, progress, **keywords):
        threads.append(threading.current_thread())
        for step in range(1000):
            if progress(step / 1000, "waiting") is False:
                raise core.Cancelled("cancelled while waiting")
            if gate.wait(0.01):
                return operation.function(*inputs, **keywords)
        raise AssertionError("nobody let the job go")

    entry = types.SimpleNamespace(function=slow)
    monkeypatch.setattr(core, "operations", lambda: {"transfinite": entry})
    made = stand_in(operators)
    made.gate, made.threads = gate, threads
    scene.add_mesh("square", SQUARE, LOOP)
    yield made
    gate.set()


def stand_in(operators, identifier="transfinite", **values):
    """An operator's instance as `OperationBase` needs it."""
    registry = scene.addon("properties").registry()
    declaration = registry["operations"][identifier]
    rna = scene.operator(identifier).get_rna_type().properties
    shown = {}
    for name in [*declaration["params"], *scene.addon("inputs").by_name(declaration)]:
        one = rna[name]
        shown[name] = list(one.default_array) if getattr(one, "is_array", False) else one.default
    made = operators.OperationBase()
    made.identifier, made.declaration, made.reports = identifier, declaration, []
    made.report = lambda level, text: made.reports.append((*level, text))
    made.properties = types.SimpleNamespace(is_property_set=lambda name: name in values)
    for name, value in {**shown, **values}.items():
        setattr(made, name, value)
    return made


def event(kind):
    """As Blender sends it."""
    return types.SimpleNamespace(type=kind, value="PRESS")


def drive(made, context, until=10.0):
    """Send timer events until the operator ends."""
    end = time.monotonic() + until
    while time.monotonic() < end:
        answer = made.modal(context, event("TIMER"))
        if answer != {"RUNNING_MODAL"}:
            return answer
        time.sleep(0.01)
    raise AssertionError("the operator never ended")


def cleaned_up(context):
    """Timer gone, cursor and status bar as before."""
    names = [call[0] for call in context.window_manager.seen]
    ended = names.count("event_timer_remove") == names.count("event_timer_add") == 1
    return (
        ended and names.count("progress_end") == names.count("progress_begin") and context.workspace.texts[-1] is None
    )


def test_long_job_runs_beside_the_window_and_ends_in_an_object(job):
    context = Context()
    assert job.invoke(context, event("LEFTMOUSE")) == {"RUNNING_MODAL"}
    assert scene.names() == {"square"}
    assert job.threads[0] is not threading.main_thread()
    assert job.modal(context, event("TIMER")) == {"RUNNING_MODAL"}
    assert "waiting" in context.workspace.texts[-1]
    assert "Esc" in context.workspace.texts[-1]
    job.gate.set()
    assert drive(job, context) == {"FINISHED"}
    assert scene.active().name == "square Transfinite Interpolation"
    assert job.reports[0][0] == "INFO"
    assert cleaned_up(context)


def test_escape_cancels_and_changes_nothing(job):
    context = Context()
    job.invoke(context, event("LEFTMOUSE"))
    assert job.modal(context, event("ESC")) == {"RUNNING_MODAL"}
    assert drive(job, context) == {"CANCELLED"}
    assert job.reports == [("INFO", "Cancelled; nothing was changed")]
    assert scene.names() == {"square"}
    assert cleaned_up(context)
    assert not job.threads[0].is_alive()


def test_one_may_look_around_but_not_edit(job):
    context = Context()
    job.invoke(context, event("LEFTMOUSE"))
    for kind in ("MOUSEMOVE", "MIDDLEMOUSE", "WHEELUPMOUSE", "TRACKPADZOOM"):
        assert job.modal(context, event(kind)) == {"PASS_THROUGH"}
    for kind in ("Z", "X", "LEFTMOUSE", "TAB"):
        assert job.modal(context, event(kind)) == {"RUNNING_MODAL"}


def test_closing_the_file_stops_the_thread(job):
    context = Context()
    job.invoke(context, event("LEFTMOUSE"))
    job.cancel(context)
    job.threads[0].join(5)
    assert not job.threads[0].is_alive()
    assert cleaned_up(context)


def test_source_removed_meanwhile(job):
    context = Context()
    job.invoke(context, event("LEFTMOUSE"))
    bpy.data.objects.remove(bpy.data.objects["square"])
    job.gate.set()
    assert drive(job, context) == {"FINISHED"}
    assert len(bpy.data.objects) == 1


def test_first_status_says_compiling(job, core, monkeypatch):
    started = threading.Event()

    def silent_at_first(*inputs, progress, **keywords):
        started.wait(5)

    entry = types.SimpleNamespace(function=silent_at_first)
    monkeypatch.setattr(core, "operations", lambda: {"transfinite": entry})
    context = Context()
    job.invoke(context, event("LEFTMOUSE"))
    assert "compiling" in context.workspace.texts[-1]
    started.set()
    drive(job, context)


def test_error_in_the_thread_is_one_line(job, core, monkeypatch):
    def failing(*inputs, progress, **keywords):
        time.sleep(0.5)
        raise core.InvalidGeometry("is bad there", points=[2])

    monkeypatch.setattr(core, "operations", lambda: {"transfinite": types.SimpleNamespace(function=failing)})
    context = Context()
    job.invoke(context, event("LEFTMOUSE"))
    assert drive(job, context) == {"CANCELLED"}
    assert job.reports == [("ERROR", "is bad there (1 vertex selected on square)")]
    assert [v.select for v in bpy.data.objects["square"].data.vertices] == [False, False, True, False]
    assert cleaned_up(context)


def test_quick_job_ends_at_once(operators):
    scene.add_mesh("square", SQUARE, LOOP)
    made = stand_in(operators, cells_i=3, cells_j=3)
    context = Context()
    assert made.invoke(context, event("LEFTMOUSE")) == {"FINISHED"}
    assert context.window_manager.seen == []
    assert len(scene.active().data.polygons) == 9


def test_bad_selection_is_told_before_any_thread(operators):
    made = stand_in(operators)
    before = threading.active_count()
    assert made.invoke(Context(), event("LEFTMOUSE")) == {"CANCELLED"}
    assert made.reports[0][0] == "ERROR"
    assert threading.active_count() == before


def test_relative_lengths_are_filled_in_from_the_inputs_size(operators):
    scene.add_mesh("big", 10 * np.array(SQUARE), LOOP)
    made = stand_in(operators)
    made.invoke(Context(), event("LEFTMOUSE"))
    declared = made.declaration["params"]
    filled = [name for name, one in declared.items() if isinstance(one["default"], dict)]
    assert filled
    for name in filled:
        assert getattr(made, name) == pytest.approx(declared[name]["default"]["relative"] * 10 * 2**0.5)


def test_lengths_that_the_caller_gives_are_kept(operators):
    scene.add_mesh("square", SQUARE, LOOP)
    made = stand_in(operators, tolerance=0.25)
    made.invoke(Context(), event("LEFTMOUSE"))
    assert made.tolerance == 0.25


def test_scripts_and_the_redo_panel_wait_for_the_result(installed):
    scene.add_mesh("square", SQUARE, LOOP)
    assert bpy.ops.meshcore.transfinite("INVOKE_DEFAULT", cells_i=2, cells_j=2) == {"FINISHED"}
    assert bpy.ops.meshcore.transfinite.poll()


def test_hand_written_operator_takes_the_place_of_the_generated_one(operators, monkeypatch):
    class Ours(operators.OperationBase):
        def execute(self, context):
            self.report({"WARNING"}, f"ours, with {self.cells_i} cells")
            return {"FINISHED"}

    overrides = scene.addon("overrides")
    monkeypatch.setitem(overrides.OVERRIDES, "transfinite", Ours)
    scene.add_mesh("square", SQUARE, LOOP)
    operators.unregister()
    operators.register()
    try:
        assert bpy.ops.meshcore.transfinite(cells_i=7) == {"FINISHED"}
        assert scene.names() == {"square"}
    finally:
        monkeypatch.undo()
        operators.unregister()
        operators.register()
    assert bpy.ops.meshcore.transfinite(cells_i=7, cells_j=7) == {"FINISHED"}
    assert len(bpy.data.objects) == 2
