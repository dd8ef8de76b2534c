"""The study `hardness` again: plastic and elastic area in the limit, and Persson's, from the fields of every solve."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from validation.audit.closed_forms import yielded_areas
from validation.audit.stored import Array, Stored
from validation.audit.studies.kept import Kept
from validation.audit.studies.said import said

__all__ = ["judge", "truncated"]

_YOUNG, _POISSON, _LENGTH, _GRADIENT = 1e9, 0.3, 1e-4, 0.1
_PARTS = ("plastic", "elastic")


def truncated(
    options: dict[str, Any], *, until: float, seed: int, length: float, gradient: float
) -> dict[str, Any]:
    """Return a surface with its waves up to q/q_long = until, as recipes have it."""
    power = 2 - 2 * options["hurst"]

    def slopes(ratio: float) -> float:
        """Mean square gradient of the waves up to a ratio, in any unit: int q^3 q^(-2 - 2 H) dq."""
        return math.log(ratio) if power == 0 else (ratio**power - 1) / power

    whole = options["bandwidth"]
    return {
        "kind": "self-affine",
        "length": [length, length],
        "hurst": options["hurst"],
        "lambda_long": length / options["periods"],
        "lambda_short": length / options["periods"] / until,
        "rms_gradient": gradient * math.sqrt(slopes(until) / slopes(whole)),
        "seed": seed,
    }


def judge(kept: Kept) -> None:
    """Judge dataset and sentences."""
    options = kept.options
    modulus = _YOUNG / (1 - _POISSON**2)
    hardness = options["hardness"] * modulus * _GRADIENT
    unit = _units(kept, hardness, modulus)
    if unit is None:
        kept.ledger.unread.append("areas of the surfaces: the store lacks solves")
    else:
        rows = [(float(options["bandwidth"]), load) for load in options["reduced_pressures"]]
        _columns(kept, rows, (unit, hardness), "")
        load = options["smoothing_reduced_pressure"]
        rows = [(float(zeta), load) for zeta in options["magnifications"]]
        _columns(kept, rows, (unit, hardness), "_grown")
    kept.array("reduced_pressure", options["reduced_pressures"])
    kept.array("magnification", options["magnifications"])
    kept.ledger.unread.append(
        "the smoothed surface (wave, kept, kept_persson): share of C(q) and of the gradient left, and Persson's"
    )
    _sentences(kept)


def _solve(kept: Kept, until: float, k: int, n: int, **wanted: Any) -> Stored | None:
    surface = truncated(
        kept.options, until=until, seed=kept.options["seed"] + k, length=_LENGTH, gradient=_GRADIENT
    )
    return kept.fields(surface, kind="Press", method="bem", grid=[n, n], **wanted)


def _units(kept: Kept, hardness: float, modulus: float) -> list[float] | None:
    """E* h'_rms of the whole surfaces [Pa], by their finest grid; None without solves."""
    found = []
    for k in range(kept.options["surfaces"]):
        one = _solve(kept, float(kept.options["bandwidth"]), k, max(kept.options["grids"]))
        if one is None:
            return None
        kept.ledger.number(f"surface {k}", "E* [Pa]", one.modulus, modulus)
        bound = float(one.p.max())
        kept.ledger.same(f"surface {k}", "no pressure above H", bound <= hardness * (1 + 1e-9), True)
        found.append(modulus * math.sqrt(one.moments[1]))
    return found


def _columns(
    kept: Kept, rows: list[tuple[float, float]], told: tuple[list[float], float], suffix: str
) -> None:
    """Judge limits, finest grids, theory and errors of one dimension."""
    units, hardness = told
    ladder = sorted(set(kept.options["grids"]))
    areas = np.full((len(rows), len(units), len(ladder), 2), np.nan)
    theory = np.full((len(rows), len(units), 2), np.nan)
    for r, (until, load) in enumerate(rows):
        for k, unit in enumerate(units):
            pressure = load * unit
            for g, n in enumerate(ladder):
                one = _solve(
                    kept,
                    until,
                    k,
                    n,
                    load={"pressure": pressure},
                    effects=[{"hardness": hardness, "kind": "hardness"}],
                )
                if one is None:
                    kept.ledger.unread.append(f"areas{suffix}: the store lacks solves")
                    return
                areas[r, k, g] = one.plastic, one.pixel - one.plastic
                place = f"surface {k}, {n}x{n}, until {until:g}, p* = {load:g}"
                kept.ledger.number(place, "mean pressure [Pa]", one.mean_pressure, pressure, rtol=1e-6)
                held = one.p[one.bound]
                if held.size:
                    kept.ledger.number(place, "pressure where it yields [Pa]", held.min(), hardness)
                variance = one.modulus**2 * one.moments[1] / 4
                theory[r, k] = yielded_areas(pressure, variance=variance, hardness=hardness)
    _limits(kept, areas, theory, (ladder, suffix))


def _limits(kept: Kept, areas: Array, theory: Array, told: tuple[list[int], str]) -> None:
    ladder, suffix = told

    def limit(g: int) -> Array:
        """Straight line in the spacing through two grids, at spacing zero."""
        coarse, fine = 1 / ladder[g - 1], 1 / ladder[g]
        return np.asarray((areas[:, :, g] * coarse - areas[:, :, g - 1] * fine) / (coarse - fine))

    last = len(ladder) - 1
    values = limit(last)
    before = limit(last - 1) if last > 1 else areas[:, :, last]
    grid = np.abs(values - before).mean(axis=1)
    n = values.shape[1]
    scatter = np.zeros_like(grid)
    if n > 1:
        scatter = np.sqrt(np.sum((values - values.mean(axis=1)[:, None]) ** 2, axis=1) / (n - 1) / n)
    for part, name in enumerate(_PARTS):
        kept.array(f"{name}{suffix}", values.mean(axis=1)[:, part])
        kept.array(f"{name}{suffix}_finest", areas[:, :, last, part].mean(axis=1))
        kept.array(f"{name}{suffix}_persson", theory.mean(axis=1)[:, part], rtol=1e-7, atol=1e-12)
        kept.array(f"{name}{suffix}_error", np.hypot(grid, scatter)[:, part], rtol=1e-7, atol=1e-10)


def _sentences(kept: Kept) -> None:
    for name, suffix, words in (
        ("reduced_pressure", "", "p*"),
        ("magnification", "_grown", "magnification"),
    ):
        for k in sorted({0, kept[name].size - 1}):
            values: dict[str, float | str] = {"x": float(kept[name][k]), "h": kept.options["hardness"]}
            parts = []
            for part in _PARTS:
                found, theory = float(kept[part + suffix][k]), float(kept[f"{part}{suffix}_persson"][k])
                values |= {part: found, f"{part}_theory": theory}
                values |= {f"{part}_error": float(kept[f"{part}{suffix}_error"][k])}
                away = ""
                if found > 0:
                    away = f", {{{part}_away}} {{{part}_side}} it"
                    values[f"{part}_away"] = abs(theory / found - 1)
                    values[f"{part}_side"] = "above" if theory > found else "below"
                parts.append(
                    f"A_{part[:2]}/A0 = {{{part}}} +- {{{part}_error}} in the limit and {{{part}_theory}} by "
                    f"Persson{away}"
                )
            at = f"{words} = {{x:3}}"
            if suffix:
                at += " (p* = {all:3} with all waves)"
                values["all"] = kept.options["smoothing_reduced_pressure"]
            said(kept, f"At {at} and H = {{h:3}} E* h'_rms: {'; '.join(parts)}.", **values)
    worst = float(np.max(np.abs(kept["kept"] - kept["kept_persson"])))
    said(
        kept,
        "Smoothed at p* = {p:3}, the surface keeps {left:3} of C(q) at q = {q:3} q_long, where Persson's formula "
        "leaves {theory:3} (largest difference {worst:2}): it smooths the whole surface, boundary elements only "
        "what has yielded, where {inside:2} of the squared gradient is left.",
        p=kept.options["smoothing_reduced_pressure"],
        left=float(kept["kept"][-1]),
        q=float(kept["wave"][-1]),
        theory=float(kept["kept_persson"][-1]),
        worst=worst,
        inside=float(kept.said["gradient_kept_inside"]),
    )
