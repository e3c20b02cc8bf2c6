"""The tree of errors, and what its members carry."""

import numpy as np
import pytest

from meshcore import errors


def test_every_error_is_a_meshcore_error_and_a_builtin_one():
    assert issubclass(errors.InvalidInput, (errors.MeshcoreError, ValueError))
    assert issubclass(errors.InvalidGeometry, errors.InvalidInput)
    assert issubclass(errors.GenerationFailed, (errors.MeshcoreError, RuntimeError))
    assert issubclass(errors.MissingLibrary, (errors.MeshcoreError, ImportError))
    assert issubclass(errors.Cancelled, errors.MeshcoreError)


def test_the_parameter_leads_the_message():
    error = errors.InvalidInput("must be at least 1, got 0", parameter="layers")
    assert str(error) == "layers: must be at least 1, got 0"
    assert error.parameter == "layers"


def test_places_become_plain_numbers():
    error = errors.InvalidGeometry("crosses", points=np.array([3, 5]), cells=[np.int32(7)])
    assert error.points == (3, 5) and error.cells == (7,)
    assert {type(k) for k in error.points + error.cells} == {int}


def test_a_failure_keeps_what_was_reached():
    partial = object()
    error = errors.GenerationFailed("tangled", cells=[1], partial=partial)
    assert error.partial is partial and error.cells == (1,)


def test_a_missing_library_tells_how_to_get_it():
    with pytest.raises(ImportError, match="pip install pyvista"):
        raise errors.MissingLibrary("pyvista", "a picture")
