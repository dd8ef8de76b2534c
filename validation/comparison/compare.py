"""The comparison: stored solves of one scene read side by side with the theory."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from fem_contact.area import ContactAreas, contact_areas
from fem_contact.contact import ContactResult
from fem_contact.errors import InvalidInput
from fem_contact.extrapolation import Limit, located_limit, perimeter_limit
from fem_contact.stress import density_at_zero
from validation.arrays import Array
from validation.comparison.below import below
from validation.comparison.compared import Comparison, CrossCheck, Row, Scatter, is_adhesive
from validation.errors import RunFailed
from validation.methods.theory import Prediction, predict
from validation.scenes.realised import Realised
from validation.scenes.scene import Load, Scene
from validation.solves.press import Press

if TYPE_CHECKING:
    from validation.comparison.passing import Passing

__all__ = ["compare"]

_TOO_FEW_GRIDS = (
    "it needs two resolved grids of boundary elements with square cells, or three solves on two grids"
)


def compare(
    scene: Scene,
    realised: Realised,
    results: Mapping[Press, ContactResult],
    *,
    accurate: Mapping[str, Any] | None = None,
) -> Comparison:
    """Put all solves of a scene beside the theory.

    Parameters
    ----------
    scene : Scene
    realised : Realised
        What the scene asks for.
    results : mapping
        Result of each of its solves, which is read once.
    accurate : mapping, optional
        What was reached, where its grids were chosen for an accuracy.
    """
    asked = {name: scene.methods.options(name).grids for name in scene.methods.solvers}
    readings = [
        _Reading.of(solve, results[solve], bare=not scene.effects, shown=solve.grid in asked[solve.method])
        for solve in results
    ]
    modulus = readings[0].contact_modulus
    shown = [
        one for one in readings if one.solve.realisation == 0 and one.solve.grid in asked[one.solve.method]
    ]
    groups = itertools.groupby(shown, key=lambda one: (one.solve.method, one.solve.grid))
    if realised.load.held:
        realised = realised.under(Load(pressure=_carried(shown)))
    rows = tuple(_row(list(group), scene, realised, modulus) for _, group in groups)
    continuum = None
    if realised.spectrum is not None:
        moments = realised.spectrum.moments()
        continuum = {"rms_height_m": moments.rms_height, "rms_gradient": moments.rms_gradient}
    limit, no_limit = _limit(readings, scene, rows)
    passes: tuple[Passing, ...] = ()
    if scene.quantities is not None and scene.quantities.passing:  # what is not asked for is not loaded
        from validation.comparison.passing import passing

        passes = passing(scene, realised, results)
    field = realised.field
    return Comparison(
        scene=scene,
        realised=realised,
        pressure=realised.pressure,
        contact_modulus=modulus,
        rms_gradient=field.rms_gradient,
        rms_height=field.rms_height,
        nayak=field.nayak if field.rms_gradient > 0 else float("nan"),
        continuum=continuum,
        treatment=() if realised.topography is None else realised.topography.history,
        rows=rows,
        cross=_cross_checks(readings, scene, realised),
        limit=limit,
        no_limit=no_limit,
        accurate=accurate,
        theory=_theory(scene, realised),
        scatter=_scatter(readings, scene, realised),
        passing=passes,
        below=below(scene, results),
    )


def _carried(shown: Sequence[_Reading]) -> float:
    """Load [Pa] at the distance that is held, on the finest grid of the first method."""
    own = [one for one in shown if one.solve.method == shown[0].solve.method]
    found = max(own, key=lambda one: one.solve.realised.points_per_wave(one.solve.grid))
    load = found.solve.realised.load
    if not found.mean_pressure > 0:
        raise RunFailed(
            f"load.{load.key} = {load.values[0]:.6g} m: nothing touches so far apart; come closer"
        )
    return found.mean_pressure


def _theory(scene: Scene, realised: Realised) -> Prediction | None:
    options = scene.methods.options("theory")
    return None if options is None else predict(realised, scene.effects, options)


@dataclass(frozen=True, kw_only=True)
class _Reading:
    """What the comparison needs of one solve, so that its fields are read once and let go.

    Attributes
    ----------
    pressure : (nx, ny) array or None
        Kept where it is compared with that of another method.
    plastic : float
        Share of points at the pressure bound.
    """

    solve: Press
    areas: ContactAreas
    density: float
    plastic: float
    residual: float
    seconds: float
    unknowns: int
    contact_modulus: float
    mean_pressure: float
    pressure: Array | None

    @classmethod
    def of(cls, solve: Press, result: ContactResult, *, bare: bool, shown: bool) -> _Reading:
        solver = solve.solver
        dx, dy = result.spacing
        # The place of an edge is known for the bare half-space, on square cells.
        located = solver.locates_edges and bare and abs(dx / dy - 1) <= 0.05
        at_bound = result.at_bound if result.weights is None else result.weights * result.at_bound
        return cls(
            solve=solve,
            areas=contact_areas(result, edge_constant=solver.edge_constant(result), subcell=located),
            density=_reduced_density(result, adhesive=is_adhesive(solve.effects)),
            plastic=float(np.mean(at_bound)),
            residual=result.residuals.worst,
            seconds=result.cost.wall_seconds,
            unknowns=result.cost.unknowns,
            contact_modulus=result.contact_modulus,
            mean_pressure=result.mean_pressure,
            pressure=result.pressure if shown and solve.is_own else None,
        )


def _row(solves: Sequence[_Reading], scene: Scene, realised: Realised, modulus: float) -> Row:
    scale = modulus * realised.field.rms_gradient
    # Where a distance is held, each grid takes a load of its own.
    held = float(np.mean([one.mean_pressure for one in solves]))
    reduced_pressure = (held if scene.load.held else realised.pressure) / scale
    solve = solves[0].solve
    pixel = np.array([one.areas.pixel for one in solves])
    perimeter = float(np.mean([one.areas.perimeter for one in solves]))
    yields = any(effect.slot == "pressure bound" for effect in scene.effects)
    return Row(
        method=solve.method,
        grid=solve.grid,
        points_per_wave=realised.points_per_wave(solve.grid),
        under_resolved=not realised.resolved_by(solve.grid),
        solves=len(solves),
        pixel=float(pixel.mean()),
        pixel_scatter=float(pixel.std(ddof=1) / np.sqrt(pixel.size)) if pixel.size > 1 else float("nan"),
        perimeter=perimeter,
        kappa=perimeter / reduced_pressure,
        density_at_zero=float(np.mean([one.density for one in solves])),
        residual=max(one.residual for one in solves),
        seconds=sum(one.seconds for one in solves),
        unknowns=solves[0].unknowns,
        plastic=float(np.mean([one.plastic for one in solves])) if yields else None,
    )


def _reduced_density(result: ContactResult, *, adhesive: bool) -> float:
    if adhesive:  # a window from zero on would hold all the tension
        return float("nan")
    try:
        found = density_at_zero(result)
    except InvalidInput:  # a flat surface has no scale of pressure
        return float("nan")
    # A window that reaches up to the hardness sees what has yielded.
    reached = np.any(result.at_bound & (result.pressure < found.threshold))
    return float("nan") if reached else found.reduced


def _cross_checks(readings: Sequence[_Reading], scene: Scene, realised: Realised) -> tuple[CrossCheck, ...]:
    """Put every other method beside the first, on the grids they share."""
    own = [one for one in readings if one.solve.is_own]
    first, *others = scene.methods.solvers
    reference = {one.solve.grid: one for one in own if one.solve.method == first}
    checks = []
    for one in own:
        other = reference.get(one.solve.grid)
        if one.solve.method not in others or other is None:
            continue
        if one.pressure is None or other.pressure is None:
            continue
        difference = np.linalg.norm(one.pressure - other.pressure) / np.linalg.norm(other.pressure)
        checks.append(
            CrossCheck(
                method=one.solve.method,
                reference=first,
                grid=one.solve.grid,
                points_per_wave=realised.points_per_wave(one.solve.grid),
                pressure=float(difference),
                pixel=one.areas.pixel / other.areas.pixel - 1,
                perimeter=one.areas.perimeter / other.areas.perimeter - 1,
            )
        )
    return tuple(checks)


def _limit(readings: Sequence[_Reading], scene: Scene, rows: tuple[Row, ...]) -> tuple[Limit | None, str]:
    """Limit of this surface, or why there is none: the first method that has one, resolved grids only."""
    reasons = []
    for method in scene.methods.solvers:
        grids = {row.grid for row in rows if row.method == method and not row.under_resolved}
        limit = _limit_over(
            [
                one.areas
                for one in readings
                if one.solve.method == method and one.solve.realisation == 0 and one.solve.grid in grids
            ]
        )
        if limit is not None and limit.determinable:
            return limit, ""
        if limit is not None:
            reasons.append(limit.doubt)
    return None, reasons[0] if reasons else _TOO_FEW_GRIDS


def _limit_over(areas: Sequence[ContactAreas]) -> Limit | None:
    """Limit over at least two grids: of the located area where there is one, else of the corrected."""
    if len({area.spacing for area in areas}) < 2:
        return None
    if all(area.subcell is not None for area in areas):
        return located_limit(areas)
    return perimeter_limit(areas)


def _scatter(readings: Sequence[_Reading], scene: Scene, realised: Realised) -> Scatter | None:
    if scene.ensemble is None or scene.ensemble_solver is None:
        return None
    surfaces = {one.solve.realisation: one.solve.realised for one in readings}
    areas, ratios, errors = [], [], []
    for k in range(scene.ensemble.realisations):
        own = [
            one.areas
            for one in readings
            if one.solve.method == scene.ensemble_solver.name
            and one.solve.realisation == k
            and one.solve.shift == (0.0, 0.0)
            and one.solve.grid in scene.ensemble.grids
        ]
        limit = _limit_over(own)
        if limit is None or not limit.determinable:
            return None
        theory = _theory(scene, surfaces.get(k, realised))
        areas.append(limit.value)
        ratios.append(limit.value / theory.area if theory is not None and theory.answers else limit.value)
        errors.append(limit.uncertainty / limit.value)
    return Scatter(
        areas=tuple(areas), ratios=tuple(ratios), grid_error=float(np.sqrt(np.mean(np.square(errors))))
    )
