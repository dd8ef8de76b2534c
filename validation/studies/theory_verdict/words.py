"""What the scores of the theory are called: verdicts, the table of them, and sentences."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from validation.arrays import Array
from validation.measures.theory import VARIANTS, modes_sentence
from validation.report.table import ResultTable

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["QUANTITIES", "findings", "labels", "range_verdict", "table", "verdict"]

Indices = NDArray[np.intp]

_RANGES = ((0.0, 0.03), (0.03, 0.1), (0.1, 0.3), (0.3, 0.7), (0.7, 0.99), (0.99, 1.001))

#: Quantities scored as ratios, and how they are called.
QUANTITIES = {
    "area": "contact area",
    "gap": "mean gap",
    "gamma": "stiffness, as p0/(K h_rms)",
    "energy": "elastic energy",
}


def verdict(ratio: float, interval: float) -> str:
    """Return a word for a simulated over a predicted value with its 95 % half width.

    Examples
    --------
    >>> verdict(1.0, 1e-9), verdict(1.02, 0.03), verdict(1.36, 0.03), verdict(0.9, 0.3)
    ('exact', 'right within 5 %', 'off by +36 %', 'not determinable')
    """
    if not np.isfinite(ratio):
        return "says nothing"
    if interval < 1e-6 and abs(ratio - 1) < 1e-4:
        return "exact"
    if abs(ratio - 1) <= interval:
        return (
            f"right within {100 * (abs(ratio - 1) + interval):.2g} %"
            if interval < 0.1
            else "not determinable"
        )
    return f"off by {100 * (ratio - 1):+.2g} %" if ratio < 2 else f"off by a factor of {ratio:.2g}"


def range_verdict(ratios: Array, intervals: Array) -> str:
    """Return the verdict on several loads: the worst that is decided against, or else the load that is known best."""
    told = np.abs(ratios - 1) > intervals
    if told.any():
        pick = int(np.argmax(np.where(told, np.abs(ratios - 1), -1.0)))
    else:
        pick = int(np.argmin(np.where(np.isfinite(intervals), intervals, np.inf)))
    return verdict(float(ratios[pick]), float(intervals[pick]))


def _inside(dataset: xr.Dataset) -> list[tuple[str, Indices]]:
    """Ranges of the area that hold loads, in words, with their loads."""
    area = dataset.area.values
    ranges = [
        (f"{low:g} to {min(high, 1.0):g}", np.flatnonzero((area >= low) & (area < high)))
        for low, high in _RANGES
    ]
    return [(words, loads) for words, loads in ranges if loads.size]


def table(dataset: xr.Dataset) -> ResultTable:
    """Return one row for each quantity and range of contact area: the verdict on every variant."""
    rows: list[tuple[float | str, ...]] = []
    ranges = _inside(dataset)
    for q, words in enumerate(QUANTITIES.values()):
        for area, loads in ranges:
            ratio, interval = (dataset[name][q].values[:, loads] for name in ("ratio", "interval"))
            cells = [range_verdict(*row) for row in zip(ratio, interval, strict=True)]
            rows.append((words, area, *cells))
    for area, loads in ranges:
        distances = dataset.distance.values[:, loads].max(axis=1)
        cells = [f"differs by up to {d:.3f}" if np.isfinite(d) else "says nothing" for d in distances]
        rows.append(("P(sigma) A0/A", area, *cells))
    if "edge_value" in dataset:
        rows += _edge_rows(dataset)
    for name, words in _CLAIMS.items():
        for area, loads in ranges:
            # The claim is about light contact.
            if dataset.area.values[loads].min() > _LIGHT:
                continue
            nothing = ["says nothing"] * (dataset.sizes["variant"] - 1)
            rows.append((words, area, _claim(dataset, name, loads), *nothing))
    return ResultTable.of(("quantity", "A/A0", *labels(dataset)), rows)


def labels(dataset: xr.Dataset) -> list[str]:
    """How the theory, its variants and the further theories of a dataset are called."""
    known = {str(name): label for name, label in VARIANTS.items()}
    return [known.get(name, name) for name in dataset.variant.values.tolist()]


_CLAIMS = {
    "pressure": "P(sigma) A0/A independent of load (Secs. 3.3, 13)",
    "patches": "patch sizes by area independent of load (Secs. 3.3, 13)",
    "number": "patch sizes by number independent of load (Secs. 3.3, 13)",
}


#: Relative area beyond which nobody claims that distributions stay.
_LIGHT = 0.3


def _claim(dataset: xr.Dataset, name: str, loads: Indices) -> str:
    """Return the verdict on a claim of independence within one range: the load that moved most."""
    loads = loads[loads != int(dataset.attrs["reference_load"])]
    if not loads.size:
        return "the reference"
    moved, high, noise = (dataset[f"{name}_moved{end}"].values[loads] for end in ("", "_high", "_noise"))
    told = moved > noise
    if told.any():
        return f"moved by {moved[told].max():.3f}"
    known = int(np.argmin(high))
    return f"right within {high[known]:.3f}" if high[known] < 0.1 else "not determinable"


def _edge_rows(dataset: xr.Dataset) -> list[tuple[float | str, ...]]:
    where = f"at p* = {float(dataset.edge_pressure):g}"
    value, half = float(dataset.edge_value), float(dataset.edge_value_half)
    zero = f"right within {abs(value) + half:.3f}" if abs(value) <= half else f"off by {value:+.3f}"
    slopes = [
        verdict(float(ratio), float(interval))
        for ratio, interval in zip(dataset.edge_slope_ratio, dataset.edge_slope_half, strict=True)
    ]
    says = [zero if name in VARIANTS else "says nothing" for name in dataset.variant.values]
    return [("P(0+) E*h' = 0", where, *says), ("slope of P(sigma) at 0", where, *slopes)]


def findings(dataset: xr.Dataset) -> tuple[str, ...]:
    """Return the verdicts in sentences."""
    sentences = []
    area = dataset.ratio.sel(quantity="area")
    half = dataset.interval.sel(quantity="area")
    for i, name in enumerate(labels(dataset)):
        ratio = area[i].values
        told = np.abs(ratio - 1) > half[i].values
        if not np.isfinite(ratio).all():
            sentences.append(_partial(dataset, name, ratio, half[i].values))
            continue
        worst = int(np.argmax(np.where(told, np.abs(ratio - 1), 0.0)))
        sentences.append(
            f"{name}: simulated over predicted area is {ratio[0]:.3f} at the lightest load (p* = {dataset.reduced_pressure.values[0]:g}) and "
            f"{ratio[-1]:.3f} at the heaviest; worst {verdict(float(ratio[worst]), float(half[i, worst]))} at "
            f"A/A0 = {dataset.area.values[worst]:.3g}."
        )
    for quantity, words in QUANTITIES.items():
        sentences.append(_closest(dataset, quantity, words))
    sentences.append(
        modes_sentence(
            *(dataset.theory_area.sel(mode=mode, variant="persson") for mode in dataset.mode.values)
        )
    )
    if "edge_value" in dataset:
        value, slope = float(dataset.edge_value), float(dataset.edge_slope_ratio[0])
        sentences.append(
            f"P(sigma) starts from {value:+.3f} +- {float(dataset.edge_value_half):.2g} (over E* h'_rms; the theory: 0), with {slope:.1f} +- "
            f"{float(dataset.edge_slope_half[0]):.1g} times the slope of the theory, at p* = {float(dataset.edge_pressure):g} on another bandwidth (study stress-near-zero)."
        )
    return tuple(sentences)


def _partial(dataset: xr.Dataset, name: str, ratio: Array, half: Array) -> str:
    """Say of a theory that does not reach all loads how far it is off where it says something."""
    said = np.flatnonzero(np.isfinite(ratio))
    if not said.size:
        return f"{name}: says nothing of the area at these loads."
    first, last = said[0], said[-1]
    loads = dataset.reduced_pressure.values
    return (
        f"{name}: simulated over predicted area is {ratio[first]:.3f} +- {half[first]:.2g} at p* = {loads[first]:g} and "
        f"{ratio[last]:.3f} +- {half[last]:.2g} at p* = {loads[last]:g}; it says nothing of {loads.size - said.size} of "
        f"{loads.size} loads."
    )


def _closest(dataset: xr.Dataset, quantity: str, words: str) -> str:
    """Say which variant is closest on average over the loads below full contact, and how far the original is."""
    open_contact = dataset.area.values < _RANGES[-1][0]
    off = np.abs(dataset.ratio.sel(quantity=quantity).values[:, open_contact] - 1).mean(axis=1)
    best = int(np.nanargmin(off))
    name = labels(dataset)[best]
    return (
        f"{words[0].upper()}{words[1:]}, mean distance over these loads below full contact: '{name}' is closest, {100 * off[best]:.2g} % off; "
        f"the original theory is {100 * off[0]:.2g} % off."
    )
