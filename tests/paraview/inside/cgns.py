"""What meshcore writes as CGNS, in ParaView's own reader: blocks, cells, families."""

# ruff: noqa: F403, F405  (the star import is how users' scripts for ParaView begin)

from __future__ import annotations

import json

from harness import OUT, run_checks
from paraview.simple import *


def check_blocks_and_families():
    for name, expected in json.loads((OUT / "cgns.json").read_text()).items():
        reader = CGNSSeriesReader(FileNames=[str(OUT / name)])
        reader.UpdatePipeline()
        found = reader.GetDataInformation()
        assert found.GetNumberOfCells() == expected["cells"], (name, found.GetNumberOfCells())
        assert found.GetNumberOfPoints() == expected["points"], (name, found.GetNumberOfPoints())
        assert list(reader.GetProperty("Families").Available) == expected["families"]


if __name__ == "__main__":
    run_checks(globals())
