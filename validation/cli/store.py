"""The commands `fem-contact store`: check."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from validation.cli.options import JsonOption, examples, say, show, stopping_cleanly
from validation.errors import RunFailed, UsageError

if TYPE_CHECKING:
    from validation.execution.store import Checked

__all__ = ["store_app"]

store_app = typer.Typer(no_args_is_help=True)


@store_app.command(
    epilog=examples(
        "fem-contact store check results/solves", "fem-contact store check results/mine --set-aside"
    )
)
def check(
    folder: Annotated[
        Path, typer.Argument(metavar="DIR", help="Folder of finished solves, or the results of a run.")
    ],
    list_all: Annotated[bool, typer.Option("--list", metavar="", help="Name the intact ones, too.")] = False,
    set_aside: Annotated[
        bool,
        typer.Option(
            "--set-aside", metavar="", help="Rename damaged files to *.corrupt; the next run repeats them."
        ),
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Verify every stored solve: its SHA-256, and that it is what its name says.

    Exits with 1 where a file is damaged and not set aside, or cannot be read.
    """
    from validation.execution.store import check_store

    place = _store_in(folder)
    found: list[Checked] = []
    with stopping_cleanly():
        for one in check_store(place, set_aside=set_aside):
            found.append(one)
            if not as_json and (list_all or one.problem is not None):
                show(_line(one))
    if as_json:
        typer.echo(json.dumps([_summary(one) for one in found], indent=2))
    wrong = [one for one in found if one.problem is not None and not (one.damaged and set_aside)]
    if not as_json:
        _sum_up(found, place, set_aside=set_aside)
    if wrong:
        remedy = "--set-aside renames what is damaged, and the next run repeats it"
        raise RunFailed(
            f"{place}: {len(wrong)} of {len(found)} files are damaged or cannot be read; {remedy}"
        )


def _store_in(folder: Path) -> Path:
    """Return the store of a results folder, or the folder itself."""
    if not folder.is_dir():
        raise UsageError(f"{folder}: is no folder; name the folder of a store, such as results/solves")
    inner = folder / "solves"
    ours = (folder / "result.json").exists()
    return inner if inner.is_dir() and ours else folder


def _line(one: Checked) -> str:
    if one.problem is not None:
        return f"{one.path.name}: {'damaged: ' if one.damaged else ''}{one.problem}"
    made = one.made
    how = "" if made is None else f", {made.finished[:16]} UTC on {made.host}, {made.seconds:.3g} s"
    return f"{one.path.name}: intact, {one.size} bytes{how}"


def _summary(one: Checked) -> dict[str, object]:
    return {
        "file": str(one.path),
        "bytes": one.size,
        "intact": one.problem is None,
        "problem": one.problem,
        "made": None if one.made is None else one.made.as_json(),
        "recipe": None if one.recipe is None else json.loads(one.recipe),
    }


def _sum_up(found: list[Checked], place: Path, *, set_aside: bool) -> None:
    from validation.execution.cost import memory_words
    from validation.execution.provenance import made_words

    intact = [one for one in found if one.problem is None]
    size = memory_words(sum(one.size for one in intact))
    show(f"{place}: {len(intact)} of {len(found)} solves are intact ({size}).")
    for sentence in made_words(one.made for one in intact if one.made is not None):
        show(sentence)
    damaged = sum(one.damaged for one in found)
    if damaged and set_aside:
        show(f"{damaged} set aside as *.corrupt; the next run that needs them repeats them.")
    aside = len(list(place.glob("*.corrupt")))
    if aside:
        say(f"{place}: {aside} set aside as *.corrupt; remove them when you have looked", prefix="note: ")
