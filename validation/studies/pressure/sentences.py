"""What the numbers of the study of the load say, in sentences."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from validation.arrays import Array
from validation.measures.common import persson_area
from validation.measures.theory import VARIANTS, WITH_ENERGY, modes_sentence

if TYPE_CHECKING:
    import xarray as xr

    from validation.measures.distributions import Distance

__all__ = ["all_of"]

#: Distance of cumulated shares up to which two distributions are called the same.
_SAME = 0.05


def all_of(
    dataset: xr.Dataset, *, distances: Mapping[str, Distance], own: Array, reference: int
) -> Iterator[str]:
    """Yield them all.

    Parameters
    ----------
    dataset : xarray.Dataset
    distances : mapping
        Of the distributions at every load from those at the reference load, by what is distributed.
    own : (loads,) array
        The same for the pressure as Persson's theory has it.
    reference : int
        Which load that is.
    """
    area = dataset.area.mean("surface").values
    ratio = area / persson_area(dataset.reduced_pressure.values)
    yield (
        "Simulated area (limit) over Persson's: "
        + ", ".join(f"{r:.3f} at A/A0 = {a:.3g}" for r, a in zip(ratio, area, strict=True) if np.isfinite(a))
        + "."
    )
    yield modes_sentence(
        *(dataset.theory_area.sel(mode=mode, variant="persson") for mode in dataset.mode.values)
    )
    for name, words in _COMPARED.items():
        yield _with_energy(dataset, name, words)
    if np.count_nonzero(area < _LIGHT) > 1:
        yield from _while_light(dataset.isel(load=np.flatnonzero(area < _LIGHT)))
    for name, distance in distances.items():
        yield _independence(dataset, name, distance, own=own, reference=reference)


#: Relative area below which contact is light.
_LIGHT = 0.1


def _while_light(dataset: xr.Dataset) -> Iterator[str]:
    """Say what light contact does as the load grows."""
    area = dataset.area.mean("surface").values
    kappa = area / dataset.reduced_pressure.values
    size, count = (dataset[name].mean("surface").values for name in ("patch_size", "patches"))
    yield (
        f"Between A/A0 = {area[0]:.2g} and {area[-1]:.2g} kappa goes from {kappa[0]:.2f} to {kappa[-1]:.2f}, the mean patch "
        f"size grows {size[-1] / size[0]:.1f}-fold and the number of patches {count[-1] / count[0]:.1f}-fold, where the theories of "
        "independent patches say that size stays and number grows with the area, "
        f"{area[-1] / area[0]:.1f}-fold."
    )
    gamma = dataset.gamma.mean("surface").values
    yield f"The mean gap falls with ln p0 by gamma h_rms with gamma = {gamma.min():.2f} to {gamma.max():.2f} at these loads."


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


def _independence(dataset: xr.Dataset, name: str, distance: Distance, *, own: Array, reference: int) -> str:
    """Return the verdict on one claim of load independence (Persson 2006, Secs. 3.3 and 13)."""
    area = dataset.area.mean("surface").values
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
    if dataset.sizes["surface"] == 1:
        told = "one surface has no scatter to tell a change from"
    theirs = (
        f" Persson's own distribution moves by {', '.join(f'{own[j]:.3f}' for j in heavier[:4])}."
        if name == "pressure"
        else ""
    )
    return f"{start}largest difference of the cumulated shares {rows}; {verdict}, and {told}.{theirs}"
