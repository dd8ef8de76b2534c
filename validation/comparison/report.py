"""The report of a run: table, figures and findings from stored results; nothing here solves."""

from __future__ import annotations

import csv
import dataclasses
import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from validation.comparison.findings import yielded_row
from validation.comparison.pictures import Pictures, render_stored
from validation.files import atomic_path
from validation.methods import find_method
from validation.report.drawing import Drawing, Written, write_drawings
from validation.report.page import render, versions
from validation.report.papers import MEASURED, PERIMETER
from validation.report.words import significant, with_error
from validation.solves.press import Press
from validation.solves.running import Solves

if TYPE_CHECKING:
    from rich.table import Table

    from fem_contact.contact import ContactResult
    from validation.comparison.compare import Comparison, Row
    from validation.scenes.scene import Scene
    from validation.solves.store import Store

__all__ = ["console_table", "report_page", "write_outputs"]

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

_DISTRIBUTION = (
    "Distribution of contact pressure near zero on each grid, per nominal area (the non-contact area, a "
    "delta at zero, is left out). "
)
_FROM_ZERO = "The exact distribution starts at zero; what remains at zero pressure on a grid is the grid's."
_WITH_TENSION = (
    "Negative pressures are tension: with adhesion the points in contact near an edge are pulled, and the "
    "density at zero pressure is finite."
)


def _cells(row: Row) -> tuple[str, ...]:
    pixel = with_error(row.pixel, row.pixel_scatter) if row.solves > 1 else significant(row.pixel)
    note = " (under-resolved)" if row.under_resolved else ""
    return (
        find_method(row.method).label + note,
        f"{row.grid[0]} x {row.grid[1]}" + (f" x {row.solves} shifts" if row.solves > 1 else ""),
        f"{row.points_per_wave:.4g}",
        pixel,
        significant(row.perimeter),
        significant(row.kappa),
        significant(row.density_at_zero, 3),
        f"{row.residual:.1e}",
        f"{row.seconds:.3g}",
    )


def _summary_rows(comparison: Comparison) -> list[tuple[str, ...]]:
    """Rows below the grids: the limit and the theory."""
    rows: list[tuple[str, ...]] = []
    # Contact starts from zero pressure where nothing attracts and nothing yields first.
    zero = "" if comparison.scene.effects else "0"
    if comparison.limit is not None:
        value, error = comparison.limit.value, comparison.limit.uncertainty
        load = comparison.reduced_pressure
        kappa = with_error(value / load, error / load)
        rows.append(("limit", "dx -> 0", "", with_error(value, error), "", kappa, zero, "", ""))
    theory = comparison.theory
    if theory is not None and theory.answers:
        kappa = significant(theory.area / comparison.reduced_pressure)
        zero = "" if theory.note else "0"
        rows.append(("Persson", "", "", significant(theory.area), "", kappa, zero, "", ""))
    for row in comparison.rows:
        if row.plastic is not None:
            method, grid = f"{find_method(row.method).label}, yielded", f"{row.grid[0]} x {row.grid[1]}"
            rows.append((method, grid, "", significant(row.plastic), "", "", "", "", ""))
    if theory is not None and theory.plastic is not None:
        rows.append(("Persson, yielded", "", "", significant(theory.plastic), "", "", "", "", ""))
    return rows


def _effect_words(comparison: Comparison) -> str:
    """Name the effects that ran, for a title."""
    kinds = [effect.kind.replace("-", " ") for effect in comparison.scene.effects]
    return ", ".join(kinds) or "elastic, no adhesion"


def console_table(comparison: Comparison) -> Table:
    """Return the table a run prints."""
    from rich.table import Table

    scene = comparison.scene
    table = Table(
        title=f"{scene.title or scene.name} ({_effect_words(comparison)}): "
        f"p* = {comparison.reduced_pressure:.4g}, "
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


def write_outputs(
    comparison: Comparison, results: Solves, folder: Path, *, pictures: bool = False
) -> tuple[Path, ...]:
    """Write tables, figures and report; return what there is to open: files, and the folder of fields.

    Parameters
    ----------
    comparison : Comparison
    results : Solves
        All results of the scene; fields for the figures are read from them.
    folder : Path
        Results folder.
    pictures : bool
        Whether to render 3-D pictures, too; that takes seconds.
    """
    table, summary, report = folder / "table.csv", folder / "summary.json", folder / "report.html"
    with atomic_path(table) as draft:
        _write_csv(draft, comparison)
    with atomic_path(summary) as draft:
        draft.write_text(json.dumps(comparison.summary(), indent=2) + "\n", encoding="utf-8")
    shown = _shown(comparison, results)
    figures = write_drawings(_drawings(comparison, shown), folder)
    pressed: list[Any] = list(results)
    blocks = [solve.block_file(results.store.folder) for solve in pressed if solve.has_block]
    blocks = [path for path in blocks if path.exists()]
    images = _pictures(shown, results.store, folder) if pictures else Pictures(missing="not asked for")
    with atomic_path(report) as draft:
        draft.write_text(report_page(comparison, figures, images), encoding="utf-8")
    return (report, table, summary, folder / "figures", *blocks, results.store.folder)


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


def _shown(comparison: Comparison, results: Solves) -> dict[Press, ContactResult]:
    """Return the solves of the scene's own surface on the grids of the table."""
    grids = {(row.method, row.grid) for row in comparison.rows}
    pressed: list[Any] = list(results)
    return {
        solve: results[solve]
        for solve in pressed
        if solve.realisation == 0 and (solve.method, solve.grid) in grids
    }


def _drawings(comparison: Comparison, shown: dict[Press, ContactResult]) -> tuple[Drawing, ...]:
    """Draw the four figures of a comparison."""
    from validation.comparison import figure_data, plots

    by_grid: dict[str, list[ContactResult]] = {}
    for solve, result in shown.items():
        by_grid.setdefault(solve.label, []).append(result)
    near_zero = figure_data.pressure_at_zero_data(comparison, by_grid)
    pair = _side_by_side(shown)
    return (
        Drawing(
            name="area",
            figure=plots.area_figure(comparison),
            data=figure_data.area_data(comparison),
            caption="Contact area against grid spacing; coarse grids are on the right. Filled: contact "
            "points counted; "
            "open: corrected at the edge; solid line and band: limit over the grids with its standard error; "
            "dash-dotted: Persson's theory.",
        ),
        Drawing(
            name="pressure-at-zero",
            figure=plots.pressure_at_zero_figure(near_zero),
            data=near_zero,
            caption=_DISTRIBUTION + (_WITH_TENSION if comparison.adhesive else _FROM_ZERO),
        ),
        Drawing(
            name="cost",
            figure=plots.cost_figure(comparison),
            data=figure_data.cost_data(comparison),
            caption="Error of the contact area against the limit, over the time of the solves. Grey: below "
            "the "
            "uncertainty of the limit, where points cannot be ranked.",
        ),
        Drawing(
            name="pressure-maps",
            figure=plots.pressure_maps_figure(comparison, pair),
            data=figure_data.pressure_maps_data(pair),
            caption="Contact pressure of both solvers on the same surface and grid, one colour scale; dark "
            "is high.",
        ),
    )


def _side_by_side(shown: dict[Press, ContactResult]) -> dict[str, ContactResult]:
    """Return the finest grid that all methods share, or the finest grid of each."""
    unshifted = {solve: result for solve, result in shown.items() if solve.is_own}
    names = dict.fromkeys(solve.method for solve in unshifted)
    grids = [{solve.grid for solve in unshifted if solve.method == name} for name in names]
    shared = set.intersection(*grids) if len(grids) > 1 else set()
    if shared:
        finest = max(shared, key=lambda grid: grid[0] * grid[1])
        return {solve.label: result for solve, result in unshifted.items() if solve.grid == finest}
    last = {solve.method: (solve.label, result) for solve, result in unshifted.items()}
    return dict(last.values())


def _pictures(shown: Iterable[Press], store: Store, folder: Path) -> Pictures:
    """Render the finest finite-element solve, or the finest of all, of the surface as it stands."""
    solves = [solve for solve in shown if solve.shift == (0.0, 0.0)]
    if not solves:
        return Pictures(missing="no solve of the surface as it stands")
    solve = max(solves, key=lambda solve: (solve.has_block, solve.grid[0] * solve.grid[1]))
    return render_stored(store.path(solve), folder / "figures" / "surface-3d.png", label=solve.label)


def report_page(
    comparison: Comparison, figures: Sequence[Written] = (), pictures: Pictures | None = None
) -> str:
    """Return the report as one page of HTML."""
    return render(
        "report.html.j2",
        title=comparison.scene.title or comparison.scene.name,
        c=comparison,
        columns=_COLUMNS,
        rows=[_cells(row) for row in comparison.rows],
        summary_rows=_summary_rows(comparison),
        figures=figures,
        pictures=pictures or Pictures(missing="not asked for"),
        settings=json.dumps(comparison.scene.model_dump(mode="json", exclude_none=True), indent=2),
        seeds=_seeds(comparison.scene),
        versions=versions(),
        papers=_papers_for(comparison),
        effects=_effect_words(comparison),
        yielded=yielded_row(comparison),
        significant=significant,
        with_error=with_error,
    )


def _papers_for(comparison: Comparison) -> tuple[str, ...]:
    """Name what is to be cited: methods, effects, and how areas were corrected."""
    scene = comparison.scene
    cited = [paper for method in scene.methods.asked.values() for paper in method.papers]
    cited += [paper for effect in scene.effects for paper in effect.papers]
    return (*cited, PERIMETER, *([MEASURED] if comparison.treatment else []))


def _seeds(scene: Scene) -> str:
    surface = scene.surface
    if surface.kind == "file":
        return "none: the surface was measured"
    if scene.ensemble is None or scene.ensemble.realisations < 2:
        return str(surface.seed)
    last = surface.seed_of(scene.ensemble.realisations - 1)
    return f"{surface.seed} (the surface shown), {surface.seed} to {last} (scatter between surfaces)"
