"""One solve by a contact code, in a process of its own: its memory is then its own, too.

``python peer_solve.py CODE HEIGHTS.npy PRESSURE PIXEL ALLOWED`` presses heights of unit
period onto a half-space of E* = 1 with that mean pressure. The code's tolerance is tightened by decades until
the share of points it has in contact is within ALLOWED of PIXEL. What the last solve took is printed as JSON,
and its pressures are left in pressure.npy beside the heights, for areas to be read off all codes alike.
"""

from __future__ import annotations

import json
import sys
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from validation.arrays import Array

__all__ = ["OWN", "SOLVERS", "main"]

_TOLERANCES = tuple(10.0**-k for k in range(2, 12))


def tamaas_pressure(heights: Array, mean_pressure: float, tolerance: float) -> Array:
    """Solve with the Polonsky-Keer solver of tamaas."""
    import tamaas

    model = tamaas.ModelFactory.createModel(tamaas.model_type.basic_2d, [1.0, 1.0], list(heights.shape))
    model.E, model.nu = 1.0, 0.0
    kind = tamaas.PolonskyKeerRey
    solver = kind(model, heights, tolerance, kind.pressure, kind.pressure)
    solver.max_iter = 100_000
    solver.solve(mean_pressure)
    return np.array(model.traction)


def contact_mechanics_pressure(heights: Array, mean_pressure: float, tolerance: float) -> Array:
    """Solve with the constrained conjugate gradients of ContactMechanics."""
    import ContactMechanics
    import SurfaceTopography

    substrate = ContactMechanics.PeriodicFFTElasticHalfSpace(heights.shape, 1.0, (1.0, 1.0), fft="numpy")
    topography = SurfaceTopography.Topography(heights, (1.0, 1.0), periodic=True)
    system = ContactMechanics.make_system(substrate=substrate, surface=topography)
    # Its tolerance is a length: the largest penetration.
    outcome = system.minimize_proxy(
        external_force=mean_pressure, pentol=tolerance * float(np.std(heights)), maxiter=20_000
    )
    return np.array(outcome.jac) * heights.size


def own_pressure(heights: Array, mean_pressure: float, tolerance: float) -> Array:
    """Solve with the boundary elements of this project, to be measured as the others are."""
    from fem_contact import HalfSpace, HeightField, Solid, bem

    half_space = HalfSpace(solid=Solid(young=1.0, poisson=0.0))
    surface = HeightField(heights=heights, lengths=(1.0, 1.0))
    return bem.solve(
        surface, half_space, mean_pressure=mean_pressure, tolerance=tolerance, threads=1
    ).pressure


OWN = "fem_contact"

#: By the name of the code's package.
SOLVERS: dict[str, Callable[[Array, float, float], Array]] = {
    "tamaas": tamaas_pressure,
    "ContactMechanics": contact_mechanics_pressure,
    OWN: own_pressure,
}


def _peak_bytes(*, reset: bool = False) -> float:
    """Return the largest memory of this process since the last reset; NaN where the system does not say."""
    try:
        if reset:  # what imports and compiling took has been given back
            Path("/proc/self/clear_refs").write_text("5", encoding="ascii")
        lines = Path("/proc/self/status").read_text(encoding="utf-8").splitlines()
        return 1024.0 * next(int(line.split()[1]) for line in lines if line.startswith("VmHWM"))
    except (OSError, StopIteration):
        return float("nan")


def main(arguments: list[str]) -> dict[str, Any]:
    """Solve as the arguments say, and return what it took."""
    code, file, pressure, pixel, allowed = arguments
    heights, solve = np.load(file), SOLVERS[code]
    warnings.simplefilter("ignore")
    solve(np.ascontiguousarray(heights[::4, ::4]), float(pressure), 1e-3)
    before = _peak_bytes(reset=True)
    for tolerance in _TOLERANCES:
        clock = time.process_time()
        pressures = solve(heights.copy(), float(pressure), tolerance)
        seconds = time.process_time() - clock
        found = float(np.mean(pressures > 0))
        error = abs(found - float(pixel))
        if error <= float(allowed):
            break
    grown = _peak_bytes() - before
    np.save(Path(file).with_name("pressure.npy"), pressures)
    return {"seconds": seconds, "tolerance": tolerance, "solver_error": error, "peak_bytes": grown}


if __name__ == "__main__":
    print(json.dumps(main(sys.argv[1:])))
