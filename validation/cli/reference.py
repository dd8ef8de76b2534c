"""The command `reference`: contact of self-affine surfaces, looked up."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import Annotated

import typer

from validation.cli.options import JsonOption

__all__ = ["reference"]


def reference(
    hurst: Annotated[float, typer.Option("--hurst", help="Hurst exponent H.")],
    bandwidth: Annotated[float, typer.Option("--bandwidth", "--ratio", help="lambda_long / lambda_short.")],
    pressure: Annotated[
        float, typer.Option("--pressure", "--reduced-pressure", help="p* = p0 / (E* h'_rms).")
    ],
    amplitudes: Annotated[str, typer.Option("--amplitudes", help="Of the waves: exact, gaussian.")] = "exact",
    gradient: Annotated[
        str, typer.Option("--gradient", help="h'_rms that p* has: of each surface, of C(q) (spectrum).")
    ] = "surface",
    as_json: JsonOption = False,
) -> None:
    """Look up contact area, gap, compliance, energy of self-affine surfaces, with their uncertainty."""
    from validation.cli.results import print_table
    from validation.reference import lookup, table
    from validation.report.table import WordTable
    from validation.report.words import with_error

    found = lookup(
        hurst=hurst,
        bandwidth=bandwidth,
        reduced_pressure=pressure,
        amplitudes=amplitudes,
        gradient=gradient,
    )
    sized = (amplitudes, gradient) == ("exact", "surface")
    parts = "surfaces, grid, solver, size of the sample" if sized else "surfaces, grid, solver"
    lacking = "" if sized else "; what the size of the sample does is not in it"
    if as_json:
        typer.echo(json.dumps({name: asdict(value) for name, value in found.items()}, indent=2))
        return
    rows = tuple(
        (
            one.quantity,
            with_error(one.value, one.uncertainty),
            f"{100 * round(one.interpolation / one.value, 6):.2g}",
            one.meaning,
        )
        for one in found.values()
    )
    print_table(
        WordTable(
            title=f"H = {hurst:g}, lambda_long/lambda_short = {bandwidth:g}, p* = {pressure:g}",
            columns=("quantity", "mean and 95 %", "interpolation [%]", "meaning"),
            rows=rows,
            left=frozenset({"quantity", "meaning"}),
            yielding=("meaning", "interpolation [%]"),
            note=f"Means over surfaces with L/lambda_long = {table().attrs['periods']:g}; the interval has "
            f"{parts} and interpolation{lacking}.",
        )
    )
