"""The bounded solver: its passes against NumPy, its answers against the plain solver, its bounds."""

import numpy as np
import pytest

from fem_contact.complementarity import polonsky_keer, solve_bounded, solve_nested
from fem_contact.complementarity.fourier import FourierOperator, coarsened, refined
from fem_contact.complementarity.iteration_arrays import IterationArrays
from fem_contact.complementarity.rows import Rows
from fem_contact.contact import Status
from fem_contact.response import HalfSpace
from fem_contact.settings import Settings
from fem_contact.solid import Solid

SOFT = HalfSpace(solid=Solid(young=1.0, poisson=0.0))
Array = np.ndarray


class Recorder:
    """An operator that keeps what it is given and returns fixed noise."""

    pairs, stiffness = 1.0, 3.0

    def __init__(self, answer: Array) -> None:
        self.answer = answer

    def apply(self, force: Array, out: Array) -> None:
        out[...] = self.answer

    def precondition(self, residual: Array, out: Array) -> None:
        self.given = residual.copy()
        out[...] = self.answer


def interpolation(fine: int) -> Array:
    """Matrix of the linear interpolation from the next coarser level along one axis."""
    coarse = -(-fine // 2)
    matrix = np.zeros((fine, coarse))
    for i in range(fine):
        matrix[i, i // 2] += 0.75
        matrix[i, (i // 2 + (1 if i % 2 else -1)) % coarse] += 0.25
    return matrix


def summation(fine: int) -> Array:
    coarse = -(-fine // 2)
    matrix = np.zeros((coarse, fine))
    matrix[np.arange(fine) // 2, np.arange(fine)] = 1
    return matrix


#: Share of each of 0 to 4 occupied cells in the value of the next level.
SHARES = (0, 0.5, 0.46, 1 / 3, 1 / 4)


def extension(occupied: Array, levels: int) -> Array:
    """The extension as a dense matrix: average up the levels, interpolate down where a level is empty."""
    nx, ny = occupied.shape
    value = np.diag(occupied.ravel().astype(float))
    values, masks = [value], [occupied.ravel()]
    shapes = [(nx, ny)]
    for _ in range(levels):
        gather = np.kron(summation(nx), summation(ny))
        count = gather @ masks[-1]
        total = gather @ (masks[-1][:, None] * values[-1])
        values.append(np.take(SHARES, count.astype(int))[:, None] * total)
        masks.append(count > 0)
        nx, ny = -(-nx // 2), -(-ny // 2)
        shapes.append((nx, ny))
    for level in range(levels - 1, -1, -1):
        spread = np.kron(interpolation(shapes[level][0]), interpolation(shapes[level][1]))
        filled = spread @ values[level + 1]
        values[level] = np.where(masks[level][:, None], values[level], filled)
    return values[0]


@pytest.mark.parametrize("shape", [(16, 16), (13, 10), (9, 16), (1, 12), (5, 2)])
def test_extension_and_its_transpose_are_the_matrix_they_should_be(shape: tuple[int, int]) -> None:
    generator = np.random.default_rng(17)
    operator = Recorder(generator.standard_normal(shape))
    arrays = IterationArrays(
        operator, generator.standard_normal(shape), bound=None, caution=0.1 / 3, threads=1
    )
    arrays.force[:] = generator.random(shape) < 0.3
    arrays.start()
    arrays.place(0.2)
    working = arrays.working.copy()
    gap = operator.answer - arrays.heights + 0.2
    np.testing.assert_allclose(arrays.gap, gap, atol=1e-15)
    assert np.array_equal(working, arrays.force - 0.1 * gap > 0)
    arrays.precondition()
    matrix = extension(working, len(arrays.sums))
    residual = np.where(working, -gap, 0)
    np.testing.assert_allclose(operator.given.ravel(), matrix @ residual.ravel(), atol=1e-13)
    np.testing.assert_allclose(
        np.where(working, arrays.buffer, 0).ravel(), matrix.T @ operator.answer.ravel(), atol=1e-13
    )


@pytest.mark.parametrize("bounded", [False, True])
@pytest.mark.parametrize("single", [False, True])
def test_passes_of_one_step_agree_with_numpy(bounded: bool, single: bool) -> None:
    generator = np.random.default_rng(23)
    shape, force_unit, length_unit = (70, 33), 3.0, 0.25
    heights = generator.standard_normal(shape)
    bound = 1 + generator.random(shape) if bounded else None
    operator = FourierOperator(SOFT, shape, (1.0, 33 / 70), threads=1)
    units, digits = ((force_unit, length_unit), 2e-6) if single else (None, 1e-13)
    arrays = IterationArrays(
        operator, heights, bound=bound, caution=0.1 / operator.stiffness, units=units, threads=2
    )
    f, length = arrays.force_unit, arrays.length_unit
    near = {"rel": 10 * digits, "abs": 10 * digits}
    x, s, v = arrays.force, arrays.step, arrays.image
    x[:] = np.maximum(generator.standard_normal(shape), 0)
    if bound is not None:
        np.minimum(x, bound, out=x)
    s[:] = generator.standard_normal(shape)
    assert arrays.bend() == pytest.approx(np.sum(s * v), **near)
    np.testing.assert_allclose(v * length, applied(operator, s * f), atol=10 * digits)
    phi = x if bound is None else x * (1 - x / bound)
    below = np.ones(shape, dtype=bool) if bound is None else x < bound
    u = applied(operator, x)
    roughly = arrays.start(roughly=True)
    s[:], v[:] = generator.standard_normal(shape), generator.standard_normal(shape)
    total, moment = arrays.start()
    assert total * f == pytest.approx(phi.sum())
    assert moment * f * length == pytest.approx(np.sum(phi * (u - heights)))
    assert roughly == pytest.approx((total, moment), **near)
    errors = arrays.place(-moment / total)
    gap = u - heights - moment / total * length
    np.testing.assert_allclose(arrays.gap * length, gap, atol=digits)
    errors = arrays.move(0.3, 0.1)
    gap = gap + 0.3 * v * length + 0.1 * length
    np.testing.assert_allclose(arrays.gap * length, gap, atol=digits)
    assert errors.moment * f * length == pytest.approx(np.sum((x * np.abs(gap))[below]), **near)
    assert errors.total * f == pytest.approx(x[below].sum(), **near)
    assert errors.lowest * length == pytest.approx(gap[below].min(), **near)
    assert errors.highest * length == (pytest.approx(gap[~below].max(), **near) if bounded else -np.inf)
    aim = x - 0.1 * gap
    working = aim > 0 if bound is None else np.where(x < bound / 2, aim > 0, aim < bound)
    assert np.array_equal(arrays.working, working)
    assert errors.free * f == pytest.approx(phi[working].sum(), **near)
    assert errors.last == pytest.approx(s[working].sum(), **near)
    assert errors.image * f == pytest.approx((phi * v)[working].sum(), **near)
    z = np.where(working, generator.standard_normal(shape), 0)
    arrays.buffer[:] = z
    before, last = x.copy(), s * 1.0
    load = 0.5 * x.size
    arrays.trial(load / f, length=0.7, beta=0.4, shift=0.2)
    trial = np.maximum(before + 0.7 * (z * f + 0.4 * last * f * working - 0.2 * phi), 0)
    stay = np.zeros(shape) if bound is None else np.where(before < bound / 2, 0, bound)
    trial = np.where(working, trial if bound is None else np.minimum(trial, bound), stay)
    if bound is None:
        trial *= load / trial.sum()
    else:
        missing, free = load - trial.sum(), (trial > 0) & (trial < bound)
        share = missing / np.sum((bound - trial)[free]) if missing > 0 else missing / trial[free].sum()
        trial[free] += share * ((bound - trial)[free] if missing > 0 else trial[free])
    np.testing.assert_allclose(s * f, trial - before, atol=10 * digits)
    assert arrays.slope * f * length == pytest.approx(np.sum(gap * (trial - before)), **near)
    with np.errstate(divide="ignore", invalid="ignore"):
        rooms = np.where(s < 0, before / -(s * f), np.inf)
        if bound is not None:
            rooms = np.minimum(rooms, np.where(s > 0, (bound - before) / (s * f), np.inf))
    assert arrays.room() == pytest.approx(max(1.0, rooms.min()), **near)
    for factor in (0.8, 1.0):
        x[:] = before
        total, moment = arrays.advance(factor)
        np.testing.assert_allclose(x, before + factor * (trial - before), atol=10 * digits)
        # A whole step ends at its bounds, not beside them.
        assert factor < 1 or np.array_equal(x == 0, trial == 0)
        assert factor < 1 or bound is None or np.array_equal(x == bound, trial == bound)
        phi = x if bound is None else x * (1 - x / bound)
        assert total * f == pytest.approx(phi.sum(), **near)
        moved = gap + factor * v * length
        assert moment * f * length == pytest.approx(np.sum(phi * moved), rel=10 * digits, abs=1e4 * digits)


def applied(operator: FourierOperator, force: Array) -> Array:
    """Displacement under a force."""
    out = np.empty(force.shape)
    operator.apply(np.ascontiguousarray(force, dtype=float), out)
    return out


def test_number_of_threads_changes_no_bit_of_the_passes() -> None:
    heights = wavy((1024, 20))
    still = Recorder(heights)
    counts = [
        len(IterationArrays(still, heights, bound=None, caution=1.0, threads=k).rows.shares)
        for k in (1, 2, 3)
    ]
    assert counts == [1, 2, 3]
    answers = [run(heights, load=0.05, threads=threads) for threads in (1, 2, 3)]
    for other in answers[1:]:
        assert np.array_equal(answers[0].force, other.force)
        assert answers[0].offset == other.offset


def test_blocks_of_rows_cover_each_row_once() -> None:
    for count in (1, 31, 32, 65, 1000):
        rows = [row for lo, hi in Rows(count, threads=1).blocks for row in range(lo, hi)]
        assert rows == list(range(count))


def wavy(shape: tuple[int, int], seed: int = 5) -> Array:
    generator = np.random.default_rng(seed)
    spectrum = np.fft.fft2(generator.standard_normal(shape))
    q = np.hypot(*np.meshgrid(*(np.fft.fftfreq(n) * n for n in shape), indexing="ij"))
    heights = np.fft.ifft2(spectrum / np.maximum(q, 2) ** 1.8 * (q < min(shape) / 4)).real
    return np.ascontiguousarray(heights / heights.std())


def run(
    heights: Array, *, load: float, bound: Array | None = None, threads: int = 1, tolerance: float = 1e-10
):
    operator = FourierOperator(
        SOFT, heights.shape, (1.0, heights.shape[1] / heights.shape[0]), threads=threads
    )
    return solve_bounded(
        operator,
        heights,
        mean_force=load,
        length_scale=float(heights.std()),
        settings=Settings(tolerance=tolerance, max_iterations=500, threads=threads),
        bound=bound,
    )


def run_nested(heights: Array, *, tolerance: float = 1e-10, **options: object):
    """Solve from a coarse start under a load of 0.3."""
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
def test_preconditioned_and_plain_solver_agree(load: float) -> None:
    heights = wavy((48, 45))
    fast = run(heights, load=load, tolerance=1e-11)
    operator = FourierOperator(SOFT, heights.shape, (1.0, 45 / 48), threads=1)
    slow = polonsky_keer(
        operator,
        heights,
        mean_force=load,
        length_scale=float(heights.std()),
        settings=Settings(tolerance=1e-11, max_iterations=5000),
    )
    assert fast.status is slow.status is Status.CONVERGED
    assert np.linalg.norm(fast.force - slow.force) < 1e-8 * np.linalg.norm(slow.force)
    assert fast.offset == pytest.approx(slow.offset, abs=1e-9)
    assert np.array_equal(fast.in_contact, slow.in_contact)


def test_coarse_start_changes_the_cost_and_not_the_answer() -> None:
    heights = wavy((128, 96))
    nested = run_nested(heights)
    cold = run(heights, load=0.3)
    assert np.linalg.norm(nested.force - cold.force) < 1e-7 * np.linalg.norm(cold.force)


def test_weights_turn_the_interpolated_pressure_into_forces() -> None:
    """With node weights the start is w p; where it starts changes no answer."""
    heights = wavy((40, 40))
    weights = np.where(np.add.outer(np.arange(40), np.arange(40)) % 2, 0.5, 1.5)
    plain, nested = run(heights, load=0.3), run_nested(heights, weights=weights)
    np.testing.assert_allclose(nested.force, plain.force, atol=1e-7 * plain.force.max())


def test_residual_that_cannot_be_reached_is_called_stagnation() -> None:
    solution = run(wavy((32, 32)), load=0.3, tolerance=1e-22)
    assert solution.status is Status.STAGNATED


def test_coarsening_keeps_low_waves_and_refinement_keeps_values() -> None:
    x = np.arange(24) / 24
    wave = np.cos(2 * np.pi * 3 * x)[:, None] * np.ones(20)
    coarse = coarsened(wave, (12, 10))
    np.testing.assert_allclose(coarse, wave[::2, ::2], atol=1e-14)
    np.testing.assert_allclose(
        coarsened(np.cos(2 * np.pi * 9 * x)[:, None] * np.ones(20), (12, 10)), 0, atol=1e-14
    )
    assert np.array_equal(refined(coarse, (24, 20))[::2, ::2], coarse)


@pytest.mark.parametrize("bounded", [False, True])
def test_steps_in_single_precision_change_the_path_and_not_the_answer(bounded: bool) -> None:
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
def test_the_response_in_single_precision_is_the_double_one_to_its_digits(shape: tuple[int, int]) -> None:
    operator = FourierOperator(SOFT, shape, (1.0, shape[1] / shape[0]), threads=1)
    field = np.random.default_rng(37).standard_normal(shape)
    field -= field.mean()
    single = operator.single(0.25)
    for double_way, single_way, factor in (
        (operator.apply, single.apply, 0.25),
        (operator.precondition, single.precondition, 4.0),
    ):
        expected, found = np.empty(shape), np.empty(shape, dtype=np.float32)
        single_way(field.astype(np.float32), found)
        double_way(field, expected)
        assert np.linalg.norm(found - factor * expected) < 1e-6 * np.linalg.norm(factor * expected)
