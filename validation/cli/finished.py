"""The commands that read what is finished: `audit`, `compare` and `store check`."""

from __future__ import annotations

import json
import re
from collections import Counter
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

import typer

from validation.cli import options
from validation.errors import RunFailed, UsageError


def audit(
    folder: options.FolderArgument,
    list_all: Annotated[bool, options.option("Name the numbers that agree, too.", "--list")] = False,
    as_json: options.JsonOption = False,
) -> None:
    """Compute every number of a result again from its fields, by other code.

    Tables, JSON, sentences, the page and the data of its figures are compared with what the fields say by
    definition; what is not computed again is listed. Exits with 1 where a number disagrees.
    """
    from validation.audit import audit as read
    from validation.cli.results import under_way

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
        list[Path], options.argument("DIR DIR...", "Results folders of one kind; the first leads.")
    ],
    output: options.OutputOption = None,
    with_report: options.ReportOption = True,
    as_json: options.JsonOption = False,
) -> None:
    """Put finished runs or studies side by side: what differs, and by how much.

    Differences are told in uncertainties. The first folder is what the others are compared with. Runs
    are compared with runs, sweeps with sweeps, and a study with the same study of other options.
    """
    from validation.cli.results import print_outputs, under_way
    from validation.comparison.compare import compare_folders

    names = "-".join(re.sub(r"[^A-Za-z0-9._-]", "-", folder.resolve().name) for folder in folders)
    target = output or Path("results") / f"compare-{names[:80]}"
    with under_way("comparing, drawing figures", quiet=as_json):
        outputs = compare_folders(folders, target, report=with_report)
    print_outputs(outputs, as_json=as_json)


store_app = typer.Typer(no_args_is_help=True, help="Verify stored solves, and set damaged ones aside.")


@store_app.command(
    epilog=options.examples(
        "fem-contact store check results/solves", "fem-contact store check results/mine --set-aside"
    )
)
def check(
    folder: Annotated[Path, options.argument("DIR", "Folder of finished solves, or the results of a run.")],
    list_all: Annotated[bool, options.option("Name the intact ones, too.", "--list")] = False,
    set_aside: Annotated[
        bool, options.option("Rename damaged files to *.corrupt; the next run repeats them.", "--set-aside")
    ] = False,
    as_json: options.JsonOption = False,
) -> None:
    """Verify every stored solve: its SHA-256, and that it is what its name says.

    Exits with 1 where a file is damaged and not set aside, or cannot be read.
    """
    from validation.execution.provenance import Made, made_words
    from validation.execution.solve import memory_words
    from validation.execution.store import Damaged, Sealed, check_store

    if not folder.is_dir():
        raise UsageError(f"{folder}: is no folder; name the folder of a store, such as results/solves")
    inner = folder / "solves"
    place = inner if inner.is_dir() and (folder / "result.json").exists() else folder
    rows: list[dict[str, Any]] = []
    intact: list[Made] = []
    size = damaged = 0
    for path, count, found in check_store(place, set_aside=set_aside):
        problem = None if isinstance(found, Sealed) else str(found).removeprefix(f"{path}: ")
        rows.append({"file": path, "bytes": count, "intact": problem is None, "problem": problem})
        about = f"{'damaged: ' if isinstance(found, Damaged) else ''}{problem}"
        damaged += isinstance(found, Damaged)
        if isinstance(found, Sealed):
            rows[-1] |= {"made": dict(found.made), "recipe": json.loads(found.recipe)}
            made, size = Made(**found.made), size + count
            intact.append(made)
            about = f"intact, {count} bytes, {made.finished[:16]} UTC on {made.host}, {made.seconds:.3g} s"
        if not as_json and (list_all or problem is not None):
            options.show(f"{path.name}: {about}")
    if as_json:
        options.print_json([{"made": None, "recipe": None, **row} for row in rows])
    else:
        options.show(f"{place}: {len(intact)} of {len(rows)} solves are intact ({memory_words(size)}).")
        for sentence in made_words(intact):
            options.show(sentence)
        if damaged and set_aside:
            options.show(f"{damaged} set aside as *.corrupt; the next run that needs them repeats them.")
        aside = len(list(place.glob("*.corrupt")))
        if aside:
            options.say(
                f"{place}: {aside} set aside as *.corrupt; remove them when you have looked", prefix="note: "
            )
    if wrong := len(rows) - len(intact) - damaged * set_aside:
        remedy = "--set-aside renames what is damaged, and the next run repeats it"
        raise RunFailed(f"{place}: {wrong} of {len(rows)} files are damaged or cannot be read; {remedy}")
