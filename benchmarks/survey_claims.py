"""What the survey says of Delaunay refinement and the advancing front, beside what is found.

``python benchmarks/survey_claims.py [--quick] [--repeats 5]``; near-linear cost is in ``scaling.py``.
"""

from __future__ import annotations

from functools import partial

import numpy as np
from _common import GmshModel, arguments, is_installed, print_claim, print_heading, print_row, taken_alternately

import meshcore
from meshcore import gallery

BOUNDARIES = {
    "square with hole": gallery.square_with_hole,
    "circle": gallery.circle,
    "airfoil in its far field": gallery.airfoil_in_far_field,
}


def angles(points: np.ndarray, triangles: np.ndarray) -> tuple[float, float]:
    """Smallest and largest angle, in degrees."""
    corners = points[triangles]
    found = []
    for k in range(3):
        u, v = corners[:, (k + 1) % 3] - corners[:, k], corners[:, (k + 2) % 3] - corners[:, k]
        found.append(np.degrees(np.arctan2(np.linalg.norm(np.cross(u, v), axis=1), (u * v).sum(axis=1))))
    return float(np.min(found)), float(np.max(found))


def circumcentres(quick: bool) -> None:
    """Angles that insertion at circumcentres reaches."""
    print_heading("Angles by circumcentre refinement", "Each triangle below the bound is removed at its circumcentre.")
    print_row("boundary", "bound", "triangles", "smallest angle", "largest angle", head=True)
    lowest, highest = 180.0, 0.0
    for name, boundary in BOUNDARIES.items():
        for bound in (20.7, 30.0, 33.0):
            outline = boundary()
            box = np.ptp(outline.points[:, :2], axis=0)
            mesh, _ = meshcore.delaunay_refinement(
                outline, min_angle=bound, max_area=box[0] * box[1] / (1e3 if quick else 1e5), placement="circumcentre"
            )
            smallest, largest = angles(mesh.points, mesh.cells["triangle"])
            print_row(name, bound, mesh.n_cells, smallest, largest)
            if bound == 30:
                lowest, highest = min(lowest, smallest), max(highest, largest)
    print_claim(
        "circumcentre insertion gives triangulations (eventually) with angles between 30 and 120 degrees in 2D",
        f"asked for 30 degrees, between {lowest:.2f} and {highest:.2f}",
    )


def front(quick: bool, repeats: int) -> None:
    """Triangles a second by Delaunay refinement and by advancing front, ours and Gmsh's."""
    boundary = gallery.square_with_hole(50)
    size = 0.02 if quick else 0.0045
    run = partial(meshcore.delaunay_refinement, boundary, size=size)
    contestants = {
        "meshcore, circumcentres": lambda: run(placement="circumcentre", min_angle=30).mesh.n_cells,
        "meshcore, advancing front": lambda: run(placement="front").mesh.n_cells,
    }
    times = taken_alternately(contestants, repeats)
    names = {5: "Gmsh, Delaunay", 6: "Gmsh, Frontal-Delaunay"} if is_installed("gmsh") else {}
    for algorithm, name in names.items():
        with GmshModel(boundary, size, algorithm) as mesh:
            times.update(taken_alternately({name: mesh}, min(repeats, 3)))
    print_heading("Delaunay refinement beside the advancing front", f"Square with a hole, edges of {size}.")
    print_row("method", "turns", "triangles", "seconds", "triangles a second", head=True)
    rates = {}
    for name, found in times.items():
        count = found.result if isinstance(found.result, int) else len(found.result[1])
        rates[name] = count / found.seconds
        print_row(name, found.turns, count, found.seconds, rates[name])
    ratios = [f"meshcore {rates['meshcore, circumcentres'] / rates['meshcore, advancing front']:.1f}"]
    if names:
        ratios.append(f"Gmsh {rates['Gmsh, Delaunay'] / rates['Gmsh, Frontal-Delaunay']:.1f}")
    print_claim(
        "the mesh is less smooth than the advancing front method, but the generation is about 10 times faster",
        f"Delaunay is faster by a factor of {', '.join(ratios)}: fronts that insert into a Delaunay triangulation "
        "need none of the searches and intersection tests that the survey's front spends its time on",
    )


def main() -> None:
    """Print both comparisons."""
    options = arguments(__doc__)
    meshcore.delaunay_refinement(gallery.square(), max_area=0.1, placement="circumcentre")  # compiles
    circumcentres(options.quick)
    front(options.quick, options.repeats)


if __name__ == "__main__":
    main()
