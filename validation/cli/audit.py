"""The command `fem-contact audit`."""

from __future__ import annotations

import json
import re
from collections import Counter
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from validation.cli.options import JsonOption, show
from validation.errors import RunFailed, UsageError

if TYPE_CHECKING:
    from validation.audit import Ledger

__all__ = ["audit"]


def audit(
    folder: Annotated[
        Path, typer.Argument(metavar="DIR", help="Results folder of a run, a sweep or a study.")
    ],
    list_all: Annotated[
        bool, typer.Option("--list", metavar="", help="Name the numbers that agree, too.")
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Compute every number of a result again from its fields, by other code.

    Tables, JSON, sentences, the page and the data of its figures are compared with what the fields say by
    definition; what is not computed again is listed. Exits with 1 where a number disagrees.
    """
    from validation.audit import audit as read
    from validation.cli.progress import under_way

    try:
        with under_way("computing the numbers again", quiet=as_json):
            ledger = read(folder)
    except KeyError as error:
        raise UsageError(f"{folder}: cannot be audited: no {error} in it; run the scene again") from None
    except FileNotFoundError as error:
        missing = Path(error.filename).name
        why = f"no {missing} in it; name the results of a run"
        raise UsageError(f"{folder}: cannot be audited: {why}") from None
    except (OSError, ValueError, LookupError) as error:
        raise UsageError(f"{folder}: cannot be audited: {error}; name the results of a run") from None
    if as_json:
        entries = [asdict(entry) for entry in ledger.entries]
        typer.echo(json.dumps({"entries": entries, "unread": ledger.unread}, indent=2, default=str))
    else:
        _show(ledger, list_all=list_all)
    if ledger.wrong:
        raise RunFailed(
            f"{len(ledger.wrong)} of {len(ledger.entries)} numbers disagree with the stored fields"
        )


def _show(ledger: Ledger, *, list_all: bool) -> None:
    """Print what disagrees, what was not judged, and how much agrees where."""
    for entry in ledger.entries if list_all else ledger.wrong:
        show(str(entry))
    for line in dict.fromkeys(ledger.unread):
        show(f"not judged: {line}")
    agreeing = Counter(entry.place for entry in ledger.entries if entry.agrees)
    files = {place: n for place, n in agreeing.items() if re.search(r"\.(json|csv|nc|html)\b", place)}
    rest = sum(agreeing.values()) - sum(files.values())
    for place, count in {**files, **({"fields of the solves": rest} if rest else {})}.items():
        show(f"{place}: {count} agree")
