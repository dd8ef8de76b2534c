"""Comparison with tamaas and ContactMechanics on shared surfaces, and what those codes get wrong.

The comparisons need the codes installed (extra ``peers``) and are skipped otherwise; the regressions do not.
"""

import numpy as np
import pytest
from surfaces import SOFT, rough_surface

from fem_contact import measure_residuals
from fem_contact.bem import solve


def shared_surface(shape=(64, 64), seed=51):
    return rough_surface(shape, seed=seed, waves=min(shape) / 8, longest=2, gradient=1.0)


def difference(result, pressure):
    return float(np.linalg.norm(result.pressure - pressure) / np.linalg.norm(result.pressure))


@pytest.mark.parametrize("load", [0.01, 0.1, 0.8])
@pytest.mark.parametrize("shape", [(64, 64), (48, 64)])
def test_tamaas_agrees_on_pressure(load, shape):
    tamaas = pytest.importorskip("tamaas")
    surface = shared_surface(shape)
    ours = solve(surface, SOFT, mean_pressure=load, tolerance=1e-10).checked()
    model = tamaas.ModelFactory.createModel(tamaas.model_type.basic_2d, [1.0, 1.0], list(shape))
    model.E, model.nu = 1.0, 0.0
    kind = tamaas.PolonskyKeerRey
    solver = kind(model, surface.heights.copy(), 1e-10, kind.pressure, kind.pressure)
    solver.max_iter = 100_000
    solver.solve(load)
    assert difference(ours, np.array(model.traction)) < 1e-6


@pytest.mark.parametrize("load", [0.01, 0.1, 0.8])
@pytest.mark.filterwarnings("ignore")
def test_contact_mechanics_agrees_on_pressure(load):
    peer = pytest.importorskip("ContactMechanics")
    surface = shared_surface()
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
    assert difference(ours, pressure) < 1e-6
