"""What is shown of fields: surface, C(q), pressures and their distribution, stress in the solid below."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from fem_contact.contact import ContactResult
from fem_contact.stress import pressure_distribution
from fem_contact.surface import HeightField, radial_spectrum
from validation.arrays import Pair, padded
from validation.comparison.reductions import grid_name, own_solves
from validation.execution.press import Contacts, Press
from validation.report.estimates import derive
from validation.report.places import gather
from validation.report.quantities import labelled
from validation.scenes.problem import ContactProblem
from validation.scenes.scene import Scene
from validation.scenes.surfaces import band_of
from validation.scenes.tables import Load
from validation.solvers.theory import stress_distribution

#: Pressures over E* h'_rms up to which the distribution near zero is shown.
NEAR_ZERO = 0.6
#: Dimensions of what belongs to figures alone.
MAPS = ("x", "y")
_CURVE = 401


def with_fields(data: xr.Dataset, scene: Scene, problem: ContactProblem, results: Contacts) -> xr.Dataset:
    """Add to the numbers of a run what its figures show of the fields.

    Maps are of the methods of the package, distributions of other codes too, stress below the contact of what
    asks for it. The theory is evaluated under the pressure that was found where a distance is held.
    """
    if problem.load.held:
        problem = problem.under(Load(pressure=float(data.pressure)))
    shown = {solve: results[solve] for solve in own_solves(scene, results)}
    data = with_maps(data, {s: r for s, r in shown.items() if s.is_own})
    if isinstance(problem.field, HeightField):
        radial = radial_spectrum(problem.field, band=band_of(problem.surface))
        nonzero = radial.power > 1e-12 * radial.power.max()
        q = radial.q[nonzero]
        data = data.assign_coords(wavevector=q).assign(power_spectrum=("wavevector", radial.power[nonzero]))
        if problem.spectrum is not None:
            power = np.asarray(problem.spectrum(q), dtype=float)
            data["power_spectrum_told"] = ("wavevector", np.where(power > 0, power, np.nan))
    data = with_distribution(data, shown, scene, problem)
    return labelled(planes(data, scene, results))


def with_cells(data: xr.Dataset, shape: tuple[int, ...], spacing: Pair) -> xr.Dataset:
    """Add the middles of cells along x and y [m]."""
    each = zip(MAPS, shape, spacing, strict=True)
    return data.assign_coords({name: (name, (np.arange(n) + 0.5) * step) for name, n, step in each})


def with_maps(data: xr.Dataset, results: Contacts) -> xr.Dataset:
    """Add heights and pressures on the finest grid that all methods share, or on the finest of the first."""
    methods = list(dict.fromkeys(solve.method for solve in results))
    grids = [{solve.grid for solve in results if solve.method == name} for name in methods]
    finest = max(set.intersection(*grids) or grids[0], key=math.prod)
    there = {solve.method: result for solve, result in results.items() if solve.grid == finest}
    first, maps = there[methods[0]], np.full((data.sizes["solver"], *finest), np.nan)
    for name, result in there.items():
        k = data.solver.values.tolist().index(name)
        maps[k] = np.where(result.in_contact, result.pressure, np.nan)
    data = with_cells(data, finest, first.spacing).assign(
        heights=(MAPS, first.heights - first.heights.mean()), pressure_map=(("solver", *MAPS), maps)
    )
    if len(there) == 2:
        one, other = (there[name] for name in data.solver.values if name in there)
        touched = one.in_contact | other.in_contact
        data["pressure_map_difference"] = (MAPS, np.where(touched, other.pressure - one.pressure, np.nan))
    return data.assign_attrs(map_grid=grid_name(finest))


def with_distribution(data: xr.Dataset, shown: Contacts, scene: Scene, problem: ContactProblem) -> xr.Dataset:
    """Add P(sigma) on every grid near zero, on the finest to its end, and that of the theory.

    All have the same bins, as many as the contact with the fewest points carries; shifts are averaged. With
    adhesion it begins at the most negative pressure, since some points are pulled. Densities are times the
    pressure scale, stresses over it.
    """
    unit, options = float(data.pressure_scale), scene.methods.options("theory")
    groups: dict[tuple[str, str], list[ContactResult]] = {}
    for solve, result in sorted(shown.items(), key=lambda pair: math.prod(pair[0].grid)):
        groups.setdefault((solve.method, grid_name(solve.grid)), []).append(result)
    lowest = 0.0
    if data.attrs.get("adhesive"):
        lowest = min(float(r.pressure[r.in_contact].min(initial=0.0)) for r in shown.values()) / unit
    finest = {method: (method, grid) for method, grid in groups}
    ends = [float(r.pressure.max()) / unit for key in finest.values() for r in groups[key]]
    if "stress_variance" in data and all(effect.slot != "pressure bound" for effect in scene.effects):
        spread = math.sqrt(float(data.stress_variance)) * float(data.contact_modulus) / unit
        ends.append(float(data.reduced_pressure) + 3 * spread)
    for name, top, keys in (("near", NEAR_ZERO, groups), ("wide", 1.02 * max(ends), finest.values())):
        points = min(sum(np.count_nonzero(r.in_contact) for r in groups[key]) for key in keys)
        edges = np.linspace(lowest, top, min(48, max(12, int(np.sqrt(points) / 2))) + 1)
        parts = {}
        for key in keys:
            densities = [pressure_distribution(r, edges * unit).density for r in groups[key]]
            parts[key] = xr.Dataset({f"density_{name}": (name, unit * np.mean(densities, axis=0))})
        data = data.assign(gather(parts, solver=data.solver.values, grid=data.grid.values).data_vars)
        data = data.assign_coords({f"stress_{name}": (name, (edges[1:] + edges[:-1]) / 2)})
        if options is None:
            continue
        stress = np.linspace(lowest, top, _CURVE)
        theory = stress_distribution(problem, scene.effects, options, stress * unit)
        if theory is not None:
            data = data.assign_coords({f"stress_{name}_exact": (f"{name}_exact", stress)})
            data[f"density_{name}_persson"] = (f"{name}_exact", theory * unit)
    return data


def below(data: xr.Dataset, scene: Scene, results: Contacts) -> xr.Dataset:
    """Add where the von Mises stress under the scene's own surface is largest, if it asks."""
    if scene.subsurface is None:
        return data
    from fem_contact.subsurface import strongest_point

    given = scene.subsurface.depths  # at the surface lie the edges of the contact ring
    depths = None if given is None else tuple(depth for depth in given if depth > 0)
    names = ("von_mises", "von_mises_depth", "von_mises_x", "von_mises_y")
    parts = {("", ""): xr.Dataset(dict.fromkeys(names, np.nan))}
    for solve in _pressed(scene, results):
        point = strongest_point(results[solve], solve.below, depths=depths)
        values = (point.von_mises, point.depth, *point.place)
        parts[solve.method, grid_name(solve.grid)] = xr.Dataset(dict(zip(names, values, strict=True)))
    data = data.assign(gather(parts, solver=data.solver.values, grid=data.grid.values).data_vars)
    before = data.von_mises.shift(grid=1)
    return derive(
        data.assign(von_mises_change=(data.von_mises - before) / before),
        von_mises_reduced="von_mises / pressure_scale",
        von_mises_depth_reduced="von_mises_depth / wave_short",
    )


def _pressed(scene: Scene, results: Mapping[Press, Any], *, finest: bool = False) -> list[Press]:
    """List the solves whose pressures lie on the response of a solid: a mesh has a stress of its own."""
    solves = [solve for solve in own_solves(scene, results) if solve.is_own and not solve.solver.sinks]
    by_size = sorted(solves, key=lambda solve: math.prod(solve.grid))
    return list({solve.method: solve for solve in by_size}.values()) if finest else solves


def write_below(scene: Scene, results: Contacts, folder: Path) -> Iterator[Path]:
    """Write the fields below the finest grid of each method, where the scene asks for them."""
    if scene.subsurface is None or not scene.subsurface.vtu:
        return
    from fem_contact.export import write_subsurface
    from fem_contact.subsurface import fields_below

    folder.mkdir(exist_ok=True)
    for solve in _pressed(scene, results, finest=True):
        target = folder / f"{solve.prefix}-below.vtu"
        write_subsurface(target, fields_below(results[solve], solve.below, depths=scene.subsurface.depths))
        yield target


def planes(data: xr.Dataset, scene: Scene, results: Contacts) -> xr.Dataset:
    """Add the von Mises stress over depth below the finest grid of each method: largest, and rms."""
    if scene.subsurface is None:
        return data
    from fem_contact.subsurface import planes_below

    rows = {
        solve.method: [
            # A logarithmic axis has no surface.
            (p.depth or np.nan, float(p.von_mises.max()), float(np.sqrt(np.mean(p.von_mises**2))))
            for p in planes_below(results[solve], solve.below, depths=scene.subsurface.depths)
        ]
        for solve in _pressed(scene, results, finest=True)
    }
    units = float(data.wave_short), *2 * [float(data.pressure_scale)]
    planes = {
        name: padded([row[k] / units[k] for row in rows.get(solver, ())] for solver in data.solver.values)
        for k, name in enumerate(("plane_depth", "plane_stress_largest", "plane_stress_rms"))
    }
    return data.assign({name: (("solver", "plane"), values) for name, values in planes.items()})
