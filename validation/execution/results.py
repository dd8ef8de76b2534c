"""What any act leaves in its folder: one dataset, one record that says what it is and of what, and its page.

The record, ``result.json``, carries a SHA-256 of itself and of the dataset, ``data.nc``. Whoever reads
numbers of a folder (report, compare, notebook) reads them here; its page, tables, figures and summary, is
made of them alone, now or again, and never read.
"""

from __future__ import annotations

import contextlib
import json
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import xarray as xr

from validation.errors import RunFailed, UsageError
from validation.execution.store import read_numbers, write_numbers
from validation.files import digest_of, locked, read_record, write_record
from validation.report.page import RECORD, Page, standing_page, write_page

DATA = "data.nc"
_FORMAT = "fem-contact result 2"
#: Records of earlier versions.
_EARLIER = ("run.json", "sweep.json", "study.json", "accuracy.json")


@dataclass(frozen=True, kw_only=True, eq=False)
class Result:
    """What a results folder holds: the numbers of a run, theory, sweep, study, accuracy or other `kind`.

    `settings` is everything that was asked for, ready for JSON, `words` sentences that a reader should know.
    """

    kind: str
    name: str
    settings: Mapping[str, Any]
    store: Path
    data: xr.Dataset
    words: tuple[str, ...] = ()


def write_results(folder: Path, data: xr.Dataset, **about: Any) -> None:
    """Write dataset and record of an act into its folder, which the caller has locked; see `Result`.

    Where it holds both already they stay as they are.
    """
    result = Result(data=data, **about)
    record = {
        "format": _FORMAT,
        "kind": result.kind,
        "name": result.name,
        "asked": dict(result.settings),
        "words": list(result.words),
        "store": os.path.relpath(os.path.realpath(result.store), os.path.realpath(folder)),
    }
    with contextlib.suppress(UsageError):
        asked = json.loads(json.dumps(record))
        if record_of(folder).items() >= asked.items() and read_results(folder).data.identical(data):
            return
    clear_results(folder)
    write_numbers(folder / DATA, data, recipe=record)
    write_record(folder / RECORD, {**record, "data": digest_of(folder / DATA)})


def clear_results(folder: Path) -> None:
    """Take dataset and record out of a folder, and records of earlier versions."""
    for name in (*_EARLIER, RECORD, DATA):
        (folder / name).unlink(missing_ok=True)


def record_of(folder: Path) -> Mapping[str, Any]:
    """Return the record of a folder if it is sound and of this version, else nothing."""
    with contextlib.suppress(OSError, ValueError):
        record = read_record(folder / RECORD)
        if record.get("format") == _FORMAT:
            return record
    return {}


def read_results(folder: Path) -> Result:
    """Return what a folder holds, verified; a UsageError where it is no finished result of this version."""
    try:
        with locked(folder, shared=True):
            record = read_record(folder / RECORD)
            if record["format"] != _FORMAT:
                raise ValueError(f"{RECORD} is not of this version")
            if record["data"] != digest_of(folder / DATA):
                raise ValueError(f"{DATA}: damaged: it is not what {RECORD} was written for")
            data = read_numbers(folder / DATA)
        return Result(
            kind=record["kind"],
            name=record["name"],
            settings=record["asked"],
            store=Path(os.path.realpath(folder / record["store"])),
            data=data,
            words=tuple(record["words"]),
        )
    except RunFailed as error:
        raise UsageError(str(error)) from None
    except NotADirectoryError:
        raise UsageError(f"{folder}: is a file; name the folder of results") from None
    except FileNotFoundError as error:
        old = next((name for name in _EARLIER if (folder / name).exists()), "")
        why = f"{old} is of an earlier version" if old else f"no {Path(error.filename).name} in it"
        raise UsageError(f"{folder}: holds no finished results ({why}); run it again") from None
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise UsageError(f"{folder}: holds no finished results ({error}); run it again") from None


def check_results(folder: Path) -> None:
    """Refuse a folder that holds no results by a UsageError, which names those beside it that do."""
    if any((folder / name).exists() for name in (RECORD, *_EARLIER)):
        return
    places = (path.parent for place in (folder.parent, Path("results")) for path in place.glob(f"*/{RECORD}"))
    folders = sorted({*map(str, places)}) or ["no folder here"]
    more = ", ..." if len(folders) > 12 else ""
    raise UsageError(
        f"{folder}: holds no results ({RECORD}): run a scene or study first; results are in "
        f"{', '.join(folders[:12])}{more}"
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class Outputs:
    """What an act left behind.

    Of the `files` a reader may want to open the report is first. Of the solves `solved` were done now and
    `reused` found finished; `failures` say why others failed, and what to do; `more` is what a
    run to an accuracy says of what it reached.
    """

    result: Result
    page: Page
    folder: Path
    files: tuple[Path, ...]
    solved: int = 0
    reused: int = 0
    failures: tuple[str, ...] = ()
    more: tuple[str, ...] = ()

    @property
    def data(self) -> xr.Dataset:
        """Every number."""
        return self.result.data

    def check(self) -> None:
        """Raise `RunFailed` where solves failed, which are rows of the report without numbers."""
        if self.failures:
            failures = "\n".join(f"  {why}" for why in self.failures)
            raise RunFailed(f"not all solves succeeded, the report is of the others:\n{failures}")


def leave(
    folder: Path,
    data: xr.Dataset,
    page_of: Callable[..., Page],
    *,
    report: bool,
    anew: bool = False,
    **record: Any,
) -> Outputs:
    """Write dataset and record (`write_results`) of an act into its folder, and `show` them."""
    with locked(folder):
        write_results(folder, data, **record)
        return show(folder, page_of, report=report, anew=anew)


def show(folder: Path, page_of: Callable[..., Page], *, report: bool = True, anew: bool = True) -> Outputs:
    """Write the page of what a folder holds; without `report` tables and JSON alone.

    `page_of` makes the page of a `Result`, drawn or not (`figures`). Unless it is to be made `anew`, a page
    that shows this already, whole and younger than the code that makes it, stays.

    A UsageError for a folder that holds no finished results of this version, or others than `page_of` shows.
    """
    with locked(folder):
        result = read_results(folder)
        written = () if anew else standing_page(folder, numbers_only=not report)
        page = page_of(result, figures=report and not written)
        written = written or write_page(page, folder, numbers_only=not report)
        return Outputs(result=result, page=page, folder=folder, files=(*written, folder / DATA))
