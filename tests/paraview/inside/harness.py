"""Runs inside ParaView's Python: loads the plugin, runs a script's checks, and writes how each ended.

A check is a function called ``check_...`` without arguments, or with the argument ``operation``: that one runs once
for each operation of the registry. The tests outside read the list of checks from the script itself, so that one
that never ran is a failure.
"""

from __future__ import annotations

import contextlib
import inspect
import json
import os
import sys
import tempfile
import traceback
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
PLUGIN = Path(os.environ.get("MESHCORE_PLUGIN", ROOT / "paraview_plugin" / "meshcore_plugin.py"))
OUT = Path(os.environ.get("OUT", tempfile.gettempdir()))


def load_plugin(*, remote: bool = False) -> None:
    """Load the plugin; its functions are then in paraview.simple."""
    from paraview.simple import LoadPlugin

    LoadPlugin(str(PLUGIN), remote=remote)


def input_names(operation) -> list[str]:
    """What a script calls the inputs of an operation: the first is Input, unless another one takes the same cells."""
    names = [name.title().replace("_", "") for name in operation.inputs]
    ports = list(operation.inputs.values())
    return names if any(port.cells == ports[0].cells for port in ports[1:]) else ["Input", *names[1:]]


@contextlib.contextmanager
def said():
    """Collect all that is written to standard error, by Python and by VTK alike: a list of one text afterwards."""
    text: list[str] = []
    sys.stderr.flush()
    kept = os.dup(2)
    with tempfile.TemporaryFile() as file:
        os.dup2(file.fileno(), 2)
        try:
            yield text
        finally:
            sys.stderr.flush()
            os.dup2(kept, 2)
            os.close(kept)
            file.seek(0)
            text.append(file.read().decode(errors="replace"))
            sys.stderr.write(text[0])


def rank() -> int:
    """Number of this process among those that run the script together."""
    from paraview.servermanager import vtkProcessModule

    return vtkProcessModule.GetProcessModule().GetPartitionId()


def names_of(function, operations) -> list[str]:
    """The names under which a check's outcomes are kept."""
    if not inspect.signature(function).parameters:
        return [function.__name__]
    return [f"{function.__name__}[{operation}]" for operation in operations]


def run_checks(namespace: dict) -> None:
    """Run every check of a script and write the outcomes to the file named on the command line, one for each rank."""
    import meshcore

    result = Path(sys.argv[1]).with_suffix(f".{rank()}.json")

    outcomes: dict[str, str] = {}
    checks = [f for name, f in list(namespace.items()) if name.startswith("check_")]
    for check in checks:
        for name in names_of(check, meshcore.operations()):
            argument = [name[len(check.__name__) + 1 : -1]] if name.endswith("]") else []
            print("----", name, flush=True)
            try:
                check(*argument)
                outcomes[name] = "passed"
            except BaseException:  # whatever a check raises is its outcome, and the others still run
                outcomes[name] = traceback.format_exc()
                print(outcomes[name], flush=True)
            result.write_text(json.dumps(outcomes))


def save(path, proxy):
    """Save a result in one of VTK's XML formats, so that any ParaView can read it again.

    By default ParaView appends the data raw, and its version 5.11 cannot read that any more with the expat library
    of an up-to-date Debian 12 (2.5.0-1+deb12u5).
    """
    from paraview.simple import SaveData

    SaveData(str(path), proxy=proxy, DataMode="Binary")
