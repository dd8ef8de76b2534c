"""Between the faces: adhesion and what a loop loses, friction of viscoelastic solids, heat and leaks.

Sliding is steady, on a viscoelastic half-space: Hunter's cylinder, limits, and friction computed twice. What
passes through contact and gap: spots, channels and grooves.
"""

from __future__ import annotations

import itertools
import math

import numpy as np
from scipy.optimize import brentq
from scipy.special import ive, kve

from fem_contact import adhesion, bem
from fem_contact.adhesion import Exponential
from fem_contact.conductance import contact_conductance, frozen_contact
from fem_contact.leak import flow_conductance
from fem_contact.response import BondedLayer, HalfSpace
from fem_contact.sliding import SlidingContact, slide
from fem_contact.solid import Solid
from fem_contact.surface import HeightField, random_surface
from fem_contact.viscoelastic import PronySolid
from persson.sliding import friction_of_waves
from validation.arrays import Array
from validation.cases import Checks, below, case, near, order, relative, within
from validation.cases._closed_forms import LATTICE_CUBE, LATTICE_MADELUNG, periodic, places
from validation.measurements.theory import wave_powers

_BODY = HalfSpace(solid=Solid(young=1.0, poisson=0.0))

_LAW = Exponential(work=8e-4, reach=0.02)


@case("adhesion-balance", source="half-space, wave by wave", tolerance="solver")
def _balance() -> Checks:
    """In an adhesive state forces balance, the gap closes, and its energy is the sum of both parts."""
    x = np.cos(2 * math.pi * np.arange(24) / 24)
    surface = periodic(0.02 * x[:, None] * x[None, :])
    state = adhesion.solve(surface, _BODY, law=_LAW, mean_pressure=0.01, tolerance=1e-9).checked()
    contact = state.contact
    geometry = contact.displacement - surface.heights + contact.offset - contact.gap
    pull = contact.pressure + _LAW.traction(contact.gap)
    # u-hat = 2 p-hat / (E* q), without its mean; E* = 1, L = 1.
    q = 2 * math.pi * np.fft.fftfreq(24, 1 / 24)
    size = np.hypot(q[:, None], q[None, :])
    size[0, 0] = np.inf
    moved = np.fft.ifft2(2 / size * np.fft.fft2(contact.pressure)).real
    energy = np.mean(0.5 * contact.pressure * moved + _LAW.energy(contact.gap))
    mismatch = moved - (contact.displacement - contact.displacement.mean())
    pulled = pull[~contact.in_contact] / _LAW.strength
    yield below("gap - (u - h + offset) over h_rms", geometry / surface.rms_height, 1e-12)
    yield below("force on a free point over the strength", pulled, 1e-6)
    yield below("displacement of the pressure, over h_rms", mismatch / surface.rms_height, 1e-9)
    yield relative("elastic and gap energy [J/m^2]", state.energy, energy, 1e-9)


@case("adhesion-loop", source="conservation of energy", tolerance="estimate")
def _loop() -> Checks:
    """The work of a loop of approach and retraction is what its jumps lose."""
    # One peak in a period: two alike would leave it to rounding which of them snaps first.
    x = np.cos(2 * math.pi * np.arange(64) / 64)
    surface = periodic(0.01 * (x[:, None] + x[None, :]))
    # As steep as the grid carries.
    law = Exponential(work=0.95 * 0.02**2 * 32, reach=0.02)
    offsets = np.linspace(0.14, 0.008, 40)
    there_and_back = [*offsets, *offsets[::-1]]
    path = adhesion.follow(
        surface, _BODY, law=law, offsets=there_and_back, resolution=0.01, least_jump=0.005, tolerance=1e-8
    )
    work = stored = 0.0
    for one, two in itertools.pairwise(path.points):
        work -= 0.5 * (one.mean_pressure + two.mean_pressure) * (two.offset - one.offset)
        stored += two.energy - one.energy
    kinds = [jump.kind for jump in path.jumps]
    told = (kinds[0], kinds[-1]) == ("snap-in", "pull-off")
    yield near("snap-in first, pull-off last", told, 1.0, 0.0)
    yield below("energy stored by the loop over w", stored / law.work, 1e-6)
    # Losses that are no jumps, and the trapezoidal rule on the smooth branches, leave .001 w.
    yield near("work of the loop over w", work / law.work, path.dissipated / law.work, 0.0015)
    yield within("loss of the loop over w", path.dissipated / law.work, 0.04, 0.08)


#: Of the rough cases: Poisson ratio and h'_rms.
_POISSON, _GRADIENT = 0.3, 0.1

_RESPONSE = "linear viscoelasticity: K. L. Johnson, Contact Mechanics, Sec. 6.5"


def _standard(ratio: float, poisson: float = _POISSON) -> PronySolid:
    """Return a standard solid with E_0 = 1 and a retardation time of 1."""
    return PronySolid.standard(relaxed=1.0, unrelaxed=ratio, time=1.0, poisson=poisson)


def _rough(n: int) -> HeightField:
    """Return a surface of period 1 with waves of 1 to 1/8."""
    made = random_surface(
        lambda q: q**-3.6, q_short=16 * np.pi * (1 + 1e-9), lengths=(1.0, 1.0), shape=(n, n), seed=11
    )
    return HeightField(heights=made.heights * (_GRADIENT / made.rms_gradient), lengths=made.lengths)


def _slid(n: int, ratio: float, velocity: float, *, reduced: float = 0.1) -> SlidingContact:
    load = reduced * _GRADIENT / (1 - _POISSON**2)
    return slide(_rough(n), _standard(ratio), velocity=velocity, mean_pressure=load).checked()


def _hunter(load: float, *, ratio: float, drift: float) -> tuple[float, float, float]:
    r"""Half width, centre and friction of a cylinder of radius 1 on a standard solid, E_0* = 1.

    With P = p - v tau_r p', U = u - v tau u' (drift = v tau, tau_r = tau E_0/E_inf) the contact is elastic:

    .. math:: P \sqrt{1-\xi^2} = \tfrac a2 (1-\xi^2) - \tfrac{m - v\tau}{2} \xi + D,\quad D = W/(\pi a) - a/4

    p = 0 at the rear end and an unstrained slope ahead of the front one give two conditions for a and m.
    """

    def constants(a: float) -> tuple[float, float]:
        level = load / (math.pi * a) - a / 4
        return level, 2 * level * float(kve(0, a / drift) / kve(1, a / drift))

    def rear(a: float) -> float:
        level, centre = constants(a)
        turn = a * ratio / drift
        return (drift / ratio + centre - drift) / 2 * float(ive(1, turn)) + level * float(ive(0, turn))

    elastic = math.sqrt(4 * load / math.pi)
    a = brentq(rear, 0.5 * elastic / math.sqrt(ratio), 1.5 * elastic, xtol=1e-15)
    centre = constants(a)[1]
    moment = load * centre - math.pi * a**2 * (centre - drift) / 4 - load * drift / ratio
    return a, centre, moment / load


@case("sliding-cylinder", source="[hunter1961]", tolerance="grid")
def _cylinder() -> Checks:
    """A cylinder on a standard solid has Hunter's friction within 1 %, and his contact to a cell."""
    n, elastic = 2048, 0.02
    load = math.pi * elastic**2 / 4
    x = places(n)
    # The images of the load bend the surface like 2 pi / 3 load x: the cylinder is made flatter by that.
    heights = -(x**2)[:, None] / 2 * (1 - 2 * math.pi / 3 * load)
    for ratio, speed in ((10.0, 0.5), (1000.0, 0.5), (1000.0, 1.5)):
        drift = speed * elastic
        result = slide(periodic(heights), _standard(ratio, 0.0), velocity=drift, mean_pressure=load).checked()
        a, centre, friction = _hunter(load, ratio=ratio, drift=drift)
        pressure = result.contact.pressure[:, 0]
        touched = x[result.contact.in_contact[:, 0]]
        parameters = f"E_inf/E_0 = {ratio:g}, v tau = {speed:g} a_0"
        yield relative(f"friction, {parameters}", np.sum(x * pressure) / np.sum(pressure), friction, 0.01)
        yield near(f"half width, {parameters}", (touched[-1] - touched[0]) / 2, a, 1 / n)
        yield near(f"centre, {parameters}", (touched[-1] + touched[0]) / 2, centre, 1 / n)


@case("sliding-twice", source=_RESPONSE, tolerance="grid")
def _twice() -> Checks:
    """Pressure on slopes and losses of the solid give one friction as the grid is refined."""
    result = _slid(256, 10.0, 0.03)
    ratio = result.slopes / result.dissipation
    yield relative("friction by slopes over that by losses, n = 256", ratio, 1.0, 0.005)
    # A thousandfold modulus leaves percents at these sizes; what is asked is that they fall.
    coarse, fine = (_slid(n, 1000.0, 0.3) for n in (64, 128))
    apart = [abs(one.slopes / one.dissipation - 1) for one in (coarse, fine)]
    yield below("E_inf/E_0 = 1000: difference, n = 128 over 64", apart[1] / apart[0], 0.5)


@case("sliding-full", source="[persson2001]", tolerance="solver")
def _full() -> Checks:
    """In full contact solver and theory give the friction that the waves add up to."""
    result = _slid(32, 50.0, 0.02, reduced=60.0)
    surface = _rough(32)
    x, y, power = wave_powers(surface.heights, surface.spacing)
    there = power > 1e-20 * power[1:].max()
    there[0, 0] = False
    theory = friction_of_waves(
        x[there],
        y[there],
        power=power[there],
        pressure=60.0 * _GRADIENT / (1 - _POISSON**2),
        velocity=0.02,
        modulus=_standard(50.0).modulus,
        poisson=_POISSON,
    )
    yield relative("friction by slopes", result.slopes, theory.friction, 1e-6)
    yield relative("friction by losses", result.dissipation, theory.friction, 1e-6)


_SOLID = Solid(young=1.0, poisson=0.2)
_HALF_SPACE = HalfSpace(solid=_SOLID)


def _spot(n: int, radius: float) -> float:
    """Resistance of a circular spot in a period of 1 over Holm's with the field of its neighbours."""
    x = places(n, 0.37)
    inside = np.hypot(x[:, None], x[None, :] - 0.24 / n) < radius
    result = bem.solve(periodic(np.where(inside, 0.0, -1.0)), _HALF_SPACE, mean_pressure=1e-3).checked()
    modulus = _SOLID.contact_modulus
    stiffness = frozen_contact(result, _HALF_SPACE).stiffness
    conductance = contact_conductance(stiffness, contact_modulus=modulus, resistivities=(3.0, 1.0))
    width = math.sqrt(result.in_contact.mean() / math.pi)
    # The other spots and the background lift this one: near it M + r^2/4 sum 1/R^3, and the mean of
    # |r - r'|^2 over two points of a flat punch is 4 a^2 / 3.
    holm = (3.0 + 1.0) / (4 * width)
    neighbours = (3.0 + 1.0) / (2 * math.pi) * (LATTICE_MADELUNG + LATTICE_CUBE / 3 * width**2)
    return 1 / conductance / (holm + neighbours)


@case("flow-spot", source="R. Holm (1967); [barber2003]", tolerance="grid")
def _spots() -> Checks:
    """The contact resistance of a circular spot is Holm's, with the field of its neighbours."""
    coarse, fine = _spot(96, 0.1), _spot(192, 0.1)
    layer = BondedLayer(solid=_SOLID, thickness=0.3)
    flat = periodic(np.zeros((8, 6)))
    pressed = frozen_contact(bem.solve(flat, layer, mean_pressure=1e-3).checked(), layer)
    # A clamped layer under uniform pressure is compressed alone: (1 - nu) E / (1 + nu) / (1 - 2 nu) / d.
    oedometric = (1 - 0.2) / (1 + 0.2) / (1 - 2 * 0.2) / 0.3
    # The edge of the set is off by a part of a cell, the resistance by a part of it in first order.
    words = "resistance over Holm's in a lattice, two grids in first order"
    yield relative(words, 2 * fine - coarse, 1.0, 5e-3)
    yield below("its error on the finer grid", abs(fine - 1), 0.02)
    yield relative("stiffness of a bonded layer in full contact [1/m]", pressed.stiffness, oedometric, 1e-9)


def _grooved(n: int, phase: Array) -> Array:
    return 1 + 0.6 * np.cos(phase) + np.zeros((n, n))


@case(
    "flow-channel",
    source="O. Reynolds (1886); oblique grooves: the mean of both conductances",
    tolerance="grid",
)
def _channels() -> Checks:
    """The conductance of a gap is that of its channels and grooves."""
    gap = np.zeros((9, 7))
    gap[:, 2:5] = 0.2
    channel = flow_conductance(gap, (3.0, 1.4), axis="x").conductance
    closed = flow_conductance(gap, (3.0, 1.4), axis="y").conductance
    along, across = 1 + 1.5 * 0.36, (1 - 0.36) ** 2.5 / (1 + 0.36 / 2)
    phase = {n: 2 * np.pi * (np.arange(n) + 0.5) / n for n in (16, 32, 64)}
    grooves = _grooved(64, phase[64][:, None])
    parallel, crossing = (
        12 * flow_conductance(grooves, (1.0, 2.5), axis=axis).conductance for axis in ("y", "x")
    )
    exact = (along + across) / 2
    errors = [
        abs(12 * flow_conductance(_grooved(n, a[:, None] + a[None, :]), (1.0, 1.0)).conductance - exact)
        for n, a in phase.items()
    ]
    words = "K of a channel of width w on 3/7 of the period [m^3]"
    yield relative(words, channel, 3 / 7 * 0.2**3 / 12, 1e-12)
    yield below("K across it", closed, 0.0)
    yield relative("12 K along grooves 1 + .6 cos", parallel, along, 1e-12)
    # The mean of an analytic function over a period converges faster than any power.
    yield relative("12 K across them", crossing, across, 1e-8)
    yield order("order along oblique ones", list(phase), errors, expected=2, tolerance=0.2)
