"""Runs inside pvpython: draws a sphere into a picture, which crashes where there is no display."""

import json
import os
import sys


def draws(picture):
    """Size in bytes of a picture that ParaView makes."""
    from paraview import simple

    simple.Show(simple.Sphere(), simple.CreateRenderView(ViewSize=[64, 64]))
    simple.SaveScreenshot(picture)
    return os.path.getsize(picture)


if __name__ == "__main__":
    print("MESHCORE " + json.dumps(draws(sys.argv[-1])))
