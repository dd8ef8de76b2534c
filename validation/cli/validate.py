"""The commands that hold code and paper against known numbers: `validate`, `challenge`, `reproduce`."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from validation.cli.options import (
    JsonOption,
    OutputOption,
    QuietOption,
    ReportOption,
    argument,
    examples,
    option,
    print_json,
    say,
)
from validation.errors import RunFailed, UsageError
from validation.report.words import json_ready

if TYPE_CHECKING:
    from validation.cases.scorecard import Scorecard


ToleranceOption = Annotated[
    float, typer.Option(metavar="T", min=1e-12, max=1e-2, help="Of a scored solver: largest residual.")
]


def validate(
    names: Annotated[list[str] | None, argument("CASE", "Cases to run; all if not given.")] = None,
    quick: Annotated[bool, option("Only what takes seconds; under three minutes.", "--quick")] = False,
    list_all: Annotated[bool, option("Name the cases and their claims.", "--list")] = False,
    method: Annotated[
        list[str] | None,
        option("Score this solver: a method, or a module:function of yours.", metavar="NAME"),
    ] = None,
    seconds: Annotated[
        float,
        typer.Option("--seconds", metavar="S", min=1.0, help="With --method: for all solves of a solver."),
    ] = 300.0,
    tolerance: ToleranceOption = 1e-6,
    output: OutputOption = None,
    with_report: ReportOption = True,
    as_json: JsonOption = False,
) -> None:
    """Check every case with a known answer; score a solver.

    Exits with 1 if a case fails. The verdicts go to results/validation. With --method, a scorecard of that
    solver is written instead; further ones stand beside the first.
    """
    from validation.cases import chosen_cases, run_cases
    from validation.cases._result import write_claims, write_scorecards
    from validation.cases.scorecard import Subject, score
    from validation.cli.results import print_outputs
    from validation.files import prepare_folder
    from validation.solvers import chosen_solver

    tell = None if as_json else lambda line: say(line, prefix="")
    if method:
        if names:
            raise UsageError(f"--method scores a solver by all rows; leave out {', '.join(names)}")
        limits: dict[str, Any] = {"tolerance": tolerance, "quick": quick, "seconds": seconds}
        chosen, cards = {name: chosen_solver(name) for name in method}, []
        plain = re.sub(r"[^A-Za-z0-9._-]", "-", method[0])
        folder = prepare_folder(output or Path("results") / f"scorecard-{plain}")
        for name, (solver, settings) in chosen.items():
            if not as_json:
                typer.echo(f"{name}:")
            cards.append(score(Subject(name=name, solver=solver, settings=settings, **limits), tell=tell))
        show_scorecards(cards, write_scorecards(folder, cards, report=with_report).files, as_json=as_json)
        return
    cases = chosen_cases(names or [], quick=quick)
    if list_all:
        for case in cases:
            typer.echo(f"{case.name:28s} {'quick' if case.quick else 'long '}  {case.claim}")
        return
    folder = prepare_folder(output or Path("results") / "validation")
    verdicts = tuple(run_cases(cases, tell=tell))
    failed_first = sorted(verdicts, key=lambda verdict: verdict.passed)
    asked = {"cases": list(names or []), "quick": quick}
    outputs = write_claims(folder, failed_first, name="validate", settings=asked, report=with_report)
    if as_json:
        print_json([verdict.summary() for verdict in verdicts])
    else:
        print_outputs(outputs)
    if failed := [verdict.case for verdict in verdicts if verdict.word == "FAILS"]:
        raise RunFailed(f"{len(failed)} of {len(verdicts)} cases failed: {', '.join(failed)}")


def show_scorecards(cards: Sequence[Scorecard], files: Iterable[Path], *, as_json: bool) -> None:
    """Print what scorecards come to; fail where the first of them does."""
    if as_json:
        print_json(json_ready({"scorecards": [card.summary() for card in cards]}))
    else:
        for path in files:
            typer.echo(f"  {path}")
    if cards[0].failed:
        raise RunFailed(cards[0].sentence)
    if not as_json:
        typer.echo(cards[0].sentence)


def reproduce(
    output: OutputOption = None,
    figures: Annotated[bool, option("Draw the figures, too.", "--figures/--no-figures")] = True,
    quiet: QuietOption = False,
    as_json: JsonOption = False,
) -> None:
    """Compute the numbers of Persson (2006) again, and say which hold.

    Covers the calculated figures and the numbers stated in the text: spectra, area, hardness, adhesion,
    tire rim, PMMA, Pyrex. Claims of one system are judged under one set of conventions. Measured figures
    and the cost of solvers have no row; the report says why.
    """
    from validation.cli.results import print_outputs, under_way
    from validation.files import prepare_folder
    from validation.paper import reproduce as reproduction

    folder = prepare_folder(output or Path("results") / "persson-2006")
    with under_way("the numbers of the paper", quiet=quiet or as_json) as tell:
        outputs = reproduction.run(folder, figures=figures, progress=tell)
    if as_json:
        data = outputs.data
        claims = data[[name for name, value in data.items() if value.dims == ("claim",)]]
        print_json(json_ready(claims.to_dataframe().reset_index().to_dict("records")))
        return
    print_outputs(outputs)


challenge_app = typer.Typer(no_args_is_help=True, help="Score a solver in any language, by files.")


@challenge_app.command(epilog=examples("fem-contact challenge export mine"))
def export(
    folder: Annotated[Path, argument("DIR", "Folder to write the problems into.")],
    points: Annotated[
        int, typer.Option(metavar="N", min=16, max=128, help="Along a side of the coarsest grids.")
    ] = 16,
    tolerance: ToleranceOption = 1e-6,
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
    folder: Annotated[Path, argument("DIR", "Folder of problems, with answers to some.")],
    as_json: JsonOption = False,
) -> None:
    """Score the answers of a folder, all or some; exit with 1 if a row fails."""
    from validation.cases._result import write_scorecards
    from validation.cases.scorecard.challenge import score_folder

    card = score_folder(folder, tell=None if as_json else lambda line: say(line, prefix=""))
    show_scorecards([card], write_scorecards(folder, [card]).files, as_json=as_json)
