"""A mesh made by hand is checked as one that is planned."""

import dataclasses

import numpy as np
import pytest

from fem_contact.block.mesh import plan_mesh
from fem_contact.errors import InvalidInput

MESH = plan_mesh((8, 8), (1.0, 1.0))


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"cells": (0, 8)}, r"cells = \(0, 8\): must be"),
        ({"cells": "x"}, "must be"),
        ({"aspect": 0.0}, "aspect = 0"),
        ({"aspect": np.nan}, "aspect = nan"),
        ({"layers": np.array([1.0, -1.0])}, "the thinnest is -1"),
        ({"layers": np.array([])}, "at least 1 numbers"),
        ({"layers": None}, "layers = None"),
        ({"element": "Hex1"}, "element = 'Hex1': must be an `Element`"),
    ],
)
def test_a_mesh_that_cannot_be_is_refused(changed, words):
    with pytest.raises(InvalidInput, match=words):
        dataclasses.replace(MESH, **changed)
