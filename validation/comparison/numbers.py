"""A scene in numbers: one labelled dataset of all methods, grids, shifts and surfaces, and the theory.

A run shows this dataset, a sweep gathers those of its cases, and a notebook makes it of what it pressed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.special

from fem_contact.area import ContactAreas
from fem_contact.contact import ContactResult
from fem_contact.extrapolation import LEAST_CONTACT_POINTS, Limit
from validation.comparison.below import below
from validation.comparison.more_numbers import beside_each_other, cost_and_orders, finest, in_numbers
from validation.comparison.passing import passing
from validation.comparison.reading import Reading, grid_name, is_adhesive
from validation.errors import RunFailed
from validation.measures.measurement import TOLERANCES_LEFT, limit_over
from validation.methods import find_method
from validation.methods.theory import predict
from validation.report.estimates import NORMAL, derive, error_of, gather, mean
from validation.report.quantities import labelled
from validation.scenes.realised import Realised
from validation.scenes.scene import Load, Scene
from validation.solves.press import Press

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["limit_of", "scene_data"]

_TOO_FEW = "it needs two resolved grids of boundary elements with square cells, or three solves on two grids"
_ABSENT = {"theory": "it is simulated"}
_HALF_SPACE = {"depth": "boundary elements press a half-space"}


def scene_data(
    scene: Scene,
    realised: Realised,
    results: Mapping[Press, ContactResult],
    *,
    failures: Mapping[Press, str] | None = None,
    accurate: Mapping[str, Any] | None = None,
) -> xr.Dataset:
    """Put all solves of a scene into one dataset, beside the theory.

    Parameters
    ----------
    scene : Scene
    realised : Realised
        What the scene asks for.
    results : mapping
        Result of each of its solves, which is read once.
    failures : mapping, optional
        Why others failed, and what to do: a row without numbers.
    accurate : mapping, optional
        What was reached, where its grids were chosen for an accuracy.

    Returns
    -------
    xarray.Dataset
        Over (method, grid, shift) of its own surface, and (surface) of an ensemble. ``area`` is that of the
        scene: the mean over the surfaces of an ensemble, else ``area_own``.
    """
    asked = {name: scene.methods.options(name).grids for name in scene.methods.solvers}
    readings = [
        Reading.of(solve, results[solve], bare=not scene.effects, shown=solve.grid in asked[solve.method])
        for solve in results
    ]
    own = [
        one for one in readings if one.solve.realisation == 0 and one.solve.grid in asked[one.solve.method]
    ]
    if not own:
        raise RunFailed(_failures_words(failures or {}))
    if realised.load.held:
        realised = realised.under(Load(pressure=_carried(own)))
    failures = failures or {}
    data = _on_grids(own, failures, scene, realised)
    data = _own_area(data, own, scene, realised)
    data = _beside_theory(data, scene, realised)
    data = _over_surfaces(data, readings, failures, scene, realised, accurate)
    data = beside_each_other(data, own, scene)
    data = finest(cost_and_orders(data))
    data = in_numbers(data, own, results, realised)
    data = passing(data, scene, realised, results)
    data = below(data, scene, realised, results)
    if failures:
        data = data.assign(failures=_failures_words(failures))
    return labelled(data).assign_attrs(_words(scene, realised))


def _failures_words(failures: Mapping[Press, str]) -> str:
    more = f", and {len(failures) - 1} more" if len(failures) > 1 else ""
    return f"{next(iter(failures.values()))}{more}"


def _words(scene: Scene, realised: Realised) -> dict[str, Any]:
    """Say what of a scene decides how its numbers are shown."""
    return {
        "title": scene.title or scene.name,
        "methods": " ".join(scene.methods.asked),
        "effects": " ".join(effect.kind for effect in scene.effects),
        "adhesive": int(is_adhesive(scene.effects)),
        "treatment": "\n".join(() if realised.topography is None else realised.topography.history),
    }


def _carried(own: Sequence[Reading]) -> float:
    """Load [Pa] at the distance that is held, on the finest grid of the first method."""
    first = [one for one in own if one.solve.method == own[0].solve.method]
    found = max(first, key=lambda one: one.solve.realised.points_per_wave(one.solve.grid))
    load = found.solve.realised.load
    if not found.mean_pressure > 0:
        raise RunFailed(
            f"load.{load.key} = {load.values[0]:.6g} m: nothing touches so far apart; come closer"
        )
    return found.mean_pressure


def _on_grids(
    own: Sequence[Reading], failures: Mapping[Press, str], scene: Scene, realised: Realised
) -> xr.Dataset:
    """Lay the solves of the scene's own surface out over method, grid and shift; means over the shifts."""
    import xarray as xr

    methods = list(scene.methods.solvers)
    failed = {(one.method, one.grid): why for one, why in failures.items() if one.realisation == 0}
    grids = sorted(
        {grid for name in methods for grid in scene.methods.options(name).grids},
        key=lambda grid: (grid[0] * grid[1], grid),
    )
    groups: dict[tuple[str, Any], list[Reading]] = {}
    for one in own:
        groups.setdefault((one.solve.method, one.solve.grid), []).append(one)
    shifts = max(map(len, groups.values()))
    coords: dict[str, Any] = {"solver": methods, "grid": [grid_name(grid) for grid in grids]}

    def over(read: Any, fill: Any = math.nan) -> Any:
        whole = np.full((len(methods), len(grids), shifts), fill, dtype=object if fill == "" else float)
        for (method, grid), group in groups.items():
            whole[methods.index(method), grids.index(grid), : len(group)] = [read(one) for one in group]
        return ("solver", "grid", "shift"), whole.astype(str) if fill == "" else whole

    waves = np.array([realised.points_per_wave(grid) for grid in grids])
    modulus = own[0].contact_modulus
    data = xr.Dataset(
        {
            "solve": over(lambda one: one.solve.key, ""),
            "area_pixel_shift": over(lambda one: one.areas.pixel),
            "area_perimeter_shift": over(lambda one: one.areas.perimeter),
            "area_located_shift": over(lambda one: one.areas.subcell or math.nan),
            "points_per_wave": ("grid", waves),
            "spacing": ("grid", 1 / waves),
            "resolved": ("grid", [float(realised.resolved_by(grid)) for grid in grids]),
            **_of_the_scene(realised, modulus),
        },
        coords=coords,
    )
    each = {
        name: xr.DataArray(over(lambda one, n=name: one.numbers[n])[1], dims=("solver", "grid", "shift"))
        for name in own[0].numbers
    }
    for name in ("area_pixel", "area_perimeter", "area_located"):
        values = data[f"{name}_shift"]
        made = {"reduction": "shift mean", "of": f"{name}_shift"}
        data[name] = values.mean("shift").assign_attrs(made)
        if name != "area_perimeter":
            data[f"{name}_error"] = error_of(data[name], grid=_scatter_half(values), **_ABSENT)
    if not bool(data.area_located.notnull().any()):
        data = data.drop_vars(["area_located", "area_located_error", "area_located_shift"])
    if failed:
        words = [[failed.get((method, grid), "") for grid in grids] for method in methods]
        data["failure"] = (("solver", "grid"), words)
    count = data.area_pixel_shift.count("shift")
    data["shifts"] = count.where(count > 0)
    data["density_at_zero"] = each["density_at_zero"].mean("shift")
    data["residual"] = each["residual"].max("shift")
    data["seconds"] = each["seconds"].sum("shift").where(count > 0)
    data["unknowns"] = each["unknowns"].isel(shift=0)
    if any(effect.slot == "pressure bound" for effect in scene.effects):
        data["area_plastic_pixel"] = each["plastic"].mean("shift")
    carried = xr.DataArray(over(lambda one: one.mean_pressure)[1], dims=("solver", "grid", "shift"))
    load = carried.mean("shift") if scene.load.held else realised.pressure
    return data.assign(kappa_perimeter=data.area_perimeter / (load / (modulus * realised.field.rms_gradient)))


def _scatter_half(values: xr.DataArray) -> xr.DataArray:
    """Half of the 95 % interval of a mean over the shifts there are; none of one."""
    count = values.count("shift")
    student = scipy.special.stdtrit(np.maximum(count - 1, 1), 0.975)
    half: xr.DataArray = values.std("shift", ddof=1) / count**0.5 * student
    return half.where(count > 1)


def _of_the_scene(realised: Realised, modulus: float) -> dict[str, float]:
    """Return what is known of surface, solid and load before anything is solved."""
    field = realised.field
    (lx, ly), scale = realised.lengths, modulus * field.rms_gradient
    found = {
        "pressure": realised.pressure,
        "reduced_pressure": realised.pressure / scale,
        "pressure_scale": scale,
        "contact_modulus": modulus,
        "contact_modulus_below": realised.contact_modulus,
        "rms_gradient": field.rms_gradient,
        "rms_height": field.rms_height,
        "nayak": field.nayak if field.rms_gradient > 0 else math.nan,
        "wave_short": realised.shortest,
        "wave_long": realised.longest,
        "nominal_area": lx * ly,
    }
    if realised.spectrum is not None:
        moments = realised.spectrum.moments()
        found |= {"rms_height_spectrum": moments.rms_height, "rms_gradient_spectrum": moments.rms_gradient}
    return found


def limit_of(areas: Sequence[ContactAreas]) -> Limit | None:
    """Limit over at least two grids: of the located area where there is one, else of the corrected."""
    return None if len({area.spacing for area in areas}) < 2 else limit_over(areas)


def _value_of(areas: Sequence[ContactAreas], tolerance: float) -> tuple[float, float, float, str, str]:
    """Return area, half widths by grid and solver, what it rests on, and why there is no limit."""
    limit = limit_of(areas)
    located = all(area.subcell is not None for area in areas)
    how = "edge located inside the cells" if located else "corrected at its edge"
    if limit is not None and limit.determinable:
        grids = len({area.spacing for area in areas})
        left = TOLERANCES_LEFT * tolerance * limit.value if located else math.nan
        return limit.value, NORMAL * limit.uncertainty, left, f"limit over {grids} grids, {how}", ""
    if not areas:
        return math.nan, math.nan, math.nan, "no solve succeeded", "no solve of it succeeded"
    finest = min(areas, key=lambda area: area.spacing)
    values = [
        a.subcell if a.subcell is not None else a.perimeter for a in areas if a.spacing == finest.spacing
    ]
    value = (
        math.nan
        if limit is not None and finest.pixel * finest.cells < LEAST_CONTACT_POINTS
        else float(np.mean(values))
    )
    why = _TOO_FEW if limit is None else limit.doubt
    more = (
        "a second grid gives the limit" if len({a.spacing for a in areas}) == 1 else "the grids tell no limit"
    )
    return value, math.nan, math.nan, f"one grid, {how}; {more}", why


def _own_area(data: xr.Dataset, own: Sequence[Reading], scene: Scene, realised: Realised) -> xr.Dataset:
    """Add the limit of every method over its resolved grids, and the area of the scene's own surface."""
    import xarray as xr

    found, methods = [], list(scene.methods.solvers)
    for method in methods:
        areas = [o.areas for o in own if o.solve.method == method and realised.resolved_by(o.solve.grid)]
        areas = areas or [o.areas for o in own if o.solve.method == method]
        found.append(_value_of(areas, float(scene.methods.options(method).tolerance)))
    values, grid, solver, basis, why = (list(column) for column in zip(*found, strict=True))
    succeeded = [k for k, method in enumerate(methods) if any(o.solve.method == method for o in own)]
    first = next((k for k in succeeded if not why[k]), succeeded[0])
    data = data.assign(
        area_limit=("solver", np.where([not words for words in why], values, math.nan)),
        area_basis=f"{find_method(methods[first]).label}, {basis[first]}",
        no_limit=why[first],
    )
    errors = {"grid": xr.DataArray(grid, dims="solver"), "solver": xr.DataArray(solver, dims="solver")}
    data["area_limit_error"] = error_of(data.area_limit, **errors, **_ABSENT)
    absent = _ABSENT if scene.methods.solvers[methods[first]].sinks else {**_ABSENT, **_HALF_SPACE}
    area = xr.DataArray(values[first])
    return data.assign(
        area_own=area, area_own_error=error_of(area, grid=grid[first], solver=solver[first], **absent)
    )


def _beside_theory(data: xr.Dataset, scene: Scene, realised: Realised) -> xr.Dataset:
    """Add what the theory says of the scene's own surface, and of C(q) alone."""
    options = scene.methods.options("theory")
    if options is None:
        return data
    said = predict(realised, scene.effects, options)
    found = {
        "area_persson_own": said.area,
        "area_ensemble": said.ensemble_area,
        "area_plastic_persson": said.plastic,
        "area_other_energy": said.other,
        "stress_variance": said.stress_variance / float(data.contact_modulus) ** 2,
        "felt_modulus": 2 * math.sqrt(said.stress_variance) / float(data.rms_gradient)
        if data.rms_gradient > 0
        else math.nan,
    }
    return data.assign({n: v for n, v in found.items() if v is not None} | {"theory_note": said.note})


def _over_surfaces(
    data: xr.Dataset,
    readings: Sequence[Reading],
    failures: Mapping[Press, str],
    scene: Scene,
    realised: Realised,
    accurate: Mapping[str, Any] | None,
) -> xr.Dataset:
    """Add area, kappa and distance from the theory: means over the surfaces where there are several."""
    import xarray as xr

    has_theory = "area_persson_own" in data
    if accurate is not None:
        data = _as_claimed(data, accurate)
    several = _surfaces(readings, failures, scene, realised, float(data.contact_modulus))
    if several is not None:
        several = derive(several, kappa_each="area_each / reduced_pressure_each")
        names = ["area", "kappa"]
        if has_theory:
            several = derive(several, area_ratio_each="area_each / area_persson_each")
            names += ["area_persson", "area_ratio"]
        several = mean(several, *names)
        values = several.area_each
        several["scatter"] = values.std("surface", ddof=1, skipna=False) / values.mean(
            "surface", skipna=False
        )
        several["surfaces"] = float(values.size)
        several["area_lowest"], several["area_highest"] = values.min("surface"), values.max("surface")
        return data.merge(several, join="exact").pipe(_excess)
    if "area" not in data:
        data = data.assign(area=data.area_own, area_error=data.area_own_error, surfaces=1.0)
    data = derive(data, kappa="area / reduced_pressure")
    alike = _alike(scene) or float(data.surfaces) == 1
    if has_theory and alike:
        data["area_persson"] = data.area_persson_own
        data = derive(data, area_ratio="area / area_persson")
    elif has_theory:
        data = data.assign(area_persson=data.area_persson_own, area_ratio=xr.DataArray(math.nan))
    return _excess(data)


def _excess(data: xr.Dataset) -> xr.Dataset:
    if "area_ratio" not in data:
        return data
    return derive(data, area_excess="area_ratio - 1", kappa_persson="area_persson / reduced_pressure")


def _alike(scene: Scene) -> bool:
    """Whether the theory says the same of all surfaces of the spectrum."""
    exact = getattr(scene.surface, "amplitudes", "") == "exact"
    return exact or (scene.load.reduced_pressure is not None and not scene.effects)


def _as_claimed(data: xr.Dataset, accurate: Mapping[str, Any]) -> xr.Dataset:
    """Put what a run to an accuracy claims in place of what a plain run would."""
    within = {"solver": "it is within that of the grid", **_ABSENT, **_HALF_SPACE}
    own = float(data.area_own) * accurate["error"]
    data = data.assign(
        area_own_error=error_of(data.area_own, grid=own, **within),
        accuracy_asked=accurate["target"],
        accuracy_reached=accurate["error"] if accurate["mean"] is None else accurate["mean_error"],
    )
    if accurate["mean"] is None:
        return data
    import xarray as xr

    area = xr.DataArray(accurate["mean"])
    statistical = accurate["statistical"] * accurate["mean"]
    left = math.sqrt(max(0.0, (accurate["mean_error"] * accurate["mean"]) ** 2 - statistical**2))
    return data.assign(
        area=area,
        area_error=error_of(area, surfaces=statistical, grid=left, **within),
        scatter=accurate["scatter"],
        surfaces=float(accurate["surfaces"]),
        area_basis="mean over surfaces of the limit over the grids",
    )


def _surfaces(
    readings: Sequence[Reading],
    failures: Mapping[Press, str],
    scene: Scene,
    realised: Realised,
    modulus: float,
) -> xr.Dataset | None:
    """Return area, load and theory of each surface of the ensemble; None without one."""
    import xarray as xr

    if scene.ensemble is None or scene.ensemble_solver is None:
        return None
    options, solver = scene.methods.options("theory"), scene.ensemble_solver
    parts = {}
    failed = {one.realisation: why for one, why in failures.items() if one.grid in scene.ensemble.grids}
    grids = sorted(scene.ensemble.grids)
    for k in range(scene.ensemble.realisations):
        own = [
            one
            for one in readings
            if (one.solve.method, one.solve.realisation, one.solve.shift) == (solver.name, k, (0.0, 0.0))
            and one.solve.grid in scene.ensemble.grids
        ]
        own.sort(key=lambda one: one.solve.grid)
        keys = {one.solve.grid: one.solve.key for one in own}
        here = own[0].solve.realised if own else realised.further(k)
        limit = limit_of([one.areas for one in own])
        value, half = (
            (math.nan, math.nan)
            if limit is None or not limit.determinable
            else (limit.value, NORMAL * limit.uncertainty)
        )
        pressure = here.pressure if not here.load.held else own[-1].mean_pressure if own else math.nan
        area = xr.DataArray(value)
        part = xr.Dataset(
            {
                "area_each": area.assign_attrs(reduction="limit"),
                "area_each_error": error_of(area, grid=half, **_ABSENT, **_HALF_SPACE),
                "rms_gradient_each": here.field.rms_gradient,
                "reduced_pressure_each": pressure / (modulus * here.field.rms_gradient),
                "solve_surface": ("surface_grid", [keys.get(grid, "") for grid in grids]),
                **({"failure_each": failed.get(k, "")} if failed else {}),
            },
            coords={"surface_grid": [grid_name(grid) for grid in grids]},
        )
        if options is not None:
            under = here.under(Load(pressure=pressure)) if here.load.held else here
            part["area_persson_each"] = predict(under, scene.effects, options).area
        parts[k] = part
    return gather(parts, surface=range(len(parts)))
