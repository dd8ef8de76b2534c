"""The verbs of `fem-contact challenge`: problems for solvers in any language, and their score."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from validation.cli.options import JsonOption, examples, say

challenge_app = typer.Typer(no_args_is_help=True, help="Score a solver in any language, by files.")


@challenge_app.command(epilog=examples("fem-contact challenge export mine"))
def export(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Folder to write the problems into.")],
    points: Annotated[
        int, typer.Option(metavar="N", min=16, max=128, help="Along a side of the coarsest grids.")
    ] = 16,
    tolerance: Annotated[
        float, typer.Option(metavar="T", min=1e-12, max=1e-2, help="Largest residual.")
    ] = 1e-6,
) -> None:
    """Write numbered problems, and what to return for each.

    Heights as .npy and text, every parameter with its unit.
    """
    from validation.cases.scorecard.challenge import export as write
    from validation.files import prepare_folder

    count = write(prepare_folder(folder), points=points, tolerance=tolerance)
    typer.echo(
        f"{folder}: {count} problems; their answers are scored by: fem-contact challenge score {folder}"
    )


@challenge_app.command(epilog=examples("fem-contact challenge score mine"))
def score(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Folder of problems, with answers to some.")],
    as_json: JsonOption = False,
) -> None:
    """Score the answers of a folder, all or some; exit with 1 if a row fails."""
    from validation.cases._result import write_scorecards
    from validation.cases.scorecard.challenge import score_folder
    from validation.cli.validate import show_scorecards

    card = score_folder(folder, tell=None if as_json else lambda line: say(line, prefix=""))
    show_scorecards([card], write_scorecards(folder, [card]).files, as_json=as_json)
