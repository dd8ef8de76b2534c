"""What a stranger needs to use the reference table: definition, conventions, licence, a CSV file."""

from typing import Any

import xarray as xr

from validation.reference.interpolation import QUANTITIES
from validation.report.estimates import total_error
from validation.report.papers import cited

#: Attributes of the file, by the Climate and Forecast conventions, which have no standard names for contact.
ATTRIBUTES: dict[str, Any] = {
    "Conventions": "CF-1.11",
    "title": "Contact of self-affine surfaces: area, gap, compliance, elastic energy, patches",
    "institution": "The fem-contact developers",
    "source": "boundary elements (fem-contact), controlled means over surfaces: fem-contact study reference",
    "product_version": "3.4",
    "license": "BSD-3-Clause",
    "references": cited("docs/reference_table.md; [persson2006]"),
    "definition": "Periodic square of side L = 4 lambda_long; h(x) = sum_q B(q) cos(q.x + phi(q)) over "
    "q = 2 pi (m, n)/L with {lowest} <= m^2 + n^2 <= (4 bandwidth)^2, one of each pair +-q, "
    "B = (4 pi/L) C(q)^(1/2), C(q) ~ {power}, phi uniform and independent; "
    "amplitudes = gaussian: B times a Rayleigh variable of mean square 1. Pressed on an "
    "elastic half-space of contact modulus E* = E/(1 - nu^2), small slopes, no friction, no adhesion. "
    "reduced_pressure = p0/(E* h'_rms), p0 the nominal pressure, h'_rms = <|grad h|^2>^(1/2) of each "
    "surface.",
    "coverage_probability": 0.95,
    "coverage_comment": "x_error has half widths by source, Student's for surfaces (coverage factor 1.96 for "
    "many pairs, 3.18 for four); the whole is the root of their sum of squares; NaN: not measured",
}

#: Its smallest m^2 + n^2 and its C(q), by roll-off.
_SPECTRA = {
    "sharp": {"lowest": 16, "power": "q^(-2-2H), no roll-off"},
    "plateau": {"lowest": 1, "power": "max(q, 2 pi/lambda_long)^(-2-2H)"},
}


def citable(table: xr.Dataset) -> xr.Dataset:
    """Return a table that says what it is, and which error belongs to which variable."""
    definition = ATTRIBUTES["definition"].format(**_SPECTRA[table.attrs["rolloff"]])
    table = table.assign_attrs(ATTRIBUTES | {"definition": definition})
    for name in map(str, table.data_vars):
        if f"{name}_error" in table:
            table[name].attrs["ancillary_variables"] = f"{name}_error"
    return table


def as_csv(table: xr.Dataset) -> str:
    """Return the cells that were made with their half widths (95 %); definition and licence stand after #."""
    head = ("title", "definition", "license", "product_version")
    halves = {f"{name}_error": total_error(table, name) for name in QUANTITIES}
    cells = table[[*QUANTITIES]].assign(halves)
    frame = cells.to_dataframe(["amplitudes", "hurst", "bandwidth", "reduced_pressure"]).dropna(subset="area")
    columns = [title for name in QUANTITIES for title in (name, f"{name}_error")]
    rows: str = frame[columns].reset_index().to_csv(index=False, float_format="%.6g", lineterminator="\n")
    return "".join(f"# {name}: {table.attrs[name]}\n" for name in head) + rows
