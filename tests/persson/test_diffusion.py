"""The diffusion solver against closed forms, a second method, its ledger, and its hard cases."""

import math
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.special import erf

from persson import _galerkin, sine_expansion, solve_diffusion
from persson.errors import NotConverged, OutsideTheory


def moving(v):
    return np.sqrt(np.sqrt(1 + v)) / 2


def test_elastic_contact_over_24_decades_of_variance_keeps_six_digits():
    variance = np.geomspace(1e-4, 1e20, 60)
    result = solve_diffusion(variance, pressure=1.0, tolerance=1e-6).checked()
    exact = erf(1 / np.sqrt(2 * variance))
    assert np.max(np.abs(result.area_elastic / exact - 1)) < 1e-6
    assert np.max(np.abs(result.load_elastic - 1)) < 1e-6


def test_error_falls_with_the_fourth_power_of_the_step_and_the_ledger_bounds_it():
    variance = np.array([0.3, 1.0, 10.0])
    exact = erf(1 / np.sqrt(2 * variance))
    errors = []
    for step in (0.4, 0.2, 0.1):
        result = solve_diffusion(variance, pressure=1.0, modes=64, step=step)
        errors.append(np.max(np.abs(result.area_elastic / exact - 1)))
        assert errors[-1] < result.error_estimate
    assert math.log2(errors[0] / errors[2]) / 2 > 3.6


def test_before_a_wall_is_felt_the_distribution_is_the_free_gaussian():
    result = solve_diffusion([0.0, 1e-6], pressure=1.0)
    assert result.area_elastic == pytest.approx([1.0, 1.0], abs=0)
    area, _ = quad(lambda s: float(result.distribution(1, s)), 0.99, 1.01, epsabs=1e-12)
    assert area == pytest.approx(1, abs=1e-10)


def test_moving_tensile_wall_gives_the_reference_areas():
    """V = zeta^2 - 1, sigma_0 = 1, sigma_a = sqrt(zeta)/2, sigma_Y = 20."""
    walls = {"tensile_limit": moving, "yield_stress": 20.0}
    result = solve_diffusion([3.0, 99.0], pressure=1.0, **walls, tolerance=1e-7).checked()
    assert result.area_elastic == pytest.approx([0.657789, 0.119701], abs=6e-7)


def test_hardness_that_rises_gives_the_reference_areas():
    """Persson 2006, Eq. 34, with sigma_0 = .02, sigma_Y = (1 + V/.05)^.1 at V = 50."""
    result = solve_diffusion([50.0], pressure=0.02, yield_stress=lambda v: (1 + v / 0.05) ** 0.1).checked()
    assert result.area_plastic[0] == pytest.approx(9.969e-3, abs=6e-7)
    assert result.area_elastic[0] == pytest.approx(8.05e-5, abs=6e-8)
    carried = result.load_elastic[0] + result.area_plastic[0] * result.yield_stress[0]
    assert carried == pytest.approx(0.02, rel=1e-6)


@pytest.mark.slow
def test_sine_expansion_and_galerkin_agree_between_moving_walls():
    """Two methods on one problem.

    The sine coefficients fall like n^-3 under a moving wall, so the error like n^-2 ... n^-3.
    """
    told = {"pressure": 1.0, "yield_stress": 20.0}
    reference = solve_diffusion([3.0], tensile_limit=moving, **told, tolerance=1e-8).checked()
    errors = []
    for modes in (60, 120):
        sine = sine_expansion(3.0, tensile_limit=lambda v: float(moving(v)), **told, modes=modes)
        errors.append(abs(sine.area_elastic - reference.area_elastic[0]))
    assert errors[0] < 1e-3
    assert errors[1] < errors[0] / 2


def test_sine_expansion_obeys_equation_34_where_the_hardness_rises():
    """P(sigma_Y) = 2 A_pl dsigma_Y/dV, not 0: what is left of the flux at the wall falls like 1/modes."""
    walls = {"tensile_limit": 0.3, "yield_stress": lambda v: 1 + 0.2 * v}
    found = solve_diffusion([1.0], pressure=0.5, tolerance=1e-7, **walls).checked()
    reference = np.array([found.area_elastic[0], found.area_plastic[0]])
    coarse, fine = (sine_expansion(1.0, pressure=0.5, modes=n, tolerance=1e-8, **walls) for n in (32, 64))
    areas = np.array([[s.area_elastic, s.area_plastic] for s in (coarse, fine)])
    errors = areas - reference
    assert errors[0] / errors[1] == pytest.approx(2.0, abs=0.15)
    assert 2 * areas[1] - areas[0] == pytest.approx(reference, abs=3e-5)
    assert fine.density_at_yield == pytest.approx(2 * 0.2 * fine.area_plastic, rel=1e-6)
    stress = 1.2 * (1 - 1e-9)
    assert fine.distribution(np.array([stress]))[0] == pytest.approx(found.distribution(0, stress), rel=4e-3)


@pytest.mark.parametrize(
    ("variance", "pressure", "walls"),
    [
        (1.0, 0.5, (0.3, lambda v: 1 + 0.2 * v)),
        (0.5, 0.4, (0.0, lambda v: 1 + 0.01 * v)),
        (5.0, 0.3, (lambda v: 0.2 + 0.1 * v, lambda v: 1.5 * (1 + v) ** 0.25)),
        (1e-3, 0.6, (0.5, 2.0)),
    ],
)
def test_the_error_estimate_of_the_sine_expansion_bounds_both_areas(variance, pressure, walls):
    walls = dict(zip(("tensile_limit", "yield_stress"), walls, strict=True))
    exact = solve_diffusion([variance], pressure=pressure, tolerance=1e-7, **walls).checked()
    for modes in (16, 24):
        sine = sine_expansion(variance, pressure=pressure, modes=modes, tolerance=1e-5, **walls)
        errors = [getattr(sine, name) - getattr(exact, name)[0] for name in ("area_elastic", "area_plastic")]
        assert np.max(np.abs(errors)) < sine.error_estimate < 0.2


def test_the_error_estimate_of_too_few_sines_is_no_smaller_than_the_error():
    walls = {"tensile_limit": 0.0, "yield_stress": lambda v: 4.8 + 0.24 * v}
    exact = solve_diffusion([0.038], pressure=0.27, tolerance=1e-7, **walls).checked()
    for modes in (2, 4, 8):
        sine = sine_expansion(0.038, pressure=0.27, modes=modes, tolerance=1e-5, **walls)
        assert abs(sine.area_elastic - exact.area_elastic[0]) < sine.error_estimate


@pytest.mark.parametrize("unit", [1e-9, 1e9])
def test_a_hardness_that_falls_by_rounding_alone_is_one_that_stands(unit):
    """In any unit, of which the tolerance has none; a fall of a millionth is one."""
    case = {"pressure": 0.5 * unit, "tensile_limit": 0.3 * unit}

    def hardness(fall):
        return lambda v: 2 * unit * (1 - fall * np.asarray(v) / unit**2)

    for solve, variance in ((solve_diffusion, [unit**2]), (partial(sine_expansion, modes=8), unit**2)):
        solve(variance, yield_stress=hardness(1e-14), **case)
        with pytest.raises(OutsideTheory, match="falls"):
            solve(variance, yield_stress=hardness(1e-6), **case)


@pytest.mark.parametrize(
    ("pressure", "wall"),
    [(0.0, {}), (-1.0, {}), (-2.0, {"tensile_limit": 1.0}), (5.0, {"yield_stress": 1.0})],
)
def test_what_nothing_holds_has_no_area_without_roughness_either(pressure, wall):
    for variances in ([0.0], [0.0, 1e-6]):
        with pytest.raises(OutsideTheory):
            solve_diffusion(variances, pressure=pressure, **wall)
    assert solve_diffusion([0.0], pressure=0.5, yield_stress=1.0).checked().area == [1.0]


def test_sine_expansion_is_exact_between_walls_that_stand():
    stress = np.linspace(-0.5, 2.0, 30)
    told = {"pressure": 0.6, "tensile_limit": 0.5, "yield_stress": 2.0}
    sine = sine_expansion(0.8, **told, modes=60)
    result = solve_diffusion([0.8], **told, tolerance=1e-9).checked()
    assert result.area_elastic[0] == pytest.approx(sine.area_elastic, rel=1e-8)
    assert result.area_plastic[0] == pytest.approx(sine.area_plastic, rel=1e-8)
    assert result.distribution(0, stress) == pytest.approx(sine.distribution(stress), abs=1e-8)


@pytest.mark.parametrize("ratio", [1e-9, 1 - 1e-9])
def test_load_close_to_either_wall(ratio):
    result = solve_diffusion([0.01, 1.0, 30.0], pressure=ratio, yield_stress=1.0).checked()
    assert result.area_plastic[-1] == pytest.approx(ratio, rel=1e-6)
    far = min(ratio, 1 - ratio)
    waves = np.pi * np.arange(1, 12, 2)
    eigen = np.sum(4 / waves * np.sin(waves * far) * np.exp(-0.5 * waves**2))
    assert result.area_elastic[1] == pytest.approx(eigen, rel=1e-6)


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("width", [0.5, 0.05])
def test_tensile_limit_jumping_by_a_million_is_followed_or_refused(sign, width):
    """Within `width` of ln V. The ledger must close, or `.checked()` must say that it does not."""

    def jump(v):
        return 0.5 * (1 + 0.5e6 * (1 + np.tanh(sign * (np.log(v) - 10) / width)))

    result = solve_diffusion([1e8, 1e14], pressure=1.0, tensile_limit=jump, tolerance=1e-5).checked()
    finer = solve_diffusion([1e8, 1e14], pressure=1.0, tensile_limit=jump, tolerance=1e-6)
    assert result.area_elastic == pytest.approx(finer.area_elastic, rel=1e-3)
    assert np.all(result.area_elastic > 0)


def test_square_root_onset_is_the_same_with_and_without_being_named():
    def onset(v):
        return 2 * np.sqrt(np.maximum(np.log(np.maximum(v, 1e-300) / 3.0), 0))

    named = solve_diffusion([1e4], pressure=1.0, tensile_limit=onset, breaks=[3.0], tolerance=1e-6).checked()
    fine = solve_diffusion([1e4], pressure=1.0, tensile_limit=onset, breaks=[3.0], modes=120, step=0.02)
    silent = solve_diffusion([1e4], pressure=1.0, tensile_limit=onset, tolerance=1e-4).checked()
    assert named.area_elastic[0] == pytest.approx(fine.area_elastic[0], rel=1e-6)
    assert silent.area_elastic[0] == pytest.approx(fine.area_elastic[0], rel=1e-4)


def test_a_wall_too_wild_to_follow_ends_in_a_refusal_not_in_a_number():
    wild = {"tensile_limit": lambda v: 1e3 * (1 + np.sin(3e5 * np.log(v)))}
    result = solve_diffusion([1e8], pressure=1.0, **wild, modes=44, step=0.3)
    with pytest.raises(NotConverged, match="ledger"):
        result.checked()


@given(st.floats(0.05, 3), st.floats(0, 5), st.floats(3.1, 30), st.floats(0, 0.6))
@settings(max_examples=25)
def test_ledger_closes_and_areas_are_shares_whatever_the_walls(pressure, limit, hardness, growth):
    walls = {"tensile_limit": lambda v: limit * (1 + v) ** growth}
    walls["yield_stress"] = lambda v: hardness * (1 + v) ** (growth / 4)
    variance = np.geomspace(0.1, 1e5, 12)
    result = solve_diffusion(variance, pressure=pressure, tolerance=1e-5, **walls).checked()
    for part in (result.area_elastic, result.area_plastic, result.area_detached):
        assert np.all(part > -1e-5)
        assert np.all(part < 1 + 1e-5)
    assert np.all(np.diff(result.area_detached) > -1e-5)


def test_kernel_matrices_are_the_integrals_of_the_basis():
    modes = 9
    mass, shift, stretch, d = _galerkin.matrices(modes)
    x, w = np.polynomial.legendre.leggauss(24)
    unit = np.eye(modes + 2)
    series = d[:, None] * (unit[:modes] - unit[2:])
    phi = np.array([np.polynomial.legendre.legval(x, row) for row in series])
    slope = np.array([np.polynomial.legendre.legval(x, np.polynomial.legendre.legder(row)) for row in series])
    products = (phi * w @ phi.T, phi * w @ slope.T, phi * w * x @ slope.T)
    for rows, exact in zip((mass, shift, stretch), products, strict=True):
        full = sum(np.diag(rows[o, max(0, 2 - o) : modes - max(0, o - 2)], o - 2) for o in range(5))
        assert full == pytest.approx(exact, abs=1e-14)
    assert slope * w @ slope.T == pytest.approx(np.eye(modes), abs=1e-12)


def test_compiled_linear_solver_equals_numpy():
    rng = np.random.default_rng(7)
    rows = rng.normal(size=(5, 12))
    rows[2] += 9
    full = sum(np.diag(rows[o, max(0, 2 - o) : 12 - max(0, o - 2)], o - 2) for o in range(5))
    right = rng.normal(size=12)
    x, factors = right.copy(), rows.copy()
    _galerkin._factor(factors)
    _galerkin._solve(factors, x)
    assert x == pytest.approx(np.linalg.solve(full, right), rel=1e-12)
