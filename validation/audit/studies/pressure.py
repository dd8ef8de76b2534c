"""The study `pressure` again: area, gap, energy, stiffness and patches against load, and their distances."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from validation.audit.stored import Array
from validation.audit.studies.distributions import apart, moved, predicted_shares, reference_of
from validation.audit.studies.kept import Kept, Numbers, base_surface, own_grid
from validation.audit.studies.numbers import (
    VARIANTS,
    drift_of,
    half_width,
    limits_of,
    persson,
    variant_area,
)
from validation.audit.studies.said import modes, said, table

__all__ = ["finest", "judge", "measured", "slope", "theory_areas"]

_WITH_ENERGY = ("persson", "yang_persson", "wang_mueser")


def measured(kept: Kept) -> list[Numbers] | None:
    """Return the stored measurements, one for each surface; None without them."""
    options = kept.options
    grids = [own_grid(options, n) for n in options["points_per_wave"]]
    found = [
        kept.numbers(
            base_surface(options, seed=options["seed"] + k),
            kind="Distributions",
            reduced_pressures=options["reduced_pressures"],
            grids=[[n, n] for n in grids],
            shifts=options["shifts"],
            tolerance=1e-8,
        )
        for k in range(options["surfaces"])
    ]
    sound = [one for one in found if one is not None]
    return sound if len(sound) == len(found) else None


def finest(rows: Sequence[Numbers], name: str) -> Array:
    """Return a quantity on the finest grid, mean over shifts, (surface, load)."""
    return np.array([one[name][-1].mean(axis=0) for one in rows])


def slope(gap: Array, loads: Array) -> Array:
    """-d gap / d ln p0 along the last axis, by the parabola through neighbouring loads."""
    x, y = np.log(loads), np.asarray(gap)
    left, right = np.diff(x)[:-1], np.diff(x)[1:]
    d = np.diff(y, axis=-1) / np.diff(x)
    inner = (left * d[..., 1:] + right * d[..., :-1]) / (left + right)
    return -np.concatenate([d[..., :1], inner, d[..., -1:]], axis=-1)


def judge(kept: Kept) -> None:
    """Judge dataset, table and sentences."""
    loads = np.asarray(kept.options["reduced_pressures"], dtype=float)
    rows = measured(kept)
    if rows is None:
        kept.ledger.unread.append("numbers of the surfaces: the store lacks solves")
    else:
        _solves(kept, rows)
        kept.array("theory_area", theory_areas(rows, loads), rtol=1e-6)
    kept.array("reduced_pressure", loads)
    kept.array("stress_upper", np.linspace(0, 4, 321)[1:])
    kept.array("patch_upper", 10 ** np.linspace(-4, 4, 161)[1:])
    kept.array("gamma", slope(kept["gap"], loads), atol=1e-12)
    with np.errstate(invalid="ignore"):
        kept.array("theory_gamma", slope(kept["theory_gap"], loads), atol=1e-12)
    kept.ledger.unread.append("theory of gap and energy: integrals over the waves of the surfaces")
    _table(kept, loads)
    _sentences(kept, loads)


def _solves(kept: Kept, rows: Sequence[Numbers]) -> None:
    """Judge the dataset beside the stored measurements."""
    wave = 1e-3 / kept.options["periods"] / kept.options["bandwidth"]
    height = np.array([[float(one.attributes["rms_height"])] for one in rows])
    full = np.array([[float(one.attributes["full_contact_energy"])] for one in rows])
    kept.array("area", [limits_of(one)[0] for one in rows], rtol=1e-7)
    kept.array("area_error", [limits_of(one)[1] for one in rows], rtol=1e-5, atol=1e-9)
    kept.array("area_drift", [drift_of(one) for one in rows], rtol=1e-4, atol=1e-9)
    kept.array("pixel", finest(rows, "pixel"))
    kept.array("gap", finest(rows, "mean_gap") / height)
    kept.array("energy", finest(rows, "energy") / full)
    kept.array("patches", finest(rows, "patches"))
    kept.array("patch_size", finest(rows, "patch_size") / wave**2)
    for name, source, scale in (("gap_error", "mean_gap", height), ("energy_error", "energy", full)):
        change = [np.abs(one[source][-1].mean(axis=0) - one[source][-2].mean(axis=0)) for one in rows]
        kept.array(name, np.array(change) / scale, rtol=1e-7, atol=1e-12)
    for name in ("stress", "patch_area", "patch_number"):
        kept.array(f"{name}_share", [one[f"{name}_profile"][-1] for one in rows])
    # What the histograms of pressure say twice: their sum is the counted area.
    kept.ledger.number(
        "data.nc",
        "sum of the shares by pressure, over the counted area",
        float(np.max(np.abs(kept["stress_share"].sum(axis=2) / kept["pixel"] - 1))),
        0.0,
        atol=1.0 if kept.options["shifts"] > 1 else 1e-9,
    )


def theory_areas(rows: Sequence[Numbers], loads: Array) -> Array:
    """A/A0 of each variant, told the gradient and from C(q) alone, (mode, variant, load)."""
    gradient = np.array([float(one.attributes["rms_gradient"]) for one in rows])
    # Surfaces are pressed with p* of their own gradient; C(q) expects .1, scattered as the realised ones.
    expected = 0.1 * gradient / math.sqrt(float(np.mean(gradient**2)))
    ratio = np.unique(np.round(np.divide.outer(gradient, expected).ravel(), 12), return_counts=True)
    found = []
    for mode in ("conditional", "ensemble"):
        own = ([1.0], [1]) if mode == "conditional" else ratio
        weight = np.asarray(own[1]) / np.sum(own[1])
        found.append(
            [
                [float(weight @ [variant_area(p * r, name) for r in own[0]]) for p in loads]
                for name in VARIANTS
            ]
        )
    return np.array(found)


def _table(kept: Kept, loads: Array) -> None:
    reference = reference_of(kept["area"])
    distances = {
        "pressure": moved(kept["stress_share"], reference),
        "patch size by area": moved(kept["patch_area_share"], reference),
        "patch size by number": moved(kept["patch_number_share"], reference),
    }
    columns = (
        "p*",
        "A/A0 limit",
        "+- (95 %)",
        "kappa",
        "A/A0 Persson, conditional",
        "A/A0 Persson, ensemble",
        "gap/h_rms",
        "Persson",
        "p0/(K h_rms)",
        "Persson",
        "U/U_full",
        "Persson (Eq. 43)",
        "patches",
        "mean patch/lambda_short^2",
        *(f"distance of the {name} distribution" for name in distances),
    )
    rows = []
    for j, p in enumerate(loads):
        area = kept["area"][:, j]
        beside = [
            cell
            for name in ("gap", "gamma", "energy")
            for cell in (float(kept[name][:, j].mean()), float(kept[f"theory_{name}"][0, 0, j]))
        ]
        rows.append(
            (
                float(p),
                float(area.mean()),
                half_width(area),
                float(area.mean() / p),
                float(kept["theory_area"][0, 0, j]),
                float(kept["theory_area"][1, 0, j]),
                *beside,
                float(kept["patches"][:, j].mean()),
                float(kept["patch_size"][:, j].mean()),
                *(float(one.value[j]) for one in distances.values()),
            )
        )
    table(kept, columns, rows)


def _sentences(kept: Kept, loads: Array) -> None:
    area = kept["area"].mean(axis=0)
    ratio = area / persson(loads)
    told = [j for j in range(loads.size) if math.isfinite(ratio[j])]
    parts = ", ".join(f"{{r{j}}} at A/A0 = {{a{j}:3}}" for j in told)
    values = {f"r{j}": float(ratio[j]) for j in told} | {f"a{j}": float(area[j]) for j in told}
    said(kept, f"Simulated area (limit) over Persson's: {parts}.", **values)
    modes(kept, kept["theory_area"][0, 0], kept["theory_area"][1, 0])
    for name, words in (
        ("gap", "mean gap"),
        ("gamma", "inverse stiffness p0/(K h_rms)"),
        ("energy", "elastic energy"),
    ):
        _beside(kept, name, words, area)
    if np.count_nonzero(area < 0.1) > 1:
        _light(kept, area, loads)
    reference = reference_of(kept["area"])
    upper, width = kept["stress_upper"], np.full(loads.size, math.sqrt(0.5))
    shares = predicted_shares(upper, loads, width)
    own = apart(shares, shares[reference])
    for start, name in (
        ("P(sigma) A0/A", "stress"),
        ("The distribution of patch sizes by area", "patch_area"),
        ("The distribution of patch sizes by number", "patch_number"),
    ):
        _claim(kept, start, kept[f"{name}_share"], own if name == "stress" else None)


def _beside(kept: Kept, name: str, words: str, area: Array) -> None:
    """Judge a quantity over that of each variant that has an energy."""
    open_contact = [j for j in range(area.size) if area[j] < 0.9]
    picked = open_contact[:: max(1, len(open_contact) // 4)]
    values = {f"a{j}": float(area[j]) for j in picked}
    parts = []
    for v, variant in enumerate(VARIANTS):
        if variant in _WITH_ENERGY:
            simulated = kept[name].mean(axis=0)
            values |= {f"{variant}{j}": float(simulated[j] / kept[f"theory_{name}"][0, v, j]) for j in picked}
            parts.append(f"{VARIANTS[variant]} " + ", ".join(f"{{{variant}{j}}}" for j in picked))
    where = ", ".join(f"{{a{j}:2}}" for j in picked)
    said(kept, f"Simulated {words} over that of the theory at A/A0 = {where}: {'; '.join(parts)}.", **values)


def _light(kept: Kept, area: Array, loads: Array) -> None:
    light = np.flatnonzero(area < 0.1)
    first, last = int(light[0]), int(light[-1])
    kappa, gamma = area / loads, kept["gamma"].mean(axis=0)[light]
    size, count = (kept[name].mean(axis=0) for name in ("patch_size", "patches"))
    said(
        kept,
        "Between A/A0 = {a:2} and {b:2} kappa goes from {k} to {l}, the mean patch size grows {s}-fold and the "
        "number of patches {n}-fold, where the theories of independent patches say that size stays and number "
        "grows with the area, {g}-fold.",
        a=float(area[first]),
        b=float(area[last]),
        k=float(kappa[first]),
        l=float(kappa[last]),
        s=float(size[last] / size[first]),
        n=float(count[last] / count[first]),
        g=float(area[last] / area[first]),
    )
    said(
        kept,
        "The mean gap falls with ln p0 by gamma h_rms with gamma = {low} to {high} at these loads.",
        low=float(gamma.min()),
        high=float(gamma.max()),
    )


def _claim(kept: Kept, start: str, shares: Array, own: Array | None) -> None:
    """Judge what is said of a distribution that should not move with load."""
    area, reference = kept["area"].mean(axis=0), reference_of(kept["area"])
    found, heavier = moved(shares, reference), range(reference + 1, area.size)
    same = []
    for j in heavier:
        if found.high[j] > 0.05:
            break
        same.append(j)
    seen = [j for j in heavier if found.low[j] > found.noise[j]]
    shown = list(heavier)[:4]
    values: dict[str, float] = {"r": float(area[reference])}
    for j in shown:
        values |= {
            f"v{j}": float(found.value[j]),
            f"l{j}": float(found.low[j]),
            f"h{j}": float(found.high[j]),
        }
        values |= {f"a{j}": float(area[j])}
    rows = ", ".join(f"{{v{j}}} [{{l{j}}}, {{h{j}}}] at {{a{j}:2}}" for j in shown)
    verdict = "the claim does not hold within 0.05 at any heavier load of the path"
    if same:
        verdict = "the claim holds up to A/A0 = {up:2} within {within}"
        values |= {"up": float(area[same[-1]]), "within": float(found.high[same[-1]])}
    if seen:
        told = "the change is told from the scatter between surfaces ({noise}) from A/A0 = {since:2} on"
        values |= {"noise": float(found.noise[seen[0]]), "since": float(area[seen[0]])}
    else:
        told = "no change is told from the scatter between surfaces ({noise})"
        values |= {"noise": float(found.noise[list(heavier)].max())} if shown else {}
    theirs = ""
    if own is not None:
        theirs = " Persson's own distribution moves by " + ", ".join(f"{{o{j}}}" for j in shown) + "."
        values |= {f"o{j}": float(own[j]) for j in shown}
    said(
        kept,
        f"{start}, against that at A/A0 = {{r:2}}: largest difference of the cumulated shares {rows}; "
        f"{verdict}, and {told}.{theirs}",
        **values,
    )
