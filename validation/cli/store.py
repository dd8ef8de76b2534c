"""The commands `fem-contact store`: check."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from validation.cli.options import JsonOption, examples, option, print_json, say, show
from validation.errors import RunFailed, UsageError

if TYPE_CHECKING:
    from validation.execution.store import Checked

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
    from validation.execution.provenance import made_words
    from validation.execution.solve import memory_words
    from validation.execution.store import check_store

    if not folder.is_dir():
        raise UsageError(f"{folder}: is no folder; name the folder of a store, such as results/solves")
    inner = folder / "solves"
    place = inner if inner.is_dir() and (folder / "result.json").exists() else folder
    files: list[Checked] = []
    for file in check_store(place, set_aside=set_aside):
        files.append(file)
        made, about = file.made, f"{'damaged: ' if file.damaged else ''}{file.problem}"
        if made is not None:
            done = f"{made.finished[:16]} UTC on {made.host}, {made.seconds:.3g} s"
            about = f"intact, {file.size} bytes, {done}"
        if not as_json and (list_all or made is None):
            show(f"{file.path.name}: {about}")
    damaged, intact = sum(file.damaged for file in files), [file for file in files if file.problem is None]
    if as_json:
        print_json(
            [
                {
                    "file": file.path,
                    "bytes": file.size,
                    "intact": file.problem is None,
                    "problem": file.problem,
                    "made": file.made and asdict(file.made),
                    "recipe": file.recipe and json.loads(file.recipe),
                }
                for file in files
            ]
        )
    else:
        size = memory_words(sum(file.size for file in intact))
        show(f"{place}: {len(intact)} of {len(files)} solves are intact ({size}).")
        for sentence in made_words(file.made for file in intact if file.made is not None):
            show(sentence)
        if damaged and set_aside:
            show(f"{damaged} set aside as *.corrupt; the next run that needs them repeats them.")
        aside = len(list(place.glob("*.corrupt")))
        if aside:
            say(f"{place}: {aside} set aside as *.corrupt; remove them when you have looked", prefix="note: ")
    wrong = sum(file.problem is not None and not (file.damaged and set_aside) for file in files)
    if wrong:
        remedy = "--set-aside renames what is damaged, and the next run repeats it"
        raise RunFailed(f"{place}: {wrong} of {len(files)} files are damaged or cannot be read; {remedy}")
