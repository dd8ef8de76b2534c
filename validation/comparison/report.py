"""The page of a run: answers, tables, figures and findings from stored results; nothing here solves."""

from __future__ import annotations

import dataclasses
import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from validation.comparison.below import below_data, below_table, write_below
from validation.comparison.compared import Row
from validation.comparison.findings import layered, percent, yielded_row
from validation.comparison.pictures import render_stored
from validation.files import atomic_path
from validation.methods import find_method
from validation.report.drawing import Drawing
from validation.report.page import Answer, Note, Page, Picture, write_page
from validation.report.papers import PAPERS
from validation.report.table import ResultTable, WordTable
from validation.report.words import significant, with_error
from validation.solves.press import Press
from validation.solves.provenance import made_words

if TYPE_CHECKING:
    from fem_contact.contact import ContactResult
    from validation.comparison.compared import Comparison
    from validation.effects.base import Judgement
    from validation.scenes.scene import Scene
    from validation.solves.running import Solves
    from validation.solves.store import Store

__all__ = ["effects_note", "papers_for", "run_page", "seed_words", "write_outputs"]

_COLUMNS = (
    "method",
    "grid (shifts)",
    "A/A0 pixel",
    "A/A0 perimeter",
    "kappa",
    "residual",
    "lambda_short/dx",
    "P(0+) E*h'",
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


def write_outputs(
    comparison: Comparison, results: Solves, folder: Path, *, pictures: bool = False, report: bool = True
) -> tuple[Page, tuple[Path, ...]]:
    """Write tables, figures and report of a run; return the page, and what there is to open.

    Parameters
    ----------
    comparison : Comparison
    results : Solves
        All results of the scene; fields for the figures are read from them.
    folder : Path
        Results folder.
    pictures : bool
        Whether to render 3-D pictures, too; that takes seconds.
    report : bool
        Whether to draw figures and write the report, or tables and JSON alone.
    """
    page = run_page(comparison, results if report else None, pictures=pictures)
    written = write_page(page, folder, numbers_only=not report)
    fields = folder / "fields"
    blocks = tuple(_link_blocks(results, fields))
    below: Any = write_below(comparison.scene, results, fields)
    return page, (*written, *blocks, *below, results.store.folder)


def _link_blocks(results: Solves, folder: Path) -> Iterator[Path]:
    """Yield the deformed blocks of this run, named by their grids; those of an earlier run are taken away.

    The store keeps the blocks of every scene that ran in it; here are those that belong to the report.
    """
    for earlier in folder.glob("*.vtu"):
        earlier.unlink()
    pressed: list[Any] = list(results)
    for solve in pressed:
        stored = solve.block_file(results.store.folder) if solve.has_block else None
        if stored is None or not stored.exists():
            continue
        folder.mkdir(exist_ok=True)
        target = folder / f"{solve.prefix}.vtu"
        try:
            os.link(stored, target)
        except OSError:  # another file system, or one without links
            with atomic_path(target) as draft:
                shutil.copyfile(stored, draft)
        yield target


def run_page(comparison: Comparison, results: Solves | None = None, *, pictures: bool = False) -> Page:
    """Return the page of a run.

    Parameters
    ----------
    comparison : Comparison
    results : Solves, optional
        All results of the scene, with the fields for the figures; a page without figures if not given.
    pictures : bool
        Whether to render 3-D pictures, too.
    """
    scene = comparison.scene
    fields = {} if results is None else _shown(comparison, results)
    picture, missing = None, "not asked for"
    if pictures and results is not None:
        picture, missing = _picture(fields, results.store)
    return Page(
        title=scene.title or scene.name,
        lead=_lead(comparison),
        answers=tuple(_answers(comparison)),
        findings=comparison.findings,
        notes=tuple(_notes(comparison)),
        tables=tuple(_tables(comparison)),
        figures=_drawings(comparison, fields) if fields else (),
        pictures=() if picture is None else (picture,),
        no_picture=missing,
        facts=(_realised(comparison), *(() if results is None else made_words(results.made()))),
        settings=scene.model_dump(mode="json", exclude_none=True),
        seeds=seed_words(scene),
        papers=papers_for(scene),
        records={"table": _record(comparison)},
        summary=comparison.summary(),
    )


def _lead(c: Comparison) -> str:
    kinds = [effect.kind.replace("-", " ") for effect in c.scene.effects]
    effects = "effects: " + ", ".join(kinds) if kinds else "elastic, no adhesion"
    bodies = "Rigid rough" if c.scene.solid.second_young is None else "Elastic rough"
    held = "".join(
        f"{key.replace('_', ' ')} {value:.4g} m held, " for key, value in c.scene.load.held.items()
    )
    where = " of the layer at the surface" if layered(c) else ""
    return (
        f"{bodies} surface on an elastic solid, frictionless, {effects}; {held}p* = {c.reduced_pressure:.4g} "
        f"(p0 = {c.pressure:.4g} Pa, E* = {c.contact_modulus:.4g} Pa{where}, "
        f"realised h'_rms = {c.rms_gradient:.4g})"
    )


def _answers(c: Comparison) -> Iterator[Answer]:
    """Yield the cards on top of the page."""
    load, limit = c.reduced_pressure, c.limit
    yield Answer(
        question="How large is the contact? A/A0",
        answer="not determinable" if limit is None else significant(limit.value),
        basis=c.no_limit
        if limit is None
        else f"limit over the grids; kappa = {with_error(limit.value / load, limit.uncertainty / load)}",
    )
    yield _how_sure(c)
    theory = c.theory if c.theory is not None and c.theory.answers else None
    if theory is not None:
        yield Answer(
            question="How far from Persson's theory?",
            answer="not determinable" if limit is None else f"{100 * (limit.value / theory.area - 1):+.1f} %",
            basis=f"theory: A/A0 = {significant(theory.area)} with the realised gradient",
        )
    for row in yielded_row(c):
        predicted = ""
        if c.theory is not None and c.theory.plastic is not None:
            predicted = f"; theory: {significant(c.theory.plastic)}"
        yield Answer(
            question="How much has yielded? A_pl/A0",
            answer=significant(float("nan") if row.plastic is None else row.plastic),
            basis=f"{find_method(row.method).label} on {_grid(row)}, points counted{predicted}",
        )
    if not c.rows:
        return
    yield Answer(
        question="What did it cost?",
        answer=f"{sum(row.seconds for row in c.rows):.3g} s",
        basis=f"{sum(row.solves for row in c.rows)} solves shown, largest "
        f"{max(row.unknowns for row in c.rows):,} unknowns",
    )


def _how_sure(c: Comparison) -> Answer:
    """Say what the grids leave open for this surface, and by how much another one would differ."""
    said, basis = [], []
    if c.limit is not None:
        said.append(f"grid +- {percent(c.limit.uncertainty / c.limit.value)}")
        basis.append("grid: one standard error for this surface")
    if c.scatter is not None:
        said.append(f"surfaces +- {percent(c.scatter.relative)}")
        basis.append(f"surfaces: standard deviation of one among {len(c.scatter.areas)} of the same spectrum")
    elif c.mean is not None:
        said.append(f"surfaces +- {percent(c.mean['scatter'])}")
        basis.append(f"surfaces: standard deviation of one among {c.mean['surfaces']} of the same spectrum")
    else:
        basis.append("scatter between surfaces unknown")
    return Answer(question="How sure?", answer=", ".join(said) or "unknown", basis="; ".join(basis))


def effects_note(judged: tuple[tuple[Judgement, ...], tuple[Judgement, ...]]) -> Note:
    """Say which effects ran and which were left out, with the number that decides."""
    run, left_out = judged
    sentences = [f"Runs: {item.effect}: {item.number} - {item.verdict}" for item in run]
    sentences = sentences or ["None beyond linear elasticity runs."]
    sentences += [f"Left out: {item.effect}: {item.number} - {item.verdict}" for item in left_out]
    return Note(title="Effects", sentences=tuple(sentences))


def _notes(c: Comparison) -> Iterator[Note]:
    yield effects_note(c.judgements)
    if c.treatment:
        yield Note(title="The measured surface", sentences=c.treatment)


def _tables(c: Comparison) -> Iterator[WordTable]:
    density = (
        ""
        if c.adhesive
        else ("P(0+) is the share of area below a pressure that falls like dx^1/2, over that pressure; ")
    )
    which = ", on E* of the layer at the surface" if layered(c) else ""
    yield WordTable(
        title="Every grid",
        columns=_COLUMNS,
        rows=tuple(_cells(row) for row in c.rows),
        sums=tuple(_sums(c)),
        left=frozenset({"method", "grid (shifts)"}),
        yielding=("P(0+) E*h'", "lambda_short/dx", "seconds", "residual", "A/A0 perimeter", "kappa"),
        note="A/A0 pixel counts the points of the contact set (mean +- standard error over sub-grid shifts); "
        "perimeter subtracts the method's edge constant times edge length times dx; "
        f"kappa = (A/A0 perimeter)/p*{which}, of the limit its own area over p*; {density}"
        "residual is the largest of penetration/h_rms, tension/(E* h'_rms), complementarity and load error.",
    )
    if c.passing:
        from validation.comparison.passing import words_table

        yield words_table(c.passing)
    if c.below:
        yield below_table(c)
    if c.cross:
        yield WordTable(
            title=f"Beside {_first(c)} on the same grid",
            columns=(
                "method",
                "grid",
                "lambda_short/dx",
                "pressure, relative L2",
                "pixel area",
                "perimeter area",
            ),
            rows=tuple(
                (
                    find_method(check.method).label,
                    f"{check.grid[0]} x {check.grid[1]}",
                    f"{check.points_per_wave:.3g}",
                    f"{100 * check.pressure:.2f} %",
                    f"{100 * check.pixel:+.2f} %",
                    f"{100 * check.perimeter:+.2f} %",
                )
                for check in c.cross
            ),
            left=frozenset({"method", "grid"}),
            note="Same surface, same points, same load. " + _independence(c),
        )


def _first(c: Comparison) -> str:
    """Label of the method that the others are compared with."""
    return find_method(next(iter(c.scene.methods.solvers))).label


def _independence(c: Comparison) -> str:
    """Say what the agreement of the methods proves."""
    _, *others = c.scene.methods.solvers.items()
    apart = [method.label for _, method in others if method.independent]
    if not apart:
        return "They share a contact algorithm, so that agreement tests the discretisation alone."
    return (
        f"{' and '.join(apart)} has a contact algorithm of its own, so agreement tests both codes; the "
        "differences include that of the discretisations."
    )


def _grid(row: Row) -> str:
    return f"{row.grid[0]} x {row.grid[1]}"


def _cells(row: Row) -> tuple[str, ...]:
    pixel = with_error(row.pixel, row.pixel_scatter) if row.solves > 1 else significant(row.pixel)
    note = " (under-resolved)" if row.under_resolved else ""
    return (
        find_method(row.method).label + note,
        _grid(row) + (f" ({row.solves})" if row.solves > 1 else ""),
        pixel,
        significant(row.perimeter),
        significant(row.kappa),
        f"{row.residual:.1e}",
        f"{row.points_per_wave:.4g}",
        significant(row.density_at_zero, 3),
        f"{row.seconds:.3g}",
    )


def _sums(comparison: Comparison) -> Iterator[tuple[str, ...]]:
    """Yield the rows below the grids: the limit and the theory."""
    # Contact starts from zero pressure where nothing attracts and nothing yields first.
    zero = "" if comparison.scene.effects else "0"
    if comparison.limit is not None:
        value, error = comparison.limit.value, comparison.limit.uncertainty
        load = comparison.reduced_pressure
        kappa = with_error(value / load, error / load)
        yield ("limit", "dx -> 0", with_error(value, error), "", kappa, "", "", zero, "")
    theory = comparison.theory
    if theory is not None and theory.answers:
        kappa = significant(theory.area / comparison.reduced_pressure)
        zero = "" if theory.note else "0"
        yield ("Persson", "", significant(theory.area), "", kappa, "", "", zero, "")
    for row in comparison.rows:
        if row.plastic is not None:
            yield (
                f"{find_method(row.method).label}, yielded",
                _grid(row),
                significant(row.plastic),
                *("" for _ in _COLUMNS[3:]),
            )
    if theory is not None and theory.plastic is not None:
        yield ("Persson, yielded", "", significant(theory.plastic), *("" for _ in _COLUMNS[3:]))


def _record(comparison: Comparison) -> ResultTable:
    """Return every digit of every row, a grid as 64x64."""
    names = [field.name for field in dataclasses.fields(Row)]
    rows = []
    for row in comparison.rows:
        values = (getattr(row, name) for name in names)
        rows.append(["x".join(map(str, v)) if isinstance(v, tuple) else v for v in values])
    return ResultTable.of(names, rows)


def _realised(c: Comparison) -> str:
    text = (
        f"Realised surface: h_rms = {c.rms_height:.4g} m, h'_rms = {c.rms_gradient:.4g}, "
        f"Nayak parameter {c.nayak:.4g}."
    )
    if c.continuum:
        text += (
            f" Integrals over C(q){', estimated' if c.treatment else ''}: "
            f"h_rms = {c.continuum['rms_height_m']:.4g} m, h'_rms = {c.continuum['rms_gradient']:.4g}."
        )
    return text


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
    """Draw the figures of a comparison."""
    from validation.comparison import figure_data, plots

    by_grid: dict[str, list[ContactResult]] = {}
    for solve, result in shown.items():
        by_grid.setdefault(solve.label, []).append(result)
    near_zero = figure_data.pressure_at_zero_data(comparison, by_grid)
    finest = {label: by_grid[label] for label in {solve.method: solve.label for solve in shown}.values()}
    top = figure_data.largest_pressure(comparison, finest)
    to_its_end = figure_data.pressure_at_zero_data(comparison, finest, top=top)
    pair = _side_by_side(shown)
    return (
        *_below(comparison, shown),
        Drawing(
            name="area",
            figure=plots.area_figure(comparison),
            data=figure_data.area_data(comparison),
            caption="Contact area against grid spacing; coarse grids are on the right. Filled: contact "
            "points counted; open: corrected at the edge; solid line and band: limit over the grids with its "
            "standard error; dash-dotted: Persson's theory.",
        ),
        Drawing(
            name="pressure-at-zero",
            figure=plots.pressure_at_zero_figure(near_zero),
            data=near_zero,
            caption=_DISTRIBUTION + (_WITH_TENSION if comparison.adhesive else _FROM_ZERO),
        ),
        Drawing(
            name="pressure-distribution",
            figure=plots.pressure_at_zero_figure(to_its_end, logarithmic=True),
            data=to_its_end,
            caption="The same to the largest pressure, on the finest grid of each method"
            f"{_theory_caption(comparison)}.",
        ),
        Drawing(
            name="cost",
            figure=plots.cost_figure(comparison),
            data=figure_data.cost_data(comparison),
            caption="Error of the contact area against the limit, over the time of the solves. Grey: below "
            "the uncertainty of the limit, where points cannot be ranked.",
        ),
        Drawing(
            name="pressure-maps",
            figure=plots.pressure_maps_figure(comparison, pair),
            data=figure_data.pressure_maps_data(pair),
            caption="Contact pressure of both solvers on the same surface and grid, one colour scale, dark "
            "is high; and where both have the same points, their difference.",
        ),
    )


def _below(c: Comparison, shown: dict[Press, ContactResult]) -> Iterator[Drawing]:
    """Draw the stress over depth, where the scene asks for it."""
    if not c.below:
        return
    from validation.comparison import plots

    data = below_data(c, shown)
    yield Drawing(
        name="below",
        figure=plots.below_figure(data),
        data=data,
        caption="Von Mises stress over the depth below the surface, on the finest grid: the largest on each "
        "plane, and the root mean square. At the surface the edges of the contact ring.",
    )


def _theory_caption(c: Comparison) -> str:
    """Say which part of the theory is drawn."""
    if c.theory is None or not c.theory.answers:
        return ""
    yielded = (
        "; what has yielded is a delta at the hardness and left out" if c.theory.plastic is not None else ""
    )
    return f", beside the theory ({c.theory.note or 'elastic, without adhesion'}{yielded})"


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


def _picture(shown: dict[Press, ContactResult], store: Store) -> tuple[Picture | None, str]:
    """Render the finest finite-element solve, or the finest of all, of the surface as it stands."""
    solves = [solve for solve in shown if solve.shift == (0.0, 0.0)]
    if not solves:
        return None, "no solve of the surface as it stands"
    solve = max(solves, key=lambda solve: (solve.has_block, solve.grid[0] * solve.grid[1]))
    return render_stored(store.path(solve), label=solve.label)


def papers_for(scene: Scene) -> tuple[str, ...]:
    """Name what is to be cited: methods, effects, and how areas were corrected."""
    cited = [paper for method in scene.methods.asked.values() for paper in method.cited(scene.effects)]
    cited += [paper for effect in scene.effects for paper in effect.papers]
    return (*cited, PAPERS["perimeter"], *([PAPERS["measured"]] if scene.surface.kind == "file" else []))


def seed_words(scene: Scene) -> str:
    """Say by which numbers surfaces are drawn."""
    surface = scene.surface
    if surface.kind == "file":
        return "none: the surface was measured"
    if scene.ensemble is None or scene.ensemble.realisations < 2:
        return str(surface.seed)
    last = surface.seed_of(scene.ensemble.realisations - 1)
    return f"{surface.seed} (the surface shown), {surface.seed} to {last} (scatter between surfaces)"
