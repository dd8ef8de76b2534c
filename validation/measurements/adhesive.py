"""One adhesive contact reduced to numbers, and what the theory says of it: area, force, stress, energy by waves."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal

import numpy as np
import xarray as xr

from fem_contact import adhesion, bem
from fem_contact.adhesion import GapLaw
from fem_contact.contact import ContactResult
from fem_contact.response import HalfSpace
from fem_contact.surface import HeightField
from persson.adhesion import AdhesiveContact, Interface
from persson.errors import PerssonError
from persson.interface import detachment_stress
from persson.scale import Scale
from validation.arrays import Array, Grid
from validation.effects.adhesion import Adhesion
from validation.effects.base import Effect, TheoryInputs, full_contact_energy
from validation.effects.hardness import Hardness
from validation.execution.bench import Solves
from validation.execution.measurement import Call, measurement
from validation.execution.press import Press
from validation.measurements.limits import solve_of
from validation.measurements.measurement import even_points
from validation.measurements.theory import wave_powers
from validation.report.estimates import claim, derive
from validation.scenes.problem import ContactProblem
from validation.solvers.theory import TheoryOptions, adhesive_contact, predict

Reading = Literal["improved", "old"]
#: Readings of the elastic energy (Persson 2006, Eqs. 44-49 and 43).
READINGS: tuple[Reading, ...] = ("improved", "old")

#: Edges of the bins of sigma / (E* h'_rms) in the contact; what lies outside counts in the first or last bin.
STRESS_EDGES = np.linspace(-3.0, 5.0, 321)

#: Work of adhesion over the elastic energy of full contact below which a contact is not parted from there.
_HOLDS = 1e-3

#: What the theory says of one surface by reading; None where it has no answer.
Solutions = Mapping[Reading, AdhesiveContact | None]


def readings(
    problem: ContactProblem, *effects: Effect, area: Literal["star", "projected"] = "star"
) -> Solutions:
    """Solve the theory with adhesion for the gradient of one surface by both readings; None where it has no answer."""
    inputs = TheoryInputs.by(problem.elastic, effects)
    scale = Scale(problem.own_spectrum, contact_modulus=problem.contact_modulus)

    def solved(energy: Reading) -> AdhesiveContact | None:
        try:
            options = TheoryOptions(energy=energy, area=area)
            return adhesive_contact(inputs, problem.pressure, options, scale=scale)
        except PerssonError:
            return None

    return {reading: solved(reading) for reading in READINGS}


def interface_energy(contact: ContactResult, law: GapLaw) -> float:
    """Energy that the law yields less what the solid stores, per nominal area [J/m^2]."""
    law = law.on_grid(spacing=max(contact.spacing), contact_modulus=contact.contact_modulus)
    return -float(np.mean(law.energy(np.maximum(contact.gap, 0.0)))) - _stored(contact)


@dataclass(frozen=True, kw_only=True)
class Sticking:
    """Surface and load on some grids, with an attraction, and a hardness where there is one; fields are kept."""

    problem: ContactProblem
    adhesion: Adhesion
    hardness: tuple[Hardness, ...]
    grids: tuple[int, ...]

    def solves(self, *, sticky: bool) -> tuple[Press, ...]:
        """Return the solves with adhesion or without, coarse grid first."""
        effects = (*((self.adhesion,) if sticky else ()), *self.hardness)
        press = partial(Press, method="bem", settings=(("tolerance", 1e-8),), effects=effects)
        return tuple(press(grid=(n, n), problem=self.problem) for n in self.grids)

    def measured(self, solved: Solves) -> xr.Dataset:
        """Return areas on every grid, what the interface gains on the finest, and what the theory says."""
        sticky, plain = ([solved[s].checked() for s in self.solves(sticky=held)] for held in (True, False))
        law, work, problem = self.adhesion.gap_law(), self.adhesion.work, self.problem
        yielded = [contact.at_bound.mean() if self.hardness else math.nan for contact in sticky]
        numbers: dict[str, Any] = {
            "area_pixel": ("grid", [contact.in_contact.mean() for contact in sticky]),
            "area_plain_pixel": ("grid", [contact.in_contact.mean() for contact in plain]),
            "area_plastic_pixel": ("grid", yielded),
            "area_plain_persson": predict(problem, self.hardness).area,
            "area_plastic_improved": math.nan,
            "interface_energy": interface_energy(sticky[-1], law) / work,
            "attraction_range": law.reach / problem.field.rms_height,
        }
        for reading, solution in readings(problem, self.adhesion, *self.hardness).items():
            numbers |= {f"area_{reading}": math.nan, f"interface_energy_{reading}": math.nan}
            if solution is not None:
                numbers[f"area_{reading}"] = solution.real_area
                numbers[f"interface_energy_{reading}"] = solution.macroscopic_work / work
                if self.hardness and reading == "improved":
                    numbers["area_plastic_improved"] = solution.area_plastic[-1]
        data = {f"{name}_each": value for name, value in numbers.items()}
        for name, attracted in (("solve", True), ("solve_plain", False)):
            data[name] = "grid", [solve.key for solve in self.solves(sticky=attracted)]
        return xr.Dataset(data, coords={"points": ("grid", list(self.grids))})


@measurement(
    "sticky-{size}",
    kind="StickyContact",
    words="adhesion",
    version=1,
    seconds=lambda points: 0.05 + 1.2e-5 * points,  # some 500 pairs of transforms
    bytes=400,
)
def sticky_contact(
    *, problem: ContactProblem, grid: Grid, work: float, reach: float, shells: tuple[float, ...]
) -> xr.Dataset:
    """Press one surface without attraction, then with it (exponential law) from there and from full contact.

    The attraction has `work` w [J/m^2] and range `reach` [m]; the elastic energy is summed between the
    rising wavevectors `shells` [1/m].
    """
    field, law = problem.heights(grid), adhesion.Exponential(work=work, reach=reach)
    half_space = HalfSpace(solid=problem.elastic)
    load: dict[str, Any] = {"mean_pressure": problem.pressure, "threads": 1}
    plain = bem.solve(field, half_space, **load).checked()
    load["law"] = law
    contact = adhesion.solve(field, half_space, start=np.maximum(plain.gap, 0.0), **load).contact.checked()
    inside = contact.in_contact
    stress = contact.pressure[inside] / problem.pressure_scale
    shares, _ = np.histogram(np.clip(stress, STRESS_EDGES[0], STRESS_EDGES[-1]), bins=STRESS_EDGES)
    by_shell = partial(_by_shell, field, modulus=problem.contact_modulus, shells=shells)
    full = by_shell(contact.heights)
    parted = math.nan
    # Hardly any attraction is a long way from full contact, and holds nothing there.
    if work > _HOLDS * full.sum():
        held = adhesion.solve(field, half_space, start=np.zeros(field.shape), **load).contact.checked()
        parted = held.in_contact.mean()
    return xr.Dataset(
        {
            "area": inside.mean(),
            "plain": plain.in_contact.mean(),
            "force": np.mean(contact.pressure * inside) / problem.pressure,
            "tension": np.mean(stress < 0) if stress.size else 0.0,
            "gap": contact.mean_gap / problem.field.rms_height,
            "parted": parted,
            "stress": ("stress_bin", shares / inside.size),
            "stored": ("shell", by_shell(contact.displacement)),
            "full": ("shell", full),
            "stored_by_pressure": _stored(contact),
        }
    )


def _by_shell(field: HeightField, displacement: Array, *, modulus: float, shells: tuple[float, ...]) -> Array:
    """Elastic energy [J/m^2] of the waves up to each of `shells` and beyond the last, sum E* q |u|^2 / 4."""
    qx, qy, power = wave_powers(displacement, field.spacing)
    q = np.hypot(qx, qy).ravel()
    shell = np.searchsorted(np.array(shells) * (1 + 1e-9), q)
    energy = modulus / 4 * q * power.ravel()
    return np.bincount(shell, weights=energy, minlength=len(shells) + 1).astype(float)


@dataclass(frozen=True, kw_only=True, eq=False)
class Cut:
    """A surface up to its last wave, the work it is given [J/m^2], and solutions of the theory that hold for it."""

    problem: ContactProblem
    work: float
    theory: Solutions

    def solve(self, points: float, *, shells: tuple[float, ...], finer: int = 1, reach: float = 1.0) -> Call:
        """Return the solve on a grid of `finer` times so many points along a side, rounded up to an even number.

        w / range is the theory's detachment stress at the last wave, where `reach` is 1: it multiplies the
        range.
        """
        n, problem, work = finer * even_points(points), self.problem, self.work
        last = {"contact_modulus": problem.contact_modulus, "wavevector": 2 * np.pi / problem.shortest}
        strength = detachment_stress(work, interface=Interface(work_of_adhesion=work), **last)
        range_of = reach * work / float(strength)
        return sticky_contact(problem=problem, grid=(n, n), work=work, reach=range_of, shells=shells)

    def reduced(self, grids: Sequence[xr.Dataset]) -> xr.Dataset:
        """Return what is read off the solves on each grid, and what the theory says."""
        counted = {"area_pixel": "area", "area_plain_pixel": "plain", "area_parted_pixel": "parted"}
        counted |= {"force_inside_grid": "force", "tension_grid": "tension"}
        data: dict[str, Any] = {
            f"{name}_each": ("grid", [float(measured[of]) for measured in grids])
            for name, of in counted.items()
        }
        energies = [float(measured.stored.sum() / measured.full.sum()) for measured in grids]
        data["energy_ratio_grid_each"] = "grid", energies
        data["area_plain_persson_each"] = predict(self.problem, ()).area
        data["stress_share_each"] = "stress_bin", grids[-1].stress.values
        data["solve"] = "grid", [measured.attrs["solve"] for measured in grids]
        for reading in READINGS:
            for name, value in _seen(self.theory.get(reading), self.problem).items():
                data[f"{name}_{reading}_each"] = ("stress_bin" if np.ndim(value) else (), value)
        middle = (STRESS_EDGES[1:] + STRESS_EDGES[:-1]) / 2
        return xr.Dataset(data, coords={"stress": ("stress_bin", middle)})


def shares_by_shell(
    measured: xr.Dataset, theory: Solutions, *, problem: ContactProblem, edges: Array
) -> xr.Dataset:
    """Return P~ of the waves of a solve between its shells, whose edges [1/m] are given from the first on, and the theory's."""
    stored, full = measured.stored.values, measured.full.values
    data: dict[str, Any] = {
        f"energy_share_{reading}_each": ("shell", _stored_shares(solution, edges, problem))
        for reading, solution in theory.items()
    }
    data |= {
        "energy_share_each": (
            "shell",
            np.divide(stored, full, where=full > 0, out=np.full(full.shape, np.nan))[:-1],
        ),
        "energy_beyond_each": stored[-1] / stored.sum(),
    }
    return xr.Dataset(data, coords={"wave": ("shell", edges[1:] / edges[0])}, attrs=solve_of(measured))


def _seen(contact: AdhesiveContact | None, problem: ContactProblem) -> dict[str, Any]:
    """Read the theory at the last wave; stresses at the nearest node, over E* h'_rms, as shares over the bins."""
    if contact is None:
        numbers = dict.fromkeys(("area", "force_inside", "energy_ratio", "tension"), math.nan)
        return numbers | {"stress_share": np.full(STRESS_EDGES.size - 1, math.nan)}
    q, at = 2 * np.pi / problem.shortest, np.log(contact.wavevectors)
    node = int(np.argmin(np.abs(at - np.log(q))))
    force, stored = (
        np.interp(np.log(q), at, values) for values in (contact.contact_force, contact.elastic_energy)
    )
    x, weights = np.polynomial.legendre.leggauss(6)
    unit, width = problem.pressure_scale, np.diff(STRESS_EDGES)
    stress = (STRESS_EDGES[:-1, None] + width[:, None] * (1 + x) / 2) * unit
    shares = contact.distribution(node, stress) @ weights * width / 2 * unit
    full = full_contact_energy(problem.field, modulus=problem.contact_modulus)
    below = shares[STRESS_EDGES[1:] <= 1e-12].sum()
    return {
        "area": contact.area_at(q),
        "force_inside": force / problem.pressure,
        "energy_ratio": (contact.elastic_energy[0] - stored) / full,
        "tension": below / shares.sum(),
        "stress_share": shares,
    }


def _stored_shares(contact: AdhesiveContact | None, edges: Array, problem: ContactProblem) -> Array:
    """Mean of P~ between wavevectors, by the energy of full contact dV/(E* q); NaN without an answer."""
    if contact is None:
        return np.full(edges.size - 1, np.nan)
    q = np.geomspace(edges[0] * (1 + 1e-9), edges[-1], 4001)
    share = np.interp(np.log(q), np.log(contact.wavevectors), contact.energy_share)
    weight = q**3 * problem.spectrum_shape(q)  # dU_full = pi E* q^2 C / 2 dq
    index = np.clip(np.searchsorted(edges[1:], q), 0, edges.size - 2)
    return np.bincount(index, weights=share * weight) / np.bincount(index, weights=weight)


def with_pooled_stress(data: xr.Dataset) -> xr.Dataset:
    """Add P(sigma) A0/A of all surfaces as one sample, and how far that of each reading is from it."""
    width = float(STRESS_EDGES[1] - STRESS_EDGES[0])
    share = "stress_share{}_each.mean('surface', skipna=False)"
    form = f"{share} / ({share}).sum('stress_bin', skipna=False) / {width}"
    ends = ("", *(f"_{reading}" for reading in READINGS))
    pooled = {f"stress_density{end}": form.format(end, end) for end in ends}
    step = "(stress_density - stress_density_{}).cumsum('stress_bin', skipna=False)"
    apart = {f"stress_distance_{r}": f"abs({step.format(r)}).max('stress_bin') * {width}" for r in READINGS}
    return claim(derive(data, **pooled, **apart), "stress_density", *apart)


def _stored(contact: ContactResult) -> float:
    pressure, displacement = contact.pressure, contact.displacement
    return 0.5 * float(np.mean((pressure - pressure.mean()) * (displacement - displacement.mean())))
