"""What the numbers of the study of macroasperities say, in sentences."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from validation.measures.common import over_surfaces
from validation.measures.statistics import Estimate

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["all_of", "thresholds"]

#: How far a pressure may move and still be called the same.
_SAME = 0.1
#: Magnifications between which the paper expects the macroasperities.
_EXPECTED = (1.0, 5.0)
#: Share of a contact below which no single patch is the contact.
_DOMINANT = 0.5


def all_of(dataset: xr.Dataset, *, paper: float) -> Iterator[str]:
    """Yield what the numbers say; `paper` is the threshold that is printed."""
    yield from _break_up(dataset)
    if dataset.sizes["percolating"]:
        yield from _percolation(dataset, paper)
    yield _where(dataset)
    yield from (_level(dataset, source) for source in dataset.source.values.tolist())
    yield _at_one(dataset)
    yield _inside(dataset)


def thresholds(dataset: xr.Dataset, name: str) -> tuple[Estimate, tuple[Estimate, ...]]:
    """Mean threshold over surfaces, both directions and all loads of one being one sample; and load by load."""
    each = dataset[f"{name}_threshold"].mean("axis", skipna=False)
    by_load = tuple(over_surfaces(each.isel(percolating=i)) for i in range(dataset.sizes["percolating"]))
    return over_surfaces(each.mean("percolating", skipna=False)), by_load


def _break_up(dataset: xr.Dataset) -> Iterator[str]:
    """Say how the patches of one load break up; the middle one of those that are there."""
    here = dataset.isel(load=dataset.sizes["load"] // 2)
    zeta = dataset.zeta.values
    first, last = (
        [over_surfaces(here[name][:, i]).value for name in ("area", "patches", "patch_size")] for i in (0, -1)
    )
    yield (
        f"p* = {float(here.reduced_pressure):g}: from zeta = {zeta[0]:g} to {zeta[-1]:g} the contact falls from A/A0 = {first[0]:.3g} to {last[0]:.3g}, "
        f"the patches on the square of the roll-off wavelength rise from {first[1]:.2g} to {last[1]:.2g}, "
        f"and their mean size falls from {first[2]:.2g} to {last[2]:.2g} of it."
    )


def _percolation(dataset: xr.Dataset, paper: float) -> Iterator[str]:
    """Say at which areas contact and gap percolate while waves are added."""
    for name, words in (("contact", "the contact comes apart"), ("gap", "the gap opens")):
        pooled, by_load = thresholds(dataset, name)
        zeta = dataset[f"{name}_zeta"].mean(("surface", "axis")).values
        listed = ", ".join(
            f"{one} at p* = {p:g} (zeta = {z:.2g})"
            for one, p, z in zip(by_load, dataset.percolating_pressure.values, zeta, strict=True)
        )
        if not np.isfinite(pooled.value):
            yield f"As waves are added {words} along an axis not on every surface between the magnifications there are: {listed}."
            continue
        inside = abs(pooled.value - paper) <= pooled.half_width
        yield (
            f"As waves are added {words} along an axis at A/A0 = {pooled} (located area, 95 % over {pooled.samples} surfaces): {listed}. "
            f"The paper's {paper:g} lies {'inside' if inside else 'outside'} that interval."
        )


def _where(dataset: xr.Dataset) -> str:
    """Say where ln A bends most, load by load, in theory and in the simulation."""
    parts = []
    for j, load in enumerate(dataset.reduced_pressure.values):
        of = []
        for s in range(dataset.sizes["source"]):
            zeta, area = float(dataset.macro_zeta[s, j]), float(dataset.macro_area[:, s, j].mean())
            at = f", where A/A0 = {area:.2g}" if np.isfinite(area) else ""
            of.append(f"{zeta:.2g}{at}" if np.isfinite(zeta) else "nowhere inside")
        parts.append(f"p* = {load:g}: {of[0]} | {of[1]}")
    known = dataset.macro_zeta.values[np.isfinite(dataset.macro_zeta.values)]
    low, high = _EXPECTED
    within = int(np.sum((known >= low) & (known <= high)))
    return (
        f"ln A bends most at zeta_m, theory | simulation: {'; '.join(parts)}. "
        f"{within} of {dataset.macro_zeta.size} lie between {low:g} and {high:g}, where the paper expects them."
    )


def _level(dataset: xr.Dataset, source: str) -> str:
    """Say how the pressure in the macroasperities of one source goes with the load."""
    pressures = dataset.macro_pressure.sel(source=source)
    loads = dataset.reduced_pressure.values
    known = [j for j in range(loads.size) if np.isfinite(pressures[:, j]).all()]
    words = "the theory" if source == "theory" else "the simulation"
    if len(known) < 2:
        return f"The pressure in the macroasperities of {words} cannot be followed over the load: zeta_m is not inside."
    first, last = known[0], known[-1]
    rises = [over_surfaces(pressures[:, j] / pressures[:, first]) for j in known]
    listed = ", ".join(f"{float(pressures[:, j].mean()):.3g} at {loads[j]:g}" for j in known)
    # The theory is told surfaces of one spectrum: their scatter says nothing.
    told = f"{rises[-1].value:.3g}" if source == "theory" else f"{rises[-1]}"
    return (
        f"Mean pressure in the macroasperities of {words} over E* h'_rms, by p*: {listed}; it rises {told} times while the load rises "
        f"{loads[last] / loads[first]:.3g} times; {_stays([loads[j] for j in known], rises)}."
    )


def _stays(loads: Sequence[float], rises: Sequence[Estimate]) -> str:
    """Say up to which load a pressure is that of the lightest, as far as the intervals tell."""
    away = [abs(rise.value - 1) for rise in rises]
    widths = [np.nan_to_num(rise.half_width) for rise in rises]
    same = [a + w < _SAME for a, w in zip(away, widths, strict=True)]
    within = f"the same within {100 * _SAME:.0f} %"
    if all(same):
        return f"it is {within} at every load"
    last = same.index(False) - 1
    moved = [p for p, a, w in zip(loads, away, widths, strict=True) if a - w >= _SAME]
    beyond = f"and not at p* = {moved[0]:g}" if moved else "and beyond the surfaces do not tell"
    return f"it is {within} up to p* = {loads[last]:g}, {beyond}"


def _at_one(dataset: xr.Dataset) -> str:
    """Say up to which load the pressure in the contact seen at the roll-off stays."""
    i = int(np.argmin(np.abs(np.log(dataset.zeta.values))))
    area, loads = dataset.area[:, :, i], dataset.reduced_pressure.values
    rises = [over_surfaces(loads[j] / area[:, j] * area[:, 0] / loads[0]) for j in range(loads.size)]
    listed = ", ".join(
        f"{rises[j]} at p* = {loads[j]:g} (A/A0 = {float(area[:, j].mean()):.2g})"
        for j in range(1, loads.size)
    )
    return (
        f"In the contact seen at zeta = {float(dataset.zeta[i]):g} the mean pressure over that at p* = {loads[0]:g} is {listed}: "
        f"{_stays(loads, rises)}."
    )


def _inside(dataset: xr.Dataset) -> str:
    """Say how much of the load is carried where a lower magnification sees contact."""
    i = int(np.argmin(np.abs(np.log(dataset.zeta.values))))
    listed = ", ".join(
        f"{over_surfaces(dataset.load_inside[:, j, i])} at p* = {p:g}"
        for j, p in enumerate(dataset.reduced_pressure.values)
        if float(dataset.load_inside[:, j, i].min()) < 1 - 1e-9  # beyond, the contact seen there is complete
    )
    least = over_surfaces(dataset.load_inside[:, 0, i])
    width = np.nan_to_num(least.half_width)
    if least.value + width < _DOMINANT:
        verdict = "most of a light load is carried where no macroasperity was"
    elif least.value - width >= _DOMINANT:
        verdict = "macroasperities carry most of it"
    else:
        verdict = "which of both carries most of a light load, the surfaces do not tell"
    return f"With all waves there, the contact seen at zeta = {float(dataset.zeta[i]):g} carries of the load {listed or 'all'}; if regions only broke up it would be 1: {verdict}."
