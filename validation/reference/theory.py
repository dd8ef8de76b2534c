"""What Persson's theory says of the quantities of the reference table."""

import functools
from collections.abc import Mapping

import numpy as np

from contact_checks import Checks
from persson import elastic, separation
from persson.scale import Scale
from persson.spectrum import SelfAffine
from validation.arrays import Array
from validation.errors import UsageError

#: What refuses a question to the table.
CHECK = Checks(UsageError, least=0.0, greatest=1e300)
#: L/lambda_long of the tables that are shipped.
_PERIODS = 4.0
#: p* at which the theory has full contact.
_FULL = 1e3


def table_spectrum(
    *, hurst: float, bandwidth: float, lowest: float = 1.0, rms_gradient: float = 1.0, q_long: float = 1.0
) -> SelfAffine:
    """Return C(q) of a cell, its plateau from `lowest` times q_long to q_long; none from 1."""
    waves = {"q_long": q_long, "q_short": bandwidth * q_long, "q_min": lowest * q_long}
    return SelfAffine.from_rms_gradient(rms_gradient, hurst=hurst, rolloff="plateau", **waves)


def lowest_wave(*, periods: float = _PERIODS, rolloff: str = "sharp", **_: object) -> float:
    """Return q_min/q_long of surfaces, of those of a table by its attributes."""
    CHECK.choice("rolloff", rolloff, ("sharp", "plateau"))
    return 1 / periods if rolloff == "plateau" else 1.0


def persson_theory(
    *, hurst: float, bandwidth: float, reduced_pressure: float, rolloff: str = "sharp"
) -> Mapping[str, float]:
    """Return what Persson's theory says of the quantities of the table, for the same C(q), and of kappa.

    Examples
    --------
    >>> persson_theory(hurst=0.8, bandwidth=8, reduced_pressure=1e-3)["kappa"]  # (8/pi)^(1/2)
    1.595...
    """
    values = theory_at_nodes((hurst,), (bandwidth,), (reduced_pressure,), lowest_wave(rolloff=rolloff))
    theory = {name: float(value[0, 0, 0]) for name, value in values.items()}
    return {"area": theory["area"], "kappa": theory["area"] / reduced_pressure, **theory}


@functools.lru_cache(maxsize=16)
def theory_at_nodes(
    hursts: tuple[float, ...], bandwidths: tuple[float, ...], loads: tuple[float, ...], lowest: float
) -> Mapping[str, Array]:
    """Return the same over (hurst, bandwidth, reduced_pressure)."""
    pressures = np.array(loads)
    made: dict[str, Array] = {
        name: np.empty((len(hursts), len(bandwidths), pressures.size))
        for name in ("area", "gap", "compliance", "energy_ratio")
    }
    for place in np.ndindex(len(hursts), len(bandwidths)):
        spectrum = table_spectrum(hurst=hursts[place[0]], bandwidth=bandwidths[place[1]], lowest=lowest)
        scale = Scale(spectrum=spectrum, contact_modulus=1.0)
        height = float(spectrum.m0()) ** 0.5
        *stored, full = separation.elastic_energy(np.array([*loads, _FULL]), scale=scale)
        stiffness = separation.contact_stiffness(pressures, scale=scale)
        made["area"][place] = elastic.persson_kappa(pressures) * pressures
        made["gap"][place] = separation.mean_separation(pressures, scale=scale) / height
        made["compliance"][place] = pressures / (stiffness * height)
        made["energy_ratio"][place] = np.array(stored) / full
    return made
