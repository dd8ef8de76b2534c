"""How much of the contact has yielded, by boundary elements over grids and by Persson's theory?

Surfaces of several seeds against a solid of given hardness, on a ladder of grids; elastic and plastic area in
the limit over the grids beside the closed form for constant hardness with the gradient of the same surface.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fem_contact.hardness import yielded
from persson import elastic
from persson.hardness import constant_hardness
from validation.bench import Bench
from validation.effect_tables import HardnessEffect
from validation.errors import UsageError
from validation.jobs import Job
from validation.scene import Load, SelfAffineSurface, SolidSpec
from validation.surfaces import reference_field

if TYPE_CHECKING:
    import xarray as xr

    from validation.drawing import Drawing

__all__ = ["figures", "findings", "run"]

_SOLID = SolidSpec(young=1e9, poisson=0.3)
_PARTS = ("plastic", "elastic")


def run(
    *,
    bench: Bench | None = None,
    pressures: tuple[float, ...] = (0.01, 0.02, 0.05, 0.1, 0.2),
    hardness: float = 0.6,
    seeds: tuple[int, ...] = (11, 12),
    grids: tuple[int, ...] = (64, 128, 256),
    hurst: float = 0.8,
    periods: float = 4.0,
    bandwidth: float = 4.0,
) -> xr.Dataset:
    """Solve every seed at every load on every grid.

    Parameters
    ----------
    bench : Bench, optional
        Where the solves run and are stored; results/solves if not given.
    pressures : tuple of float
        p* = p0 / (E* h'_rms) with the realised gradient.
    hardness : float
        H / (E* h'_rms) with the gradient asked for.
    seeds, grids : tuple of int
        Realisations, and points along a side; at least two grids.
    hurst, periods, bandwidth : float
        H, L / lambda_long, lambda_long / lambda_short.

    Returns
    -------
    xarray.Dataset
        Over `pressure`: A_pl/A0 and A_el/A0 in the limit of the two finest grids, linear in dx, averaged over
        the seeds; by how much the finest grid differs from it; the theory.

    Raises
    ------
    UsageError
        For fewer than two grids.
    """
    import xarray as xr

    if len(set(grids)) < 2:
        raise UsageError(f"--grids = {grids}: at least two, for a limit")
    bench = bench or Bench.at()
    gradient, length = 0.1, 1e-4
    modulus = _SOLID.young / (1 - _SOLID.poisson**2)
    effect = HardnessEffect(kind="hardness", hardness=hardness * modulus * gradient)
    jobs = {}
    for seed in seeds:
        surface = SelfAffineSurface(
            kind="self-affine",
            length=(length, length),
            hurst=hurst,
            lambda_long=length / periods,
            lambda_short=length / periods / bandwidth,
            rms_gradient=gradient,
            seed=seed,
        )
        for load in pressures:
            for n in sorted(set(grids)):
                jobs[seed, load, n] = Job(
                    method="bem",
                    grid=(n, n),
                    surface=surface,
                    solid=_SOLID,
                    load=Load(reduced_pressure=load),
                    settings=(("tolerance", 1e-8),),
                    effects=(effect,),
                )
    solved = bench.solve(jobs.values())
    areas = np.zeros((len(pressures), len(seeds), 3, 2))
    for i, load in enumerate(pressures):
        for j, seed in enumerate(seeds):
            middle, fine = (yielded(solved[jobs[seed, load, n]].checked()) for n in sorted(set(grids))[-2:])
            (a, b), (c, d) = ((part.plastic_area, part.elastic_area) for part in (middle, fine))
            ratio = sorted(set(grids))[-2] / sorted(set(grids))[-1]
            areas[i, j, 0] = [(c - ratio * a) / (1 - ratio), (d - ratio * b) / (1 - ratio)]
            areas[i, j, 1] = [c, d]
            field = reference_field(jobs[seed, load, grids[0]].surface)
            unit = modulus * field.rms_gradient
            theory = constant_hardness(
                load * unit,
                stress_variance=elastic.stress_variance(field.moments[1], contact_modulus=modulus),
                yield_stress=effect.hardness,
            )
            areas[i, j, 2] = [float(theory.plastic), float(theory.elastic)]
    means = areas.mean(axis=1)
    columns = {}
    for k, part in enumerate(_PARTS):
        for m, (name, words) in enumerate(
            (("", "limit over grids"), ("_finest", "finest grid"), ("_persson", "Persson"))
        ):
            text = {"units": "1", "long_name": f"A_{part[:2]}/A0, {words}"}
            columns[f"{part}{name}"] = ("pressure", means[:, m, k], text)
    return xr.Dataset(
        columns,
        coords={
            "pressure": (
                "pressure",
                np.asarray(pressures),
                {"units": "1", "long_name": "p* = p0 / (E* h'_rms)"},
            )
        },
        attrs={"methods": "theory bem", "surfaces": len(seeds), "hardness": hardness},
    )


def findings(data: xr.Dataset) -> tuple[str, ...]:
    """Say how far the theory is from the limit at the lightest and heaviest load."""
    from validation.findings import percent

    sentences = []
    for k in sorted({0, data.sizes["pressure"] - 1}):
        point = data.isel(pressure=k)
        parts = []
        for part in _PARTS:
            found, theory = float(point[part]), float(point[f"{part}_persson"])
            where = "above" if theory > found else "below"
            away = "" if found <= 0 else f", {percent(abs(theory / found - 1))} {where} it"
            parts.append(f"A_{part[:2]}/A0 = {found:.4f} in the limit and {theory:.4f} by Persson{away}")
        sentences.append(
            f"At p* = {float(point['pressure']):.3g} and H = {data.attrs['hardness']:.3g} E* h'_rms: "
            f"{'; '.join(parts)}."
        )
    return tuple(sentences)


def figures(data: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw plastic and elastic area against load."""
    from validation import plots
    from validation.drawing import Drawing

    return tuple(
        Drawing(
            name=f"{part}-area",
            figure=plots.lines_figure(
                data, x="pressure", lines=(part, f"{part}_finest", f"{part}_persson"), logarithmic="x"
            ),
            data=data[[part, f"{part}_finest", f"{part}_persson"]],
            caption=f"Share of the nominal area in {part} contact against load: limit over the grids, finest "
            "grid, and Persson's theory with the gradient of the same surfaces.",
        )
        for part in _PARTS
    )
