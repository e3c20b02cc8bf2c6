"""Progress, abort and what is said of compiling."""

from __future__ import annotations

import paraview.simple as pv
from datasets import of_mesh, polylines, producer
from harness import input_names, load_plugin, run_checks, said

import meshcore
from meshcore import gallery

load_plugin()


def model(operation):
    """A filter on the gallery's model, not run yet."""
    inputs, keywords = gallery.arguments(operation)
    entry = meshcore.operations()[operation]
    sources = dict(zip(input_names(entry), (producer(of_mesh(m)) for m in inputs), strict=False))
    shown = {name.title().replace("_", ""): value for name, value in keywords.items()}
    return getattr(pv, "meshcore" + entry.label.replace(" ", ""))(**sources, **shown)


def watched(proxy, react=lambda algorithm: None):
    """What an update tells on its way: (fraction, text) each time."""
    seen = []
    algorithm = proxy.GetClientSideObject()

    def note(caller, event):
        seen.append((caller.GetProgress(), caller.GetProgressText()))
        react(caller)

    tag = algorithm.AddObserver("ProgressEvent", note)
    proxy.UpdatePipeline()
    algorithm.RemoveObserver(tag)
    return seen


def check_progress_is_told(operation):
    seen = watched(model(operation))
    assert any(0 < fraction < 1 and text for fraction, text in seen), seen
    assert any("compiling" in text for _, text in seen if text), seen  # the first call in this process
    assert not any("compiling" in text for _, text in watched(model(operation)) if text)


def check_abort_empties_the_result(operation):
    proxy = model(operation)
    with said() as text:
        watched(proxy, lambda algorithm: algorithm.SetAbortExecute(1))
    assert proxy.GetDataInformation().GetNumberOfCells() == 0
    assert "aborted" in text[0] and "Traceback" not in text[0] and "ERR|" not in text[0], text[0]


def check_after_an_abort_the_next_run_is_complete():
    square = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 0)]
    proxy = pv.meshcoreTransfiniteInterpolation(South=producer(polylines(square)), CellsI=4, CellsJ=3)
    watched(proxy, lambda algorithm: algorithm.SetAbortExecute(1))
    proxy.CellsI = 5
    proxy.UpdatePipeline()
    assert proxy.GetDataInformation().GetNumberOfCells() == 15


if __name__ == "__main__":
    run_checks(globals())
