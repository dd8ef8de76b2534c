"""How does the contact area grow with load, when the whole field of every solve is kept?

Boundary elements on surfaces of several seeds, from light load upwards, each surface and load on a ladder of grids; the
limit over the grids beside Persson's theory with the gradient of the same surface. Its jobs are those of scenes, so that
the two share stored solves. It is the smallest study, and the one to copy for a new one; `pressure` answers the question
in depth, from numbers alone.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from fem_contact.area import contact_areas
from fem_contact.extrapolation import located_limit
from persson import elastic
from validation.errors import UsageError
from validation.measures.common import LEAST_POINTS_PER_WAVE, at_least
from validation.measures.statistics import combined
from validation.scenes.scene import Load, SelfAffineSurface, SolidSpec
from validation.scenes.surfaces import reference_field
from validation.solves.bench import Bench
from validation.solves.solve import Job

if TYPE_CHECKING:
    import xarray as xr

    from validation.report.drawing import Drawing

__all__ = ["figures", "findings", "jobs", "run"]

_SOLID = SolidSpec(young=1e9, poisson=0.3)


def jobs(
    *,
    pressures: tuple[float, ...],
    seeds: tuple[int, ...],
    grids: tuple[int, ...],
    hurst: float,
    periods: float,
    bandwidth: float,
) -> tuple[Job, ...]:
    """List the solves: every seed at every load on every grid."""
    length = 1e-4
    found = []
    for seed in seeds:
        surface = SelfAffineSurface(
            kind="self-affine",
            length=(length, length),
            hurst=hurst,
            lambda_long=length / periods,
            lambda_short=length / periods / bandwidth,
            rms_gradient=0.1,
            seed=seed,
        )
        for pressure in pressures:
            load = Load(reduced_pressure=pressure)
            found += [Job(method="bem", grid=(n, n), surface=surface, solid=_SOLID, load=load) for n in grids]
    return tuple(found)


def run(
    *,
    bench: Bench | None = None,
    pressures: tuple[float, ...] = (0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0),
    seeds: tuple[int, ...] = (11, 12, 13, 14),
    grids: tuple[int, ...] = (64, 96, 128),
    hurst: float = 0.8,
    periods: float = 2.0,
    bandwidth: float = 4.0,
) -> xr.Dataset:
    """Solve every seed at every load on every grid, and take the limit over the grids.

    Parameters
    ----------
    bench : Bench, optional
        Where the solves run and are stored; results/solves if not given.
    pressures : tuple of float
        p* = p0 / (E* h'_rms) with the realised gradient.
    seeds : tuple of int
        At least two: the standard error is that over surfaces.
    grids : tuple of int
        Points along a side; at least two with 3 points per shortest wave or more. Coarser ones are run, labelled,
        and left out of the limit.
    hurst : float
    periods : float
        L / lambda_long.
    bandwidth : float
        lambda_long / lambda_short.

    Returns
    -------
    xarray.Dataset
        Over `pressure`: mean limit of A/A0 over the seeds, its standard error (surfaces and grids), the
        uncertainty of a single limit, kappa, and Persson's A/A0; NaN where a contact is too small for a limit.

    Raises
    ------
    UsageError
        For grids or seeds that give no limit or no standard error.
    """
    import xarray as xr

    at_least("number of seeds", len(set(seeds)), 2)
    resolved = _resolved(grids, waves=periods * bandwidth)
    bench = bench or Bench.at()
    wanted = jobs(
        pressures=pressures, seeds=seeds, grids=grids, hurst=hurst, periods=periods, bandwidth=bandwidth
    )
    solved = bench.solve(wanted)
    area = np.zeros((len(pressures), len(seeds)))
    error, theory = np.zeros_like(area), np.zeros_like(area)
    for j, seed in enumerate(seeds):
        for i, pressure in enumerate(pressures):
            own = [
                job
                for job in wanted
                if job.surface.kind == "self-affine"
                and job.surface.seed == seed
                and job.load.reduced_pressure == pressure
                and job.grid[0] in resolved
            ]
            results = [solved[job] for job in own]
            limit = located_limit([contact_areas(r, subcell=True) for r in results])
            area[i, j], error[i, j] = limit.value, limit.uncertainty
            modulus = results[0].contact_modulus
            moment = reference_field(own[0].surface).moments[1]
            variance = elastic.stress_variance(moment, contact_modulus=modulus)
            theory[i, j] = elastic.contact_area(
                pressure * modulus * np.sqrt(moment), stress_variance=variance
            )
    mean, spread = area.mean(axis=1), area.std(axis=1, ddof=1) / np.sqrt(len(seeds))
    grid_error = np.sqrt(np.mean(error**2, axis=1))
    # Grids are off to the same side on all surfaces of a spectrum: their error does not average out.
    both = np.array([combined(*pair) for pair in zip(spread, grid_error, strict=True)])
    loads = np.asarray(pressures)
    columns = {
        "area": (mean, "A/A0, limit over grids"),
        "area_error": (both, "standard error: surfaces and grids"),
        "scatter_error": (spread, "standard error over surfaces alone"),
        "grid_error": (grid_error, "uncertainty of one limit, root mean square"),
        "kappa": (mean / loads, "kappa = (A/A0) / p*"),
        "kappa_error": (both / loads, "standard error: surfaces and grids"),
        "persson": (theory.mean(axis=1), "A/A0, Persson with the realised gradient"),
    }
    return xr.Dataset(
        {
            name: ("pressure", values, {"units": "1", "long_name": words})
            for name, (values, words) in columns.items()
        },
        coords={"pressure": ("pressure", loads, {"units": "1", "long_name": "p* = p0 / (E* h'_rms)"})},
        attrs={
            "methods": "theory bem perimeter",
            "surfaces": len(seeds),
            "grids": _names(resolved),
            "left_out": _names(n for n in grids if n not in resolved),
        },
    )


def _names(grids: Iterable[int]) -> str:
    return ", ".join(f"{n} x {n}" for n in grids)


def _resolved(grids: Sequence[int], *, waves: float) -> tuple[int, ...]:
    """Return the grids of at least 3 points per shortest wave, of which there are `waves` along a side."""
    found = tuple(dict.fromkeys(n for n in grids if n / waves >= LEAST_POINTS_PER_WAVE * (1 - 1e-9)))
    if len(found) < 2:
        raise UsageError(
            f"grids = {', '.join(map(str, grids))}: a limit needs two grids of at least {LEAST_POINTS_PER_WAVE:g} points per "
            f"shortest wave; here that is {int(np.ceil(LEAST_POINTS_PER_WAVE * waves - 1e-9))} or more along a side"
        )
    return found


def findings(data: xr.Dataset) -> tuple[str, ...]:
    """Say how kappa and the distance to the theory change from the lightest to the heaviest load."""
    from validation.comparison.findings import percent
    from validation.report.words import with_error

    loads, kappa, error = (data[name].values for name in ("pressure", "kappa", "kappa_error"))
    share, persson = data["grid_error"].values / data["area"].values, data["persson"].values
    sentences = []
    for k in sorted({0, len(loads) // 2, len(loads) - 1}):
        if not np.isfinite(kappa[k]):
            sentences.append(
                f"At p* = {loads[k]:.3g} kappa is not determinable: a contact has too few points on the finest grid."
            )
            continue
        distance = float(data["area"].values[k] / persson[k] - 1)
        sentences.append(
            f"At p* = {loads[k]:.3g} kappa = {with_error(float(kappa[k]), float(error[k]))} (standard error over "
            f"{data.attrs['surfaces']} surfaces and of the grids, which alone is {percent(float(share[k]))}); the area "
            f"lies {percent(abs(distance))} {'above' if distance > 0 else 'below'} Persson's theory."
        )
    left_out = data.attrs.get("left_out", "")
    if left_out:
        sentences.append(
            f"Under-resolved (fewer than {LEAST_POINTS_PER_WAVE:g} points per shortest wave), run and left out of every "
            f"limit: {left_out}."
        )
    return tuple(sentences)


def figures(data: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw area and kappa against load."""
    from validation.report.drawing import Drawing
    from validation.report.figure import lines_figure

    with_theory = data.assign(
        persson_kappa=data["persson"] / data["pressure"],
    )
    with_theory["persson_kappa"].attrs = {
        "units": "1",
        "long_name": "kappa, Persson with the realised gradient",
    }
    return (
        Drawing(
            name="area",
            figure=lines_figure(data, x="pressure", lines=("area", "persson"), logarithmic="xy"),
            data=data[["area", "area_error", "scatter_error", "grid_error", "persson"]],
            caption="Contact area against load: limit over the grids, mean and standard error (surfaces and "
            "grids), beside Persson's theory for the same surfaces.",
        ),
        Drawing(
            name="kappa",
            figure=lines_figure(with_theory, x="pressure", lines=("kappa", "persson_kappa"), logarithmic="x"),
            data=with_theory[["kappa", "kappa_error", "persson_kappa"]],
            caption="Area over load, kappa: constant where contact grows in proportion to load.",
        ),
    )
