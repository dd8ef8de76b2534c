"""The bounded solver: its answers against the plain solver, its bounds; its passes are in test_arrays.py."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from surfaces import SOFT

from fem_contact import Status
from fem_contact.complementarity import polonsky_keer, solve_bounded, solve_nested
from fem_contact.complementarity.fourier import FourierOperator
from fem_contact.complementarity.grids import Grids
from fem_contact.complementarity.iteration_arrays import IterationArrays
from fem_contact.complementarity.rows import Rows
from fem_contact.settings import Settings


def test_number_of_threads_changes_no_bit_of_the_passes():
    heights = wavy((1024, 20))
    operator = FourierOperator(SOFT, heights.shape, (1.0, 20 / 1024), threads=1)
    for k in (1, 2, 3):
        assert len(IterationArrays(operator, heights, bound=None, caution=1, threads=k).rows.shares) == k
    answers = [run(heights, load=0.05, threads=threads) for threads in (1, 2, 3)]
    for other in answers[1:]:
        assert np.array_equal(answers[0].force, other.force)
        assert answers[0].offset == other.offset


def test_blocks_of_rows_cover_each_row_once():
    for count in (1, 31, 32, 65, 1000):
        rows = [row for lo, hi in Rows(count, threads=1).blocks for row in range(lo, hi)]
        assert rows == list(range(count))


def wavy(shape, seed=5):
    generator = np.random.default_rng(seed)
    spectrum = np.fft.fft2(generator.standard_normal(shape))
    q = np.hypot(*np.meshgrid(*(np.fft.fftfreq(n) * n for n in shape), indexing="ij"))
    heights = np.fft.ifft2(spectrum / np.maximum(q, 2) ** 1.8 * (q < min(shape) / 4)).real
    return np.ascontiguousarray(heights / heights.std())


def run(heights, *, load, bound=None, threads=1, tolerance=1e-10):
    lengths = (1.0, heights.shape[1] / heights.shape[0])
    operator = FourierOperator(SOFT, heights.shape, lengths, threads=threads)
    settings = Settings(tolerance=tolerance, max_iterations=500, threads=threads)
    asked = {"mean_force": load, "length_scale": float(heights.std()), "bound": bound}
    return solve_bounded(operator, heights, settings=settings, **asked)


def run_nested(heights, *, tolerance=1e-10, **options):
    lengths = (1.0, heights.shape[1] / heights.shape[0])
    return solve_nested(
        FourierOperator(SOFT, heights.shape, lengths, threads=1),
        heights,
        coarse=lambda shape: FourierOperator(SOFT, shape, lengths, threads=1),
        mean_force=0.3,
        length_scale=float(heights.std()),
        settings=Settings(tolerance=tolerance, max_iterations=500, threads=1),
        **options,
    )


@pytest.mark.parametrize("load", [1e-3, 0.3, 3.0, 12.0])
def test_preconditioned_and_plain_solver_agree(load):
    heights = wavy((48, 45))
    fast = run(heights, load=load, tolerance=1e-11)
    operator = FourierOperator(SOFT, heights.shape, (1.0, 45 / 48), threads=1)
    asked = {"mean_force": load, "length_scale": float(heights.std())}
    slow = polonsky_keer(operator, heights, settings=Settings(tolerance=1e-11, max_iterations=5000), **asked)
    assert fast.status is slow.status is Status.CONVERGED
    assert np.linalg.norm(fast.force - slow.force) < 1e-8 * np.linalg.norm(slow.force)
    assert fast.offset == pytest.approx(slow.offset, abs=1e-9)
    assert np.array_equal(fast.in_contact, slow.in_contact)


def test_coarse_start_changes_the_cost_and_not_the_answer():
    heights = wavy((128, 96))
    nested = run_nested(heights)
    cold = run(heights, load=0.3)
    assert np.linalg.norm(nested.force - cold.force) < 1e-7 * np.linalg.norm(cold.force)
    assert nested.fft_pairs != int(nested.fft_pairs)
    # No coarser grid takes part beside a start: its pairs would be a share of those of the finest.
    handed = run_nested(heights, start=cold.force.copy())
    assert handed.iterations < nested.iterations
    assert handed.fft_pairs == int(handed.fft_pairs)


def test_plain_solver_takes_the_shape_of_its_start_and_not_its_load():
    heights = wavy((32, 30))

    def plain(start):
        return polonsky_keer(
            FourierOperator(SOFT, heights.shape, (1.0, 30 / 32), threads=1),
            heights,
            mean_force=0.3,
            length_scale=float(heights.std()),
            settings=Settings(tolerance=1e-9, max_iterations=5000),
            start=start,
        )

    cold = plain(None)
    for factor in (0.25, 1.0, 8.0):
        assert plain(factor * cold.force).iterations < 0.2 * cold.iterations


def test_weights_turn_the_interpolated_pressure_into_forces():
    """With node weights the start is w p; where it starts changes no answer."""
    heights = wavy((40, 40))
    weights = np.where(np.add.outer(np.arange(40), np.arange(40)) % 2, 0.5, 1.5)
    plain, nested = run(heights, load=0.3), run_nested(heights, weights=weights)
    assert_allclose(nested.force, plain.force, atol=1e-7 * plain.force.max())


def test_residual_that_cannot_be_reached_is_called_stagnation():
    solution = run(wavy((32, 32)), load=0.3, tolerance=1e-22)
    assert solution.status is Status.STAGNATED


@pytest.mark.parametrize("single", [False, True])
@pytest.mark.parametrize("steps", [1, 3, 10, 500])
def test_displacements_are_those_of_the_forces_wherever_a_solve_ends(single, steps):
    heights = wavy((64, 48))
    operator, found = FourierOperator(SOFT, heights.shape, (1.0, 0.75), threads=1), np.empty(heights.shape)
    settings = Settings(tolerance=1e-12, max_iterations=steps)
    solution = solve_bounded(
        operator, heights, mean_force=0.3, length_scale=1.0, settings=settings, single=single
    )
    assert (solution.status is Status.CONVERGED) == (steps == 500)
    operator.apply(solution.force, found)
    assert_allclose(solution.displacement, found, atol=1e-12 * np.abs(found).max())


def test_where_all_that_bear_yield_the_body_sinks_no_deeper_than_the_last_of_them_asks():
    for seed in range(40):
        generator = np.random.default_rng(seed)
        heights = 1e-3 * generator.normal(size=(24, 24))
        count = int(generator.integers(1, 9))
        high = generator.choice(heights.size, count, replace=False)
        heights.flat[high] += 5.0 + 0.1 * generator.normal(size=count)
        load = 1.7 * count / heights.size
        found = run(heights, load=load, bound=np.full(heights.shape, 1.7))
        assert np.array_equal(np.flatnonzero(found.at_bound), np.sort(high))
        gap = found.displacement - heights + found.offset
        assert abs(gap.flat[high].max()) < 1e-9, seed


def test_coarsening_keeps_low_waves_and_refinement_keeps_values():
    fine, half, x = (24, 20), (12, 10), np.arange(24) / 24
    grids = Grids(fine, threads=1)
    wave, short = (np.cos(2 * np.pi * n * x)[:, None] * np.ones(20) for n in (3, 9))
    coarse = grids.coarsened(wave, fine, half)
    assert_allclose(coarse, wave[::2, ::2], atol=1e-14)
    assert_allclose(grids.coarsened(short, fine, half), 0, atol=1e-14)
    assert np.array_equal(grids.refined(coarse, half, fine)[::2, ::2], coarse)


@pytest.mark.parametrize("bounded", [False, True])
def test_steps_in_single_precision_change_the_path_and_not_the_answer(bounded):
    heights = wavy((264, 257)) + 20.0
    options = {"tolerance": 1e-11, "bound": np.full(heights.shape, 4.0) if bounded else None}
    double, single = run_nested(heights, double=True, **options), run_nested(heights, **options)
    assert single.status is Status.CONVERGED
    assert np.array_equal(single.in_contact, double.in_contact)
    # Twice 11 tolerance h_rms load bounds the energy of the difference; stiffness turns it into force.
    assert np.linalg.norm(single.force - double.force) < 1e-7 * np.linalg.norm(double.force)
    assert single.iterations <= double.iterations + 8
    assert single.force.dtype == single.displacement.dtype == np.float64


@pytest.mark.parametrize("shape", [(64, 64), (70, 33), (200, 128)])
def test_the_response_in_single_precision_is_the_double_one_to_its_digits(shape):
    operator = FourierOperator(SOFT, shape, (1.0, shape[1] / shape[0]), threads=1)
    field = np.random.default_rng(37).standard_normal(shape)
    field -= field.mean()
    single = operator.single(0.25)
    ways = (operator.apply, single.apply, 0.25), (operator.precondition, single.precondition, 4.0)
    for double_way, single_way, factor in ways:
        expected, found = np.empty(shape), np.empty(shape, dtype=np.float32)
        single_way(field.astype(np.float32), found)
        double_way(field, expected)
        assert np.linalg.norm(found - factor * expected) < 1e-6 * np.linalg.norm(factor * expected)
