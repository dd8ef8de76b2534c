"""Other ways to call the peers than their methods do, in which their known failures show."""

import warnings

import numpy as np


def tamaas_by_gaps(heights, lengths, *, contact_modulus, mean_pressure, tolerance, max_iterations=10_000):
    """Return pressures [Pa] of tamaas with the gap as its unknown, which it offers beside the pressure."""
    import tamaas

    tamaas.set_log_level(tamaas.LogLevel.error)
    model = tamaas.ModelFactory.createModel(tamaas.model_type.basic_2d, list(lengths), list(heights.shape))
    model.E, model.nu = contact_modulus, 0.0
    kind = tamaas.PolonskyKeerRey
    solver = kind(model, np.ascontiguousarray(heights), tolerance, kind.gap, kind.pressure)
    solver.max_iter = max_iterations
    solver.solve(mean_pressure)
    return np.array(model.traction)


def contact_mechanics_by_default(
    heights, lengths, *, contact_modulus, mean_pressure, offset=None, tolerance, max_iterations=10_000
):
    """Return pressures [Pa] of ContactMechanics in the units of the user, with its own tolerances of forces.

    At an offset its half-space has a mean displacement as stiff as its longest waves.
    """
    import ContactMechanics
    import SurfaceTopography

    warnings.simplefilter("ignore")
    substrate = ContactMechanics.PeriodicFFTElasticHalfSpace(
        heights.shape, contact_modulus, lengths, fft="numpy"
    )
    surface = SurfaceTopography.Topography(np.array(heights), lengths, periodic=True)
    system = ContactMechanics.make_system(substrate=substrate, surface=surface)
    told = {"pentol": tolerance * float(np.std(heights))}
    if mean_pressure is None:
        assert offset is not None
        told["offset"] = -offset
    else:
        told["external_force"] = mean_pressure * lengths[0] * lengths[1]
    outcome = system.minimize_proxy(maxiter=max_iterations, **told)
    cell = lengths[0] * lengths[1] / heights.size
    return {"pressure": np.array(outcome.jac) / cell, "converged": bool(outcome.success)}
