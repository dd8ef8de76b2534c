"""What are the macroasperities, do they carry the same pressure at every load, and at which area does contact percolate?

One surface with a roll-off is pressed with its waves up to rising magnifications (Persson 2006, Secs. 3.6, 3.7): patches of
contact break up, contact and gap join up, and the regions seen where ln A bends most are the macroasperities.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import numpy as np
from pydantic import Field

from persson.errors import OutsideTheory
from persson.percolation import SITE_THRESHOLD
from persson.separation import macroasperity_magnification
from validation.arrays import Array
from validation.measures.common import (
    Rising,
    RisingOrNone,
    base_case,
    base_surface,
    each,
    named,
    over_surfaces,
    persson_area,
    results_of,
)
from validation.measures.measurement import grid_for
from validation.report.drawing import Drawing
from validation.report.table import ResultTable
from validation.scenes.realised import Realised
from validation.solves.bench import Bench
from validation.studies._options import Bandwidth, Hurst, Periods, Seed, Surfaces
from validation.studies._study import StudyOptions
from validation.studies.macroasperities.pressing import QUANTITIES, Magnified

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Options", "figures", "findings", "run", "table"]


class Options(StudyOptions):
    """What is pressed, with which of its waves."""

    own = "it asks about spectra with a roll-off, and makes a surface for each"

    reduced_pressures: Rising = Field(
        default=(0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0),
        min_length=2,
        description="p* = p0 / (E* h'_rms) with the gradient of all waves, rising",
    )
    magnifications: Annotated[Rising, Field(min_length=3)] = Field(
        default=(0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0, 5.7, 8.0),
        description="zeta = q/q_0 of the last wave there is, rising; the last is at most the bandwidth",
    )
    percolating: RisingOrNone = Field(
        default=(0.05, 0.1, 0.15), description="p* at which contact and gap are followed to their thresholds"
    )
    hurst: Hurst = 0.8
    periods: Periods = 8.0
    bandwidth: Bandwidth = 8.0
    surfaces: Surfaces = 16
    points_per_wave: float = Field(default=4.0, ge=2, description="grid, as lambda_short/dx")
    seed: Seed = 2006

    @property
    def first(self) -> Realised:
        """The first surface: waves up to q_0 = 2 pi / lambda_long have one C(q), shorter ones are self-affine."""
        sharp = base_surface(hurst=self.hurst, periods=self.periods, bandwidth=self.bandwidth, seed=self.seed)
        surface = sharp.model_copy(update={"rolloff": "smooth"})
        return base_case(surface, reduced_pressure=self.reduced_pressures[0])


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Press every surface with its waves up to each magnification.

    Returns
    -------
    xarray.Dataset
        `area`, patches and what lies in the contact seen at zeta over (surface, load, magnification); `theory`, A/A0 of the
        waves that are there; thresholds over (surface, percolating, axis); `macro_zeta` where ln A bends most and
        `macro_area` there, of `source` theory and bem, and `macro_pressure` = p0 A0 / A in units of E* h'_rms.
    """
    import xarray as xr

    first = options.first
    cases = {
        k: Magnified(
            realised=first.further(k),
            grid=grid_for(first, options.points_per_wave),
            reduced_pressures=options.reduced_pressures,
            magnifications=options.magnifications,
            percolating=options.percolating,
        )
        for k in range(options.surfaces)
    }
    found = results_of(bench, cases)
    data: xr.Dataset = xr.concat([found[k] for k in cases], dim="surface")
    for name, words in QUANTITIES.items():
        data[name].attrs = {"units": "1", "long_name": words}
    loads, zeta = np.array(options.reduced_pressures), np.array(options.magnifications)
    data = data.assign_coords(
        reduced_pressure=named("load", loads, "p0 / (E* h'_rms), all waves"),
        zeta=named("magnification", zeta, "q / q_0 of the last wave"),
        percolating_pressure=("percolating", list(options.percolating)),
        source=["theory", "bem"],
    )
    theory = persson_area(loads[None, :, None] / data.gradient.values[:, None, :])
    data["theory"] = named(("surface", "load", "magnification"), theory, "A/A0, Persson")
    # Those of the simulation from the mean over the surfaces: the bend of a single one is noise.
    mean = data.area.mean("surface").values
    bends = np.array([[_of_theory(first, p) for p in loads], [_sharpest_bend(zeta, area) for area in mean]])
    areas = np.array(
        [
            [
                [_between(zeta, row, z) for z, row in zip(of, one, strict=True)]
                for of, one in zip(bends, (data.theory.values[k], data.area.values[k]), strict=True)
            ]
            for k in range(options.surfaces)
        ]
    )
    data["macro_zeta"] = named(("source", "load"), bends, "zeta where ln A bends most")
    data["macro_area"] = named(("surface", "source", "load"), areas, "A/A0 there")
    data["macro_pressure"] = loads / data.macro_area
    data.attrs = {"study": "macroasperities", "methods": "theory bem", **_spectrum_words(options)}
    return data


def _spectrum_words(options: Options) -> dict[str, float]:
    return {
        "hurst": options.hurst,
        "periods": options.periods,
        "bandwidth": options.bandwidth,
        "points_per_wave": options.points_per_wave,
    }


def _of_theory(first: Realised, reduced: float) -> float:
    """zeta_m of the theory; NaN where ln A bends most at an end of the spectrum."""
    try:
        return macroasperity_magnification(
            first.own_spectrum,
            pressure=reduced * first.pressure_scale,
            contact_modulus=first.contact_modulus,
            q_reference=2 * np.pi / first.longest,
        )
    except OutsideTheory:
        return float("nan")


def _sharpest_bend(zeta: Array, area: Array) -> float:
    """Zeta where ln A over ln zeta bends up most, by the parabola through three steps; NaN at an end."""
    x, y = np.log(zeta), np.log(area)
    slopes, middles = np.diff(y) / np.diff(x), (x[1:] + x[:-1]) / 2
    bend = np.diff(slopes) / np.diff(middles)
    top = int(np.argmax(bend))
    if top in (0, bend.size - 1) or not bend[top] > 0:
        return float("nan")
    around = slice(top - 1, top + 2)
    c2, c1, _ = np.polyfit(x[1:-1][around], bend[around], 2)
    return float(np.exp(-c1 / (2 * c2)))


def _between(zeta: Array, area: Array, at: float) -> float:
    """A/A0 between the magnifications, straight in the logarithms; NaN beyond them."""
    if not zeta[0] <= at <= zeta[-1]:
        return float("nan")
    return float(np.exp(np.interp(np.log(at), np.log(zeta), np.log(area))))


def table(dataset: xr.Dataset) -> ResultTable:
    """Return one row for each load and magnification."""
    rows = []
    for here in each(dataset, "load", "magnification"):
        area, inside = over_surfaces(here.area), over_surfaces(here.load_inside)
        rows.append(
            {
                "p* (all waves)": float(here.reduced_pressure),
                "zeta": float(here.zeta),
                "A/A0": area.value,
                "+- (95 %)": area.half_width,
                "Persson": float(here.theory.mean()),
                "p0 A0/A / (E* h'_rms)": float(here.reduced_pressure) / area.value,
                "patches on lambda_0^2": over_surfaces(here.patches).value,
                "mean patch / lambda_0^2": over_surfaces(here.patch_size).value,
                "largest patch / A": over_surfaces(here.largest).value,
                "load inside, all waves": inside.value,
                "+- (95 %) of it": inside.half_width,
            }
        )
    return ResultTable.of_rows(rows)


def findings(dataset: xr.Dataset) -> tuple[str, ...]:
    """Say where contact and gap percolate, where the macroasperities are, and whether their pressure stays."""
    from validation.studies.macroasperities import sentences

    return tuple(sentences.all_of(dataset, paper=SITE_THRESHOLD))


def figures(dataset: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw patches over zeta, the pressure in them over the load, and both thresholds."""
    from validation.studies.macroasperities import plots

    drawn = [
        Drawing(
            name="patches-over-magnification",
            figure=plots.patches(dataset),
            data=dataset[["area", "theory", "patches", "patch_size", "largest"]],
            caption="One surface with its waves up to zeta, mean and 95 % over the surfaces. Left: contact area, with Persson's (lines) and the paper's threshold. "
            "Middle: patches on the square of the roll-off wavelength. Right: share of the contact that the largest patch holds.",
        ),
        Drawing(
            name="macroasperity-pressure",
            figure=plots.pressure(dataset),
            data=dataset[["macro_zeta", "macro_area", "macro_pressure", "load_inside", "area"]],
            caption="Left: mean pressure in the contact seen at fixed zeta, and at zeta_m of the theory and of the simulation, over the load; level where it is "
            "independent of the load. Right: share of the load that, with all waves there, is carried inside the contact seen at zeta.",
        ),
    ]
    if dataset.sizes["percolating"]:
        names = [f"{what}_{kind}" for what in ("contact", "gap") for kind in ("threshold", "zeta")]
        drawn.append(
            Drawing(
                name="percolation",
                figure=plots.percolation(dataset, paper=SITE_THRESHOLD),
                data=dataset[names],
                caption="Located areas at which, as waves are added, the contact comes apart (filled) and the gap opens (open), one point a surface and direction: "
                "left over the magnification where it happens, right as the share of them below. Dotted: the paper's threshold.",
            )
        )
    return tuple(drawn)
