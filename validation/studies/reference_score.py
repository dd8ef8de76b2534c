"""How far is a theory, or somebody's numbers, from the computed areas of the reference table, cell by cell?"""

import csv
from pathlib import Path
from typing import Literal

import numpy as np
import xarray as xr

from validation import reference
from validation.arrays import Array
from validation.errors import UsageError
from validation.files import reason
from validation.measurements.theory import Waves
from validation.reference.theory import lowest_wave, table_spectrum
from validation.report.estimates import derive, total_error
from validation.report.views import Figure, Findings, Image, Table, Views, against, finding, panels_along
from validation.studies._options import StudyOptions
from validation.studies._study import Bench
from validation.theories import Rough, Theory, find_theory

#: E* [Pa], and smallest wavevector [1/m] and rms slope of the surfaces: no dimensionless area depends on them.
_MODULUS, _Q_LONG, _SLOPE = 1e9, 2 * np.pi / 1e-4, 0.1
_CELL = ("hurst", "bandwidth", "reduced_pressure")


class Options(StudyOptions):
    """What is scored."""

    theory: tuple[str, ...] = ("persson", "yang-persson", "wang-mueser", "xu")
    """theories by name, or your own, my_module:area; none to score numbers alone"""
    rolloff: Literal["sharp", "plateau"] = "sharp"
    """C(q) of waves longer than lambda_long: none, or constant up to the period"""
    csv: Path | None = None
    """areas of your own, a table with the columns hurst, bandwidth, reduced_pressure, area, and area_error
    (95 %) if you have it; cells without a row are left out"""


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Put theories, told C(q), and areas of a file beside the table of exact amplitudes; nothing is solved.

    Over (theory, hurst, bandwidth, reduced_pressure): the table's ``area``, ``area_scored``, their relative
    distance ``theory_excess`` and ``z_score``, the distance over the standard error of the table.
    """
    data = reference.table(options.rolloff).sel(amplitudes="exact", drop=True)[["area", "area_error"]]
    theories = [find_theory(name) for name in options.theory]
    scored = {theory.label: (_areas(theory, data), np.zeros(data.area.shape)) for theory in theories}
    if options.csv is not None:
        scored[options.csv.name] = _read(options.csv, data)
    if not scored:
        raise UsageError("study reference-score: nothing to score; name a theory or a csv")
    if silent := [label for label, (areas, _) in scored.items() if not np.isfinite(areas).any()]:
        raise UsageError(f"study reference-score: {silent[0]} says nothing on any cell of the table")
    (areas, halves), over = map(np.array, zip(*scored.values(), strict=True)), ("theory", *_CELL)
    data["area_scored"] = over, areas, {"reduction": "theory"}
    data = data.assign_coords(theory=[*scored]).transpose("theory", *_CELL, "source")
    table_error = total_error(data, "area")
    assert table_error is not None  # the shipped table has it
    both = (table_error**2 + xr.DataArray(halves, dims=over) ** 2) ** 0.5
    z_score = (data.area_scored - data.area) / (both / 1.96)
    data = derive(data, theory_excess="area_scored / area - 1")
    return data.assign(z_score=z_score.transpose(*over))


def views(data: xr.Dataset) -> Views:
    """Show where each theory is above and below the table, and its worst cell."""
    figures = []
    for k, label in enumerate(map(str, data.theory.values)):
        image = Image("theory_excess", rows="bandwidth", cmap="RdBu_r", symmetric=True)
        panel = against("reduced_pressure", image, log="xy", at={"theory": k})
        known = data.theory_excess.isel(theory=k).notnull().any(("bandwidth", "reduced_pressure")).values
        panels = [row for row in panels_along(data, "hurst", panel) if known[row.at["hurst"]]]
        caption = f"Area of {label} over that of the table, less one. The colours end at the worst cell."
        figures.append(Figure(f"excess-{k}", caption, panels))
    table = Table(("theory", *_CELL), ("theory", *_CELL, "area", "area_scored", "theory_excess", "z_score"))
    return Views(table=table, budget=("area",), figures=figures, findings=[*_findings(data)])


def _findings(data: xr.Dataset) -> Findings:
    worst = data.isel(abs(data.theory_excess).fillna(-1.0).argmax(_CELL))
    form = "Farthest from the table: {each}."
    item = "{theory} lies {verdict} it, by {theory_excess:+%}, at H = {hurst}, bandwidth {bandwidth}, p* = {reduced_pressure}"
    yield finding("comparison", form, worst, item=item, by="theory_excess")
    counted = data.assign(
        cells_within=(abs(data.z_score) <= 1.96).sum(_CELL).astype(float),
        cells_scored=data.z_score.count(_CELL).astype(float),
        theory_excess_median=abs(data.theory_excess).median(_CELL),
    )
    yield finding(
        "share",
        "Within the 95 % interval of the table lie {each}.",
        counted[["cells_within", "cells_scored", "theory_excess_median"]],
        item="{cells_within} of {cells_scored} cells of {theory}, {theory_excess_median:%} away in the median",
    )


def _areas(theory: Theory, data: xr.Dataset) -> Array:
    areas, lowest = np.full(data.area.shape, np.nan), lowest_wave(**data.attrs)
    for i, hurst in enumerate(data.hurst.values):
        for j, bandwidth in enumerate(data.bandwidth.values):
            cell = {"hurst": float(hurst), "bandwidth": float(bandwidth), "lowest": lowest}
            spectrum = table_spectrum(**cell, rms_gradient=_SLOPE, q_long=_Q_LONG)
            moments, waves = spectrum.moments(), Waves.of_spectrum(spectrum)
            rough = Rough(contact_modulus=_MODULUS, moments=moments, spectrum=spectrum, waves=waves)
            areas[i, j] = theory.area(data.reduced_pressure.values * _MODULUS * moments.rms_gradient, rough)
    return areas


def _read(path: Path, data: xr.Dataset) -> tuple[Array, Array]:
    try:
        with path.open(newline="", encoding="utf-8") as file:
            # As the shipped tables are: with what they are in lines of comments.
            lines = [(number, line) for number, line in enumerate(file, 1) if line.strip() and line[0] != "#"]
            reader = csv.DictReader(line for _, line in lines)
            rows, columns = list(reader), reader.fieldnames or []
    except OSError as error:
        raise UsageError(f"--csv {path}: cannot be read: {reason(error)}") from None
    except (ValueError, csv.Error) as error:
        raise UsageError(f"--csv {path}: {error}") from None
    if missing := [name for name in (*_CELL, "area") if name not in columns]:
        raise UsageError(
            f"--csv {path}: no column {', '.join(missing)}; it has {', '.join(columns) or 'none'}"
        )
    areas, errors = (np.full(data.area.shape, np.nan) for _ in range(2))
    for (number, _), row in zip(lines[1:], rows, strict=False):
        if row.get("amplitudes", "exact") != "exact":
            continue
        try:
            values = [float(row[name]) for name in (*_CELL, "area")]
            half = float(row.get("area_error") or 0.0)
        except (TypeError, ValueError):
            raise UsageError(f"--csv {path}: line {number}: holds what is no number") from None
        near = [np.isclose(data[name], at, rtol=1e-6) for name, at in zip(_CELL, values, strict=False)]
        if not all(map(np.any, near)):
            known = "; ".join(f"{name}: {', '.join(f'{v:g}' for v in data[name].values)}" for name in _CELL)
            raise UsageError(f"--csv {path}: line {number}: no cell of the table, which has {known}")
        if not 0 <= values[3] <= 1 or not half >= 0:
            raise UsageError(f"--csv {path}: line {number}: area = {values[3]:g}: must lie in [0, 1]")
        areas[np.ix_(*near)], errors[np.ix_(*near)] = values[3], half
    return areas, errors
