"""Comparison with ContactMechanics as it is called without us; skipped where it is not installed."""

import numpy as np
import pytest
from surfaces import SOFT, rough_surface

from fem_contact import measure_residuals
from fem_contact.bem import solve


@pytest.mark.parametrize("load", [0.01, 0.1, 0.8])
@pytest.mark.filterwarnings("ignore")
def test_contact_mechanics_agrees_on_pressure(load):
    peer = pytest.importorskip("ContactMechanics")
    surface = rough_surface((64, 64), seed=51, waves=8, longest=2, gradient=1.0)
    ours = solve(surface, SOFT, mean_pressure=load, tolerance=1e-10).checked()
    substrate = peer.PeriodicFFTElasticHalfSpace(surface.shape, 1.0, surface.lengths, fft="numpy")
    topography = pytest.importorskip("SurfaceTopography").Topography(
        surface.heights.copy(), surface.lengths, periodic=True
    )
    system = peer.make_system(substrate=substrate, surface=topography)
    # Forces are per point there, and so are their tolerances; forces on the elastic body count as negative.
    cell = 1 / surface.heights.size
    outcome = system.minimize_proxy(external_force=load, pentol=1e-10 * surface.rms_height, maxiter=20000)
    assert outcome.success
    pressure = np.array(outcome.jac) / cell
    residuals = measure_residuals(
        pressure=pressure,
        gap=ours.gap,
        heights=surface.heights,
        lengths=surface.lengths,
        contact_modulus=1.0,
        rms_gradient=surface.rms_gradient,
        target_pressure=load,
    )
    assert residuals.load < 1e-9
    assert np.linalg.norm(ours.pressure - pressure) < 1e-6 * np.linalg.norm(ours.pressure)
