"""What the numbers of the study of refinement say, in sentences."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from validation.measures.budget import grid_share
from validation.measures.references import PUBLISHED
from validation.measures.statistics import Estimate, combined, mean_over_surfaces, order_of_convergence
from validation.measures.theory import modes_sentence
from validation.studies.refinement.data import AREAS, overestimate

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["all_of"]

#: Pressure, over E* h'_rms, below which the excess of a coarse grid is looked for.
_SMALL = 0.2


def all_of(dataset: xr.Dataset) -> Iterator[str]:
    """Yield what refinement shows, in words."""
    pressure = float(dataset.attrs["reduced_pressure"])
    limit = mean_over_surfaces(dataset.limit.values / pressure)
    theory = float(dataset.theory) / pressure
    resolved = dataset.isel(grid=np.flatnonzero(dataset.points_per_wave.values > 2 * (1 + 1e-9)))
    whole = "" if limit.samples == 1 else f" (95 %, {limit.samples} surfaces)"
    start = f"kappa in the limit of vanishing spacing is {limit}{whole} at p* = {pressure:.6g}; "
    if np.isfinite(theory):
        yield (
            f"{start}Persson's theory gives {theory:.4g}: {100 * (1 - theory / limit.value):.0f} % of the simulated area is not "
            "explained by the grid."
        )
        yield _verdict(resolved, limit.value, theory)
    else:
        yield f"{start}Persson's theory knows nothing of these effects."
    if "bare" in dataset.attrs:
        yield modes_sentence([theory * pressure], [float(dataset.ensemble)])
    yield _load_identity(resolved)
    yield from _by_area(resolved)
    yield from _criterion(resolved)
    if "kappa_grid_scale" in dataset:
        yield _protocol(dataset, limit.value, theory)
        yield _published(dataset, limit)
    for e in range(dataset.sizes.get("element", 0)):
        yield _element_sentence(dataset, e)
    for m in range(dataset.sizes.get("other_method", 0)):
        yield _other_sentence(dataset, m)


def _by_area(resolved: xr.Dataset) -> Iterator[str]:
    """Say how far each definition of the area is from the limit, grid by grid."""
    per_wave = resolved.points_per_wave.values
    for name in AREAS:
        error = overestimate(resolved, name).mean("surface").values
        if not np.all(np.isfinite(error)):
            continue
        order = order_of_convergence(1 / per_wave, np.where(error == 0, 1e-12, error))
        parts = ", ".join(f"{100 * e:+.2g} % at {p:g}" for e, p in zip(error, per_wave, strict=True))
        yield (
            f"The {name} area differs from the limit by {parts} points per shortest wave (mean over surfaces; fitted order {order:.2f})."
        )


def _criterion(resolved: xr.Dataset) -> Iterator[str]:
    """Say from which grid on counting is within 5 %, and how large patches are there."""
    per_wave = resolved.points_per_wave.values
    close = np.abs(overestimate(resolved, "pixel").mean("surface").values) < 0.05
    if close.any():
        first = int(np.argmax(close))
        cells = float(resolved.cells_per_patch[:, first].mean())
        yield (
            f"Counting is within 5 % of the limit from lambda_short/dx = {per_wave[first]:g} on; half of the contact area then lies in patches "
            f"of at least {cells:.0f} cells (Persson's criterion asks for 100 to 10000)."
        )


def _verdict(resolved: xr.Dataset, limit: float, theory: float) -> str:
    """Say how much of a counted kappa is the grid, and what remains to the theory without it."""
    pressure = float(resolved.attrs["reduced_pressure"])
    words = []
    for g in range(resolved.sizes["grid"]):
        counted = float(resolved.pixel[:, g].mean()) / pressure
        words.append(
            f"{100 * (counted - limit) / (counted - theory):.0f} % at {float(resolved.points_per_wave[g]):g}"
        )
    coarse = float(resolved.pixel[:, 0].mean()) / pressure
    half = mean_over_surfaces(resolved.limit.values / pressure).half_width
    told = ", which these surfaces do not tell from zero" if abs(limit - theory) <= half else ""
    return (
        f"Verdict: counted on {float(resolved.points_per_wave[0]):g} points per shortest wave kappa is {coarse:.2f}, of which {coarse - limit:+.2f} is "
        f"the grid; without it {limit:.2f}{_give(half)} remains, {limit - theory:+.2f} ({100 * (limit / theory - 1):+.0f}"
        f"{_give(100 * half / theory)} %) from the theory{told}. The grid's part of the distance between counted value and theory is "
        f"{', '.join(words)} points per wave."
    )


def _give(half_width: float) -> str:
    """Return +- and an uncertainty, nothing where one surface tells none."""
    return f" +- {half_width:.2g}" if np.isfinite(half_width) else ""


def _load_identity(resolved: xr.Dataset) -> str:
    """Say what the grid does to P(sigma) at fixed load: Persson 2006, Sec. 12."""
    first = float(np.abs(resolved.first_moment - 1).max())
    coarse, fine = (resolved.density.isel(grid=g).values for g in (0, -1))
    stress = resolved.stress.values
    # Above the last pressure at which the coarse grid has more, it must have less: the load is the same.
    small = stress < _SMALL
    excess = float((coarse - fine).sum())
    low = float((coarse - fine)[small].sum())
    change = float(coarse[~small].sum() / fine[~small].sum() - 1)
    zeroth = float((resolved.pixel[:, 0] / resolved.pixel[:, -1]).mean() - 1)
    return (
        f"The first moment of P(sigma) is p0 on every grid (to {first:.1g}); the zeroth, the area, is {100 * zeroth:+.1f} % on "
        f"{float(resolved.points_per_wave[0]):g} against {float(resolved.points_per_wave[-1]):g} points per wave. Of that excess {100 * low / excess:.0f} % lies at "
        f"sigma < {_SMALL:g} E* h'_rms, and above it the coarse grid holds {100 * change:+.1f} %: what is too much at small pressure is "
        "balanced by too little at large pressure."
    )


def _published(dataset: xr.Dataset, limit: Estimate) -> str:
    """Put the published values beside the converged one and beside what the grid can make of it."""
    last = dataset.kappa_grid_scale.isel(protocol_grid=-1).mean("surface").values
    words = []
    for published in (one for one in PUBLISHED if one.quantity == "kappa"):
        low, high = published.low, published.high
        if low == high:
            inside = last.min() <= low <= last.max()
            share, half = 100 * (low / limit.value - 1), 100 * limit.half_width / limit.value
            told = ", not told from it," if abs(share) <= half else ""
            words.append(
                f"{low:g} ({published.words}) lies {share:+.0f}{_give(half)} % from it{told} and {'inside' if inside else 'outside'} the "
                f"{last.min():.2f} to {last.max():.2f} that roughness at the grid scale gives by the definition of the slope"
            )
        else:
            words.append(f"{low:g} to {high:g} ({published.words}) {_against(limit, low, high)}")
    return f"Published kappa: {'; '.join(words)}."


def _against(limit: Estimate, low: float, high: float) -> str:
    """Say whether a converged value agrees with a published range, or is too uncertain to tell."""
    if limit.value + limit.half_width < low or limit.value - limit.half_width > high:
        return f"do not agree with the converged {limit}"
    # An interval that is wider than the range would meet it almost anywhere.
    if not limit.half_width <= (high - low) / 2:
        return f"can be neither confirmed nor ruled out by the converged {limit}: its interval is wider than that range"
    return f"agree with the converged {limit}"


def _element_sentence(dataset: xr.Dataset, e: int) -> str:
    """Say how finite elements count, corrected and in the limit."""
    counted = (dataset.fem_pixel[e] / dataset.limit - 1).mean("surface").values
    corrected = (dataset.fem_perimeter[e] / dataset.limit - 1).mean("surface").values
    apart = mean_over_surfaces((dataset.fem_limit[e] / dataset.limit - 1).values)
    points = dataset.fem_points_per_wave.values
    grids = [
        100 * grid_share(dataset.fem_limit[e].values, errors=dataset.fem_limit_error[e].values, drifts=[0.0]),
        100
        * grid_share(
            dataset.limit.values, errors=dataset.limit_error.values, drifts=dataset.limit_drift.values
        ),
    ]
    depth = 100 * float(dataset.depth_error)
    distance, half = 100 * apart.value, 100 * apart.half_width
    whole = combined(half, *grids, depth)
    told = "the two are not told apart"
    if abs(distance) > whole:
        # Both discretise one problem: a distance beyond all that is claimed is an error of the extrapolation.
        told = f"they are told apart, so that the grids of the element leave {combined(grids[0], distance):.2f} %, not {grids[0]:.2f} %"
    if apart.samples == 1:
        told = "one surface does not tell whether they differ"
    rows = ", ".join(
        f"{100 * a:+.2g} ({100 * b:+.2g}) % at {p:g}"
        for a, b, p in zip(counted, corrected, points, strict=True)
    )
    return (
        f"Finite elements {dataset.element.values[e]}, nodes counted (with the element's edge constant), differ from the limit of the boundary elements by {rows}; "
        f"their own limit differs by {distance:+.2f}{_give(whole)} % ({half:.2f} % the surfaces, {grids[0]:.2f} % their grids, {grids[1]:.2f} % those "
        f"of the boundary elements, {depth:.2f} % the depth of the block; 95 %): {told}."
    )


def _other_sentence(dataset: xr.Dataset, m: int) -> str:
    """Say how another method counts, where its limit is, and whether its residuals are what it was asked for."""
    name = str(dataset.other_method.values[m])
    own = dataset.isel(case=np.flatnonzero(dataset.other.values == name))
    counted = 100 * (own.other_pixel / dataset.limit - 1).mean("surface").values
    rows = ", ".join(
        f"{a:+.2g} % at {p:g}" for a, p in zip(counted, own.other_points_per_wave.values, strict=True)
    )
    apart = mean_over_surfaces((dataset.other_limit[m] / dataset.limit - 1).values)
    text = f"{name}, points counted, differs from the limit of the boundary elements by {rows} points per shortest wave"
    if np.isfinite(apart.value):
        half = f" +- {100 * apart.half_width:.2g}" if apart.samples > 1 else ""
        text += f"; its own limit differs by {100 * apart.value:+.2g}{half} %"
    missed = int((own.other_converged < 1).sum())
    if missed:
        text += (
            f"; {missed} of its {own.other_converged.size} answers do not have the residuals asked for, "
            f"the worst {float(own.other_residual.max()):.2g}"
        )
    return text + "."


def _protocol(dataset: xr.Dataset, limit: float, theory: float) -> str:
    """Say what roughness down to the grid scale does, by the definition of the slope."""
    last = dataset.kappa_grid_scale.isel(protocol_grid=-1)
    words = ", ".join(f"{float(last.sel(slope=name).mean()):.2f} ({name})" for name in dataset.slope.values)
    values = [float(last.sel(slope=name).mean()) for name in dataset.slope.values]
    spread = max(values) / min(values) - 1
    span = (
        " on both sides of"
        if min(values) < limit < max(values)
        else (" above" if min(values) > limit else " below")
    )
    return (
        f"With roughness down to the grid scale on {int(dataset.protocol_points[-1])} points and nodes counted, kappa is {words}, by how the slope is "
        f"measured: a spread of {100 * spread:.0f} %,{span} the converged {limit:.2f}; the theory's {theory:.2f} is "
        f"{'below all of them' if theory < min(values) else 'not below all of them'}."
    )
