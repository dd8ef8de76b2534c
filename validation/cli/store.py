"""The commands `fem-contact store`: check."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import typer

from validation.cli.options import JsonOption, examples, option, print_json, say, show
from validation.errors import RunFailed, UsageError

store_app = typer.Typer(no_args_is_help=True, help="Verify stored solves, and set damaged ones aside.")


@store_app.command(
    epilog=examples(
        "fem-contact store check results/solves", "fem-contact store check results/mine --set-aside"
    )
)
def check(
    folder: Annotated[
        Path, typer.Argument(metavar="DIR", help="Folder of finished solves, or the results of a run.")
    ],
    list_all: Annotated[bool, option("--list", help="Name the intact ones, too.")] = False,
    set_aside: Annotated[
        bool, option("--set-aside", help="Rename damaged files to *.corrupt; the next run repeats them.")
    ] = False,
    as_json: JsonOption = False,
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
            show(f"{path.name}: {about}")
    if as_json:
        print_json([{"made": None, "recipe": None, **row} for row in rows])
    else:
        show(f"{place}: {len(intact)} of {len(rows)} solves are intact ({memory_words(size)}).")
        for sentence in made_words(intact):
            show(sentence)
        if damaged and set_aside:
            show(f"{damaged} set aside as *.corrupt; the next run that needs them repeats them.")
        aside = len(list(place.glob("*.corrupt")))
        if aside:
            say(f"{place}: {aside} set aside as *.corrupt; remove them when you have looked", prefix="note: ")
    wrong = len(rows) - len(intact) - damaged * set_aside
    if wrong:
        remedy = "--set-aside renames what is damaged, and the next run repeats it"
        raise RunFailed(f"{place}: {wrong} of {len(rows)} files are damaged or cannot be read; {remedy}")
