"""The study `refinement` again: areas on every grid against the limit, moments of P(sigma), finite elements, kappa."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from validation.audit.stored import Array
from validation.audit.studies.hurst import judge_ladders, spectral_share
from validation.audit.studies.kept import Kept, Numbers, base_surface, own_grid
from validation.audit.studies.numbers import (
    drift_of,
    grid_share,
    half_width,
    limits_of,
    order_of,
    persson,
    root_sum,
    solver_share,
)
from validation.audit.studies.said import budget, modes, said, table

__all__ = ["judge"]

_AREAS = ("pixel", "perimeter", "subcell")
_SMALL, _STRESS_TOP, _BINS = 0.2, 4.0, 320


def judge(kept: Kept) -> None:
    """Judge dataset, table, budget and sentences."""
    rows = [_measured(kept, k) for k in range(kept.options["surfaces"])]
    sound = [one for one in rows if one is not None]
    if len(sound) < len(rows):
        kept.ledger.unread.append("areas of the surfaces: the store lacks solves")
    else:
        _boundary_elements(kept, sound)
        _protocol(kept)
        if "element" in kept.data:
            _finite_elements(kept)
    if "ladder_hurst" in kept.data:
        usual = {
            "ladder_bandwidths": (4.0, 8.0, 16.0, 32.0),
            "ladder_periods": (2.0, 4.0, 8.0),
            "ladder_pairs": 4,
            "ladder_points_per_wave": (4.0, 6.0),
            "ladder_reduced_pressure": kept.options["reduced_pressure"],
            "shifts": 2,
        }
        judge_ladders(kept, {**kept.options, **usual})
    _table(kept)
    _budget(kept)
    _sentences(kept)


def _measured(kept: Kept, k: int, *, grids: int | None = None, tolerance: float = 1e-8) -> Numbers | None:
    options = kept.options
    points = [own_grid(options, n) for n in options["points_per_wave"]][:grids]
    return kept.numbers(
        base_surface(options, seed=options["seed"] + k),
        kind="Distributions",
        reduced_pressures=[options["reduced_pressure"]],
        grids=[[n, n] for n in points],
        shifts=options["shifts"],
        tolerance=tolerance,
    )


def _boundary_elements(kept: Kept, rows: list[Numbers]) -> None:
    for name in (*_AREAS, "density_at_zero", "patches", "cells_per_patch", "edge_fraction", "residual"):
        kept.array(name, [one[name][:, :, 0].mean(axis=1) for one in rows])
    kept.array("seconds", [one["seconds"][:, :, 0].sum(axis=1) for one in rows])
    kept.array("first_moment", [one["load_profile"][:, 0].sum(axis=1) for one in rows])
    density = np.mean([one["stress_profile"][:, 0] for one in rows], axis=0) * _BINS / _STRESS_TOP
    kept.array("density", density)
    parts, per_wave = (0.1, 0.5, 0.9), kept.options["points_per_wave"]
    kept.array("part", parts)
    kept.array("points_per_wave", per_wave)
    cells = [
        [[_percentile(row, part) * n**2 for part in parts] for row, n in zip(one, per_wave, strict=True)]
        for one in (own["patch_area_profile"][:, 0] for own in rows)
    ]
    kept.array("cells", cells)
    gradients = np.array([float(one.attributes["rms_gradient"]) for one in rows])
    expected = 0.1 * gradients / math.sqrt(float(np.mean(gradients**2)))
    areas = [persson(kept.options["reduced_pressure"] * own / expected) for own in gradients]
    kept.array("ensemble", np.mean(areas), rtol=1e-7)
    kept.array("theory", persson(kept.options["reduced_pressure"]), rtol=1e-7)
    kept.array("stress", (np.arange(_BINS) + 0.5) * _STRESS_TOP / _BINS)
    kept.array("limit", [limits_of(one)[0][0] for one in rows], rtol=1e-7)
    kept.array("limit_error", [limits_of(one)[1][0] for one in rows], rtol=1e-5, atol=1e-10)
    kept.array("limit_drift", [drift_of(one)[0] for one in rows], rtol=1e-4, atol=1e-9)
    few = max(2, sum(n <= 8.0 for n in kept.options["points_per_wave"]))
    strict = _measured(kept, 0, grids=few, tolerance=1e-10)
    if strict is not None:
        resolved = int(np.sum(rows[0]["points_per_wave"][:few] >= 3 * (1 - 1e-9)))
        kept.array("solver_error", solver_share(rows[0], strict, grids=resolved), rtol=1e-6, atol=1e-12)


def _percentile(shares: Array, part: float) -> float:
    """Patch area over lambda_short^2 below which a part of the area lies, along the logarithm of the edges."""
    total = np.concatenate([[0.0], np.cumsum(shares)]) / np.sum(shares)
    return float(10 ** np.interp(part, total, np.linspace(-4, 4, shares.size + 1)))


def _protocol(kept: Kept) -> None:
    options = kept.options
    found = []
    for k in range(options["surfaces"]):
        surface = base_surface(options, seed=options["seed"] + k)
        del surface["lambda_short"]
        for n in options["grid_scale_grids"]:
            one = kept.numbers(surface, kind="GridRoughness", points=n)
            if one is None:
                return
            found.append(one["kappa"])
    kept.array("kappa_grid_scale", np.reshape(found, kept["kappa_grid_scale"].shape))


def _finite_elements(kept: Kept) -> None:
    """Judge areas of the blocks and their limit: a straight line of the counted area against its edges."""
    options = kept.options
    shape = kept["fem_pixel"].shape
    found: dict[str, list[Any]] = {name: [] for name in ("pixel", "perimeter", "pixel_bem", "pixel_layer")}
    for element in options["elements"]:
        for k in range(options["surfaces"]):
            for n in options["fem_points_per_wave"]:
                one = kept.numbers(
                    base_surface(options, seed=options["seed"] + k),
                    kind="BlockMeasurement",
                    element=element,
                    points=own_grid(options, n),
                    tolerance=None,
                )
                if one is None:
                    return
                for name, values in found.items():
                    values.append(float(one[name]))
    areas = {name: np.reshape(values, shape) for name, values in found.items()}
    kept.array("fem_pixel", areas["pixel"])
    kept.array("fem_perimeter", areas["perimeter"])
    kept.array(
        "depth_error", np.mean(np.abs(areas["pixel_layer"] / areas["pixel_bem"] - 1)[..., -1]), atol=1e-12
    )
    per_wave = np.asarray(options["fem_points_per_wave"])
    kept.array("fem_points_per_wave", per_wave)
    _stopping(kept)
    limits = np.array(
        [
            [_counted_limit(p, q, per_wave) for p, q in zip(*pair, strict=True)]
            for pair in zip(areas["pixel"], areas["perimeter"], strict=True)
        ]
    )
    kept.array("fem_limit", limits[..., 0], rtol=1e-7)
    kept.array("fem_limit_error", limits[..., 1], rtol=1e-5, atol=1e-9)


def _stopping(kept: Kept) -> None:
    """Judge what the stopping of the finite elements leaves, at least one node."""
    options = kept.options
    points = own_grid(options, options["fem_points_per_wave"][0])
    found = []
    for element in options["elements"]:
        usual, strict = (
            kept.numbers(
                base_surface(options, seed=options["seed"]),
                kind="BlockMeasurement",
                element=element,
                points=points,
                tolerance=tolerance,
            )
            for tolerance in (None, 1e-10)
        )
        if usual is None or strict is None:
            return
        a, b = float(usual["pixel"]), float(strict["pixel"])
        found.append(max(abs(a - b), 1 / points**2) / b)
    kept.array("fem_solver_error", found, rtol=1e-7)


def _counted_limit(pixel: Array, perimeter: Array, points: Array) -> tuple[float, float]:
    """Area without edges, and its standard error; edges scatter like the root of their number."""
    # The constant of the element scales the edges, and drops out of the limit.
    edges = pixel - perimeter
    deviation = np.sqrt(edges) / points
    w = 1 / np.maximum(deviation / deviation.max(), 1e-3) ** 2
    s, sx, sxx = w.sum(), w @ edges, w @ edges**2
    det = s * sxx - sx**2
    value = (sxx * (w @ pixel) - sx * (w @ (edges * pixel))) / det
    slope = (s * (w @ (edges * pixel)) - sx * (w @ pixel)) / det
    rest = pixel - value - slope * edges
    return float(value), math.sqrt(float(w @ rest**2) / (pixel.size - 2) * sxx / det)


def _off(kept: Kept, name: str) -> Array:
    """Relative distance of an area from the limit of its own surface, (surface, grid)."""
    return np.asarray(kept[name] / kept["limit"][:, None] - 1)


def _table(kept: Kept) -> None:
    p = kept.options["reduced_pressure"]
    columns = (
        "grid",
        "lambda_short/dx",
        "cells in the median patch",
        "kappa, counted (zeroth moment / p*)",
        *(f"{name} {what} [%]" for name in _AREAS for what in ("- limit", "+- (95 %)")),
        "first moment / p0",
        "P(0+) E*h'",
        "patches",
        *(f"cells at {100 * float(part):g} % of the area" for part in kept["part"]),
        "seconds",
    )
    rows: list[tuple[float | str, ...]] = []
    for i, n in enumerate(kept["points_per_wave"]):
        off = [_off(kept, name)[:, i] for name in _AREAS]
        rows.append(
            (
                f"{int(kept['points'][i])}" + ("" if n > 2 * (1 + 1e-9) else " (under-resolved)"),
                float(n),
                float(kept["cells_per_patch"][:, i].mean()),
                float(kept["pixel"][:, i].mean()) / p,
                *(100 * f for values in off for f in (float(values.mean()), half_width(values))),
                *(float(kept[name][:, i].mean()) for name in ("first_moment", "density_at_zero", "patches")),
                *(float(c) for c in kept["cells"][:, i].mean(axis=0)),
                float(kept["seconds"][:, i].mean()),
            )
        )
    for e, g in np.ndindex(*(kept["fem_pixel"].shape[::2] if "element" in kept.data else (0, 0))):
        off = [kept[name][e, :, g] / kept["limit"] - 1 for name in ("fem_pixel", "fem_perimeter")]
        rows.append(
            (
                f"FEM {kept['element'][e]}",
                float(kept["fem_points_per_wave"][g]),
                math.nan,
                float(kept["fem_pixel"][e, :, g].mean()) / p,
                *(100 * f for values in off for f in (float(values.mean()), half_width(values))),
                *([math.nan] * (6 + kept["part"].size)),
            )
        )
    table(kept, columns, rows)


def _budget(kept: Kept) -> None:
    options, p = kept.options, kept.options["reduced_pressure"]
    spectral = {}
    if "ladder_hurst" in kept.data:
        for name, kind, told in (("finite size", "size", "periods"), ("bandwidth", "bandwidth", "bandwidth")):
            spectral[name] = spectral_share(kept, kind, hurst=options["hurst"], step=1 / options[told])
    limit = kept["limit"]
    shares = {
        "grid": grid_share(limit, kept["limit_error"], kept["limit_drift"]),
        "solver": float(kept["solver_error"]),
        "surfaces": half_width(limit) / float(limit.mean()),
    }
    rows = [("kappa, boundary elements", float(limit.mean()) / p, shares | spectral)]
    for e in range(kept["element"].size if "element" in kept.data else 0):
        own = kept["fem_limit"][e]
        random = grid_share(own, kept["fem_limit_error"][e], np.zeros(1))
        shares = {
            "grid": root_sum(random, float(np.mean(own / limit)) - 1),
            "solver": float(kept["fem_solver_error"][e]),
            "surfaces": half_width(own) / float(own.mean()),
            "depth": float(kept["depth_error"]),
        }
        rows.append(
            (f"kappa, finite elements {kept['element'][e]}", float(own.mean()) / p, shares | spectral)
        )
    budget(kept, rows)


def _sentences(kept: Kept) -> None:
    p = kept.options["reduced_pressure"]
    kappa, theory = kept["limit"] / p, float(persson(p)) / p
    mean = float(kappa.mean())
    said(
        kept,
        "kappa in the limit of vanishing spacing is {kappa:4} +- {half:2} (95 %, {n} surfaces) at p* = {p}; "
        "Persson's theory gives {theory:4}: {share} % of the simulated area is not explained by the grid.",
        kappa=mean,
        half=half_width(kappa),
        n=float(kappa.size),
        p=float(p),
        theory=theory,
        share=100 * (1 - theory / mean),
    )
    keep = np.flatnonzero(kept["points_per_wave"] > 2 * (1 + 1e-9))
    _verdict(kept, keep, (mean, theory))
    modes(kept, [theory * p], [float(kept["ensemble"])])
    _moments(kept, keep)
    for name in _AREAS:
        _by_area(kept, name, keep)
    _criterion(kept, keep)
    _grid_scale(kept, (mean, theory))
    _published(kept, kappa)
    _elements(kept)


def _verdict(kept: Kept, keep: Array, both: tuple[float, float]) -> None:
    limit, theory = both
    p = kept.options["reduced_pressure"]
    counted = kept["pixel"][:, keep].mean(axis=0) / p
    half = half_width(kept["limit"] / p)
    told = ", which these surfaces do not tell from zero" if abs(limit - theory) <= half else ""
    per_wave = kept["points_per_wave"][keep]
    parts = ", ".join(f"{{s{g}}} % at {float(n):g}" for g, n in enumerate(per_wave))
    said(
        kept,
        f"Verdict: counted on {float(per_wave[0]):g} points per shortest wave kappa is {{coarse}}, of which "
        "{grid} is the grid; without it {limit} +- {half:2} remains, {rest} ({share} +- {share_half:2} %) from the "
        f"theory{told}. The grid's part of the distance between counted value and theory is {parts} points per wave.",
        coarse=float(counted[0]),
        grid=float(counted[0]) - limit,
        limit=limit,
        half=half,
        rest=limit - theory,
        share=100 * (limit / theory - 1),
        share_half=100 * half / theory,
        **{f"s{g}": float(100 * (c - limit) / (c - theory)) for g, c in enumerate(counted)},
    )


def _moments(kept: Kept, keep: Array) -> None:
    first = float(np.abs(kept["first_moment"][:, keep] - 1).max())
    coarse, fine = kept["density"][keep[0]], kept["density"][keep[-1]]
    small = kept["stress"] < _SMALL
    excess = float(np.sum(coarse - fine))
    per_wave = kept["points_per_wave"][keep]
    said(
        kept,
        "The first moment of P(sigma) is p0 on every grid (to {first:1}); the zeroth, the area, is {zeroth} % on "
        f"{float(per_wave[0]):g} against {float(per_wave[-1]):g} points per wave. Of that excess {{low}} % lies "
        f"at sigma < {_SMALL:g} E* h'_rms, and above it the coarse grid holds {{change}} %: what is too much at "
        "small pressure is balanced by too little at large pressure.",
        first=first,
        zeroth=100 * (float(np.mean(kept["pixel"][:, keep[0]] / kept["pixel"][:, keep[-1]])) - 1),
        low=100 * float(np.sum((coarse - fine)[small])) / excess,
        change=100 * float(np.sum(coarse[~small]) / np.sum(fine[~small]) - 1),
    )


def _by_area(kept: Kept, name: str, keep: Array) -> None:
    off, per_wave = _off(kept, name)[:, keep].mean(axis=0), kept["points_per_wave"][keep]
    if not np.all(np.isfinite(off)):
        return
    parts = ", ".join(f"{{e{g}:2}} % at {float(n):g}" for g, n in enumerate(per_wave))
    said(
        kept,
        f"The {name} area differs from the limit by {parts} points per shortest wave (mean over surfaces; fitted "
        "order {order}).",
        order=order_of(1 / per_wave, np.where(off == 0, 1e-12, off)),
        **{f"e{g}": 100 * float(e) for g, e in enumerate(off)},
    )


def _criterion(kept: Kept, keep: Array) -> None:
    close = np.flatnonzero(np.abs(_off(kept, "pixel")[:, keep].mean(axis=0)) < 0.05)
    if close.size:
        first = keep[close[0]]
        said(
            kept,
            f"Counting is within 5 % of the limit from lambda_short/dx = {float(kept['points_per_wave'][first]):g} "
            "on; half of the contact area then lies in patches of at least {cells} cells (Persson's criterion "
            "asks for 100 to 10000).",
            cells=float(kept["cells_per_patch"][:, first].mean()),
        )


def _grid_scale(kept: Kept, both: tuple[float, float]) -> None:
    """Judge kappa with roughness down to the grid scale, by the definition of the slope."""
    limit, theory = both
    values = kept["kappa_grid_scale"][:, -1].mean(axis=0)
    low, high = float(values.min()), float(values.max())
    where = " on both sides of" if low < limit < high else " above" if low > limit else " below"
    said(
        kept,
        f"With roughness down to the grid scale on {int(kept['protocol_points'][-1])} points and nodes counted, "
        "kappa is {spectral} (spectral), {forward} (forward), {central} (central), by how the slope is measured: "
        f"a spread of {{spread}} %,{where} the converged {{limit}}; the theory's {{theory}} is "
        f"{'below all of them' if theory < low else 'not below all of them'}.",
        spread=100 * (high / low - 1),
        limit=limit,
        theory=theory,
        **dict(zip(("spectral", "forward", "central"), map(float, values), strict=True)),
    )


def _published(kept: Kept, kappa: Array) -> None:
    """Judge the published values beside the converged one: 2 to 2.2 by several groups, and 1.8."""
    mean, half = float(kappa.mean()), half_width(kappa)
    values = kept["kappa_grid_scale"][:, -1].mean(axis=0)
    verdict, why = "agree with", ""
    if mean + half < 2.0 or mean - half > 2.2:
        verdict = "do not agree with"
    elif 2 * half > 2.2 - 2.0:
        verdict = "can be neither confirmed nor ruled out by"
        why = ": its interval is wider than that range"
    off = 100 * (1.8 / mean - 1)
    told = ", not told from it," if abs(off) <= 100 * half / mean else ""
    inside = "inside" if values.min() <= 1.8 <= values.max() else "outside"
    said(
        kept,
        "Published kappa: 2 to 2.2 (simulations of resolved surfaces by several groups, A/A0 below about 0.1) "
        f"{verdict} the converged {{mean:4}} +- {{half:2}}{why}; 1.8 (Hyun et al. 2004, as read from a figure of "
        f"Persson 2006) lies {{off}} +- {{off_half:2}} % from it{told} and {inside} the {{low}} to {{high}} that "
        "roughness at the grid scale gives by the definition of the slope.",
        mean=mean,
        half=half,
        off=off,
        off_half=100 * half / mean,
        low=float(values.min()),
        high=float(values.max()),
    )


def _elements(kept: Kept) -> None:
    limit = kept["limit"]
    others = 100 * grid_share(limit, kept["limit_error"], kept["limit_drift"])
    depth = 100 * float(kept["depth_error"])
    for e in range(kept["element"].size if "element" in kept.data else 0):
        counted = (kept["fem_pixel"][e] / limit[:, None] - 1).mean(axis=0)
        corrected = (kept["fem_perimeter"][e] / limit[:, None] - 1).mean(axis=0)
        apart = 100 * (kept["fem_limit"][e] / limit - 1)
        distance, half = float(apart.mean()), half_width(apart)
        own = 100 * grid_share(kept["fem_limit"][e], kept["fem_limit_error"][e], np.zeros(1))
        whole = root_sum(half, own, others, depth)
        points = kept["fem_points_per_wave"]
        rows = ", ".join(f"{{a{g}:2}} ({{b{g}:2}}) % at {float(n):g}" for g, n in enumerate(points))
        values = {f"a{g}": 100 * float(x) for g, x in enumerate(counted)}
        values |= {f"b{g}": 100 * float(x) for g, x in enumerate(corrected)}
        told = "the two are not told apart"
        if abs(distance) > whole:
            told = "they are told apart, so that the grids of the element leave {left} %, not {own} %"
            values["left"] = root_sum(own, distance)
        said(
            kept,
            f"Finite elements {kept['element'][e]}, nodes counted (with the element's edge constant), differ from "
            f"the limit of the boundary elements by {rows}; their own limit differs by {{distance}} +- {{whole:2}} % "
            "({half} % the surfaces, {own} % their grids, {others} % those of the boundary elements, {depth} % the "
            f"depth of the block; 95 %): {told}.",
            distance=distance,
            whole=whole,
            half=half,
            own=own,
            others=others,
            depth=depth,
            **values,
        )
