"""How does the contact area fall as shorter and shorter waves are added to one surface?"""

import itertools

import numpy as np
import xarray as xr

from persson import elastic
from validation.errors import UsageError
from validation.measurements.common import SHIFTS, Ladder, Rising
from validation.measurements.limits import limits_of
from validation.measurements.measurement import TOLERANCE, press_on_grids, truncated_heights
from validation.measurements.theory import modes_finding
from validation.report.estimates import derive, mean
from validation.report.views import Figure, Table, Views, against, finding
from validation.studies._options import Bandwidth, Shifts, Surfaces
from validation.studies._scene import PressedOptions
from validation.studies._study import Bench, Call, gathered


class Options(PressedOptions):
    """What is pressed, and which of its waves are there."""

    plain = "it follows the area of the elastic half-space wave by wave (Eq. 20)"

    reduced_pressures: Rising = (0.05, 0.2)
    """p* = p0 / (E* h'_rms) with the gradient of all waves, rising"""
    magnifications: Rising = (1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0)
    """zeta = q/q_long of the last wave there is, rising"""
    bandwidth: Bandwidth = 16.0
    surfaces: Surfaces = 4
    shifts: Shifts = SHIFTS
    points_per_wave: Ladder = (3.0, 6.0)
    """grids, as the shortest wave of all over dx, rising"""


def design(options: Options) -> dict[tuple[int, float], Call]:
    """Return the solves by surface and magnification."""
    q_long, grids = 2 * np.pi / options.first.longest, options.grids_for(options.points_per_wave)
    least = options.magnifications[0]
    left = truncated_heights(options.first, grids[0], truncation=least * q_long)
    if left.rms_gradient < 1e-9 * options.first.field.rms_gradient:
        raise UsageError(f"magnifications = {least:g}, the first: leaves no wave, must be larger")
    return {
        (k, zeta): press_on_grids(
            problem=problem,
            truncation=zeta * q_long,
            reduced_pressures=options.reduced_pressures,
            grids=grids,
            shifts=options.shifts,
            tolerance=options.tolerance(TOLERANCE),
        )
        for (k, problem), zeta in itertools.product(enumerate(options.pressed), options.magnifications)
    }


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Press every surface with its waves up to each magnification, always at the same nominal pressures.

    Area (surface, magnification, load), its mean over the surfaces, and the theory told the realised gradient of
    the waves that are there, or C(q) alone up to that magnification.
    """
    first, q_long = options.first, 2 * np.pi / options.first.longest

    def limits(measured: xr.Dataset, call: Call) -> xr.Dataset:
        # On the finest grid: on one coarser than a map its gradient is not that of its waves.
        cut = truncated_heights(call["problem"], call["grids"][-1], truncation=call["truncation"])
        return limits_of(measured, drift=False).assign(truncated_gradient_each=cut.rms_gradient)

    data = gathered(bench, design(options), limits, "surface", "magnification")
    data["stress_variance_ensemble"] = xr.full_like(data.magnification, np.nan)
    if first.spectrum is not None:
        q = np.minimum(data.magnification * q_long, first.spectrum.q_short)
        variance = elastic.stress_variance(first.spectrum.m2(q.values), contact_modulus=1.0)
        data["stress_variance_ensemble"] = ("magnification", variance)
    # p* h'_rms of all waves is p0/E*: p* of a truncated surface grows as its gradient shrinks. V is over E*^2.
    data = derive(
        data,
        area_persson_each="erf(2**.5 * reduced_pressure * rms_gradient_each / truncated_gradient_each)",
        area_ensemble_each="erf(reduced_pressure * rms_gradient_each / sqrt(2 * stress_variance_ensemble))",
        area_ratio_each="area_each / area_persson_each",
        area_change_each="area_each / area_each.isel(magnification=0) - 1",
    )
    data = mean(data, "area", "area_persson", "area_ensemble", "area_ratio", "area_change")
    return data.assign_attrs(options.spectrum_words)


def views(data: xr.Dataset) -> Views:
    """Area against magnification at each load, simulation and theory."""
    last = data.isel(magnification=-1).assign(
        start=data.area.isel(magnification=0), start_error=data.area_error.isel(magnification=0)
    )
    form = "From zeta = {zeta:~} to {magnification}, at one nominal pressure, the area {each}."
    item = "{verdict} from {start:~} to {area} at p* = {reduced_pressure}, there {area_ratio} of Persson's"
    falls = finding("trend", form, last, item=item, by="area_change", zeta=data.magnification[0])
    areas = ("area", "area_persson", "area_ensemble")
    columns = ("reduced_pressure", "magnification", *areas, "area_ratio")
    return Views(
        table=Table(("load", "magnification"), columns),
        budget=("area",),
        figures=[
            Figure(
                "area-against-magnification",
                "Contact area of one nominal pressure as shorter waves are added.",
                [against("magnification", *areas, by="load", log="xy")],
            )
        ],
        findings=[falls, modes_finding(data.sel(magnification=data.magnification >= _ROUGH))],
    )


#: Magnification from which on the sum over waves and the integral over C(q) can be compared.
_ROUGH = 2.0
