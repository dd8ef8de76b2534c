"""table.csv, summary.json, figure data and the tables of the page, number by number."""

from __future__ import annotations

import csv
import html
import math
import re
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from validation.audit.ledger import Ledger
from validation.audit.recomputed import Row, Run, without_none
from validation.audit.sentences import label_of, with_error

__all__ = ["audit_figures", "audit_page", "audit_summary", "audit_table", "page_tables"]

#: Rounding differs between two ways to add up; a residual of 1e-17 is rounding itself.
_LOOSE = {"residual": {"rtol": 1e-6, "atol": 1e-14}, "pixel_scatter": {"rtol": 1e-9, "atol": 1e-12}}


def _unknown(run: Run, name: str, row: Row) -> bool:
    """Whether a column cannot be computed from the fields."""
    if name == "residual" and math.isnan(row.residual):
        return True
    return run.measured and name in ("points_per_wave", "under_resolved", "kappa", "residual")


def _rows(place: str, found: list[dict[str, Any]], run: Run, ledger: Ledger) -> None:
    ledger.same(place, "number of rows", len(found), len(run.rows))
    for stands, row in zip(found, run.rows, strict=False):
        where = f"{row.method} {row.grid[0]}x{row.grid[1]}"
        for name, value in asdict(row).items():
            if _unknown(run, name, row):
                ledger.unread.append(f"{place}: {name}")
                continue
            title, said = f"{where} {name}", stands[name]
            if name == "grid":
                ledger.same(
                    place,
                    title,
                    said if isinstance(said, str) else "x".join(map(str, said)),
                    where.split()[1],
                )
            elif name in ("method", "under_resolved"):
                ledger.same(place, title, str(said), str(value))
            else:
                ledger.number(place, title, said, value, **_LOOSE.get(name, {}))


def audit_table(folder: Path, run: Run, ledger: Ledger) -> None:
    """Judge table.csv."""
    with (folder / "table.csv").open(newline="", encoding="utf-8") as file:
        _rows("table.csv", list(csv.DictReader(file)), run, ledger)


def audit_summary(said: dict[str, Any], run: Run, ledger: Ledger) -> None:
    """Judge summary.json, its sentences excepted."""
    place = "summary.json"
    _rows(place, said["rows"], run, ledger)
    ledger.same(place, "scene is that of run.json", without_none(said["scene"]), without_none(run.scene))
    ledger.number(place, "E* [Pa]", said["contact_modulus_Pa"], run.modulus)
    if run.measured:
        ledger.unread.append("realised moments, p* and theory of a measured surface")
    found = run.moments()
    if found is not None:
        m0, m2, m4 = found
        ledger.number(place, "p0 [Pa]", said["pressure_Pa"], run.pressure())
        ledger.number(place, "p*", said["reduced_pressure"], run.reduced_pressure)
        ledger.number(place, "h_rms [m]", said["realised"]["rms_height_m"], math.sqrt(m0), atol=0.0)
        ledger.number(place, "h'_rms", said["realised"]["rms_gradient"], math.sqrt(m2))
        ledger.number(
            place, "Nayak parameter", said["realised"]["nayak"], 1.5 * m0 * m4 / m2**2 if m2 else None
        )
    if run.spectral_moments is not None:
        spectral = [math.sqrt(m) for m in run.spectral_moments]
        ledger.number(
            place, "h_rms of C(q) [m]", said["continuum"]["rms_height_m"], spectral[0], rtol=1e-6, atol=0.0
        )
        ledger.number(place, "h'_rms of C(q)", said["continuum"]["rms_gradient"], spectral[1], rtol=1e-6)
    _limit_theory(said, run, ledger)
    _cross_scatter(said, run, ledger)


def _limit_theory(said: dict[str, Any], run: Run, ledger: Ledger) -> None:
    place, limit = "summary.json", run.own_limit
    ledger.same(place, "there is a limit", said["limit"] is not None, limit is not None)
    if limit is not None and said["limit"] is not None:
        ledger.number(place, "limit of A/A0", said["limit"]["value"], limit.value, rtol=1e-7)
        ledger.number(
            place, "error of the limit", said["limit"]["uncertainty"], limit.error, rtol=1e-5, atol=1e-9
        )
        ledger.same(place, "solves of the limit", said["limit"]["grids"], limit.solves)
        ledger.same(place, "area that was extrapolated", said["limit"]["definition"], limit.definition)
    theory = run.theory()
    if theory is None:
        if said["theory"] is not None:
            ledger.unread.append("theory with effects, or of a measured surface")
        return
    ledger.number(place, "theory, A/A0 of this surface", said["theory"]["area"], theory)
    (_, m2, _) = run.moments() or (0.0, 0.0, 0.0)
    variance = run.modulus**2 * m2 / 4
    ledger.number(place, "theory, V [Pa^2]", said["theory"]["stress_variance"], variance)
    if run.yielded_theory is not None:
        ledger.number(place, "theory, A_pl/A0", said["theory"]["plastic"], run.yielded_theory)
    if run.ensemble_theory is not None:
        ledger.number(
            place,
            "theory, A/A0 from C(q) alone",
            said["theory"]["ensemble_area"],
            run.ensemble_theory,
            rtol=1e-6,
        )


def _cross_scatter(said: dict[str, Any], run: Run, ledger: Ledger) -> None:
    place = "summary.json"
    ledger.same(place, "number of cross-checks", len(said["cross_checks"]), len(run.cross))
    for stands, (method, grid, *values) in zip(said["cross_checks"], run.cross, strict=False):
        where = f"{method} on {grid[0]}x{grid[1]} against {run.methods[0]}"
        ledger.same(
            place,
            where,
            (stands["method"], stands["reference"], *stands["grid"]),
            (method, run.methods[0], *grid),
        )
        for name, value in zip(("pressure", "pixel", "perimeter"), values, strict=True):
            ledger.number(place, f"{where}, {name}", stands[name], value, atol=1e-12)
    if run.scatter is not None and said["scatter"] is not None:
        for name, found in zip(("areas", "ratios"), run.scatter[:2], strict=True):
            ledger.same(place, f"number of {name}", len(said["scatter"][name]), len(found))
            for k, (a, b) in enumerate(zip(said["scatter"][name], found, strict=False)):
                ledger.number(place, f"scatter, {name} {k}", a, b, rtol=1e-7)
        ledger.number(place, "scatter, grid error", said["scatter"]["grid_error"], run.scatter[2], rtol=1e-5)
    else:
        ledger.same(place, "there is a scatter", said["scatter"] is not None, run.scatter is not None)


def _columns(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def audit_figures(folder: Path, run: Run, ledger: Ledger) -> None:
    """Judge the numbers behind the figures, where there are figures."""
    figures = folder / "figures"
    if not figures.is_dir() or run.measured:
        ledger.unread.append(
            "data of figures" + (": of a measured surface" if run.measured else ": there are none")
        )
        return
    _area_figure(figures, run, ledger)
    limit = run.own_limit
    place, found = "figures/cost.csv", _columns(figures / "cost.csv")
    ways = [(row, name) for row in run.rows for name in ("pixel", "perimeter")]
    ledger.same(place, "number of points", len(found), len(ways))
    for stands, (row, name) in zip(found, ways, strict=False):
        where = f"{row.method} {row.grid[0]}x{row.grid[1]} {name}"
        ledger.same(place, where, (stands["method"], stands["area"]), (row.method, name))
        ledger.number(place, f"{where}, seconds", stands["seconds"], row.seconds)
        error = None if limit is None else getattr(row, name) / limit.value - 1
        ledger.number(place, f"{where}, error", stands["error"], error, atol=1e-7)
    _distribution(figures, run, ledger)


def _area_figure(figures: Path, run: Run, ledger: Ledger) -> None:
    import netCDF4

    place, limit = "figures/area", run.own_limit
    for stands, row in zip(_columns(figures / "area.csv"), run.rows, strict=True):
        where = f"{row.method} {row.grid[0]}x{row.grid[1]}"
        ledger.same(
            place, where, (stands["method"], int(stands["nx"]), int(stands["ny"])), (row.method, *row.grid)
        )
        ledger.number(place, f"{where}, dx / lambda_short", stands["spacing"], 1 / row.points_per_wave)
        ledger.number(place, f"{where}, pixel", stands["pixel"], row.pixel)
        ledger.number(place, f"{where}, scatter", stands["pixel_error"], row.pixel_scatter, atol=1e-12)
        ledger.number(place, f"{where}, perimeter", stands["perimeter"], row.perimeter)
    with netCDF4.Dataset(figures / "area.nc") as file:
        said = {name: file.getncattr(name) for name in file.ncattrs()}
    expected = {"persson": run.theory(), "persson_from_spectrum": run.ensemble_theory}
    expected |= {"limit": limit.value, "limit_error": limit.error} if limit else {}
    for name, value in expected.items():
        if value is not None:
            ledger.number(place, name, said.get(name), value, rtol=1e-5)


def _distribution(figures: Path, run: Run, ledger: Ledger) -> None:
    """Judge P(sigma): shares of area in bins, and the theory's at the same load."""
    place, found = "figures/pressure-at-zero.csv", _columns(figures / "pressure-at-zero.csv")
    if run.gradient is None or run.adhesive:
        ledger.unread.append(f"{place}: P(sigma) under attraction")
        return
    unit = run.modulus * run.gradient
    curves: dict[str, list[dict[str, str]]] = {}
    for point in found:
        curves.setdefault(point["curve"], []).append(point)
    for row in run.rows:
        label = f"{label_of(row.method)} {row.grid[0]} x {row.grid[1]}"
        bins = curves.get(label, [])
        ledger.same(place, f"{label} is drawn", bool(bins), True)
        own = run.shown(row.method, row.grid)
        edges = [float(b["lower"]) for b in bins] + [float(bins[-1]["upper"])] if bins else [0.0, 1.0]
        counts = sum(
            np.histogram(one.p[one.contact], np.array(edges) * unit, weights=one.weights[one.contact])[0]
            / one.p.size
            for one in own
        )
        density = counts / len(own) / np.diff(edges)
        for b, value in zip(bins, density, strict=False):
            ledger.number(
                place, f"{label}, P at {float(b['lower']):.3g}", b["density"], float(value), rtol=1e-6
            )
    pressure, (_, m2, _) = run.pressure(), run.moments() or (0.0, 0.0, 0.0)
    if run.theory() is None or pressure is None or not m2 > 0:
        return
    if not run.bare:
        ledger.unread.append(f"{place}: the theory's P(sigma) with effects")
        return
    variance = run.modulus**2 * m2 / 4
    for point in curves.get("Persson", []):
        s = float(point["lower"]) * unit
        both = [math.exp(-((s + sign * pressure) ** 2) / (2 * variance)) for sign in (-1, 1)]
        exact = (both[0] - both[1]) / math.sqrt(2 * math.pi * variance) * unit
        ledger.number(
            place, f"Persson, P at {float(point['lower']):.3g}", point["density"], exact, atol=1e-10
        )


_MARKS = (
    ("κ", "kappa"),
    ("α", "alpha"),
    ("λ", "lambda"),
    ("Δx", "dx"),
    ("±\u00a0", "+- "),
    ("\u00a0%", " %"),
    ("σ", "sigma"),
)


def _plain(cell: str) -> str:
    """Return a cell of a page as it was typed."""
    text = html.unescape(re.sub(r"<[^>]+>", "", re.sub(r"<sub>([^<\d]+)</sub>", r"_\1", cell)))
    for printed, typed in _MARKS:
        text = text.replace(printed, typed)
    return text.strip()


def page_tables(page: str) -> dict[str, tuple[list[str], list[list[str]]]]:
    """Return the tables of a page by their titles: names of the columns, and lines of cells."""
    found = {}
    for title, table in re.findall(r'aria-label="Table: ([^"]+)"><table>(.*?)</table>', page, flags=re.S):
        names = [_plain(cell) for cell in re.findall(r"<th[^>]*>(.*?)</th>", table, flags=re.S)]
        lines = re.findall(r"<tr[^>]*>((?:<td.*?)+)</tr>", table, flags=re.S)
        cells = [[_plain(c) for c in re.findall(r"<td[^>]*>(.*?)</td>", line, flags=re.S)] for line in lines]
        found[html.unescape(title)] = names, cells
    return found


def audit_page(folder: Path, run: Run, ledger: Ledger) -> None:
    """Judge the tables of report.html, where it was written."""
    path = folder / "report.html"
    if not path.exists() or run.measured:
        ledger.unread.append(
            "report.html" + (": of a measured surface" if run.measured else ": there is none")
        )
        return
    page = path.read_text(encoding="utf-8")
    tables = {
        title: [dict(zip(names, line, strict=False)) for line in lines]
        for title, (names, lines) in page_tables(page).items()
    }
    lines = tables.get("Every grid", [])
    for line, row in zip(lines, run.rows, strict=False):
        _line(line, row, ledger)
    for line in lines[len(run.rows) :]:
        _sum(line, run, ledger)
    place = "report.html, cross-checks"
    crossed = next((lines for title, lines in tables.items() if title.startswith("Beside ")), [])
    ledger.same(place, "number of rows", len(crossed), len(run.cross))
    for line, (method, grid, *values) in zip(crossed, run.cross, strict=False):
        ledger.same(place, "method", line["method"], label_of(method))
        ledger.same(place, "grid", line["grid"], f"{grid[0]} x {grid[1]}")
        columns = ("pressure, relative L2", "pixel area", "perimeter area")
        for name, value in zip(columns, values, strict=True):
            ledger.text(place, f"{line['grid']} {name}", line[name], value)
    for card in re.findall(r"<div><span>(.*?)</span><b>(.*?)</b><span>(.*?)</span></div>", page):
        question, answer, basis = map(_plain, card)
        _card(question, answer, run, ledger)
        _basis(basis, run, ledger)


def _line(line: dict[str, str], row: Row, ledger: Ledger) -> None:
    place, where = "report.html, every grid", f"{row.method} {row.grid[0]}x{row.grid[1]}"
    shifts = f" ({row.solves})" if row.solves > 1 else ""
    note = " (under-resolved)" if row.under_resolved else ""
    ledger.same(place, where, line["method"], label_of(row.method) + note)
    ledger.same(place, where, line["grid (shifts)"], f"{row.grid[0]} x {row.grid[1]}{shifts}")
    if row.solves > 1:
        with_error(ledger, f"page, {where} pixel", line["A/A0 pixel"], (row.pixel, row.pixel_scatter))
    else:
        ledger.text(place, f"{where} pixel", line["A/A0 pixel"], row.pixel, 4)
    for column, value, digits in (
        ("A/A0 perimeter", row.perimeter, 4),
        ("kappa", row.kappa, 4),
        ("residual", row.residual, None),
        ("lambda_short/dx", row.points_per_wave, 4),
        ("P(0+) E*h'", row.density_at_zero, 3),
        ("seconds", row.seconds, 3),
    ):
        ledger.text(place, f"{where} {column}", line[column], value, digits)


def _sum(line: dict[str, str], run: Run, ledger: Ledger) -> None:
    load, limit, theory = run.reduced_pressure, run.own_limit, run.theory()
    if load is None:
        return
    if line["method"] == "limit" and limit is not None:
        with_error(ledger, "page, limit", line["A/A0 pixel"], (limit.value, limit.error))
        with_error(
            ledger, "page, kappa of the limit", line["kappa"], (limit.value / load, limit.error / load)
        )
    elif line["method"] == "Persson" and theory is not None:
        ledger.text("report.html, every grid", "Persson", line["A/A0 pixel"], theory, 4)
        ledger.text("report.html, every grid", "kappa of Persson", line["kappa"], theory / load, 4)


def _card(question: str, answer: str, run: Run, ledger: Ledger) -> None:
    place, limit, theory = "report.html, card", run.own_limit, run.theory()
    if question.startswith("How large"):
        ledger.text(
            place, question, answer, None if limit is None else limit.value, None if limit is None else 4
        )
    elif question.startswith("How far") and theory is not None:
        ledger.text(place, question, answer, None if limit is None else limit.value / theory - 1)
    elif question.startswith("How sure") and limit is not None:
        said = re.search(r"grid \+- ([\d.e-]+ %)", answer)
        ledger.text(place, question, said[1] if said else answer, limit.error / limit.value)
    elif question.startswith("What did it cost"):
        ledger.text(place, question, answer.removesuffix(" s"), sum(row.seconds for row in run.rows), 3)


def _basis(basis: str, run: Run, ledger: Ledger) -> None:
    """Judge what stands in small print below a card."""
    limit, load, theory = run.own_limit, run.reduced_pressure, run.theory()
    place = "report.html, card"
    kappa = re.fullmatch(r"limit over the grids; kappa = (\S+) \+- (\S+)", basis)
    if kappa is not None and limit is not None and load is not None:
        ledger.text(place, "kappa of the card", kappa[1], limit.value / load)
        ledger.text(place, "error of kappa of the card", kappa[2], limit.error / load)
    stands = re.fullmatch(r"theory: A/A0 = (\S+) with the realised gradient", basis)
    if stands is not None and theory is not None:
        ledger.text(place, "theory of the card", stands[1], theory, 4)
