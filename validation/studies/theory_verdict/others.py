"""Theories beyond Persson's and its variants, scored on the same surfaces."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from validation.arrays import Array
from validation.measures.distributions import largest_difference
from validation.scenes.realised import Realised
from validation.studies.theory_verdict.words import QUANTITIES
from validation.theories import Rough, Theory, find_theory

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["with_theories"]

#: Gauss points in each bin of the distribution of pressure.
_POINTS = 8


def with_theories(
    found: xr.Dataset, names: Sequence[str], *, data: xr.Dataset, pressed: Sequence[Realised]
) -> xr.Dataset:
    """Return the scores with those of further theories, told the realised surfaces, behind the variants.

    Parameters
    ----------
    found : xarray.Dataset
        Scores of the theory and its variants.
    names : sequence of str
        Of theories, or of functions or modules of the user's own.
    data : xarray.Dataset
        Of the study `pressure`.
    pressed : sequence of Realised
        Its surfaces.

    Raises
    ------
    UsageError
        For a theory that is unknown or cannot be evaluated.
    """
    import xarray as xr

    loads, told = data.reduced_pressure.values, [Rough.of(one) for one in pressed]
    # The original is scored already: what it is wrong by, times what it says over what another says.
    original = data.theory_area.sel(mode="conditional", variant="persson").values
    scores = []
    for name in names:
        theory = find_theory(name)
        said = _said(theory, told, loads)
        ratios, halves = np.full((2, len(QUANTITIES), loads.size), np.nan)
        for q, quantity in enumerate(QUANTITIES):
            if quantity not in said:
                continue
            ours = original if quantity == "area" else _conditional(data, quantity)
            with np.errstate(divide="ignore", invalid="ignore"):
                over = ours / said[quantity]
            ratios[q] = found.ratio[q, 0].values * over
            halves[q] = found.interval[q, 0].values * np.abs(over)
        pooled = data.stress_share.sum("surface").values
        distance = _distances(theory, told, loads, pooled=pooled, upper=data.stress_upper.values)
        scores.append(
            xr.Dataset(
                {
                    "ratio": (("quantity", "load"), ratios),
                    "interval": (("quantity", "load"), halves),
                    "distance": ("load", distance),
                },
                coords={"quantity": list(QUANTITIES), "variant": theory.label},
            )
        )
    scored = [found[["ratio", "interval", "distance"]], *scores]
    joined = xr.concat(scored, dim="variant", join="outer", coords="minimal", compat="override")
    rest = found.drop_vars(["ratio", "interval", "distance"]).reindex(variant=joined.variant)
    order = ("quantity", "variant", "load")
    return rest.assign({name: joined[name].transpose(*order, missing_dims="ignore") for name in joined})


def _conditional(data: xr.Dataset, quantity: str) -> Array:
    return np.asarray(data[f"theory_{quantity}"].sel(mode="conditional", variant="persson").values)


def _said(theory: Theory, told: Sequence[Rough], loads: Array) -> dict[str, Array]:
    """Return what a theory says of each quantity, means over the surfaces, in the units of the study."""

    def mean(
        function: Callable[[Array, Rough], Array | None], unit: Callable[[Rough], float]
    ) -> Array | None:
        rows = []
        for rough in told:
            value = function(loads * rough.contact_modulus * rough.moments.rms_gradient, rough)
            if value is None:
                return None
            rows.append(value / unit(rough))
        return np.asarray(np.mean(rows, axis=0))

    gap = mean(theory.mean_gap, lambda rough: rough.moments.rms_height)
    found = {
        "area": mean(theory.area, lambda rough: 1.0),
        "gap": gap,
        "gamma": None if gap is None else -np.gradient(gap, np.log(loads)),
        "energy": mean(theory.elastic_energy, lambda rough: rough.waves.full_energy * rough.contact_modulus),
    }
    return {name: value for name, value in found.items() if value is not None}


def _distances(theory: Theory, told: Sequence[Rough], loads: Array, *, pooled: Array, upper: Array) -> Array:
    """Distance of the simulated P(sigma) A0/A from that of a theory at each load; NaN where it has none."""
    x, weights = np.polynomial.legendre.leggauss(_POINTS)
    edges = np.concatenate([[0.0], upper])
    stress = edges[:-1, None] + np.diff(edges)[:, None] * (1 + x) / 2
    rough = told[0]
    unit = rough.contact_modulus * rough.moments.rms_gradient
    found = np.full(loads.size, np.nan)
    for j, load in enumerate(loads):
        density = theory.pressure_distribution((stress * unit).ravel(), load * unit, rough)
        if density is None:
            continue
        shares = (density.reshape(stress.shape) @ weights) * np.diff(edges) / 2 * unit
        area = float(theory.area(np.array([load * unit]), rough)[0])
        # What lies above the last edge counts in the last bin.
        shares[-1] += max(area - shares.sum(), 0.0)
        found[j] = float(largest_difference(pooled[j], shares)) if np.isfinite(area) else np.nan
    return found
