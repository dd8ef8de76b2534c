"""How do area, force, stress and energy of an adhesive contact change as shorter waves are added, and does the theory see it?

One surface is cut at rising magnification zeta and solved with adhesion each time, in two ways: with the work of adhesion
itself, beside the theory of that cut surface; and with the theory's gamma_eff(zeta), which is to stand for all shorter
waves, beside A(zeta) and F(zeta) along one solution. The theory knows no range of the attraction: the law is given the
strength that the theory's detachment stress has at the last wave, so that both end at the same tension. Areas are
projected in both; A counts points whose gap is closed, and what F exceeds the load by is the pull outside the contact.
"""

import itertools
from typing import Annotated, Any

import numpy as np
import xarray as xr
from pydantic import AfterValidator, Field

from validation.effects.adhesion import Adhesion
from validation.effects.base import full_contact_energy
from validation.measurements.adhesive import (
    READINGS,
    Cut,
    Solutions,
    readings,
    shares_by_shell,
    with_pooled_stress,
)
from validation.measurements.common import RisingSeveral, base_case, in_rising_order
from validation.measurements.limits import straight_limit
from validation.report.estimates import claim, derive, mean, same_of_all
from validation.report.places import gather
from validation.report.views import Figure, Findings, Line, Table, Views, against, finding
from validation.scenes.problem import ContactProblem
from validation.scenes.tables import SolidSpec
from validation.studies._options import Periods, SurfaceOptions, Surfaces
from validation.studies._study import ABSENT, Bench, Call, solved
from validation.units import Positive

_LENGTH = 1e-5
_SOLID = SolidSpec(young=1e7, poisson=0.5)
#: gamma_eff over w below which no solve is tried.
_LEAST = 0.02
#: Which work the cut surface is given.
_FULL, _EFFECTIVE = "w", "gamma_eff(zeta)"
#: What is compared with the theory.
_COMPARED = ("area", "force_inside", "energy_ratio", "tension")
#: Points per last wave with which the range of the attraction spans two cells.
_Resolving = Annotated[float, Field(ge=14.2)]


class Options(SurfaceOptions):
    """Where the spectrum is cut, and how strong the adhesion is."""

    why_no_scene = "it cuts the spectra of surfaces it makes"

    magnifications: RisingSeveral = (1.5, 2.0, 3.0, 4.0, 6.0, 8.0)
    """zeta = q/q_long of the last wave, rising, above 1; the last is the whole surface"""
    reduced_pressure: Positive = 0.05
    """p* with the gradient of all waves"""
    work: Positive = 0.3
    """w over the elastic energy of full contact of all waves, per area"""
    points_per_wave: Annotated[tuple[_Resolving, _Resolving], AfterValidator(in_rising_order)] = (16.0, 24.0)
    """two grids, as the last wave over dx, rising; below 14.2 the range of the attraction is not resolved"""
    periods: Periods = 2.0
    surfaces: Surfaces = 6


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Solve every cut of every surface with its own work and with gamma_eff(zeta), on two grids.

    Area, force, energy and tension over (told, surface, magnification), limits over grids, beside both readings of
    the theory; stress in the contact as shares over bins, surfaces pooled; P~ of the waves between magnifications
    (surface, shell) of the whole surface; what half the range changes.
    """
    zetas, surfaces = options.magnifications, range(options.surfaces)
    wholes = [_full_surface(options, k) for k in surfaces]
    along = [readings(whole, Adhesion(work=work), area="projected") for whole, work in wholes]
    cuts: dict[tuple[str, int, float], Cut] = {}
    for k, zeta in itertools.product(surfaces, zetas):
        for told, solutions in ((_FULL, None), (_EFFECTIVE, along[k])):
            if cut := _cut(options, k, zeta, along=solutions):
                cuts[told, k, zeta] = cut
    q_long = 2 * np.pi * options.periods / _LENGTH
    edges = q_long * np.array([1.0, *zetas])
    shells = tuple(edges[1:].tolist())
    points = [per_wave * options.periods for per_wave in options.points_per_wave]
    cases: dict[Any, Call] = {
        (at, g): cut.solve(n * at[2], shells=shells) for at, cut in cuts.items() for g, n in enumerate(points)
    }
    # Half the range takes four times the points: on the second magnification of the first surface.
    cases["half"] = cuts[_FULL, 0, zetas[1]].solve(points[0] * zetas[1], shells=shells, finer=4, reach=0.5)
    measured = solved(bench, cases)
    half = measured.pop("half")
    data = gather(
        {at: cut.reduced([measured[at, g] for g in range(len(points))]) for at, cut in cuts.items()},
        told=(_FULL, _EFFECTIVE),
        surface=surfaces,
        magnification=zetas,
    ).assign(area_half_range=half.area, force_inside_half_range=half.force)
    shares = {
        k: shares_by_shell(measured[(_FULL, k, zetas[-1]), 1], along[k], problem=wholes[k][0], edges=edges)
        for k in surfaces
    }
    data = data.merge(gather(shares, "surface").rename(solve="solve_whole"))
    data = data.assign_coords(points_per_wave=("grid", list(options.points_per_wave)))
    data = straight_limit(data, "area", "area_plain", "area_parted", x="points_per_wave")
    data = _compared(straight_limit(data, *_COMPARED[1:], of="grid", x="points_per_wave"))
    asked = options.model_dump(include={"hurst", "reduced_pressure", "work"})
    return data.assign_attrs(methods="theory bem adhesion", **asked)


def _full_surface(options: Options, k: int) -> tuple[ContactProblem, float]:
    surface = options.self_affine(number=k, bandwidth=options.magnifications[-1], length=_LENGTH)
    whole = base_case(surface, reduced_pressure=options.reduced_pressure, solid=_SOLID)
    return whole, options.work * full_contact_energy(whole.field, modulus=whole.contact_modulus)


def _cut(options: Options, k: int, zeta: float, *, along: Solutions | None = None) -> Cut | None:
    whole, work = _full_surface(options, k)
    surface = options.self_affine(number=k, until=zeta, bandwidth=options.magnifications[-1], length=_LENGTH)
    problem = base_case(surface, pressure=whole.pressure, solid=_SOLID)
    if along is None:
        solutions: Solutions = readings(problem, Adhesion(work=work), area="projected")
    else:
        # gamma_eff is that of one reading: so is what it is compared with.
        solutions, left = {"improved": along["improved"]}, along["improved"]
        effective = 0.0 if left is None else float(left.work_at(2 * np.pi / problem.shortest))
        if effective < _LEAST * work:
            return None
        work = effective
    return Cut(problem=problem, work=work, theory=solutions)


def _compared(data: xr.Dataset) -> xr.Dataset:
    data = derive(
        data,
        area_gain_each="area_each / area_plain_each",
        area_parted_excess_each="area_parted_each - area_each",
        **{f"area_gain_{r}_each": f"area_{r}_each / area_plain_persson_each" for r in READINGS},
        **{f"{name}_excess_each": f"{name}_each / {name}_improved_each - 1" for name in _COMPARED},
        energy_share_excess_each="energy_share_each - energy_share_improved_each",
        area_parted_excess_largest="area_parted_excess_each.max()",
    )
    names = (*_COMPARED, "area_gain", "energy_share")
    excesses = [f"{name}_excess" for name in (*_COMPARED, "energy_share")]
    data = mean(data, *names, *excesses, "area_plain", "area_parted", "energy_beyond")
    data = same_of_all(data, "area_plain_persson", *(f"{name}_{r}" for name in names for r in READINGS))
    data = claim(with_pooled_stress(data), "area_half_range", "force_inside_half_range")
    return claim(data, *_COMPARED, "area_gain", "energy_share", **ABSENT)


def views(data: xr.Dataset) -> Views:
    """Area, force and energy over magnification, P(sigma), and P~ by waves."""
    last = data.sizes["magnification"] - 1
    full_work, effective, thin = {"told": 0}, {"told": 1}, {"color": "black", "ls": ":", "lw": 0.9}
    panels = [
        against(
            "magnification",
            Line(name, by="told", joined=False),
            *(Line(f"{name}_{reading}", at=full_work) for reading in READINGS),
            Line(f"{name}_improved", at=effective, label="Persson, one solution", look=thin),
            log="x",
        )
        for name in ("area", "force_inside", "energy_ratio")
    ]
    ends = ("", *(f"_{reading}" for reading in READINGS))
    densities = [Line(f"stress_density{end}", at=full_work, look={"marker": ""}) for end in ends]
    stresses = [
        against(
            "stress", *densities, title=f"zeta = {float(data.magnification[z]):g}", at={"magnification": z}
        )
        for z in (0, last)
    ]
    waves = [f"energy_share{end}" for end in ends]
    columns = ["told", "magnification", "area_plain", *(f"{name}{end}" for name in _COMPARED for end in ends)]
    columns += ["area_gain", *(f"stress_distance_{reading}" for reading in READINGS), "area_parted"]
    return Views(
        table=Table(("told", "magnification"), tuple(columns)),
        budget=("area", "force_inside"),
        figures=[
            Figure(
                "adhesive-by-magnification",
                "Area, force in the contact over the load, and elastic energy over that of full contact, of one nominal "
                "load as shorter waves are added: solved with the work of adhesion w and with gamma_eff(zeta) of the theory.",
                panels,
            ),
            Figure(
                "adhesive-stress",
                "Stress in the contact at the first (left) and last (middle) magnification, with tension, surfaces pooled; "
                "energy of the waves of the whole surface over that in full contact (right).",
                [*stresses, against("wave", *waves, log="x")],
            ),
        ],
        findings=[*_findings(data, [0, last])],
    )


_BESIDE = {"?": "beside"}


def _findings(data: xr.Dataset, ends: list[int]) -> Findings:
    full_work, effective = (data.isel(told=k) for k in (0, 1))
    holds = np.flatnonzero(np.isfinite(effective.area.values))
    gain = (
        "{area} at zeta = {magnification} ({area_gain:~} times that without adhesion), {verdict} the theory's"
    )
    yield finding(
        "comparison",
        "Solved with w over a finite range, A/A0 is {each}.",
        full_work.isel(magnification=ends),
        item=gain + " {area_improved:~} ({area_gain_improved:~} times; {area_old:~} by Eq. 43)",
        by="area_excess",
        words=_BESIDE,
    )
    yield finding(
        "comparison",
        "There F/F_load is {each}.",
        full_work.isel(magnification=ends),
        item="{force_inside} at zeta = {magnification}, {verdict} the theory's {force_inside_improved:~}, U_el/U_full "
        "{energy_ratio} for {energy_ratio_improved:~}, in tension {tension} of the contact for {tension_improved:~}, "
        "and P(sigma) A0/A up to {stress_distance_improved:~} apart",
        by="force_inside_excess",
        words=_BESIDE,
    )
    yield finding(
        "comparison",
        "Solved with gamma_eff(zeta), which holds nothing at {left} of {all} magnifications, A/A0 is {each}.",
        effective.isel(magnification=sorted({int(k) for k in (*holds[:1], *holds[-1:])})),
        item=gain + " along one solution, {area_improved:~}",
        by="area_excess",
        left=data.sizes["magnification"] - holds.size,
        all=data.sizes["magnification"],
        words=_BESIDE,
    )
    yield finding(
        "comparison",
        "With all waves, P~ of those added last, energy stored over that of full contact, is {each}; {energy_beyond:%} of "
        "the energy is in waves shorter than any of the surface, of which the theory knows nothing.",
        data.isel(shell=ends),
        item="{energy_share} up to zeta = {wave}, {verdict} the theory's {energy_share_improved:~}",
        by="energy_share_excess",
        words=_BESIDE,
    )
    form = "The theory knows no range: with half of it (zeta = {magnification}, first surface) A/A0 is {area_half_range} for "
    form += "{area_each}, and F/F_load {force_inside_half_range} for {force_inside_each}."
    yield finding("value", form, full_work.isel(surface=0, magnification=1))
    form = "Parted from full contact instead of approached, A/A0 of a single surface is "
    several = bool((data.area_parted_excess_largest > 1e-3).any())
    minima = ": its energy has several minima, of which the theory has one."
    form += "larger by up to {area_parted_excess_largest}" + minima if several else "the same within 0.001."
    yield finding("value", form, data)
