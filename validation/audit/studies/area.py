"""The study `area` again: limits, means, standard errors and kappa from the fields of every solve."""

from __future__ import annotations

import math

import numpy as np

from validation.audit.limits import limit_over
from validation.audit.stored import Array
from validation.audit.studies.kept import Kept, base_surface
from validation.audit.studies.numbers import LEAST_POINTS, persson, root_sum
from validation.audit.studies.said import said

__all__ = ["judge"]

_YOUNG, _POISSON = 1e9, 0.3


def judge(kept: Kept) -> None:
    """Judge dataset and sentences."""
    loads = np.asarray(kept.options["reduced_pressures"], dtype=float)
    waves = kept.options["periods"] * kept.options["bandwidth"]
    resolved = [n for n in dict.fromkeys(kept.options["grids"]) if n / waves >= LEAST_POINTS * (1 - 1e-9)]
    kept.array("reduced_pressure", loads)
    found = [[_one(kept, load, k, resolved) for k in range(kept.options["surfaces"])] for load in loads]
    if all(one is not None for row in found for one in row):
        _means(kept, np.array(found, dtype=float))
    else:
        kept.ledger.unread.append("limits of the surfaces: the store that study.json names lacks solves")
    both = np.hypot(kept["scatter_error"], kept["grid_error"])
    kept.array("area_error", both)
    kept.array("kappa", kept["area"] / loads)
    kept.array("kappa_error", both / loads)
    kept.array("persson", persson(loads))
    kept.derived["persson_kappa"] = persson(loads) / loads
    _sentences(kept, loads, resolved)


def _one(kept: Kept, load: float, k: int, grids: list[int]) -> tuple[float, float] | None:
    """Limit of one surface at one load and its standard error; None without its solves."""
    surface = base_surface(kept.options, seed=kept.options["seed"] + k)
    modulus = _YOUNG / (1 - _POISSON**2)
    solves = []
    for n in grids:
        one = kept.fields(
            surface, method="bem", grid=[n, n], load={"reduced_pressure": load}, effects=[], shift=[0.0, 0.0]
        )
        if one is None:
            return None
        place = f"surface {k}, {n}x{n}, p* = {load:g}"
        scale = modulus * math.sqrt(one.moments[1])
        kept.ledger.number(place, "p*", one.mean_pressure / scale, load, rtol=1e-6)
        kept.ledger.number(place, "E* [Pa]", one.modulus, modulus)
        kept.ledger.same(place, "status", one.said["status"], "CONVERGED")
        solves.append(one)
    limit = limit_over(solves, located=True)
    return (math.nan, math.nan) if limit is None else (limit.value, limit.error)


def _means(kept: Kept, found: Array) -> None:
    """Judge means over surfaces: `found` is (load, surface, value and error)."""
    area, error = found[..., 0], found[..., 1]
    n = area.shape[1]
    kept.array("area", area.mean(axis=1), rtol=1e-7)
    deviation = np.sqrt(np.sum((area - area.mean(axis=1)[:, None]) ** 2, axis=1) / (n - 1))
    kept.array("scatter_error", deviation / math.sqrt(n), rtol=1e-5, atol=1e-10)
    kept.array("grid_error", np.sqrt(np.mean(error**2, axis=1)), rtol=1e-5, atol=1e-10)


def _sentences(kept: Kept, loads: Array, resolved: list[int]) -> None:
    for k in sorted({0, loads.size // 2, loads.size - 1}):
        area, theory = float(kept["area"][k]), math.erf(math.sqrt(2) * loads[k])
        if not math.isfinite(area):
            start = "At p* = {load:3} kappa is not determinable: "
            said(kept, start + "a contact has too few points on the finest grid.", load=float(loads[k]))
            continue
        error = root_sum(float(kept["scatter_error"][k]), float(kept["grid_error"][k]))
        said(
            kept,
            "At p* = {load:3} kappa = {kappa} (standard error over {surfaces} surfaces and of the grids, which "
            "alone is {grid}); the area lies {distance} {side} Persson's theory.",
            load=float(loads[k]),
            kappa=(area / loads[k], error / loads[k]),
            surfaces=float(kept.options["surfaces"]),
            grid=float(kept["grid_error"][k]) / area,
            distance=abs(area / theory - 1),
            side="above" if area > theory else "below",
        )
    left = [n for n in kept.options["grids"] if n not in resolved]
    if left:
        said(
            kept,
            "Under-resolved (fewer than 3 points per shortest wave), run and left out of every limit: {names}.",
            names=", ".join(f"{n} x {n}" for n in left),
        )
