"""Pressing a surface of a notebook, and asking the theory alone."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from inspect import signature
from typing import Any

import numpy as np
import xarray as xr

from fem_contact.solid import Solid
from fem_contact.surface import HeightField
from validation.arrays import Grid
from validation.comparison.theory_alone import theory_data
from validation.effects import effect_kinds
from validation.errors import NoLimit, UsageError, did_you_mean
from validation.notebook._contact import Contact, pressed
from validation.notebook._surface import GridLike, Quantity, Surface, checked, fast_grid
from validation.report.values import Value, value_of
from validation.scenes.checks import check_scene
from validation.scenes.problem import realise
from validation.scenes.scene import Scene
from validation.scenes.tables import RandomSurface
from validation.solvers import methods

#: Points per shortest wave of the grid that is taken unless one is given: by a quick method, by others.
_POINTS_PER_WAVE = (8.0, 4.0)


def press(
    surface: Surface,
    solid: Solid | None = None,
    *,
    young: Quantity | None = None,
    poisson: float | None = None,
    second_young: Quantity | None = None,
    second_poisson: float | None = None,
    pressure: Quantity | None = None,
    reduced_pressure: float | None = None,
    force: Quantity | None = None,
    mean_gap: Quantity | None = None,
    offset: Quantity | None = None,
    grid: GridLike | None = None,
    grids: Sequence[GridLike] | None = None,
    method: str = "bem",
    options: Mapping[str, Any] | None = None,
    **effects: Any,
) -> Contact:
    """Press a surface against an elastic solid.

    Parameters
    ----------
    surface : Surface
        Of `self_affine` or `measured`.
    solid : Solid, optional
        In place of `young` and `poisson`.
    young : quantity
        Young's modulus: a number in Pa, a text such as "1 GPa", or a quantity of pint.
    poisson : float
    second_young, second_poisson : quantity, float, optional
        Of the rough body, where it is elastic, too.
    pressure, reduced_pressure, force, mean_gap, offset : quantity or float
        One of: p0; p* = p0 / (E* h'_rms) with the realised gradient; p0 times the nominal area; or a distance
        that is held: the mean gap, or that of the mean planes before deformation.
    grid : int or (int, int), optional
        Points along the sides; 8 per shortest wave if not given, 4 by finite elements and of a
        measured surface, whose shortest wave is two of its spacings.
    grids : sequence, optional
        Several in place of one: area, kappa, mean gap and so on have their errors then; fields are those of
        the finest.
    method : str
        "bem" for boundary elements, "fem" for the finite-element block, or one of another package.
    options : mapping, optional
        More of the table ``[methods.NAME]`` of a scene, such as ``{"tolerance": 1e-10}``.
    effects
        Effects by name, each a table or its chief quantity: ``hardness="2 GPa"``,
        ``adhesion={"work": "50 mJ/m^2", "reach": "2 nm"}``, ``free_boundary=True``.

    Raises
    ------
    UsageError
        For what cannot be pressed, before anything is computed.
    FemContactError
        When the solve fails.
    """
    tables = _tables(surface, solid, (young, poisson, second_young, second_poisson))
    load = {"pressure": pressure, "reduced_pressure": reduced_pressure, "force": force}
    load |= {"mean_gap": mean_gap, "offset": offset}
    if any(np.ndim(value) for value in load.values()):  # type: ignore[arg-type]
        raise UsageError(
            "press: takes one load; for several write table([press(..., reduced_pressure=p) for p in loads])"
        )
    if not isinstance(method, str):
        raise UsageError(f"press: method = {method!r}: give its name; one of: {', '.join(methods())}")
    if not isinstance(options or {}, Mapping):
        raise UsageError(f'press: options = {options!r}: give a table, such as {{"tolerance": 1e-10}}')
    if grids is not None and grid is not None:
        raise UsageError("press: grid and grids: give one of them")
    points = [_default_grid(surface, method) if grid is None else grid] if grids is None else grids
    listed = _effects(effects, press)
    known = all(effect_kinds()[effect["kind"]].has_theory() for effect in listed)
    chosen = {method: {**(options or {}), "grids": points}, **({"theory": {}} if known else {})}
    scene = checked(Scene, "press", {**tables, "load": load, "methods": chosen, "effects": listed})
    return pressed(scene, replace(realise(scene), given=surface.given), done={})


def theory(
    surface: Surface,
    solid: Solid | None = None,
    *,
    young: Quantity | None = None,
    poisson: float | None = None,
    second_young: Quantity | None = None,
    second_poisson: float | None = None,
    pressure: Any = None,
    reduced_pressure: Any = None,
    **effects: Any,
) -> xr.Dataset:
    """Return what Persson's theory says of the C(q) of a surface at one load or several; nothing is pressed.

    Parameters are those of `press`; a load may be a list. The dataset, over `load`, has A/A0, the yielded
    part of it, and the error that the theory estimates of itself; NaN where it has no answer.
    """
    tables = _tables(surface, solid, (young, poisson, second_young, second_poisson))
    listed, load = _effects(effects, theory), {"pressure": pressure, "reduced_pressure": reduced_pressure}
    if (pressure is None) == (reduced_pressure is None):
        raise UsageError("theory: give exactly one of 'pressure' and 'reduced_pressure'")
    tables |= {"load": load, "methods": {"theory": {}}, "effects": listed}
    scene = checked(Scene, "theory", tables)
    problem = replace(realise(scene), given=surface.given)
    check_scene(scene, problem)
    data = theory_data(scene, problem).set_coords("reduced_pressure")
    names = [name for name in ("area_ensemble", "area_plastic_ensemble") if name in data]
    note = "; ".join(dict.fromkeys(filter(None, data.theory_note.values.tolist())))
    plain = data[[*names, "error_estimate"]].drop_attrs(deep=False).assign_attrs(note=note)
    return plain.rename({name: name.removesuffix("_ensemble") for name in names})


def table(contacts: Iterable[Contact], *, along: str | None = None, limit: bool = False) -> xr.Dataset:
    """Return the numbers of several contacts as one dataset; ``area_error`` is half of the 95 % interval.

    One grid tells no error: press each on several, or ask for the limit.

    Parameters
    ----------
    contacts : iterable of Contact
    along : str, optional
        What becomes the coordinate: ``reduced_pressure``, ``pressure``, ``method``, ``points``, or a key of
        surface, solid or effect such as ``hurst``, ``seed``, ``young``, ``hardness`` (of an
        effect ``coating_young``, where the solid has it, too). The first that tells all apart if not given.
    limit : bool
        Also take the limit over grids of each and half of its 95 % interval, which presses each on some more.

    Raises
    ------
    UsageError
        For contacts that do not differ in it.
    """
    pressed_ones: list[Any] = list(contacts) if isinstance(contacts, Iterable) else [contacts]
    if not pressed_ones:
        raise UsageError("table: no contact is given; give a list, as [press(...), press(...)]")
    if wrong := [one for one in pressed_ones if not isinstance(one, Contact)]:
        raise UsageError(f"table: {wrong[0]!r}: give a list of contacts, as [press(...), press(...)]")
    inputs = [_said(contact) for contact in pressed_ones]
    known = dict.fromkeys(name for one in inputs for name in one)
    # Without what rounding does, so that what is the same is one.
    close = [{n: float(f"{v:.9g}") if isinstance(v, float) else v for n, v in one.items()} for one in inputs]
    telling = [name for name in known if len({one.get(name) for one in close} - {None}) == len(inputs)]
    if along is None:
        along = next(iter(telling), "reduced_pressure")
    if along not in telling:
        some = f"; {'these do' if telling else 'nor does any of'}: {', '.join(telling or known)}"
        raise UsageError(f"table: along = {along!r}: does not tell the contacts apart{some}")
    parts = [_numbers(contact, limit=limit) for contact in pressed_ones]
    rows = xr.concat(parts, along, combine_attrs="drop")
    # What else differs stands beside it.
    columns = {name: [one[name] for one in inputs] for name in known if all(name in one for one in inputs)}
    others = {name: (along, column) for name, column in columns.items() if len(set(column)) > 1}
    return rows.assign_coords({**others, along: [one[along] for one in inputs]})


#: What a table calls the numbers of a run on one grid.
_COLUMNS = {
    "area": "area",
    "area_pixel": "pixel",
    "kappa": "kappa",
    "area_persson_own": "persson",
    "area_plastic_pixel": "plastic",
    "area_plastic_persson": "persson_plastic",
    "residual": "residual",
}


def _numbers(contact: Contact, *, limit: bool) -> xr.Dataset:
    data, load = contact.data.isel(solver=0, grid=-1, drop=True), float(contact.data.reduced_pressure)
    columns = {name: column for name, column in _COLUMNS.items() if name in data}
    row = data[list(columns)].rename(columns).reset_coords(drop=True)
    if "persson" in row:
        row["persson_kappa"] = row.persson / load
    halves = {name: value_of(contact.data, name).error for name in ("area", "kappa")}
    row = row.assign({f"{name}_error": math.nan if half is None else half for name, half in halves.items()})
    if not limit:
        return row
    try:
        over = contact.limit()
    except NoLimit:
        over = Value(value=math.nan, error=math.nan)
    value, half = float(over.value), math.nan if over.error is None else over.error
    return row.assign(limit=value, limit_error=half, kappa_limit=value / load, kappa_limit_error=half / load)


def _said(contact: Contact) -> dict[str, Any]:
    scene, problem = contact.scene, contact._loaded
    # As it was asked for, not as it comes back from the other.
    loads: dict[str, Any] = {
        name: getattr(scene.load, name) or getattr(problem, name) for name in ("reduced_pressure", "pressure")
    }
    loads |= {"method": contact.solve.solver.label, "points": contact.solve.grid[0]}
    for listed in (scene.surface, scene.solid, *scene.effects):
        for name, value in listed.model_dump(exclude_none=True, exclude={"kind"}).items():
            if isinstance(value, (int, float, str)):
                kind = getattr(listed, "kind", "")
                loads[f"{kind}_{name}" if name in loads else name] = value
    return loads


def _tables(surface: object, solid: object, numbers: tuple[Any, Any, Any, Any]) -> dict[str, Any]:
    """Return name, surface and solid as a scene has them; of what is none, what to write instead."""
    body = dict(zip(("young", "poisson", "second_young", "second_poisson"), numbers, strict=True))
    if not isinstance(surface, Surface):
        what, remedy = type(surface).__name__, "write self_affine(...) or measured(...)"
        if isinstance(surface, np.ndarray):
            remedy = (
                'an array says neither size nor unit: write measured(array, length="100 um", unit="1 nm")'
            )
        elif isinstance(surface, HeightField):
            remedy = "write measured(field)"
        raise UsageError(f"surface: found {what}; {remedy}")
    if isinstance(solid, Solid):
        if body["young"] is not None or body["poisson"] is not None:
            raise UsageError("solid: given twice; leave young and poisson out, or the Solid")
        body |= {"young": solid.young, "poisson": solid.poisson}
    elif solid is not None:
        what = type(solid).__name__
        remedy = "give its Solid, half_space.solid" if hasattr(solid, "solid") else "give a Solid"
        raise UsageError(f'solid: found {what}; {remedy}, or young="1 GPa", poisson=0.3')
    return {"name": "notebook", "surface": surface.table, "solid": body}


def _effects(effects: Mapping[str, Any], called: Callable[..., Any]) -> list[dict[str, Any]]:
    """Return effects as a scene lists them: a table, or the field that bears the name of the effect."""
    kinds, listed = effect_kinds(), []
    for argument, value in effects.items():
        name = argument.replace("_", "-")
        if name not in kinds:
            allowed = [one for one in (*signature(called).parameters, *kinds) if one != "effects"]
            hint = did_you_mean(argument, allowed) or ";"
            raise UsageError(f"{argument}: no such argument or effect{hint} Allowed: {', '.join(allowed)}")
        if value is True:
            listed.append({"kind": name})
        elif isinstance(value, Mapping):
            listed.append({"kind": name, **value})
        elif name in kinds[name].model_fields:
            listed.append({"kind": name, name: value})
        else:
            fields = ", ".join(field for field in kinds[name].model_fields if field != "kind")
            raise UsageError(f"{name} = {value!r}: give a table {{...}} with {fields}")
    return listed


def _default_grid(surface: Surface, method: str) -> Grid:
    """Return twice the points of a measured surface, 4 per shortest wave, or what resolves a random one."""
    if surface.given is not None:
        nx, ny = surface.given.raw.heights.shape
        return 2 * nx, 2 * ny
    assert isinstance(surface.table, RandomSurface)
    quick, slow = _POINTS_PER_WAVE
    points = quick if getattr(methods().get(method), "for_ensembles", False) else slow
    return fast_grid(surface.table.length, surface.table.lambda_short, points)
