"""What the books of the autopsy say, in sentences."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from validation.studies.autopsy import reading
from validation.studies.autopsy.reading import Spread

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["CLOSED", "all_of"]

#: Books are called closed within this.
CLOSED = 0.02

#: The end of the first octave and a half, and where the short waves begin.
_EARLY, _LATE = 2**1.5, 4.0

#: Reduced pressures away from the edge of the contact, and at it (edges of bins), and the step at which the drift is told.
_AWAY, _NEAR, _STEP = (0.735, 2.94), (0.06, 0.135), 0.01

#: d ln A / d ln V of the theory from which on the contact is not full.
_TOUCHED = -0.05


def all_of(dataset: xr.Dataset) -> Iterator[str]:
    """Yield them all."""
    loads = ", ".join(f"{p:g}" for p in dataset.reduced_pressure.values)
    yield f"Numbers below are for p* = {loads} in this order, with the largest of their 95 % half widths over surfaces."
    yield from _excess(dataset)
    yield from _terms(dataset)
    yield from _books(dataset)
    yield from _drift(dataset)
    yield from _flows(dataset)
    yield from _edge(dataset)
    yield from _restart(dataset)
    yield from _memory(dataset)


def _cases(dataset: xr.Dataset, numbers: Spread, digits: int = 2) -> str:
    """Write numbers over (hurst, load): those of each H in a row, with the largest of their half widths."""
    value, width = (part.transpose("hurst", "load").values for part in (numbers.value, numbers.half_width))
    rows = []
    for k, hurst in enumerate(dataset.hurst.values):
        known = np.isfinite(value[k])
        said = [f"{v:.{digits}f}" if np.isfinite(v) else "not determinable" for v in value[k]]
        most = f" (+- {np.nanmax(width[k][known]):.{digits}f})" if known.any() else ""
        rows.append(f"{', '.join(said)}{most} at H = {hurst:g}")
    return "; ".join(rows)


def _range(values: xr.DataArray, form: str) -> str:
    """Smallest and largest of what is finite."""
    found = values.values[np.isfinite(values.values)]
    if not found.size:
        return "not determinable"
    low, high = format(float(found.min()), form), format(float(found.max()), form)
    return low if low == high else f"{low} to {high}"


def _at(numbers: Spread, **where: int) -> Spread:
    return Spread(value=numbers.value.isel(where), half_width=numbers.half_width.isel(where))


def _nearest(values: xr.DataArray, wanted: float) -> int:
    return int(np.argmin(np.abs(np.log(values.values / wanted))))


def _later(dataset: xr.Dataset) -> list[int]:
    """Octaves that begin where the short waves do; the last one if there is none."""
    begins = np.asarray(dataset.attrs["octaves"], dtype=float)[:-1]
    return [int(k) for k in np.flatnonzero(begins >= _LATE)] or [begins.size - 1]


def _late(dataset: xr.Dataset) -> str:
    return f"from zeta = {dataset.attrs['octaves'][_later(dataset)[0]]:g} on"


def _excess(dataset: xr.Dataset) -> Iterator[str]:
    """Say where the area comes to exceed the theory's."""
    ratio = reading.over_persson(dataset)
    early = dataset.zeta.values[_nearest(dataset.zeta, _EARLY)]
    there = Spread.of(ratio.isel(level=_nearest(dataset.zeta, _EARLY)))
    yield (
        f"Area over Persson's after the first octave and a half (zeta = {early:.3g}): {_cases(dataset, there)}; with all waves "
        f"(zeta = {dataset.zeta.values[-1]:g}): {_cases(dataset, Spread.of(ratio.isel(level=-1)))}."
    )
    yield (
        f"Where Persson's own area is {', '.join(f'{a:g}' for a in _SHARES)}, it is {', '.join(_range(reading.at_share(dataset, a), '.2f') for a in _SHARES)} "
        f"over all H and loads that come by there."
    )
    book = reading.area_book(dataset)
    book = book.where(book.persson < _TOUCHED)
    later = book.isel(octave=_later(dataset)).mean("octave")
    first = Spread.of(book.located.isel(octave=0) / book.persson.isel(octave=0))
    yield (
        f"Relative loss of area d ln A/d ln V over Persson's in the first octave: {_cases(dataset, first)}; "
        f"{_late(dataset)}: {_cases(dataset, Spread.of(later.located / later.persson))}."
    )


def _terms(dataset: xr.Dataset) -> Iterator[str]:
    """Say what the change of the mean square pressure consists of."""
    later = reading.square_book(dataset).isel(octave=_later(dataset)).mean("octave")
    yield (
        f"Mean square pressure, d<p^2>/(A dV) {_late(dataset)}, where the theory has 1: "
        f"{_cases(dataset, Spread.of(later.change))}."
    )
    for name, said in (
        ("diffusion", "diffusivity, in the theory 1"),
        ("drift", "drift, in the theory 0"),
        ("re_entry", "re-entry, in the theory 0"),
    ):
        yield f"Of that {reading.TERMS[name][0]} ({said}): {_cases(dataset, Spread.of(later[name]))}."


def _books(dataset: xr.Dataset) -> Iterator[str]:
    """Say whether anything is missing."""
    square, area = reading.square_book(dataset), reading.area_book(dataset)
    off = float(np.abs(square.told.mean("surface") / square.change.mean("surface") - 1).max())
    path = Spread.of(square.path - square.change)
    held = np.abs(path.value) <= path.half_width + _ROUNDING
    yield (
        f"The book of the mean square pressure {'closes' if off <= CLOSED else 'does not close'} within {100 * CLOSED:g} % in every octave: D(p), mu(p) and "
        f"re-entry make d<p^2> but for {100 * off:.2f} % at most. Without the negative rings it is the same within the 95 % intervals in {int(held.sum())} of {held.size} octaves."
    )
    touched = area.persson.mean("surface") < _TOUCHED
    gap = np.abs((area.counted - area.located).mean("surface") / area.located.mean("surface")).where(touched)
    if touched.any():
        closed = int((gap <= CLOSED).sum())
        yield (
            f"The book of the area closes within {100 * CLOSED:g} % in {closed} of {int(touched.sum())} octaves of partial contact: entering less leaving area, extrapolated "
            f"over grids, against the change of the located area (median {100 * float(gap.median()):.1f} %, largest {100 * float(gap.max()):.1f} %)."
        )


#: What counts as no difference where both are exact.
_ROUNDING = 1e-9


def _drift(dataset: xr.Dataset) -> Iterator[str]:
    """Say what drift and diffusivity are away from the edge, and at it."""
    steps, probe = dataset.relative_step.values, dataset.sizes["probe"] - 1
    drift, away = reading.within(dataset, *_AWAY)
    _, edge = reading.within(dataset, *_NEAR)
    chosen = _nearest(dataset.relative_step, _STEP)
    least, most = (_at(edge, probe=probe, variance_step=k) for k in (0, -1))
    grows = bool((least.value - most.value > least.half_width).all())
    yield (
        f"Away from the edge (p/sqrt(V) = {_AWAY[0]:.1f} to {_AWAY[1]:.1f}, zeta = {float(dataset.probe_zeta[probe]):g}) the diffusivity is {_range(away.value.isel(probe=probe), '.2f')} at all steps. "
        f"At it ({_NEAR[0]:.2f} to {_NEAR[1]:.2f}) it is {_range(most.value, '.2f')} at Delta V/V = {steps[-1]:g} and {_range(least.value, '.2f')} at {steps[0]:g}: "
        f"it {'grows as the step falls, without a limit' if grows else 'is not seen to grow as the step falls'}."
    )
    load = Spread.of(reading.flux(dataset, "entered_load") / dataset.relative_step)
    yield (
        f"The drift away from the edge, in Delta V/sqrt(V), is {_cases(dataset, _at(drift, probe=probe, variance_step=chosen))} (Delta V/V = {steps[chosen]:g}): at a given load "
        f"those in contact lose what entering points take up, per contact area {_cases(dataset, _at(load, probe=probe, variance_step=chosen))}. Eqs. 24 and 25 have neither."
    )


def _flows(dataset: xr.Dataset) -> Iterator[str]:
    """Say what goes over p = 0, by the step."""
    steps = dataset.relative_step.values
    probe = dataset.sizes["probe"] - 1
    lost, entered = (reading.flux(dataset, name).isel(probe=probe) for name in ("lost", "entered"))
    powers = reading.exponents(lost, steps)
    fine = Spread.of(_power_at_zero_step(powers, steps))
    ends = Spread.of(powers.isel(pair=-2) - powers.isel(pair=0)).value
    falls = bool((ends > 0).where(np.isfinite(ends), True).all())
    half = np.abs(fine.value - 0.5) <= np.maximum(fine.half_width, _HALF)
    known = int(np.isfinite(fine.value).sum())
    all_steps = Spread.of(powers.isel(pair=-1))
    bound = bool((all_steps.value + all_steps.half_width < 1).where(np.isfinite(all_steps.value), True).all())
    yield (
        f"Area that leaves contact goes like Delta V to the power {_cases(dataset, all_steps)} between Delta V/V = {steps[0]:g} and {steps[-1]:g} "
        f"(zeta = {float(dataset.probe_zeta[probe]):g}). Between neighbouring steps it {'falls with the step in every case' if falls else 'does not fall with the step in every case'}; "
        f"in the limit, straight in sqrt(Delta V), it is "
        f"{_cases(dataset, fine)}: 1/2 within {_HALF:g} or the interval in {int(half.sum())} of {known} cases."
    )
    yield (
        f"Entering over leaving area: {_cases(dataset, Spread.of((entered / lost).isel(variance_step=-1)))} at Delta V/V = {steps[-1]:g}; in the limit, straight in sqrt(Delta V), "
        f"{_cases(dataset, Spread.of(_at_zero_step(entered / lost, steps)))}. "
        f"{'Since the power is less than 1, no flow over p = 0 has a value without its step.' if bound else 'The power is not told from 1 in every case.'}"
    )
    net = Spread.of(reading.net_flux(dataset).isel(probe=probe))
    yield (
        f"The net, d ln A/d ln V, is {_cases(dataset, _at(net, variance_step=-1))} at Delta V/V = {steps[-1]:g}, {_cases(dataset, _at(net, variance_step=-2))} at {steps[-2]:g}."
    )
    load, square = (
        Spread.of(reading.exponents(reading.flux(dataset, name).isel(probe=probe), steps).isel(pair=-1))
        for name in ("entered_load", "entered_square")
    )
    yield (
        f"Load of the entering points goes like Delta V to the power {_cases(dataset, load)}, their p^2 like {_cases(dataset, square)}. An edge that moves by sqrt(Delta V), "
        "with p like the root of the distance from it, has 1/2, 3/4 and 1 for area, load and square."
    )


#: Areas of the theory at which the simulated one is told.
_SHARES = (0.9, 0.5, 0.2, 0.1)

#: How near 1/2 an exponent is called so.
_HALF = 0.03


def _at_zero_step(values: xr.DataArray, steps: np.ndarray) -> xr.DataArray:
    """Value at Delta V -> 0 by a straight line in its root through all steps."""
    import xarray as xr

    design = np.stack([np.ones(steps.size), np.sqrt(steps)], axis=1)
    weights = xr.DataArray(np.linalg.pinv(design)[0], dims="variance_step")
    return (values * weights).sum("variance_step", skipna=False)


def _power_at_zero_step(powers: xr.DataArray, steps: np.ndarray) -> xr.DataArray:
    """Exponent at Delta V -> 0 from those between neighbours: c sqrt(Delta V) (1 + a sqrt(Delta V)) has 1/2 + a sqrt(Delta V)/2."""
    if steps.size == 2:
        return powers.isel(pair=0)
    local = powers.isel(pair=slice(0, steps.size - 1)).rename(pair="variance_step")
    return _at_zero_step(local, np.sqrt(steps[1:] * steps[:-1]))


def _edge(dataset: xr.Dataset) -> Iterator[str]:
    """Compare the flow of Eq. 26 with both slopes."""
    book, probe = reading.edge_book(dataset), dataset.sizes["probe"] - 1
    slope = Spread(value=dataset.slope, half_width=dataset.slope_half_width)
    true, own = (_at(book[name], probe=probe) for name in ("true", "of the true slope"))
    apart = int((own.value - true.value > np.hypot(own.half_width, true.half_width)).sum())
    yield (
        f"P'(0) over Persson's at zeta = {float(dataset.probe_zeta[probe]):g}: {_cases(dataset, _at(slope, probe=probe), 1)}. Eq. 26 with the true slope gives -d ln A/d ln V = "
        f"{_cases(dataset, own)}; the truth is {_cases(dataset, true)}; his own slope gives "
        f"{', '.join(f'{v:.2f}' for v in book['Persson'].value.isel(probe=probe, hurst=0).values)}. In {apart} of {true.value.size} cases Eq. 26 with the true slope loses too much, beyond the intervals."
    )


def _restart(dataset: xr.Dataset) -> Iterator[str]:
    """Say whether the errors cancel."""
    late = _nearest(dataset.restart_zeta, _LATE)
    ratio = Spread.of(reading.loss_ratio(dataset).isel(restart=late))
    end = Spread.of(reading.restarts(dataset).isel(level=-1))
    yield (
        f"Absorbing diffusion started from the true P(p) at zeta = {dataset.restart_zeta.values[late]:g} loses area over the next half octave {_cases(dataset, ratio)} times as fast as the truth. "
        f"With all waves it ends at {_cases(dataset, _at(end, restart=late))} of the true area; started at zeta = {dataset.restart_zeta.values[0]:g}, at {_cases(dataset, _at(end, restart=0))}."
    )


def _memory(dataset: xr.Dataset) -> Iterator[str]:
    """Say whether the past matters."""
    both = reading.two_steps(dataset)
    true, composed = (Spread.of(one) for one in both)
    difference = Spread.of(both[1] - both[0])
    partial = true.value > _SOME
    apart = int(((np.abs(difference.value) > difference.half_width) & partial).sum())
    chance = Spread.of(reading.returns(dataset))
    finest = dataset.isel(grid=-1)
    out = Spread.of(finest.out_at.isel(level=_nearest(dataset.zeta, 2.0)))
    long = min(4, dataset.sizes["age"] - 2)
    yield (
        f"Over two rings {_cases(dataset, true, 3)} of the contact area comes in; the laws of single rings compose to {_cases(dataset, composed, 3)}. "
        f"In {apart} of {int(partial.sum())} cases of partial contact the two differ beyond the interval: {'no Markov process' if apart else 'not told from a Markov process'}."
    )
    yield (
        f"A ring brings back a point that the last one took out with the chance {_cases(dataset, _at(chance, age=1))}, one that left {long} rings before with {_cases(dataset, _at(chance, age=long), 3)}."
    )
    yield (
        f"Of the final contact {_cases(dataset, Spread.of(finest.crossed_once))} had left at least once, and {_cases(dataset, out)} was out at zeta = 2."
    )


#: Inflow over the contact area below which contact is full.
_SOME = 1e-3
