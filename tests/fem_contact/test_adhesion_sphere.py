"""A sphere against Maugis (1992), JKR, Derjaguin-Muller-Toporov and Greenwood-Johnson (1998)."""

from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq, minimize_scalar
from surfaces import SOFT

from fem_contact import HeightField, NotConverged, Status, adhesion
from fem_contact.adhesion import path as adhesion_path
from fem_contact.adhesion.laws import Dugdale, Exponential

RADIUS = 100.0
MAUGIS_K = 4 / 3
#: Work of adhesion for which Maugis's length (pi w R^2 / K)^(1/3) is 1.
WORK = MAUGIS_K / (np.pi * RADIUS**2)
FORCE = np.pi * WORK * RADIUS
APPROACH = (np.pi**2 * WORK**2 * RADIUS / MAUGIS_K**2) ** (1 / 3)
#: A force on the square lattice of its images moves its own place by -3.9002649 / pi p L / E* (Ewald).
IMAGES = 3.9002649 / np.pi


def strength(maugis):
    return maugis / 2 * (np.pi * WORK * MAUGIS_K**2 / RADIUS) ** (1 / 3)


def maugis_dugdale(radius, maugis):
    """Force over pi w R and approach over (pi^2 w^2 R / K^2)^(1/3) at a contact radius (Maugis 1992)."""

    def excess(m):
        s, t = np.sqrt(m * m - 1), np.arccos(1 / m)
        zone = maugis * radius**2 / 2 * (s + (m * m - 2) * t)
        return zone + 4 * maugis**2 * radius / 3 * (s * t - m + 1) - 1

    top = 2.0
    while excess(top) < 0:
        top *= 2
    m = brentq(excess, 1, top, xtol=1e-14)
    s, t = np.sqrt(m * m - 1), np.arccos(1 / m)
    force = radius**3 - maugis * radius**2 * (s + m * m * t)
    return force, radius**2 - 4 / 3 * maugis * radius * s


def pull_off(maugis):
    told = {"bounds": (0.01, 2.5), "method": "bounded", "options": {"xatol": 1e-9}}
    return -minimize_scalar(lambda a: maugis_dugdale(a, maugis)[0], **told).fun


@dataclass
class Sphere:
    maugis: float
    points: int
    length: float
    law_class: type = Dugdale

    def __post_init__(self):
        x = (np.arange(self.points) - self.points // 2) * self.length / self.points
        heights = -(x[:, None] ** 2 + x[None, :] ** 2) / (2 * RADIUS)
        self.surface = HeightField(heights=heights, lengths=(self.length, self.length))
        self.law = self.law_class(work=WORK, reach=WORK / strength(self.maugis))
        self.unit = FORCE / self.length**2

    def follow(self, **path):
        return adhesion_path.follow(self.surface, SOFT, law=self.law, threads=1, **path)

    def approach(self, point):
        """Approach of a body that is not periodic, over Maugis's unit."""
        return (-point.offset + IMAGES * point.mean_pressure * self.length) / APPROACH


#: From the pressed sphere to beyond pull-off, in steps of the approach.
WAYS = {
    0.1: np.arange(-0.3, 0.4, 0.02),
    0.5: np.arange(-0.3, 1.3, 0.05),
    1.0: np.concatenate([np.arange(-1.0, 0.75, 0.125), np.arange(0.75, 1.3, 0.1)]),
}


@cache
def parted(maugis, points, length):
    """A sphere, and its way until it is pulled off."""
    sphere = Sphere(maugis, points, length)
    return sphere, sphere.follow(offsets=WAYS[maugis] * APPROACH)


@pytest.mark.parametrize(("maugis", "points", "length"), [(0.1, 64, 12.0), (0.5, 64, 10.0), (1.0, 128, 12.0)])
def test_pull_off_force_is_within_two_percent_of_maugis(maugis, points, length):
    sphere, path = parted(maugis, points, length)
    assert path.greatest_tension / sphere.unit == pytest.approx(pull_off(maugis), rel=0.02)


def test_the_limits_are_dmt_and_jkr():
    assert pull_off(0.01) == pytest.approx(2.0, rel=0.005)
    assert pull_off(10.0) == pytest.approx(1.5, rel=0.005)
    sphere = Sphere(0.03, 96, 20.0)
    path = sphere.follow(offsets=np.arange(-0.05, 0.12, 0.01) * APPROACH)
    assert path.greatest_tension / sphere.unit == pytest.approx(2.0, rel=0.02)


def test_force_at_given_approach_follows_maugis_along_the_whole_branch():
    sphere, path = parted(1.0, 128, 12.0)
    points = [point for point in path.points if point.offset < 0.74 * APPROACH]
    assert len(points) == 14
    radii = np.linspace(0.25, 1.9, 300)
    branch = np.array([maugis_dugdale(a, 1.0) for a in radii])
    expected = np.interp([sphere.approach(p) for p in points], branch[:, 1], branch[:, 0])
    computed = np.array([p.mean_pressure for p in points]) / sphere.unit
    # The radius moves over the lattice in steps of a cell, here 1/10 of the unit of length.
    np.testing.assert_allclose(computed, expected, atol=0.05)
    assert abs(np.mean(computed - expected)) < 0.02


def test_snap_in_and_pull_off_under_displacement_lie_where_maugis_has_them():
    sphere = Sphere(2.0, 128, 12.0)
    top = sphere.law.reach * 2.1
    back = np.arange(0, 1.25 * APPROACH, 0.2 * APPROACH)
    path = sphere.follow(offsets=np.concatenate([np.arange(top, 0, -top / 8), back]))
    assert [jump.kind for jump in path.jumps] == ["snap-in", "pull-off"]
    assert path.greatest_tension / sphere.unit == pytest.approx(pull_off(2.0), rel=0.02)
    snap, part = path.jumps
    ramp = sphere.law.on_grid(spacing=12.0 / 128, contact_modulus=1.0).ramp
    # Nothing attracts beyond the end of the ramp; the jump comes as soon as the slope of the ramp acts.
    assert 1 - ramp / 2 < snap.before.offset / sphere.law.reach < 1 + ramp / 2
    radii = np.linspace(0.12, 1.9, 400)
    branch = np.array([maugis_dugdale(a, 2.0) for a in radii])
    lowest = np.argmin(branch[:, 1])
    expected = np.interp(sphere.approach(snap.after), branch[lowest:, 1], branch[lowest:, 0])
    assert snap.after.mean_pressure / sphere.unit == pytest.approx(expected, rel=0.02)
    assert sphere.approach(part.before) == pytest.approx(branch[lowest, 1], abs=0.02)
    assert part.after.mean_pressure == pytest.approx(0, abs=1e-6 * sphere.unit)


def test_jumps_are_located_to_the_resolution_asked_for():
    sphere = Sphere(2.0, 108, 12.0, Exponential)
    path = sphere.follow(offsets=np.arange(0.0, 1.6, 0.4) * APPROACH, resolution=1e-3)
    (jump,) = path.jumps
    assert 0 < jump.after.offset - jump.before.offset <= 1e-3 * sphere.law.reach


def test_tension_beyond_pull_off_ends_the_path_and_is_no_result():
    sphere = Sphere(1.0, 64, 12.0)
    path = sphere.follow(mean_pressures=np.arange(0, -2.05, -0.25) * sphere.unit)
    assert path.jumps[-1].after is None
    assert path.greatest_tension / sphere.unit == pytest.approx(pull_off(1.0), rel=0.02)
    torn = adhesion.solve(sphere.surface, SOFT, law=sphere.law, mean_pressure=-3 * sphere.unit, threads=1)
    assert torn.contact.status is Status.SEPARATED
    with pytest.raises(NotConverged, match="pulled apart"):
        torn.checked()


def hertz_gap(r, edge, amplitude):
    """Displacement outside a Hertzian pressure amplitude sqrt(edge^2 - r^2), E* = 1."""
    inner = (2 * edge**2 - r**2) * np.arcsin(edge / r) + edge * np.sqrt(r**2 - edge**2)
    return amplitude / 2 * inner


@dataclass(frozen=True)
class Tabulated:
    curve: PchipInterpolator
    strength: float
    work: float
    reach: float

    @property
    def steepest(self):
        return 5 * self.strength / self.reach

    def _within(self, gap):
        return np.minimum(gap, self.curve.x[-1])

    def energy(self, gap):
        return self.curve.antiderivative()(self._within(gap)) - self.work

    def traction(self, gap):
        return np.where(gap < self.curve.x[-1], self.curve(self._within(gap)), 0.0)

    def slope(self, gap):
        return np.where(gap < self.curve.x[-1], self.curve.derivative()(self._within(gap)), 0.0)

    def on_grid(self, **_):
        return self


def test_a_sphere_with_the_law_of_greenwood_and_johnson_has_the_double_hertz_stress():
    # Appendix B of Persson 2006: A sqrt(a^2 - r^2) - B sqrt(b^2 - r^2) with a = 1.
    eta = 1.5
    ratio = 10 / 3  # sigma_max / sigma_a
    scale = 2 / np.pi / RADIUS  # A - B, from the curvature of the contact
    tension = scale / ratio  # sigma_a if A a - B b = sigma_max ...
    b_amp = tension / np.sqrt(eta**2 - 1)
    # ... and from A = sigma_max + B eta: A - B = sigma_max + B (eta - 1) fixes the size.
    factor = scale / (ratio * tension + b_amp * (eta - 1))
    tension, b_amp = factor * tension, factor * b_amp
    a_amp = ratio * tension + b_amp * eta
    approach = np.pi / 2 * (a_amp - b_amp * eta**2)
    r = np.linspace(1, eta, 4001)
    inside_b = b_amp * np.pi / 4 * (2 * eta**2 - r**2)
    gap = r**2 / (2 * RADIUS) - approach + hertz_gap(r, 1.0, a_amp) - inside_b
    gap -= gap[0]
    attraction = b_amp * np.sqrt(np.maximum(eta**2 - r**2, 0))
    keep = np.concatenate([[True], np.diff(gap) > 0])
    curve = PchipInterpolator(gap[keep], attraction[keep])
    law = Tabulated(curve, tension, float(curve.antiderivative()(gap[-1])), gap[-1])
    points, length = 192, 9.0
    x = (np.arange(points) - points // 2) * length / points
    radius = np.hypot(x[:, None], x[None, :])
    surface = HeightField(heights=-(radius**2) / (2 * RADIUS), lengths=(length, length))
    force = 2 * np.pi / 3 * (a_amp - b_amp * eta**3)
    offset = -approach + IMAGES * force / length
    state = adhesion.solve(surface, SOFT, law=law, offset=offset, threads=1).checked()
    pressure = state.contact.pressure
    exact = a_amp * np.sqrt(np.maximum(1 - radius**2, 0)) - b_amp * np.sqrt(np.maximum(eta**2 - radius**2, 0))
    assert pressure.max() == pytest.approx(ratio * tension, rel=0.02)
    assert pressure.min() == pytest.approx(-tension, rel=0.02)
    assert np.sum(pressure) * (length / points) ** 2 == pytest.approx(force, rel=0.02)
    interior = radius < 0.9
    np.testing.assert_allclose(pressure[interior], exact[interior], atol=0.02 * pressure.max())
    # P(sigma) vanishes at -sigma_a: sigma = s lies within (s + sigma_a)^2 / A^2 of the contact area.
    contact = state.contact.in_contact
    share = np.mean(pressure[contact] < 0.5 * ratio * tension)
    assert share == pytest.approx(np.mean(exact[radius < 1] < 0.5 * ratio * tension), abs=0.03)
