"""What the study of the energy says: estimates with their intervals, table and sentences."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from validation.arrays import Array
from validation.measures.common import over_surfaces
from validation.report.table import ResultTable

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["QUANTITIES", "Scored", "findings", "scored", "table"]

#: What is compared, and how it is called.
QUANTITIES = {
    "energy": "elastic energy / that of full contact",
    "gap": "mean gap / h_rms",
    "compliance": "compliance p0 / (K h_rms)",
}


@dataclass(frozen=True, kw_only=True, eq=False)
class Scored:
    """One quantity over the loads, and how far every theory is from it.

    Attributes
    ----------
    value, surfaces, grid, solver, half_width : (loads,) arrays
        Mean; halves of 95 % intervals: over surfaces, of the grid limit (off to one side on all surfaces), what the
        solver's tolerance leaves; the root of the sum of their squares.
    ratio, interval : (theories, loads) arrays
        Simulated over predicted, and half of its 95 % interval; NaN where the contact is full.
    """

    value: Array
    surfaces: Array
    grid: Array
    solver: Array
    half_width: Array
    ratio: Array
    interval: Array

    @property
    def holds(self) -> NDArray[np.bool_]:
        """Whether a theory lies within the interval, (theories, loads)."""
        return np.abs(self.ratio - 1) <= self.interval


def scored(dataset: xr.Dataset, name: str) -> Scored:
    """Score every theory on one of `QUANTITIES`."""
    means = [over_surfaces(dataset[name][:, j]) for j in range(dataset.sizes["load"])]
    value, surfaces = (np.array([getattr(m, part) for m in means]) for part in ("value", "half_width"))
    grid = 1.96 * np.sqrt(np.mean(dataset[f"{name}_error"].values ** 2, axis=0))
    usual = int(np.argmin(np.abs(np.log(dataset.tolerance.values / dataset.attrs["solver_tolerance"]))))
    solver = np.nan_to_num(dataset[f"left_{name}"].values[usual]) * np.abs(value)
    half = np.sqrt(np.nan_to_num(surfaces) ** 2 + grid**2 + solver**2)
    # In full contact nothing is left of gap and compliance, and the energy is known.
    full = dataset.gap.values.max(axis=0) <= 0
    predicted = dataset[f"theory_{name}"].values
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio, interval = (np.where(full, np.nan, part / predicted) for part in (value, half))
    return Scored(
        value=value,
        surfaces=surfaces,
        grid=grid,
        solver=solver,
        half_width=half,
        ratio=ratio,
        interval=interval,
    )


def table(dataset: xr.Dataset) -> ResultTable:
    """Return one row for each quantity and load."""
    names = dataset.theory.values.tolist()
    rows: list[dict[str, float | str]] = []
    for name, words in QUANTITIES.items():
        found = scored(dataset, name)
        for j in range(dataset.sizes["load"]):
            holds = [str(theory) for theory, yes in zip(names, found.holds[:, j], strict=True) if yes]
            none = "none" if np.isfinite(found.ratio[0, j]) else "full contact"
            rows.append(
                {
                    "quantity": words,
                    "p*": float(dataset.reduced_pressure[j]),
                    "A/A0": float(dataset.area[:, j].mean()),
                    "limit": float(found.value[j]),
                    "+- surfaces (95 %)": float(found.surfaces[j]),
                    "+- grid": float(found.grid[j]),
                    "+- solver": float(found.solver[j]),
                    **{f"over {name}": float(found.ratio[v, j]) for v, name in enumerate(names)},
                    "within the interval": "; ".join(holds) or none,
                }
            )
    return ResultTable.of_rows(rows)


def findings(dataset: xr.Dataset) -> tuple[str, ...]:
    """Say how far each theory is off, where, and what the checks found."""
    sentences = []
    for name, words in QUANTITIES.items():
        found = scored(dataset, name)
        sentences += [
            _ends(dataset, found, words),
            _ranked(found, dataset.theory.values.tolist(), words),
        ]
    if dataset.sizes["surface"] == 1:
        sentences.append(
            "The intervals are those of grids and solver: how much another surface would differ is unknown."
        )
    return (*sentences, *_checks(dataset), _tolerances(dataset))


def _ends(dataset: xr.Dataset, found: Scored, words: str) -> str:
    """Say how far the original theory is off at three loads, to the heaviest that leaves a gap."""
    partial = np.flatnonzero(np.isfinite(found.ratio[0]))
    parts = [
        f"{found.ratio[0, j]:.3g} +- {found.interval[0, j]:.1g} at A/A0 = {float(dataset.area[:, j].mean()):.3g}"
        for j in (partial[0], partial[len(partial) // 2], partial[-1])
    ]
    return f"{words[0].upper()}{words[1:]}, over that of {dataset.theory.values[0]}: {', '.join(parts)}."


def _ranked(found: Scored, names: list[str], words: str) -> str:
    """Say which theories are nearest and farthest: by the worst load that is told, as a factor."""
    told = np.isfinite(found.ratio) & ~found.holds
    factor = np.exp(np.abs(np.log(np.maximum(found.ratio, 1e-12))))
    worst = np.max(np.where(told, factor, 1.0), axis=1)
    order = np.argsort(worst)
    loads = int(np.isfinite(found.ratio[0]).sum())

    def said(v: int) -> str:
        held = int(found.holds[v].sum())
        off = f"off by a factor of {worst[v]:.3g} at worst" if held < loads else "nowhere told from it"
        return f"{names[v]} ({off}, within the interval at {held} of {loads} loads)"

    return f"{words[0].upper()}{words[1:]}: nearest are {said(order[0])} and {said(order[1])}, farthest is {said(order[-1])}."


def _checks(dataset: xr.Dataset) -> tuple[str, ...]:
    """Energy against work, stiffness against neighbouring loads, full contact."""
    partial = dataset.first_gap.values > 0
    work, stiffness = (
        np.abs(dataset[name].values[partial] - 1).max() for name in ("work", "stiffness_check")
    )
    path = np.abs(dataset.path_work.values[1:] - 1).max()
    said = [
        f"Checks, first surface: the energy gained between loads .2 % apart is the work of the load within {work:.1g}, "
        f"and their difference quotient the stiffness within {stiffness:.1g}, relative, at every load that leaves a gap; "
        f"along the whole path it is the integral of p du within {path:.1g}, by a quadrature of fourth order."
    ]
    if not partial.all():
        j = int(np.flatnonzero(~partial)[0])
        said.append(
            f"From p* = {float(dataset.reduced_pressure[j]):g} on the contact of the first surface is full: its gap is "
            f"{float(dataset.first_gap[j]):.1g} h_rms, its energy that of full contact within "
            f"{abs(float(dataset.first_energy[j]) - 1):.1g}."
        )
    return tuple(said)


def _tolerances(dataset: xr.Dataset) -> str:
    """Say what each tolerance leaves of the smallest gap there is."""
    j = int(np.flatnonzero(dataset.first_gap.values > 0)[-1])
    parts = ", ".join(
        f"{float(left):.1g} at {float(tolerance):.0e}"
        for tolerance, left in zip(dataset.tolerance.values, dataset.left_gap.values[:, j], strict=True)
    )
    return (
        f"The smallest gap, {float(dataset.first_gap[j]):.3g} h_rms at p* = {float(dataset.reduced_pressure[j]):g}, is "
        f"certified by the tolerance of the solver: relative to a tolerance of 1e-12 it is off by {parts}; "
        f"the study takes {dataset.attrs['solver_tolerance']:.0e}."
    )
