"""The report of a run: table, figures and findings from stored results; nothing here solves."""

from __future__ import annotations

import csv
import dataclasses
import json
import platform
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any

from validation.jobs import Job, block_file, jobs_of
from validation.store import atomic_path

if TYPE_CHECKING:
    from rich.table import Table

    from fem_contact.contact import ContactResult
    from validation.comparison import Comparison, Row
    from validation.store import Store

__all__ = ["console_table", "write_outputs"]

_COLUMNS = (
    "method",
    "grid",
    "lambda_short/dx",
    "A/A0 pixel",
    "A/A0 perimeter",
    "kappa",
    "P(0+) E*h'",
    "residual",
    "seconds",
)


def _cells(row: Row) -> tuple[str, ...]:
    pixel = f"{row.pixel:.5f}" + (f" +- {row.pixel_scatter:.5f}" if row.solves > 1 else "")
    note = " (under-resolved)" if row.under_resolved else ""
    return (
        row.method.upper() + note,
        f"{row.grid[0]} x {row.grid[1]}" + (f" x {row.solves} shifts" if row.solves > 1 else ""),
        f"{row.points_per_wave:.4g}",
        pixel,
        f"{row.perimeter:.5f}",
        f"{row.kappa:.3f}",
        f"{row.density_at_zero:.3f}",
        f"{row.residual:.1e}",
        f"{row.seconds:.3g}",
    )


def _summary_rows(comparison: Comparison) -> list[tuple[str, ...]]:
    """Rows below the grids: the limit and the theory."""
    rows: list[tuple[str, ...]] = []
    if comparison.limit is not None:
        value, error = comparison.limit.value, comparison.limit.uncertainty
        kappa = f"{value / comparison.reduced_pressure:.3f}"
        rows.append(("limit", "dx -> 0", "", f"{value:.5f} +- {error:.5f}", "", kappa, "0", "", ""))
    if comparison.theory is not None:
        area = comparison.theory.area
        rows.append(
            ("Persson", "", "", f"{area:.5f}", "", f"{area / comparison.reduced_pressure:.3f}", "0", "", "")
        )
    return rows


def console_table(comparison: Comparison) -> Table:
    """Return the table a run prints."""
    from rich.table import Table

    scene = comparison.scene
    table = Table(
        title=f"{scene.title or scene.name}: p* = {comparison.reduced_pressure:.4g}, "
        f"h'_rms = {comparison.rms_gradient:.4g} (realised), p0 = {comparison.pressure:.4g} Pa",
        caption="A/A0 pixel: contact points counted, mean and standard error over sub-grid shifts; "
        "perimeter: with the edge correction of the method; kappa = (A/A0 perimeter)/p*; "
        "residual: largest of penetration, tension, complementarity, load.",
    )
    for column in _COLUMNS:
        table.add_column(column, justify="left" if column in ("method", "grid") else "right", no_wrap=True)
    for row in comparison.rows:
        table.add_row(*_cells(row))
    table.add_section()
    for cells in _summary_rows(comparison):
        table.add_row(*cells)
    return table


def write_outputs(comparison: Comparison, store: Store, folder: Path) -> tuple[Path, ...]:
    """Write table.csv, summary.json, the figures and report.html.

    Returns what there is to open: files, and the folder of netCDF fields.

    Parameters
    ----------
    comparison : Comparison
    store : Store
        Where the solves are; fields for the figures are read from it.
    folder : Path
        Results folder.
    """
    table, summary, report = folder / "table.csv", folder / "summary.json", folder / "report.html"
    with atomic_path(table) as draft:
        _write_csv(draft, comparison)
    with atomic_path(summary) as draft:
        draft.write_text(json.dumps(comparison.summary(), indent=2) + "\n", encoding="utf-8")
    figures = _write_figures(comparison, store, folder)
    with atomic_path(report) as draft:
        draft.write_text(_html(comparison, figures), encoding="utf-8")
    blocks = [block_file(store.folder, job) for job in jobs_of(comparison.scene) if job.method == "fem"]
    return (report, table, summary, *(path for path in blocks if path.exists()), store.folder)


def _write_csv(path: Path, comparison: Comparison) -> None:
    names = [field.name for field in dataclasses.fields(type(comparison.rows[0]))]
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(names)
        for row in comparison.rows:
            values = dataclasses.asdict(row)
            writer.writerow(
                ["x".join(map(str, v)) if isinstance(v := values[name], tuple) else v for name in names]
            )


def _shown(comparison: Comparison, store: Store) -> dict[Job, ContactResult]:
    """Return the solves of the scene's own surface on the grids of the table."""
    grids = {(row.method, row.grid) for row in comparison.rows}
    shown = {}
    for job in jobs_of(comparison.scene):
        if job.realisation == 0 and (job.method, job.grid) in grids:
            result = store.load(job)
            assert result is not None, job.key
            shown[job] = result
    return shown


def _label(job: Job) -> str:
    return f"{job.method.upper()} {job.grid[0]} x {job.grid[1]}"


def _write_figures(comparison: Comparison, store: Store, folder: Path) -> dict[str, str]:
    """Draw the four figures, write them as SVG and return the SVG texts by name."""
    from validation import plots

    shown = _shown(comparison, store)
    by_grid: dict[str, list[ContactResult]] = {}
    for job, result in shown.items():
        by_grid.setdefault(_label(job), []).append(result)
    figures = {
        "area": plots.area_figure(comparison),
        "pressure-at-zero": plots.pressure_at_zero_figure(comparison, by_grid),
        "cost": plots.cost_figure(comparison),
        "pressure-maps": plots.pressure_maps_figure(comparison, _side_by_side(shown)),
    }
    target = folder / "figures"
    target.mkdir(exist_ok=True)
    texts = {}
    for name, figure in figures.items():
        path = target / f"{name}.svg"
        with atomic_path(path) as draft:
            plots.save_figure(figure, draft)
        drawing = path.read_text(encoding="utf-8")
        texts[name] = drawing[drawing.index("<svg") :]
    return texts


def _side_by_side(shown: dict[Job, ContactResult]) -> dict[str, ContactResult]:
    """Return the finest grid both solvers share, or the finest grid of each."""
    unshifted = {job: result for job, result in shown.items() if job.shift == (0.0, 0.0)}
    grids = [{job.grid for job in unshifted if job.method == method} for method in ("bem", "fem")]
    shared = grids[0] & grids[1]
    if shared:
        finest = max(shared, key=lambda grid: grid[0] * grid[1])
        return {_label(job): result for job, result in unshifted.items() if job.grid == finest}
    last = {job.method: (_label(job), result) for job, result in unshifted.items()}
    return dict(last.values())


def _versions() -> dict[str, str]:
    names = ("fem-contact", "numpy", "scipy", "numba", "scikit-fem", "pyamg")
    return {"Python": platform.python_version(), **{name: metadata.version(name) for name in names}}


def _html(comparison: Comparison, figures: dict[str, str]) -> str:
    import jinja2

    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("validation"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
    )
    page = environment.get_template("report.html.j2")
    context: dict[str, Any] = {
        "c": comparison,
        "columns": _COLUMNS,
        "rows": [_cells(row) for row in comparison.rows],
        "summary_rows": _summary_rows(comparison),
        "figures": {name: _safe(text) for name, text in figures.items()},
        "settings": json.dumps(comparison.scene.model_dump(mode="json", exclude_none=True), indent=2),
        "versions": _versions(),
    }
    return page.render(context)


def _safe(text: str) -> Any:
    """Mark an SVG that this package drew as safe to embed."""
    from markupsafe import Markup

    return Markup(text)
