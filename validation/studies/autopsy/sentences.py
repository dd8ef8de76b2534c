"""What the books of the autopsy say, in sentences."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from validation.studies.autopsy import reading
from validation.studies.autopsy.reading import Spread

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["all_of"]

#: Books are called closed within this.
CLOSED = 0.02

#: The end of the first octave and a half, and where the short waves begin.
_EARLY, _LATE = 2**1.5, 4.0


def all_of(dataset: xr.Dataset) -> Iterator[str]:
    """Yield them all."""
    yield _excess(dataset)
    yield _relative_loss(dataset)
    yield from _books(dataset)
    yield _terms(dataset)
    yield from _drift(dataset)
    yield from _flows(dataset)
    yield _edge(dataset)
    yield _restart(dataset)
    yield from _memory(dataset)


def _pm(value: float, half_width: float, digits: int = 2) -> str:
    if not np.isfinite(value):
        return "not determinable"
    return f"{value:.{digits}f} +- {half_width:.{digits}f}"


def _cases(dataset: xr.Dataset, numbers: Spread, digits: int = 2) -> str:
    """Write numbers over (hurst, load), load after load."""
    value, width = (part.transpose("hurst", "load").values for part in (numbers.value, numbers.half_width))
    rows = [
        f"H = {h:g}: {', '.join(_pm(v, w, digits) for v, w in zip(value[k], width[k], strict=True))}"
        for k, h in enumerate(dataset.hurst.values)
    ]
    return "; ".join(rows)


def _loads(dataset: xr.Dataset) -> str:
    return "p* = " + ", ".join(f"{p:g}" for p in dataset.reduced_pressure.values)


def _level(dataset: xr.Dataset, zeta: float) -> int:
    return int(np.argmin(np.abs(np.log(dataset.zeta.values / zeta))))


def _excess(dataset: xr.Dataset) -> str:
    ratio = reading.over_persson(dataset)
    end, early = Spread.of(ratio.isel(level=-1)), ratio.isel(level=_level(dataset, _EARLY))
    share = (np.log(early.mean("surface")) / np.log(end.value)).where(end.value - 1 > end.half_width)
    most = ratio.mean("surface").max("level")
    return (
        f"The area over Persson's with all waves, {_loads(dataset)}: {_cases(dataset, end)} (95 % over "
        f"{dataset.sizes['surface']} surfaces). After the first octave and a half (zeta = {dataset.zeta.values[_level(dataset, _EARLY)]:.3g}) the logarithm of "
        f"that excess has {_range(100 * share, '.0f')} % of its final value; the largest mean excess on the way is {_range(100 * (most - 1), '.0f')} %."
    )


def _range(values: xr.DataArray, form: str) -> str:
    """Smallest and largest of what is finite."""
    found = values.values[np.isfinite(values.values)]
    if not found.size:
        return "an undeterminable share of"
    low, high = format(float(found.min()), form), format(float(found.max()), form)
    return low if low == high else f"{low} to {high}"


def _later(dataset: xr.Dataset) -> list[int]:
    """Octaves that begin where the short waves do."""
    begins = np.asarray(dataset.attrs["octaves"], dtype=float)[:-1]
    return [int(k) for k in np.flatnonzero(begins >= _LATE)] or [begins.size - 1]


def _relative_loss(dataset: xr.Dataset) -> str:
    book = reading.area_book(dataset)
    first = Spread.of((book.located / book.persson).isel(octave=0))
    later = book.isel(octave=_later(dataset)).mean("octave")
    return (
        f"The relative loss d ln A/d ln V over Persson's in the first octave, {_loads(dataset)}: {_cases(dataset, first)}; "
        f"from zeta = {_LATE:g} on: {_cases(dataset, Spread.of(later.located / later.persson))}."
    )


def _books(dataset: xr.Dataset) -> Iterator[str]:
    square, area = reading.square_book(dataset), reading.area_book(dataset)
    change = square.change.mean("surface")
    off = np.abs(square.told.mean("surface") / change - 1).max("octave")
    path = Spread.of(square.path - square.change)
    held = np.abs(path.value) <= path.half_width
    yield (
        "The book of the mean square pressure, by octave: drift and diffusivity taken as functions of p, and re-entry, make "
        f"{'' if float(off.max()) <= CLOSED else 'not '}all of d<p^2>/(A dV) within {100 * CLOSED:g} % (largest difference {100 * float(off.max()):.2f} %); the change along the "
        f"surface itself, without the negative rings, agrees within the 95 % intervals in {int(held.sum())} of {held.size} octaves."
    )
    touched = area.persson.mean("surface") < -0.05
    gap = np.abs((area.counted - area.located).mean("surface") / area.located.mean("surface")).where(touched)
    if not np.isfinite(gap.values).any():
        return
    closed = int((gap <= CLOSED).sum())
    yield (
        f"The book of the area, by octave: entering less leaving area, extrapolated over grids, equals the change of the located area within "
        f"{100 * CLOSED:g} % in {closed} of {int(touched.sum())} octaves where the area falls; the largest difference is {100 * float(gap.max()):.1f} %, the median {100 * float(gap.median()):.1f} %."
    )


def _terms(dataset: xr.Dataset) -> str:
    later = reading.square_book(dataset).isel(octave=_later(dataset)).mean("octave")
    parts = [
        f"{words}: {_cases(dataset, Spread.of(later[name]))}" for name, (words, _, _) in reading.TERMS.items()
    ]
    return (
        f"Terms of d<p^2>/(A dV) from zeta = {_LATE:g} on (Persson: D = 1, no drift, no re-entry), {_loads(dataset)}: {'. '.join(parts)}. "
        f"Together: {_cases(dataset, Spread.of(later.change))}."
    )


def _flows(dataset: xr.Dataset) -> Iterator[str]:
    steps = dataset.relative_step.values
    probe = dataset.sizes["probe"] - 1
    where = f"at zeta = {float(dataset.probe_zeta[probe]):g}"
    lost, entered = (reading.flux(dataset, name).isel(probe=probe) for name in ("lost", "entered"))
    least, most = steps[[0, -1]]
    yield (
        f"Area that leaves contact grows like Delta V to the power ({where}, Delta V/V = {least:g} to {most:g}), {_loads(dataset)}: "
        f"{_cases(dataset, Spread.of(reading.exponents(lost, steps).isel(pair=-1)), 3)}; between the two smallest steps: "
        f"{_cases(dataset, Spread.of(reading.exponents(lost, steps).isel(pair=0)), 3)}."
    )
    ratio = Spread.of(entered / lost)
    net = Spread.of(reading.net_flux(dataset).isel(probe=probe))
    yield (
        f"Of it re-enters, Delta V/V = {most:g}: {_cases(dataset, _at(ratio, -1))}; {least:g}: {_cases(dataset, _at(ratio, 0))}; in the limit, by a straight "
        f"line in sqrt(Delta V): {_cases(dataset, Spread.of(_at_zero_step(entered / lost, steps)))}. A flow over p = 0 therefore has no value without its step: only the net has one, "
        f"d ln A/d ln V = {_cases(dataset, _at(net, -1))} at {most:g} and {_cases(dataset, _at(net, -2))} at {steps[-2]:g}."
    )
    load, square = (
        reading.exponents(reading.flux(dataset, name).isel(probe=probe), steps).isel(pair=-1)
        for name in ("entered_load", "entered_square")
    )
    yield (
        f"The load that the entering points carry goes like Delta V to the power {_cases(dataset, Spread.of(load))}, their p^2 like {_cases(dataset, Spread.of(square))}: "
        "an edge that moves by sqrt(Delta V), with p growing like the root of the distance from it, gives 1/2, 3/4 and 1 for area, load and square."
    )


def _drift(dataset: xr.Dataset) -> Iterator[str]:
    """Say what drift and diffusivity are away from the edge, and at it."""
    steps, probe = dataset.relative_step.values, dataset.sizes["probe"] - 1
    drift, away = reading.within(dataset, *_AWAY)
    _, edge = reading.within(dataset, *_NEAR)
    chosen = int(np.argmin(np.abs(np.log(steps / _STEP))))
    zeta = float(dataset.probe_zeta[probe])
    yield (
        f"At zeta = {zeta:g} the diffusivity between p/sqrt(V) = {_AWAY[0]:.2g} and {_AWAY[1]:.2g} is {_range(away.value.isel(probe=probe), '.2f')} at all steps and loads (Persson: 1); between "
        f"{_NEAR[0]:.2g} and {_NEAR[1]:.2g} it goes from {_range(edge.value.isel(probe=probe, variance_step=-1), '.2f')} at Delta V/V = {steps[-1]:g} to {_range(edge.value.isel(probe=probe, variance_step=0), '.2f')} at {steps[0]:g} and has no limit."
    )
    here = {"probe": probe, "variance_step": chosen}
    at = Spread(value=drift.value.isel(here), half_width=drift.half_width.isel(here))
    load = Spread.of((reading.flux(dataset, "entered_load") / dataset.relative_step).isel(here))
    yield (
        f"The drift there, in units of Delta V/sqrt(V) at Delta V/V = {steps[chosen]:g}, is {_cases(dataset, at)} ({_loads(dataset)}), where the theory has none: "
        f"points that enter carry {_cases(dataset, load)} of load per contact area in the same unit, which those in contact lose, since the load is given (Eqs. 24 and 25 leave no such term)."
    )


#: Reduced pressures away from the edge of the contact, and at it (edges of bins), and the step at which the drift is told.
_AWAY, _NEAR, _STEP = (0.735, 2.94), (0.06, 0.135), 0.01


def _at(numbers: Spread, step: int) -> Spread:
    return Spread(
        value=numbers.value.isel(variance_step=step), half_width=numbers.half_width.isel(variance_step=step)
    )


def _at_zero_step(values: xr.DataArray, steps: np.ndarray) -> xr.DataArray:
    """Value at Delta V -> 0 by a straight line in its root through all steps."""
    import xarray as xr

    design = np.stack([np.ones(steps.size), np.sqrt(steps)], axis=1)
    weights = xr.DataArray(np.linalg.pinv(design)[0], dims="variance_step")
    return (values * weights).sum("variance_step", skipna=False)


def _edge(dataset: xr.Dataset) -> str:
    book = reading.edge_book(dataset)
    probe = dataset.sizes["probe"] - 1
    slope = Spread(
        value=dataset.slope.isel(probe=probe), half_width=dataset.slope_half_width.isel(probe=probe)
    )
    parts = [
        f"{name}: {_cases(dataset, Spread(value=one.value.isel(probe=probe), half_width=one.half_width.isel(probe=probe)))}"
        for name, one in book.items()
        if name != "Persson"
    ]
    persson = book["Persson"].value.isel(probe=probe)
    return (
        f"P'(0) over Persson's at zeta = {float(dataset.probe_zeta[probe]):g}, {_loads(dataset)}: {_cases(dataset, slope)}. "
        f"Eq. 26 with it would have the area fall faster than it does, -d ln A/d ln V: {'; '.join(parts)}; Persson's own {_range(persson, '.2f')}. "
        "His slope is too small, and he lets nothing re-enter."
    )


def _restart(dataset: xr.Dataset) -> str:
    ratio = reading.loss_ratio(dataset)
    end = reading.restarts(dataset).isel(level=-1)
    early, late = (int(np.argmin(np.abs(dataset.restart_zeta.values - z))) for z in (1.0, _LATE))
    return (
        f"Absorbing diffusion started from the true P(p) at zeta = {dataset.restart_zeta.values[late]:g} loses area faster than the truth over half an octave, by the factor "
        f"({_loads(dataset)}) {_cases(dataset, Spread.of(ratio.isel(restart=late)))}; with all waves its area over the true one is {_cases(dataset, Spread.of(end.isel(restart=late)))}, "
        f"started at zeta = {dataset.restart_zeta.values[early]:g}: {_cases(dataset, Spread.of(end.isel(restart=early)))}."
    )


def _memory(dataset: xr.Dataset) -> Iterator[str]:
    true, composed = (Spread.of(one) for one in reading.two_steps(dataset))
    chance = reading.returns(dataset)
    yield (
        f"Not Markov: over two rings the share of the contact area that comes in is, {_loads(dataset)}, {_cases(dataset, true, 3)}; the laws of single rings "
        f"compose to {_cases(dataset, composed, 3)}."
    )
    late = dataset.isel(grid=-1).out_at.isel(level=_level(dataset, 2.0))
    yield (
        f"A point that has just left is brought back by the next ring with the chance {_cases(dataset, Spread.of(chance.isel(age=1)), 3)}, one that left four rings ago {_cases(dataset, Spread.of(chance.isel(age=min(4, chance.sizes['age'] - 1))), 3)}, "
        f"one that was never in contact {_cases(dataset, Spread.of(chance.isel(age=0)), 4)}. Of the final contact "
        f"{_cases(dataset, Spread.of(dataset.isel(grid=-1).crossed_once))} had left at least once, and {_cases(dataset, Spread.of(late))} was out at zeta = 2."
    )
