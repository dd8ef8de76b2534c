"""The study `theory-verdict` again: simulated over predicted, its intervals, and the words they are given."""

from __future__ import annotations

import math

import numpy as np

from validation.audit.stored import Array
from validation.audit.studies import pressure
from validation.audit.studies.distributions import apart, moved, predicted_shares, reference_of
from validation.audit.studies.kept import Kept, Numbers
from validation.audit.studies.numbers import VARIANTS, drift_of, grid_share, half_width, limits_of
from validation.audit.studies.said import budget, modes, said, table

__all__ = ["judge"]

_QUANTITIES = {
    "area": "contact area",
    "gap": "mean gap",
    "gamma": "stiffness, as p0/(K h_rms)",
    "energy": "elastic energy",
}
_RANGES = ((0.0, 0.03), (0.03, 0.1), (0.1, 0.3), (0.3, 0.7), (0.7, 0.99), (0.99, 1.001))
_CLAIMS = {
    "pressure": ("stress", "P(sigma) A0/A independent of load (Secs. 3.3, 13)"),
    "patches": ("patch_area", "patch sizes by area independent of load (Secs. 3.3, 13)"),
    "number": ("patch_number", "patch sizes by number independent of load (Secs. 3.3, 13)"),
}


def judge(kept: Kept) -> None:
    """Judge dataset, table, budget and sentences."""
    rows = pressure.measured(kept)
    if rows is None:
        kept.ledger.unread.append("scores: the store lacks solves")
    else:
        _scores(kept, rows)
    kept.ledger.unread.append("scores of gap, stiffness and energy: the theory's integrals over the waves")
    _table(kept)
    _budget(kept)
    _sentences(kept)


def _scores(kept: Kept, rows: list[Numbers]) -> None:
    """Judge the scores of the area, and the distances of the distributions."""
    loads = np.asarray(kept.options["reduced_pressures"], dtype=float)
    kept.array("reduced_pressure", loads)
    limits = [limits_of(one) for one in rows]
    area, error = (np.array([limit[k] for limit in limits]) for k in (0, 1))
    drift = np.array([drift_of(one) for one in rows])
    kept.array("area", area.mean(axis=0), rtol=1e-7)
    theory = pressure.theory_areas(rows, loads)
    kept.array("theory_area", theory, rtol=1e-6)
    shares = np.array(
        [
            (grid_share(area[:, j], error[:, j], drift[:, j]), half_width(area[:, j]) / area[:, j].mean())
            for j in range(loads.size)
        ]
    )
    kept.array("shares", shares, rtol=1e-4, atol=1e-9)
    half = np.maximum(np.hypot(shares[:, 0], shares[:, 1]) * area.mean(axis=0), 1e-9)
    place = [str(name) for name in kept["quantity"]].index("area")
    for name, expected in (("ratio", area.mean(axis=0) / theory[0]), ("interval", half / theory[0])):
        for v, variant in enumerate(VARIANTS):
            for j, p in enumerate(loads):
                kept.ledger.number(
                    "data.nc",
                    f"{name} of the area, {variant}, p* = {p:g}",
                    kept[name][place, v, j],
                    float(expected[v, j]),
                    rtol=1e-4 if name == "interval" else 1e-6,
                )
    stress = np.array([one["stress_profile"][-1] for one in rows])
    upper = np.linspace(0, 4, stress.shape[2] + 1)[1:]
    widths = [_width(theory[0, v], loads) for v in range(len(VARIANTS))]
    distance = [apart(stress.sum(axis=0), predicted_shares(upper, loads, width)) for width in widths]
    kept.array("distance", distance, rtol=1e-4, atol=1e-7)
    reference = reference_of(area)
    kept.ledger.same("data.nc", "reference load", int(kept.said["reference_load"]), reference)
    for name, (profile, _) in _CLAIMS.items():
        found = moved(np.array([one[f"{profile}_profile"][-1] for one in rows]), reference)
        kept.array(f"{name}_moved", found.value)
        kept.array(f"{name}_moved_high", found.high)
        kept.array(f"{name}_moved_noise", found.noise)


def _width(area: Array, loads: Array) -> Array:
    """(2 V)^(1/2) over E* h' that gives an area: p* / erfinv(A/A0), or that of full contact."""
    from scipy.special import erfinv

    closed = area > 1 - 1e-9
    return np.where(closed, math.sqrt(0.5), loads / erfinv(np.where(closed, 0.5, area)))


def _word(ratio: float, interval: float) -> str:
    """Return what a ratio with its half width is called."""
    off = abs(ratio - 1)
    if not math.isfinite(ratio):
        return "says nothing"
    if interval < 1e-6 and off < 1e-4:
        return "exact"
    if off <= interval:
        return f"right within {100 * (off + interval):.2g} %" if interval < 0.1 else "not determinable"
    return f"off by {100 * (ratio - 1):+.2g} %" if ratio < 2 else f"off by a factor of {ratio:.2g}"


def _worst(ratios: Array, intervals: Array) -> str:
    """Return the word for the load that is furthest off beyond its interval, or else that is known best."""
    off = np.abs(ratios - 1)
    decided = [k for k in range(off.size) if off[k] > intervals[k]]
    if decided:
        pick = max(decided, key=lambda k: off[k])
    else:
        pick = int(np.argmin(np.where(np.isfinite(intervals), intervals, np.inf)))
    return _word(float(ratios[pick]), float(intervals[pick]))


def _ranges(kept: Kept) -> list[tuple[str, Array]]:
    area = kept["area"]
    found = [
        (f"{low:g} to {min(high, 1.0):g}", np.flatnonzero((area >= low) & (area < high)))
        for low, high in _RANGES
    ]
    return [(words, loads) for words, loads in found if loads.size]


def _table(kept: Kept) -> None:
    rows: list[tuple[str, ...]] = []
    names, count = [str(name) for name in kept["quantity"]], len(VARIANTS)
    for quantity, words in _QUANTITIES.items():
        q = names.index(quantity)
        for area, loads in _ranges(kept):
            cells = [_worst(kept["ratio"][q, v, loads], kept["interval"][q, v, loads]) for v in range(count)]
            rows.append((words, area, *cells))
    for area, loads in _ranges(kept):
        rows.append(
            (
                "P(sigma) A0/A",
                area,
                *(f"differs by up to {kept['distance'][v, loads].max():.3f}" for v in range(count)),
            )
        )
    if "edge_value" in kept.data:
        rows += _edge_rows(kept)
    for name, (_, words) in _CLAIMS.items():
        for area, loads in _ranges(kept):
            if kept["area"][loads].min() <= 0.3:
                rows.append((words, area, _claim(kept, name, loads), *["says nothing"] * (count - 1)))
    table(kept, ("quantity", "A/A0", *VARIANTS.values()), rows)


def _edge_rows(kept: Kept) -> list[tuple[str, ...]]:
    where = f"at p* = {float(kept['edge_pressure']):g}"
    value, half = float(kept["edge_value"]), float(kept["edge_value_half"])
    zero = f"right within {abs(value) + half:.3f}" if abs(value) <= half else f"off by {value:+.3f}"
    slopes = [
        _word(float(r), float(h))
        for r, h in zip(kept["edge_slope_ratio"], kept["edge_slope_half"], strict=True)
    ]
    return [
        ("P(0+) E*h' = 0", where, *[zero] * len(VARIANTS)),
        ("slope of P(sigma) at 0", where, *slopes),
    ]


def _claim(kept: Kept, name: str, loads: Array) -> str:
    own = [int(j) for j in loads if int(j) != int(kept.said["reference_load"])]
    if not own:
        return "the reference"
    value, high, noise = (kept[f"{name}_moved{end}"] for end in ("", "_high", "_noise"))
    told = [float(value[j]) for j in own if value[j] > noise[j]]
    if told:
        return f"moved by {max(told):.3f}"
    known = min(own, key=lambda j: float(high[j]))
    return f"right within {float(high[known]):.3f}" if high[known] < 0.1 else "not determinable"


def _budget(kept: Kept) -> None:
    rows = []
    for j, p in enumerate(kept["reduced_pressure"]):
        shares = {"grid": float(kept["shares"][j, 0]), "surfaces": float(kept["shares"][j, 1])}
        shares["solver"] = float(kept["solver_error"])
        words = f"A/A_Persson, p* = {p:g}"
        if "ladder_load" in kept.data:
            near = min(
                range(kept["ladder_load"].size), key=lambda k: abs(math.log(kept["ladder_load"][k] / p))
            )
            for k, name in enumerate(kept["spectral_source"]):
                shares[str(name)] = float(kept["spectral"][near, k])
            words += f" (spectrum: as at {float(kept['ladder_load'][near]):g})"
        rows.append((words, float(kept["ratio"][0, 0, j]), shares))
    budget(kept, rows)


def _sentences(kept: Kept) -> None:
    ratio, half = kept["ratio"][0], kept["interval"][0]
    for v, name in enumerate(VARIANTS.values()):
        off = np.where(np.abs(ratio[v] - 1) > half[v], np.abs(ratio[v] - 1), 0.0)
        worst = int(np.argmax(off))
        said(
            kept,
            f"{name}: simulated over predicted area is {{first}} at the lightest load (p* = {{p}}) and {{last}} at "
            "the heaviest; worst {word} at A/A0 = {area:3}.",
            first=float(ratio[v, 0]),
            p=float(kept["reduced_pressure"][0]),
            last=float(ratio[v, -1]),
            word=_word(float(ratio[v, worst]), float(half[v, worst])),
            area=float(kept["area"][worst]),
        )
    inside = kept["area"] < _RANGES[-1][0]
    for q, words in enumerate(_QUANTITIES.values()):
        off = np.abs(kept["ratio"][q][:, inside] - 1).mean(axis=1)
        best = int(np.nanargmin(off))
        said(
            kept,
            f"{words[0].upper()}{words[1:]}, mean distance over these loads below full contact: '{{name}}' is "
            "closest, {best:2} % off; the original theory is {own:2} % off.",
            name=list(VARIANTS.values())[best],
            best=100 * float(off[best]),
            own=100 * float(off[0]),
        )
    modes(kept, kept["theory_area"][0, 0], kept["theory_area"][1, 0])
    if "edge_value" in kept.data:
        said(
            kept,
            "P(sigma) starts from {value} +- {half:2} (over E* h'_rms; the theory: 0), with {slope} +- {error:1} "
            "times the slope of the theory, at p* = {p} on another bandwidth (study stress-near-zero).",
            value=float(kept["edge_value"]),
            half=float(kept["edge_value_half"]),
            slope=float(kept["edge_slope_ratio"][0]),
            error=float(kept["edge_slope_half"][0]),
            p=float(kept["edge_pressure"]),
        )
