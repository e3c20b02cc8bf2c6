"""Any section a user may bring: O-, C- and H-grids by every method, default parameters, judged by exact arithmetic.

``python benchmarks/sections.py [--quick] [--number 300] [--seed 1] [--family "NACA 4" ...] [--log FILE]``

Sections of some thirty families (airfoils by formula and measured, blades, vehicles, polygons, plates, bays), half of
them turned, moved, scaled, rounded, clockwise or with doubled points. Nothing may crash, take longer than a minute, or
fold. Each is made in a process of its own, which a crash or hang would cost. First heights count as missed if any point
of the section is farther than 5 % from what was asked. A log gets a line for each trial: family, number, words.
"""

from __future__ import annotations

import json
import multiprocessing
import statistics
from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

from _common import Target, arguments, print_heading, print_row

from tests.section_families import FAMILIES, section_of
from tests.section_trials import MAKERS, Trial, methods, tried

SECONDS = 60.0
NONE = Target(0, at_most=True)
Case = tuple[str, int, int, str, str]
"""Family, seed, number, topology, method."""


def outcome(case: Case) -> Trial:
    """What becomes of a case."""
    family, seed, k, topology, method = case
    return tried(topology, method, section_of(family, seed, k))


def _serve(pipe: Any) -> None:
    while (case := pipe.recv()) is not None:
        pipe.send(outcome(case))


class Worker:
    """A process that makes grids, started anew if it crashes or hangs."""

    def __init__(self) -> None:
        self._start()

    def _start(self) -> None:
        context = multiprocessing.get_context("spawn")
        self.pipe, theirs = context.Pipe()
        self.process = context.Process(target=_serve, args=(theirs,), daemon=True)
        self.process.start()
        theirs.close()

    def run(self, case: Case) -> Trial:
        """What becomes of a case, even if it takes the process with it."""
        self.pipe.send(case)
        word = "hang"
        try:
            if self.pipe.poll(SECONDS + 60):  # imports and compiling come first
                return self.pipe.recv()
        except EOFError:
            word = "crash"
        self.stop()
        self._start()
        return Trial(word, converged=False, seconds=SECONDS)

    def stop(self) -> None:
        """End the process."""
        self.process.kill()
        self.process.join()


def cases(number: int, seed: int, families: list[str]) -> Iterator[Case]:
    """All topologies and methods of each section."""
    for k in range(number):
        for topology in MAKERS:
            for method in methods(topology):
                yield families[k % len(families)], seed, k, topology, method


def rows(name: str, found: dict[str, list[Trial]]) -> None:
    """A table with a row for each kind of trial."""
    print()
    wrong = ("folded", "overlaps", "wall moved", "no MeshcoreError", "crash", "hang")
    print_row(name, "grids", "sound", "refused", *wrong, "heights missed", "not converged", "seconds, most", head=True)
    for key, trials in found.items():
        words = [trial.word for trial in trials]
        made = [trial for trial in trials if trial.word == "sound"]
        seconds = [trial.seconds for trial in trials]
        print_row(
            key,
            len(trials) - words.count("crosses"),
            len(made),
            words.count("refused"),
            *(words.count(word) for word in wrong),
            sum(trial.heights > 0 for trial in made),
            sum(not trial.converged for trial in made),
            f"{statistics.median(seconds):.2f}, {max(seconds):.1f}",
        )


def run(chosen: Iterable[Case], log: Path | None) -> None:
    """Print the tables, and what failed."""
    by_method: dict[str, list[Trial]] = defaultdict(list)
    by_family: dict[str, list[Trial]] = defaultdict(list)
    failed = []
    worker = Worker()
    for case in chosen:
        family, _, _, topology, method = case
        trial = worker.run(case)
        by_method[f"{topology}, {method}"].append(trial)
        by_family[family].append(trial)
        if trial.word not in ("sound", "crosses"):
            failed.append(f"{case}: {trial.word}: {trial.text}")
        if log is not None:
            with log.open("a") as file:
                file.write(json.dumps([*case, asdict(trial)]) + "\n")
    worker.stop()
    rows("method", by_method)
    rows("family", by_family)
    print(f"\nnot sound: {NONE.verdict(len(failed))}\n" + "\n".join(failed))


def main() -> None:
    """Print the tables."""
    options = arguments(__doc__, number=[310], seed=[1], family=[""], log=[""])
    families = [name for name in options.family or [] if name] or list(FAMILIES)
    number = (options.number or [len(families) if options.quick else 10 * len(families)])[0]
    print_heading("Any section", f"{number} sections in {len(families)} families, default parameters.")
    log = Path(options.log[0]) if options.log else None
    run(cases(number, (options.seed or [1])[0], families), log)


if __name__ == "__main__":
    main()
