"""Why is Persson's theory off: which terms of its diffusion equation fail, where, and how far do they cancel?

One surface is built up ring by ring of waves, from the longest to the shortest, at one nominal pressure, each ring with both
signs; after every ring the pressure of every point is compared with that before. What the theory says of a step: the pressure
diffuses with D = 1 and without drift, what reaches p = 0 is lost for good, and nothing else moves. Here each of these is
measured, and so is what the others make of it: the books of area, load and mean square pressure, in which nothing may be missing.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated

import numpy as np
from pydantic import AfterValidator, Field

from validation.arrays import Array
from validation.measures.common import Rising, base_case, base_surface, named
from validation.measures.measurement import area_limits
from validation.report.drawing import Drawing
from validation.report.table import ResultTable
from validation.scenes.realised import Realised
from validation.solves.bench import Bench
from validation.solves.running import Solves
from validation.studies import stress_near_zero
from validation.studies._options import Hurst, Seed, Surfaces
from validation.studies._study import StudyOptions
from validation.studies.autopsy import reading
from validation.studies.autopsy.books import FLOWS, PROFILE_EDGES, PROFILES
from validation.studies.autopsy.chain import Chain
from validation.studies.autopsy.probe import RING, Probe
from validation.studies.autopsy.reading import Spread
from validation.studies.autopsy.rings import AREAS, ring_ends
from validation.units import wrong

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Options", "figures", "findings", "run", "table"]


def _rough(magnifications: tuple[float, ...]) -> tuple[float, ...]:
    if magnifications[0] < LEAST_PROBE:
        raise wrong(f"must be at least {LEAST_PROBE:g}: a surface of one wave length is not rough")
    return magnifications


#: Magnification from which on a surface is probed.
LEAST_PROBE = 2.0


class Options(StudyOptions):
    """Spectra, loads, rings, and the grids over which every flow is extrapolated."""

    own = "it builds its surfaces up ring by ring of waves"

    hursts: Annotated[tuple[Hurst, ...], Field(min_length=1)] = Field(
        default=(0.3, 0.8), description="Hurst exponents H"
    )
    reduced_pressures: Rising = Field(
        default=(0.02, 0.05, 0.3, 1.0),
        description="p* = p0 / (E* h'_rms) with the realised gradient of all waves, rising",
    )
    periods: int = Field(
        default=2, ge=1, le=64, description="L / lambda_long, whole: rings are of such waves"
    )
    bandwidth: float = Field(default=32.0, ge=2, le=1024, description="lambda_long / lambda_short")
    steps_per_octave: int = Field(
        default=2,
        ge=2,
        le=64,
        multiple_of=2,
        description="rings of waves in each octave, even: half octaves are compared",
    )
    surfaces: Surfaces = 4
    points_per_wave: Annotated[Rising, Field(min_length=2)] = Field(
        default=(8.0, 12.0), description="grids of the rings, as lambda_short/dx, rising"
    )
    probes: Annotated[Rising, AfterValidator(_rough)] = Field(
        default=(2.0, 4.0, 8.0),
        description="magnifications at which the surface is cut, pressed with these p* of its own gradient, and given one more "
        "ring as high as the steps below ask for, rising",
    )
    probe_surfaces: Surfaces = 8
    variance_steps: Annotated[Rising, Field(min_length=2)] = Field(
        default=(0.0025, 0.01, 0.04, 0.16), description="Delta V / V of that ring, rising"
    )
    probe_points_per_wave: Annotated[Rising, Field(min_length=2)] = Field(
        default=(12.0, 24.0), description="grids there, as the shortest wave there is over dx, rising"
    )
    slope_points_per_wave: Annotated[Rising, Field(min_length=3)] = Field(
        default=(16.0, 32.0, 64.0), description="grids of the slope of P(p) at zero there, rising"
    )
    seed: Seed = 2006

    @property
    def ends(self) -> tuple[float, ...]:
        """Magnifications at which the rings end."""
        found = ring_ends(
            periods=self.periods, bandwidth=self.bandwidth, steps_per_octave=self.steps_per_octave
        )
        return tuple(float(end) for end in found)

    @property
    def octaves(self) -> tuple[float, ...]:
        """Where octaves begin and end, the last one cut where the bandwidth is no power of two."""
        return tuple(float(e) for e in self.ends if abs(np.log2(e) - round(np.log2(e))) < 1e-9)

    def realised(self, hurst: float, load: float, surface: int, *, bandwidth: float) -> Realised:
        """Return a surface at a load."""
        whole = base_surface(hurst=hurst, periods=self.periods, bandwidth=bandwidth, seed=self.seed)
        return base_case(whole, reduced_pressure=load).further(surface)


#: What a chain is called: numbers of H, load, surface, grid; a probe has its magnification behind.
_Case = tuple[int, ...]


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Build every surface up ring by ring, and probe single rings.

    Returns
    -------
    xarray.Dataset
        With dimensions (hurst, load, surface, grid): the books of every ring (step) and of single rings of given Delta V / V
        (probe, variance_step), per nominal area with pressures in units of sqrt(V) before the step, means over both signs; drift
        and diffusivity by pressure (bin); limits of the area over the grids, with the ring and with its negative (sign, level); the
        area of absorbing diffusion started from the truth (restart, level); returns by time since leaving (age).
    """
    import xarray as xr

    chains = _chains(options)
    probes = [_probes(options, zeta) for zeta in options.probes]
    solved = bench.solve([*chains.values(), *(solve for cases in probes for solve in cases.values())])
    probed = xr.concat([_stacked(solved, cases) for cases in probes], dim="probe")
    data = _stacked(solved, chains).merge(_apart(probed))
    slope, half_width = _slopes(options, bench)
    data["slope"] = ("hurst", "load", "probe"), slope
    data["slope_half_width"] = ("hurst", "load", "probe"), half_width
    for name, variable in data.data_vars.items():
        variable.attrs["long_name"] = _WORDS[str(name).removeprefix("probe_")]
    data = data.assign_coords(
        hurst=list(options.hursts),
        reduced_pressure=named("load", list(options.reduced_pressures), "p* = p0 / (E* h'_rms)"),
        zeta=named("level", list(options.ends), "q / q_long of the last wave there is"),
        restart_zeta=("restart", list(options.octaves[:-1])),
        probe_zeta=("probe", list(options.probes)),
        relative_step=named("variance_step", list(options.variance_steps), "Delta V / V"),
        upper=named("bin", PROFILE_EDGES[1:], "p / sqrt(V), upper edge"),
    )
    return data.assign_attrs(
        study="autopsy",
        periods=options.periods,
        bandwidth=options.bandwidth,
        surfaces=options.surfaces,
        octaves=list(options.octaves),
    )


def _chains(options: Options) -> dict[_Case, Chain]:
    """List the chains: every surface at every load on every grid."""
    sizes = map(
        len, (options.hursts, options.reduced_pressures, range(options.surfaces), options.points_per_wave)
    )
    return {
        (h, j, k, g): Chain(
            realised=options.realised(
                options.hursts[h], options.reduced_pressures[j], k, bandwidth=options.bandwidth
            ),
            points=_even(options.points_per_wave[g] * options.bandwidth * options.periods),
            ends=options.ends,
            restarts=options.octaves[:-1],
        )
        for h, j, k, g in itertools.product(*map(range, sizes))
    }


def _probes(options: Options, zeta: float) -> dict[_Case, Probe]:
    """List the probes of one magnification: every surface at every load on every grid."""
    grids = options.probe_points_per_wave
    sizes = map(len, (options.hursts, options.reduced_pressures, range(options.probe_surfaces), grids))
    return {
        (h, j, k, g): Probe(
            # The waves do not depend on where the spectrum is cut, but for their common scale.
            realised=options.realised(
                options.hursts[h], options.reduced_pressures[j], k, bandwidth=zeta * RING
            ),
            points=_even(grids[g] * zeta * options.periods),
            magnification=zeta,
            steps=options.variance_steps,
        )
        for h, j, k, g in itertools.product(*map(range, sizes))
    }


def _slopes(options: Options, bench: Bench) -> tuple[Array, Array]:
    """V P'(0) over that of the theory at every probe, (hurst, load, probe), with its 95 % half width, as `stress-near-zero` has it."""
    axes = options.hursts, options.reduced_pressures, options.probes
    found = []
    for hurst, load, zeta in itertools.product(*axes):
        edge = stress_near_zero.Options(
            reduced_pressure=load,
            hurst=hurst,
            periods=options.periods,
            bandwidth=zeta,
            surfaces=options.probe_surfaces,
            seed=options.seed,
            points_per_wave=options.slope_points_per_wave,
        )
        data = stress_near_zero.run(edge, bench=bench)
        (own,) = stress_near_zero.by_method(data).values()
        slope = stress_near_zero.limit_slope(own)
        found.append(np.array([slope.value, slope.half_width]) / data.attrs["persson_slope"])
    value, half_width = np.array(found).T.reshape(2, *map(len, axes))
    return value, half_width


def _even(points: float) -> int:
    return 2 * int(np.ceil(points / 2 - 1e-9))


_DIMS = ("hurst", "load", "surface", "grid")


def _stacked(solved: Solves, cases: Mapping[_Case, Chain] | Mapping[_Case, Probe]) -> xr.Dataset:
    """Results of one shape as one dataset, with limits over the grids in the place of areas on each grid."""
    import xarray as xr

    results = {case: solved[solve] for case, solve in cases.items()}
    first = results[0, 0, 0, 0]
    sizes = tuple(max(case[axis] for case in cases) + 1 for axis in range(len(_DIMS)))
    ordered = [results[case] for case in itertools.product(*map(range, sizes))]
    data = xr.Dataset(
        {
            name: (
                (*_DIMS, *first[name].dims),
                np.array([case[name].values for case in ordered]).reshape(*sizes, *first[name].shape),
            )
            for name in map(str, first.data_vars)
        }
    )
    return _with_limits(data, [cases[0, 0, 0, g] for g in range(sizes[-1])])


def _with_limits(data: xr.Dataset, grids: Sequence[Chain | Probe]) -> xr.Dataset:
    """Put limits over the grids, and their standard errors, in the place of the areas on each grid."""
    import xarray as xr

    others = [str(dim) for dim in data.pixel.dims if dim != "grid"]
    flat = {
        name: (
            ("grid", "shift", "load"),
            data[name].transpose("grid", *others).values.reshape(len(grids), 1, -1),
        )
        for name in AREAS
    }
    areas = xr.Dataset(flat).assign(
        points=("grid", [solve.points for solve in grids]),
        cells=("grid", [solve.points**2 for solve in grids]),
        points_per_wave=("grid", [solve.points_per_wave for solve in grids]),
    )
    shape = [data.sizes[name] for name in others]
    value, error = (column.reshape(shape) for column in area_limits(areas))
    spacing = np.array([1 / solve.points_per_wave for solve in grids])
    return data.drop_vars(list(AREAS)).assign(
        area=(others, value), area_error=(others, error), spacing=("grid", spacing)
    )


def _apart(probed: xr.Dataset) -> xr.Dataset:
    """Name what the probes left apart from what the chains did."""
    dims = {"step": "variance_step", "level": "probe_level", "grid": "probe_grid", "surface": "probe_surface"}
    return probed.rename(dims | {name: f"probe_{name}" for name in map(str, probed.data_vars)})


_WORDS = {
    "variance": "V / V of all waves",
    "square": "<p^2> / V, over the nominal area, on each grid",
    "diffused": "A/A0 of absorbing diffusion started from the truth, on each grid",
    "two_step": "area out of contact before two steps and in contact after",
    "composed": "the same by the laws of single steps",
    "out_points": "points out of contact when a step begins, by steps since leaving (0: never in contact)",
    "returned": "those of them that the step brings back",
    "out_at": "share of the final contact that is out of contact here",
    "crossed_once": "share of the final contact that had left at least once",
    "area": "A/A0, limit over grids, with the ring and with its negative",
    "area_error": "standard error of that limit",
    "nominal": "p0 / sqrt(V) of all waves there are",
    "spacing": "dx over the shortest wave there is",
    "slope": "P'(0) over that of the theory at every probe",
    "slope_half_width": "95 % half width of that",
    **FLOWS,
    **PROFILES,
}


def table(dataset: xr.Dataset) -> ResultTable:
    """Return one row for each H, load and octave: the books, and what absorbing diffusion makes of the same start."""
    square, area = reading.square_book(dataset), reading.area_book(dataset)
    columns = {
        "d<p^2>/(A dV)": Spread.of(square.change),
        **{words: Spread.of(square[name]) for name, (words, _, _) in reading.TERMS.items()},
        "told by D(p), mu(p)": Spread.of(square.told),
        "d ln A/d ln V": Spread.of(area.located),
        "counted": Spread.of(area.counted),
        "Persson": Spread.of(area.persson),
        "restarted loss over true": Spread.of(reading.loss_ratio(dataset).rename(restart="octave")),
    }
    ends = np.asarray(dataset.attrs["octaves"], dtype=float)
    ratio = Spread.of(reading.over_persson(dataset))
    rows: list[dict[str, float | str]] = []
    for h, j, k in itertools.product(
        range(dataset.sizes["hurst"]), range(dataset.sizes["load"]), range(ends.size - 1)
    ):
        at = {"hurst": h, "load": j, "octave": k}
        end = {"hurst": h, "load": j, "level": int(np.argmin(np.abs(dataset.zeta.values - ends[k + 1])))}
        row: dict[str, float | str] = {
            "H": float(dataset.hurst[h]),
            "p*": float(dataset.reduced_pressure[j]),
            "zeta": f"{ends[k]:g}-{ends[k + 1]:g}",
        }
        for name, spread in columns.items():
            row[name] = float(spread.value.isel(at))
            if name in _WITH_INTERVAL:
                row[f"+- {name} (95 %)"] = float(spread.half_width.isel(at))
        row["A/Persson at its end"] = float(ratio.value.isel(end))
        row["+- A/Persson (95 %)"] = float(ratio.half_width.isel(end))
        rows.append(row)
    return ResultTable.of_rows(rows)


_WITH_INTERVAL = ("d<p^2>/(A dV)", "d ln A/d ln V", "restarted loss over true")


def findings(dataset: xr.Dataset) -> tuple[str, ...]:
    """Return what fails, where, and what cancels."""
    from validation.studies.autopsy import sentences

    return tuple(sentences.all_of(dataset))


def figures(dataset: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw the terms of the diffusion equation, the flows, the budget, the restarts and the memory."""
    from validation.studies.autopsy import plots

    load = plots.nearest(dataset.reduced_pressure, 0.05)
    return (
        Drawing(
            name="budget",
            figure=plots.budget_bars(dataset),
            data=_means(reading.square_book(dataset)),
            caption="Where d<p^2>/(A dV) comes from, octave by octave (left of each pair the smaller H): diffusion and drift of the points that stay, loss, re-entry; circles, their sum with 95 % over surfaces. Persson's theory has the green line: diffusion alone.",
        ),
        Drawing(
            name="restarts",
            figure=plots.area_and_restarts(dataset),
            data=_means(
                _dataset(over_persson=reading.over_persson(dataset), restarted=reading.restarts(dataset))
            ),
            caption="Contact area over Persson's as waves are added, with 95 % over surfaces; dashed, where absorbing diffusion goes when it starts from the true distribution of pressure.",
        ),
        Drawing(
            name="drift-and-diffusivity",
            figure=plots.drift_and_diffusivity(dataset, load=load),
            data=dataset[[f"probe_{name}" for name in PROFILES]].isel(load=load, probe_grid=-1),
            caption=f"Diffusivity and drift of points that stay in contact, by their pressure before the ring, p* = {float(dataset.reduced_pressure[load]):g}, all surfaces; green, Persson's theory. Near p = 0 the diffusivity has no limit as the step vanishes: the edge of the contact moves.",
        ),
        Drawing(
            name="fluxes",
            figure=plots.fluxes(dataset),
            data=_means(
                _dataset(
                    lost=reading.flux(dataset, "lost"),
                    entered=reading.flux(dataset, "entered"),
                    net=reading.net_flux(dataset),
                )
            ),
            caption="Area that a ring takes out of contact and brings back, over the contact area, against its step (left), their ratio (middle) and the net (right), at the last magnification probed and the largest H; limits over grids, 95 % over surfaces.",
        ),
        Drawing(
            name="memory",
            figure=plots.memory(dataset),
            data=_means(_dataset(returns=reading.returns(dataset))),
            caption="Chance that a ring brings a point back into contact against the number of rings since it left; 95 % over surfaces. Without memory it would be one number.",
        ),
    )


def _dataset(**variables: xr.DataArray) -> xr.Dataset:
    """Put variables together."""
    import xarray as xr

    return xr.Dataset(variables)


def _means(values: xr.Dataset) -> xr.Dataset:
    """Means over surfaces and half widths of their intervals."""
    found: dict[str, xr.DataArray] = {}
    for name, variable in values.data_vars.items():
        spread = Spread.of(variable)
        found |= {str(name): spread.value, f"{name}_half_width": spread.half_width}
    return _dataset(**found)
