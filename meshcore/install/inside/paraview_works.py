"""Runs inside pvpython: makes a small mesh by meshcore, and tells where its compiled kernels are kept."""

import json
import sys


def works(packages):
    """Versions, and the folder of compiled kernels, after a real call."""
    if packages not in sys.path:
        sys.path.append(packages)
    import numba

    import meshcore
    import meshcore._numba
    import meshcore.gallery

    positional, keywords = meshcore.gallery.arguments("refined")
    mesh, _ = meshcore.operations()["refined"].function(*positional, **keywords)
    return {
        "meshcore": meshcore.__version__,
        "numba": numba.__version__,
        "cells": mesh.n_cells,
        "cache": str(meshcore._numba.cache_folder()),
    }


if __name__ == "__main__":
    print("MESHCORE " + json.dumps(works(sys.argv[-1])))
