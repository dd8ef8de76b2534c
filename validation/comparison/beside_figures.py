"""Figures of results side by side, from the numbers that their folders hold."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from validation.comparison.beside import Beside, Result, Row
from validation.comparison.plots import spacings_as_fractions
from validation.report.drawing import Drawing
from validation.report.figure import COLOURS, STYLES, SYMBOLS, new_figure
from validation.report.words import mathtext

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["drawings"]

#: Panels of one figure.
_PANELS = 3


def drawings(found: Beside) -> tuple[Drawing, ...]:
    """Draw the one figure with all results."""
    if found.results[0].kind == "run":
        return (_of_runs(found),)
    return _of_tables(found)


def _of_runs(found: Beside) -> Drawing:
    """Draw area against grid spacing, and P(sigma) on the finest grid where the folders have it."""
    import xarray as xr

    curves = {result.label: _distribution(result) for result in found.results}
    drawn = {label: data for label, data in curves.items() if data is not None}
    figure, panels = new_figure(width=5.0 * (1 + bool(drawn)), height=4.2, columns=1 + bool(drawn))
    _areas(panels[0], found)
    if drawn:
        _distributions(panels[1], drawn, labels=found.labels)
    missing = [label for label, data in curves.items() if data is None]
    said = (
        "; right: distribution of pressure on the finest grid, thin lines: Persson's theory" if drawn else ""
    )
    if missing:
        said += f"; no distribution was drawn for {', '.join(missing)}: fem-contact report DIR does"
    return Drawing(
        name="beside",
        figure=figure,
        data=xr.merge([_area_data(found), _distribution_data(drawn)]),
        caption="Left: contact area of each result against its grid spacing; symbols: contact points "
        "counted; line and band: limit over the grids with its standard error; dotted: Persson's theory"
        f"{said}.",
    )


def _method_rows(result: Result) -> list[dict[str, Any]]:
    """Rows of the method that gives the limit, coarse to fine."""
    rows: list[dict[str, Any]] = result.summary["rows"]
    return [row for row in rows if row["method"] == rows[0]["method"]]


def _areas(axes: Axes, found: Beside) -> None:
    for k, result in enumerate(found.results):
        colour, rows = COLOURS[k % len(COLOURS)], _method_rows(result)
        errors = [row["pixel_scatter"] or 0.0 for row in rows]
        axes.errorbar(
            [1 / row["points_per_wave"] for row in rows],
            [row["pixel"] for row in rows],
            yerr=errors,
            color=colour,
            marker=SYMBOLS[k % len(SYMBOLS)],
            ls="--",
            capsize=2,
            label=result.label,
        )
        limit, theory = result.summary["limit"], result.summary["theory"]
        if limit is not None:
            low, high = (limit["value"] + sign * limit["uncertainty"] for sign in (-1, 1))
            axes.axhspan(low, high, color=colour, alpha=0.2, lw=0)
            axes.axhline(limit["value"], color=colour, lw=1)
        if theory is not None and theory["area"] is not None:
            axes.axhline(theory["area"], color=colour, lw=1, ls=":")
    axes.set_xscale("log", base=2)
    spacings_as_fractions(
        axes, [1 / row["points_per_wave"] for result in found.results for row in _method_rows(result)]
    )
    axes.set_xlabel(r"grid spacing over shortest wavelength, $\Delta x/\lambda_{short}$")
    axes.set_ylabel(r"relative contact area $A/A_0$")
    axes.legend(fontsize=7)


def _distribution(result: Result) -> xr.Dataset | None:
    """Read P(sigma) on the finest grid, and the theory's; None where no figure was drawn."""
    import xarray as xr

    path = result.folder / "figures" / "pressure-distribution.nc"
    if not path.exists():
        return None
    with xr.open_dataset(path, engine="netcdf4") as stored:
        data = stored.load()
    first = _method_rows(result)[0]["method"].upper()
    names = [name for name in dict.fromkeys(data["curve"].values.tolist()) if name != "Persson"]
    finest = [name for name in names if name.upper().startswith(first)][-1:] or names[-1:]
    kept = np.isin(data["curve"].values, [*finest, "Persson"])
    return data.isel(bin=np.flatnonzero(kept))


def _distributions(axes: Axes, drawn: dict[str, xr.Dataset], *, labels: tuple[str, ...]) -> None:
    for label, data in drawn.items():
        k = labels.index(label)
        colour = COLOURS[k % len(COLOURS)]
        theory = data["curve"].values == "Persson"
        here, exact = data.isel(bin=~theory), data.isel(bin=theory)
        edges = np.append(here["lower"].values, here["upper"].values[-1])
        axes.stairs(here["density"].values, edges, color=colour, ls=STYLES[k % 4], label=label, baseline=None)
        if exact.sizes["bin"]:
            axes.plot(exact["lower"], exact["density"], color=colour, lw=0.7)
    axes.set_ylim(bottom=0)
    axes.set_xlabel(r"pressure $\sigma / (E^* h'_{rms})$")
    axes.set_ylabel(r"$P(\sigma)\, E^* h'_{rms}$ per nominal area")
    axes.legend(fontsize=7)


def _area_data(found: Beside) -> xr.Dataset:
    rows = [(result.label, row) for result in found.results for row in _method_rows(result)]
    return _columns(
        "row",
        {
            "result": ([label for label, _ in rows], "result"),
            "spacing": ([1 / row["points_per_wave"] for _, row in rows], "dx / lambda_short"),
            "pixel": ([row["pixel"] for _, row in rows], "A/A0, contact points counted"),
            "pixel_error": (
                [np.nan if row["pixel_scatter"] is None else row["pixel_scatter"] for _, row in rows],
                "standard error over shifts",
            ),
            "perimeter": ([row["perimeter"] for _, row in rows], "A/A0, perimeter-corrected"),
        },
    )


def _distribution_data(drawn: dict[str, xr.Dataset]) -> xr.Dataset:
    """Return the curves of all results one after the other, named by result and curve."""
    parts = [
        (f"{label}: {curve}", lower, upper, density)
        for label, data in drawn.items()
        for curve, lower, upper, density in zip(
            *(data[name].values.tolist() for name in ("curve", "lower", "upper", "density")), strict=True
        )
    ]
    columns: list[Any] = list(zip(*parts, strict=True)) if parts else [[], [], [], []]
    words = (
        "result, then solver and grid or theory",
        "lower edge of the bin, sigma / (E* h'_rms)",
        "upper edge of the bin, sigma / (E* h'_rms)",
        "P(sigma) E* h'_rms per nominal area",
    )
    names = ("curve", "lower", "upper", "density")
    return _columns("bin", dict(zip(names, zip(columns, words, strict=True), strict=True)))


def _columns(dimension: str, columns: dict[str, tuple[Any, str]]) -> xr.Dataset:
    import xarray as xr

    return xr.Dataset(
        {
            name: (dimension, np.asarray(values), {"units": "1", "long_name": words})
            for name, (values, words) in columns.items()
        }
    )


def _of_tables(found: Beside) -> tuple[Drawing, ...]:
    """Draw the first quantities, those with an uncertainty first, against the key that varies most."""
    names = list(dict.fromkeys(row.quantity for row in found.rows))[:_PANELS]
    axis = max(range(len(found.keys)), key=lambda n: len({row.where[n] for row in found.rows}), default=None)
    if axis is None:
        return ()
    here, fixed = _along(found, axis)
    figure, panels = new_figure(width=4.6 * len(names), height=4.0, columns=len(names))
    for axes, name in zip(panels, names, strict=True):
        _panel(axes, [row for row in here if row.quantity == name], found, axis=axis, name=name)
    kept = [row for row in here if row.quantity in names]
    data = _columns(
        "row",
        {
            "key": ([row.where[axis] for row in kept for _ in found.labels], found.keys[axis]),
            "quantity": ([row.quantity for row in kept for _ in found.labels], "what it is, with its unit"),
            "result": ([label for _ in kept for label in found.labels], "result"),
            "value": ([number.value for row in kept for number in row.numbers], "in that unit"),
            "error": ([number.error for row in kept for number in row.numbers], "its uncertainty"),
        },
    )
    caption = (
        f"{', '.join(names)} of each result, with the uncertainty of its table, against "
        f"{found.keys[axis]}{fixed}."
    )
    return (Drawing(name="beside", figure=figure, data=data, caption=caption),)


def _along(found: Beside, axis: int) -> tuple[list[Row], str]:
    """Return the rows along one key, the others at their middle value, and say which."""
    rows, said = list(found.rows), []
    for n, key in enumerate(found.keys):
        values = list(dict.fromkeys(row.where[n] for row in rows))
        if n != axis and len(values) > 1:
            middle = values[len(values) // 2]
            rows = [row for row in rows if row.where[n] == middle]
            said.append(f"{key} = {middle}")
    return rows, f" (at {', '.join(said)})" if said else ""


def _panel(axes: Axes, rows: list[Row], found: Beside, *, axis: int, name: str) -> None:
    try:
        x: Any = np.array([float(row.where[axis]) for row in rows])
        wide = x.size > 1 and x.min() > 0 and x.max() >= 3 * x.min()
    except ValueError:
        x, wide = np.arange(len(rows)), False
        axes.set_xticks(x, [row.where[axis] for row in rows])
    order = np.argsort(x)
    for k, label in enumerate(found.labels):
        numbers = [row.numbers[k] for row in rows]
        axes.errorbar(
            x[order],
            np.array([number.value for number in numbers])[order],
            yerr=np.array([0.0 if math.isnan(n.error) else n.error for n in numbers])[order],
            color=COLOURS[k % len(COLOURS)],
            marker=SYMBOLS[k % len(SYMBOLS)],
            ls=STYLES[k % 4],
            capsize=2,
            label=label,
        )
    if wide:
        axes.set_xscale("log")
    axes.set_xlabel(mathtext(found.keys[axis]))
    axes.set_ylabel(mathtext(name))
    axes.legend(fontsize=7)
