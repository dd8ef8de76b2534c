"""How do area, mean gap, stiffness, elastic energy and patches change from light load to full contact?"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import erf

from persson import elastic
from persson.variants import corrected_contact_area
from validation.measures.budget import grid_drift
from validation.measures.common import (
    at_least,
    base_surface,
    measure,
    over_surfaces,
    persson_area,
    rising,
    solid_of,
)
from validation.measures.distributions import PATCH_EDGES, STRESS_EDGES, Distributions
from validation.measures.load_independence import Distance, distance_to_reference, largest_difference
from validation.measures.measurement import area_limits, grid_for
from validation.measures.theory import ensemble_stress_variance, modes_sentence
from validation.measures.theory_energy import VARIANTS, WITH_ENERGY, Waves
from validation.report.drawing import Drawing
from validation.report.table import ResultTable
from validation.scenes.surfaces import reference_field, spectrum_of
from validation.solves.bench import Bench

if TYPE_CHECKING:
    import xarray as xr

    from validation.scenes.scene import Scene, SelfAffineSurface

__all__ = ["LOADS", "figures", "findings", "independence", "run", "table"]

#: Reduced pressures from light load to full contact.
LOADS = (0.001, 0.003, 0.01, 0.02, 0.05, 0.1, 0.2, 0.4, 0.8, 1.6, 3.2)

#: Relative area from which on the light contact is dense enough to serve as reference for its distributions.
_REFERENCE_AREA = 0.015

#: Distance of cumulated shares up to which two distributions are called the same.
_SAME = 0.05


def run(
    *,
    scene: Scene | None = None,
    bench: Bench | None = None,
    reduced_pressures: tuple[float, ...] = LOADS,
    hurst: float = 0.8,
    size: float = 4.0,
    ratio: float = 8.0,
    surfaces: int = 8,
    points_per_wave: tuple[float, ...] = (4.0, 8.0, 16.0),
    shifts: int = 2,
    seed: int = 2006,
) -> xr.Dataset:
    """Press every surface along the path of loads.

    Parameters
    ----------
    scene : Scene, optional
        Gives the solid; nothing reported depends on it.
    bench : Bench, optional
        Where and how the cases run.
    reduced_pressures : tuple of float
        p*, rising: one warm path of loads.
    hurst, size, ratio : float
        H, L/lambda_long and lambda_long/lambda_short.
    surfaces : int
        Realisations.
    points_per_wave : tuple of float
        Grids, as lambda_short/dx, rising.
    shifts : int
        Sub-grid shifts along each axis.
    seed : int
        Of the first surface.

    Returns
    -------
    xarray.Dataset
        With dimensions (surface, load): area (limit over grids), and from the finest grid the mean gap over h_rms, the
        energy over that of full contact, the contact stiffness between neighbouring loads, the patches, and histograms of
        pressure and patch size; with dimensions (mode, variant, load) what the theory says, told the realised surface
        (conditional) or C(q) alone (ensemble).
    """
    import xarray as xr

    at_least("surfaces", surfaces, 2)
    reduced_pressures, points_per_wave = (
        rising("reduced_pressures", reduced_pressures),
        rising("points_per_wave", points_per_wave),
    )
    surface = base_surface(hurst=hurst, size=size, ratio=ratio, seed=seed)
    cases = [
        Distributions(
            surface=surface,
            realisation=k,
            solid=solid_of(scene),
            reduced_pressures=reduced_pressures,
            grids=tuple(grid_for(surface, points) for points in points_per_wave),
            shifts=shifts,
        )
        for k in range(surfaces)
    ]
    measured = measure(bench, cases)
    limits = [area_limits(data) for data in measured]
    finest = [data.isel(grid=-1).mean("shift") for data in measured]
    pressure = np.array(reduced_pressures)
    gap = np.array([d.mean_gap.values / m.attrs["rms_height"] for d, m in zip(finest, measured, strict=True)])
    full = np.array([[m.attrs["full_contact_energy"]] for m in measured])
    data = {
        "area": np.array([value for value, _ in limits]),
        "area_error": np.array([error for _, error in limits]),
        "area_drift": np.array([grid_drift(data) for data in measured]),
        "pixel": np.array([d.pixel.values for d in finest]),
        "gap": gap,
        "energy": np.array([d.energy.values for d in finest]) / full,
        "gamma": _logarithmic_slope(gap, pressure),
        "patches": np.array([d.patches.values for d in finest]),
        "patch_size": np.array([d.patch_size.values for d in finest]) / surface.lambda_short**2,
        "gap_error": _grid_change(measured, "mean_gap", [m.attrs["rms_height"] for m in measured]),
        "energy_error": _grid_change(measured, "energy", full[:, 0].tolist()),
    }
    found = xr.Dataset(
        {name: (("surface", "load"), values, {"long_name": _WORDS[name]}) for name, values in data.items()},
        coords={"reduced_pressure": ("load", pressure, {"long_name": "p0 / (E* h'_rms)"})},
        attrs={"study": "pressure", "hurst": hurst, "size": size, "ratio": ratio},
    )
    for name in ("stress", "patch_area", "patch_number"):
        found[f"{name}_share"] = (
            ("surface", "load", f"{name}_bin"),
            np.array([m[f"{name}_profile"].values[-1] for m in measured]),
            {"long_name": _SHARES[name]},
        )
    gradients = [m.attrs["rms_gradient"] for m in measured]
    return found.merge(_theory(surface, pressure, gradients)).assign_coords(
        stress_upper=("stress_bin", STRESS_EDGES[1:], {"long_name": "sigma / (E* h'_rms), upper edge"}),
        patch_upper=(
            "patch_area_bin",
            PATCH_EDGES[1:],
            {"long_name": "A_patch / lambda_short^2, upper edge"},
        ),
        variant=list(VARIANTS),
        mode=["conditional", "ensemble"],
    )


def _logarithmic_slope(gap: np.ndarray, pressure: np.ndarray) -> np.ndarray:
    """-d gap / d ln p, along the last axis; the theory's is taken with the same differences."""
    return np.asarray(-np.gradient(gap, np.log(pressure), axis=-1))


def _grid_change(measured: Sequence[xr.Dataset], name: str, scales: Sequence[float]) -> np.ndarray:
    """By how much a quantity that no limit is taken of moves between the two finest grids."""
    change = [np.abs(np.diff(d[name].mean("shift").values[-2:], axis=0)[0]) for d in measured]
    return np.asarray(np.array(change) / np.asarray(scales)[:, None])


def _theory(surface: SelfAffineSurface, loads: np.ndarray, gradients: Sequence[float]) -> xr.Dataset:
    """Area, energy, gap and stiffness of every variant in both modes, means over the surfaces."""
    import xarray as xr

    fields = [reference_field(surface, realisation=k) for k in range(len(gradients))]
    # Without scatter of the amplitudes every surface has the same waves, and the theory knows nothing of phases.
    told = fields[:1] if surface.amplitudes == "exact" else fields
    shape = (2, len(VARIANTS), loads.size)
    values = {name: np.full(shape, np.nan) for name in ("area", "energy", "gap", "gamma")}
    variances = ensemble_stress_variance(surface, gradients)
    of_spectrum = Waves.of_spectrum(spectrum_of(surface))
    of_field = [Waves.of_field(field) for field in told]
    for v, variant in enumerate(VARIANTS):
        unit = elastic.stress_variance(1.0, contact_modulus=1.0)
        values["area"][0, v] = corrected_contact_area(loads, stress_variance=unit, variant=variant)
        pressures = np.multiply.outer(np.asarray(gradients), loads)
        values["area"][1, v] = np.mean(
            [corrected_contact_area(pressures, stress_variance=x, variant=variant) for x in variances],
            axis=(0, 1),
        )
        if variant not in WITH_ENERGY:
            continue
        for m, waves in enumerate((of_field, [of_spectrum] * len(told))):
            gap, energy = [], []
            for field, whole, wave in zip(told, of_field, waves, strict=True):
                pressure = loads * field.rms_gradient
                gap.append(wave.mean_gap(pressure, variant) / field.rms_height)
                energy.append(wave.elastic_energy(pressure, variant) / whole.full_energy)
            values["gap"][m, v], values["energy"][m, v] = np.mean(gap, axis=0), np.mean(energy, axis=0)
            values["gamma"][m, v] = _logarithmic_slope(values["gap"][m, v], loads)
    dims = ("mode", "variant", "load")
    return xr.Dataset(
        {
            f"theory_{name}": (dims, value, {"long_name": f"{_WORDS[name]}, theory"})
            for name, value in values.items()
        }
    )


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
    rows = []
    distances = independence(dataset)
    conditional = dataset.sel(mode="conditional", variant="persson")
    for j, pressure in enumerate(dataset.reduced_pressure.values):
        area = over_surfaces(dataset.area[:, j])
        mean = {name: float(dataset[name][:, j].mean()) for name in _WORDS}
        theory = {name: float(conditional[f"theory_{name}"][j]) for name in ("gap", "gamma", "energy")}
        rows.append(
            (
                float(pressure),
                area.value,
                area.half_width,
                area.value / pressure,
                *(
                    float(dataset.theory_area.sel(mode=mode, variant="persson")[j])
                    for mode in dataset.mode.values
                ),
                mean["gap"],
                theory["gap"],
                mean["gamma"],
                theory["gamma"],
                mean["energy"],
                theory["energy"],
                mean["patches"],
                mean["patch_size"],
                *(float(distance.value[j]) for distance in distances.values()),
            )
        )
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
    return ResultTable.of(columns, rows)


def findings(dataset: xr.Dataset) -> tuple[str, ...]:
    """Return where the theory holds, and what does not change with load while contact is light."""
    theory = persson_area(dataset.reduced_pressure.values)
    area = dataset.area.mean("surface").values
    ratio = area / theory
    sentences = [
        "Simulated area (limit) over Persson's: "
        + ", ".join(f"{r:.3f} at A/A0 = {a:.3g}" for r, a in zip(ratio, area, strict=True) if np.isfinite(a))
        + ".",
        modes_sentence(
            *(dataset.theory_area.sel(mode=mode, variant="persson") for mode in dataset.mode.values)
        ),
    ]
    sentences += [_with_energy(dataset, name, words) for name, words in _COMPARED.items()]
    light = np.flatnonzero(area < 0.1)
    if light.size > 1:
        kappa = area[light] / dataset.reduced_pressure.values[light]
        size = dataset.patch_size.mean("surface").values[light]
        count = dataset.patches.mean("surface").values[light]
        sentences.append(
            f"Between A/A0 = {area[light[0]]:.2g} and {area[light[-1]]:.2g} kappa goes from {kappa[0]:.2f} to {kappa[-1]:.2f}, the mean patch "
            f"size grows {size[-1] / size[0]:.1f}-fold and the number of patches {count[-1] / count[0]:.1f}-fold, where the theories of "
            "independent patches say that size stays and number grows with the area, "
            f"{area[light[-1]] / area[light[0]]:.1f}-fold."
        )
        gamma = dataset.gamma.mean("surface").values[light]
        sentences.append(
            f"The mean gap falls with ln p0 by gamma h_rms with gamma = {gamma.min():.2f} to {gamma.max():.2f} at these loads."
        )
    own = theory_distances(dataset)
    sentences += [
        _independence(dataset, name, distance, own) for name, distance in independence(dataset).items()
    ]
    return tuple(sentences)


_COMPARED = {"gap": "mean gap", "gamma": "inverse stiffness p0/(K h_rms)", "energy": "elastic energy"}


def _with_energy(dataset: xr.Dataset, name: str, words: str) -> str:
    """Compare a quantity with every variant that has an energy, from the lightest to a heavy load."""
    area = dataset.area.mean("surface").values
    picked = [j for j in range(area.size) if area[j] < 0.9][:: max(1, int((area < 0.9).sum()) // 4)]
    simulated = dataset[name].mean("surface").values
    parts = []
    for variant in WITH_ENERGY:
        predicted = dataset[f"theory_{name}"].sel(mode="conditional", variant=variant).values
        parts.append(f"{VARIANTS[variant]} {', '.join(f'{simulated[j] / predicted[j]:.2f}' for j in picked)}")
    return f"Simulated {words} over that of the theory at A/A0 = {', '.join(f'{area[j]:.2g}' for j in picked)}: {'; '.join(parts)}."


def _independence(dataset: xr.Dataset, name: str, distance: Distance, own: np.ndarray) -> str:
    """Return the verdict on one claim of load independence (Persson 2006, Secs. 3.3 and 13)."""
    area = dataset.area.mean("surface").values
    reference = reference_load(dataset)
    what = "P(sigma) A0/A" if name == "pressure" else f"The distribution of {name.replace('size', 'sizes')}"
    start = f"{what}, against that at A/A0 = {area[reference]:.2g}: "
    heavier = np.arange(reference + 1, area.size)
    same = []
    for j in heavier:
        if distance.high[j] > _SAME:
            break
        same.append(j)
    seen = [j for j in heavier if distance.low[j] > distance.noise[j]]
    rows = ", ".join(
        f"{distance.value[j]:.3f} [{distance.low[j]:.3f}, {distance.high[j]:.3f}] at {area[j]:.2g}"
        for j in heavier[:4]
    )
    verdict = (
        f"the claim holds up to A/A0 = {area[same[-1]]:.2g} within {distance.high[same[-1]]:.3f}"
        if same
        else f"the claim does not hold within {_SAME:g} at any heavier load of the path"
    )
    told = (
        f"the change is told from the scatter between surfaces ({distance.noise[seen[0]]:.3f}) from A/A0 = {area[seen[0]]:.2g} on"
        if seen
        else (f"no change is told from the scatter between surfaces ({distance.noise[heavier].max():.3f})")
    )
    theirs = (
        f" Persson's own distribution moves by {', '.join(f'{own[j]:.3f}' for j in heavier[:4])}."
        if name == "pressure"
        else ""
    )
    return f"{start}largest difference of the cumulated shares {rows}; {verdict}, and {told}.{theirs}"


def figures(dataset: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw area, gap, energy and distributions against load."""
    from validation.studies import _plots_limits as plots_limits

    distances = independence(dataset)
    theory = [name for name in dataset.data_vars if str(name).startswith("theory_")]
    return (
        Drawing(
            name="area-against-pressure",
            figure=plots_limits.area_against_pressure(dataset),
            data=dataset[["area", "area_error", "theory_area"]],
            caption="Contact area against load (left) and its ratio to Persson's theory (right), with its variants, told the realised surface (conditional; thin, dashed: C(q) alone); bars, scatter between surfaces.",
        ),
        Drawing(
            name="gap-and-energy",
            figure=plots_limits.gap_and_energy(dataset),
            data=dataset[["gap", "gamma", "energy", *theory]],
            caption="Mean gap, inverse stiffness and elastic energy over that of full contact against load, with the theory and its variants, conditional (thin, dashed: from C(q) alone); bars, scatter between surfaces.",
        ),
        Drawing(
            name="load-independence",
            figure=plots_limits.load_independence(
                dataset, distances, theory_distances(dataset), reference_load(dataset)
            ),
            data=dataset[["stress_share", "patch_area_share", "patch_number_share"]],
            caption="Distribution of pressure (left) and of patch size by area (middle) per contact area at several loads, surfaces pooled; right, their largest distance from that at the reference load, with 95 % intervals by resampling surfaces, and (dotted) what is not told from zero.",
        ),
    )
