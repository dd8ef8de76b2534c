"""The study `hurst` again: kappa of every surface, means over pairs, trends, ladders and their limits."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.special import stdtrit

from validation.audit.stored import Array
from validation.audit.studies.kept import Kept, Numbers, area_tolerance, base_surface, own_grid
from validation.audit.studies.numbers import (
    VARIANTS,
    drift_of,
    grid_share,
    half_width,
    limits_of,
    pairs,
    persson,
    root_sum,
    solver_share,
    variant_area,
)
from validation.audit.studies.said import budget, modes, said, table

__all__ = ["Line", "judge", "judge_ladders", "line_through", "spectral_share"]

STEPS = {"bandwidth": "lambda_short / lambda_long", "size": "lambda_long / L"}
#: A limit further off than this many times the span of the rungs is none.
_REACH = 2.0


def judge(kept: Kept) -> None:
    """Judge dataset, table, budget and sentences."""
    if kept.recipes:
        _solves(kept)
    if "ladder_hurst" in kept.data:
        judge_ladders(kept, kept.options)
    theory = np.array([persson(p) / p for p in kept["reduced_pressure"]])
    _table(kept, theory)
    _budget(kept)
    _sentences(kept, theory)


def _measured(kept: Kept, spectrum: int, surface: int, *, share: float = 1.0) -> Numbers | None:
    """Return the stored measurement of a surface; 2k and 2k + 1 are +h and -h of the k-th."""
    told = {
        "hurst": float(kept["hurst"][spectrum]),
        "bandwidth": float(kept["bandwidth"][spectrum]),
        "periods": kept.options["periods"],
    }
    grids = [own_grid(told, n) for n in kept.options["points_per_wave"]]
    pair, inverted = divmod(surface, 2)
    return kept.numbers(
        base_surface(told, seed=kept.options["seed"] + pair),
        kind="Measurement",
        inverted=True if inverted else None,
        reduced_pressures=kept.options["reduced_pressures"],
        grids=[[n, n] for n in grids],
        shifts=kept.options["shifts"],
        tolerance=share * area_tolerance(told, max(grids)),
        truncation=None,
    )


def _solves(kept: Kept) -> None:
    """Judge the dataset beside the stored measurements."""
    count, surfaces = kept["kappa"].shape[:2]
    found = [[_measured(kept, i, k) for k in range(surfaces)] for i in range(count)]
    if any(one is None for row in found for one in row):
        kept.ledger.unread.append("kappa of the surfaces: the store lacks solves")
        return
    rows = [[one for one in row if one is not None] for row in found]
    p = np.asarray(kept.options["reduced_pressures"])
    kept.array("reduced_pressure", p)

    def over(read: Callable[[Numbers], Any]) -> Array:
        return np.array([[read(one) for one in row] for row in rows])

    kept.array("kappa", over(lambda one: limits_of(one)[0]) / p, rtol=1e-7)
    kept.array("kappa_grid_error", over(lambda one: limits_of(one)[1]) / p, rtol=1e-5)
    kept.array("kappa_grid_drift", over(drift_of) / p, rtol=1e-4, atol=1e-9)
    kept.array("kappa_pixel", over(lambda one: one["pixel"].mean(axis=1)) / p)
    kept.array("kappa_perimeter", over(lambda one: one["perimeter"][-1].mean(axis=0)) / p)
    kept.array("nayak", over(lambda one: one.attributes["nayak"]))
    kept.array("points_per_wave", kept.options["points_per_wave"])
    hursts = kept.options["hursts"]
    kept.array("hurst", np.resize(hursts, count))
    equal = len(kept.options["bandwidths"]) * len(hursts)
    if equal < count:
        kept.ledger.unread.append("data.nc: bandwidth of equal Nayak parameter")
    told = np.repeat(kept.options["bandwidths"], len(hursts))
    kept.array("bandwidth", np.concatenate([told, kept["bandwidth"][equal:]]))
    gradients = over(lambda one: float(one.attributes["rms_gradient"]))
    kept.array("kappa_ensemble", np.array([_from_spectrum(row, p) for row in gradients]) / p, rtol=1e-7)
    strict = _measured(kept, 0, 0, share=0.01)
    if strict is not None:
        kept.array("solver_error", solver_share(rows[0][0], strict), rtol=1e-6, atol=1e-12)


def _from_spectrum(gradients: Array, p: Array) -> Array:
    """A/A0 of each surface at each load from C(q) alone, whose gradient is .1, scattered as the realised ones."""
    expected = 0.1 * gradients / math.sqrt(float(np.mean(gradients**2)))
    return np.array([np.mean([persson(p * own / one) for one in expected], axis=0) for own in gradients])


@dataclass(frozen=True, kw_only=True)
class Line:
    """A straight line in step^order through a ladder, and the half widths of its 95 % intervals."""

    limit: float
    half: float
    slope: float
    slope_half: float
    order: float
    reach: float

    @property
    def determinable(self) -> bool:
        """Whether the rungs come near enough."""
        return self.reach <= _REACH


def line_through(rungs: Sequence[Array], steps: Sequence[float], *, order: float, common: bool) -> Line:
    """Least squares with a fixed order: equal weights for surfaces that all rungs share, or by scatter."""
    x = np.asarray(steps) ** order
    (limit, slope), (half, slope_half) = _fit(rungs, x, common=common)
    drift = slope_drift = 0.0
    if x.size > 2:
        (shorter, steeper), _ = _fit(rungs[1:], x[1:], common=common)
        drift, slope_drift = shorter - limit, steeper - slope
    return Line(
        limit=limit,
        half=root_sum(half, drift),
        slope=slope,
        slope_half=root_sum(slope_half, slope_drift),
        order=order,
        reach=float(x[-1] / (x[0] - x[-1])),
    )


def _fit(
    rungs: Sequence[Array], x: Array, *, common: bool
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Fit a weighted straight line in closed form; return it, and the half widths of intercept and slope."""
    errors = np.array([np.std(rung, ddof=1) / math.sqrt(rung.size) for rung in rungs])
    w = np.ones_like(x) if common else 1 / np.maximum(errors, 1e-3 * errors.max() + 1e-300) ** 2
    s, sx, sxx = w.sum(), w @ x, w @ x**2
    det = s * sxx - sx**2
    rows = np.stack([w * (sxx - sx * x), w * (s * x - sx)]) / det
    value = rows @ np.array([rung.mean() for rung in rungs])
    factor = float(stdtrit(min(rung.size for rung in rungs) - 1, 0.975))
    if common:
        spread = np.std(rows @ np.stack(rungs), axis=1, ddof=1) / math.sqrt(rungs[0].size)
    else:
        spread = np.sqrt(rows**2 @ errors**2)
    return (float(value[0]), float(value[1])), (float(factor * spread[0]), float(factor * spread[1]))


def _rung(kept: Kept, told: dict[str, Any], count: int) -> tuple[Array, float] | None:
    """Kappa of the pairs on one rung, and the half width that grids leave; None without the solves."""
    load = told["load"]
    grids = [own_grid(told, n) for n in told["points"]]
    values, errors = [], []
    for pair, inverted in itertools.product(range(count), (None, True)):
        one = kept.numbers(
            base_surface(told, seed=told["seed"] + pair),
            kind="Measurement",
            inverted=inverted,
            reduced_pressures=[load],
            grids=[[n, n] for n in grids],
            shifts=told["shifts"],
            tolerance=area_tolerance(told, max(grids)),
            truncation=None,
        )
        if one is None:
            return None
        (value,), (error,) = limits_of(one)
        values.append(value / load)
        errors.append(error / load)
    return pairs(np.array(values)), 2 * math.sqrt(float(np.mean(np.square(errors))) / len(errors))


def judge_ladders(kept: Kept, options: dict[str, Any]) -> None:
    """Judge kappa on every rung, and the line through the rungs."""
    told = {
        "periods": options["periods"],
        "shifts": options["shifts"],
        "seed": options["seed"],
        "points": options["ladder_points_per_wave"],
        "load": options["ladder_reduced_pressure"],
    }
    bands, sizes = options["ladder_bandwidths"], options["ladder_periods"]
    kept.array("ladder_hurst", options.get("ladder_hursts", options.get("hursts", [options.get("hurst")])))
    kept.array("bandwidth_step", [1 / band for band in bands])
    kept.array("size_step", [1 / size for size in sizes])
    for kind, rungs in (("bandwidth", bands), ("size", sizes)):
        lines, means, halves = [], [], []
        for hurst in kept["ladder_hurst"]:
            found = []
            for rung in rungs:
                own = {**told, "hurst": float(hurst), "bandwidth": bands[0]}
                own["bandwidth" if kind == "bandwidth" else "periods"] = rung
                count = options["ladder_pairs"]
                if kind == "size":
                    count = max(2, round(count * (sizes[-1] / rung) ** 2))
                found.append(_rung(kept, own, count))
            sound = [rung for rung in found if rung is not None]
            if len(sound) < len(found):
                kept.ledger.unread.append(f"ladder of the {kind}: the store lacks solves")
                return
            samples, grid = [rung for rung, _ in sound], max(error for _, error in sound)
            order = 2 * (1 - float(hurst)) if kind == "bandwidth" else 2.0
            line = line_through(
                samples, [1 / rung for rung in rungs], order=order, common=kind == "bandwidth"
            )
            lines.append((line, grid))
            means.append([sample.mean() for sample in samples])
            halves.append([root_sum(half_width(sample), grid) for sample in samples])
        _ladder_entries(kept, kind, lines, (means, halves))


def _ladder_entries(
    kept: Kept, kind: str, lines: list[tuple[Line, float]], rungs: tuple[list[Any], list[Any]]
) -> None:
    loose = {"rtol": 1e-5, "atol": 1e-9}
    kept.array(f"{kind}_kappa", rungs[0], rtol=1e-7)
    kept.array(f"{kind}_half_width", rungs[1], **loose)
    kept.array(f"{kind}_limit", [line.limit for line, _ in lines], **loose)
    kept.array(f"{kind}_limit_half_width", [root_sum(line.half, grid) for line, grid in lines], **loose)
    kept.array(f"{kind}_slope", [line.slope for line, _ in lines], **loose)
    kept.array(f"{kind}_slope_half_width", [line.slope_half for line, _ in lines], **loose)
    kept.array(f"{kind}_order", [line.order for line, _ in lines])
    kept.array(f"{kind}_reach", [line.reach for line, _ in lines])


def spectral_share(kept: Kept, kind: str, *, hurst: float, step: float) -> float:
    """How far kappa at a step may be from its limit: shift and its uncertainty, over the limit."""
    found = np.flatnonzero(np.isclose(kept["ladder_hurst"], hurst))
    if not found.size or float(kept[f"{kind}_reach"][found[0]]) > _REACH:
        return math.nan
    k = int(found[0])
    power = float(step ** kept[f"{kind}_order"][k])
    slope, half = float(kept[f"{kind}_slope"][k]), float(kept[f"{kind}_slope_half_width"][k])
    return power * (abs(slope) + half) / float(kept[f"{kind}_limit"][k])


def _mean(kept: Kept, name: str, i: int, j: int) -> tuple[float, float]:
    """Mean over pairs of a spectrum at a load and its half width; counted on the finest grid."""
    values = kept[name][i, :, -1, j] if kept[name].ndim == 4 else kept[name][i, :, j]
    own = pairs(values)
    return float(own.mean()), half_width(own)


def _share(kept: Kept, i: int, j: int) -> float:
    parts = (kept[name][i, :, j] for name in ("kappa", "kappa_grid_error", "kappa_grid_drift"))
    return grid_share(*parts)


def _cases(kept: Kept) -> list[tuple[int, int, float]]:
    loads = kept["reduced_pressure"]
    return [(i, j, float(p)) for i in range(kept["kappa"].shape[0]) for j, p in enumerate(loads)]


def _table(kept: Kept, theory: Array) -> None:
    finest, coarsest = kept["points_per_wave"][-1], kept["points_per_wave"][0]
    others = {words: name for name, words in VARIANTS.items() if name != "persson"}
    columns = (
        "H",
        "lambda_long/lambda_short",
        "Nayak (realised)",
        "p*",
        "kappa limit",
        "+- (95 %, surfaces)",
        "+- (95 %, grid)",
        f"counted at lambda_short/dx = {finest:g}",
        f"counted at {coarsest:g}",
        "Persson, conditional",
        "Persson, ensemble",
        *others,
    )
    rows = []
    for i, j, p in _cases(kept):
        value, half = _mean(kept, "kappa", i, j)
        rows.append(
            (
                float(kept["hurst"][i]),
                float(kept["bandwidth"][i]),
                float(kept["nayak"][i].mean()),
                p,
                value,
                half,
                value * _share(kept, i, j),
                _mean(kept, "kappa_pixel", i, j)[0],
                float(kept["kappa_pixel"][i, :, 0, j].mean()),
                float(theory[j]),
                float(kept["kappa_ensemble"][i, :, j].mean()),
                *(variant_area(p, name) / p for name in others.values()),
            )
        )
    table(kept, columns, rows, rtol=1e-7)


def _budget(kept: Kept) -> None:
    rows = []
    for i, j, p in _cases(kept):
        value, half = _mean(kept, "kappa", i, j)
        shares = {
            "grid": _share(kept, i, j),
            "solver": float(kept["solver_error"]),
            "surfaces": half / value,
        }
        hurst = float(kept["hurst"][i])
        name = f"kappa, H = {hurst:g}, {kept['family'][i]}, p* = {p:g}"
        if "ladder_hurst" in kept.data:
            steps = {
                "size": 1 / kept.options["periods"],
                "bandwidth": 1 / float(kept["bandwidth"][i]),
            }
            size, band = (spectral_share(kept, kind, hurst=hurst, step=s) for kind, s in steps.items())
            shares |= {"finite size": size, "bandwidth": band}
            at = kept.options["ladder_reduced_pressure"]
            name += f" (spectrum: as at {at:g})" if p != at else ""
        rows.append((name, value, shares))
    budget(kept, rows)


def _sentences(kept: Kept, theory: Array) -> None:
    families = [str(family) for family in kept["family"]]
    for family in dict.fromkeys(families):
        part = [i for i, own in enumerate(families) if own == family]
        if len(part) > 1:
            _trend(kept, family, part)
    loads = kept["reduced_pressure"]
    ratio = kept["kappa"].mean(axis=(0, 1)) / theory
    words = ", ".join(f"{{r{j}}} at p* = {p:g}" for j, p in enumerate(loads))
    said(
        kept,
        f"The limit over Persson's theory is {words} (mean over the spectra).",
        **{f"r{j}": float(r) for j, r in enumerate(ratio)},
    )
    _counting(kept)
    modes(kept, np.broadcast_to(theory, kept["kappa_ensemble"].shape), kept["kappa_ensemble"])
    if "ladder_hurst" in kept.data and kept["ladder_hurst"].size > 1:
        _equal_alpha(kept)
    for k in range(kept["ladder_hurst"].size if "ladder_hurst" in kept.data else 0):
        _over_magnification(kept, k)
    for kind in STEPS:
        for k in range(kept["ladder_hurst"].size if "ladder_hurst" in kept.data else 0):
            _ladder(kept, kind, k)


def _counting(kept: Kept) -> None:
    """Judge how much of the spread over H and loads is the grid's, in the first family."""
    family = str(kept["family"][0])
    part = [i for i, own in enumerate(kept["family"]) if own == family]
    true = kept["kappa"][part].mean(axis=1)
    values = {"a": float(true.min()), "b": float(true.max()), "s": 100 * float(true.max() / true.min() - 1)}
    words = []
    for g in sorted({0, kept["points_per_wave"].size - 1}):
        seen = kept["kappa_pixel"][part][:, :, g].mean(axis=1)
        values |= {f"a{g}": float(seen.min()), f"b{g}": float(seen.max())}
        values[f"s{g}"] = 100 * float(seen.max() / seen.min() - 1)
        values[f"m{g}"] = 100 * float(seen.mean() / true.mean() - 1)
        words.append(
            f"at lambda_short/dx = {float(kept['points_per_wave'][g]):g} from {{a{g}}} to {{b{g}}} (spread "
            f"{{s{g}}} %, {{m{g}}} % on average)"
        )
    said(
        kept,
        f"Counting points gives kappa, over all H and loads of {family}, {' and '.join(words)}; the limit goes "
        "from {a} to {b} (spread {s} %): what is more is the grid's.",
        **values,
    )


def _equal_alpha(kept: Kept) -> None:
    """Judge H at equal Nayak parameter, and the Nayak parameter at equal H, along the ladders of bandwidth."""
    alpha, kappa, hurst = kept["bandwidth_nayak"], kept["bandwidth_kappa"], kept["ladder_hurst"]
    common = float(alpha[:, -1].min())
    if common < alpha[:, 0].max():
        start = "The bandwidth ladders share no Nayak parameter: "
        said(kept, start + "H at equal alpha cannot be read off them.")
        return
    at = np.array([np.interp(math.log(common), np.log(a), k) for a, k in zip(alpha, kappa, strict=True)])
    values = {"alpha": common, "within": 100 * float(at.max() / at.min() - 1)}
    values |= {"low": float(at.min()), "high": float(at.max())}
    words = []
    for k, h in enumerate(hurst):
        values |= {f"c{k}": 100 * float(kappa[k, -1] / kappa[k, 0] - 1)}
        values |= {f"a{k}": float(alpha[k, 0]), f"b{k}": float(alpha[k, -1])}
        words.append(f"{{c{k}}} % from {{a{k}:2}} to {{b{k}:2}} (H = {float(h):g})")
    said(
        kept,
        "H at equal alpha: at the Nayak parameter {alpha:3} kappa of all bandwidth ladders, H = "
        f"{float(hurst.min()):g} to {float(hurst.max()):g}, lies within {{within}} % ({{low}} to {{high}}). Alpha "
        f"at equal H: it changes by {', '.join(words)}.",
        **values,
    )


#: alpha over Persson's for D_f = 2.2, as he quotes it (2006, Sec. 3.5).
_PUBLISHED = {
    "molecular dynamics (Yang, Tartaglino, Persson 2006)": 1.14,
    "finite elements (Hyun et al. 2004)": 1.13,
    "discretised continuum (Borri-Brunetto 2006)": 0.8,
}


def _over_magnification(kept: Kept, k: int) -> None:
    """Judge the slope of the area over the load, over the theory's, along one ladder of bandwidth."""
    load, hurst = float(kept.options["ladder_reduced_pressure"]), float(kept["ladder_hurst"][k])
    theory = persson(load) / load
    ratio, half = (kept[f"bandwidth_{name}"][k] / theory for name in ("kappa", "half_width"))
    zeta = 1 / kept["bandwidth_step"]
    values = {"f": 100 * abs(float(ratio[-1] / ratio[0]) - 1)}
    for i, (r, e) in enumerate(zip(ratio, half, strict=True)):
        values |= {f"r{i}": float(r), f"e{i}": float(e)}
    words = ", ".join(f"{{r{i}}} +- {{e{i}:2}} at zeta = {float(z):g}" for i, z in enumerate(zeta))
    end = "less" if ratio[-1] > ratio[0] else "more"
    form = (
        f"D_f = {3 - hurst:.2g}: the slope alpha(zeta) of A over the load, over Persson's (Eq. 22), is {words}: "
        f"as waves are added it falls {{f}} % {end} than his."
    )
    if math.isclose(hurst, 0.8):
        told = (
            f"{v:g} by {s}{'' if abs(v - ratio[-1]) <= half[-1] else ' (outside the interval)'}"
            for s, v in _PUBLISHED.items()
        )
        form += f" Published for this D_f: {', '.join(told)}."
    said(kept, form, **values)


def _trend(kept: Kept, family: str, part: list[int]) -> None:
    """Judge the change from the lowest to the highest H, surface by surface."""
    first = min(part, key=lambda i: kept["hurst"][i])
    last = max(part, key=lambda i: kept["hurst"][i])
    values: dict[str, float | str] = {"a": float(kept["nayak"][first].mean())}
    values["b"] = float(kept["nayak"][last].mean())
    words = []
    for j, p in enumerate(kept["reduced_pressure"]):
        change = pairs(kept["kappa"][last, :, j] / kept["kappa"][first, :, j] - 1)
        mean, half = float(change.mean()), half_width(change)
        values |= {f"c{j}": 100 * mean, f"h{j}": 100 * half}
        undecided = " (not told from zero)" if abs(mean) <= half else ""
        words.append(f"{{c{j}}} +- {{h{j}}} % at p* = {p:g}{undecided}")
    said(
        kept,
        f"Spectra of {family}: from H = {float(kept['hurst'][first]):g} to {float(kept['hurst'][last]):g} "
        f"(Nayak parameter {{a:2}} to {{b:2}}) kappa changes by {', '.join(words)}.",
        **values,
    )


def _ladder(kept: Kept, kind: str, k: int) -> None:
    kappa, steps = kept[f"{kind}_kappa"][k], kept[f"{kind}_step"]
    numbers: dict[str, float] = {"first": float(kappa[0]), "last": float(kappa[-1])}
    start = (
        f"H = {float(kept['ladder_hurst'][k]):g}, p* = {kept.options['ladder_reduced_pressure']:g}: kappa goes "
        f"from {{first}} to {{last}} as {STEPS[kind]} falls from 1/{1 / steps[0]:g} to 1/{1 / steps[-1]:g}"
    )
    if kind == "bandwidth":
        alpha = kept["bandwidth_nayak"][k]
        start += " (at equal H, with the Nayak parameter from {a:2} to {b:2})"
        numbers |= {"a": float(alpha[0]), "b": float(alpha[-1])}
    numbers |= {"order": float(kept[f"{kind}_order"][k]), "reach": float(kept[f"{kind}_reach"][k])}
    if numbers["reach"] > _REACH:
        end = "; its limit is not determinable: with the order {order:2} it lies {reach} times "
        said(kept, f"{start}{end}as far away as these rungs span.", **numbers)
        return
    numbers |= {"limit": float(kept[f"{kind}_limit"][k]), "half": float(kept[f"{kind}_limit_half_width"][k])}
    slope, half = (float(kept[f"{kind}_slope{end}"][k]) for end in ("", "_half_width"))
    decided = "." if abs(slope) > half else ", and no trend is told from zero."
    said(
        kept,
        f"{start}; with the fixed order {{order:2}} the limit is {{limit}} +- {{half:2}} (95 %){decided}",
        **numbers,
    )
