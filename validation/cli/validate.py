"""The commands of known numbers: `validate`, `challenge`, `reproduce`, and `reference`, which tells them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import asdict
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
    named_by,
    option,
    print_json,
    say,
    show,
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


def _word(what: str, *choices: str) -> Any:
    return typer.Option(metavar="WORD", help=what, autocompletion=lambda: choices)


def reference(
    hurst: Annotated[float | None, option("Hurst exponent.", metavar="H")] = None,
    bandwidth: Annotated[
        float | None, option("lambda_long / lambda_short.", "--bandwidth", "--ratio", metavar="B")
    ] = None,
    reduced_pressure: Annotated[float | None, option("p* = p0 / (E* h'_rms).", metavar="P")] = None,
    amplitudes: Annotated[str, _word("Of the waves: exact, gaussian.", "exact", "gaussian")] = "exact",
    gradient: Annotated[
        str, _word("Whose h'_rms p* has: of each surface, or of C(q): spectrum.", "surface", "spectrum")
    ] = "surface",
    rolloff: Annotated[
        str, _word("C(q) beyond lambda_long: none (sharp), or constant: plateau.", "sharp", "plateau")
    ] = "sharp",
    theory: Annotated[
        list[str] | None,
        option(
            "Score a theory on all cells; your own is module:function, as "
            "def area(pressure, *, contact_modulus, moments), of arrays.",
            metavar="NAME",
            autocompletion=named_by("validation.theories:theories"),
        ),
    ] = None,
    csv: Annotated[
        Path | None, option("Score areas: columns hurst, bandwidth, reduced_pressure, area.", metavar="FILE")
    ] = None,
    output: OutputOption = None,
    as_json: JsonOption = False,
) -> None:
    """Look up the contact of a self-affine surface, beside Persson's theory.

    Contact area, kappa, mean gap, compliance, elastic energy: means over surfaces with their uncertainty,
    between the computed values by interpolation. With --theory or --csv a theory, or your numbers, are scored
    on all cells instead, as by the study reference-score.
    """
    from validation.cli.results import print_outputs, print_table
    from validation.execution.bench import Bench
    from validation.files import prepare_folder
    from validation.reference import lookup, persson_theory, table
    from validation.report.table import WordTable
    from validation.report.words import with_error
    from validation.studies import find_study
    from validation.studies._outputs import run_study

    if theory or csv is not None:
        asked = {"--hurst": hurst, "--bandwidth": bandwidth, "--reduced-pressure": reduced_pressure}
        said = {"--amplitudes": amplitudes != "exact", "--gradient": gradient != "surface"}
        for flag in (flag for flag, value in {**asked, **said}.items() if value):
            raise UsageError(f"{flag}: not with --theory or --csv, which score all cells; leave it out")
        folder = prepare_folder(output or Path("results") / "reference-score")
        study = find_study("reference-score")
        flags = ["--rolloff", rolloff, "--theory", ",".join(theory or ())]
        options = study.parse(flags if csv is None else [*flags, "--csv", str(csv)])
        outputs = run_study(study, options, folder, bench=Bench.at())
        print_outputs(outputs, as_json=as_json)
        return
    if hurst is None or bandwidth is None or reduced_pressure is None:
        raise UsageError(
            "reference: give --hurst, --bandwidth and --reduced-pressure; or a theory to score, --theory"
        )
    point = {"hurst": hurst, "bandwidth": bandwidth, "reduced_pressure": reduced_pressure}
    values = lookup(**point, amplitudes=amplitudes, gradient=gradient, rolloff=rolloff)
    persson = persson_theory(**point, rolloff=rolloff)
    if as_json:
        print_json({name: {**asdict(value), "persson": persson.get(name)} for name, value in values.items()})
        return
    rows = []
    for name, value in values.items():
        theory_words = f"{persson[name]:.4g}" if name in persson else "-"
        share = f"{100 * round(value.interpolation / value.value, 6):.2g}"
        number = with_error(value.value, value.uncertainty)
        rows.append((name, number, theory_words, share, value.meaning))
    sized = (amplitudes, gradient) == ("exact", "surface")
    parts = "surfaces, grid, solver, size of the sample" if sized else "surfaces, grid, solver"
    lacking = "" if sized else "; what the size of the sample does is not in it"
    where = f"H = {hurst:g}, lambda_long/lambda_short = {bandwidth:g}, p* = {reduced_pressure:g}"
    show(where)
    print_table(
        WordTable(
            title=where,
            columns=("quantity", "mean and 95 %", "Persson", "interpolation [%]", "meaning"),
            rows=tuple(rows),
            left=frozenset({"quantity", "meaning"}),
            yielding=("interpolation [%]", "meaning"),
            note=f"Means over surfaces with L/lambda_long = {table(rolloff).attrs['periods']:g}; "
            f"the interval has {parts} and interpolation{lacking}.",
        )
    )
