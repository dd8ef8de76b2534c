"""Random surfaces and exact interpolation against sums of waves written out by hand."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from refusing import refused

from fem_contact import HeightField, InvalidInput, radial_spectrum, random_surface, resolves
from fem_contact.surface import Patch, estimate_spectrum, random_waves

EPS = np.finfo(float).eps
LENGTHS = (1.0, 1.0)
Q_SHORT = 2 * np.pi * 7.5


def self_affine(q, *, hurst=0.8, q_long=2 * np.pi * 1.5):
    """C(q) with a flat plateau below q_long, in units of the period."""
    return 1e-6 * (np.maximum(q, q_long) / q_long) ** (-2 * (1 + hurst))


def surface_on(shape, *, seed=7, lengths=LENGTHS, q_short=Q_SHORT, **options):
    return random_surface(self_affine, q_short=q_short, lengths=lengths, shape=shape, seed=seed, **options)


def fourier(surface):
    """Wave numbers and coefficients of a resolved surface, by the definition of the transform (no FFT)."""
    numbers, matrices = [], []
    for points in surface.shape:
        m = np.arange(-((points - 1) // 2), (points - 1) // 2 + 1)
        numbers.append(m)
        matrices.append(np.exp(-2j * np.pi * np.outer(m, np.arange(points)) / points) / points)
    return numbers[0], numbers[1], matrices[0] @ surface.heights @ matrices[1].T


def sum_of_waves(surface, x, y):
    """Heights at the outer product of positions x and y, in units of the periods."""
    m, n, coefficients = fourier(surface)
    left, right = np.exp(2j * np.pi * np.outer(x, m)), np.exp(2j * np.pi * np.outer(n, y))
    return (left @ coefficients @ right).real


def lattice(lengths, q_short):
    """|q| of every wave of the period with 0 < |q| <= q_short, whatever the rounding of equal ones."""
    tops = [int(q_short * length / (2 * np.pi)) + 1 for length in lengths]
    m, n = np.meshgrid(*(np.arange(-top, top + 1) for top in tops), indexing="ij")
    q = np.hypot(2 * np.pi * m / lengths[0], 2 * np.pi * n / lengths[1])
    return q[(q > 0) & (q <= q_short * (1 + 1e-9))]


def assert_same_heights(actual, expected, *, tolerance=1e-12):
    scale = np.abs(expected).max()
    assert_allclose(actual, expected, rtol=0, atol=tolerance * scale)


# --- the spectrum of a realisation --------------------------------------------------------------------------


@pytest.mark.parametrize("shape", [(16, 16), (17, 17), (24, 17), (19, 32)])
@pytest.mark.parametrize("lengths", [(1.0, 1.0), (1.0, 0.9)])
def test_exact_amplitudes_carry_the_spectrum_in_every_wave(shape, lengths):
    surface = surface_on(shape, lengths=lengths)
    m, n, coefficients = fourier(surface)
    q = np.hypot(2 * np.pi * m[:, None] / lengths[0], 2 * np.pi * n / lengths[1])
    measured = np.abs(coefficients) ** 2 * lengths[0] * lengths[1] / (2 * np.pi) ** 2
    expected = np.where((q > 0) & (q <= Q_SHORT), self_affine(q), 0.0)
    assert_allclose(measured, expected, rtol=1e-9, atol=1e-9 * expected[expected > 0].min())


def test_measured_radial_spectrum_is_that_of_the_surface():
    flat_spectrum, waves = 3e-7, {"q_short": 2 * np.pi * 12, "lengths": (1.0, 1.0), "seed": 11}
    surface = random_surface(lambda q: np.full_like(q, flat_spectrum), shape=(31, 32), **waves)
    measured = radial_spectrum(surface)
    inside = measured.q < 2 * np.pi * 11.4
    assert_allclose(measured.power[inside], flat_spectrum, rtol=1e-10)
    assert_allclose(measured.power[measured.q > 2 * np.pi * 12.6], 0, atol=1e-10 * flat_spectrum)


def test_rings_are_one_fundamental_wavevector_wide_and_hold_every_wave_once():
    measured = radial_spectrum(HeightField(heights=np.zeros((9, 9)), lengths=(2.0, 2.0)))
    m, n = np.meshgrid(np.arange(-4, 5), np.arange(-4, 5))
    radius = np.hypot(m, n)
    for ring, (q, count) in enumerate(zip(measured.q, measured.count, strict=True), start=1):
        inside = radius[np.abs(radius - ring) < 0.5]
        assert count == inside.size
        assert q == pytest.approx(np.pi * inside.mean(), rel=1e-12)
    assert measured.count.sum() == 80


def test_gaussian_amplitudes_are_exponential_in_power_and_uniform_in_phase():
    samples = []
    for seed in range(100, 140):
        surface = surface_on((16, 16), seed=seed, amplitudes="gaussian")
        m, n, coefficients = fourier(surface)
        q = 2 * np.pi * np.hypot(m[:, None], n)
        half = (q > 0) & (q <= Q_SHORT) & ((n > 0) | ((n == 0) & (m[:, None] > 0)))
        samples.append((coefficients / (2 * np.pi * np.sqrt(self_affine(q))))[half])
    wave = np.concatenate(samples)
    power = np.abs(wave) ** 2
    # five standard errors of the mean, the second moment (variance 20) and the mean phase factor
    assert abs(power.mean() - 1) < 5 / np.sqrt(power.size)
    assert abs((power**2).mean() - 2) < 5 * np.sqrt(20 / power.size)
    assert abs((wave / np.abs(wave)).mean()) < 5 / np.sqrt(power.size)


def test_every_wave_has_a_phase_of_its_own():
    m, n, coefficients = fourier(surface_on((33, 33), q_short=2 * np.pi * 15))
    there = np.abs(coefficients) > 1e-9 * np.abs(coefficients).max()
    half = there & ((n > 0) | ((n == 0) & (m[:, None] > 0)))
    phases = np.sort(np.angle(coefficients[half]))
    assert phases.size == lattice(LENGTHS, 2 * np.pi * 15).size // 2
    assert np.diff(phases).min() > 1e-9


# --- one seed, one surface ----------------------------------------------------------------------------------


@pytest.mark.parametrize("amplitudes", ["exact", "gaussian"])
def test_cutting_the_spectrum_keeps_the_remaining_waves(amplitudes):
    cut = 2 * np.pi * 4.2
    whole, truncated = (surface_on((20, 21), q_short=q, amplitudes=amplitudes) for q in (Q_SHORT, cut))
    m, n, coefficients = fourier(whole)
    kept = np.where(2 * np.pi * np.hypot(m[:, None], n) <= cut, coefficients, 0.0)
    assert_same_heights(fourier(truncated)[2], kept)


@pytest.mark.parametrize(
    ("amplitudes", "corner"),
    [
        ("exact", [[0.016895581013087503, 0.0303082712492482], [0.020587295436910506, 0.01718694255456334]]),
        (
            "gaussian",
            [[0.010828042235588158, 0.018572045483332723], [0.018623937579186473, 0.016850734492670435]],
        ),
    ],
)
def test_the_surface_of_a_seed_is_the_one_of_the_last_release(amplitudes, corner):
    # Recorded, not derived: stored results are shared by seed, so a new drawing order is a change of numbers
    # to announce.
    assert_allclose(surface_on((16, 16), amplitudes=amplitudes).heights[:2, :2], corner, rtol=1e-12)


def test_amplitudes_do_not_change_the_phases():
    exact, gaussian = (fourier(surface_on((16, 16), amplitudes=kind))[2] for kind in ("exact", "gaussian"))
    full = np.abs(exact) > 1e-9 * np.abs(exact).max()
    assert_allclose(np.angle(gaussian[full] / exact[full]), 0, atol=1e-9)


def test_a_generator_is_a_seed_that_moves_on():
    generator = np.random.default_rng(7)
    first, second = (surface_on((16, 16), seed=generator).heights for _ in range(2))
    assert_array_equal(first, surface_on((16, 16), seed=7).heights)
    assert not np.array_equal(first, second)


# --- exact interpolation ------------------------------------------------------------------------------------


@pytest.mark.parametrize("new", [(33, 40), (16, 17), (64, 16), (9, 10), (1, 1), (1, 5)])
@pytest.mark.parametrize("old", [(16, 16), (17, 20), (24, 19)])
def test_resampling_samples_the_sum_of_waves(old, new):
    surface = surface_on(old)
    expected = sum_of_waves(surface, *(np.arange(points) / points for points in new))
    assert_same_heights(surface.resampled(new).heights, expected, tolerance=1e-11)


def test_resampling_there_and_back_loses_nothing_even_at_the_nyquist_limit():
    rng = np.random.default_rng(31)
    for shape in [(8, 8), (7, 9), (8, 5), (1, 6)]:
        surface = HeightField(heights=rng.standard_normal(shape), lengths=(2.0, 3.0))
        back = surface.resampled((3 * shape[0] + 1, 2 * shape[1] + 3)).resampled(shape)
        assert_same_heights(back.heights, surface.heights)
        assert back.lengths == surface.lengths


@pytest.mark.parametrize("fraction", [(0.5, 0.5), (0.25, -0.7), (1 / 3, 0.0), (3, -5)])
@pytest.mark.parametrize("shape", [(16, 16), (17, 20)])
def test_shifts_by_fractions_sample_the_sum_of_waves_elsewhere(shape, fraction):
    surface = surface_on(shape)
    x, y = ((np.arange(points) + part) / points for points, part in zip(shape, fraction, strict=True))
    assert_same_heights(surface.shifted(fraction).heights, sum_of_waves(surface, x, y), tolerance=1e-11)


# --- moments ------------------------------------------------------------------------------------------------


def test_moments_are_the_mean_squares_of_the_derivatives():
    x, y = np.arange(16)[:, None] / 16 * 2.0, np.arange(15)[None, :] / 15 * 3.0
    k, p = 2 * np.pi * 3 / 2.0, 2 * np.pi * 2 / 3.0
    heights = 0.2 * np.cos(k * x + 0.3) * np.sin(p * y) + 0.1 * np.sin(k * x) + 5.0
    surface = HeightField(heights=heights, lengths=(2.0, 3.0))
    slope_x = -0.2 * k * np.sin(k * x + 0.3) * np.sin(p * y) + 0.1 * k * np.cos(k * x)
    slope_y = 0.2 * p * np.cos(k * x + 0.3) * np.cos(p * y)
    laplacian = -0.2 * (k**2 + p**2) * np.cos(k * x + 0.3) * np.sin(p * y) - 0.1 * k**2 * np.sin(k * x)
    expected = [np.var(surface.heights), np.mean(slope_x**2 + slope_y**2), np.mean(laplacian**2)]
    assert_allclose(surface.moments, expected, rtol=1e-12)


# --- grids that do not resolve the spectrum -----------------------------------------------------------------


def test_an_under_resolved_grid_is_refused_with_the_grid_that_would_do():
    with refused(InvalidInput, r"shape = \(15, 16\): does not resolve .* at least \(16, 16\)"):
        surface_on((15, 16))
    with pytest.raises(InvalidInput, match="does not resolve"):
        random_waves(self_affine, q_short=Q_SHORT, lengths=LENGTHS, seed=7).on((15, 16))
    assert resolves((16, 16), LENGTHS, q_short=Q_SHORT)


@pytest.mark.parametrize("waves", [7, 7.5, 8, 11.25])
def test_the_grid_named_as_sufficient_is_the_smallest_that_resolves(waves):
    q_short = 2 * np.pi * waves
    needed = 2 * waves
    for points in range(int(needed) - 2, int(needed) + 3):
        assert resolves((points, 100), LENGTHS, q_short=q_short) == (points > needed)


def test_an_under_resolved_grid_gets_the_true_point_values_when_asked_for():
    coarse = surface_on((6, 5), under_resolved=True)
    assert_same_heights(coarse.heights, surface_on((18, 20)).heights[::3, ::4])


# --- laws ---------------------------------------------------------------------------------------------------

shapes = st.tuples(st.integers(1, 9), st.integers(1, 9))


@st.composite
def height_fields(draw):
    rng = np.random.default_rng(draw(st.integers(2, 2**32)))
    lengths = draw(st.tuples(st.floats(0.1, 10), st.floats(0.1, 10)))
    return HeightField(heights=rng.standard_normal(draw(shapes)), lengths=lengths)


@given(height_fields(), st.floats(-2, 2), st.floats(-5, 5))
def test_moments_are_quadratic_and_blind_to_the_mean_plane(surface, factor, offset):
    other = HeightField(heights=factor * surface.heights + offset, lengths=surface.lengths)
    # the offset enters the rounding error of each height, which the derivatives amplify by at most q^4 of the
    # grid
    q = np.hypot(*(np.pi * n / length for n, length in zip(surface.shape, surface.lengths, strict=True)))
    rounding = 1e3 * EPS * (np.abs(surface.heights).max() + abs(offset)) ** 2
    for order, (a, b) in enumerate(zip(other.moments, surface.moments, strict=True)):
        assert abs(a - factor**2 * b) <= rounding * (1 + factor**2) * q ** (2 * order)


@given(st.integers(2, 2**40), shapes, st.sampled_from(["exact", "gaussian"]), st.sampled_from([1.0, 0.9]))
def test_any_seed_gives_the_same_surface_on_any_grid(seed, extra, amplitudes, width):
    shape = (2 * 7 + 2 + extra[0], 2 * 7 + 2 + extra[1])
    options = {"seed": seed, "amplitudes": amplitudes, "lengths": (width, 1.0)}
    fine = surface_on((32, 27), **options).resampled(shape)
    assert_same_heights(fine.heights, surface_on(shape, **options).heights)


def test_the_shortest_wave_of_an_even_grid_carries_the_power_of_a_cosine():
    # +-1 on the points is a cosine between them, whose mean square is one half, whichever way it is measured.
    heights = np.cos(np.pi * np.arange(8))[:, None] * np.ones(9)
    surface = HeightField(heights=heights, lengths=(1.0, 1.0))
    rings = radial_spectrum(surface)
    cell = (2 * np.pi) ** 2
    assert_allclose(np.sum(rings.power * rings.count) * cell, 0.5, rtol=1e-12)
    assert_allclose(surface.moments[1], 0.5 * (8 * np.pi) ** 2, rtol=1e-12)


def test_rings_at_a_cut_off_are_means_over_the_waves_that_a_surface_is_made_of():
    def spectrum(q):
        return np.where(q > 0.999 * q_long, np.maximum(q, 1.0) ** -3.6, 0.0)

    q_long, q_short = 2 * np.pi * 4, 2 * np.pi * 8
    surface = random_surface(spectrum, q_short=q_short, lengths=(1.0, 1.0), shape=(20, 20), seed=3)
    whole, inside = radial_spectrum(surface), radial_spectrum(surface, band=(q_long, q_short))
    # A mean over a ring is a little more than what the spectrum is at its mean |q|.
    assert_allclose(inside.power, inside.q**-3.6, rtol=0.03)
    np.testing.assert_array_equal(np.rint(inside.q / (2 * np.pi)), [4, 5, 6, 7, 8])
    assert whole.power[7] < 0.7 * whole.q[7] ** -3.6
    with pytest.raises(InvalidInput, match="band = 3: must be a pair of wavevectors"):
        radial_spectrum(surface, band=3)


def test_rings_of_an_oblong_period_hold_all_waves():
    surface = random_surface(lambda q: q**-3.0, q_short=20.0, lengths=(4.0, 1.0), shape=(64, 16), seed=5)
    rings = radial_spectrum(surface)
    cell = (2 * np.pi) ** 2 / np.prod(surface.lengths)
    assert np.sum(rings.power * rings.count) * cell == pytest.approx(surface.moments[0], rel=1e-9)
    assert rings.q.min() < np.pi  # half of the wavevector of the shorter side


def test_the_rings_of_a_tilted_patch_are_those_under_its_window():
    rough = random_surface(lambda q: q**-3.6, q_short=150.0, lengths=(1.0, 1.0), shape=(64, 64), seed=5)
    tilted = rough.heights + 10 * np.arange(64)[:, None] / 64 * rough.rms_height
    rings = radial_spectrum(Patch(heights=tilted, lengths=(1.0, 1.0)))
    estimate = estimate_spectrum(tilted, (1.0, 1.0))
    same = np.isin(rings.q, estimate.q)
    assert_allclose(rings.power[same], estimate.power, rtol=1e-9)
    assert same.sum() == estimate.q.size
