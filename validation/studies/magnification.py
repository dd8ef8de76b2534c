"""How does the contact area fall as shorter and shorter waves are added to one surface?"""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import numpy as np

from persson import elastic
from validation.measures.common import (
    at_least,
    base_surface,
    measure,
    over_surfaces,
    persson_area,
    rising,
    solid_of,
)
from validation.measures.measurement import Measurement, area_limits, grid_for
from validation.measures.theory import modes_sentence
from validation.report.drawing import Drawing
from validation.report.table import ResultTable
from validation.scenes.surfaces import spectrum_of
from validation.solves.bench import Bench

if TYPE_CHECKING:
    import xarray as xr

    from validation.scenes.scene import Scene

__all__ = ["figures", "findings", "run", "table"]


def run(
    *,
    scene: Scene | None = None,
    bench: Bench | None = None,
    reduced_pressures: tuple[float, ...] = (0.05, 0.2),
    magnifications: tuple[float, ...] = (1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0),
    hurst: float = 0.8,
    size: float = 4.0,
    ratio: float = 16.0,
    surfaces: int = 4,
    points_per_wave: tuple[float, ...] = (3.0, 6.0),
    shifts: int = 2,
    seed: int = 2006,
) -> xr.Dataset:
    """Press every surface with its waves up to each magnification, always at the same nominal pressures.

    Parameters
    ----------
    scene : Scene, optional
        Gives the solid; nothing reported depends on it.
    bench : Bench, optional
        Where and how the cases run.
    reduced_pressures : tuple of float
        p* with the gradient of all waves, rising.
    magnifications : tuple of float
        zeta = q/q_long, rising.
    hurst, size, ratio : float
        H, L/lambda_long and lambda_long/lambda_short.
    surfaces : int
        Realisations.
    points_per_wave : tuple of float
        Grids, as the shortest wave of all over dx, rising.
    shifts : int
        Sub-grid shifts along each axis.
    seed : int
        Of the first surface.

    Returns
    -------
    xarray.Dataset
        area (limit over grids) with dimensions (surface, magnification, load), and the theory told the realised gradient
        of the waves that are there (conditional) or C(q) alone up to that magnification (ensemble).
    """
    import xarray as xr

    at_least("surfaces", surfaces, 2)
    magnifications, points_per_wave = (
        rising("magnifications", magnifications),
        rising("points_per_wave", points_per_wave),
    )
    surface = base_surface(hurst=hurst, size=size, ratio=ratio, seed=seed)
    grids = tuple(grid_for(surface, points) for points in points_per_wave)
    q_long = 2 * np.pi / surface.lambda_long
    cases = [
        Measurement(
            surface=surface,
            realisation=k,
            truncation=zeta * q_long,
            solid=solid_of(scene),
            reduced_pressures=reduced_pressures,
            grids=grids,
            shifts=shifts,
        )
        for k, zeta in itertools.product(range(surfaces), magnifications)
    ]
    measured = measure(bench, cases)
    shape = (surfaces, len(magnifications), len(reduced_pressures))
    limits = [area_limits(data) for data in measured]
    # p* of a truncated surface grows as its gradient shrinks, at the same nominal pressure.
    partial = np.array([case.field(grids[0]).rms_gradient for case in cases])
    whole = np.array([data.attrs["rms_gradient"] for data in measured])
    pressures = np.array(reduced_pressures) * (whole / partial)[:, None]
    spectrum = spectrum_of(surface)
    q_upper = np.tile(np.minimum(np.array(magnifications) * q_long, spectrum.q_short), surfaces)
    variance = elastic.stress_variance(spectrum.m2(q_upper), contact_modulus=1.0)
    return xr.Dataset(
        {
            "area": (("surface", "magnification", "load"), np.array([v for v, _ in limits]).reshape(shape)),
            "area_error": (
                ("surface", "magnification", "load"),
                np.array([e for _, e in limits]).reshape(shape),
            ),
            "theory": (("surface", "magnification", "load"), persson_area(pressures).reshape(shape)),
            "theory_ensemble": (
                ("surface", "magnification", "load"),
                elastic.contact_area(
                    np.array(reduced_pressures) * whole[:, None], stress_variance=variance[:, None]
                ).reshape(shape),
            ),
        },
        coords={
            "magnification": ("magnification", list(magnifications), {"long_name": "q / q_long"}),
            "reduced_pressure": ("load", list(reduced_pressures)),
        },
        attrs={"study": "magnification", "hurst": hurst, "size": size, "ratio": ratio},
    )


def table(dataset: xr.Dataset) -> ResultTable:
    """Return one row for each load and magnification."""
    rows = []
    for j, i in itertools.product(range(dataset.sizes["load"]), range(dataset.sizes["magnification"])):
        area = over_surfaces(dataset.area[:, i, j])
        theory = float(dataset.theory[:, i, j].mean())
        rows.append(
            (
                float(dataset.reduced_pressure[j]),
                float(dataset.magnification[i]),
                area.value,
                area.half_width,
                theory,
                float(dataset.theory_ensemble[:, i, j].mean()),
                area.value / theory,
            )
        )
    return ResultTable.of(
        (
            "p* (all waves)",
            "zeta",
            "A/A0 limit",
            "+- (95 %)",
            "A/A0 Persson, conditional",
            "A/A0 Persson, ensemble",
            "ratio to the first",
        ),
        rows,
    )


def findings(dataset: xr.Dataset) -> tuple[str, ...]:
    """Return how the distance to the theory builds up with magnification."""
    sentences = []
    for j, pressure in enumerate(dataset.reduced_pressure.values):
        area = dataset.area[:, :, j].mean("surface").values
        ratio = (dataset.area / dataset.theory)[:, :, j].mean("surface").values
        zeta = dataset.magnification.values
        if not np.all(np.isfinite(area)):
            sentences.append(
                f"At p* = {pressure:g} (all waves) how the area changes is not determinable: contacts are too small "
                "for a limit."
            )
            continue
        falls = bool(np.all(np.diff(area) < 0))
        sentences.append(
            f"At p* = {pressure:g} (all waves) the area {'falls with every wave added' if falls else 'does not fall at every step'}, from {area[0]:.3f} "
            f"at zeta = {zeta[0]:g} to {area[-1]:.4f} at {zeta[-1]:g}; over the theory it is {ratio[0]:.3f} there and {ratio[-1]:.3f} here."
        )
    # Up to zeta = 1 the integral over C(q) holds no wave, where the period holds its longest.
    rough = dataset.isel(magnification=np.flatnonzero(dataset.magnification.values >= _ROUGH))
    if rough.sizes["magnification"]:
        sentences.append(f"From zeta = {_ROUGH:g} on: {modes_sentence(rough.theory, rough.theory_ensemble)}")
    return tuple(sentences)


#: Magnification from which on the sum over waves and the integral over C(q) can be compared.
_ROUGH = 2.0


def figures(dataset: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw area against magnification, simulation and theory."""
    from validation.studies import _plots_studies as plots_studies

    return (
        Drawing(
            name="area-against-magnification",
            figure=plots_studies.area_against_magnification(dataset),
            data=dataset[["area", "theory", "theory_ensemble"]],
            caption="Contact area of one nominal pressure as shorter waves are added, simulation (limit over grids) and theory with the gradient of the waves that are there (thin, dashed: from C(q) alone).",
        ),
    )
