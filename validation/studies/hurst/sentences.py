"""What the numbers of the study of the Hurst exponent say, in sentences."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from validation.measures.common import persson_area
from validation.measures.ladders import LADDERS, rungs_of
from validation.measures.references import ALPHA_HURST, ALPHA_LITERATURE
from validation.measures.statistics import mean_over_surfaces, pair_means
from validation.measures.theory import modes_sentence

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["all_of", "alpha_ratio"]


def all_of(dataset: xr.Dataset) -> Iterator[str]:
    """Yield what the numbers say, family by family of spectra."""
    for family in dict.fromkeys(dataset.family.values.tolist()):
        part = dataset.isel(spectrum=np.flatnonzero(dataset.family.values == family))
        if part.sizes["spectrum"] > 1:
            yield _trend(part, family)
    yield _counting(dataset)
    pressures = dataset.reduced_pressure.values
    theory = persson_area(pressures) / pressures
    ratio = dataset.kappa.mean(("spectrum", "surface")).values / theory
    yield (
        "The limit over Persson's theory is "
        + ", ".join(f"{r:.3f} at p* = {p:g}" for r, p in zip(ratio, pressures, strict=True))
        + " (mean over the spectra)."
    )
    yield modes_sentence(np.broadcast_to(theory, dataset.kappa_ensemble.shape), dataset.kappa_ensemble)
    if dataset.sizes.get("ladder", 0) > 1:
        yield _alpha_sentence(dataset)
    yield from (_over_magnification(dataset, k) for k in range(dataset.sizes.get("ladder", 0)))
    for kind in LADDERS:
        for k in range(dataset.sizes.get("ladder", 0)):
            yield _ladder_sentence(dataset, kind, k)


def _counting(dataset: xr.Dataset) -> str:
    """Say how much of the spread over H and loads is the grid's, by the spectra of equal bandwidth."""
    family = dataset.family.values[0]
    part = dataset.isel(spectrum=np.flatnonzero(dataset.family.values == family))

    def spread(values: xr.DataArray) -> tuple[float, float, float]:
        means = values.mean("surface").values
        return float(means.min()), float(means.max()), float(means.max() / means.min() - 1)

    low, high, true = spread(part.kappa)
    words = []
    for g in sorted({0, part.sizes["grid"] - 1}):
        least, most, seen = spread(part.kappa_pixel.isel(grid=g))
        mean = float(part.kappa_pixel.isel(grid=g).mean() / part.kappa.mean() - 1)
        words.append(
            f"at lambda_short/dx = {float(part.points_per_wave[g]):g} from {least:.2f} to {most:.2f} (spread {100 * seen:.0f} %, {100 * mean:+.1f} % on average)"
        )
    return (
        f"Counting points gives kappa, over all H and loads of {family}, {' and '.join(words)}; the limit goes from {low:.2f} to {high:.2f} "
        f"(spread {100 * true:.0f} %): what is more is the grid's."
    )


def _alpha_sentence(dataset: xr.Dataset) -> str:
    """Compare H at equal Nayak parameter with the Nayak parameter at equal H, along the bandwidth ladders."""
    alpha, kappa = dataset.bandwidth_nayak.values, dataset.bandwidth_kappa.values
    common = float(alpha[:, -1].min())
    if common < alpha[:, 0].max():
        return "The bandwidth ladders share no Nayak parameter: H at equal alpha cannot be read off them."
    at_common = np.array([np.interp(np.log(common), np.log(a), k) for a, k in zip(alpha, kappa, strict=True)])
    along = kappa[:, -1] / kappa[:, 0] - 1
    hurst = dataset.ladder_hurst.values
    return (
        f"H at equal alpha: at the Nayak parameter {common:.3g} kappa of all bandwidth ladders, H = {hurst.min():g} to {hurst.max():g}, lies within "
        f"{100 * (at_common.max() / at_common.min() - 1):.1f} % ({at_common.min():.3f} to {at_common.max():.3f}). Alpha at equal H: it changes by "
        + ", ".join(
            f"{100 * c:+.1f} % from {a[0]:.2g} to {a[-1]:.2g} (H = {h:g})"
            for c, a, h in zip(along, alpha, hurst, strict=True)
        )
        + "."
    )


def alpha_ratio(dataset: xr.Dataset, k: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Magnifications of one ladder, alpha(zeta) of A = alpha F over Persson's, and its 95 % half width."""
    load = float(dataset.attrs["ladder_reduced_pressure"])
    theory = float(persson_area(load)) / load
    kappa, half = dataset.bandwidth_kappa[k].values, dataset.bandwidth_half_width[k].values
    return 1 / dataset.bandwidth_step.values, kappa / theory, half / theory


def _over_magnification(dataset: xr.Dataset, k: int) -> str:
    """Compare alpha(zeta) of one fractal dimension with the theory, and with what was published (2006, Sec. 3.5)."""
    zeta, ratio, half = alpha_ratio(dataset, k)
    hurst = float(dataset.ladder_hurst[k])
    listed = ", ".join(
        f"{r:.3f} +- {e:.2g} at zeta = {z:g}" for z, r, e in zip(zeta, ratio, half, strict=True)
    )
    text = (
        f"D_f = {3 - hurst:.2g}: the slope alpha(zeta) of A over the load, over Persson's (Eq. 22), is {listed}: as waves are added it falls "
        f"{100 * abs(ratio[-1] / ratio[0] - 1):.1f} % {'less' if ratio[-1] > ratio[0] else 'more'} than his"
    )
    if not np.isclose(hurst, ALPHA_HURST):
        return text + "."
    low, high = ratio[-1] - half[-1], ratio[-1] + half[-1]
    published = ", ".join(
        f"{value:g} by {source}{'' if low <= value <= high else ' (outside the interval)'}"
        for source, value in ALPHA_LITERATURE.items()
    )
    return f"{text}. Published for this D_f: {published}."


def _ladder_sentence(dataset: xr.Dataset, kind: str, k: int) -> str:
    """Say where a ladder leads."""
    line, hurst = rungs_of(dataset, kind, k), float(dataset.ladder_hurst[k])
    kappa, steps = dataset[f"{kind}_kappa"][k].values, dataset[f"{kind}_step"].values
    change = f"kappa goes from {kappa[0]:.3f} to {kappa[-1]:.3f} as {LADDERS[kind]} falls from 1/{1 / steps[0]:g} to 1/{1 / steps[-1]:g}"
    if kind == "bandwidth":
        alpha = dataset.bandwidth_nayak[k].values
        change += f" (at equal H, with the Nayak parameter from {alpha[0]:.2g} to {alpha[-1]:.2g})"
    start = f"H = {hurst:g}, p* = {dataset.attrs['ladder_reduced_pressure']:g}: {change}"
    if not line.determinable:
        return (
            f"{start}; its limit is not determinable: with the order {line.order:.2g} it lies {line.reach:.1f} times "
            "as far away as these rungs span."
        )
    decided = abs(line.slope) > line.slope_half_width
    return (
        f"{start}; with the fixed order {line.order:.2g} the limit is {line.limit:.3f} +- {line.half_width:.2g} (95 %)"
        + ("." if decided else ", and no trend is told from zero.")
    )


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
