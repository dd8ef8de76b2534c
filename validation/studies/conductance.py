"""How well does a rough contact conduct, and how stiff is it, from a few spots to full contact?

The contact set is held and pressed a little further: the stiffness, which is the electrical and the thermal conductance
in other units (Barber 2003). A light contact of few long waves stands on few spots, so the sample size is a dial.
"""

import numpy as np
import xarray as xr

from validation.measurements.common import SHIFTS, Rising, RisingSeveral, base_case
from validation.measurements.flow import stiffness_of
from validation.measurements.measurement import grids_for, press_on_grids
from validation.measurements.theory import WITH_ENERGY
from validation.report.estimates import claim, derive, mean, same_of_all
from validation.report.places import spread
from validation.report.views import Figure, Findings, Level, Table, Views, against, finding
from validation.studies._options import Bandwidth, Shifts, SurfaceOptions, Surfaces
from validation.studies._study import ABSENT, Bench, Call, gathered

_THEORY = [f"stiffness_{variant}" for variant in WITH_ENERGY]
#: Light load, as p*: there the stiffness should go with the load.
_LIGHT = 0.05


class Options(SurfaceOptions):
    """What is pressed, and how large the sample is."""

    why_no_scene = "it asks about spectra, and makes a surface for each"

    reduced_pressures: RisingSeveral = (0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0)
    """p* = p0 / (E* h'_rms) with the realised gradient of each surface, rising"""
    periods: Rising = (1.0, 2.0, 4.0)
    """L / lambda_long: sizes of the sample, rising"""
    bandwidth: Bandwidth = 8.0
    surfaces: Surfaces = 8
    shifts: Shifts = SHIFTS
    points_per_wave: RisingSeveral = (4.0, 8.0)
    """grids, as lambda_short/dx; the finest gives the value, its distance to the one before the uncertainty"""


def design(options: Options) -> dict[tuple[float, int], Call]:
    """Return the solves by size of the sample and number of the surface."""
    cases = {}
    for periods in options.periods:
        base = base_case(options.self_affine(periods=periods), reduced_pressure=options.reduced_pressures[0])
        grids = grids_for(base, options.points_per_wave)
        for k in range(options.surfaces):
            cases[periods, k] = press_on_grids(
                problem=base.further(k),
                reduced_pressures=options.reduced_pressures,
                grids=grids,
                shifts=options.shifts,
                keep=("stiffness",),
            )
    return cases


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Press every surface of every size along the path of loads, and move each frozen contact.

    Stiffness K h_rms / p0, mean gap and area on the finest grid (periods, surface, load), beside the theory's;
    local power of the load with which the stiffness goes (periods, surface, step), and its mean at light load.
    """
    data = gathered(
        bench, design(options), lambda d, call: stiffness_of(d, call["problem"]), "periods", "surface"
    )
    loads = np.array(options.reduced_pressures)
    data = data.assign_coords(reduced_pressure_between=("step", np.sqrt(loads[1:] * loads[:-1])))
    power = "1 + log(stiffness_each).diff('load') / log(reduced_pressure).diff('load')"
    light = f"stiffness_exponent_each.where(reduced_pressure_between <= {_LIGHT}).mean('step')"
    data = derive(
        data,
        stiffness_exponent_each=f"({power}).drop_vars('reduced_pressure').rename(load='step')",
        stiffness_exponent_light_each=light,
        **{f"stiffness_ratio_{v}_each": f"stiffness_{v}_each / stiffness_each" for v in WITH_ENERGY},
        **{f"stiffness_excess_{v}_each": f"stiffness_each / stiffness_{v}_each - 1" for v in WITH_ENERGY},
    )
    data = same_of_all(data, *_THEORY)
    theory = [f"stiffness_{of}_{variant}" for of in ("ratio", "excess") for variant in WITH_ENERGY]
    data = mean(data, "stiffness", "gap", "area_perimeter", "stiffness_exponent", *theory)
    data = mean(data, "stiffness_exponent_light").assign(stiffness_exponent_proportional=1.0)
    data = claim(data, "stiffness", "stiffness_exponent", "stiffness_exponent_light", **ABSENT)
    data = derive(data, stiffness_exponent_light_excess="stiffness_exponent_light - 1")
    return data.assign_attrs(methods="theory bem", hurst=options.hurst, bandwidth=options.bandwidth)


def views(data: xr.Dataset) -> Views:
    """Stiffness over the load for every size, beside the theory, and its power of the load."""
    proportional = Level("stiffness_exponent_proportional", look={"color": "black", "lw": 0.8, "ls": "-"})
    power, last = ("stiffness_exponent", proportional), {"periods": data.sizes["periods"] - 1}
    ratios = [f"stiffness_ratio_{variant}" for variant in WITH_ENERGY]
    columns = ("periods", "reduced_pressure", "area_perimeter", "gap", "stiffness", *_THEORY, *ratios)
    return Views(
        table=Table(("periods", "load"), columns),
        budget=("stiffness",),
        figures=[
            Figure(
                "conductance",
                "Contact stiffness, which is the conductance in other units, over the load: by size of the sample (left), "
                "the largest beside the theory (middle), and its local power of the load (right). It is level where the "
                "stiffness goes with the load. Few long waves make a light contact softer than many.",
                [
                    against("reduced_pressure", "stiffness", by="periods", log="xy"),
                    against("reduced_pressure", "stiffness", *_THEORY, log="xy", at=last),
                    against("reduced_pressure_between", *power, by="periods", log="x"),
                ],
            )
        ],
        findings=[*_findings(data)],
    )


def _findings(data: xr.Dataset) -> Findings:
    if bool((data.reduced_pressure_between <= _LIGHT).any()):
        yield finding(
            "comparison",
            "At p* up to {light}, the geometric mean of two loads, the stiffness goes with the load to the power {each}; proportional "
            "would be 1.",
            data,
            item="{stiffness_exponent_light} for L/lambda_long = {periods}, {verdict} 1",
            by="stiffness_exponent_light_excess",
            light=_LIGHT,
        )
    middle = data.isel(periods=-1, load=spread(data, "load"))
    authors = ("Persson's", "Yang and Persson's (2008)", "Wang and Müser's (2017)")
    for variant, whose in zip(WITH_ENERGY, authors, strict=True):
        form = "L/lambda_long = {periods}: K h_rms/p0 is {each}."
        item = f"{{stiffness}} at p* = {{reduced_pressure}}, {{verdict}} {whose} {{stiffness_{variant}:~}}"
        yield finding("comparison", form, middle, item=item, by=f"stiffness_excess_{variant}")
