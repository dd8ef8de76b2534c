"""What the study of adhesion by magnification says: means with intervals, table and sentences."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from validation.arrays import Array
from validation.measures.distributions import largest_difference
from validation.measures.statistics import Estimate, mean_over_surfaces
from validation.report.table import ResultTable

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["QUANTITIES", "TOLD", "estimate", "findings", "solved", "table", "theory"]

#: Which work the cut surface is given, in words.
TOLD = {"own": "w", "effective": "effective work"}
#: What is compared, and how it is called.
QUANTITIES = {
    "contact": "A/A0",
    "force": "F/F_load, force in the contact over the load",
    "energy": "U_el over that of full contact",
    "tension": "share of the contact under tension",
}


def estimate(dataset: xr.Dataset, name: str, told: int, z: int) -> Estimate:
    """Mean over surfaces; the half width holds the limit over grids, off to one side on all surfaces."""
    found = mean_over_surfaces(dataset[name].values[told, :, z])
    grid = 1.96 * float(np.sqrt(np.mean(dataset[f"{name}_error"].values[told, :, z] ** 2)))
    return Estimate(
        value=found.value,
        standard_error=found.standard_error,
        half_width=math.hypot(found.half_width, grid),
        samples=found.samples,
    )


def theory(dataset: xr.Dataset, name: str, told: int, z: int) -> Array:
    """Return what each reading says, mean over the surfaces."""
    return np.asarray(dataset[f"theory_{name}"].values[told, :, z].mean(axis=0))


def distances(dataset: xr.Dataset, told: int, z: int) -> Array:
    """Largest difference of the cumulated P(sigma) A0/A from the theory's, surfaces pooled, for each reading."""
    ours = dataset.stress.values[told, :, z].sum(axis=0)
    theirs = dataset.theory_stress.values[told, :, z].sum(axis=0)
    return np.array([largest_difference(ours, one) if np.isfinite(one).all() else np.nan for one in theirs])


def solved(dataset: xr.Dataset) -> list[tuple[int, int]]:
    """Works and magnifications at which every surface was solved."""
    area = dataset.contact.values
    return [
        (t, z) for t in range(area.shape[0]) for z in range(area.shape[2]) if np.isfinite(area[t, :, z]).all()
    ]


def table(dataset: xr.Dataset) -> ResultTable:
    """Return one row for each work and magnification."""
    rows: list[dict[str, float | str]] = []
    short = ("A/A0", "F/F_load", "U_el/U_full", "share in tension")
    for told, z in solved(dataset):
        row: dict[str, float | str] = {
            "work": list(TOLD.values())[told],
            "zeta": float(dataset.magnification[z]),
            "A/A0 without adhesion": estimate(dataset, "plain", told, z).value,
        }
        for name, words in zip(QUANTITIES, short, strict=True):
            found = estimate(dataset, name, told, z)
            row |= {words: found.value, f"+- {words} (95 %)": found.half_width}
            said = theory(dataset, name, told, z)
            row |= {
                f"{words}, theory (Eqs. 44-49)": float(said[0]),
                f"{words}, theory (Eq. 43)": float(said[1]),
            }
        for reading, distance in zip(("Eqs. 44-49", "Eq. 43"), distances(dataset, told, z), strict=True):
            row[f"distance of P(sigma) A0/A ({reading})"] = float(distance)
        row["A/A0 parted from full contact"] = estimate(dataset, "parted", told, z).value
        rows.append(row)
    return ResultTable.of_rows(rows)


def findings(dataset: xr.Dataset) -> tuple[str, ...]:
    """Say how far the theory is from every quantity, and what of it can be compared."""
    sentences = [_sentence(dataset, told, z) for told, z in solved(dataset)]
    left = [
        f"{float(zeta):g}"
        for z, zeta in enumerate(dataset.magnification.values)
        if not np.isfinite(dataset.contact.values[1, :, z]).all()
    ]
    if left:
        sentences.append(
            f"At zeta = {', '.join(left)} the theory's gamma_eff holds nothing: there is no contact with it to solve."
        )
    return (*sentences, _by_waves(dataset), *_range(dataset))


def _sentence(dataset: xr.Dataset, told: int, z: int) -> str:
    def pair(name: str) -> str:
        said = ", ".join(f"{v:.3g}" for v in theory(dataset, name, told, z) if np.isfinite(v))
        return f"{estimate(dataset, name, told, z)} ({said})"

    distance = ", ".join(f"{v:.2g}" for v in distances(dataset, told, z) if np.isfinite(v))
    area, plain = (estimate(dataset, name, told, z).value for name in ("contact", "plain"))
    theirs = theory(dataset, "contact", told, z) / float(dataset.theory_plain.values[told, :, z].mean())
    times = ", ".join(f"{v:.3g}" for v in theirs if np.isfinite(v))
    return (
        f"zeta = {float(dataset.magnification[z]):g}, work {list(TOLD.values())[told]}: A/A0 = {pair('contact')}, {area / plain:.3g} times "
        f"({times}) that without adhesion; F/F_load = {pair('force')}; U_el/U_full = {pair('energy')}; in tension {pair('tension')} of "
        f"the contact; P(sigma) A0/A differs by up to {distance}. In brackets the theory, by Eqs. 44-49 and then by Eq. 43."
    )


def _by_waves(dataset: xr.Dataset) -> str:
    """P~ of the longest and of the shortest waves of the whole surface."""
    parts = []
    for s in (0, dataset.sizes["shell"] - 1):
        ours = mean_over_surfaces(dataset.share.values[:, s])
        said = ", ".join(f"{v:.3g}" for v in dataset.theory_share.values[:, :, s].mean(axis=1))
        parts.append(f"{ours} up to zeta = {float(dataset.shell_end[s]):g} ({said})")
    return (
        f"With all waves, P~ of those added last before a magnification, energy stored over that of full contact, is {'; '.join(parts)}; "
        f"{100 * float(dataset.beyond.mean()):.2g} % of the energy is in waves shorter than any of the surface, of which the theory knows nothing."
    )


def _range(dataset: xr.Dataset) -> tuple[str, ...]:
    """Say what the range of the attraction and the history of the contact change."""
    zeta = float(dataset.magnification[1])
    area, force = (float(dataset[name][0, 0, 1]) for name in ("contact", "force"))
    parted = (dataset.parted - dataset.contact).values
    return (
        f"The theory knows no range: with half of it (zeta = {zeta:g}, first surface) A/A0 is {float(dataset.half_area):.3g} for "
        f"{area:.3g}, and F/F_load {float(dataset.half_force):.3g} for {force:.3g}. What F exceeds the load by is the pull outside the contact.",
        f"Parted from full contact instead of approached, A/A0 is larger by up to {np.nanmax(parted):.2g}: the energy has several minima, "
        "of which the theory has one.",
        "Areas are projected in both; A counts points whose gap is closed, and the stress in them reaches down to the strength of the law.",
    )
