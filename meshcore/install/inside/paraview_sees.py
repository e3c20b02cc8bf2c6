"""Runs inside pvpython: tells which of the labels given as JSON ParaView offers as sources or filters."""

import json
import sys


def offered(labels):
    """Those labels that are functions of paraview.simple in a fresh session."""
    from paraview import make_name_valid, simple

    return [label for label in labels if hasattr(simple, make_name_valid(label))]


if __name__ == "__main__":
    print("MESHCORE " + json.dumps(offered(json.loads(sys.argv[-1]))))
