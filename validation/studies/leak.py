"""Does the gap percolate, how wide is it, and how much leaks through it?

Surfaces are pressed to given contact areas, and to the areas at which the contact begins and the gap ceases to percolate.
Reynolds' equation is solved in the gap, along x and along y, beside Bruggeman's effective medium and the narrowest place
of the widest path; the distribution of gaps stands beside the theory's.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from persson.gaps import gap_distribution
from persson.percolation import SITE_THRESHOLD
from persson.scale import Scale
from validation.measures.common import (
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
from validation.measures.flow import GAP_EDGES, LeakMeasurement
from validation.measures.measurement import grid_for
from validation.measures.statistics import Estimate, mean_over_surfaces
from validation.report.drawing import Drawing
from validation.report.table import ResultTable
from validation.scenes.scene import SelfAffineSurface
from validation.solves.bench import Bench
from validation.studies._options import Hurst, Periods, Seed, Surfaces
from validation.studies._study import StudyOptions

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

__all__ = ["Options", "figures", "findings", "run", "table"]

_QUANTITIES = {
    "located": "A/A0, edge located inside the cells",
    "conductance": "K / mean gap^3",
    "closed": "1 where no path leads through",
    "effective_medium": "Bruggeman's K / mean gap^3 of the same gaps",
    "constriction": "narrowest place of the widest path / mean gap",
    "balance": "deviation of the flux between sections, relative",
    "gap_density": "P(u) h_rms, without the contact",
    "contact_threshold": "A/A0 where the contact begins to percolate",
    "gap_threshold": "A/A0 where the gap ceases to percolate",
}

_MIDDLES = (GAP_EDGES[1:] + GAP_EDGES[:-1]) / 2
#: Energies of the theory of gaps, by their g.
_ENERGY_RATIOS = {"Persson": 1.0, "Yang, Persson 2008": 0.45}
#: Gaps, as u/h_rms, that are called narrow.
_NARROW = 0.1
#: A/A0 of the tire rim as the paper prints it (Sec. 8.3), which it compares with its threshold.
_RIM = 0.44


class Options(StudyOptions):
    """What is pressed, and how far."""

    own = "it asks about spectra of rising bandwidth, and makes a surface for each"

    areas: Annotated[Rising, Field(max_length=20)] = Field(
        default=(0.1, 0.2, 0.3, 0.4),
        description="contact areas A/A0 at which the flow is computed, rising, below 0.9",
    )
    hurst: Hurst = 0.8
    periods: Periods = 2.0
    bandwidths: Rising = Field(default=(4.0, 8.0, 16.0), description="lambda_long / lambda_short, rising")
    surfaces: Surfaces = 16
    points_per_wave: float = Field(default=6.0, ge=2, description="grid, as lambda_short/dx")
    seed: Seed = 2006

    def surface(self, bandwidth: float) -> SelfAffineSurface:
        """Return the first surface of one bandwidth."""
        return base_surface(hurst=self.hurst, periods=self.periods, bandwidth=bandwidth, seed=self.seed)


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Press every surface of every spectrum to its areas and thresholds.

    Returns
    -------
    xarray.Dataset
        Conductance, what theories make of the same gap, and whether it is closed over (spectrum, surface, area, axis);
        both percolation thresholds, as located A/A0, over (spectrum, surface, axis); `gap_density` and that of the `theory`,
        told the spectrum and the load of each surface, over (spectrum, surface, area, gap_bin).
    """
    import xarray as xr

    cases = _cases(options)
    found = results_of(bench, cases)
    rows: list[xr.Dataset] = [
        xr.concat([found[b, k] for k in range(options.surfaces)], dim="surface") for b in options.bandwidths
    ]
    data: xr.Dataset = xr.concat(rows, dim="spectrum")
    for name, words in _QUANTITIES.items():
        data[name].attrs = {"units": "1", "long_name": words}
    data["theory_density"] = named(
        ("variant", *data.gap_density.dims),
        [
            [
                [_theory(cases[b, k], found[b, k], ratio) for k in range(options.surfaces)]
                for b in options.bandwidths
            ]
            for ratio in _ENERGY_RATIOS.values()
        ],
        "P(u) h_rms of the theory, without the contact",
        unit="1",
    )
    data.attrs = {
        "study": "leak",
        "methods": "theory bem",
        "hurst": options.hurst,
        "periods": options.periods,
        "points_per_wave": options.points_per_wave,
    }
    bandwidth = named("spectrum", list(options.bandwidths), "lambda_long / lambda_short")
    return data.assign_coords(
        bandwidth=bandwidth,
        gap=named("gap_bin", _MIDDLES, "u / h_rms", unit="1"),
        variant=list(_ENERGY_RATIOS),
    )


def _theory(case: LeakMeasurement, found: xr.Dataset, ratio: float) -> NDArray[np.float64]:
    """P(u) h_rms at the loads of one surface, over (area, gap_bin); three points by Simpson's rule in each bin."""
    own = case.realised
    height, scale = own.field.rms_height, Scale(own.own_spectrum, contact_modulus=own.contact_modulus)
    points = np.stack([GAP_EDGES[:-1], _MIDDLES, GAP_EDGES[1:]]) * height
    rows = []
    for load in found.reduced_pressure.values:
        pressure = float(load) * own.pressure_scale
        density = gap_distribution(points.ravel(), pressure=pressure, scale=scale, energy_ratio=ratio)
        rows.append(np.array([1, 4, 1]) / 6 @ density.reshape(points.shape) * height)
    return np.array(rows)


def _cases(options: Options) -> dict[tuple[float, int], LeakMeasurement]:
    """List one case for each spectrum and surface."""
    found = {}
    for bandwidth in options.bandwidths:
        base = base_case(options.surface(bandwidth), reduced_pressure=0.1)
        grid = grid_for(base, options.points_per_wave)
        for k in range(options.surfaces):
            found[bandwidth, k] = LeakMeasurement(realised=base.further(k), grid=grid, areas=options.areas)
    return found


def _surface_means(values: xr.DataArray) -> Estimate:
    """Mean over surfaces; the two directions of a surface are one sample."""
    return over_surfaces(values.mean("axis"))


def table(dataset: xr.Dataset) -> ResultTable:
    """Return one row for each spectrum and area."""
    rows = []
    for here in each(dataset, "spectrum", "area"):
        leak, medium = _surface_means(here.conductance), _surface_means(here.effective_medium)
        rows.append(
            {
                "lambda_long/lambda_short": float(here.bandwidth),
                "A/A0": float(here.area),
                "K/gap^3": leak.value,
                "+- (95 %)": leak.half_width,
                "Bruggeman": medium.value,
                "K/Bruggeman": leak.value / medium.value if medium.value else float("nan"),
                "u_c^3/12": float((here.constriction**3 / 12).mean()),
                "closed [%]": 100 * float(here.closed.mean()),
            }
        )
    return ResultTable.of_rows(rows)


def findings(dataset: xr.Dataset) -> tuple[str, ...]:
    """Say where contact and gap percolate, how much leaks, and how far the theories are off."""
    sentences = []
    for name, words in (
        ("contact_threshold", "the contact begins to percolate"),
        ("gap_threshold", "the gap ceases to percolate"),
    ):
        each = [_surface_means(dataset[name][s]) for s in range(dataset.sizes["spectrum"])]
        pooled = mean_over_surfaces(dataset[name].mean("axis").values.mean(axis=0))
        listed = ", ".join(
            f"{one} at lambda_long/lambda_short = {b:g}"
            for one, b in zip(each, dataset.bandwidth.values, strict=True)
        )
        sentences.append(
            f"Along an axis {words} at A/A0 = {pooled} (located area, 95 % over {pooled.samples} surfaces of each spectrum, "
            f"common phases); {listed}. Persson (2006, Sec. 3.6) has .3, Dapp et al. (2012) .42."
        )
    sentences.append(_rim(dataset))
    last = dataset.sizes["spectrum"] - 1
    for a in range(dataset.sizes["area"]):
        here = dataset.isel(spectrum=last, area=a)
        leak, medium = _surface_means(here.conductance), _surface_means(here.effective_medium)
        closed = 100 * float(here.closed.mean())
        ratio = f"{leak.value / medium.value:.2g} of Bruggeman's" if medium.value else "Bruggeman's is 0"
        sentences.append(
            f"A/A0 = {float(dataset.area[a]):g}, lambda_long/lambda_short = {float(dataset.bandwidth[last]):g}: K = {leak} times the cube of "
            f"the mean gap, {ratio}; {closed:.2g} % of the directions are closed."
        )
        sentences.append(_gaps(here))
    return tuple(sentences)


def _rim(dataset: xr.Dataset) -> str:
    """Decide whether the tire rim of the paper seals, by the threshold of the gap that was found."""
    found = mean_over_surfaces(dataset.gap_threshold.mean("axis").values.mean(axis=0))
    low, high = found.value - found.half_width, found.value + found.half_width
    verdict = (
        "it seals"
        if low > 0 and high < _RIM
        else "it leaks"
        if low > _RIM
        else "whether it seals is not decided"
    )
    return (
        f"Tire rim, A/A0 = {_RIM:g} with adhesion (Persson 2006, Sec. 8.3, where no leak is concluded from {_RIM:g} > {SITE_THRESHOLD:g}): "
        f"the gap closes at {found}, so {verdict}, if adhesion does not move the threshold."
    )


def _gaps(here: xr.Dataset) -> str:
    """Compare the distribution of gaps at one area with the theory's."""
    width = np.diff(GAP_EDGES)
    narrow = GAP_EDGES[1:] <= _NARROW * (1 + 1e-9)

    def share(density: xr.DataArray) -> xr.DataArray:
        return (density * width)[..., narrow].sum("gap_bin")

    found = over_surfaces(share(here.gap_density))
    cumulated = (here.gap_density * width).mean("surface").cumsum("gap_bin")
    parts = []
    for name in here.variant.values.tolist():
        theory = here.theory_density.sel(variant=name)
        apart = float(np.abs((theory * width).mean("surface").cumsum("gap_bin") - cumulated).max())
        parts.append(f"{name} {float(share(theory).mean()):.3g} (cumulated shares at most {apart:.2g} apart)")
    return f"There gaps below {_NARROW:g} h_rms, contact left out, cover {found} of the nominal area; theory, told the load: {', '.join(parts)}."


def figures(dataset: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw the conductance over the area, the thresholds, and the distribution of gaps."""
    return (
        Drawing(
            name="leak",
            figure=_figure(dataset),
            data=dataset,
            caption="Left: conductance of the gap over the cube of the mean gap; filled, Reynolds' equation with 95 % over the "
            "surfaces; open, Bruggeman's effective medium of the same gaps. Right: areas at which the contact begins (filled) "
            "and the gap ceases (open) to percolate along an axis, one point a surface and direction.",
        ),
        Drawing(
            name="gap-distribution",
            figure=_gap_figure(dataset),
            data=dataset[["gap_density", "theory_density"]],
            caption="Distribution of the gap per nominal area at given contact areas, the contact left out, widest spectrum: steps, boundary elements, "
            "mean over the surfaces; lines, Persson's theory told the same loads, with its energy of 2006 and with that of Yang and Persson (2008, dashed).",
        ),
    )


def _gap_figure(dataset: xr.Dataset) -> Figure:
    """P(u) at each area, simulation and theory."""
    from validation.report.figure import COLOURS, STYLES, new_figure

    figure, (axes,) = new_figure()
    last = dataset.isel(spectrum=-1).mean("surface")
    for a, area in enumerate(dataset.area.values):
        colour = COLOURS[a % len(COLOURS)]
        axes.stairs(last.gap_density[a], GAP_EDGES, color=colour, lw=1.5, label=rf"$A/A_0$ = {area:g}")
        for v, name in enumerate(dataset.variant.values.tolist()):
            axes.plot(
                dataset.gap,
                last.theory_density[v, a],
                color=colour,
                lw=0.9,
                ls=STYLES[v],
                label=name if a == 0 else None,
            )
    axes.set_yscale("log")
    axes.set_ylim(3e-3, 3)
    axes.set_xlabel(r"$u / h_\mathrm{rms}$")
    axes.set_ylabel(r"$P(u)\, h_\mathrm{rms}$ per nominal area")
    axes.legend(fontsize=7)
    return figure


def _figure(dataset: xr.Dataset) -> Figure:
    from validation.report.figure import look, new_figure, plain_look

    figure, (left, right) = new_figure(width=9.0, columns=2)
    for s, bandwidth in enumerate(dataset.bandwidth.values):
        label = rf"$\lambda_\mathrm{{long}}/\lambda_\mathrm{{short}}$ = {bandwidth:g}"
        draw_means(
            left, dataset.area, means_of(dataset.conductance[s].mean("axis")), ls="-", label=label, **look(s)
        )
        left.plot(
            dataset.area,
            [medium.value for medium in means_of(dataset.effective_medium[s].mean("axis"))],
            ls="--",
            mfc="white",
            label="Bruggeman, same gaps" if s == 0 else None,
            **plain_look(s),
        )
        for name, fill in (("contact_threshold", plain_look(s)["color"]), ("gap_threshold", "white")):
            values = np.sort(dataset[name][s].values.ravel())
            share = (np.arange(values.size) + 0.5) / values.size
            right.plot(values, share, ls="-", mfc=fill, **plain_look(s))
    left.set_yscale("log")
    left.set_xlabel(r"$A/A_0$, located")
    left.set_ylabel(r"$K / \bar u^3$")
    left.legend(fontsize=7)
    right.set_xlabel(r"$A/A_0$ at the threshold, located")
    right.set_ylabel("share of surfaces and directions below")
    return figure
