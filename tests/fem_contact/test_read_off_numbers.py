"""Limits, errors and states by closed forms that share nothing with the code."""

import dataclasses
import math
from types import SimpleNamespace

import numpy as np
import pytest
from made_results import made_areas
from surfaces import SOFT

from fem_contact import HalfSpace, Solid, Status, adhesion, bem, located_limit, pressure_distribution
from fem_contact.adhesion.descent import Minimum
from fem_contact.adhesion.laws import Exponential
from fem_contact.adhesion.path import _Walk
from fem_contact.adhesion.state import AdhesionProblem, Stability
from fem_contact.settings import Settings
from fem_contact.surface import HeightField


def _width(area, fraction):
    return np.asarray(fraction) / (area * (1 - area) ** 1.25)


def _off(area, fraction):
    z = _width(area, fraction)
    return fraction * (-0.00359 * z + 0.00919 * z**1.5 - 0.00678 * z**2 + 0.00087 * z**3)


def _law(area, fraction, count, solves, *, alignment=0.0, anisotropy=0.0, unresolved=0.0, wavenumber=0.0):
    """Covariance of the error law, written out: random orders, one of each grid, noise of the lattice."""
    fraction, count = np.asarray(fraction), np.asarray(count)
    z = _width(area, fraction)
    # A law of 80 patches; 20 cells over edges times relative spacing squared are one.
    patches = fraction[0] * z[0] * count[0] / solves[0] / 20
    # Ever so many share four fifths of what 80 of them are off by.
    few = max((80 / patches) ** 0.25, 0.8) * (1 + 6.5 * max(anisotropy - 0.12, 0))
    few += 1.5 * (unresolved / 0.05) ** 0.25
    # Edges are no smoother than the heights.
    z = np.maximum(z, 1.5 * wavenumber * fraction / fraction[0])
    spread = np.diag(fraction * (0.006**2 + (0.026 * z) ** 2) / count + (0.0005 * few * fraction * z**2) ** 2)
    for power, deviation in ((1, 0.0003), (1.5, 0.00055), (2, 0.00015), (3, 0.00025)):
        term = deviation * few * fraction * z**power
        spread += np.outer(term, term)
    alike = alignment * fraction * (0.0075 + 0.01 * z)
    spread += np.outer(alike, alike)
    spread += np.diag((alignment * fraction * (0.003 + 0.03 * z)) ** 2 / (patches**0.5 * np.asarray(solves)))
    return np.linalg.inv(spread + 0.00011**2 * np.outer(fraction, fraction))


#: What contours and heights may be like, beyond isotropic ones that the grid resolves.
TRAITS = [{}, {"anisotropy": 0.1}, {"anisotropy": 0.6}, {"unresolved": 0.03}, {"wavenumber": 0.9}]
TRAITS += [{"alignment": 0.7, "anisotropy": 0.9, "unresolved": 0.01, "wavenumber": 0.5}]


#: Points, edge fraction and shifts of each grid, the finest first; its area counts.
LADDERS = [[(64, 0.04, 1)], [(64, 0.04, 1), (32, 0.08, 2)], [(128, 0.03, 2), (96, 0.04, 1), (32, 0.12, 3)]]


@pytest.mark.parametrize("ladder", LADDERS)
@pytest.mark.parametrize("traits", TRAITS)
@pytest.mark.parametrize(("apart", "repeats"), [(1e-6, 1), (0.04, 1), (1e-6, 100)])
def test_the_limit_is_the_best_estimate_under_the_law_of_error_and_its_spread_the_claim(
    apart, repeats, traits, ladder
):
    points, fraction, shifts = (np.array(column) for column in zip(*ladder, strict=True))
    value = np.full(points.size, 0.2) + apart * (points < points[0])
    given = []
    for k, n in enumerate(points):
        told = {"cells": int(n) ** 2 * repeats, "spacing": (2.0**20 / n,) * 2} | (traits if k == 0 else {})
        given += [made_areas(value[k], n, fraction[k], **told)] * shifts[k]
    weight = _law(0.2, fraction, shifts * points**2 * repeats, shifts, **traits)
    known = value - np.array([_off(*pair) for pair in zip(value, fraction, strict=True)])
    best = float(weight.sum(axis=0) @ known / weight.sum())
    rest = known - best
    # A single grid is told its error by the law alone, from which surfaces differ by a tenth.
    misfit = float(rest @ weight @ rest) / (points.size - 1) if points.size > 1 else 1.1**2
    found = located_limit(given)
    assert found.value == pytest.approx(best, rel=1e-10)
    assert found.uncertainty == pytest.approx(math.sqrt(max(misfit, 1.0) / weight.sum()), rel=1e-8)


def test_a_state_is_stable_only_where_its_curvature_exceeds_its_uncertainty():
    assert Stability(curvature=0.3, uncertainty=0.2).is_minimum
    assert not Stability(curvature=0.1, uncertainty=0.2).is_minimum
    assert not Stability(curvature=-0.3, uncertainty=0.2).is_minimum


def test_cells_of_a_process_zone_are_modulus_times_work_over_strength_squared_and_spacing():
    law = Exponential(work=3e-3, reach=0.02)
    exact = 5.0 * 0.02**2 / 3e-3 / 0.1
    assert adhesion.cells_in_process_zone(law, spacing=0.1, contact_modulus=5.0) == pytest.approx(exact)


def _packed(*, gap, force):
    """An adhesive state with planted gap and force on a surface of waves."""
    x = np.arange(16) / 16
    surface = HeightField(heights=0.01 * np.cos(2 * np.pi * x)[:, None] * np.ones(16), lengths=(1.0, 1.0))
    law = Exponential(work=1e-3, reach=0.03)
    problem = AdhesionProblem(surface, SOFT, law=law, settings=Settings(tolerance=1e-8))
    made = {"status": Status.CONVERGED, "iterations": 1, "fft_pairs": 1.0, "energy": 0.0, "imbalance": 0.0}
    minimum = Minimum(gap=gap, force=force, mean_pressure=0.01, offset=0.02, **made)
    return surface, law, problem.packed(minimum).contact


def test_tension_beyond_the_attraction_of_the_law_is_a_residual():
    force = np.zeros((16, 16))
    force[0, 0], force[8, 8] = -0.1, 0.1
    surface, law, contact = _packed(gap=np.zeros((16, 16)), force=force)
    exact = (0.1 - 0.01 - law.strength) / surface.rms_gradient
    assert contact.residuals.tension == pytest.approx(exact, rel=1e-12)


def test_the_gap_of_an_adhesive_state_is_displacement_less_heights_plus_offset():
    surface, _, contact = _packed(gap=np.full((16, 16), 0.004), force=np.zeros((16, 16)))
    gap = contact.displacement - surface.heights + contact.offset
    np.testing.assert_allclose(gap, contact.gap, atol=1e-15)


@pytest.mark.parametrize("axis", [0, 1])
def test_a_wave_along_either_side_of_an_oblong_period_has_the_stiffness_of_its_own_length(axis):
    lengths, n = (3.0, 0.5), 16
    x = np.cos(2 * np.pi * np.arange(n) / n)
    heights = 1e-3 * (x[:, None] * np.ones(n) if axis == 0 else np.ones(n)[:, None] * x)
    body = HalfSpace(solid=Solid(young=2.0, poisson=0.3))
    found = bem.solve(HeightField(heights=heights, lengths=lengths), body, mean_pressure=0.1).checked()
    # Full contact: p = p0 + (E* q / 2) h.
    amplitude = 2.0 / 0.91 * np.pi / lengths[axis] * 1e-3
    np.testing.assert_allclose(found.pressure - 0.1, amplitude / 1e-3 * heights, atol=1e-9)


def test_the_distribution_of_pressure_counts_each_point_by_its_weight():
    x = np.arange(8) / 8
    heights = 1e-2 * np.cos(2 * np.pi * x)[:, None] * np.ones(8)
    body = HalfSpace(solid=Solid(young=1.0, poisson=0.0))
    plain = bem.solve(HeightField(heights=heights, lengths=(1.0, 1.0)), body, mean_pressure=0.01).checked()
    weights = np.tile([1.75, 0.25], (8, 4))
    contact = plain.in_contact.copy()
    contact[:, 1::2] = False
    weighed = dataclasses.replace(plain, weights=weights, in_contact=contact)
    found = pressure_distribution(weighed, [-1.0, 1.0])
    exact = 1.75 * np.count_nonzero(contact) / 64
    assert found.area == pytest.approx(exact, rel=1e-12)
    assert found.density[0] * 2 == pytest.approx(exact, rel=1e-12)


def test_energy_lost_in_a_step_is_the_work_of_the_mean_load_less_what_is_stored():
    def state(load, offset, energy):
        return SimpleNamespace(mean_pressure=load, offset=offset, energy=energy, separated=False)

    # Moved inwards by 0.2 under a load that rises from 1 to 3, storing 0.15: 2 * 0.2 - 0.15.
    lost = _Walk._dissipated(None, state(1.0, 0.5, 0.0), state(3.0, 0.3, 0.15))
    assert lost == pytest.approx(0.25, rel=1e-12)
