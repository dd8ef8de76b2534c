"""The commands that read finished results: `audit` and `compare`."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from validation.cli import options
from validation.errors import RunFailed, UsageError


def audit(
    folder: options.FolderArgument,
    list_all: Annotated[bool, options.option("--list", help="Name the numbers that agree, too.")] = False,
    as_json: options.JsonOption = False,
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
    except (OSError, ValueError, LookupError) as error:
        absent = Path(error.filename).name if isinstance(error, FileNotFoundError) else error
        why = f"no {absent} in it" if isinstance(error, (FileNotFoundError, KeyError)) else error
        raise UsageError(f"{folder}: cannot be audited: {why}; run it again, or name a result") from None
    if as_json:
        options.print_json({"entries": [asdict(entry) for entry in ledger.entries], "unread": ledger.unread})
    else:
        for entry in ledger.entries if list_all else ledger.wrong:
            options.show(str(entry))
        for line in dict.fromkeys(ledger.unread):
            options.show(f"not judged: {line}")
        agreeing = (entry.place for entry in ledger.entries if entry.agrees)
        files = (p if re.search(r"\.(json|csv|nc|html)\b", p) else "fields of the solves" for p in agreeing)
        for place, count in Counter(files).items():
            options.show(f"{place}: {count} agree")
    if ledger.wrong:
        raise RunFailed(
            f"{len(ledger.wrong)} of {len(ledger.entries)} numbers disagree with the stored fields"
        )


def compare(
    folders: Annotated[
        list[Path], typer.Argument(metavar="DIR DIR...", help="Results folders of one kind; the first leads.")
    ],
    output: options.OutputOption = None,
    with_report: options.ReportOption = True,
    as_json: options.JsonOption = False,
) -> None:
    """Put finished runs or studies side by side: what differs, and by how much.

    Differences are told in uncertainties. The first folder is what the others are compared with. Runs
    are compared with runs, sweeps with sweeps, and a study with the same study of other options.
    """
    from validation.cli.progress import under_way
    from validation.cli.results import print_outputs
    from validation.comparison.compare import compare_folders

    names = "-".join(re.sub(r"[^A-Za-z0-9._-]", "-", folder.resolve().name) for folder in folders)
    target = output or Path("results") / f"compare-{names[:80]}"
    with under_way("comparing, drawing figures", quiet=as_json):
        outputs = compare_folders(folders, target, report=with_report)
    print_outputs(outputs, as_json=as_json)
