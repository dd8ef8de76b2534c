"""How does the contact area fall as shorter and shorter waves are added to one surface?"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from pydantic import Field

from persson import elastic
from validation.arrays import Array
from validation.measures.common import SHIFTS, Ladder, Rising, each, over_surfaces, persson_area, results_of
from validation.measures.measurement import Measurement, area_limits
from validation.measures.theory import modes_sentence
from validation.report.drawing import Drawing
from validation.report.table import ResultTable
from validation.solves.bench import Bench
from validation.studies._options import Bandwidth, Shifts, Surfaces
from validation.studies._scene import PressedOptions

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

__all__ = ["Options", "figures", "findings", "run", "table"]


class Options(PressedOptions):
    """What is pressed, and which of its waves are there."""

    plain = "it follows the area of the elastic half-space wave by wave (Eq. 20)"

    reduced_pressures: Rising = Field(
        default=(0.05, 0.2), description="p* = p0 / (E* h'_rms) with the gradient of all waves, rising"
    )
    magnifications: Rising = Field(
        default=(1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0),
        description="zeta = q/q_long of the last wave there is, rising",
    )
    bandwidth: Bandwidth = 16.0
    surfaces: Surfaces = 4
    shifts: Shifts = SHIFTS
    points_per_wave: Ladder = Field(
        default=(3.0, 6.0), description="grids, as the shortest wave of all over dx, rising"
    )


#: What a case is called: number of the surface, magnification.
_Case = tuple[int, float]


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Press every surface with its waves up to each magnification, always at the same nominal pressures.

    Returns
    -------
    xarray.Dataset
        area (limit over grids) with dimensions (surface, magnification, load), and the theory told the realised gradient
        of the waves that are there (conditional) or C(q) alone up to that magnification (ensemble).
    """
    import xarray as xr

    cases = _cases(options)
    measured = results_of(bench, cases)
    limits = {case: area_limits(data) for case, data in measured.items()}
    loads, spectrum = np.array(options.reduced_pressures), options.first.spectrum
    q_long = 2 * np.pi / options.first.longest

    def own_pressures(case: _Case) -> Array:
        # p* of a truncated surface grows as its gradient shrinks, at the same nominal pressure.
        solve = cases[case]
        partial = solve.heights(solve.grids[0]).rms_gradient
        return np.asarray(loads * (measured[case].attrs["rms_gradient"] / partial))

    def ensemble(case: _Case) -> Array:
        if spectrum is None:
            return np.full(loads.shape, np.nan)
        q = min(case[1] * q_long, spectrum.q_short)
        variance = elastic.stress_variance(spectrum.m2(q), contact_modulus=1.0)
        pressure = loads * measured[case].attrs["rms_gradient"]
        return np.asarray(elastic.contact_area(pressure, stress_variance=variance))

    def over(read: Callable[[_Case], Array]) -> tuple[tuple[str, ...], Array]:
        rows = [[read((k, zeta)) for zeta in options.magnifications] for k in range(options.surfaces)]
        return ("surface", "magnification", "load"), np.array(rows)

    return xr.Dataset(
        {
            "area": over(lambda case: limits[case][0]),
            "area_error": over(lambda case: limits[case][1]),
            "theory": over(lambda case: persson_area(own_pressures(case))),
            "theory_ensemble": over(ensemble),
        },
        coords={
            "magnification": ("magnification", list(options.magnifications), {"long_name": "q / q_long"}),
            "reduced_pressure": ("load", list(options.reduced_pressures)),
        },
        attrs={"study": "magnification", **options.spectrum_words},
    )


def _cases(options: Options) -> dict[_Case, Measurement]:
    """List one case for each surface and magnification."""
    q_long = 2 * np.pi / options.first.longest
    return {
        (k, zeta): Measurement(
            realised=own,
            truncation=zeta * q_long,
            reduced_pressures=options.reduced_pressures,
            grids=options.grids_for(options.points_per_wave),
            shifts=options.shifts,
            tolerance=options.tolerance(Measurement.tolerance),
        )
        for (k, own), zeta in itertools.product(enumerate(options.pressed), options.magnifications)
    }


def table(dataset: xr.Dataset) -> ResultTable:
    """Return one row for each load and magnification."""
    rows = []
    for here in each(dataset, "load", "magnification"):
        area, theory = over_surfaces(here.area), float(here.theory.mean())
        rows.append(
            {
                "p* (all waves)": float(here.reduced_pressure),
                "zeta": float(here.magnification),
                "A/A0 limit": area.value,
                "+- (95 %)": area.half_width,
                "A/A0 Persson, conditional": theory,
                "A/A0 Persson, ensemble": float(here.theory_ensemble.mean()),
                "ratio to the first": area.value / theory,
            }
        )
    return ResultTable.of_rows(rows)


def findings(dataset: xr.Dataset) -> tuple[str, ...]:
    """Return how the distance to the theory builds up with magnification."""
    sentences = []
    for j, pressure in enumerate(dataset.reduced_pressure.values):
        area = dataset.area[:, :, j].mean("surface").values
        ratio = (dataset.area / dataset.theory)[:, :, j].mean("surface").values
        zeta = dataset.magnification.values
        if not np.all(np.isfinite(area)):
            sentences.append(
                f"At p* = {pressure:g} (all waves) how the area changes is not determinable: contacts are too small "
                "for a limit."
            )
            continue
        falls = bool(np.all(np.diff(area) < 0))
        sentences.append(
            f"At p* = {pressure:g} (all waves) the area {'falls with every wave added' if falls else 'does not fall at every step'}, from {area[0]:.3f} "
            f"at zeta = {zeta[0]:g} to {area[-1]:.4f} at {zeta[-1]:g}; over the theory it is {ratio[0]:.3f} there and {ratio[-1]:.3f} here."
        )
    # Up to zeta = 1 the integral over C(q) holds no wave, where the period holds its longest.
    rough = dataset.isel(magnification=np.flatnonzero(dataset.magnification.values >= _ROUGH))
    if rough.sizes["magnification"]:
        where = f"From zeta = {_ROUGH:g} on: " if rough.theory_ensemble.notnull().any() else ""
        sentences.append(where + modes_sentence(rough.theory, rough.theory_ensemble))
    return tuple(sentences)


#: Magnification from which on the sum over waves and the integral over C(q) can be compared.
_ROUGH = 2.0


def figures(dataset: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw area against magnification, simulation and theory."""
    return (
        Drawing(
            name="area-against-magnification",
            figure=_area_against_magnification(dataset),
            data=dataset[["area", "theory", "theory_ensemble"]],
            caption="Contact area of one nominal pressure as shorter waves are added, simulation (limit over grids) and theory with the gradient of the waves that are there (thin, dashed: from C(q) alone).",
        ),
    )


def _area_against_magnification(dataset: xr.Dataset) -> Figure:
    """A/A0 against magnification at each load, simulation and theory."""
    from validation.report.figure import COLOURS, look, new_figure

    figure, (axes,) = new_figure()
    for j, pressure in enumerate(dataset.reduced_pressure.values):
        area = dataset.area[:, :, j]
        axes.errorbar(
            dataset.magnification,
            area.mean("surface"),
            yerr=area.std("surface", ddof=1),
            label=f"limit, p* = {pressure:g}",
            **look(j),
        )
        axes.plot(
            dataset.magnification,
            dataset.theory[:, :, j].mean("surface"),
            ls="-.",
            color=COLOURS[j],
            label=f"Persson, p* = {pressure:g}",
        )
        axes.plot(
            dataset.magnification,
            dataset.theory_ensemble[:, :, j].mean("surface"),
            ls="--",
            lw=0.7,
            color=COLOURS[j],
            label="the same from C(q) alone",
        )
    axes.set_xscale("log", base=2)
    axes.set_yscale("log")
    axes.set_xlabel(r"magnification $\zeta = q / q_{long}$")
    axes.set_ylabel(r"$A(\zeta)/A_0$")
    axes.legend(fontsize=8)
    return figure
