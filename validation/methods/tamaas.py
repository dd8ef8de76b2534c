"""The Polonsky-Keer solver of tamaas, by FFT boundary elements written in C++."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from validation.methods.base import Settings
from validation.methods.foreign import Foreign
from validation.methods.peers import installed, missing

__all__ = ["Tamaas", "solve"]

Array = NDArray[np.float64]

#: What it adds up as its error is not what is asked for: it is asked for as much less.
_SAFETY = 0.1


class Tamaas(Foreign):
    """Polonsky and Keer's conjugate gradients of tamaas, on the elastic half-space without effects."""

    name = "tamaas"
    label = "tamaas"
    locates_edges = True
    papers = (
        "tamaas: L. Frerot, G. Anciaux, V. Rey, S. Pham-Ba, J.-F. Molinari, J. Open Source Softw. 5, "
        "2121 (2020).",
    )

    def available(self) -> str | None:
        """Say what to install."""
        return missing("tamaas")

    def source(self, settings: Mapping[str, Any]) -> Settings:
        """Return its version."""
        return installed("tamaas")

    def call(self, settings: Mapping[str, Any]) -> tuple[str, Mapping[str, Any]]:
        """Return the function below."""
        return f"{__name__}:solve", {}


def solve(
    heights: Array,
    lengths: tuple[float, float],
    *,
    contact_modulus: float,
    mean_pressure: float,
    tolerance: float,
) -> Array:
    """Return pressures [Pa]; E* = 1 and the longer period 1 go in, as its tolerances have units."""
    import tamaas

    scale = max(lengths)
    sides = [length / scale for length in lengths]
    model = tamaas.ModelFactory.createModel(tamaas.model_type.basic_2d, sides, list(heights.shape))
    model.E, model.nu = 1.0, 0.0
    kind = tamaas.PolonskyKeerRey
    surface = np.ascontiguousarray((heights - heights.mean()) / scale)
    solver = kind(model, surface, _SAFETY * tolerance, kind.pressure, kind.pressure)
    solver.max_iter = 100_000
    solver.solve(mean_pressure / contact_modulus)
    return np.array(model.traction) * contact_modulus
