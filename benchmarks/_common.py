"""What the benchmarks share: turns, clocks, peers, targets, tables in Markdown, and work in a process of its own.

Contestants run alternately in one process, so that a busy machine slows all of them, and ratios of medians are what
counts. Processor seconds are compared where both sides have one thread, the clock on the wall where not.
"""

from __future__ import annotations

import argparse
import gc
import multiprocessing
import statistics
import sys
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))  # tests.point_sets, and meshcore without installing


def arguments(about: str, **numbers: Any) -> argparse.Namespace:
    """The command line: ``--quick``, ``--repeats``, and a list of sizes for each keyword."""
    parser = argparse.ArgumentParser(description=about, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="small sizes and few repeats: does it run at all?")
    parser.add_argument("--repeats", type=int, help="turns of each contestant (default 5, quick 2)")
    for name, default in numbers.items():
        parser.add_argument(
            f"--{name}", type=type(default[0]), nargs="*", help=f"default {' '.join(map(str, default))}"
        )
    options = parser.parse_args()
    options.repeats = options.repeats or (2 if options.quick else 5)
    return options


# ---- measuring


class Times(NamedTuple):
    """Seconds of each turn, in the processor and on the wall, and what the last turn returned."""

    processor: list[float]
    wall: list[float]
    result: Any

    @property
    def seconds(self) -> float:
        """Median of the processor's seconds."""
        return statistics.median(self.processor)

    @property
    def wall_seconds(self) -> float:
        """Median of the seconds on the wall."""
        return statistics.median(self.wall)

    @property
    def turns(self) -> int:
        """How many medians are of."""
        return len(self.wall)


def taken_alternately(
    contestants: dict[str, Callable[[], Any]], repeats: int, rare: dict[str, int] | None = None
) -> dict[str, Times]:
    """Let each contestant run in turn, ``repeats`` times, those in ``rare`` fewer times.

    A contestant may return the seconds of its own work instead, as `Own`, to leave out what its wrapper adds.
    """
    rare = rare or {}
    found = {name: Times([], [], None) for name in contestants}
    for turn in range(repeats):
        for name, run in contestants.items():
            if turn >= rare.get(name, repeats):
                continue
            gc.collect()
            wall, processor = time.perf_counter(), time.process_time()
            result = run()
            processor, wall = time.process_time() - processor, time.perf_counter() - wall
            if isinstance(result, Own):
                processor, wall, result = result
            found[name] = Times([*found[name].processor, processor], [*found[name].wall, wall], result)
    return found


class Own(NamedTuple):
    """Seconds that a contestant measured itself, and its result."""

    processor: float
    wall: float
    result: Any


def in_own_process(function: Callable[..., Any], *given: Any, seconds: float = 1800.0) -> Any:
    """Result of a module's function in a fresh process; an exception, returned, names how that ended or what it raised.

    A peer that crashes or hangs on bad points takes down its own row only.
    """
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe(duplex=False)
    process = context.Process(target=_send_result, args=(theirs, function, given))
    process.start()
    theirs.close()
    try:
        if not ours.poll(seconds):
            return RuntimeError(f"not done after {seconds:.0f} s")
        return ours.recv()
    except EOFError:
        process.join()
        return RuntimeError(f"ended with code {process.exitcode}")
    finally:
        process.kill()
        process.join()


def _send_result(pipe: Any, function: Callable[..., Any], given: tuple[Any, ...]) -> None:
    try:
        pipe.send(function(*given))
    except Exception as error:
        pipe.send(RuntimeError(f"{type(error).__name__}: {str(error).strip().splitlines()[0]}"))


# ---- peers: each makes the triangulation of points only, by one thread


def with_triangle(points: np.ndarray) -> int:
    """Number of Triangle's triangles (divide and conquer, its default)."""
    import triangle

    return len(triangle.triangulate({"vertices": points}, "Qz")["triangles"])


class TetGenResult(NamedTuple):
    """Number of tetrahedra, and processor seconds that meshpy took to copy the points, one by one, in Python."""

    cells: int
    copying: float


def with_tetgen(points: np.ndarray) -> Own:
    """TetGen's own seconds; those in which meshpy copies points are told apart, those to read cells not counted."""
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import meshpy.tet

    start = time.process_time()
    given = meshpy.tet.MeshInfo()
    given.set_points(points)
    wall, processor = time.perf_counter(), time.process_time()
    mesh = meshpy.tet.build(given, options=meshpy.tet.Options("Q"))
    seconds = time.process_time() - processor, time.perf_counter() - wall
    return Own(*seconds, TetGenResult(len(mesh.elements), processor - start))


def with_scipy(points: np.ndarray) -> int:
    """Number of Qhull's simplices."""
    from scipy.spatial import Delaunay

    return len(Delaunay(points).simplices)


def with_gmsh(points: np.ndarray) -> int:
    """Number of Gmsh's simplices of points."""
    import gmsh

    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        run = gmsh.algorithm.triangulate if points.shape[1] == 2 else gmsh.algorithm.tetrahedralize
        return len(run(points.ravel())) // (points.shape[1] + 1)
    finally:
        gmsh.finalize()


class GmshModel:
    """A planar boundary inside Gmsh, to be meshed again and again: ``with GmshModel(loops, 0.1, 6) as mesh: mesh()``.

    Parameters
    ----------
    boundary : Mesh
        Closed loops of lines, the outermost first.
    size : float
        Edge length everywhere.
    algorithm : int
        5 is Gmsh's Delaunay, 6 its Frontal-Delaunay.
    """

    def __init__(self, boundary: Any, size: float, algorithm: int):
        self.boundary, self.size, self.algorithm = boundary, size, algorithm

    def __enter__(self) -> Callable[[], Own]:
        import gmsh

        gmsh.initialize(interruptible=False)
        for name, value in (
            ("General.Terminal", 0),
            ("General.NumThreads", 1),
            ("Mesh.Algorithm", self.algorithm),
            ("Mesh.MeshSizeMin", self.size),
            ("Mesh.MeshSizeMax", self.size),
        ):
            gmsh.option.setNumber(name, value)
        points = [gmsh.model.geo.addPoint(*p, self.size) for p in self.boundary.points.tolist()]
        lines = self.boundary.get("line").tolist()
        curves = [gmsh.model.geo.addLine(points[a], points[b]) for a, b in lines]
        breaks = [k + 1 for k in range(len(lines) - 1) if lines[k][1] != lines[k + 1][0]]
        loops = [gmsh.model.geo.addCurveLoop(curves[a:b]) for a, b in zip([0, *breaks], [*breaks, None], strict=True)]
        gmsh.model.geo.addPlaneSurface(loops)
        gmsh.model.geo.synchronize()
        return self.mesh

    def mesh(self) -> Own:
        """Seconds of meshing alone; points (n, 3) and triangles (m, 3)."""
        import gmsh

        gmsh.model.mesh.clear()
        wall, processor = time.perf_counter(), time.process_time()
        gmsh.model.mesh.generate(2)
        processor, wall = time.process_time() - processor, time.perf_counter() - wall
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        place = np.zeros(int(tags.max()) + 1, np.int64)
        place[tags] = np.arange(len(tags))
        corners = place[gmsh.model.mesh.getElementsByType(2)[1]].reshape(-1, 3)
        return Own(processor, wall, (coordinates.reshape(-1, 3), corners))

    def __exit__(self, *_: Any) -> None:
        import gmsh

        gmsh.finalize()


def is_installed(package: str) -> bool:
    """Whether an optional peer is there."""
    import importlib.util

    return importlib.util.find_spec(package) is not None


# ---- writing


class Target(NamedTuple):
    """What the project asks of a number: at least (or at most) the one, better the other, if there is another."""

    limit: float
    aim: float | None = None
    at_most: bool = False

    def verdict(self, value: float) -> str:
        """``3.8 (at least 3.5 met, aim 5 MISSED)``."""
        words = [
            f"{name} {limit:g} {'met' if (value <= limit if self.at_most else value >= limit) else 'MISSED'}"
            for name, limit in (("at most" if self.at_most else "at least", self.limit), ("aim", self.aim))
            if limit is not None
        ]
        return f"**{value:.3g}** ({', '.join(words)})"


def print_heading(title: str, about: str = "") -> None:
    """A Markdown heading, and what the table below it measures."""
    print(f"\n### {title}\n")
    if about:
        print(about + "\n")


def print_row(*cells: Any, head: bool = False) -> None:
    """One row of a Markdown table; after a ``head`` row comes its line."""
    print("| " + " | ".join(map(_text, cells)) + " |", flush=True)
    if head:
        print("|" + " --- |" * len(cells))


def print_claim(survey: str, found: str) -> None:
    """A claim of the survey beside what was found."""
    print(f"\nSurvey: {survey}\nFound: {found}")


def _text(cell: Any) -> str:
    if isinstance(cell, float):
        return f"{cell:.3g}" if abs(cell) < 1000 else f"{cell:,.0f}"
    return f"{cell:,}" if isinstance(cell, int) else str(cell)


def of_turns(times: Iterable[Times]) -> str:
    """``median of 5``, or of how many each."""
    turns = [t.turns for t in times]
    return f"{turns[0]}" if len(set(turns)) == 1 else "/".join(map(str, turns))
