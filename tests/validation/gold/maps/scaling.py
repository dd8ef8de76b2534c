"""`scaling` on the kit: exponents and what a decade costs are variables and no rows of the table."""

from __future__ import annotations

from gold.maps import Look


def _column(name: str, *, unit: float = 1.0, area: bool = False) -> Look:
    def values(d):
        ends = ["", "", ""] if area else [d[f"exponent_{name}"], None, d[f"decade_{name}"]]
        if not area:
            ends[1] = d[f"exponent_{name}_error"].sel(source="surfaces")
        return [*(d[name].values / unit), *(e if area else float(e) for e in ends)]

    return values


NAMES: dict[str, Look] = {
    "data.area": "area_located_each",
    "data.fft_pairs": "fft_pairs_each",
    "data.peak_bytes": "peak_bytes_each",
    "table.FFT pairs": _column("fft_pairs"),
    "table.MiB": lambda d: [
        *(d.peak_bytes.values / 2**20),
        float(d.exponent_peak_bytes),
        float(d.exponent_peak_bytes_error.sel(source="surfaces")),
        float(d.decade_peak_bytes),
    ],
}
CHANGED: dict[str, str] = {
    "table.grid": "the number of points stands in a column of numbers",
    "table.A/A0 subcell": "the same as data.area, mean over surfaces",
    "table.lambda_long/lambda_short": "rows of exponents are gone from the table",
}
