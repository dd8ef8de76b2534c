"""How do area, force, stress and energy of an adhesive contact change as shorter waves are added, and does the theory see it?

One surface is cut at rising magnification zeta and solved with adhesion each time, in two ways: with the work of adhesion
itself, beside the theory of that cut surface; and with the theory's gamma_eff(zeta), which is to stand for all shorter
waves, beside A(zeta) and F(zeta) along one solution. The theory knows no range of the attraction: the law is given the
strength that the theory's detachment stress has at the last wave, so that both end at the same tension.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from pydantic import Field

from persson.adhesion import AdhesiveContact
from persson.elastic import contact_area, stress_variance
from persson.interface import Interface, detachment_stress
from validation.arrays import Array
from validation.effects.base import full_contact_energy
from validation.measures.adhesive import STRESS_EDGES, StickyContact, adhesive_theory
from validation.measures.common import Rising, named, truncated_surface
from validation.report.drawing import Drawing
from validation.scenes.realised import Realised
from validation.scenes.scene import Load, SelfAffineSurface, SolidSpec
from validation.solves.bench import Bench
from validation.studies._options import Hurst, Periods, Seed, Surfaces
from validation.studies._study import StudyOptions
from validation.studies.adhesive_magnification.words import QUANTITIES, TOLD, findings, table
from validation.units import Positive

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Options", "figures", "findings", "run", "table"]

_Reading = Literal["improved", "old"]

_LENGTH, _GRADIENT = 1e-5, 0.1
_SOLID = SolidSpec(young=1e7, poisson=0.5)
#: Readings of the elastic energy (Persson 2006, Eqs. 44-49 and 43).
_READINGS: tuple[_Reading, ...] = ("improved", "old")
#: gamma_eff over w below which no solve is tried.
_LEAST = 0.02


class Options(StudyOptions):
    """Where the spectrum is cut, and how strong the adhesion is."""

    own = "it cuts the spectra of surfaces it makes"

    magnifications: Rising = Field(
        default=(1.5, 2.0, 3.0, 4.0, 6.0, 8.0),
        min_length=2,
        description="zeta = q/q_long of the last wave, rising, above 1; the last is the whole surface",
    )
    reduced_pressure: Positive = Field(default=0.05, description="p* with the gradient of all waves")
    work: Positive = Field(
        default=0.3, description="w over the elastic energy of full contact of all waves, per area"
    )
    points_per_wave: tuple[float, float] = Field(
        default=(16.0, 24.0),
        description="two grids, as the last wave over dx, rising; below 14.2 the range of the attraction is not resolved",
    )
    hurst: Hurst = 0.8
    periods: Periods = 2.0
    surfaces: Surfaces = 6
    seed: Seed = 2006


@dataclass(frozen=True, kw_only=True, eq=False)
class _Cut:
    """A surface up to one magnification, the work it is given, and what the theory says of it by reading."""

    realised: Realised
    work: float
    theory: Mapping[_Reading, _Said]

    @property
    def plain(self) -> float:
        """A/A0 of the theory without adhesion."""
        modulus = self.realised.contact_modulus
        variance = stress_variance(self.realised.field.moments[1], contact_modulus=modulus)
        return float(contact_area(self.realised.pressure, stress_variance=variance))


@dataclass(frozen=True, kw_only=True, eq=False)
class _Said:
    """What the theory says at one magnification; stress as shares over `STRESS_EDGES`."""

    contact: float
    force: float
    energy: float
    tension: float
    stress: Array


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Solve every cut of every surface with its own work and with gamma_eff(zeta), on two grids.

    Returns
    -------
    xarray.Dataset
        `contact` (A/A0), `force`, `energy`, `tension` over (told, surface, magnification), limits over grids, each with its `_error`,
        and `theory_*` over (told, reading, magnification); `plain`, area without adhesion; `parted`, area from full
        contact; `stress` and `theory_stress`, shares over bins; `share` (surface, shell) and `theory_share`: P~ of the
        waves between magnifications of the whole surface; `half_*`: with half the range.
    """
    import xarray as xr

    zetas = np.array(options.magnifications)
    along = [_along(options, k) for k in range(options.surfaces)]
    cuts = {
        (told, k, z): _cut(options, k, zeta, along=along[k] if told == "effective" else None)
        for told in TOLD
        for k in range(options.surfaces)
        for z, zeta in enumerate(zetas)
    }
    cases = {
        (*at, g): _case(options, cut, zetas[at[2]], g)
        for at, cut in cuts.items()
        if cut is not None
        for g in (0, 1)
    }
    # Half the range takes four times the points: on the second magnification of the first surface.
    first = cuts["own", 0, 1]
    assert first is not None
    half = _case(options, first, zetas[1], 0, finer=4, reach=0.5)
    solved = bench.solve([*cases.values(), half])
    measured = {at: solved[case] for at, case in cases.items()}
    data = _numbers(options, cuts, measured) | _shares(options, measured, along)
    data |= {f"half_{name}": ((), float(solved[half][name])) for name in ("area", "force")}
    return xr.Dataset(
        data,
        coords={
            "told": list(TOLD),
            "reading": list(_READINGS),
            "magnification": named("magnification", zetas, "q / q_long of the last wave"),
            "stress_lower": named("stress_bin", STRESS_EDGES[:-1], "sigma / (E* h'_rms), lower edge"),
            "shell_end": named("shell", zetas, "q / q_long where the shell ends"),
        },
        attrs={
            "study": "adhesive-magnification",
            "methods": "theory bem adhesion",
            "hurst": options.hurst,
            "reduced_pressure": options.reduced_pressure,
            "work": options.work,
            "surfaces": options.surfaces,
        },
    )


def _surface(options: Options, k: int, zeta: float) -> SelfAffineSurface:
    whole = {"length": _LENGTH, "gradient": _GRADIENT, "bandwidth": options.magnifications[-1]}
    return truncated_surface(
        zeta, seed=options.seed + k, hurst=options.hurst, periods=options.periods, **whole
    )


#: The theory's solution by reading; None where it has no answer.
_Solutions = Mapping[_Reading, AdhesiveContact | None]


def _whole(options: Options, k: int) -> tuple[Realised, float]:
    """Return the surface with all waves, and the work of adhesion [J/m^2]."""
    surface = _surface(options, k, options.magnifications[-1])
    load = Load(reduced_pressure=options.reduced_pressure)
    whole = Realised(surface=surface, solid=_SOLID, load=load)
    return whole, options.work * full_contact_energy(whole.field, modulus=whole.contact_modulus)


def _along(options: Options, k: int) -> _Solutions:
    """Solve the theory for the whole surface, once for each reading."""
    whole, work = _whole(options, k)
    return {r: adhesive_theory(whole, work=work, energy=r, area="projected") for r in _READINGS}


def _cut(options: Options, k: int, zeta: float, *, along: _Solutions | None = None) -> _Cut | None:
    """Return one surface up to zeta with w, or `along` the theory with gamma_eff(zeta); None where that holds nothing."""
    whole, work = _whole(options, k)
    load = Load(pressure=whole.pressure)
    realised = Realised(surface=_surface(options, k, zeta), solid=_SOLID, load=load)
    q = 2 * np.pi / realised.shortest
    if along is None:
        found: _Solutions = {
            r: adhesive_theory(realised, work=work, energy=r, area="projected") for r in _READINGS
        }
    else:
        # gamma_eff is that of one reading: so is what it is compared with.
        found, left = {"improved": along["improved"]}, along["improved"]
        effective = 0.0 if left is None else float(left.work_at(q))
        if effective < _LEAST * work:
            return None
        work = effective
    said = {reading: _read(one, q, realised) for reading, one in found.items() if one is not None}
    return _Cut(realised=realised, work=work, theory=said)


def _read(contact: AdhesiveContact, q: float, realised: Realised) -> _Said:
    """Read the theory at one wavevector: stresses at the nearest node, over E* h'_rms of the cut surface."""
    node = int(np.argmin(np.abs(np.log(contact.wavevectors / q))))
    at = np.log(contact.wavevectors)
    force, stored = (
        float(np.interp(np.log(q), at, values)) for values in (contact.contact_force, contact.elastic_energy)
    )
    x, weights = np.polynomial.legendre.leggauss(6)
    unit, width = realised.pressure_scale, np.diff(STRESS_EDGES)
    stress = (STRESS_EDGES[:-1, None] + width[:, None] * (1 + x) / 2) * unit
    shares = contact.distribution(node, stress) @ weights * width / 2 * unit
    full = full_contact_energy(realised.field, modulus=realised.contact_modulus)
    below = shares[STRESS_EDGES[1:] <= 1e-12].sum()
    return _Said(
        contact=float(contact.area_at(q)),
        force=force / realised.pressure,
        energy=(float(contact.elastic_energy[0]) - stored) / full,
        tension=float(below / shares.sum()),
        stress=shares,
    )


def _case(
    options: Options, cut: _Cut, zeta: float, grid: int, *, finer: int = 1, reach: float = 1.0
) -> StickyContact:
    """Surface and law on one grid: the strength w / range is the theory's detachment stress at the last wave."""
    points = options.points_per_wave[grid] * zeta * options.periods
    n = finer * 2 * math.ceil(points / 2 - 1e-9)
    modulus, q = cut.realised.contact_modulus, 2 * np.pi / cut.realised.shortest
    interface = Interface(work_of_adhesion=cut.work)
    strength = float(detachment_stress(cut.work, contact_modulus=modulus, wavevector=q, interface=interface))
    q_long = 2 * np.pi * options.periods / _LENGTH
    return StickyContact(
        realised=cut.realised,
        grid=(n, n),
        work=cut.work,
        reach=reach * cut.work / strength,
        shells=tuple(float(q_long * z) for z in options.magnifications),
    )


def _numbers(
    options: Options,
    cuts: Mapping[tuple[str, int, int], _Cut | None],
    measured: Mapping[tuple[str, int, int, int], xr.Dataset],
) -> dict[str, Any]:
    """Limits over the two grids, and the theory, laid out; NaN where nothing was solved."""
    shape = (len(TOLD), options.surfaces, len(options.magnifications))
    names = (*QUANTITIES, "plain", "parted")
    value, error = ({name: np.full(shape, np.nan) for name in names} for _ in range(2))
    plain, stress = np.full(shape, np.nan), np.full((*shape, STRESS_EDGES.size - 1), np.nan)
    theory = {name: np.full((*shape, len(_READINGS)), np.nan) for name in QUANTITIES}
    theory_stress = np.full((*shape, len(_READINGS), STRESS_EDGES.size - 1), np.nan)
    for (told, k, z), cut in cuts.items():
        if cut is None:
            continue
        at = (list(TOLD).index(told), k, z)
        coarse, fine = (_of(measured[told, k, z, grid]) for grid in (0, 1))
        for name in names:
            # Counted edges are off by a share of a cell.
            step = (fine[name] - coarse[name]) / (options.points_per_wave[1] / options.points_per_wave[0] - 1)
            value[name][at], error[name][at] = fine[name] + step, abs(step)
        plain[at], stress[at] = cut.plain, measured[told, k, z, 1].stress.values
        for r, reading in enumerate(_READINGS):
            if reading in cut.theory:
                for name in QUANTITIES:
                    theory[name][(*at, r)] = getattr(cut.theory[reading], name)
                theory_stress[(*at, r)] = cut.theory[reading].stress
    dims = ("told", "surface", "magnification")
    words = {**QUANTITIES, "plain": "A/A0 without adhesion", "parted": "A/A0 parted from full contact"}
    return (
        {name: named(dims, value[name], words[name], unit="1") for name in names}
        | {f"{name}_error": named(dims, error[name], "standard error, grids") for name in names}
        | {
            f"theory_{name}": named((*dims, "reading"), theory[name], f"{QUANTITIES[name]}, theory")
            for name in QUANTITIES
        }
        | {
            "theory_plain": named(dims, plain, "A/A0 without adhesion, theory"),
            "stress": named((*dims, "stress_bin"), stress, "share of the nominal area by stress"),
            "theory_stress": named((*dims, "reading", "stress_bin"), theory_stress, "the same, theory"),
        }
    )


def _of(data: xr.Dataset) -> dict[str, float]:
    found = {name: float(data[name]) for name in ("force", "tension", "plain", "parted")}
    return found | {"contact": float(data.area), "energy": float(data.stored.sum() / data.full.sum())}


def _shares(
    options: Options,
    measured: Mapping[tuple[str, int, int, int], xr.Dataset],
    along: Sequence[_Solutions],
) -> dict[str, Any]:
    """P~ of the waves of the whole surface between magnifications, solved with w, and the theory's."""
    last = len(options.magnifications) - 1
    whole = [measured["own", k, last, 1] for k in range(options.surfaces)]
    share = np.array([data.stored.values[:-1] / data.full.values[:-1] for data in whole])
    beyond = [float(data.stored[-1] / data.stored.sum()) for data in whole]
    theory = np.full((len(_READINGS), options.surfaces, last + 1), np.nan)
    for k in range(options.surfaces):
        realised, _ = _whole(options, k)
        edges = 2 * np.pi * options.periods / _LENGTH * np.array([1.0, *options.magnifications])
        for r, reading in enumerate(_READINGS):
            found = along[k][reading]
            if found is not None:
                theory[r, k] = _theory_share(found, edges, realised)
    return {
        "share": named(("surface", "shell"), share, "P~, energy of these waves over that in full contact"),
        "beyond": named("surface", beyond, "share of the energy in waves shorter than the last"),
        "theory_share": named(("reading", "surface", "shell"), theory, "P~, theory"),
    }


def _theory_share(found: AdhesiveContact, edges: Array, realised: Realised) -> Array:
    """Mean of P~ between wavevectors, by the energy of full contact dV/(E* q)."""
    q = np.geomspace(edges[0] * (1 + 1e-9), edges[-1], 4001)
    share = np.interp(np.log(q), np.log(found.wavevectors), found.energy_share)
    weight = q**3 * np.asarray(realised.spectrum_shape(q))  # dU_full = pi E* q^2 C / 2 dq
    index = np.clip(np.searchsorted(edges[1:], q), 0, edges.size - 2)
    return np.bincount(index, weights=share * weight) / np.bincount(index, weights=weight)


def figures(dataset: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw area, force and energy over magnification, P(sigma), and P~ by waves."""
    from validation.studies.adhesive_magnification import plots

    return (
        Drawing(
            name="adhesive-by-magnification",
            figure=plots.by_magnification(dataset),
            data=dataset.drop_vars(["stress", "theory_stress"]),
            caption="Area, force in the contact over the load, and elastic energy over that of full contact, of one nominal load as "
            "shorter waves are added. Filled: boundary elements with the work of adhesion w, 95 % intervals; lines: theory of "
            "that cut surface, by Eqs. 44-49 and by Eq. 43. Open: with gamma_eff(zeta) of the theory in the place of w; dotted: "
            "the theory along one solution.",
        ),
        Drawing(
            name="adhesive-stress",
            figure=plots.stress(dataset),
            data=dataset[["stress", "theory_stress", "share", "theory_share"]],
            caption="Left and middle: P(sigma) A0/A at the first and the last magnification, with tension, surfaces pooled, and the theory by "
            "Eqs. 44-49 (dashed) and Eq. 43 (dash-dotted). Right: P~, the energy of the waves of the whole surface over that in full contact, by "
            "their magnification.",
        ),
    )
