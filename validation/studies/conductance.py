"""How well does a rough contact conduct, and how stiff is it, from a few spots to full contact?

The contact set is held and pressed a little further: the stiffness, which is the electrical and the thermal conductance
in other units (Barber 2003). A light contact of few long waves stands on few spots, so the sample size is a dial.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from pydantic import Field

from validation.arrays import Array
from validation.measures.common import (
    SHIFTS,
    Rising,
    base_case,
    base_surface,
    draw_means,
    each,
    means_of,
    named,
    over_surfaces,
    results_of,
)
from validation.measures.flow import StiffMeasurement
from validation.measures.measurement import grid_for
from validation.measures.theory import VARIANTS, WITH_ENERGY, Waves
from validation.report.drawing import Drawing
from validation.report.table import ResultTable
from validation.scenes.realised import Realised
from validation.scenes.scene import SelfAffineSurface
from validation.solves.bench import Bench
from validation.studies._options import Bandwidth, Hurst, Seed, Shifts, Surfaces
from validation.studies._study import StudyOptions

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

__all__ = ["Options", "figures", "findings", "run", "table"]

#: Loads between which the theory's gap is differentiated, relative.
_STEP = 0.01
#: Light load, as p*: there the stiffness should go with the load.
_LIGHT = 0.05


class Options(StudyOptions):
    """What is pressed, and how large the sample is."""

    own = "it asks about spectra, and makes a surface for each"

    reduced_pressures: Rising = Field(
        default=(0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0),
        min_length=2,
        description="p* = p0 / (E* h'_rms) with the realised gradient of each surface, rising",
    )
    periods: Rising = Field(
        default=(1.0, 2.0, 4.0), description="L / lambda_long: sizes of the sample, rising"
    )
    hurst: Hurst = 0.8
    bandwidth: Bandwidth = 8.0
    surfaces: Surfaces = 8
    shifts: Shifts = SHIFTS
    points_per_wave: Rising = Field(
        default=(4.0, 8.0),
        min_length=2,
        description="grids, as lambda_short/dx; the finest gives the value, its distance to the one before the uncertainty",
    )
    seed: Seed = 2006

    def surface(self, periods: float) -> SelfAffineSurface:
        """Return the first surface of one size."""
        return base_surface(hurst=self.hurst, periods=periods, bandwidth=self.bandwidth, seed=self.seed)


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Press every surface of every size along the path of loads, and move each frozen contact.

    Returns
    -------
    xarray.Dataset
        `stiffness` K h_rms / p0 (finest grid, mean over shifts), `grid_error` and `gap` over (periods, surface, load);
        `exponent` d ln K / d ln p0 between neighbouring loads; `theory` over (periods, variant, load).
    """
    import xarray as xr

    cases = _cases(options)
    measured = results_of(bench, cases)
    shape = (len(options.periods), options.surfaces, len(options.reduced_pressures))
    stiffness, grid_error, gap, pixel = (np.empty(shape) for _ in range(4))
    for (i, k), at in zip(cases, np.ndindex(shape[:2]), strict=True):
        data = measured[i, k].mean("shift")
        stiffness[at] = data.stiffness.values[-1]
        grid_error[at] = np.abs(np.diff(data.stiffness.values[-2:], axis=0)[0])
        gap[at] = data.mean_gap.values[-1] / measured[i, k].attrs["rms_height"]
        pixel[at] = data.perimeter.values[-1]
    loads = np.array(options.reduced_pressures)
    exponent = 1 + np.diff(np.log(stiffness), axis=-1) / np.diff(np.log(loads))
    dims = ("sample", "surface", "load")
    words = {
        "stiffness": "K h_rms / p0, finest grid",
        "grid_error": "change of it from the grid before",
        "gap": "mean gap / h_rms, finest grid",
        "area": "A/A0, perimeter-corrected, finest grid",
    }
    values = {"stiffness": stiffness, "grid_error": grid_error, "gap": gap, "area": pixel}
    return xr.Dataset(
        {name: named(dims, values[name], words[name], unit="1") for name in words}
        | {
            "exponent": named(("sample", "surface", "step"), exponent, "d ln K / d ln p0"),
            "theory": named(
                ("sample", "variant", "load"),
                np.array(
                    [_theory([cases[i, k].realised for k in range(shape[1])], loads) for i in range(shape[0])]
                ),
                "K h_rms / p0, theory told the realised surfaces",
            ),
        },
        coords={
            "periods": named("sample", list(options.periods), "L / lambda_long"),
            "reduced_pressure": named("load", loads, "p0 / (E* h'_rms)"),
            "step_pressure": ("step", np.sqrt(loads[1:] * loads[:-1])),
            "variant": list(WITH_ENERGY),
        },
        attrs={
            "study": "conductance",
            "methods": "theory bem",
            "hurst": options.hurst,
            "bandwidth": options.bandwidth,
        },
    )


def _cases(options: Options) -> dict[tuple[int, int], StiffMeasurement]:
    """List one case for each size and surface."""
    found = {}
    for i, periods in enumerate(options.periods):
        base = base_case(options.surface(periods), reduced_pressure=options.reduced_pressures[0])
        grids = tuple(grid_for(base, points) for points in options.points_per_wave)
        for k in range(options.surfaces):
            found[i, k] = StiffMeasurement(
                realised=base.further(k),
                reduced_pressures=options.reduced_pressures,
                grids=grids,
                shifts=options.shifts,
            )
    return found


def _theory(cases: list[Realised], loads: Array) -> Array:
    """K h_rms / p0 = -h_rms / (d gap / d ln p0) of every variant with an energy, mean over the surfaces."""
    values = []
    for case in cases:
        waves, gradient = Waves.of_field(case.field), case.field.rms_gradient
        around = np.sort(np.concatenate([loads * np.exp(-_STEP), loads * np.exp(_STEP)])) * gradient
        gaps = np.array([waves.mean_gap(around, variant) for variant in WITH_ENERGY])
        fall = (gaps[:, 0::2] - gaps[:, 1::2]) / (2 * _STEP)
        values.append(case.field.rms_height / fall)
    return np.asarray(np.mean(values, axis=0))


def table(dataset: xr.Dataset) -> ResultTable:
    """Return one row for each size and load."""
    rows = []
    for here in each(dataset, "sample", "load"):
        mean = over_surfaces(here.stiffness)
        rows.append(
            {
                "L/lambda_long": float(here.periods),
                "p*": float(here.reduced_pressure),
                "A/A0": float(here.area.mean()),
                "K h_rms/p0": mean.value,
                "+- surfaces (95 %)": mean.half_width,
                "+- grid": _grid_share(here),
                **{VARIANTS[name]: float(here.theory[v]) for v, name in enumerate(WITH_ENERGY)},
            }
        )
    return ResultTable.of_rows(rows)


def _grid_share(here: xr.Dataset) -> float:
    """Root mean square over the surfaces of the change from the grid before: grids are off in common."""
    return float(np.sqrt(np.mean(here.grid_error.values**2)))


def findings(dataset: xr.Dataset) -> tuple[str, ...]:
    """Say how the stiffness goes with the load, what the sample size does, and how far the theory is off."""
    last = dataset.sizes["sample"] - 1
    light = [j for j, p in enumerate(dataset.step_pressure.values) if p <= _LIGHT]
    sentences = []
    for i in range(last + 1):
        if not light:
            break
        power = over_surfaces(dataset.exponent[i, :, light].mean("step"))
        sentences.append(
            f"L/lambda_long = {float(dataset.periods[i]):g}: at p* up to {_LIGHT:g} the stiffness goes with the load to the power "
            f"{power} (95 %, {power.samples} surfaces); proportional would be 1."
        )
    for j in sorted({0, dataset.sizes["load"] // 2, dataset.sizes["load"] - 1}):
        here = dataset.isel(sample=last, load=j)
        mean = over_surfaces(here.stiffness)
        sure = float(np.hypot(mean.half_width, _grid_share(here)))
        ratios = ", ".join(
            f"{VARIANTS[name]} {float(here.theory[v]) / mean.value:.3g} times that"
            for v, name in enumerate(WITH_ENERGY)
        )
        sentences.append(
            f"p* = {float(here.reduced_pressure):g}: K h_rms/p0 = {mean.value:.4g} +- {sure:.2g} "
            f"(95 % over surfaces, and the grid); {ratios}."
        )
    return tuple(sentences)


def figures(dataset: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw the stiffness over the load for every size, and its exponent."""
    return (
        Drawing(
            name="conductance",
            figure=_figure(dataset),
            data=dataset,
            caption="Contact stiffness, which is the conductance in other units, over the load. Left: K h_rms/p0, mean and 95 % "
            "over the surfaces; level where the stiffness goes with the load. Right: its local power of the load, by size of "
            "the sample. Few long waves make a light contact softer than many.",
        ),
    )


def _figure(dataset: xr.Dataset) -> Figure:
    from validation.report.figure import STYLES, look, new_figure

    figure, (left, right) = new_figure(width=9.0, columns=2)
    loads = dataset.reduced_pressure.values
    for i, periods in enumerate(dataset.periods.values):
        label = rf"$L/\lambda_\mathrm{{long}}$ = {periods:g}"
        draw_means(left, loads, means_of(dataset.stiffness[i]), label=label, ls="", **look(i))
        draw_means(right, dataset.step_pressure, means_of(dataset.exponent[i]), label=label, **look(i))
    for v, name in enumerate(WITH_ENERGY):
        left.plot(loads, dataset.theory[-1, v], color="black", lw=1, ls=STYLES[v % 4], label=VARIANTS[name])
    right.axhline(1.0, color="black", lw=0.8)
    left.set_ylabel(r"$K h_\mathrm{rms}/p_0$")
    right.set_ylabel(r"$d\,\ln K / d\,\ln p_0$")
    left.set_yscale("log")
    for axes in (left, right):
        axes.set_xscale("log")
        axes.set_xlabel(r"$p_0 / (E^* h'_\mathrm{rms})$")
        axes.legend(fontsize=7)
    return figure
