"""Run the parts of the test suite, each in its own process: `python3 tests/run.py [PART ...]`.

Two host libraries in one process crash each other, so each host has a process, and its own environment. Each part
ends in one line, and all of them in one more. A part that cannot start counts as a failure, and so does a skip.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import NamedTuple

sys.path.insert(0, str(Path(__file__).resolve().parent))
import environments

ROOT = environments.ROOT
CORE_PYTHON = environments.CORE / "bin/python"


class Part(NamedTuple):
    """One part of the suite: what must be there, and pytest's interpreter and arguments."""

    environments: list[str]
    python: Path
    arguments: list[str]


class Count(NamedTuple):
    """How a part ended."""

    passed: int
    failed: int
    skipped: int


def parts() -> dict[str, Part]:
    """All parts but lint, in the order in which they run."""
    table = {
        "core": Part(["core"], CORE_PYTHON, ["--doctest-modules", "meshcore", "tests/core"]),
        "meshlab": Part(["core", "meshlab"], environments.FOLDER / "meshlab/bin/python", ["tests/meshlab"]),
        "paraview": Part(["core", "paraview"], CORE_PYTHON, ["tests/paraview"]),
    }
    for name in environments.blenders():
        table[name] = Part(["core", name], environments.FOLDER / name / "bin/python", ["tests/blender"])
    table["install"] = Part(["core", "paraview", *environments.blenders()], CORE_PYTHON, ["tests/install"])
    return table


def lint() -> Count:
    """Style, format and the layers, one check each."""
    environments.main(["core"])
    tools = environments.CORE / "bin"
    checks = [
        [tools / "ruff", "check", "."],
        [tools / "ruff", "format", "--check", "."],
        [tools / "lint-imports"],
    ]
    codes = [subprocess.run([str(word) for word in check], cwd=ROOT, check=False).returncode for check in checks]
    failed = sum(code != 0 for code in codes)
    return Count(len(checks) - failed, failed, 0)


def run_pytest(part: Part) -> Count:
    """Run a part's tests and read their number from its report."""
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "report.xml"
        command = [part.python, "-m", "pytest", "-q", f"--junitxml={report}", *part.arguments]
        subprocess.run([str(word) for word in command], cwd=ROOT, check=False)
        if not report.exists():
            return Count(0, 1, 0)  # crashed before it could report
        suite = ET.parse(report).getroot().find("testsuite")
    number = {key: int(suite.get(key)) for key in ("tests", "failures", "errors", "skipped")}
    failed = number["failures"] + number["errors"]
    return Count(number["tests"] - failed - number["skipped"], failed, number["skipped"])


def closing_line(name: str, count: Count, seconds: float) -> str:
    """As pytest closes, but with the part's name."""
    skipped = f", {count.skipped} skipped" if count.skipped else ""
    return f"{name}: {count.passed} passed, {count.failed} failed{skipped} in {seconds:.0f}s".center(90, "=")


def run_part(name: str, table: dict[str, Part]) -> Count:
    """Prepare and run one part."""
    if name == "lint":
        return lint()
    setup = [sys.executable, str(ROOT / "tests/environments.py"), *table[name].environments]
    if subprocess.run(setup, check=False).returncode:
        return Count(0, 1, 0)
    return run_pytest(table[name])


def main(names: list[str]) -> int:
    """Run the named parts, or all; return the exit code."""
    os.environ.setdefault("PYTHONUNBUFFERED", "1")
    table = parts()
    names = names or ["lint", *table]
    if unknown := set(names) - {"lint", *table}:
        sys.exit(f"no part {sorted(unknown)[0]!r}; there are lint, {', '.join(table)}")
    lines, total = [], Count(0, 0, 0)
    for name in names:
        print(f" {name} ".center(90, "-"), flush=True)
        start = time.perf_counter()
        count = run_part(name, table)
        lines.append(closing_line(name, count, time.perf_counter() - start))
        print(lines[-1], flush=True)
        total = Count(*(a + b for a, b in zip(total, count, strict=False)))
    print("\n".join(["", *lines]))
    print(f"all: {total.passed} passed, {total.failed} failed" + f", {total.skipped} skipped" * bool(total.skipped))
    return 1 if total.failed or total.skipped or not total.passed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
