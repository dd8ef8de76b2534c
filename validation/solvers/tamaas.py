"""The Polonsky-Keer solver of tamaas, by FFT boundary elements written in C++."""

from __future__ import annotations

import numpy as np

from validation.arrays import Array
from validation.solvers.external import ExternalSolver

#: What it adds up as its error is not what is asked for: it is asked for as much less.
_SAFETY = 0.1


class Tamaas(ExternalSolver):
    """Polonsky and Keer's conjugate gradients of tamaas; where the solid yields, Kato's projections."""

    name = "tamaas"
    label = "tamaas"
    package = "tamaas"
    slots = frozenset({"pressure bound"})
    locates_edges = True
    papers = ("tamaas: [frerot2020].",)


def solve(
    heights: Array,
    lengths: tuple[float, float],
    *,
    contact_modulus: float,
    mean_pressure: float | None,
    tolerance: float,
    offset: float = 0.0,
    hardness: float | None = None,
    max_iterations: int = 100_000,
) -> Array:
    """Return pressures [Pa]; E* = 1 and the longer period 1 go in, as its tolerances have units.

    It returns a number that it calls error and does not say whether that is small enough.
    """
    import tamaas

    tamaas.set_log_level(tamaas.LogLevel.error)
    scale = max(lengths)
    sides = [length / scale for length in lengths]
    model = tamaas.ModelFactory.createModel(tamaas.model_type.basic_2d, sides, list(heights.shape))
    model.E, model.nu = 1.0, 0.0
    surface = np.ascontiguousarray((heights - heights.mean()) / scale)
    if hardness is not None:
        solver = tamaas.KatoSaturated(model, surface, _SAFETY * tolerance, hardness / contact_modulus)
    else:
        kind = tamaas.PolonskyKeerRey
        primal = kind.gap if mean_pressure is None else kind.pressure
        solver = kind(model, surface, _SAFETY * tolerance, primal, primal)
    solver.max_iter = max_iterations
    # Its gap is that above the mean plane, which was taken off.
    solver.solve(
        (offset - heights.mean()) / scale if mean_pressure is None else mean_pressure / contact_modulus
    )
    return np.array(model.traction) * contact_modulus
