"""The study `adhesion` again: areas with and without attraction, energy of the interface, from the fields."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from validation.audit.closed_forms import yielded_areas
from validation.audit.energies import full_energy, stored_energy
from validation.audit.stored import Stored
from validation.audit.studies.hardness import truncated
from validation.audit.studies.kept import Kept
from validation.audit.studies.said import said

__all__ = ["judge"]

_YOUNG, _POISSON, _LENGTH, _GRADIENT = 1e7, 0.5, 1e-5, 0.1
_DIALS = {
    "work": "w / U_full",
    "reduced_pressure": "p*",
    "magnification": "q / q_long of the last wave",
    "hardness": "H / (E* h'_rms)",
}
_OPTION = {
    "work": "works",
    "reduced_pressure": "reduced_pressures",
    "magnification": "magnifications",
    "hardness": "hardnesses",
}


def judge(kept: Kept) -> None:
    """Judge dataset and sentences."""
    until, finest = float(kept.options["bandwidth"]), max(kept.options["grids"])
    found = [_solve(kept, k, until, finest) for k in range(kept.options["surfaces"])]
    wholes = [one for one in found if one is not None]
    if len(wholes) < len(found):
        kept.ledger.unread.append("areas along the dials: the store lacks solves")
    else:
        modulus = _YOUNG / (1 - _POISSON**2)
        for k, whole in enumerate(wholes):
            kept.ledger.number(f"surface {k}", "E* [Pa]", whole.modulus, modulus)
        for dial in _DIALS:
            _dial(kept, dial, wholes)
    for dial, option in _OPTION.items():
        kept.array(dial, kept.options[option])
    kept.ledger.unread.append(
        "theory with adhesion (improved, old, macroscopic, yielded): solved by quadrature"
    )
    _general(kept)
    for dial in _DIALS:
        for k in range(kept[dial].size):
            _sentence(kept, dial, k)


def _name(quantity: str, dial: str) -> str:
    if dial == "work":
        return quantity
    bare = quantity.removesuffix("_error")
    return f"{bare}_{dial}" + quantity[len(bare) :]


def _solve(kept: Kept, k: int, until: float, n: int, **wanted: Any) -> Stored | None:
    surface = truncated(
        kept.options, until=until, seed=kept.options["seed"] + k, length=_LENGTH, gradient=_GRADIENT
    )
    return kept.fields(surface, kind="Press", method="bem", grid=[n, n], **wanted)


def _dial(kept: Kept, dial: str, wholes: list[Stored]) -> None:
    """Judge everything along one dial: means over the surfaces."""
    options = kept.options
    rows: list[dict[str, float]] = []
    for value in options[_OPTION[dial]]:
        turned = {"work": options["work"], "reduced_pressure": options["reduced_pressure"], dial: value}
        several = []
        for k, whole in enumerate(wholes):
            unit = whole.modulus * math.sqrt(whole.moments[1])
            case = {
                "until": float(turned.get("magnification", options["bandwidth"])),
                "work": turned["work"] * full_energy(whole),
                "pressure": turned["reduced_pressure"] * unit,
                "hardness": turned["hardness"] * unit if dial == "hardness" else None,
            }
            one = _case(kept, k, case)
            if one is None:
                kept.ledger.unread.append(f"areas along the dial {dial}: the store lacks solves")
                return
            several.append(one)
        rows.append(_over_surfaces(several))
    names = ["area", "area_error", "plain", "interface", "persson_plain"]
    names += ["yielded"] if dial == "hardness" else []
    for name in names:
        loose = {"rtol": 1e-6, "atol": 1e-9} if name == "interface" else {}
        kept.array(_name(name, dial), [row[name] for row in rows], **loose)
    if dial == "work":
        kept.array("reach", [row["reach"] for row in rows], rtol=1e-7)


def _over_surfaces(several: list[dict[str, float]]) -> dict[str, float]:
    """Means; beside the mean error of the grids, which all surfaces share, the standard error of the area."""
    n = len(several)
    found = {name: math.fsum(one[name] for one in several) / n for name in several[0]}
    squares = math.fsum((one["area"] - found["area"]) ** 2 for one in several)
    scatter = math.sqrt(squares / (n - 1) / n) if n > 1 else 0.0
    return found | {"area_error": math.hypot(found["area_error"], scatter)}


def _case(kept: Kept, k: int, case: dict[str, Any]) -> dict[str, float] | None:
    """Areas, energy and plain theory of one surface; None without its solves."""
    grids = kept.options["grids"]
    hard = [] if case["hardness"] is None else [{"kind": "hardness", "hardness": case["hardness"]}]
    attraction = {"kind": "adhesion", "work": case["work"]}
    load = {"pressure": case["pressure"]}
    sticky = [_solve(kept, k, case["until"], n, load=load, effects=[attraction, *hard]) for n in grids]
    plain = [_solve(kept, k, case["until"], n, load=load, effects=hard) for n in grids]
    with_it, without = ([one for one in found if one is not None] for found in (sticky, plain))
    if len(with_it) < 2 or len(without) < 2:
        return None
    finest = with_it[-1]
    told = next(effect for effect in finest.recipe["effects"] if effect["kind"] == "adhesion")
    for one in (*with_it, *without):
        place = f"p0 = {case['pressure']:.4g} Pa, w = {case['work']:.4g} J/m^2, {one.grid[0]}x{one.grid[1]}"
        kept.ledger.number(place, "mean pressure [Pa]", one.mean_pressure, case["pressure"], rtol=1e-6)
        kept.ledger.same(place, "status", one.said["status"], "CONVERGED")

    def limit(values: list[float]) -> float:
        coarse, fine = (1 / n for n in grids)
        value = (values[1] * coarse - values[0] * fine) / (coarse - fine)
        return float(np.clip(value, 0.0, 1.0))

    area = limit([one.pixel for one in with_it])
    law = -case["work"] * np.exp(-np.maximum(finest.gap, 0.0) / told["reach"])
    variance = finest.modulus**2 * finest.moments[1] / 4
    if case["hardness"] is None:
        theory = math.erf(case["pressure"] / math.sqrt(2 * variance))
    else:
        theory = sum(yielded_areas(case["pressure"], variance=variance, hardness=case["hardness"]))
    return {
        "area": area,
        "area_error": abs(area - finest.pixel),
        "plain": limit([one.pixel for one in without]),
        "interface": (-float(np.mean(law)) - stored_energy(finest)) / case["work"],
        "persson_plain": theory,
        "yielded": limit([one.plastic for one in with_it]),
        "reach": told["reach"] / math.sqrt(finest.moments[0]),
    }


def _general(kept: Kept) -> None:
    """Judge what is said of the surfaces of all numbers."""
    surfaces = kept.options["surfaces"]
    if surfaces > 1:
        said(
            kept,
            "Means over {n} surfaces; +- is one standard error, that of the surfaces and the step to the limit "
            "together.",
            n=float(surfaces),
        )
    else:
        said(
            kept,
            "These are numbers of one surface: how much another of the same spectrum would differ is unknown.",
        )


def _sentence(kept: Kept, dial: str, k: int) -> None:
    def value(name: str) -> float:
        return float(kept[_name(name, dial)][k])

    values: dict[str, float] = {
        "at": float(kept[dial][k]),
        "gain": value("area") / value("plain"),
        "area": value("area"),
        "error": value("area_error"),
    }
    text = (
        f"{_DIALS[dial]} = {{at:3}}: adhesion multiplies the area by {{gain:3}} by boundary elements (A/A0 = "
        "{area} +- {error})"
    )
    for reading in ("improved", "old"):
        if math.isfinite(value(reading)):
            text += f", by {{{reading}:3}} in the theory ({reading})"
            values[reading] = value(reading) / value("persson_plain")
        else:
            text += f"; the theory ({reading}) gives no answer"
    if dial == "hardness":
        text += "; A_pl/A0 = {yielded}, {theory} in the theory"
        values |= {"yielded": value("yielded"), "theory": value("yielded_persson")}
    else:
        text += "; the interface gains {gained:3} w, {theory:3} in the theory ({old_theory:3}, old)"
        values |= {"gained": value("interface"), "theory": value("macroscopic")}
        values["old_theory"] = value("macroscopic_old")
    said(kept, f"{text}.", **values)
