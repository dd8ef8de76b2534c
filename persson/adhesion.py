"""Adhesive contact: effective work of adhesion, detachment stress and contact area, solved together.

Persson 2006, Secs. 8.1-8.6 and 9. At each magnification the contact may carry tension up to sigma_a, which
depends on the adhesive energy left after paying for the elastic deformation on all shorter scales; that
energy depends on the area of contact on all shorter scales, which depends on sigma_a. The loop is closed by
a fixed-point iteration.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline, PchipInterpolator

from persson._checks import (
    Array,
    in_proportion,
    instance,
    non_negative,
    positive,
    real,
    scalar,
    whole,
    within,
)
from persson._window import FALLING
from persson.diffusion import Diffusion, diffuse_once
from persson.errors import NotConverged, OutsideTheory
from persson.interface import Interface as Interface
from persson.interface import closing_work as closing_work
from persson.interface import crossover_length as crossover_length
from persson.interface import detachment_stress as detachment_stress
from persson.interface import opening_work as opening_work
from persson.scale import Scale, of_variance
from persson.spectrum import area_factor, check_sample

#: Spacing of the nodes in ln V and in ln q, on the coarse and on the fine level.
_SPACINGS = (0.24, 0.12)
#: Below this share of the nominal area contact counts as lost.
_LOST = 1e-13
#: Share of the largest gamma_eff to which it is known, over the tolerance.
_ROUNDED = 1e-4
#: Rounds that a load on the way to none gets: near the loss of contact the state without load takes more.
_ROUNDS_UNDER_LOAD = 300


class AdhesionStatus(Enum):
    """How the iteration ended; the value is a sentence."""

    CONVERGED = "converged"
    NO_CONTACT = "no contact: without load, the adhesive energy does not pay for the elastic deformation"
    ROUND_LIMIT = "the fixed-point iteration stopped at its limit: allow more rounds or a larger tolerance"


@dataclass(frozen=True, kw_only=True)
class AdhesiveContact:
    """Adhesive contact against the wavevector up to which roughness is resolved.

    Attributes
    ----------
    wavevectors, variance : (n,) arrays
        q [1/m] of the nodes and V(q) [Pa^2].
    area, area_plastic : (n,) arrays
        Area in contact (yielded area included) and yielded area, over the nominal area.
    work : (n,) array
        gamma_eff(q) [J/m^2], raw: negative where the surfaces do not adhere.
    tensile_limit : (n,) array
        sigma_a(q) [Pa].
    contact_force : (n,) array
        F(q)/A0 [Pa], the force in the area of contact: it exceeds the load by what pulls outside of it, and
        grows by -sigma_a dA (Persson 2006, Eq. 40).
    elastic_energy : (n,) array
        U_el(q)/A0 [J/m^2], stored by the waves shorter than those at q.
    energy_share : (n,) array
        P~(q), the energy stored over that of full contact: Eq. 44, or P, or Eq. 50, as the interface says.
    macroscopic_work : float
        gamma_eff(1) [J/m^2], with the energy of all roughness.
    real_area : float
        A(q_short)/A0.
    error_estimate : float
        Change of `real_area` when the number of nodes is halved, plus the last change of the iteration.
    rounds : int
        Iterations on the fine nodes.
    """

    wavevectors: Array
    variance: Array
    area: Array
    area_plastic: Array
    work: Array
    tensile_limit: Array
    contact_force: Array
    elastic_energy: Array
    energy_share: Array
    macroscopic_work: float
    real_area: float
    error_estimate: float
    rounds: int
    status: AdhesionStatus
    _state: Diffusion | None = None

    def checked(self) -> Self:
        """Return this result, or raise `NotConverged`; to have no contact is a result."""
        if self.status is AdhesionStatus.ROUND_LIMIT:
            raise NotConverged(f"{self.status.value} (last error estimate {self.error_estimate:.3g})")
        return self

    def area_at(self, wavevector: ArrayLike) -> Array:
        """A(q)/A0 between the nodes, monotonically interpolated in ln q."""
        return self._between(wavevector, self.area)

    def work_at(self, wavevector: ArrayLike) -> Array:
        """gamma_eff(q) [J/m^2] between the nodes."""
        return self._between(wavevector, self.work)

    def distribution(self, index: int, stress: ArrayLike) -> Array:
        """P(sigma, zeta) [1/Pa] per nominal area at ``wavevectors[index]``, for stresses [Pa].

        The elastic contact: from -sigma_a, tension, to the hardness. It integrates to area - area_plastic.
        """
        whole("index", index, least=-self.wavevectors.size, most=self.wavevectors.size - 1)
        if self._state is None:
            return np.zeros_like(real("stress", stress))[()]
        return self._state.distribution(index, stress)

    def _between(self, wavevector: ArrayLike, values: Array) -> Array:
        first = self.wavevectors[0]
        q = np.clip(non_negative("wavevector", wavevector), first, self.wavevectors[-1])
        return np.asarray(PchipInterpolator(np.log(self.wavevectors / first), values)(np.log(q / first)))[()]


@dataclass(frozen=True, kw_only=True)
class _Nodes:
    """Nodes: q, T = ln(V / reference), E*, area factor, and the tension squared of gamma_eff = 1."""

    q: Array
    t: Array
    modulus: Array
    factor: Array
    per_work: Array


@dataclass(frozen=True, kw_only=True)
class _Case:
    scale: Scale
    pressure: float
    interface: Interface
    yield_stress: float | Callable[[Array], Array] | None
    reference: float

    def nodes(self, spacing: float, onset: float | None) -> _Nodes:
        """Place nodes evenly in ln V and ln q together, and quadratically dense around the onset."""
        scale = self.scale
        span = (scale.q_short - scale.q_min) / scale.q_min
        q = scale.q_min * (1 + np.geomspace(min(1e-4, span / 8), span, 1500))
        q[-1] = scale.q_short
        t = np.log(scale.variance(q) / self.reference)
        t = np.maximum.accumulate(t)
        q, t = q[t > -28], t[t > -28]
        path = np.append(0.0, np.cumsum(np.diff(t) + np.log1p(np.diff(q) / q[:-1])))
        count = max(math.ceil(path[-1] / (2 * spacing)), 12)
        chosen = np.interp(np.linspace(0, path[-1], count + 1), path, t)
        if onset is not None:
            ramp = np.linspace(0, 1, math.ceil(2 / spacing) + 1)[1:] ** 2
            chosen = np.concatenate([chosen, onset - ramp, [onset], onset + ramp])
        chosen = np.unique(np.clip(chosen, t[0], 0.0))
        chosen = chosen[np.append(True, np.diff(chosen) > 1e-4 * spacing)]
        if chosen[-1] < 0:
            chosen[-1] = 0.0
        q = scale.wavevector(self.reference * np.exp(chosen))
        modulus = scale.modulus(q)
        star = self.interface.area == "star"
        return _Nodes(
            q=q,
            t=chosen,
            modulus=modulus,
            factor=area_factor(scale.spectrum.m2(q)) if star else np.ones_like(q),
            per_work=self.interface.alpha * modulus * q,
        )


def solve_adhesion(
    scale: Scale,
    *,
    pressure: float,
    interface: Interface,
    yield_stress: float | Callable[[Array], Array] | None = None,
    start: AdhesiveContact | None = None,
    tolerance: float = 1e-6,
    rounds: int = 150,
) -> AdhesiveContact:
    r"""Solve for gamma_eff(q), sigma_a(q) and A(q) together.

    .. math:: A^*(\zeta)\gamma_\mathrm{eff}(\zeta) = A^*(\zeta_1)\Delta\gamma - U_\mathrm{el}(\zeta), \qquad
              U_\mathrm{el}(\zeta) = A_0 \int_\zeta^{\zeta_1} \tilde P \,\frac{dV}{E^* q}

    Parameters
    ----------
    scale : Scale
        Spectrum and modulus, which may be graded.
    pressure : float
        Nominal pressure sigma_0 [Pa]; 0 or negative (tension) where adhesion holds the bodies together.
    interface : Interface
        Work of adhesion and the reading of the theory.
    yield_stress : float or callable, optional
        Hardness [Pa], constant or as a function of q that does not decrease (Persson 2006, Sec. 9). Yielded
        contact adheres; only elastic contact stores energy.
    start : AdhesiveContact, optional
        A state to continue from, such as that at a smaller tension. Without load the bodies are otherwise
        taken to have been pressed together first.
    tolerance : float
        Change of area and of gamma_eff / Delta gamma at which the iteration stops, or a ten-thousandth of it
        in gamma_eff over its largest.
    rounds : int
        Largest number of iterations per level.

    Returns
    -------
    AdhesiveContact
        Call `.checked()` before using it as a result.

    Raises
    ------
    OutsideTheory
        For a load that is not below the hardness, or a hardness that falls with q. Tension beyond what the
        interface holds is a result: no contact.

    Notes
    -----
    Persson 2006, Eqs. 35-50. With 2 pi q^3 C E*^2/4 dq = dV, Eq. 43 becomes the integral above. Where
    adhesion sets in under load sigma_a starts like a square root; nodes are dense there and the steps are
    even in its argument.
    """
    instance("scale", scale, Scale)
    instance("interface", interface, Interface)
    if start is not None:
        instance("start", start, AdhesiveContact, what="an earlier result of `solve_adhesion`")
    if yield_stress is not None and not callable(yield_stress):
        positive("yield_stress", yield_stress)
    within("tolerance", tolerance, "[1e-14, 0.1]")
    whole("rounds", rounds, least=1, most=100_000)
    pressure = scalar("pressure", pressure)
    if pressure < 0:
        check_sample(scale.spectrum, "under tension the size L of the sample matters")
    case = _Case(
        scale=scale,
        pressure=pressure,
        interface=interface,
        yield_stress=yield_stress,
        reference=float(scale.variance(scale.q_short)),
    )
    with in_proportion():
        if start is None and pressure <= 0:
            start = _approach(replace(case, pressure=0.0), tolerance, rounds)
        coarse = _iterate(case, _SPACINGS[0], start, tolerance, rounds)
        if coarse.status is AdhesionStatus.NO_CONTACT:
            return coarse
        fine = _iterate(case, _SPACINGS[1], coarse, tolerance, rounds)
        change = abs(fine.real_area - coarse.real_area)
        lost = fine.status is AdhesionStatus.NO_CONTACT
        return fine if lost else replace(fine, error_estimate=fine.error_estimate + change)


def _approach(case: _Case, tolerance: float, rounds: int) -> AdhesiveContact | None:
    """Contact under a load that is taken away in steps: where it sticks, a start for the case without load.

    Without load the equations also have the solution of no contact, and an iteration started anywhere falls
    into it. The state left by a vanishing load decides: adhesion holds if its macroscopic energy is
    positive.
    """
    scale, gamma = case.scale, case.interface.work_of_adhesion
    largest = math.sqrt(case.interface.alpha * gamma * float(scale.modulus(scale.q_min)) * scale.q_min)
    hardness, most = case.yield_stress, 3 * largest
    limit = hardness(np.array([scale.q_min]))[0] if callable(hardness) else hardness or math.inf
    most = most if most < limit else 0.5 * limit  # a solid that yields bears less
    state: AdhesiveContact | None = None
    slope = math.inf
    for power in range(12):
        load = most * 0.2**power
        under_load = replace(case, pressure=load)
        state = _iterate(under_load, _SPACINGS[0], state, 1e-4, min(rounds, _ROUNDS_UNDER_LOAD))
        if state.macroscopic_work > 0:
            free = _iterate(case, _SPACINGS[0], state, tolerance, rounds)
            if free.status is AdhesionStatus.CONVERGED:
                return free
        elif abs(state.real_area / load / slope - 1) < 0.02:
            # Area and energies have become proportional to the load: nothing changes below.
            break
        slope = state.real_area / load
    return state


def _iterate(
    case: _Case, spacing: float, start: AdhesiveContact | None, tolerance: float, rounds: int
) -> AdhesiveContact:
    gamma = case.interface.work_of_adhesion
    nodes = case.nodes(spacing, None)
    work = np.full(nodes.t.shape, gamma)
    onset: float | None = None
    if start is not None:
        t = np.log(start.variance / case.reference)
        onset = _onset(case, t, start.work)
        nodes = case.nodes(spacing, onset)
        work = PchipInterpolator(t, start.work)(np.clip(nodes.t, t[0], t[-1]))
    area = np.zeros(nodes.t.shape)
    failures = 0
    for count in range(1, rounds + 1):
        try:
            state = _diffuse(case, nodes, work, onset)
        except OutsideTheory as error:
            if case.pressure > 0 or str(error) == FALLING:
                raise
            return _empty(case, nodes, count)
        if state.area[-1] < _LOST:
            return _empty(case, nodes, count)
        result = _result(case, nodes, state, count)
        new_work = result.work
        if case.pressure <= 0 and new_work[0] <= 0:
            failures += 1
            if failures > 2:
                return _empty(case, nodes, count)
            new_work = 0.5 * (new_work + np.maximum(work, 0.0))
        # Where nothing sticks gamma_eff is the elastic energy, many times Delta gamma, and rounded as such.
        scale = max(gamma, _ROUNDED * float(np.max(np.abs(new_work))))
        change = max(float(np.max(np.abs(new_work - work))) / scale, float(np.max(np.abs(state.area - area))))
        result = replace(result, error_estimate=change)
        if change < tolerance:
            return result
        damping = 1.0 if count < 40 else 0.5
        work, area = work + damping * (new_work - work), state.area
        moved = _onset(case, nodes.t, work)
        if (moved is None) != (onset is None) or (moved is not None and abs(moved - (onset or 0.0)) > 1e-7):
            onset = moved
            fresh = case.nodes(spacing, onset)
            work = PchipInterpolator(nodes.t, work)(np.clip(fresh.t, nodes.t[0], nodes.t[-1]))
            area = np.interp(fresh.t, nodes.t, area)
            nodes = fresh
    return replace(result, status=AdhesionStatus.ROUND_LIMIT)


def _onset(case: _Case, t: Array, work: Array) -> float | None:
    """T at which gamma_eff last turns positive, None where it is positive from the start or never."""
    negative = np.flatnonzero(work <= 0)
    if case.pressure <= 0 or negative.size == 0 or negative[-1] == t.size - 1:
        return None
    last = negative[-1]
    roots = PchipInterpolator(t, work).roots(extrapolate=False)
    inside = roots[(roots >= t[last]) & (roots <= t[last + 1])]
    return float(inside[-1]) if inside.size else float(t[last])


def _diffuse(case: _Case, nodes: _Nodes, work: Array, onset: float | None) -> Diffusion:
    strength = case.interface.ideal_strength
    square = PchipInterpolator(nodes.t, work * nodes.per_work)
    first, last = nodes.t[0], nodes.t[-1]
    # The onset lags behind the root by what moves no nodes: sigma_a starts there all the same, or the first
    # of the dense steps would see a root on either side of the break in turn, and the rounds not settle.
    start, offset = (first, 0.0) if onset is None else (onset, float(square(onset)))

    def tensile_limit(variance: Array) -> Array:
        t = np.clip(np.log(variance / case.reference), first, last)
        bare = np.sqrt(np.where(t < start, 0.0, np.maximum(square(t) - offset, 0.0)))
        return bare if strength is None else bare / (1 + bare / strength)

    hardness = case.yield_stress
    return diffuse_once(
        case.reference * np.exp(nodes.t),
        pressure=case.pressure,
        tensile_limit=tensile_limit,
        yield_stress=of_variance(hardness, case.scale) if callable(hardness) else hardness,
        breaks=() if onset is None else (case.reference * math.exp(onset),),
        modes=48,
        step=0.3,
    )


def _tensile_limit(case: _Case, nodes: _Nodes, work: Array) -> Array:
    return detachment_stress(
        work, contact_modulus=nodes.modulus, wavevector=nodes.q, interface=case.interface
    )


def _result(case: _Case, nodes: _Nodes, state: Diffusion, count: int) -> AdhesiveContact:
    """Eq. 37 at the nodes, and at zeta = 1."""
    variance, load = state.variance, case.pressure
    if case.interface.energy == "old":
        share = state.area_elastic
    elif case.interface.energy == "improved":
        share = state.mean_square / variance
    else:
        # Eq. 50 drops the terms of Eq. 48 that are linear and quadratic in sigma_0.
        extra = 2 * load * (state.load_elastic - load) + load * load * (1 - state.area_elastic)
        share = (state.mean_square + extra) / variance
    density = share * variance / (nodes.modulus * nodes.q)
    total = CubicSpline(nodes.t, density).antiderivative()
    energy = total(nodes.t[-1]) - total(nodes.t)
    # Before the first node V ~ q - q_min: the integrand is 1 / (E* q) over V.
    total_energy = energy[0] + density[0]
    gained = state.area[-1] * nodes.factor[-1] * case.interface.work_of_adhesion
    area = np.maximum(state.area, 1e-300)
    work = (gained - energy) / (area * nodes.factor)
    carried = state.area_plastic * np.where(state.area_plastic != 0, state.yield_stress, 0.0)
    return AdhesiveContact(
        wavevectors=nodes.q,
        variance=variance,
        area=state.area,
        area_plastic=state.area_plastic,
        work=work,
        tensile_limit=_tensile_limit(case, nodes, work),
        contact_force=state.load_elastic + carried,
        elastic_energy=energy,
        energy_share=share,
        macroscopic_work=float(gained - total_energy),
        real_area=float(state.area[-1]),
        error_estimate=math.nan,
        rounds=count,
        status=AdhesionStatus.CONVERGED,
        _state=state,
    )


def _empty(case: _Case, nodes: _Nodes, count: int) -> AdhesiveContact:
    names = ("area", "area_plastic", "work", "tensile_limit", "contact_force", "elastic_energy")
    nothing: dict[str, Any] = dict.fromkeys((*names, "energy_share"), np.zeros_like(nodes.q))
    return AdhesiveContact(
        wavevectors=nodes.q,
        variance=case.reference * np.exp(nodes.t),
        **nothing,
        macroscopic_work=0.0,
        real_area=0.0,
        error_estimate=0.0,
        rounds=count,
        status=AdhesionStatus.NO_CONTACT,
    )
