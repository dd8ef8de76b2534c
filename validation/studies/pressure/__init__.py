"""How do area, mean gap, stiffness, elastic energy and patches change from light load to full contact?"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from pydantic import Field
from scipy.special import erf

from persson import elastic
from persson.variants import Variant, corrected_contact_area
from validation.arrays import Array
from validation.measures.budget import grid_drift
from validation.measures.common import SHIFTS, Ladder, Rising, named, over_surfaces
from validation.measures.distributions import (
    PATCH_EDGES,
    STRESS_EDGES,
    Distance,
    Distributions,
    distance_to_reference,
    largest_difference,
)
from validation.measures.measurement import area_limits
from validation.measures.theory import RANKED, VARIANTS, WITH_ENERGY, Waves, ensemble_stress_variance
from validation.report.drawing import Drawing
from validation.report.table import ResultTable
from validation.scenes.realised import Realised
from validation.solves.bench import Bench
from validation.studies._options import Shifts
from validation.studies._scene import PressedOptions

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["LOADS", "Options", "figures", "findings", "independence", "reference_load", "run", "table"]

#: Reduced pressures from light load to full contact.
LOADS = (0.001, 0.003, 0.01, 0.02, 0.05, 0.1, 0.2, 0.4, 0.8, 1.6, 3.2)

#: Relative area from which on the light contact is dense enough to serve as reference for its distributions.
_REFERENCE_AREA = 0.015


class Options(PressedOptions):
    """What is pressed, along which path of loads, on which grids."""

    plain = "gap, stiffness and energy are compared with the theory of the elastic half-space; `area` takes all effects"

    reduced_pressures: Rising = Field(
        default=LOADS,
        description="p* = p0 / (E* h'_rms) with the realised gradient of each surface, rising: one warm path of loads",
    )
    shifts: Shifts = SHIFTS
    points_per_wave: Ladder = Field(default=(4.0, 8.0, 16.0), description="grids, as lambda_short/dx, rising")


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Press every surface along the path of loads.

    Returns
    -------
    xarray.Dataset
        With dimensions (surface, load): area (limit over grids), and from the finest grid the mean gap over h_rms, the
        energy over that of full contact, the contact stiffness between neighbouring loads, the patches, and histograms of
        pressure and patch size; with dimensions (mode, variant, load) what the theory says, told the realised surface
        (conditional) or C(q) alone (ensemble).
    """
    cases = _cases(options)
    solved = bench.solve(cases)
    measured = [solved[case] for case in cases]
    gradients = [data.attrs["rms_gradient"] for data in measured]
    theory = _theory([case.realised for case in cases], gradients, _loads(options))
    return (
        _numbers(options, measured)
        .merge(_shares(measured))
        .merge(theory)
        .assign_coords(
            stress_upper=named("stress_bin", STRESS_EDGES[1:], "sigma / (E* h'_rms), upper edge"),
            patch_upper=named("patch_area_bin", PATCH_EDGES[1:], "A_patch / lambda_short^2, upper edge"),
            variant=list(VARIANTS),
            mode=["conditional", "ensemble"],
        )
    )


def _loads(options: Options) -> Array:
    return np.array(options.reduced_pressures)


def _cases(options: Options) -> list[Distributions]:
    """List one case for each surface."""
    return [
        Distributions(
            realised=own,
            reduced_pressures=options.reduced_pressures,
            grids=options.grids_for(options.points_per_wave),
            shifts=options.shifts,
            tolerance=options.tolerance(Distributions.tolerance),
        )
        for own in options.pressed
    ]


def _numbers(options: Options, measured: Sequence[xr.Dataset]) -> xr.Dataset:
    """Limits, and what is read off the finest grid, (surface, load)."""
    import xarray as xr

    limits = [area_limits(data) for data in measured]
    finest = [data.isel(grid=-1).mean("shift") for data in measured]
    heights = [data.attrs["rms_height"] for data in measured]
    gap = np.array([d.mean_gap.values / height for d, height in zip(finest, heights, strict=True)])
    full = np.array([[data.attrs["full_contact_energy"]] for data in measured])
    wave = options.first.shortest
    data = {
        "area": np.array([value for value, _ in limits]),
        "area_error": np.array([error for _, error in limits]),
        "area_drift": np.array([grid_drift(data) for data in measured]),
        "pixel": np.array([d.pixel.values for d in finest]),
        "gap": gap,
        "energy": np.array([d.energy.values for d in finest]) / full,
        "gamma": _logarithmic_slope(gap, _loads(options)),
        "patches": np.array([d.patches.values for d in finest]),
        "patch_size": np.array([d.patch_size.values for d in finest]) / wave**2,
        "gap_error": _grid_change(measured, "mean_gap", heights),
        "energy_error": _grid_change(measured, "energy", full[:, 0].tolist()),
    }
    return xr.Dataset(
        {name: named(("surface", "load"), values, _WORDS[name]) for name, values in data.items()},
        coords={"reduced_pressure": named("load", _loads(options), "p0 / (E* h'_rms)")},
        attrs={"study": "pressure", "methods": RANKED, **options.spectrum_words},
    )


def _shares(measured: Sequence[xr.Dataset]) -> xr.Dataset:
    """Histograms on the finest grid, (surface, load, bin)."""
    import xarray as xr

    return xr.Dataset(
        {
            f"{name}_share": named(
                ("surface", "load", f"{name}_bin"),
                np.array([data[f"{name}_profile"].values[-1] for data in measured]),
                words,
            )
            for name, words in _SHARES.items()
        }
    )


def _logarithmic_slope(gap: np.ndarray, pressure: np.ndarray) -> np.ndarray:
    """-d gap / d ln p, along the last axis; the theory's is taken with the same differences."""
    return np.asarray(-np.gradient(gap, np.log(pressure), axis=-1))


def _grid_change(measured: Sequence[xr.Dataset], name: str, scales: Sequence[float]) -> np.ndarray:
    """By how much a quantity that no limit is taken of moves between the two finest grids."""
    change = [np.abs(np.diff(d[name].mean("shift").values[-2:], axis=0)[0]) for d in measured]
    return np.asarray(np.array(change) / np.asarray(scales)[:, None])


def _theory(cases: Sequence[Realised], gradients: Sequence[float], loads: Array) -> xr.Dataset:
    """Area, energy, gap and stiffness of every variant in both modes, means over the surfaces."""
    import xarray as xr

    # Without scatter of the amplitudes every surface has the same waves, and the theory knows nothing of phases.
    told = cases if getattr(cases[0].surface, "amplitudes", "") == "gaussian" else cases[:1]
    spectrum = cases[0].spectrum
    values = {
        name: np.full((2, len(VARIANTS), loads.size), np.nan) for name in ("area", "energy", "gap", "gamma")
    }
    of_field = [Waves.of_field(case.field) for case in told]
    of_spectrum = [] if spectrum is None else [Waves.of_spectrum(spectrum)] * len(told)
    variances = ensemble_stress_variance(spectrum, gradients)
    pressures = np.multiply.outer(np.asarray(gradients), loads)
    for v, variant in enumerate(VARIANTS):
        unit = elastic.stress_variance(1.0, contact_modulus=1.0)
        values["area"][0, v] = corrected_contact_area(loads, stress_variance=unit, variant=variant)
        if spectrum is not None:
            values["area"][1, v] = np.mean(
                [corrected_contact_area(pressures, stress_variance=x, variant=variant) for x in variances],
                axis=(0, 1),
            )
        if variant not in WITH_ENERGY:
            continue
        for m, waves in enumerate((of_field, of_spectrum) if of_spectrum else (of_field,)):
            gap, energy = _gap_and_energy(told, waves, of_field, variant=variant, loads=loads)
            values["gap"][m, v], values["energy"][m, v] = gap, energy
            values["gamma"][m, v] = _logarithmic_slope(gap, loads)
    dims = ("mode", "variant", "load")
    return xr.Dataset(
        {f"theory_{name}": named(dims, value, f"{_WORDS[name]}, theory") for name, value in values.items()}
    )


def _gap_and_energy(
    cases: Sequence[Realised],
    waves: Sequence[Waves],
    own: Sequence[Waves],
    *,
    variant: Variant,
    loads: Array,
) -> tuple[Array, Array]:
    """Mean gap over h_rms and energy over that of full contact, means over surfaces; `own` are their waves."""
    gap, energy = [], []
    for case, wave, whole in zip(cases, waves, own, strict=True):
        pressure = loads * case.field.rms_gradient
        gap.append(wave.mean_gap(pressure, variant) / case.field.rms_height)
        energy.append(wave.elastic_energy(pressure, variant) / whole.full_energy)
    return np.mean(gap, axis=0), np.mean(energy, axis=0)


_WORDS = {
    "area": "A/A0, limit over grids",
    "area_error": "standard error of that limit",
    "area_drift": "by how much that limit moves without the coarsest grid",
    "pixel": "A/A0, points counted on the finest grid",
    "gap": "mean gap / h_rms",
    "energy": "elastic energy over that of full contact",
    "gamma": "p0 / (K h_rms) = -d(gap/h_rms)/d ln p0, K the contact stiffness dp0/du",
    "patches": "number of contact patches on the finest grid",
    "patch_size": "sum A_i^2 / sum A_i over lambda_short^2",
    "gap_error": "by how much the gap moves between the two finest grids",
    "energy_error": "by how much the energy moves between the two finest grids",
}


_SHARES = {
    "stress": "share of the nominal area by pressure, on the finest grid",
    "patch_area": "share of the nominal area by patch size, on the finest grid",
    "patch_number": "number of patches by patch size, on the finest grid",
}


def independence(dataset: xr.Dataset) -> dict[str, Distance]:
    """Distances of the distributions of pressure and patch size from those at the reference load."""
    reference = reference_load(dataset)
    shares = {
        "pressure": dataset.stress_share,
        "patch size by area": dataset.patch_area_share,
        "patch size by number": dataset.patch_number_share,
    }
    return {name: distance_to_reference(values.values, reference) for name, values in shares.items()}


def reference_load(dataset: xr.Dataset) -> int:
    """Lightest load whose contact is dense enough to compare distributions with."""
    enough = np.flatnonzero(dataset.area.mean("surface").values >= _REFERENCE_AREA)
    return int(enough[0]) if enough.size else dataset.sizes["load"] - 1


def theory_distances(dataset: xr.Dataset) -> np.ndarray:
    """Return the distance of Persson's own P(sigma) A0/A from that at the reference load."""
    width = np.sqrt(2 * float(elastic.stress_variance(1.0, contact_modulus=1.0)))
    # What lies above the last edge counts in the last bin.
    stress = np.concatenate([[0.0], dataset.stress_upper.values[:-1], [np.inf]]) / width
    load = dataset.reduced_pressure.values[:, None] / width
    below = 0.5 * (erf(stress - load) - erf(stress + load)) + erf(load)
    shares = np.diff(below, axis=1)
    return largest_difference(shares, shares[reference_load(dataset)])


def table(dataset: xr.Dataset) -> ResultTable:
    """Return one row for each load, means over the surfaces."""
    distances = independence(dataset)
    columns = (
        "p*",
        "A/A0 limit",
        "+- (95 %)",
        "kappa",
        "A/A0 Persson, conditional",
        "A/A0 Persson, ensemble",
        "gap/h_rms",
        "Persson",
        "p0/(K h_rms)",
        "Persson",
        "U/U_full",
        "Persson (Eq. 43)",
        "patches",
        "mean patch/lambda_short^2",
        *(f"distance of the {name} distribution" for name in distances),
    )
    rows = [
        (*_row(dataset.isel(load=j)), *(float(distance.value[j]) for distance in distances.values()))
        for j in range(dataset.sizes["load"])
    ]
    return ResultTable.of(columns, rows)


def _row(at: xr.Dataset) -> Iterator[float]:
    """Yield the numbers of one load, the theory's beside those simulated."""
    pressure, area = float(at.reduced_pressure), over_surfaces(at.area)
    yield from (pressure, area.value, area.half_width, area.value / pressure)
    for mode in at.mode.values:
        yield float(at.theory_area.sel(mode=mode, variant="persson"))
    conditional = at.sel(mode="conditional", variant="persson")
    for name in ("gap", "gamma", "energy"):
        yield from (float(at[name].mean()), float(conditional[f"theory_{name}"]))
    yield from (float(at.patches.mean()), float(at.patch_size.mean()))


def findings(dataset: xr.Dataset) -> tuple[str, ...]:
    """Return where the theory holds, and what does not change with load while contact is light."""
    from validation.studies.pressure import sentences

    return tuple(
        sentences.all_of(
            dataset,
            distances=independence(dataset),
            own=theory_distances(dataset),
            reference=reference_load(dataset),
        )
    )


def figures(dataset: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw area, gap, energy and distributions against load."""
    from validation.studies.pressure import plots

    distances = independence(dataset)
    theory = [name for name in dataset.data_vars if str(name).startswith("theory_")]
    return (
        Drawing(
            name="area-against-pressure",
            figure=plots.area_against_pressure(dataset),
            data=dataset[["area", "area_error", "theory_area"]],
            caption="Contact area against load (left) and its ratio to Persson's theory (right), with its variants, told the realised surface (conditional; thin, dashed: C(q) alone); bars, scatter between surfaces.",
        ),
        Drawing(
            name="gap-and-energy",
            figure=plots.gap_and_energy(dataset),
            data=dataset[["gap", "gamma", "energy", *theory]],
            caption="Mean gap, inverse stiffness and elastic energy over that of full contact against load, with the theory and its variants, conditional (thin, dashed: from C(q) alone); bars, scatter between surfaces.",
        ),
        Drawing(
            name="load-independence",
            figure=plots.load_independence(
                dataset, distances, theory_distances(dataset), reference_load(dataset)
            ),
            data=dataset[["stress_share", "patch_area_share", "patch_number_share"]],
            caption="Distribution of pressure (left) and of patch size by area (middle) per contact area at several loads, surfaces pooled; right, their largest distance from that at the reference load, with 95 % intervals by resampling surfaces, and (dotted) what is not told from zero.",
        ),
    )
