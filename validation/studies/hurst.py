"""How does kappa = (A/A0)/p* depend on the Hurst exponent, and is it the Nayak parameter that matters?"""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import numpy as np
import scipy.optimize

from validation.bench import Bench
from validation.drawing import Drawing
from validation.errors import UsageError
from validation.statistics import Estimate, mean_over_surfaces, pair_means
from validation.studies._common import (
    ResultTable,
    at_least,
    base_surface,
    measure,
    persson_area,
    rising,
    solid_of,
)
from validation.studies._measurement import Measurement, area_limits, grid_for
from validation.surfaces import spectrum_of

if TYPE_CHECKING:
    import xarray as xr

    from validation.scene import Scene

__all__ = ["figures", "findings", "run", "table"]


def run(
    *,
    scene: Scene | None = None,
    bench: Bench | None = None,
    hursts: tuple[float, ...] = (0.1, 0.3, 0.5, 0.8, 0.95),
    ratios: tuple[float, ...] = (16.0,),
    equal_nayak: float | None = None,
    reduced_pressures: tuple[float, ...] = (0.02, 0.05, 0.1, 0.2),
    size: float = 4.0,
    pairs: int = 8,
    points_per_wave: tuple[float, ...] = (4.0, 6.0, 8.0),
    shifts: int = 2,
    seed: int = 2006,
) -> xr.Dataset:
    """Measure kappa for every spectrum, surface and load.

    Parameters
    ----------
    scene : Scene, optional
        Gives the solid; kappa does not depend on it.
    bench : Bench, optional
        Where and how the cases run; in this process and in `results/solves` if not given.
    hursts : tuple of float
        Hurst exponents.
    ratios : tuple of float
        lambda_long/lambda_short, each with every H.
    equal_nayak : float, optional
        Also choose the ratio of each H so that alpha of C(q) has this value.
    reduced_pressures : tuple of float
        p*, rising.
    size : float
        L/lambda_long.
    pairs : int
        Pairs of surfaces +h, -h.
    points_per_wave : tuple of float
        Grids, as lambda_short/dx, rising.
    shifts : int
        Sub-grid shifts along each axis.
    seed : int
        Of the first surface.

    Returns
    -------
    xarray.Dataset
        kappa by pixel count and perimeter on the finest grid and in the limit, with dimensions (spectrum, surface,
        load). Surfaces 2k and 2k + 1 are +h and -h. All spectra share their phases.
    """
    import xarray as xr

    at_least("pairs", pairs, 2)
    reduced_pressures, points_per_wave = (
        rising("reduced_pressures", reduced_pressures),
        rising("points_per_wave", points_per_wave),
    )
    spectra = [(h, r, f"ratio {r:g}") for r, h in itertools.product(ratios, hursts)]
    if equal_nayak is not None:
        spectra += [
            (h, _ratio_for(equal_nayak, hurst=h, size=size), f"alpha {equal_nayak:g}") for h in hursts
        ]
    surfaces = [base_surface(hurst=h, size=size, ratio=r, seed=seed) for h, r, _ in spectra]
    cases = [
        Measurement(
            surface=surface,
            realisation=pair,
            inverted=inverted,
            solid=solid_of(scene),
            reduced_pressures=reduced_pressures,
            grids=tuple(grid_for(surface, points) for points in points_per_wave),
            shifts=shifts,
        )
        for surface, pair, inverted in itertools.product(surfaces, range(pairs), (False, True))
    ]
    measured = measure(bench, cases)
    shape = (len(spectra), 2 * pairs, len(reduced_pressures))
    pressure = np.array(reduced_pressures)
    limits = [area_limits(data) for data in measured]
    kappa = {
        "kappa": np.array([value for value, _ in limits]).reshape(shape) / pressure,
        "kappa_grid_error": np.array([error for _, error in limits]).reshape(shape) / pressure,
        "kappa_pixel": _finest(measured, "pixel").reshape(shape) / pressure,
        "kappa_perimeter": _finest(measured, "perimeter").reshape(shape) / pressure,
    }
    words = {
        "kappa": "limit over grids",
        "kappa_grid_error": "standard error of that limit",
        "kappa_pixel": "pixel count on the finest grid, mean over shifts",
        "kappa_perimeter": "perimeter-corrected on the finest grid, mean over shifts",
    }
    nayak = np.array([data.attrs["nayak"] for data in measured]).reshape(shape[:2])
    return xr.Dataset(
        {
            name: (("spectrum", "surface", "load"), values, {"long_name": words[name]})
            for name, values in kappa.items()
        },
        coords={
            "hurst": ("spectrum", [hurst for hurst, _, _ in spectra]),
            "ratio": (
                "spectrum",
                [ratio for _, ratio, _ in spectra],
                {"long_name": "lambda_long / lambda_short"},
            ),
            "family": ("spectrum", [family for _, _, family in spectra]),
            "nayak": (("spectrum", "surface"), nayak, {"long_name": "realised Nayak parameter"}),
            "reduced_pressure": ("load", pressure, {"long_name": "p0 / (E* h'_rms)"}),
        },
        attrs={
            "study": "hurst",
            "size": size,
            "points_per_wave": list(points_per_wave),
            "seconds": float(sum(data.seconds.sum() for data in measured)),
        },
    )


def _ratio_for(nayak: float, *, hurst: float, size: float) -> float:
    """lambda_long/lambda_short at which alpha of C(q) has a value, for one H."""

    def excess(ratio: float) -> float:
        surface = base_surface(hurst=hurst, size=size, ratio=ratio, seed=0)
        return spectrum_of(surface).moments().nayak - nayak

    if not excess(1.01) < 0 < excess(1e4):
        raise UsageError(
            f"equal_nayak = {nayak:g}: no bandwidth gives it at H = {hurst:g}; it must exceed 1.5"
        )
    return float(scipy.optimize.brentq(excess, 1.01, 1e4, xtol=1e-6))


def _finest(measured: list[xr.Dataset], name: str) -> np.ndarray:
    return np.array([data[name].isel(grid=-1).mean("shift").values for data in measured])


def estimates(dataset: xr.Dataset, name: str = "kappa") -> list[list[Estimate]]:
    """Mean over pairs of surfaces with its 95 % interval, for each spectrum and load."""
    values = pair_means(dataset[name].transpose("spectrum", "load", "surface").values)
    return [[mean_over_surfaces(samples) for samples in loads] for loads in values]


def table(dataset: xr.Dataset) -> ResultTable:
    """Return one row for each spectrum and load."""
    limits, pixels = estimates(dataset), estimates(dataset, "kappa_pixel")
    rows = []
    for i, j in itertools.product(range(dataset.sizes["spectrum"]), range(dataset.sizes["load"])):
        pressure = float(dataset.reduced_pressure[j])
        grid_error = float(
            np.sqrt(np.mean(dataset.kappa_grid_error[i, :, j] ** 2) / dataset.sizes["surface"])
        )
        rows.append(
            (
                float(dataset.hurst[i]),
                float(dataset.ratio[i]),
                float(dataset.nayak[i].mean()),
                pressure,
                limits[i][j].value,
                limits[i][j].half_width,
                grid_error,
                pixels[i][j].value,
                float(persson_area(pressure)) / pressure,
            )
        )
    columns = (
        "H",
        "lambda_long/lambda_short",
        "Nayak (realised)",
        "p*",
        "kappa limit",
        "+- (95 %, surfaces)",
        "+- (1 s.e., grid)",
        "kappa pixel, finest grid",
        "kappa Persson",
    )
    return ResultTable.of(columns, rows)


def findings(dataset: xr.Dataset) -> tuple[str, ...]:
    """Return what the numbers say, family by family of spectra."""
    sentences = []
    for family in dict.fromkeys(dataset.family.values.tolist()):
        part = dataset.isel(spectrum=np.flatnonzero(dataset.family.values == family))
        if part.sizes["spectrum"] > 1:
            sentences.append(_trend(part, family))
    raw = float(dataset.kappa_pixel.mean() / dataset.kappa.mean() - 1)
    sentences.append(
        f"Counting points at lambda_short/dx = {max(dataset.attrs['points_per_wave']):g} gives kappa "
        f"{100 * raw:.1f} % {'above' if raw > 0 else 'below'} the limit on average over all spectra and loads."
    )
    theory = np.array(persson_area(dataset.reduced_pressure.values)) / dataset.reduced_pressure.values
    ratio = dataset.kappa.mean(("spectrum", "surface")).values / theory
    pressures = dataset.reduced_pressure.values
    sentences.append(
        "The limit over Persson's theory is "
        + ", ".join(f"{r:.3f} at p* = {p:g}" for r, p in zip(ratio, pressures, strict=True))
        + " (mean over the spectra)."
    )
    return tuple(sentences)


def _trend(part: xr.Dataset, family: str) -> str:
    """Compare the lowest with the highest H, surface by surface, since their phases are common."""
    first, last = int(part.hurst.values.argmin()), int(part.hurst.values.argmax())
    words = []
    for j, pressure in enumerate(part.reduced_pressure.values):
        ratio = part.kappa[last, :, j].values / part.kappa[first, :, j].values - 1
        change = mean_over_surfaces(pair_means(ratio))
        decided = abs(change.value) > change.half_width
        words.append(
            f"{100 * change.value:+.1f} +- {100 * change.half_width:.1f} % at p* = {pressure:g}"
            + ("" if decided else " (not told from zero)")
        )
    alphas = part.nayak.mean("surface").values
    return (
        f"Spectra of {family}: from H = {float(part.hurst[first]):g} to {float(part.hurst[last]):g} (Nayak parameter "
        f"{alphas[first]:.2g} to {alphas[last]:.2g}) kappa changes by " + ", ".join(words) + "."
    )


def figures(dataset: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw kappa against H and against the Nayak parameter."""
    from validation import plots_studies

    return (
        Drawing(
            name="kappa-against-hurst",
            figure=plots_studies.kappa_against_hurst(
                dataset, estimates(dataset), estimates(dataset, "kappa_pixel")
            ),
            data=dataset[["kappa"]],
            caption="kappa against the Hurst exponent: filled, limit over grids with 95 % intervals over pairs of surfaces; open, points counted on the finest grid; lines, theory; grey and cross, literature.",
        ),
        Drawing(
            name="kappa-against-nayak",
            figure=plots_studies.kappa_against_nayak(dataset, estimates(dataset)),
            data=dataset[["kappa"]],
            caption="The same kappa against the realised Nayak parameter; colours are loads, markers are families of spectra.",
        ),
    )
