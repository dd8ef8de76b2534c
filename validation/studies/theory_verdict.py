"""How good is Persson's theory, quantity by quantity and range by range, and are its variants better?"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from persson import elastic
from persson.variants import Variant, corrected_contact_area
from validation.bench import Bench
from validation.drawing import Drawing
from validation.statistics import mean_over_surfaces
from validation.studies import pressure as pressure_study
from validation.studies._common import ResultTable

if TYPE_CHECKING:
    import xarray as xr

    from validation.scene import Scene

__all__ = ["figures", "findings", "run", "table"]

_VARIANTS: tuple[Variant, ...] = ("persson", "yang_persson", "wang_mueser", "xu")
_RANGES = ((0.0, 0.03), (0.03, 0.1), (0.1, 0.3), (0.3, 0.7), (0.7, 0.99), (0.99, 1.001))


def run(
    *,
    scene: Scene | None = None,
    bench: Bench | None = None,
    reduced_pressures: tuple[float, ...] = (0.003, 0.01, 0.02, 0.05, 0.1, 0.2, 0.4, 0.8, 1.6, 3.2),
    hurst: float = 0.8,
    size: float = 4.0,
    ratio: float = 8.0,
    surfaces: int = 6,
    points_per_wave: tuple[float, ...] = (4.0, 8.0),
    shifts: int = 2,
    seed: int = 2006,
) -> xr.Dataset:
    """Score the theory and its variants on the loads of the study `pressure`, whose cases it shares.

    Parameters
    ----------
    scene : Scene, optional
        Gives the solid; nothing reported depends on it.
    bench : Bench, optional
        Where and how the cases run.
    reduced_pressures : tuple of float
        p*, rising.
    hurst, size, ratio : float
        H, L/lambda_long and lambda_long/lambda_short.
    surfaces : int
        Realisations.
    points_per_wave : tuple of float
        Grids, as lambda_short/dx, rising.
    shifts : int
        Sub-grid shifts along each axis.
    seed : int
        Of the first surface.

    Returns
    -------
    xarray.Dataset
        area_ratio (variant, load): simulated over predicted area, with its 95 % interval; energy_ratio (load): simulated over
        predicted elastic energy, where the original theory has the area times the energy of full contact.
    """
    import xarray as xr

    data = pressure_study.run(
        scene=scene,
        bench=bench,
        reduced_pressures=reduced_pressures,
        hurst=hurst,
        size=size,
        ratio=ratio,
        surfaces=surfaces,
        points_per_wave=points_per_wave,
        shifts=shifts,
        seed=seed,
    )
    loads = data.reduced_pressure.values
    variance = elastic.stress_variance(1.0, contact_modulus=1.0)
    predicted = np.array(
        [corrected_contact_area(loads, stress_variance=variance, variant=variant) for variant in _VARIANTS]
    )
    simulated = [mean_over_surfaces(data.area[:, j].values) for j in range(loads.size)]
    grid = np.sqrt((data.area_error.values**2).mean(axis=0) / data.sizes["surface"])
    # At full contact no surface differs from another: what is left is rounding, and it is no uncertainty of zero.
    half = np.maximum([np.hypot(s.half_width, 2 * g) for s, g in zip(simulated, grid, strict=True)], 1e-9)
    value = np.array([s.value for s in simulated])
    energy = data.energy.mean("surface").values
    return xr.Dataset(
        {
            "area_ratio": (
                ("variant", "load"),
                value / predicted,
                {"long_name": "simulated over predicted area"},
            ),
            "interval": (
                ("variant", "load"),
                half / predicted,
                {"long_name": "95 % half width of that ratio"},
            ),
            "area": ("load", value, {"long_name": "A/A0, limit over grids"}),
            "energy_ratio": (
                "load",
                energy / predicted[0],
                {"long_name": "simulated over predicted elastic energy (Eq. 43)"},
            ),
        },
        coords={
            "variant": ("variant", list(_VARIANTS)),
            "reduced_pressure": ("load", loads, {"long_name": "p0 / (E* h'_rms)"}),
        },
        attrs={"study": "theory-verdict", "hurst": hurst, "size": size, "ratio": ratio, "surfaces": surfaces},
    )


def verdict(ratio: float, interval: float) -> str:
    """Return a word for a simulated over a predicted value with its 95 % half width.

    Examples
    --------
    >>> verdict(1.0, 1e-9), verdict(1.02, 0.03), verdict(1.36, 0.03), verdict(0.9, 0.3)
    ('exact', 'right within 5.0 %', 'off by +36 %', 'not determinable')
    """
    if interval < 1e-6 and abs(ratio - 1) < 1e-4:
        return "exact"
    if abs(ratio - 1) <= interval:
        return (
            f"right within {100 * (abs(ratio - 1) + interval):.1f} %"
            if interval < 0.1
            else "not determinable"
        )
    return f"off by {100 * (ratio - 1):+.2g} %"


def table(dataset: xr.Dataset) -> ResultTable:
    """Return one row for each range of contact area: the verdict on every variant, worst load of the range."""
    rows: list[tuple[float | str, ...]] = []
    for low, high in _RANGES:
        inside = np.flatnonzero((dataset.area.values >= low) & (dataset.area.values < high))
        if not inside.size:
            continue
        cells = []
        for i in range(dataset.sizes["variant"]):
            worst = inside[int(np.argmax(np.abs(dataset.area_ratio[i].values[inside] - 1)))]
            cells.append(verdict(float(dataset.area_ratio[i, worst]), float(dataset.interval[i, worst])))
        energy = dataset.energy_ratio.values[inside]
        rows.append((f"{low:g} to {min(high, 1.0):g}", *cells, f"{energy.min():.2f} to {energy.max():.2f}"))
    columns = ("A/A0", *(f"area: {name}" for name in _VARIANTS), "energy over Eq. 43")
    return ResultTable.of(columns, rows)


def findings(dataset: xr.Dataset) -> tuple[str, ...]:
    """Return the verdicts in sentences."""
    sentences = []
    for i, name in enumerate(_VARIANTS):
        ratio = dataset.area_ratio[i].values
        worst = int(np.argmax(np.abs(ratio - 1)))
        sentences.append(
            f"{name}: simulated over predicted area is {ratio[0]:.3f} at the lightest load (p* = {dataset.reduced_pressure.values[0]:g}) and "
            f"{ratio[-1]:.3f} at the heaviest; worst {verdict(float(ratio[worst]), float(dataset.interval[i, worst]))} at "
            f"A/A0 = {dataset.area.values[worst]:.3g}."
        )
    mean = np.abs(dataset.area_ratio - 1).mean("load").values
    best = _VARIANTS[int(np.argmin(mean))]
    sentences.append(
        f"On average over these loads '{best}' is closest, {100 * mean.min():.2g} % off; the original theory is "
        f"{100 * mean[0]:.2g} % off. All are scored conditional on the realised gradient, on one bandwidth and H."
    )
    return tuple(sentences)


def figures(dataset: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw simulated over predicted area against the area."""
    from validation import plots_studies

    return (
        Drawing(
            name="theory-verdict",
            figure=plots_studies.theory_verdict(dataset),
            data=dataset[["area_ratio", "interval"]],
            caption="Simulated contact area (limit over grids) over the prediction of the theory and its variants, with 95 % intervals; 1 is agreement.",
        ),
    )
