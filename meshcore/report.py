"""What a generator returns beside its mesh: counts, quality, warnings, time."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, NamedTuple


@dataclass
class Report:
    """How a generator fared; prints as a small table.

    Attributes
    ----------
    operation : str
        Label of the operation.
    counts : dict of str to int
        Points, cells, and whatever else the generator counts.
    quality : dict of str to float
        Summary of the mesh's quality, e.g. ``{"smallest angle (degree)": 30.1}``.
    iterations : int
        Iterations or sweeps done.
    residual : float or None
        Last residual of an iterative generator.
    converged : bool
        False if the generator stopped before it reached what was asked; `warnings` says why.
    warnings : list of str
        What the user should know about the result.
    seconds : float
        Wall time in seconds, set by the registry.
    history : list of float
        Residual at the start and after each iteration, in units of the start's; not printed.

    Examples
    --------
    >>> print(Report("Demo", counts={"points": 4, "triangles": 2}))
    Demo
      points     4
      triangles  2
      seconds    0
    """

    operation: str = ""
    counts: dict[str, int] = field(default_factory=dict)
    quality: dict[str, float] = field(default_factory=dict)
    iterations: int = 0
    residual: float | None = None
    converged: bool = True
    warnings: list[str] = field(default_factory=list)
    seconds: float = 0.0
    history: list[float] = field(default_factory=list)

    def rows(self) -> list[tuple[str, str]]:
        """The table's rows, as pairs of text."""
        rows = [(name, f"{value:,}") for name, value in self.counts.items()]
        rows += [(name, f"{value:.4g}") for name, value in self.quality.items()]
        if self.iterations:
            rows.append(("iterations", str(self.iterations)))
        if self.residual is not None:
            rows.append(("residual", f"{self.residual:.3g}"))
        if not self.converged:
            rows.append(("converged", "no"))
        rows.append(("seconds", f"{self.seconds:.3g}"))
        rows += [("warning", text) for text in self.warnings]
        return rows

    def __str__(self) -> str:
        rows = self.rows()
        width = max(len(name) for name, _ in rows)
        return "\n".join([self.operation or "report"] + [f"  {name:<{width}}  {text}" for name, text in rows])


class Result(NamedTuple):
    """A mesh (`Mesh`, `PolyhedralMesh`, `StructuredGrid` or `MultiBlock`) and the `Report` of how it was made.

    Examples
    --------
    >>> mesh, report = Result("a mesh", Report("Demo"))
    >>> mesh
    'a mesh'
    """

    mesh: Any
    report: Report
