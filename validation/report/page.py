"""The page that a run and a study leave: what was asked, what came out, and every number."""

from __future__ import annotations

import base64
import contextlib
import hashlib
import json
import sys
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import xarray as xr

from validation.errors import harmless
from validation.files import atomic_path, digest_of, read_record, remove_drafts, write_json, write_record
from validation.registry import versions
from validation.report.marks import Drawing, draw, write_drawing
from validation.report.papers import cited
from validation.report.table import (
    TREATMENT,
    ResultTable,
    WordTable,
    budget_table,
    shown,
    write_dataset,
    write_table,
)
from validation.report.values import values_of
from validation.report.views import Card, Views
from validation.report.words import json_ready, mathematics

#: What the numbers of a page are a result of, beside it.
RECORD = "result.json"

#: Width over height from which on a figure has several panels, and the width of the page to itself.
_WIDE = 1.7

#: Pixels of the page for an inch of a figure, at most.
_ENLARGED = 170

_BUDGET = (
    "Half widths of 95 % intervals by source, in per cent of the value. Together they are the root of the "
    "sum of their squares, where all are measured."
)
_TREATED = (
    " Treatment is no part of the intervals: how far other treatments of the map move the area, together."
)


#: Characters of a sentence in half of a page of 1400 pixels, and lines of a table for each line of it.
_LINE, _SENTENCE = 68, 0.85
#: Lines of a table that are as high as the first figure, with by how many what is beside it may be higher.
_FIGURE = 20.0 + 6.0


@dataclass(frozen=True, kw_only=True)
class Picture:
    """A PNG image, and what it shows."""

    name: str
    png: bytes
    caption: str


@dataclass(frozen=True, kw_only=True, eq=False)
class Page:
    """Everything that a results folder shows, before any of it is written.

    `notes` are sentences by their heading; `records` are written as CSV by name, `data` as data.csv, with one
    more file for each further set of dimensions, and `summary` as summary.json, with the papers to cite.
    """

    title: str
    lead: str
    settings: Mapping[str, Any]
    seeds: str
    papers: tuple[str, ...]
    answers: tuple[Card, ...] = ()
    findings: tuple[str, ...] = ()
    notes: Mapping[str, Sequence[str]] = field(default_factory=dict)
    tables: tuple[WordTable, ...] = ()
    budget: ResultTable | None = None
    figures: tuple[Drawing, ...] = ()
    pictures: tuple[Picture, ...] = ()
    no_picture: str = ""
    facts: tuple[str, ...] = ()
    versions: Mapping[str, str] = field(default_factory=versions)
    records: Mapping[str, ResultTable] = field(default_factory=dict)
    data: xr.Dataset | None = None
    summary: Mapping[str, Any] | None = None


def page_of(data: xr.Dataset, views: Views, /, *, figures: bool, **rest: Any) -> Page:
    """Return the page of a dataset: what its views declare, drawn or not, and what else `Page` is told.

    Of the `rest`, fields of `Page`, notes and the summary are added to those of the findings.
    """
    made = [(table, rows) for table in views.tables if (rows := table.of(data)).rows]
    every = (draw(figure, data) for figure in (views.figures if figures else ()))
    numbers = {
        name: {k: v for k, v in value.as_json().items() if k in ("value", "error", "sources")}
        for name, value in sorted(values_of(data).items())
    }
    summary = {**views.as_json(data), "numbers": numbers}
    context: dict[str, Any] = {
        "answers": tuple(Card(card.question, str(card.answer), str(card.basis)) for card in views.cards),
        "findings": tuple(finding.text for finding in views.findings),
        "tables": tuple(shown(rows, title=table.title, note=table.note) for table, rows in made),
        "budget": budget_table(data, views.budget) if views.budget else None,
        "figures": tuple(drawing for drawing in every if drawing.drawn),
        "records": {table.file: rows for table, rows in made},
        "data": data,
        "facts": tuple(str(data.attrs.get("solves_made", "")).splitlines()),
    }
    context |= rest | {"papers": tuple(dict.fromkeys(map(cited, rest["papers"])))}
    context["summary"] = json_ready({**summary, **rest.get("summary", {})})
    return Page(**context)


def write_page(page: Page, folder: Path, *, numbers_only: bool) -> tuple[Path, ...]:
    """Write tables, JSON, figures and the report into a folder; return the files, the report first.

    With `numbers_only` figures and report are left out, as they can be made later from what is stored.
    """
    written: list[Path] = []
    if page.data is not None:
        # Maps stand beside their figures.
        written += write_dataset(page.data.drop_dims(["x", "y"], errors="ignore"), folder / "data.csv")
    records = page.records if page.budget is None else {**page.records, "budget": page.budget}
    written += [write_table(table, folder / f"{name}.csv") for name, table in records.items()]
    if page.summary is not None:
        written.append(write_json(folder / "summary.json", {**page.summary, "papers": list(page.papers)}))
    if numbers_only:
        clear_page(folder, keep=(*written, _seal(folder, written)))
        return tuple(written)
    figures, report = folder / "figures", folder / "report.html"
    if page.figures or page.pictures:
        figures.mkdir(exist_ok=True)
    pictures = [figures / f"{picture.name}.png" for picture in page.pictures]
    for path, picture in zip(pictures, page.pictures, strict=True):
        with atomic_path(path) as draft:
            draft.write_bytes(picture.png)
    drawn = [_embedded(drawing, write_drawing(drawing, figures)) for drawing in page.figures]
    with atomic_path(report) as draft:
        draft.write_text(render(page, drawn), encoding="utf-8")
    drawings = [folder / file for figure in drawn for file, _ in figure["files"]]
    outputs = [report, *written, *drawings, *pictures]
    clear_page(folder, keep=(*outputs, _seal(folder, outputs)))
    return _listed(folder, outputs)


def _listed(folder: Path, files: Iterable[Path]) -> tuple[Path, ...]:
    """Return those that a reader is told of: the folder of figures instead of each of them."""
    return tuple(dict.fromkeys(path if path.parent == folder else path.parent for path in files))


def _seal(folder: Path, files: Collection[Path]) -> Path:
    """Write the digests of a result and of what shows it, for whoever reads numbers back from there."""
    digests = {str(path.relative_to(folder)): digest_of(path) for path in files}
    of = digest_of(folder / RECORD) if (folder / RECORD).exists() else None
    return write_record(folder / "shown.json", {"of": of, "files": digests})


def standing_page(folder: Path, *, numbers_only: bool) -> tuple[Path, ...]:
    """Return the files of a page that shows the folder's record already; none where it is to be made.

    Every file has to be the one that was written, and later than all code that is loaded or in this package.
    """
    seal = folder / "shown.json"
    with contextlib.suppress(OSError, ValueError, KeyError):
        shown = read_record(seal)
        files = {folder / name: digest for name, digest in shown["files"].items()}
        whole = "report.html" in shown["files"]
        same = shown["of"] == digest_of(folder / RECORD) and whole != numbers_only
        if same and _code_time() < seal.stat().st_mtime and all(digest_of(p) == d for p, d in files.items()):
            return _listed(folder, files)
    return ()


def _code_time() -> float:
    """When code was last changed that is loaded, or belongs to this package."""
    loaded = (getattr(module, "__file__", None) for module in [*sys.modules.values()])
    ours = (path for path in Path(__file__).parents[1].rglob("*") if path.suffix != ".pyc" and path.is_file())
    return max(path.stat().st_mtime for path in {*map(Path, filter(None, loaded)), *ours} if path.exists())


def clear_page(folder: Path, *, keep: Collection[Path] = ()) -> None:
    """Remove from a results folder what an earlier page left there, and drafts of killed processes.

    Nothing but files that a page writes is touched: CSV files by name, summary.json, report.html, and the
    images and numbers in the folder of figures.
    """
    figures = folder / "figures"
    tables = "table claims areas magnification numbers methods below surfaces first-surface treatment"
    tables += " settings budget data data-*"
    names = ["report.html", "summary.json", "shown.json", *(f"{name}.csv" for name in tables.split())]
    earlier = [path for name in names for path in folder.glob(name)]
    if figures.is_dir() and not figures.is_symlink():
        earlier += [p for suffix in ("svg", "pdf", "csv", "nc", "png") for p in figures.glob(f"*.{suffix}")]
        remove_drafts(figures)
    for path in set(earlier) - set(keep):
        path.unlink(missing_ok=True)
    remove_drafts(folder)


def _embedded(drawing: Drawing, files: tuple[Path, ...]) -> dict[str, Any]:
    """Return what the template shows of a figure, of whose files the first is the SVG."""
    from markupsafe import Markup

    from validation.report.figure import embeddable

    svg = embeddable(files[0].read_text(encoding="utf-8"), drawing.name, words=drawing.caption)
    figure, links = drawing.figure, []
    for path in files:  # svg, pdf, csv, nc; csv (mode, load) of numbers along other dimensions
        along = path.stem.removeprefix(drawing.name).strip("-").replace("-", ", ")
        links.append((f"figures/{path.name}", path.suffix[1:] + (f" ({along})" if along else "")))
    return {
        "name": drawing.name,
        # This package drew it: nothing in it comes from elsewhere.
        "svg": Markup(svg),
        "caption": drawing.caption,
        "wide": figure.get_figwidth() > _WIDE * figure.get_figheight(),
        "pixels": round(_ENLARGED * figure.get_figwidth()),
        "files": links,
    }


def layout(
    findings: Iterable[str],
    tables: Sequence[WordTable],
    budget: WordTable | None,
    figures: Sequence[Mapping[str, Any]],
) -> dict[str, Any]:
    """Place what a page shows so that no half of it stays empty.

    Tables stand `beside` the first figure, `across` the page or in `columns` with the `narrow` figures. The
    budget and the first table stand below the findings, where half a page holds them and there is room
    beside the first figure.
    """
    placed = [replace(table, turned=len(table.columns) > 12 and len(table.rows) < 9) for table in tables]
    if budget is not None:
        budget = replace(budget, turned=not budget.narrow and len(budget.rows) < 5)
        placed.insert(1, budget)
    beside: list[WordTable] = []
    lines = 2 + sum(_SENTENCE * (1 + len(text) // _LINE) for text in findings)
    room = _FIGURE if figures and not figures[0]["wide"] else 0.0
    for one in sorted(placed[:2], key=lambda one: one is not budget):
        if one.narrow and lines + one.lines <= room:
            beside.append(one)
            lines += one.lines
    rest = [one for one in placed if one not in beside]
    return {
        "beside": beside,
        "across": [one for one in rest if not one.narrow],
        "columns": [one for one in rest if one.narrow],
        "narrow": [figure for figure in figures[1:] if not figure["wide"]],
        "wide": [figure for figure in figures[1:] if figure["wide"]],
    }


def render(page: Page, figures: Sequence[Mapping[str, Any]] = ()) -> str:
    """Return the page as HTML, with figures as they were written."""
    import jinja2
    from markupsafe import Markup

    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("validation.report"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["math"] = mathematics
    environment.filters["harmless"] = harmless
    environment.filters["base64"] = lambda data: base64.b64encode(data).decode("ascii")
    budget = None
    if page.budget is not None:
        note = _BUDGET + _TREATED * (TREATMENT in page.budget.columns)
        budget = shown(page.budget, title="What is uncertain", note=note)
    # The one script that may run: the policy of the page names it by its hash.
    assert environment.loader is not None
    script = environment.loader.get_source(environment, "zoom.js")[0]
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    return environment.get_template("report.html.j2").render(
        page=page,
        figures=figures,
        layout=layout(page.findings, page.tables, budget, figures),
        settings=json.dumps(page.settings, indent=2),
        script=Markup(script),
        script_hash=f"sha256-{digest}",
    )
