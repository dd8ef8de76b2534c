"""What theories say along a path of loads: area, gap, energy, compliance, P(sigma)."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from persson.spectrum import Moments
from validation.arrays import Array
from validation.measurements.measurement import STRESS_EDGES
from validation.measurements.theory import Waves
from validation.report.estimates import derive
from validation.report.findings import Finding, ranking
from validation.report.values import value_of
from validation.scenes.problem import ContactProblem
from validation.theories.base import Rough, Theory

#: Step in ln p0 by which a theory is differentiated.
_STEP = 0.01
#: Gauss points in each bin of the distribution of pressure.
_POINTS = 8
#: What is compared as a ratio.
COMPARED = ("area", "gap", "compliance", "energy_ratio")
#: A gap smaller than this, over h_rms, is closed; contact is nearly full from this area on.
_CLOSED, NEARLY_FULL = 1e-9, 0.9


def predictions(
    theories: Sequence[Theory], pressed: Sequence[ContactProblem], reduced_pressures: Sequence[float]
) -> xr.Dataset:
    """Return what theories say, means over the surfaces; NaN where one says nothing.

    Over (theory, load) ``area_predicted``, ``gap_predicted`` (over h_rms), ``energy_ratio_predicted`` and
    ``compliance_predicted`` (p0/(K h_rms) = -d gap/d ln p0 / h_rms), told each realised surface; and the
    same with ``_spectral``, told C(q) alone.
    """
    loads = np.asarray(reduced_pressures, dtype=float)
    # Without scatter of the amplitudes every surface has the same waves; no theory knows of phases.
    several = getattr(pressed[0].surface, "amplitudes", "") == "gaussian"
    surfaces = [Rough.of(case) for case in (pressed if several else pressed[:1])]
    nothing, data = np.full(loads.size, np.nan), {}
    # Each surface meets its own nominal pressure; C(q) does not know which surface it is.
    told = {
        "predicted": [(one, one) for one in surfaces],
        "spectral": [(rough, one) for one in surfaces for rough in _expected(surfaces)],
    }
    for ending, pairs in told.items():
        said = [[_along(theory, rough, loads, units=one) for rough, one in pairs] for theory in theories]
        for name in COMPARED:
            means = [np.mean([along[name] for along in row], axis=0) if row else nothing for row in said]
            data[f"{name}_{ending}"] = ("theory", "load"), means, {"reduction": "theory"}
    return xr.Dataset(data, coords={"theory": [theory.label for theory in theories]})


def _expected(surfaces: Sequence[Rough]) -> list[Rough]:
    """Return what C(q) alone lets one expect: as rough as it says, with the scatter of the realised."""
    spectrum = surfaces[0].spectrum
    if spectrum is None:
        return []
    waves = Waves.of_spectrum(spectrum)
    m0, m2, m4 = float(spectrum.m0()), float(spectrum.m2()), float(spectrum.m4())
    squares = np.array([rough.moments.m2 for rough in surfaces])
    return [
        replace(surfaces[0], waves=waves, moments=Moments(m0=m0, m2=m2 * share, m4=m4))
        for share in squares / squares.mean()
    ]


def _along(theory: Theory, rough: Rough, loads: Array, *, units: Rough) -> dict[str, Array]:
    """One theory of one surface; loads and results are in the units of the surface `units`."""
    pressure = loads * units.contact_modulus * units.moments.rms_gradient
    height, full = units.moments.rms_height, units.waves.full_energy * units.contact_modulus
    nothing = np.full(loads.shape, np.nan)
    gap, energy = theory.mean_gap(pressure, rough), theory.elastic_energy(pressure, rough)

    def rise(of: Callable[[Array, Rough], Any]) -> Array:
        """Differentiate by ln p0."""
        up, down = (of(pressure * np.exp(step), rough) for step in (_STEP, -_STEP))
        return np.asarray(up - down) / (2 * _STEP)

    compliance = nothing
    if energy is not None:  # -d gap = dU / p
        compliance = rise(theory.elastic_energy) / (pressure * height)
    elif gap is not None:
        compliance = -rise(theory.mean_gap) / height
    return {
        "area": theory.area(pressure, rough),
        "gap": nothing if gap is None else gap / height,
        "energy_ratio": nothing if energy is None else energy / full,
        "compliance": compliance,
    }


def beside(data: xr.Dataset, theories: Sequence[Theory], pressed: Sequence[ContactProblem]) -> xr.Dataset:
    """Add to a path of loads what theories say, and simulated over predicted values ``_over`` (theory, load).

    Gap, compliance and energy have none where the contact is full: nothing is left of the first two, and the
    energy is known. The area of the first theory is ``area_persson``, told C(q) alone ``area_ensemble``.
    """
    data = data.merge(predictions(theories, pressed, data.reduced_pressure.values)).assign(agreement=1.0)
    for name, predicted in (("area_persson", "area_predicted"), ("area_ensemble", "area_spectral")):
        data[name] = data[predicted].isel(theory=0, drop=True)
    partly = data.gap_finest_each.max("surface") > _CLOSED
    data["partial_contact"] = partly.where(partly).astype(float).drop_attrs()
    open_only = {f"{name}_over": f"{name} / {name}_predicted * partial_contact" for name in COMPARED[1:]}
    return derive(data, area_over="area / area_predicted", **open_only)


def distances(data: xr.Dataset) -> xr.Dataset:
    """Add ``_off`` (theory): mean of abs ln of simulated over predicted values, below nearly full contact.

    From there on little is left of gap and compliance, and what theories miss of them has no bound. NaN for a
    theory that does not reach all of these loads. The errors at all loads are those of the same surfaces and
    grids: they are averaged as they are and do not shrink.
    """
    partly = data.isel(load=np.flatnonzero(data.area.values < NEARLY_FULL))
    for name in COMPARED:
        over = partly[f"{name}_over"]
        with np.errstate(invalid="ignore", divide="ignore"):  # a theory of one's own may say anything
            off = over.copy(data=abs(np.log(over.values))).mean("load", skipna=False)
        made = {"reduction": "mean distance", "of": f"{name}_over", "below": NEARLY_FULL}
        error = (partly[f"{name}_over_error"] / over).mean("load", skipna=False)
        data[f"{name}_off"], data[f"{name}_off_error"] = off.drop_attrs().assign_attrs(made), error
    return data


def ranked(form: str, data: xr.Dataset, name: str) -> Finding:
    """Return the order of the theories that reach all loads, by their distances; see `ranking`.

    All are judged by the same simulated values: what these may be off by moves two theories on one side of
    them alike, and those on opposite sides twice.
    """
    partly = data.isel(load=np.flatnonzero(data.area.values < NEARLY_FULL))
    over, off = partly[f"{name}_over"], f"{name}_off"
    moved = (partly[f"{name}_over_error"] / over).transpose("source", "theory", "load")

    def between(one: str, other: str) -> float:
        def apart(share: Any) -> Array:
            first, second = (abs(np.log(over.sel(theory=label).values) + share) for label in (one, other))
            return np.asarray(first - second)

        errors = moved.sel(theory=one).values
        half = np.maximum(*(abs(apart(sign * errors) - apart(0.0)) for sign in (1, -1))).mean(-1)
        joint = data[[off, f"{off}_error"]].sel(theory=one)
        error = value_of(joint.assign({f"{off}_error": ("source", half)}), off).error
        return math.nan if error is None else error

    places = {str(label): data.sel(theory=label) for label in data.theory.values}
    numbers = {label: value_of(here, off) for label, here in places.items()}
    reaching = {label: value for label, value in numbers.items() if np.isfinite(float(value.value))}
    return ranking(form, reaching, between)


def stress_shares(theory: Theory, problem: ContactProblem, reduced_pressures: Sequence[float]) -> Array:
    """Shares of the nominal area by pressure, (load, bin) over `STRESS_EDGES`; NaN without a P(sigma)."""
    x, weights = np.polynomial.legendre.leggauss(_POINTS)
    stress = STRESS_EDGES[:-1, None] + np.diff(STRESS_EDGES)[:, None] * (1 + x) / 2
    rough = Rough.of(problem)
    unit = rough.contact_modulus * rough.moments.rms_gradient
    shares = np.full((len(reduced_pressures), STRESS_EDGES.size - 1), np.nan)
    for j, load in enumerate(reduced_pressures):
        density = theory.pressure_distribution((stress * unit).ravel(), load * unit, rough)
        area = float(theory.area(np.array([load * unit]), rough)[0])
        if density is None or not np.isfinite(area):
            continue
        shares[j] = (density.reshape(stress.shape) @ weights) * np.diff(STRESS_EDGES) / 2 * unit
        # What lies above the last edge counts in the last bin.
        shares[j, -1] += max(area - shares[j].sum(), 0.0)
    return shares
