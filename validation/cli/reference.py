"""The command `reference`: contact of self-affine surfaces, looked up."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import Annotated, Any

import typer

from validation.cli.options import JsonOption

__all__ = ["reference"]


def _of(*choices: str) -> Any:
    """Complete one of some words."""
    return lambda incomplete: [word for word in choices if word.startswith(incomplete)]


def reference(
    hurst: Annotated[float, typer.Option("--hurst", metavar="H", help="Hurst exponent.")],
    bandwidth: Annotated[
        float, typer.Option("--bandwidth", "--ratio", metavar="B", help="lambda_long / lambda_short.")
    ],
    reduced_pressure: Annotated[
        float, typer.Option("--reduced-pressure", metavar="P", help="p* = p0 / (E* h'_rms).")
    ],
    amplitudes: Annotated[
        str,
        typer.Option(
            metavar="WORD", help="Of the waves: exact, gaussian.", autocompletion=_of("exact", "gaussian")
        ),
    ] = "exact",
    gradient: Annotated[
        str,
        typer.Option(
            metavar="WORD",
            help="Whose h'_rms p* has: of each surface, or of C(q): spectrum.",
            autocompletion=_of("surface", "spectrum"),
        ),
    ] = "surface",
    as_json: JsonOption = False,
) -> None:
    """Look up the contact of a self-affine surface, beside Persson's theory.

    Contact area, kappa, mean gap, compliance, elastic energy: means over surfaces with their uncertainty,
    between the computed values by interpolation.
    """
    from validation.cli.results import print_table
    from validation.reference import lookup, persson_theory, table
    from validation.report.table import WordTable
    from validation.report.words import with_error

    at = {"hurst": hurst, "bandwidth": bandwidth, "reduced_pressure": reduced_pressure}
    values = lookup(**at, amplitudes=amplitudes, gradient=gradient)
    theory = persson_theory(**at)
    if as_json:
        record = {name: {**asdict(value), "persson": theory.get(name)} for name, value in values.items()}
        typer.echo(json.dumps(record, indent=2))
        return
    rows = [
        (
            name,
            with_error(value.value, value.uncertainty),
            f"{theory[name]:.4g}" if name in theory else "-",
            f"{100 * round(value.interpolation / value.value, 6):.2g}",
            value.meaning,
        )
        for name, value in values.items()
    ]
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
            note=f"Means over surfaces with L/lambda_long = {table().attrs['periods']:g}; the interval has "
            f"{parts} and interpolation{lacking}.",
        )
    )
