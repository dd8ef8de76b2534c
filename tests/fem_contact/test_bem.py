"""The boundary-element solver against closed forms, symmetries and changes of unit."""

import numpy as np
import pytest
from surfaces import SOFT, rough_surface

from fem_contact import BondedLayer, FrictionlessLayer, InvalidInput, NotConverged, Solid, Status
from fem_contact.bem import solve, solve_displacement, solve_path
from fem_contact.complementarity.fourier import FourierOperator
from fem_contact.surface import HeightField


def rough(shape=(64, 64), *, seed=7, ratio=8.0):
    lengths = (1.0, shape[1] / shape[0])
    waves = max(shape) / ratio
    return rough_surface(shape, lengths, seed=seed, waves=waves, longest=4 * max(lengths), gradient=1.0)


def test_offset_of_the_heights_only_moves_the_offset():
    surface = rough((48, 48))
    lifted = HeightField(heights=surface.heights + 0.75, lengths=surface.lengths)
    first, second = (solve(s, SOFT, mean_pressure=0.05, tolerance=1e-11).checked() for s in (surface, lifted))
    assert second.offset - first.offset == pytest.approx(0.75, rel=1e-10)
    assert np.linalg.norm(first.pressure - second.pressure) < 1e-8 * np.linalg.norm(first.pressure)


def test_iteration_limit_is_a_status_with_a_remedy():
    result = solve(rough(), SOFT, mean_pressure=0.05, max_iterations=3)
    assert result.status is Status.ITERATION_LIMIT
    with pytest.raises(NotConverged, match="allow more iterations"):
        result.checked()


def test_bound_equal_to_the_load_leaves_no_choice_and_below_it_is_refused():
    surface = rough()
    result = solve(surface, SOFT, mean_pressure=0.3, pressure_bound=0.3).checked()
    assert np.all(result.pressure == 0.3)
    assert result.at_bound.all()
    assert result.gap.max() == pytest.approx(0.0, abs=1e-15)
    with pytest.raises(InvalidInput, match="must not be below"):
        solve(surface, SOFT, mean_pressure=0.3, pressure_bound=0.29)


def test_offset_control_of_a_layer_goes_through_full_contact():
    surface = rough((32, 32))
    layer = BondedLayer(solid=Solid(young=1.0, poisson=0.3), thickness=0.06)
    offsets = np.array([2.0, 0.0, -2.0, -40.0, -80.0]) * surface.rms_height
    loads = [solve_displacement(surface, layer, offset=one).checked().mean_pressure for one in offsets]
    assert np.all(np.diff(loads) > 0)
    stiffness = 1 / layer.compliance(np.zeros(1), np.zeros(1))[0]
    assert loads[4] - loads[3] == pytest.approx(40 * surface.rms_height * stiffness, rel=1e-9)


def test_zero_mean_gap_is_full_contact_at_the_least_load_and_less_is_refused():
    surface = rough((32, 32))
    result = solve_displacement(surface, SOFT, mean_gap=0.0).checked()
    assert result.in_contact.all()
    assert result.pressure.min() == pytest.approx(0.0, abs=1e-12)
    with pytest.raises(InvalidInput, match="negative mean gap"):
        solve_displacement(surface, SOFT, mean_gap=-1e-3 * surface.rms_height)
    lifted = HeightField(heights=surface.heights + 1, lengths=surface.lengths)
    with pytest.raises(InvalidInput, match=r"offset = 0\.9 m: asks for a negative mean gap"):
        solve_displacement(lifted, SOFT, offset=0.9)
    with pytest.raises(InvalidInput, match="exactly one"):
        solve_displacement(surface, SOFT)


def test_path_up_and_down_does_not_remember():
    surface = rough((48, 48))
    loads = [0.01, 0.05, 0.2, 1.0, 0.2, 0.05, 0.01]
    path = [result.checked() for result in solve_path(surface, SOFT, mean_pressures=loads, tolerance=1e-10)]
    for up, down in zip(path[:3], path[:3:-1], strict=True):
        assert np.linalg.norm(up.pressure - down.pressure) < 1e-6 * np.linalg.norm(up.pressure)
        assert np.array_equal(up.in_contact, down.in_contact)
    cold = [solve(surface, SOFT, mean_pressure=load, tolerance=1e-10).cost.fft_pairs for load in loads]
    assert sum(result.cost.fft_pairs for result in path) < 1.2 * sum(cold)


#: What tests/fem_contact/test_random_contacts.py does not draw.
HARD = {
    "one column": lambda: np.cos(np.arange(64) * 0.3)[:, None],
    "one point": lambda: np.ones((1, 1)),
    "flat": lambda: np.full((9, 6), 1e6),
    "prime": lambda: np.cos(np.add.outer(np.arange(31) ** 1.5, np.arange(37) * 0.9)),
}


@pytest.mark.parametrize("name", HARD)
@pytest.mark.parametrize("reduced", [1e-6, 0.1, 10.0])
def test_hard_surfaces_end_in_a_right_answer(name, reduced):
    surface = HeightField(heights=HARD[name](), lengths=(1.0, 1.5))
    scale = max(surface.rms_gradient, 1e-12)
    result = solve(surface, SOFT, mean_pressure=reduced * scale).checked()
    assert result.residuals.worst < 2e-7
    assert result.in_contact.any()


def test_cost_counts_pairs_and_memory():
    surface = rough((256, 256))
    result = solve(surface, SOFT, mean_pressure=0.05)
    assert result.cost.fft_pairs < 45
    assert result.cost.peak_bytes <= 10 * 8 * 256**2
    assert result.cost.unknowns == 256**2
    assert result.cost.wall_seconds > 0


# --- far from ordinary: a right answer, or a status that says why not
# --------------------------------------------------------------------


@pytest.mark.parametrize("kind", [BondedLayer, FrictionlessLayer])
def test_a_flat_body_driven_into_a_layer_compresses_it(kind):
    layer = kind(solid=Solid(young=1.0, poisson=0.3), thickness=0.2)
    flat = HeightField(heights=np.zeros((8, 8)), lengths=(1.0, 1.0))
    # Confined compression: (1 - nu) E / ((1 + nu) (1 - 2 nu)) times the strain of a half.
    confined = 0.7 / (1.3 * 0.4) * 0.5
    assert confined == pytest.approx(0.673, abs=1e-3)
    for bound in (None, 10.0):
        result = solve_displacement(flat, layer, offset=-0.1, pressure_bound=bound).checked()
        np.testing.assert_allclose(result.pressure, confined, rtol=1e-12)
        assert result.offset == pytest.approx(-0.1, rel=1e-12)


@pytest.mark.parametrize("reduced", [1e10, 1e12, 1e20])
def test_full_contact_whose_gap_is_lost_to_rounding_is_not_converged(reduced):
    surface = rough()
    pressed = solve(surface, SOFT, mean_pressure=reduced * surface.rms_gradient)
    assert pressed.residuals.worst > 1e-7
    assert pressed.status is Status.STAGNATED
    with pytest.raises(NotConverged, match="below what the arithmetic can reach"):
        pressed.checked()


@pytest.mark.parametrize(("seed", "n", "reduced"), [(7, 32, 1e-30), (8, 16, 1e-20), (9, 24, 1e-100)])
def test_a_load_that_steps_round_away_is_carried_all_the_same(seed, n, reduced):
    surface = rough_surface((n, n), seed=seed, waves=6.0)  # a division by a load of 0 on each of them once
    result = solve(surface, SOFT, mean_pressure=reduced * surface.rms_gradient).checked()
    assert result.mean_pressure == pytest.approx(reduced * surface.rms_gradient, rel=1e-12)


def test_surfaces_too_far_apart_do_not_touch():
    surface = rough((32, 32))
    result = solve_displacement(surface, SOFT, offset=2 * float(surface.heights.max())).checked()
    assert result.mean_pressure == result.in_contact.sum() == 0
    assert result.gap.min() == pytest.approx(float(surface.heights.max()))


def test_a_thin_incompressible_layer_takes_a_hundred_pairs():
    """182, 496 and 857 of them before; at .01 and a load of .5 the iteration stagnated."""
    for thickness, load, pairs in ((0.03, 0.05, 120), (0.01, 0.05, 140), (0.003, 0.5, 80), (0.01, 0.5, 200)):
        layer = BondedLayer(solid=Solid(young=1.0, poisson=0.5), thickness=thickness)
        assert solve(rough(), layer, mean_pressure=load).checked().cost.fft_pairs < pairs


@pytest.mark.parametrize(("lengths", "shape"), [((1.0, 0.1), (160, 16)), ((0.1, 1.0), (16, 160))])
def test_the_long_stiff_waves_of_a_strip_lie_along_it(lengths, shape):
    layer = BondedLayer(solid=Solid(young=1.0, poisson=0.5), thickness=0.05)
    assert FourierOperator(layer, shape, lengths, threads=1).long_waves is not None


def test_full_contact_is_answered_at_once_with_a_bound_it_does_not_reach_and_not_with_one_it_does():
    surface = rough((32, 32))
    least = solve_displacement(surface, SOFT, mean_gap=0.0).checked()
    free, bounded, yielding = (
        solve(surface, SOFT, mean_pressure=1.1 * least.mean_pressure, pressure_bound=bound)
        for bound in (None, 2.5 * least.pressure.max(), 0.8 * least.pressure.max())
    )
    assert np.array_equal(free.pressure, bounded.pressure)
    assert free.cost.fft_pairs == bounded.cost.fft_pairs < yielding.cost.fft_pairs
    assert yielding.at_bound.any()


def test_a_residual_that_rests_on_oblong_cells_says_so():
    heights = np.random.default_rng(31).standard_normal((128, 32))
    surface = HeightField(heights=heights, lengths=(1.0, 1e4))
    result = solve(surface, SOFT, mean_pressure=0.05 * surface.rms_gradient)
    assert result.status is Status.OBLONG_CELLS
    with pytest.raises(NotConverged, match="far from square: choose spacings alike"):
        result.checked()


@pytest.mark.parametrize("sizes", [10.0, 1e9])
def test_where_all_has_yielded_the_body_sinks_as_far_as_it_is_pushed(sizes):
    surface = rough()
    gap = -sizes * surface.rms_height
    result = solve_displacement(surface, SOFT, mean_gap=gap, pressure_bound=0.5).checked()
    assert np.all(result.pressure == 0.5)
    assert result.at_bound.all()
    assert np.mean(result.gap) == pytest.approx(gap, rel=1e-12)


def test_points_that_touch_below_the_bound_sink_no_further():
    """A gap below full contact needs points that yield: full contact was called the answer."""
    surface = rough((32, 32))
    full = solve_displacement(surface, SOFT, mean_gap=0.0).checked()
    bound = 1.5 * float(full.pressure.max())
    target = -0.2 * surface.rms_height
    for asked in ({"mean_gap": target}, {"offset": target + np.mean(surface.heights)}):
        result = solve_displacement(surface, SOFT, **asked, pressure_bound=bound).checked()
        assert np.mean(result.gap) == pytest.approx(target, abs=1e-6 * surface.rms_height)
        assert result.at_bound.any()
        assert result.mean_pressure > full.mean_pressure


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_two_equal_peaks_that_have_yielded_bear_one_load_over_a_range_of_offsets(share):
    """The load does not change between their yielding and the next point's touch: no search finds it."""
    heights = np.zeros((6, 6))
    heights[1, 2] = heights[4, 5] = 1.0
    surface, bound = HeightField(heights=heights, lengths=(1.0, 1.0)), 0.3
    both = solve(surface, SOFT, mean_pressure=bound / 18, pressure_bound=bound)
    level = both.displacement - heights
    touch, yielded = -float(level[heights == 0].min()), -float(level[heights == 1].max())
    offset = touch + share * (yielded - touch)
    result = solve_displacement(surface, SOFT, offset=offset, pressure_bound=bound).checked()
    assert result.offset == pytest.approx(offset, rel=1e-7)
    assert result.mean_pressure == pytest.approx(bound / 18, rel=1e-9)
    assert result.at_bound.sum() == 2


def test_points_that_a_loose_solve_leaves_on_the_wrong_side_are_in_its_area_interval():
    """No interval of a rough solve misses the strict area, and it narrows in proportion to the tolerance."""
    moved, widths = 0, []
    for seed in (7, 11):
        for load in (3e-3, 0.05, 0.4):
            surface = rough((96, 96), seed=seed)
            strict = solve(surface, SOFT, mean_pressure=load, tolerance=1e-11).checked()
            area = float(np.mean(strict.in_contact))
            assert strict.area_interval == (area, area)
            for tolerance in (2e-3, 1e-4):
                loose = solve(surface, SOFT, mean_pressure=load, tolerance=tolerance).checked()
                least, most = loose.area_interval
                moved += int(np.count_nonzero(loose.in_contact != strict.in_contact))
                assert least <= np.mean(loose.in_contact & strict.in_contact)
                assert np.mean(loose.in_contact | strict.in_contact) <= most
                widths.append((most - least) / area)
    assert moved > 10
    assert max(widths[1::2]) < 0.1 * max(widths[::2])
