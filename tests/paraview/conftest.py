"""Runs scripts in ParaView's own Python and hands their outcomes to the tests. A ParaView that is absent fails."""

from __future__ import annotations

import ast
import json
import os
import shutil
import signal
import subprocess
from pathlib import Path
from typing import NamedTuple

import pytest

import meshcore

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
INSIDE = HERE / "inside"
PACKAGES = ROOT / ".envs" / "paraview"


class Run(NamedTuple):
    """How a script ended."""

    code: int
    output: str
    outcomes: dict[str, str]


def checks_of(script: str) -> list[str]:
    """Names of the checks that a script must run, from its source."""
    tree = ast.parse((INSIDE / script).read_text(encoding="utf-8"))
    names = []
    for node in tree.body:
        if isinstance(node, ast.FunctionDef) and node.name.startswith("check_"):
            each = list(meshcore.operations()) if node.args.args else []
            names += [f"{node.name}[{operation}]" for operation in each] or [node.name]
    assert names, f"{script} has no checks"
    return names


def assert_passed(run: Run, check: str) -> None:
    """Fail with the check's own traceback, or with the end of the output if it never ran."""
    outcome = run.outcomes.get(check, f"never ran; exit code {run.code}\n{run.output[-6000:]}")
    assert outcome == "passed", outcome


class Host:
    """Starts ParaView's programs in a clean home folder, with meshcore and what it needs on the path."""

    def __init__(self, folder: Path):
        self.folder = folder
        self.plugin = ROOT / "paraview_plugin" / "meshcore_plugin.py"
        self.runs: dict[tuple, Run] = {}

    def environment(self, **more: str) -> dict[str, str]:
        kept = {k: v for k, v in os.environ.items() if not k.startswith(("PYTHON", "PV_", "XDG_", "MESHCORE_"))}
        path = [HERE / "shim", INSIDE, ROOT, PACKAGES]
        return {
            **kept,
            "HOME": str(self.folder),
            "OUT": str(self.folder),
            "PYTHONPATH": os.pathsep.join(map(str, path)),
            "MESHCORE_CACHE_DIR": str(PACKAGES / "kernels"),
            "MESHCORE_PLUGIN": str(self.plugin),
            "OMPI_ALLOW_RUN_AS_ROOT": "1",
            "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
            **more,
        }

    def execute(self, *command: str | Path, timeout: float = 900, **more: str) -> tuple[int, str]:
        """Run a command to its end; its exit code and all that it said."""
        assert shutil.which(str(command[0])), f"{command[0]} is not here: apt install paraview xvfb openmpi-bin"
        process = subprocess.Popen(
            [str(word) for word in command],
            env=self.environment(**more),
            cwd=self.folder,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        try:
            output, _ = process.communicate(timeout=timeout)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            output, _ = process.communicate()
            output += f"\nstopped after {timeout:g} s".encode()
        return process.returncode, output.decode(errors="replace")

    def run(self, script: str, *launcher: str, ranks: int = 1) -> Run:
        """The outcomes of a script's checks, on the first rank that failed; it runs once, however many tests ask."""
        key = (script, *launcher)
        if key not in self.runs:
            result = self.folder / Path(script).stem
            code, output = self.execute(*(launcher or ["pvpython"]), INSIDE / script, result)
            files = [result.with_suffix(f".{rank}.json") for rank in range(ranks)]
            each = [json.loads(file.read_text()) if file.exists() else {} for file in files]
            ran = [name for name in each[0] if all(name in outcomes for outcomes in each)]
            outcomes = {name: next((o[name] for o in each if o[name] != "passed"), "passed") for name in ran}
            self.runs[key] = Run(code, output, outcomes)
        return self.runs[key]


@pytest.fixture(scope="session")
def host(tmp_path_factory: pytest.TempPathFactory) -> Host:
    """ParaView, or a failure."""
    assert shutil.which("pvpython"), "pvpython is not here: apt install paraview"
    assert (PACKAGES / "numba").is_dir(), "make .envs/paraview first: python3 tests/environments.py paraview"
    return Host(tmp_path_factory.mktemp("paraview"))
