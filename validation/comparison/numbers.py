"""A scene in numbers: one labelled dataset of all methods, grids, shifts and surfaces, and the theory.

A run shows this dataset, a sweep gathers those of its cases, and a notebook makes it of what it pressed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from fem_contact.area import ContactAreas
from fem_contact.extrapolation import LEAST_CONTACT_POINTS, Limit
from validation.arrays import Array
from validation.comparison.fields import below
from validation.comparison.reductions import (
    DIFFERENCES,
    Case,
    grid_name,
    is_adhesive,
    passing,
    read_off,
    too_far_apart,
)
from validation.comparison.treatment import about
from validation.errors import RunFailed
from validation.execution.press import Contacts, Press
from validation.measurements.common import LEAST_POINTS_PER_WAVE
from validation.measurements.limits import ABSENT
from validation.measurements.measurement import TOLERANCES_LEFT, limit_over, no_limit
from validation.measurements.statistics import finest_error, order_of_convergence, relative_distance
from validation.report.estimates import HOLDS, NORMAL, bare, derive, error_of, mean, mean_of
from validation.report.places import gather
from validation.report.quantities import labelled
from validation.scenes.problem import ContactProblem
from validation.scenes.scene import Scene
from validation.scenes.tables import Load
from validation.solvers import find_method
from validation.solvers.theory import predict

_ABSENT = {"theory": "it is simulated"}
#: Within which relative distance from the limit the cheapest solve is looked for.
_CLOSE = 0.01


def scene_data(
    scene: Scene,
    problem: ContactProblem,
    results: Contacts,
    *,
    failures: Mapping[Press, str] | None = None,
    accurate: Mapping[str, Any] | None = None,
) -> xr.Dataset:
    """Put all solves of a scene into one dataset, beside the theory.

    It is over (solver, grid, shift) of the scene's own surface, and (surface) of an ensemble. ``area`` is
    that of the scene: the mean over the surfaces of an ensemble, else ``area_own``. What failed, and why, is
    a row without numbers, and `accurate` what was reached where grids were chosen for it.

    A RunFailed where no solve of its own surface succeeded, or what holds a distance does not press.
    """
    areas, numbers = {}, {}
    for solve in results:
        areas[solve], numbers[solve] = read_off(solve, results[solve])
    read: Any = {"results": results, "areas": areas, "numbers": numbers, "failures": failures or {}}
    case = Case(scene=scene, problem=problem, **read)
    if not case.own:
        raise RunFailed(case.failed)
    if problem.load.held:
        finest = case.ladder(case.own[0].method)[-1]
        pressure = float(numbers[finest].mean_pressure)
        if not pressure > 0:
            raise too_far_apart(problem, pulled=float(results[finest].in_contact.mean()))
        case = replace(case, problem=problem.under(Load(pressure=pressure)))
    data = _on_grids(case)
    data = _own_area(data, case)
    data = _beside_theory(data, case)
    data = _over_surfaces(data, case, accurate)
    data = beside_each_other(data, case)
    data = finest_of(cost_and_orders(data))
    data = in_numbers(data, case)
    if radius := next(filter(None, (getattr(effect, "radius", None) for effect in scene.effects)), None):
        data = derive(
            data.assign(ball_radius=radius),
            hertz_radius="(3 * pressure * nominal_area * ball_radius / (4 * contact_modulus)) ** (1 / 3)",
            hertz_approach="hertz_radius ** 2 / ball_radius",
            hertz_pressure=f"1.5 * pressure * nominal_area / ({math.pi} * hertz_radius ** 2)",
            hertz_share=f"contact_area / ({math.pi} * hertz_radius ** 2)",
        )
    data = passing(data, case)
    data = below(data, scene, results)
    if failures:
        data = data.assign(failures=case.failed)
    treatment = "" if problem.measured is None else "\n".join(problem.measured.period.history)
    data = labelled(data, scene.given).assign_attrs(about(scene, problem))
    return data.assign_attrs(adhesive=int(is_adhesive(scene.effects)), treatment=treatment)


def _on_grids(case: Case) -> xr.Dataset:
    scene, problem, field = case.scene, case.problem, case.problem.field
    every = {grid for name in case.methods for grid in scene.methods.options(name).grids}
    grids = sorted(every, key=lambda grid: (math.prod(grid), grid))
    parts: dict[tuple[str, str, int], xr.Dataset] = {}
    for solve in case.own:
        place = solve.method, grid_name(solve.grid)
        parts[(*place, sum(there[:2] == place for there in parts))] = case.numbers[solve]
    names, shifts = list(map(grid_name, grids)), range(1 + max(shift for *_, shift in parts))
    each = gather(parts, solver=case.methods, grid=names, shift=shifts).drop_vars("shift")
    ways = ["pixel", "perimeter", *(["located"] if each.area_located_shift.notnull().any() else [])]
    data = each[["solve", *(f"area_{way}_shift" for way in ways)]].assign(
        points_per_wave=("grid", [problem.points_per_wave(grid) for grid in grids]),
        resolved=("grid", [float(problem.resolved_by(grid)) for grid in grids]),
        pressure=problem.pressure,
        contact_modulus=problem.contact_modulus,
        surface_modulus=case.surface_modulus,
        rms_gradient=field.rms_gradient,
        rms_height=field.rms_height,
        nayak=field.nayak,
        wave_short=problem.shortest,
        wave_long=problem.longest,
        nominal_area=math.prod(problem.lengths),
    )
    scale = "contact_modulus * rms_gradient"
    data = derive(
        data, spacing="1 / points_per_wave", pressure_scale=scale, reduced_pressure=f"pressure / ({scale})"
    )
    if problem.spectrum is not None:
        moments = problem.spectrum.moments()
        data = data.assign(rms_height_spectrum=moments.rms_height, rms_gradient_spectrum=moments.rms_gradient)
    for name in (f"area_{way}" for way in ways):
        values = data[f"{name}_shift"]
        data = derive(data, **{name: f"{name}_shift.mean('shift')"})
        if name != "area_perimeter":
            # Of a mean over the shifts there are; none of one.
            half = mean_of(values.values, values.get_axis_num("shift"), there=values.notnull().values)[1]
            data[f"{name}_error"] = error_of(data[name], grid=half, **_ABSENT)
            data[f"{name}_error"].attrs[HOLDS] = "sub-grid positions"
    own = ((solve, why) for solve, why in case.failures.items() if solve.problem.realisation == 0)
    if failed := {(solve.method, solve.grid): why for solve, why in own}:
        words = [[failed.get((method, grid), "") for grid in grids] for method in case.methods]
        data["failure"] = (("solver", "grid"), words)
    if any(effect.slot == "pressure bound" for effect in scene.effects):
        data["area_plastic_pixel"] = each.plastic.mean("shift")
    count = bare(data.area_pixel_shift).count("shift")
    load = each.mean_pressure.mean("shift") if scene.load.held else problem.pressure
    return data.assign(
        shifts=count.where(count > 0),
        density_at_zero=each.density_at_zero.mean("shift"),
        residual=each.residual.max("shift"),
        seconds=each.seconds.sum("shift").where(count > 0),
        unknowns=each.unknowns.isel(shift=0),
        kappa_perimeter=bare(data.area_perimeter) / (load / float(data.pressure_scale)),
    )


def limit_of(areas: Sequence[ContactAreas]) -> Limit:
    """Limit over at least two grids: of the located area where there is one, else of the corrected."""
    few = len({area.spacing for area in areas}) < 2
    return no_limit("it needs two resolved grids") if few else limit_over(areas)


def _value_of(areas: Sequence[ContactAreas], tolerance: float) -> xr.Dataset:
    """Return area, half widths by grid and solver, what it rests on, and why there is no limit."""
    limit, grids = limit_of(areas), len({area.spacing for area in areas})
    located = all(area.subcell is not None for area in areas)
    how = "edge located inside the cells" if located else "corrected at its edge"
    why = limit.doubt if areas else "no solve of it succeeded"
    value, half, left, basis = math.nan, math.nan, math.nan, "no solve succeeded"
    if limit.determinable:
        value, half = limit.value, NORMAL * limit.uncertainty
        left = TOLERANCES_LEFT * tolerance * limit.value if located else math.nan
        basis = f"limit over {grids} grids, {how}"
    elif areas:
        finest = min(areas, key=lambda area: area.spacing)
        there = [area for area in areas if area.spacing == finest.spacing]
        if grids == 1 or finest.pixel * finest.cells >= LEAST_CONTACT_POINTS:
            value = float(np.mean([a.perimeter if a.subcell is None else a.subcell for a in there]))
        more = "the grids tell no limit"
        if grids == 1:
            more = f"a second grid of {LEAST_POINTS_PER_WAVE:g} points per shortest wave gives the limit"
        few = math.isnan(value)
        basis = f"{more}, and the finest has too few points in contact" if few else f"one grid, {how}; {more}"
    return xr.Dataset({"area": value, "half": half, "left": left, "basis": basis, "why": why})


def _own_area(data: xr.Dataset, case: Case) -> xr.Dataset:
    values = {}
    for method in case.methods:
        solves = [solve for solve in case.own if solve.method == method]
        good = [solve for solve in solves if case.problem.resolved_by(solve.grid)] or solves
        tolerance = float(case.scene.methods.options(method).tolerance)
        values[method] = _value_of([case.areas[solve] for solve in good], tolerance)
    usual = case.own[0].method  # which succeeded
    method = next((name for name, value in values.items() if not value.why), usual)
    every, first = gather(values, solver=case.methods), values[method]
    absent = _ABSENT if case.scene.methods.solvers[method].sinks else ABSENT
    limits = every.area.where(every.why == "")
    return data.assign(
        area_limit=limits,
        area_limit_error=error_of(limits, grid=every.half, solver=every.left, **_ABSENT),
        area_basis=f"{find_method(method).label}, {first.basis.item()}",
        no_limit=first.why.item(),
        area_own=first.area,
        area_own_error=error_of(first.area, grid=first.half, solver=first.left, **absent),
    )


def _beside_theory(data: xr.Dataset, case: Case) -> xr.Dataset:
    options = case.scene.methods.options("theory")
    if options is None:
        return data
    prediction = predict(case.problem, case.scene.effects, options)
    predicted = {
        "area_persson_own": prediction.area,
        "area_ensemble": prediction.ensemble_area,
        "area_plastic_persson": prediction.plastic,
        "area_other_energy": prediction.other,
        "stress_variance": prediction.stress_variance / case.problem.contact_modulus**2,
        "theory_note": prediction.note,
    }
    data = data.assign({name: value for name, value in predicted.items() if value is not None})
    return derive(data, felt_modulus="2 * contact_modulus * sqrt(stress_variance) / rms_gradient")


def _over_surfaces(data: xr.Dataset, case: Case, accurate: Mapping[str, Any] | None) -> xr.Dataset:
    has_theory = "area_persson_own" in data
    if accurate is not None:
        data = _as_claimed(data, accurate)
    several = _surfaces(case)
    if several is not None:
        several = derive(several, kappa_each="area_each / reduced_pressure_each")
        names = ["area", "kappa"]
        if has_theory:
            several = derive(
                several,
                area_ratio_each="area_each / area_persson_each",
                kappa_persson_each="area_persson_each / reduced_pressure_each",
            )
            names += ["area_persson", "area_ratio", "kappa_persson"]
        several = mean(several, *names)
        values = bare(several.area_each)
        deviation = values.std("surface", ddof=1, skipna=False)
        several["scatter"] = deviation / values.mean("surface", skipna=False)
        several["surfaces"] = float(values.size)
        for name, how in {"area_lowest": "min", "area_highest": "max"}.items():
            made = {"reduction": "expression", "expression": f"area_each.{how}('surface')"}
            several[name] = bare(getattr(values, how)("surface"), **made)
        data = data.merge(several, join="exact")
    else:
        if "area" not in data:
            area = bare(data.area_own, reduction="expression", expression="area_own")
            data = data.assign(area=area, area_error=data.area_own_error, surfaces=1.0)
        # Whether all surfaces of the spectrum have one p*, and the theory says the same of them.
        exact = getattr(case.scene.surface, "amplitudes", "") == "exact" or data.surfaces == 1
        same_load = exact or case.scene.load.reduced_pressure is not None
        data = derive(data, kappa="area / reduced_pressure") if same_load else data.assign(kappa=math.nan)
        if has_theory:
            data = derive(data.assign(area_ratio=math.nan), area_persson="area_persson_own")
            data = derive(data, kappa_persson="area_persson / reduced_pressure")
        if has_theory and (exact or (same_load and not case.scene.effects)):
            data = derive(data, area_ratio="area / area_persson")
    return derive(data, area_excess="area_ratio - 1") if has_theory else data


def _as_claimed(data: xr.Dataset, accurate: Mapping[str, Any]) -> xr.Dataset:
    """Put what a run to an accuracy claims in place of what a plain run would."""
    solver = TOLERANCES_LEFT * accurate["tolerance"]  # of the area, in what is claimed

    def claimed(area: xr.DataArray, error: float, statistical: float = 0.0) -> xr.DataArray:
        grid = math.sqrt(max(0.0, error**2 - statistical**2 - solver**2))
        parts = {"solver": solver * float(area), "grid": grid * float(area)}
        if statistical:
            parts["surfaces"] = statistical * float(area)
        return error_of(area, **parts, **ABSENT)

    data = data.assign(
        area_own_error=claimed(data.area_own, accurate["error"]),
        accuracy_asked=accurate["target"],
        wall_seconds=accurate["seconds"],
        accuracy_reached=accurate["error"] if accurate["mean"] is None else accurate["mean_error"],
    )
    if accurate["mean"] is None:
        return data
    area = xr.DataArray(accurate["mean"])
    return data.assign(
        area=area,
        area_error=claimed(area, accurate["mean_error"], accurate["statistical"]),
        scatter=accurate["scatter"],
        surfaces=float(accurate["surfaces"]),
    )


def _surfaces(case: Case) -> xr.Dataset | None:
    if case.scene.ensemble is None or not case.surfaces:
        return None
    grids, options = sorted(case.scene.ensemble.grids), case.scene.methods.options("theory")
    failed = {solve.problem.realisation: why for solve, why in case.failures.items() if solve.grid in grids}
    parts = {}
    for k, on in case.surfaces.items():
        solves = [on[grid] for grid in grids if grid in on]
        here = solves[0].problem if solves else case.problem.further(k)
        limit = limit_of([case.areas[solve] for solve in solves])
        area, half = xr.DataArray(limit.value), NORMAL * limit.uncertainty
        part = {
            "area_each": area.assign_attrs(reduction="limit"),
            "area_each_error": error_of(area, grid=half, **ABSENT),
            "rms_gradient_each": here.field.rms_gradient,
            "reduced_pressure_each": here.pressure / here.pressure_scale,
            "solve_surface": ("surface_grid", [on[g].key if g in on else "" for g in grids]),
        }
        if options is not None:
            part["area_persson_each"] = predict(here, case.scene.effects, options).area
        if failed:
            part["failure_each"] = failed.get(k, "")
        parts[k] = xr.Dataset(part, coords={"surface_grid": [grid_name(grid) for grid in grids]})
    return gather(parts, surface=range(len(parts)))


def beside_each_other(data: xr.Dataset, case: Case) -> xr.Dataset:
    """Put every other method beside the first, on the grids they share; how differences shrink with dx."""
    methods, grids = data.solver.values.tolist(), data.grid.values.tolist()
    if len(methods) < 2:
        return data
    still = {(solve.method, solve.grid): solve for solve in case.own if solve.is_own}
    # The first method is not beside itself; where all others failed, nothing else says what is asked.
    cases = {(methods[0], grids[0]): xr.Dataset(dict.fromkeys(DIFFERENCES, math.nan))}
    for (method, grid), solve in still.items():
        if method != methods[0] and (first := still.get((methods[0], grid))) is not None:
            values = (
                relative_distance(case.results[solve].pressure, case.results[first].pressure),
                case.areas[solve].pixel / case.areas[first].pixel - 1,
                case.areas[solve].perimeter / case.areas[first].perimeter - 1,
            )
            cases[method, grid_name(grid)] = xr.Dataset(dict(zip(DIFFERENCES, values, strict=True)))
    data = data.assign(gather(cases, solver=methods, grid=grids).data_vars)
    for name in DIFFERENCES:
        made = {"reduction": "order", "of": name}
        orders = [_order(data, row) for row in np.abs(data[name].values)]
        data[f"{name}_order"] = ("solver", orders, made)
    return data


def _order(data: xr.Dataset, values: Array) -> float:
    """Power of dx with which something shrinks, where three grids tell."""
    known = np.isfinite(values) & (values > 0)
    return order_of_convergence(data.spacing.values[known], values[known]) if known.sum() > 2 else math.nan


def cost_and_orders(data: xr.Dataset) -> xr.Dataset:
    """Add how far every area is from the limit, what it took to come close, and how P(0+) falls with dx."""
    limit = math.nan
    if data.no_limit.item() == "" and 0 < data.area_own < 1 - 1e-12:
        limit = float(data.area_own)
    ways = {"located": "edge located", "perimeter": "corrected at its edge", "pixel": "points counted"}
    ways = {name: words for name, words in ways.items() if f"area_{name}" in data}
    for name in ways:
        data[f"area_{name}_off"] = bare(data[f"area_{name}"]) / limit - 1
        data[f"deviation_{name}"] = np.maximum(abs(data[f"area_{name}_off"]), 1e-6)
    if "area_persson_own" in data:
        data["deviation_persson"] = np.maximum(abs(data.area_persson_own / limit - 1), 1e-6)
    every = "(['solver', 'grid'])"
    data = derive(data, seconds_total=f"seconds.sum{every}", unknowns_largest=f"unknowns.max{every}")
    near = xr.concat([abs(data[f"area_{way}_off"]) <= _CLOSE for way in ways], "way").transpose(..., "way")
    seconds = data.seconds.where(near & (data.resolved > 0))
    if seconds.notnull().any():
        at = seconds.argmin(["solver", "grid", "way"])
        way, here = list(ways)[int(at.pop("way"))], data.isel(at)
        data = data.assign(
            cheapest=f"{find_method(str(here.solver.item())).label} on {here.grid.item()}, {ways[way]}",
            seconds_cheapest=float(here.seconds),
            area_cheapest_off=float(here[f"area_{way}_off"]),
        )
    first = data.isel(solver=0)
    cells = np.array([math.prod(map(int, str(g).split(" x "))) for g in data.grid.values])
    enough = (data.resolved.values > 0) & (first.area_pixel.values * cells >= LEAST_CONTACT_POINTS)
    density = np.where(enough, first.density_at_zero.values, math.nan)
    return data.assign(density_at_zero_order=_order(data, density))


def finest_of(data: xr.Dataset) -> xr.Dataset:
    """Add what every method says on its finest resolved grid, or on its finest where none resolves."""
    names = {"area_pixel", "area_perimeter", "area_plastic_pixel", "residual"} & set(data)
    solved = bare(data.area_pixel.notnull())
    resolved = solved & (bare(data.resolved) > 0)
    candidates = resolved.where(resolved.any("grid"), solved)
    # A method that failed on every grid has NaN on the last one, too.
    at = (candidates * np.arange(1, data.sizes["grid"] + 1)).max("grid") - 1
    values = {f"{name}_finest": bare(data[name]).isel(grid=at) for name in sorted(names)}
    return data.assign({**values, "grid_finest": ("solver", data.grid.values[at])})


def in_numbers(data: xr.Dataset, case: Case) -> xr.Dataset:
    """Add what one asks of a contact, on the finest resolved grid of the first method."""
    from fem_contact.conductance import frozen_contact
    from fem_contact.patches import find_patches

    solves, height = case.ladder(case.own[0].method), case.problem.field.rms_height
    rows = []
    for solve in solves:  # whose fields are read one after the other
        result = case.results[solve]
        row = {
            "mean_gap": result.mean_gap,
            "approach": -result.offset,
            "largest_pressure": float(result.pressure.max()),
            "patches": float(find_patches(result.in_contact, result.spacing, periodic=result.periodic).count),
        }
        some = result.in_contact.any() and not result.in_contact.all()
        # The stiffness of a contact set is exact where points weigh alike on an elastic response.
        if some and result.weights is None and not is_adhesive(solve.effects) and not solve.solver.sinks:
            stiffness = frozen_contact(result, solve.response, tolerance=1e-6).stiffness
            row["stiffness"] = stiffness * height / result.mean_pressure
        if "area_plastic_pixel" in data:
            at = {"solver": solve.method, "grid": grid_name(solve.grid)}
            row["area_plastic"] = float(data.area_plastic_pixel.sel(at))
        rows.append(row)
    spacing = [1 / case.problem.points_per_wave(solve.grid) for solve in solves]
    for name, value in rows[-1].items():
        data[name] = xr.DataArray(value)
        power = 1.0 if name in ("largest_pressure", "patches") else 1.5
        half = finest_error([row.get(name, math.nan) for row in rows], spacing, power=power)
        data[f"{name}_error"] = error_of(data[name], grid=half, **_ABSENT)
    if height > 0:
        data = derive(data, gap="mean_gap / rms_height")
    return derive(data, contact_area="area_own * nominal_area")
