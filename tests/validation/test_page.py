"""One kind of page: what a run and a study leave is written by the same code."""

import csv
import dataclasses
import io
import json
import math
import re
import shutil
import socket
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from rich.console import Console
from small_scene import scene_of

from validation.audit.values import page_tables
from validation.cli.results import Bar, page_table, print_outputs, sentence_lines
from validation.comparison.run import report_scene, result_page, run_scene
from validation.comparison.run_views import run_views
from validation.execution.bench import Bench
from validation.execution.results import read_results, record_of, show
from validation.report.estimates import total_error
from validation.report.figure import new_figure, readable_ticks, save_figure
from validation.report.findings import note
from validation.report.marks import Figure, Line, Panel, draw, panels_along
from validation.report.page import Page, render, write_page
from validation.report.table import ResultTable, WordTable, shown, write_dataset
from validation.report.views import Card, Views
from validation.report.words import mathematics, percent
from validation.studies import find_study
from validation.studies._outputs import _cards, _undetermined, run_study, study_page


def _run_area(folder, store, **how):
    area = find_study("area")
    rough = {"seed": 3, "surfaces": 2, "grids": (16, 24, 32), "bandwidth": 2.0}
    options = area.options(reduced_pressures=(0.02, 0.1, 0.5), **rough)
    return run_study(area, options, folder, bench=Bench.at(store), **how)


@pytest.fixture(scope="module")
def outputs(small_run, tmp_path_factory):
    """What a run and a study left behind: page, folder, and how both are made again."""
    folder = tmp_path_factory.mktemp("outputs")
    shutil.copytree(small_run.folder, folder / "run")
    (folder / "study").mkdir()
    study = _run_area(folder / "study", folder / "solves")
    return {
        "run": (small_run.page, folder / "run", report_scene),
        "study": (study.page, folder / "study", lambda folder: show(folder, study_page)),
    }


@pytest.mark.parametrize("kind", ["run", "study"])
def test_a_run_and_a_study_leave_the_same_kind_of_page(outputs, kind):
    page, folder, again = outputs[kind]
    written = {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    html = (folder / "report.html").read_text(encoding="utf-8")
    headings = re.findall(r"<h2>(.*?)</h2>", html)
    assert headings[0] == "What was found"
    assert headings[-2:] == ["Settings, seeds, versions", "Papers to cite"]
    for words in (page.lead, *page.findings, *(column for t in page.tables for column in t.columns)):
        assert mathematics(words) in html
    findings = json.loads((folder / "summary.json").read_text())["findings"]
    assert [one if isinstance(one, str) else one["text"] for one in findings] == list(page.findings)
    for name, table in page.records.items():
        with (folder / f"{name}.csv").open(newline="") as file:
            assert len(list(csv.reader(file))) == 1 + len(table.rows)
    for drawing in page.figures:
        assert f'id="{drawing.name}"' in html
        suffixes = {path.suffix for path in folder.glob(f"figures/{drawing.name}.*")}
        assert suffixes == {".svg", ".pdf", ".csv", ".nc"}
    for path in written:
        if path.parts[0] in ("report.html", "figures", "summary.json", "table.csv", "data.csv"):
            (folder / path).unlink()
    again(folder)
    for path, content in written.items():
        if path.suffix != ".nc" and path.name != "shown.json":  # the bytes of HDF5 differ
            assert (folder / path).read_bytes() == content, path


def test_a_study_answers_on_its_first_screen_with_interval_and_distance_to_the_theory(outputs):
    page, folder, _ = outputs["study"]
    assert page.seeds == "3 is the first; each further surface has its own"
    answer, sure, distance = page.answers
    data = read_results(folder).data
    table, half = data.area, total_error(data, "area")
    assert answer.answer == f"{table.min().item():.4g} to {table.max().item():.4g}"
    assert (answer.basis, sure.basis) == ("p* = 0.02 to p* = 0.5", "95 %: surfaces, grid")
    # One of them is as large as the area: a share of that says nothing.
    assert (half / table).max() > 1
    assert sure.answer == f"+- {half.min().item():.2g} to {half.max().item():.2g}"
    narrow = list(_cards(data.assign(area_error=data.area_error / 20), Views(budget=("area",))))[1]
    assert narrow.answer == f"+- {percent((half / table / 20).min())} to {percent((half / table / 20).max())}"
    assert distance.question == "How far from Persson's theory?"
    assert " of 3 cases they agree within the 95 % interval" in distance.basis


def test_a_study_without_a_single_number_begins_with_what_it_found_first(outputs):
    data = read_results(outputs["study"][1]).data
    views = Views(findings=(note("One."), note("Two.")))
    assert [card.answer.text for card in _cards(data, views)] == ["One."]


def _page(**said):
    return Page(title="A page", lead="p0 = 2 Pa", settings={"seed": 5}, seeds="5", papers=(), **said)


def test_a_page_writes_every_digit_and_shows_five(tmp_path):
    table = ResultTable(columns=("name", "value"), rows=(("a", 1 / 3), ("b", float("nan"))))
    data = xr.Dataset({"area": ("load", np.array([0.1, 0.2]))})
    page = _page(records={"table": table}, tables=(shown(table),), data=data, summary={"x": 1})
    files = write_page(page, tmp_path, numbers_only=False)
    assert [path.name for path in files] == ["report.html", "data.csv", "table.csv", "summary.json"]
    assert (tmp_path / "table.csv").read_text().splitlines()[1] == f"a,{1 / 3!r}"
    assert "0.33333</td>" in (tmp_path / "report.html").read_text()
    assert not (tmp_path / "figures").exists()


@pytest.mark.parametrize(("columns", "rows"), [(13, 3), (12, 3), (13, 9)])
def test_a_table_of_many_columns_and_few_rows_is_turned(columns, rows):
    table = ResultTable(columns=tuple(f"c{k}" for k in range(columns)), rows=((1.0,) * columns,) * rows)
    page = render(_page(tables=(shown(table, title="Wide"),)))
    assert ("scroll turned" in page) == ((columns, rows) == (13, 3))
    names, lines = page_tables(page)["Wide"]
    assert (len(names), len(lines), {len(line) for line in lines}) == (columns, rows, {columns})


def test_half_a_page_holds_a_table_of_76_characters():
    def narrow(*widths, turned=False):
        across = tuple("y" * width for width in widths)
        rows = tuple(("x", cell) for cell in across) if turned else (across,)
        return WordTable(columns=tuple("abcd"[: len(rows[0])]), rows=rows, turned=turned).narrow

    assert narrow(17, 17, 17, 17)
    assert not narrow(17, 17, 17, 18)
    assert narrow(36, 50), "long cells break"
    assert narrow(12, 12, 12, 12, turned=True)
    assert not narrow(12, 12, 12, 13, turned=True)


def test_what_was_measured_nowhere_takes_no_column_and_is_named_below():
    cells = [("a", 1.0, "not measured", "not measured"), ("b", 2.0, "not measured", 0.5)]
    columns = ("number", "grid [%]", "size [%]", "solver [%]")
    table = shown(ResultTable(columns=columns, rows=cells), note="Shares.")
    assert table.columns == ("number", "grid [%]", "solver [%]")
    assert table.note == "Shares. Not measured: size."


def test_what_intervals_hold_is_said_of_the_rows_that_have_one():
    cells = [("a", 2.0, 0.1, "grid"), ("b", 3.0, math.nan, math.nan)]
    table = shown(ResultTable(columns=("number", "kappa", "kappa +- (95 %)", "kappa +- holds"), rows=cells))
    assert table.note == "Intervals (95 %) hold: grid."


def test_numbers_of_a_figure_stand_at_values_not_at_places(tmp_path):
    data = xr.Dataset(
        {"kappa": (("hurst", "load", "end"), np.arange(8.0).reshape(2, 2, 2))},
        coords={"hurst": [0.3, 0.8], "reduced_pressure": ("load", [0.05, 0.1])},
    )
    (path,) = write_dataset(data, tmp_path / "kappa.csv")
    header, first, *_ = path.read_text().splitlines()
    assert (header, first) == ("hurst,end,reduced_pressure,kappa", "0.3,0,0.05,0.0")


def test_what_looks_like_markup_is_shown_and_not_obeyed():
    page = _page(findings=("<b>A/A0</b> = 1",), answers=(Card("<i>", "<u>"),))
    html = render(dataclasses.replace(page, title="<script>alert(1)</script>"))
    assert "<script>" not in html
    assert "&lt;b&gt;A/A<sub>0</sub>&lt;/b&gt; = 1" in html
    assert not re.search(r"<[iu]>", html)


def test_a_run_of_another_scene_leaves_nothing_of_the_one_before(small_run, read_scene, tmp_path):
    folder = tmp_path / "results"
    shutil.copytree(small_run.folder, folder)
    names = "figures/surface-3d.png figures/other.svg areas.csv data.csv data-load.csv study.json run.json"
    old = [folder / name for name in names.split()]
    mine = [folder / "notes.txt", folder / "figures" / "notes.txt"]
    for path in (*old, *mine):
        path.write_text("earlier")
    draft = folder / "figures" / f".{socket.gethostname()}-{_dead_process()}-area.svg"
    draft.write_text("half")
    again = run_scene(read_scene(("A small scene", "Another"), fem=False), folder)
    assert again.solved == 0
    assert not [path for path in (*old, draft) if path.exists()]
    assert all(path.exists() for path in mine)
    assert {path.suffix for path in again.files if path.is_file()} == {".html", ".csv", ".json", ".nc"}
    assert not list(folder.glob("fields/*"))


def test_an_interrupted_run_of_another_scene_does_not_stand_beside_the_old_report(
    small_run, read_scene, tmp_path, monkeypatch
):
    folder = tmp_path / "results"
    shutil.copytree(small_run.folder, folder)

    def interrupted(*args, **kwargs):
        raise KeyboardInterrupt

    monkeypatch.setattr("validation.execution.bench.Bench.solve", interrupted)
    with pytest.raises(KeyboardInterrupt):
        run_scene(scene_of(small_run), folder)
    assert (folder / "report.html").exists()
    with pytest.raises(KeyboardInterrupt):
        run_scene(read_scene(("A small scene", "Another")), folder)
    assert not (folder / "report.html").exists()
    assert not list(folder.glob("figures/*"))


def test_a_folder_is_that_of_what_ran_in_it_last(outputs, small_run, tmp_path):
    folder = tmp_path / "both"
    shutil.copytree(outputs["study"][1], folder)
    assert record_of(folder)["kind"] == "study"
    run_scene(scene_of(small_run), folder, bench=Bench.at(small_run.folder / "solves"), report=False)
    assert record_of(folder)["kind"] == "run"
    _run_area(folder, outputs["study"][1].parent / "solves", report=False)
    assert record_of(folder)["kind"] == "study"


def _dead_process():
    done = subprocess.Popen([sys.executable, "-c", ""])
    done.wait()
    return done.pid


HOSTILE = "[/]\x1b[31m<b>\u202etxt.exe"


def test_a_hostile_title_is_harmless_in_terminal_and_page(small_run, capsys):
    data = small_run.data.assign_attrs(title=HOSTILE)
    page = result_page(dataclasses.replace(small_run.result, data=data), figures=True)
    print_outputs(dataclasses.replace(small_run, page=page))
    for text in (capsys.readouterr().out, render(page)):
        assert r"[/]\x1b[31m" in text
        assert not {"\x1b", "\u202e"} & set(text)
    assert "&lt;b&gt;" in render(page)


@pytest.mark.parametrize("width", [80, 100, 200])
def test_columns_that_decide_stay_whole_at_every_width(small_run, width):
    console = Console(width=width, file=io.StringIO(), force_terminal=False)
    table = small_run.page.tables[0]
    shown, left_out = page_table(table, width=width)
    console.print(shown)
    text = console.file.getvalue()
    assert max(map(len, text.splitlines())) <= width
    for words in ("method", "grid", "corrected at its edge", table.rows[0][1]):
        assert words in text
    for name in table.columns:
        assert (name in text) != (name in left_out)
    assert "…" not in text
    assert (width == 200) <= (len(left_out) < 5)


def test_two_columns_of_one_name_stay_apart_or_leave_together():
    table = WordTable(columns=("A", "+-", "B", "+-"), rows=(("1", "2", "3", "4" * 30),), yielding=("+-",))
    whole, left_out = page_table(table, width=80)
    assert (len(whole.columns), left_out) == (4, ())
    narrow, left_out = page_table(table, width=20)
    assert ([str(column.header) for column in narrow.columns], left_out) == (["A", "B"], ("+-",))


def test_a_narrow_terminal_keeps_the_first_columns_of_a_study_whole(outputs):
    table = outputs["study"][0].tables[0]
    shown, left_out = page_table(table, width=60)
    kept = [str(column.header) for column in shown.columns]
    assert kept == list(table.columns[: len(kept)])
    assert (*kept, *reversed(left_out)) == table.columns
    assert 2 <= len(kept) < len(table.columns)


def test_findings_break_at_words_on_a_terminal_and_nowhere_in_a_log(small_run):
    finding = f"- {small_run.page.findings[0]}"
    lines = sentence_lines(finding, 80)
    assert len(lines) > 1
    assert max(map(len, lines)) <= 80
    assert " ".join(line.strip() for line in lines) == finding
    assert sentence_lines(finding, None) == [finding]


def _jobs(count):
    own = {"describe": lambda: "a solve", "predict": lambda: SimpleNamespace(seconds=0.1)}
    return tuple(SimpleNamespace(key=str(k), **own) for k in range(count))


def test_between_the_first_and_the_last_a_log_says_a_line_in_ten_seconds(monkeypatch, capsys):
    jobs = _jobs(5)
    with Bar(quiet=False) as bar:
        bar.start(jobs, 0)
        for job, second in zip(jobs, (0.0, 9.0, 11.0, 20.0, 21.0), strict=True):
            monkeypatch.setattr("time.monotonic", lambda second=second: second)
            bar.done(job)
    told = [line.split()[1] for line in capsys.readouterr().err.splitlines() if " of 5: " in line]
    assert told == ["1", "3", "5"]


@pytest.mark.parametrize(("quiet", "told"), [(True, ""), (False, "fem-contact: 12 solves, 3 s\n")])
def test_a_plan_is_told_unless_one_asked_for_quiet(capsys, quiet, told):
    with Bar(quiet=quiet) as bar:
        bar.plan("12 solves, 3 s")
    assert capsys.readouterr().err == told


def test_a_bar_ends_full_and_counts(monkeypatch):
    monkeypatch.setattr("rich.console.Console.is_terminal", True)
    jobs = _jobs(3)
    with Bar(quiet=False) as bar:
        bar.start(jobs, 2)
        for job in jobs:
            bar.begin(job)
            bar.done(job)
        (task,) = bar._progress.tasks
        assert task.percentage == 100
        assert task.fields["count"] == "3 of 3 solved,"
        assert task.description.startswith("writing")
        bar.start((), 5)
        (task,) = bar._progress.tasks
        assert (task.percentage, task.fields["count"]) == (100, "all 5 solves found,")


@pytest.mark.parametrize("name", ["BEM 512x512", "kappa, grids 96x96, H = 0.8, nu = 0.3, surface 12 (-h)"])
def test_the_times_of_a_bar_are_whole_on_80_columns(monkeypatch, name):
    monkeypatch.setattr("rich.console.Console.is_terminal", True)
    monkeypatch.setenv("COLUMNS", "80")
    solve = SimpleNamespace(key="k", describe=lambda: name, predict=lambda: SimpleNamespace(seconds=1.0))
    with Bar(quiet=False) as bar:
        for step in (lambda: bar.start((solve,), 5), lambda: bar.begin(solve), lambda: bar.done(solve)):
            step()
            console = Console(width=80, file=io.StringIO(), color_system=None)
            console.print(bar._progress.get_renderable())
            (line,) = console.file.getvalue().splitlines()
            assert re.search(r" % 0:00:0\d left [-0]:[-0]{2}:[-0]{2}$", line.rstrip()), line
    assert line.startswith("1 of 1 solved, writing the report ")


@pytest.mark.parametrize(
    ("range_", "shown"),
    [
        ((1, 30), {"1", "2", "5", "10", "20"}),
        ((0.02, 200), {"10⁻¹", "10⁰", "10¹", "10²"}),
        ((2e-9, 5e-9), {"2×10⁻⁹", "5×10⁻⁹"}),
        ((8e-9, 3e-8), {"10⁻⁸", "3×10⁻⁸"}),
        ((1, 1.3), {"1", "1.1", "1.2", "1.3"}),
    ],
)
def test_a_logarithmic_axis_of_few_decades_carries_plain_numbers_and_two_at_least(tmp_path, range_, shown):
    figure, (axes,) = new_figure(1)
    axes.plot(range_, [1, 2])
    axes.set_xscale("log")
    save_figure(figure, tmp_path / "figure.svg")
    low, high = axes.get_xlim()
    words = {label.get_text() for label in axes.get_xticklabels() if low <= label.get_position()[0] <= high}
    assert words >= shown
    assert any("10" in text and text != "10" for text in words) == any("⁻" in text for text in shown)


def logarithmic(low, high):
    _, (axes,) = new_figure(1)
    axes.set_xscale("log")
    axes.set_xlim(low, high)
    return axes.xaxis


@pytest.mark.parametrize(
    ("places", "ticks"),
    [
        ([4, 8], ["4", "8"]),
        ([2, 4, 6, 8], ["2", "4", "6", "8"]),
        # Others find no place, or are not whole.
        ([1, 1000, 1001], ["10⁰", "10¹", "10²", "10³"]),
        ([2.5, 5, 10], ["3", "5", "7", "10"]),
    ],
)
def test_a_logarithmic_axis_names_its_places_where_they_are_few_whole_numbers(places, ticks, tmp_path):
    data = xr.Dataset({"area": ("grid", [0.1] * len(places))}, {"points_per_wave": ("grid", places)})
    panel = Panel(marks=[Line(y="area")], x="points_per_wave", log="x")
    figure = draw(Figure(name="f", caption="c", panels=[panel]), data).figure
    save_figure(figure, tmp_path / "f.png", dpi=20)
    (axes,) = figure.axes
    low, high = axes.get_xlim()
    labels = [t.get_text() for t in axes.get_xticklabels() if low <= t.get_position()[0] <= high]
    assert labels == ticks
    assert not any(label.get_text() for label in axes.get_xticklabels(minor=True))


@pytest.mark.parametrize(("low", "high"), [(1e5, 1.5e6), (0.7e6, 1e7)])
def test_labels_at_the_ends_of_an_axis_count(low, high):
    axis = logarithmic(low, high)
    readable_ticks(axis)
    ticks = axis.get_majorticklocs()
    assert list(ticks[(low <= ticks) & (ticks <= high)]) == sorted(10 ** np.round(np.log10([low, high])))


def test_panels_of_different_decades_leave_the_highest_point_a_margin():
    data = xr.Dataset({"area": (("hurst", "reduced_pressure"), [[1e-4, 1e-5], [0.4, 0.2]])})
    data = data.assign_coords(hurst=[0.3, 0.8], reduced_pressure=[0.01, 0.02])
    panel = Panel(marks=[Line(y="area")], x="reduced_pressure", log="y")
    figure = Figure(name="areas", caption="", panels=panels_along(data, "hurst", panel))
    bottom, top = draw(figure, data).figure.axes[1].get_ylim()
    assert np.log(top / 0.4) > 0.03 * np.log(top / bottom)


def test_one_solve_tells_of_no_scatter(small_run):
    half = small_run.data.area_pixel_error.sel(source="grid")
    shifts = small_run.data.shifts
    assert np.isnan(half.where(shifts == 1)).all()
    assert (half.where(shifts > 1) > 0).sum() == (shifts > 1).sum()
    values = small_run.data.area_pixel_shift.sel(solver="bem", grid="24 x 16")
    student = 3.182446305284263  # three degrees of freedom, 97.5 %
    exact = student * values.std(ddof=1) / 2
    assert float(half.sel(solver="bem", grid="24 x 16")) == pytest.approx(float(exact), rel=1e-9)


def test_the_card_says_what_is_known_of_the_interval(small_run):
    (card,) = [card for card in small_run.page.answers if card.question == "How sure?"]
    assert "the scatter between surfaces is unknown" in card.basis
    share = float((small_run.data.area_error**2).sum() ** 0.5 / small_run.data.area)
    assert card.answer == f"+- {100 * share:.2g} %"
    unmeasured = small_run.data.assign(area_error=small_run.data.area_error * np.nan)
    (card,) = [card for card in run_views(unmeasured).cards if card.question == "How sure?"]
    assert (card.answer.text, "95 %" in card.basis.text) == ("not measured", False)


@pytest.mark.parametrize("name", ["area", "limit", "kappa"])
def test_a_study_counts_what_it_could_not_determine(name):
    known = xr.Dataset({name: ("load", [0.1, np.nan, np.nan])})
    known[f"{name}_error"] = (("load", "source"), [[0.1]] * 3)
    (said,) = _undetermined(known)
    assert said.startswith(f"2 of 3 values of '{name}' are not determinable")
    assert list(_undetermined(known.isel(load=[0]))) == []


def test_a_theory_without_an_answer_has_no_card():
    data = xr.Dataset({"area": ("load", [0.1, 0.2]), "area_persson": ("load", [np.nan, np.nan])})
    assert len([*_cards(data, Views(budget=("area",)))]) == 1
    known = data.assign(area_persson=("load", [0.1, np.nan]))
    *_, card = _cards(known, Views(budget=("area",)))
    assert card.question.startswith("How far from Persson")
