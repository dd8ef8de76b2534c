"""Results folders side by side: what each was asked, what it found, and how far apart they are.

Everything is read from what the folders hold (records, tables, figure data); nothing here solves.
"""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from validation.errors import UsageError

__all__ = ["Beside", "Number", "Result", "Row", "beside", "read_result"]

#: Numbers by what they are and where: (values of the key columns, quantity).
Where = tuple[tuple[str, ...], str]
_RECORDS = {"run.json": "run", "sweep.json": "sweep", "study.json": "study"}
#: Of a table without uncertainties, columns that may say what a row is.
_MOST_KEYS = 2


@dataclass(frozen=True, kw_only=True)
class Number:
    """A value and its uncertainty, NaN where it has none."""

    value: float
    error: float = math.nan


@dataclass(frozen=True, kw_only=True, eq=False)
class Result:
    """What one results folder holds.

    Attributes
    ----------
    label : str
        Names it among the others.
    kind : str
        "run", "theory", "sweep" or "study NAME"; only results of one kind are compared.
    folder : Path
    settings : mapping of str to str
        Everything that was asked for, by dotted key.
    columns, cells : tuples
        Its table as it was written; a run has one row.
    summary : mapping
        Its summary.json.
    """

    label: str
    kind: str
    folder: Path
    settings: Mapping[str, str]
    columns: tuple[str, ...]
    cells: tuple[tuple[str, ...], ...]
    summary: Mapping[str, Any]

    @cached_property
    def errors(self) -> dict[int, tuple[int, ...]]:
        """Columns with the uncertainty of a column: "+-" follows its value, x_error belongs to x."""
        found: dict[int, tuple[int, ...]] = {}
        value = 0
        for k, name in enumerate(self.columns):
            stem = name.removesuffix("_error")
            if "+-" in name:
                found[value] = (*found.get(value, ()), k)
            elif stem != name and stem in self.columns:
                found[self.columns.index(stem)] = (k,)
            else:
                value = k
        return found

    def column(self, name: str) -> tuple[str, ...]:
        """Cells of a column."""
        k = self.columns.index(name)
        return tuple(row[k] for row in self.cells)


@dataclass(frozen=True, kw_only=True)
class Row:
    """One quantity of all results.

    Attributes
    ----------
    where : tuple of str
        Values of the key columns.
    quantity : str
    numbers : tuple of Number
        One for each result.
    """

    where: tuple[str, ...]
    quantity: str
    numbers: tuple[Number, ...]

    def apart(self, k: int) -> Number:
        """Return the k-th less the first, and the root of the sum of their squared uncertainties."""
        first, other = self.numbers[0], self.numbers[k]
        # What is computed twice may differ in its last digit.
        equal = math.isclose(first.value, other.value, rel_tol=1e-14)
        difference = 0.0 if equal else other.value - first.value
        return Number(value=difference, error=math.hypot(first.error, other.error))

    def units(self, k: int) -> float:
        """Return that difference in units of that uncertainty; NaN where there is none."""
        apart = self.apart(k)
        if apart.value == 0:
            return 0.0 if math.isfinite(apart.error) else math.nan
        return apart.value / apart.error if apart.error > 0 else math.nan

    @property
    def uncertain(self) -> bool:
        """Whether every number has an uncertainty."""
        return all(math.isfinite(number.error) for number in self.numbers)


@dataclass(frozen=True, kw_only=True, eq=False)
class Beside:
    """Results of one kind, side by side.

    Attributes
    ----------
    results : tuple of Result
        The first is what the others are compared with.
    keys : tuple of str
        Columns that say what a row of a table is; none for runs.
    rows : tuple of Row
        Numbers that all of them have, those with an uncertainty first.
    left_out : tuple of str
        A line for each folder that cannot be compared.
    """

    results: tuple[Result, ...]
    keys: tuple[str, ...]
    rows: tuple[Row, ...]
    left_out: tuple[str, ...]

    @property
    def labels(self) -> tuple[str, ...]:
        """How the results are called."""
        return tuple(result.label for result in self.results)

    @cached_property
    def differing(self) -> dict[str, tuple[str, ...]]:
        """Settings that differ, each with its value in every result; "" where it has none."""
        keys = dict.fromkeys(key for result in self.results for key in result.settings)
        values = {key: tuple(result.settings.get(key, "") for result in self.results) for key in keys}
        return {key: each for key, each in values.items() if len(set(each)) > 1}

    @property
    def one_surface(self) -> bool:
        """Whether all of them press the same surface, or are studies of the same ones."""
        surface = ("surface.", "seed", "surfaces", "pairs", "ensemble.")
        return not any(key.startswith(surface) for key in self.differing)


def beside(folders: Sequence[Path]) -> Beside:
    """Read results folders and pair their numbers.

    Parameters
    ----------
    folders : sequence of Path
        At least two; the first that can be read says what is compared.

    Raises
    ------
    UsageError
        Where fewer than two can be compared, with the reason for each that cannot.
    """
    if len({folder.resolve() for folder in folders}) < max(2, len(folders)):
        raise UsageError("compare: needs at least two results folders, each named once")
    results: list[Result] = []
    left_out: list[str] = []
    for folder, label in zip(folders, _labels(folders), strict=True):
        found = read_result(folder, label=label)
        if isinstance(found, str):
            left_out.append(f"{folder}: not compared: {found}")
        elif results and found.kind != results[0].kind:
            left_out.append(
                f"{folder}: not compared: it is a {_kind_words(found.kind)}, and {results[0].folder} "
                f"is a {_kind_words(results[0].kind)}"
            )
        else:
            results.append(found)
    if len(results) < 2:
        raise UsageError(
            "; ".join(left_out) + "; fewer than two folders are left: name results folders of one kind"
        )
    keys = _keys(results)
    rows = tuple(_rows(results, keys))
    if not rows:
        raise UsageError(
            f"{', '.join(str(result.folder) for result in results)}: their tables share no row; compare "
            "results with common values of their first column"
        )
    return Beside(results=tuple(results), keys=keys, rows=rows, left_out=tuple(left_out))


def _kind_words(kind: str) -> str:
    return {"theory": "run of the theory alone"}.get(kind, kind)


def _labels(folders: Sequence[Path]) -> list[str]:
    """Name folders by as much of their paths as tells them apart."""
    parts = [folder.resolve().parts for folder in folders]
    for length in range(1, max(map(len, parts)) + 1):
        names = ["/".join(each[-length:]) for each in parts]
        if len(set(names)) == len(names):
            return names
    return [str(folder) for folder in folders]


def read_result(folder: Path, *, label: str) -> Result | str:
    """Read one results folder, or say in words why it cannot be compared."""
    record = next((name for name in _RECORDS if (folder / name).exists()), None)
    if record is None:
        return "it holds no run, sweep or study"
    try:
        said = json.loads((folder / record).read_text(encoding="utf-8"))
        summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
        kind, settings = _asked(said, _RECORDS[record])
        if kind in ("run", "theory"):
            columns, cells = _run_table(summary) if kind == "run" else _theory_table(summary)
        else:
            columns, cells = _read_table(folder)
    except FileNotFoundError as error:
        return f"{Path(error.filename).name} is missing; run it to its end"
    except (OSError, ValueError, KeyError, TypeError, IndexError) as error:
        return f"its record cannot be read ({error}); run it again"
    return Result(
        label=label,
        kind=kind,
        folder=folder,
        settings=settings,
        columns=columns,
        cells=cells,
        summary=summary,
    )


def _asked(said: Mapping[str, Any], kind: str) -> tuple[str, dict[str, str]]:
    """Return the kind of a record in full, and its settings by dotted key."""
    if kind == "study":
        return f"study {said['study']}", dict(_flat(said["options"]))
    scene = {key: value for key, value in said["scene"].items() if key not in ("name", "title", "run")}
    settings = dict(_flat(scene))
    if kind == "sweep":
        for key in said["keys"]:
            settings.pop(key["key"], None)
            settings["sweep." + key["key"]] = _word(key["values"])
        return kind, settings
    return (kind if set(scene["methods"]) - {"theory"} else "theory"), settings


def _flat(tree: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, str]]:
    """Yield dotted keys and their values in words; effects are named by their kind."""
    for key, value in tree.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{before}{key}.")
        elif isinstance(value, list) and value and all(isinstance(item, Mapping) for item in value):
            for item in value:
                name = item.get("kind", "")
                yield f"{before}{key}.{name}", "listed"
                yield from _flat({k: v for k, v in item.items() if k != "kind"}, f"{before}{key}.{name}.")
        else:
            yield before + key, _word(value)


def _word(value: Any) -> str:
    if isinstance(value, list):
        return ", ".join(map(_word, value))
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _read_table(folder: Path) -> tuple[tuple[str, ...], tuple[tuple[str, ...], ...]]:
    """Read table.csv, or data.csv of a study without a table; columns of one name are numbered."""
    path = folder / "table.csv"
    with (path if path.exists() else folder / "data.csv").open(newline="", encoding="utf-8") as file:
        head, *rows = csv.reader(file)
    names: list[str] = []
    for k, name in enumerate(head):
        count = head[:k].count(name) + 1
        names.append(name if count == 1 else f"{name} ({count})")
    return tuple(names), tuple(tuple(row) for row in rows)


def _run_table(summary: Mapping[str, Any]) -> tuple[tuple[str, ...], tuple[tuple[str, ...], ...]]:
    """Lay the headline numbers of a run out as a table of one row."""
    cells: dict[str, float] = {}
    load, limit, theory = summary["reduced_pressure"], summary["limit"], summary["theory"]
    area = None if theory is None else theory["area"]
    if limit is not None:
        value, error = limit["value"], limit["uncertainty"]
        cells |= {"A/A0 limit": value, "A/A0 limit +-": error}
        cells |= {"kappa limit": value / load, "kappa limit +-": error / load}
        if area:
            cells |= {"limit over Persson": value / area, "limit over Persson +-": error / area}
    if summary["scatter"] is not None:
        ratios = np.array(summary["scatter"]["ratios"])
        cells["mean over Persson" if area else "mean A/A0"] = float(ratios.mean())
        cells["mean +-"] = float(ratios.std(ddof=1) / math.sqrt(ratios.size))
    resolved = [row for row in summary["rows"] if not row["under_resolved"]]
    finest = max(resolved or summary["rows"], key=lambda row: row["points_per_wave"])
    cells["A/A0 perimeter, finest grid"] = finest["perimeter"]
    if finest["plastic"] is not None:
        cells["A_pl/A0, finest grid"] = finest["plastic"]
    if area is not None:
        cells["A/A0 Persson"] = area
        if theory["plastic"] is not None:
            cells["A_pl/A0 Persson"] = theory["plastic"]
    cells["p*"] = load
    cells["seconds"] = sum(row["seconds"] for row in summary["rows"])
    return tuple(cells), (tuple(map(repr, cells.values())),)


def _theory_table(summary: Mapping[str, Any]) -> tuple[tuple[str, ...], tuple[tuple[str, ...], ...]]:
    """Lay the answers of the theory out, one row for each load."""
    names = {"pressure_Pa": "p0 [Pa]", "area": "A/A0", "plastic": "A_pl/A0"}
    kept = {key: words for key, words in names.items() if key in summary["answers"][0]}
    rows = ([answer[key] for key in kept] for answer in summary["answers"])
    return tuple(kept.values()), tuple(tuple("" if v is None else repr(v) for v in row) for row in rows)


def _keys(results: Sequence[Result]) -> tuple[str, ...]:
    """Return the columns that say what a row is: before all values, with cells that the tables share."""
    if results[0].kind == "run":
        return ()
    first = results[0]
    common = [name for name in first.columns if all(name in other.columns for other in results)]
    values = [first.columns.index(name) for name in common if first.columns.index(name) in first.errors]
    end = min(values, default=_MOST_KEYS)
    keys = []
    for name in common:
        shared = set.intersection(*(set(map(_plain, result.column(name))) for result in results))
        if first.columns.index(name) < end and shared:
            keys.append(name)
    return tuple(keys)


def _plain(cell: str) -> str:
    """Return a cell as it is compared: numbers to nine digits."""
    try:
        return f"{float(cell):.9g}"
    except ValueError:
        return cell


def _rows(results: Sequence[Result], keys: Sequence[str]) -> Iterator[Row]:
    """Yield the numbers that all results have, those with an uncertainty first."""
    each = [_numbers(result, keys) for result in results]
    shared = [where for where in each[0] if all(where in numbers for numbers in each[1:])]
    rows = [
        Row(where=where, quantity=name, numbers=tuple(numbers[where, name] for numbers in each))
        for where, name in shared
    ]
    order = {name: k for k, name in enumerate(results[0].columns)}
    yield from sorted(rows, key=lambda row: (not row.uncertain, order[row.quantity]))


def _numbers(result: Result, keys: Sequence[str]) -> dict[Where, Number]:
    """Return the numbers of a table by key and quantity; of rows with one key the first."""
    places = [result.columns.index(key) for key in keys]
    errors = {k for several in result.errors.values() for k in several}
    found: dict[Where, Number] = {}
    for row in result.cells:
        where = tuple(_plain(row[k]) for k in places)
        for k, name in enumerate(result.columns):
            value = _float(row[k])
            if k in places or k in errors or not math.isfinite(value):
                continue
            parts = [_float(row[j]) for j in result.errors.get(k, ())]
            error = math.hypot(*parts) if parts else math.nan
            found.setdefault((where, name), Number(value=value, error=error))
    return found


def _float(cell: str) -> float:
    try:
        return float(cell)
    except ValueError:
        return math.nan
