"""Compliances of the elastic solids."""

import numpy as np

from fem_contact.response import HalfSpace, Response
from fem_contact.solid import Solid


def test_half_space_compliance_is_two_over_modulus_and_wavevector() -> None:
    response = HalfSpace(solid=Solid(young=2.0, poisson=0.5))
    assert isinstance(response, Response)
    qx, qy = np.array([0.0, 3.0])[:, None], np.array([0.0, 4.0])[None, :]
    expected = 2 / (2.0 / 0.75 * np.array([[np.inf, 4.0], [3.0, 5.0]]))
    np.testing.assert_allclose(response.compliance(qx, qy), expected, rtol=1e-15)
