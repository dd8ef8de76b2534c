"""The command `reference`: contact of self-affine surfaces, looked up."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

import typer

from validation.cli.options import JsonOption, OutputOption, named_by, option, print_json
from validation.errors import UsageError


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
    print_table(
        WordTable(
            title=f"H = {hurst:g}, lambda_long/lambda_short = {bandwidth:g}, p* = {reduced_pressure:g}",
            columns=("quantity", "mean and 95 %", "Persson", "interpolation [%]", "meaning"),
            rows=tuple(rows),
            left=frozenset({"quantity", "meaning"}),
            yielding=("interpolation [%]", "meaning"),
            note=f"Means over surfaces with L/lambda_long = {table(rolloff).attrs['periods']:g}; "
            f"the interval has {parts} and interpolation{lacking}.",
        )
    )
