"""The comparison: stored solves of one scene read side by side with the theory."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from fem_contact.area import EDGE_CONSTANTS, ContactAreas, Limit, contact_areas
from fem_contact.contact import ContactResult
from fem_contact.errors import InvalidInput
from fem_contact.extrapolation import counted_limit, located_limit
from fem_contact.stress import density_at_zero
from fem_contact.surface import resolves
from validation.errors import RunFailed
from validation.methods.scene_theory import Theory, theory_of
from validation.report.words import json_ready
from validation.scenes.scene import FileSurface, Scene
from validation.scenes.surfaces import (
    measured_spectrum,
    reference_field,
    shortest_wavelength,
    spectrum_of,
    topography_of,
)
from validation.solves.solve import Job, jobs_of, nominal_pressure
from validation.solves.store import Store

if TYPE_CHECKING:
    from validation.effects.judgement import Judgement

__all__ = ["Comparison", "CrossCheck", "Row", "Scatter", "Theory", "compare", "edge_constant"]

_TOO_FEW_GRIDS = (
    "it needs two resolved grids of boundary elements with square cells, or three solves on two grids"
)


@dataclass(frozen=True, kw_only=True)
class Row:
    """One method on one grid, averaged over the sub-grid shifts that were run.

    Attributes
    ----------
    method : str
        "bem" or "fem".
    grid : tuple of int
    points_per_wave : float
        lambda_short / dx, on the coarser axis.
    under_resolved : bool
        Whether lambda_short <= 2 dx.
    solves : int
        Number of shifts averaged.
    pixel, perimeter : float
        A/A0 by counting, and with the perimeter correction of the method's edge constant.
    pixel_scatter : float
        Standard error of `pixel` over the shifts; NaN for one shift, which tells nothing of it.
    kappa : float
        (A/A0) / p* from `perimeter`.
    density_at_zero : float
        P(0+) E* h'_rms, from the points below a pressure that falls like sqrt(dx); NaN with adhesion, where
        pressures do not start at zero.
    residual : float
        The largest of the four contact residuals over the solves.
    seconds : float
        Wall time of all the solves.
    unknowns : int
        Of one solve.
    plastic : float or None
        A_pl/A0, points at the pressure bound counted; None without a hardness.
    """

    method: str
    grid: tuple[int, int]
    points_per_wave: float
    under_resolved: bool
    solves: int
    pixel: float
    pixel_scatter: float
    perimeter: float
    kappa: float
    density_at_zero: float
    residual: float
    seconds: float
    unknowns: int
    plastic: float | None = None


@dataclass(frozen=True, kw_only=True)
class CrossCheck:
    """Finite elements against boundary elements on the same surface and grid.

    Attributes
    ----------
    grid : tuple of int
    points_per_wave : float
        lambda_short / dx.
    pressure : float
        ||p_fem - p_bem|| / ||p_bem||, over all points.
    pixel, perimeter : float
        A_fem / A_bem - 1, by counting and with each method's perimeter correction.
    """

    grid: tuple[int, int]
    points_per_wave: float
    pressure: float
    pixel: float
    perimeter: float


@dataclass(frozen=True, kw_only=True)
class Scatter:
    """Spread of the contact area between realisations of the same spectrum.

    Attributes
    ----------
    areas : tuple of float
        Limit of A/A0 of each realisation.
    ratios : tuple of float
        Each over the theory conditional on that realisation.
    grid_error : float
        Root mean square of the uncertainties of the single limits, relative.
    """

    areas: tuple[float, ...]
    ratios: tuple[float, ...]
    grid_error: float

    @property
    def mean_ratio(self) -> float:
        """Mean of area over theory."""
        return float(np.mean(self.ratios))

    @property
    def relative(self) -> float:
        """Standard deviation between surfaces over the mean."""
        return float(np.std(self.ratios, ddof=1) / np.mean(self.ratios))

    @property
    def mean_error(self) -> float:
        """Standard error of `mean_ratio`."""
        return float(np.std(self.ratios, ddof=1) / np.sqrt(len(self.ratios)))


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """Everything a run found, in numbers; plots, tables and sentences are made from it.

    Attributes
    ----------
    scene : Scene
    pressure, contact_modulus, rms_gradient : float
        p0 [Pa], E* [Pa], and the realised, spectral h'_rms.
    rms_height, nayak : float
        h_rms [m] and Nayak parameter of the realised surface.
    continuum : dict of str to float, or None
        h_rms [m] and h'_rms of the integrals over C(q), which for a measured surface is estimated.
    treatment : tuple of str
        What was done to a measured surface, in words; empty for a generated one.
    rows, cross : tuples
    limit : Limit or None
        Limit of A/A0 over the resolved BEM grids (FEM grids where there is no BEM); None from a single grid,
        fewer than three counted areas, or a contact too small to carry the law.
    theory : Theory or None
        None unless the scene asks for it.
    scatter : Scatter or None
    no_limit : str
        Why there is no limit, in words; empty where there is one.
    accurate : bool
        Whether the grids were chosen for an accuracy of the limit.
    """

    scene: Scene
    pressure: float
    contact_modulus: float
    rms_gradient: float
    rms_height: float
    nayak: float
    continuum: dict[str, float] | None
    treatment: tuple[str, ...]
    rows: tuple[Row, ...]
    cross: tuple[CrossCheck, ...]
    limit: Limit | None
    theory: Theory | None
    scatter: Scatter | None
    no_limit: str = ""
    accurate: bool = False

    @property
    def adhesive(self) -> bool:
        """Whether the surfaces attract each other, so that pressures are negative near the edges."""
        return any(effect.kind == "adhesion" for effect in self.scene.effects)

    @cached_property
    def judgements(self) -> tuple[tuple[Judgement, ...], tuple[Judgement, ...]]:
        """Effects that ran and effects left out, each with the number that decides."""
        from validation.comparison.explain import judgements

        return judgements(self.scene)

    @property
    def reduced_pressure(self) -> float:
        """p* = p0 / (E* h'_rms) with the realised gradient."""
        return self.pressure / (self.contact_modulus * self.rms_gradient)

    @cached_property
    def findings(self) -> tuple[str, ...]:
        """What the run found, in words."""
        from validation.comparison.findings import findings

        return findings(self)

    def rows_of(self, method: str) -> tuple[Row, ...]:
        """Rows of one method, coarse to fine."""
        return tuple(row for row in self.rows if row.method == method)

    def summary(self) -> dict[str, Any]:
        """Everything as JSON-ready data."""
        return {
            "scene": self.scene.model_dump(mode="json"),
            "pressure_Pa": self.pressure,
            "reduced_pressure": self.reduced_pressure,
            "contact_modulus_Pa": self.contact_modulus,
            "realised": json_ready(
                {
                    "rms_height_m": self.rms_height,
                    "rms_gradient": self.rms_gradient,
                    "nayak": self.nayak,
                }
            ),
            "continuum": self.continuum,
            "treatment": list(self.treatment),
            "rows": [json_ready(asdict(row)) for row in self.rows],
            "fem_against_bem": [asdict(check) for check in self.cross],
            "limit": None if self.limit is None else asdict(self.limit),
            "no_limit": self.no_limit,
            "theory": None if self.theory is None else self.theory.summary(),
            "scatter": None if self.scatter is None else asdict(self.scatter),
            "findings": list(self.findings),
        }


def edge_constant(job: Job, result: ContactResult) -> float:
    """Edge constant of the perimeter correction: of boundary elements, or of the finite element used."""
    if job.method == "bem":
        return EDGE_CONSTANTS["bem"]
    from fem_contact.block import ELEMENTS

    return ELEMENTS[result.provenance["element"]].edge_constant


def compare(scene: Scene, store: Store, *, accurate: bool = False) -> Comparison:
    """Read all stored solves of a scene and put them beside the theory.

    Parameters
    ----------
    scene : Scene
    store : Store
    accurate : bool
        Whether its grids were chosen for an accuracy of the limit.

    Raises
    ------
    RunFailed
        When a solve of the scene is not stored.
    """
    surface = scene.surface
    field = reference_field(surface)
    pressure = nominal_pressure(scene.load, scene.solid, field)
    results = {job: _stored(store, job) for job in jobs_of(scene)}
    modulus = next(iter(results.values())).contact_modulus
    shown = [job for job in results if job.realisation == 0 and job.grid in _asked_grids(scene, job.method)]
    groups = [list(group) for _, group in itertools.groupby(shown, key=lambda job: (job.method, job.grid))]
    reduced = pressure / (modulus * field.rms_gradient)
    rows = tuple(_row([(job, results[job]) for job in group], scene, reduced) for group in groups)
    continuum = None
    treatment: tuple[str, ...] = ()
    if isinstance(surface, FileSurface):
        treatment = topography_of(surface).history
        if surface.edges in ("tukey", "hann"):
            moments = measured_spectrum(surface).moments()
            continuum = {"rms_height_m": moments.rms_height, "rms_gradient": moments.rms_gradient}
    else:
        moments = spectrum_of(surface).moments()
        continuum = {"rms_height_m": moments.rms_height, "rms_gradient": moments.rms_gradient}
    limit, no_limit = _limit(results, scene, rows)
    return Comparison(
        scene=scene,
        pressure=pressure,
        contact_modulus=modulus,
        rms_gradient=field.rms_gradient,
        rms_height=field.rms_height,
        nayak=field.nayak if field.rms_gradient > 0 else float("nan"),
        continuum=continuum,
        treatment=treatment,
        rows=rows,
        cross=_cross_checks(results, scene),
        limit=limit,
        no_limit=no_limit,
        accurate=accurate,
        theory=theory_of(scene, field, pressure, modulus),
        scatter=_scatter(results, scene, modulus),
    )


def _stored(store: Store, job: Job) -> ContactResult:
    result: ContactResult | None = store.load(job)
    if result is None:
        raise RunFailed(f"{job.describe()}: no result in {store.folder}; run the scene first")
    return result


def _asked_grids(scene: Scene, method: str) -> tuple[tuple[int, int], ...]:
    table = scene.methods.bem if method == "bem" else scene.methods.fem
    return () if table is None else table.grids


def _areas(job: Job, result: ContactResult) -> ContactAreas:
    dx, dy = result.spacing
    # The place of an edge is known for the bare half-space, by boundary elements, on square cells.
    located = job.method == "bem" and not job.effects and abs(dx / dy - 1) <= 0.05
    return contact_areas(result, edge_constant=edge_constant(job, result), subcell=located)


def _points_per_wave(scene: Scene, grid: tuple[int, int]) -> float:
    spacing = max(length / n for length, n in zip(scene.surface.length, grid, strict=True))
    return shortest_wavelength(scene.surface) / spacing


def _row(solves: Sequence[tuple[Job, ContactResult]], scene: Scene, reduced_pressure: float) -> Row:
    job = solves[0][0]
    areas = [_areas(job, result) for _, result in solves]
    pixel = np.array([area.pixel for area in areas])
    perimeter = float(np.mean([area.perimeter for area in areas]))
    per_wave = _points_per_wave(scene, job.grid)
    adhesive = any(effect.kind == "adhesion" for effect in scene.effects)
    return Row(
        method=job.method,
        grid=job.grid,
        points_per_wave=per_wave,
        under_resolved=not _resolved(scene, job.grid),
        solves=len(solves),
        pixel=float(pixel.mean()),
        pixel_scatter=float(pixel.std(ddof=1) / np.sqrt(pixel.size)) if pixel.size > 1 else float("nan"),
        perimeter=perimeter,
        kappa=perimeter / reduced_pressure,
        density_at_zero=float(np.mean([_reduced_density(r, adhesive=adhesive) for _, r in solves])),
        residual=max(result.residuals.worst for _, result in solves),
        seconds=sum(result.cost.wall_seconds for _, result in solves),
        unknowns=solves[0][1].cost.unknowns,
        plastic=_plastic(scene, [result for _, result in solves]),
    )


def _plastic(scene: Scene, results: Sequence[ContactResult]) -> float | None:
    if not any(effect.kind == "hardness" for effect in scene.effects):
        return None
    shares = [np.mean(r.at_bound if r.weights is None else r.weights * r.at_bound) for r in results]
    return float(np.mean(shares))


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


def _resolved(scene: Scene, grid: tuple[int, int]) -> bool:
    return resolves(grid, scene.surface.length, q_short=2 * np.pi / shortest_wavelength(scene.surface))


def _cross_checks(results: dict[Job, ContactResult], scene: Scene) -> tuple[CrossCheck, ...]:
    own = [job for job in results if job.realisation == 0 and job.shift == (0.0, 0.0)]
    bem = {job.grid: job for job in own if job.method == "bem"}
    checks = []
    for job in own:
        other = bem.get(job.grid)
        if job.method != "fem" or other is None:
            continue
        fem_areas, bem_areas = _areas(job, results[job]), _areas(other, results[other])
        p_fem, p_bem = results[job].pressure, results[other].pressure
        checks.append(
            CrossCheck(
                grid=job.grid,
                points_per_wave=_points_per_wave(scene, job.grid),
                pressure=float(np.linalg.norm(p_fem - p_bem) / np.linalg.norm(p_bem)),
                pixel=fem_areas.pixel / bem_areas.pixel - 1,
                perimeter=fem_areas.perimeter / bem_areas.perimeter - 1,
            )
        )
    return tuple(checks)


def _limit(
    results: dict[Job, ContactResult], scene: Scene, rows: tuple[Row, ...]
) -> tuple[Limit | None, str]:
    """Limit of this surface, or why there is none: boundary elements first, resolved grids only."""
    reasons = []
    for method in ("bem", "fem"):
        grids = {row.grid for row in rows if row.method == method and not row.under_resolved}
        limit = _limit_over(
            [_areas(job, r) for job, r in results.items() if _is_own(job, method) and job.grid in grids]
        )
        if limit is not None and limit.determinable:
            return limit, ""
        if limit is not None:
            reasons.append(limit.doubt)
    return None, reasons[0] if reasons else _TOO_FEW_GRIDS


def _is_own(job: Job, method: str) -> bool:
    return job.method == method and job.realisation == 0


def _limit_over(areas: Sequence[ContactAreas]) -> Limit | None:
    """Limit over at least two grids: of the located area where there is one, else of the counted."""
    if len({area.spacing for area in areas}) < 2:
        return None
    if all(area.subcell is not None for area in areas):
        return located_limit(areas)
    return counted_limit(areas) if len(areas) >= 3 else None


def _scatter(results: dict[Job, ContactResult], scene: Scene, modulus: float) -> Scatter | None:
    if scene.ensemble is None:
        return None
    areas, ratios, errors = [], [], []
    for k in range(scene.ensemble.realisations):
        own = [
            (job, result)
            for job, result in results.items()
            if job.method == "bem"
            and job.realisation == k
            and job.shift == (0.0, 0.0)
            and job.grid in scene.ensemble.grids
        ]
        limit = _limit_over([_areas(job, result) for job, result in own])
        if limit is None or not limit.determinable:
            return None
        field = reference_field(scene.surface, realisation=k)
        pressure = nominal_pressure(scene.load, scene.solid, field)
        theory = theory_of(scene, field, pressure, modulus)
        areas.append(limit.value)
        ratios.append(limit.value / theory.area if theory is not None and theory.answers else limit.value)
        errors.append(limit.uncertainty / limit.value)
    return Scatter(
        areas=tuple(areas), ratios=tuple(ratios), grid_error=float(np.sqrt(np.mean(np.square(errors))))
    )
