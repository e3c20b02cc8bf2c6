"""The registry's snapshot: identifiers, parameters and labels stand in users' files, so a change is deliberate.

`make registry` writes it anew.
"""

import json
from pathlib import Path

import pytest

import meshcore
from meshcore import gallery

SNAPSHOT = Path(__file__).resolve().parent.parent / "registry.json"


def declarations() -> dict:
    """What the registry declares now."""
    return {name: op.declaration() for name, op in meshcore.operations().items()}


def test_the_registry_is_as_it_was():
    assert json.loads(SNAPSHOT.read_text()) == json.loads(json.dumps(declarations()))


@pytest.mark.parametrize("name", meshcore.operations())
def test_every_operation_is_public_and_has_a_model_call(name):
    op = meshcore.operations()[name]
    assert getattr(meshcore, name) is op.function
    inputs, keywords = gallery.arguments(name)
    mesh, report = op.function(*inputs, **keywords)
    assert mesh.n_cells > 0 and report.converged
    made = {"mesh": "Mesh", "grid": "StructuredGrid", "blocks": "MultiBlock", "polyhedra": "PolyhedralMesh"}
    kinds = [made[kind] for kind in op.output.split(" or ") if kind in made] or [type(inputs[0]).__name__]
    assert type(mesh).__name__ in kinds


if __name__ == "__main__":
    SNAPSHOT.write_text(json.dumps(declarations(), indent=2) + "\n")
