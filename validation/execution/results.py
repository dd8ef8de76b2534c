"""What any act leaves in its folder: one dataset, and one record that says what it is and what it is of.

The record, ``result.json``, carries a SHA-256 of itself and of the dataset, ``data.nc``. Whoever reads
numbers of a folder (report, compare, notebook) reads them here; tables, figures and summary are made of
them and never read.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from validation.errors import RunFailed, UsageError
from validation.execution.store import read_numbers, write_numbers
from validation.files import digest_of, locked, read_record, write_record

if TYPE_CHECKING:
    import xarray as xr

RECORD, DATA = "result.json", "data.nc"
_FORMAT = "fem-contact result 1"
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


def write_results(
    folder: Path,
    data: xr.Dataset,
    *,
    kind: str,
    name: str,
    settings: Mapping[str, Any],
    store: Path,
    words: Sequence[str] = (),
) -> None:
    """Write dataset and record of an act into its folder, which the caller has locked; see `Result`."""
    record = {
        "format": _FORMAT,
        "kind": kind,
        "name": name,
        "asked": dict(settings),
        "words": list(words),
        "store": os.path.relpath(os.path.realpath(store), os.path.realpath(folder)),
    }
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
    places = {path.parent for place in (folder.parent, Path("results")) for path in place.glob(f"*/{RECORD}")}
    folders = sorted(map(str, places))
    raise UsageError(
        f"{folder}: holds no results ({RECORD}): run a scene or study first; results are in "
        + (", ".join(folders[:12]) + (", ..." if len(folders) > 12 else "") if folders else "no folder here")
    )
