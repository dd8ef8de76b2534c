"""The audit of values: a study agrees throughout, and each number of it that is blanked or moved is found."""

import copy
import math
import random
import re
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from gold.asked import STUDIES
from numpy.testing import assert_allclose
from scipy.special import stdtrit

from validation.audit import Ledger, dataset, values
from validation.audit.reductions import errors_of, recomputed
from validation.audit.values import page_tables, value_ledger
from validation.comparison.run import run_scene
from validation.report.quantities import registry
from validation.report.words import mathematics

SMALL = ("cross", "magnification", "scaling")
#: Every study; in the nightly tests those beyond the small ones.
EVERY = [*SMALL, *(pytest.param(name, marks=pytest.mark.nightly) for name in STUDIES if name not in SMALL)]


@pytest.fixture(scope="module")
def results(left, small_run, tmp_path_factory):
    root = tmp_path_factory.mktemp("values")

    class Results(dict[str, dataset.Result]):
        def __missing__(self, name):
            found = self[name] = dataset.Result(left(name, root / name))
            # Read once: what a test changes is a copy in memory.
            assert all((found.tables, found.figures, found.page))
            return found

    return Results(run=dataset.Result(small_run.folder))


class _Found(Exception):
    """An entry that disagrees."""


class _Agreeing(list):
    def append(self, entry):
        if not entry.agrees:
            raise _Found
        super().append(entry)


def finds(part, result):
    """Whether a part of the audit finds something wrong; it ends with the first that it finds."""
    try:
        part(result, Ledger(entries=_Agreeing()))
    except _Found:
        return True
    return False


def changed(result, name, value):
    other = copy.copy(result)
    other.__dict__[name] = value
    return other


@pytest.mark.parametrize("name", SMALL)
def test_every_number_of_a_study_follows_from_its_solves_or_is_listed(results, name):
    ledger = value_ledger(results[name])
    assert ledger.wrong == ()
    assert len(ledger.entries) > 100
    # What is asked for, and costs, is no result of a solve; findings say numbers of two places at once.
    odd = [line for line in ledger.unread if line.startswith("data.nc")]
    assert len(odd) <= 6, odd


#: What was once listed as unread.
JUDGED = {
    "refinement": {"area_each", "area_each_drift", "area_each_error, grid", "kappa_difference"},
    "hurst": {"area_by_bandwidth_each", "kappa_by_bandwidth_limit", "kappa_by_size_slope"},
}


@pytest.mark.parametrize("name", JUDGED)
def test_drifts_ladders_and_several_kinds_of_solves_of_one_study_are_told_apart(name, left, tmp_path):
    result, ledger = dataset.Result(left(name, tmp_path, report=False)), Ledger()
    values.judge_dataset(result, ledger)
    assert ledger.wrong == ()
    assert not JUDGED[name] & {line.removeprefix("data.nc: ") for line in ledger.unread}


@pytest.mark.parametrize("name", ["run", *EVERY])
def test_each_cell_of_a_table_that_is_blanked_or_moved_is_found(results, name):
    for file in results[name].tables:
        if not file.startswith("data"):
            part = values.judge_budget if file == "budget.csv" else values.judge_tables
            _damage_each_cell(results[name], file, part)


def test_of_nothing_no_error_is_a_part_of_the_budget_and_any_other_cannot_be_said(results):
    result = results["magnification"]
    name = result.summary["budget"][0]
    zero, halves = (xr.zeros_like(result.data[n]) for n in (name, f"{name}_error"))
    data = changed(result, "data", {**result.data, name: zero, f"{name}_error": halves})
    header, *lines = result.tables["budget.csv"]
    column = header.index("surfaces [%]")
    for share in ("0.0", "0.5"):
        rows = [[*line[:column], share, *line[column + 1 :]] for line in lines]
        ledger = Ledger()
        values.judge_budget(changed(data, "tables", {"budget.csv": [header, *rows]}), ledger)
        found = [one.agrees for one in ledger.entries if "surfaces" in one.name]
        assert (found[0] if found else None) == (share == "0.0"), ledger.entries[:4]


def test_how_far_other_treatments_of_a_map_move_its_area_is_judged(map_scene, tmp_path):
    heights = np.random.default_rng(3).standard_normal((32, 32))
    result = dataset.Result(run_scene(map_scene(heights), tmp_path / "out", report=False).folder)
    assert "treatment [%]" in result.tables["budget.csv"][0]
    _damage_each_cell(result, "budget.csv", values.judge_budget)


def _damage_each_cell(result, file, part):
    rows = result.tables[file]
    assert not finds(part, changed(result, "tables", {file: rows}))
    cells = list(np.ndindex(len(rows), len(rows[0]) if rows else 0))
    # Each is judged with its whole table: of one of hundreds of rows some are drawn.
    for i, j in random.Random(5).sample(cells, min(len(cells), 3000 // max(len(rows), 1))):
        try:
            number = float(rows[i][j])
        except ValueError:
            continue
        for wrong in ("" if math.isfinite(number) else "0.5", repr(number * (1 + 1e-6) + 1e-300)):
            if wrong == "nan" or float(wrong or "nan") == number:
                continue
            moved = copy.deepcopy(rows)
            moved[i][j] = wrong
            assert finds(part, changed(result, "tables", {file: moved})), (file, i, rows[0][j], wrong)


@pytest.mark.parametrize("name", ["run", *EVERY])
def test_each_number_of_the_summary_that_is_blanked_or_moved_is_found(results, name):
    numbers = results[name].summary["numbers"]
    for named, value in numbers.items():
        left = {"numbers": {other: numbers[other] for other in numbers if other != named}}
        assert finds(values.judge_numbers, changed(results[name], "summary", left)), named
        for key in ("value", "error"):
            if isinstance(value.get(key, ""), float):
                for wrong in (None, value[key] * (1 + 1e-6) + 1e-300):
                    summary = {"numbers": {**numbers, named: {**value, key: wrong}}}
                    changes = changed(results[name], "summary", summary)
                    assert finds(values.judge_numbers, changes), (named, key, wrong)


def test_an_interval_without_end_is_nothing_in_json(results):
    result = results["scaling"]
    endless = {"side_seconds_error": xr.full_like(result.data["side_seconds_error"], math.inf)}
    data = changed(result, "data", {**result.data, **endless})
    for interval, wrong in ((None, False), (0.5, True)):
        numbers = result.summary["numbers"]
        numbers = {**numbers, "side_seconds": {**numbers["side_seconds"], "error": interval}}
        assert finds(values.judge_numbers, changed(data, "summary", {"numbers": numbers})) == wrong


@pytest.mark.parametrize("name", ["run", *EVERY])
def test_each_value_of_a_finding_that_is_blanked_or_moved_is_found_or_was_listed(results, name):
    result = results[name]
    ledger = Ledger()
    values.judge_findings(result, ledger)
    listed = ledger.unread
    for k, finding in enumerate(result.summary["findings"]):
        groups = [("values", None), *(("rows", r) for r in range(len(finding.get("rows", ()))))]
        for kind, r in groups:
            group = finding.get(kind, {}) if r is None else finding["rows"][r]
            for named, value in group.items():
                said = f"finding {k + 1}: {named} = {value['value']}"
                if isinstance(value["value"], str) or said in listed:
                    continue
                unknown = value["value"] is None
                for wrong in (0.5,) if unknown else (None, value["value"] * (1 + 1e-6) + 1e-300):
                    summary = copy.deepcopy(result.summary)
                    of = summary["findings"][k]
                    (of[kind] if r is None else of[kind][r])[named]["value"] = wrong
                    changes = changed(result, "summary", summary)
                    assert finds(values.judge_findings, changes), (k, named, wrong)


@pytest.mark.parametrize("name", EVERY)
def test_each_variable_of_the_dataset_that_is_moved_somewhere_is_found_or_was_listed(results, name):
    result = results[name]
    listed = value_ledger(result).unread
    shown = set(result.figures and next(iter(result.figures.values())))
    for named, variable in result.data.items():
        numbers = variable.values
        if numbers.dtype.kind != "f" or not np.isfinite(numbers).any() or f"data.nc: {named}" in listed:
            continue
        if named in variable.dims or (named.endswith("_error") and named not in shown):
            continue
        least = 1e-9 * np.nanmax(np.abs(numbers))  # below it there is rounding
        places = np.argwhere(np.isfinite(numbers) & (np.abs(numbers) > least))
        for place in places[:: max(1, len(places) // 2)]:
            if "source" in variable.dims:
                source = result.data["source"].values[place[variable.dims.index("source")]]
                if f"data.nc: {named}, {source}" in listed:
                    continue
            moved = numbers.copy()
            moved[tuple(place)] *= 1.01
            first = {named: xr.Variable(variable.dims, moved, variable.attrs)}
            data = {**first, **result.data, **first}
            assert finds(values.judge_dataset, changed(result, "data", data)), (named, place)


def test_each_symbol_of_a_page_is_read_as_it_was_typed():
    for entry in registry()["quantities"].values():
        page = f'aria-label="Table: Numbers"><table><th>{mathematics(entry["symbol"])}</th></table>'
        assert page_tables(page)["Numbers"][0] == [entry["symbol"]]


@pytest.mark.parametrize("name", ["run", *EVERY])
def test_no_column_of_a_page_goes_unjudged(results, name):
    ledger = Ledger()
    values.judge_page(results[name], ledger)
    assert ledger.unread == []
    assert len(ledger.entries) > 5


@pytest.mark.parametrize("name", ["run", *EVERY])
def test_a_cell_of_the_page_that_is_moved_is_found(results, name):
    page, table = results[name].page, "Every grid" if name == "run" else "Numbers"
    start = page.index(f'aria-label="Table: {table}"')
    cells = list(re.finditer(r">(\d\.\d+)<", page[start:]))[:40]
    assert cells
    for cell in cells:
        value = float(cell[1])
        wrong = f">{value + 10 ** -(len(cell[1]) - 3):.{len(cell[1]) - 2}f}<"
        other = page[: start + cell.start()] + wrong + page[start + cell.end() :]
        assert finds(values.judge_page, changed(results[name], "page", other)), cell[1]


def test_means_of_infinite_samples_are_infinite_and_have_no_interval():
    """The stiffness of full contact is infinite."""
    each = xr.Variable(("load", "surface"), [[1.0, 3.0], [np.inf, np.inf], [2.0, np.nan]])
    made = {"reduction": "mean", "of": "each", "over": "surface"}
    result = SimpleNamespace(data={"each": each, "k": xr.Variable("load", [2.0, np.inf, np.nan], made)})
    assert_allclose(recomputed(result, "k"), [2.0, np.inf, np.nan])
    half = stdtrit(1, 0.975)
    assert_allclose(errors_of(result, "k")["surfaces"], [half, np.nan, np.nan])


def test_a_line_is_judged_where_another_has_a_gap():
    each = 2.0 + 0.5 * np.array([0.1, 0.2, 0.4])[:, None] + 0.01 * np.array([[-1, 1]]) * np.ones((2, 3, 1))
    each[1, 0, 0] = np.nan
    made = {"reduction": "line slope", "of": "each", "x": "x", "along": "rung", "over": "surface"}
    data = {
        "each": xr.Variable(("hurst", "rung", "surface"), each),
        "x": xr.Variable("rung", [0.1, 0.2, 0.4]),
    }
    data["slope"] = xr.Variable("hurst", [0.5, np.nan], made)
    assert_allclose(recomputed(SimpleNamespace(data=data), "slope"), [0.5, np.nan], rtol=1e-9)
