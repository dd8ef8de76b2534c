"""Flow through the gap: closed forms, percolation, conservation."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fem_contact import critical_gap, find_patches, flow_conductance, percolates


def test_the_flux_is_the_same_through_every_section_of_a_gap_of_many_decades():
    rng = np.random.default_rng(5)
    gap = 10.0 ** rng.uniform(-3, 0, (40, 33))
    gap[rng.random(gap.shape) < 0.2] = 0
    found = flow_conductance(gap, (1.0, 0.7))
    assert not found.closed
    assert found.balance < 1e-10
    # The work of the mean gradient is what is dissipated.
    again = flow_conductance(3.0 * gap, (1.0, 0.7))
    assert again.conductance == pytest.approx(27 * found.conductance, rel=1e-12)


def test_wide_pools_behind_narrow_straits_keep_the_flux_in_balance():
    # Two pools, joined by two straits of one cell, whose cubes are 1e-9 of theirs: all resistance is there.
    gap = np.ones((24, 24))
    gap[11] = gap[23] = 0.0
    gap[11, 5] = gap[23, 17] = 1e-3
    found = flow_conductance(gap, (1.0, 1.0))
    assert found.balance < 1e-10
    assert found.conductance == pytest.approx(1e-9 / 12 / 2, rel=1e-6)


def test_a_diagonal_channel_winds_along_both_axes_and_leaks_along_both():
    gap = np.zeros((12, 12))
    index = np.arange(12)
    gap[index, index] = gap[index, (index + 1) % 12] = 1.0
    for axis in ("x", "y"):
        assert percolates(gap > 0, axis)
        assert not flow_conductance(gap, (1.0, 1.0), axis=axis).closed


def test_a_path_that_goes_through_the_period_and_back_leads_nowhere():
    # A hairpin: up column 1 to the seam, over it, and back below without closing around the period.
    open_cells = np.zeros((8, 8), dtype=bool)
    open_cells[2:, 1] = open_cells[0, 1:5] = open_cells[2:, 4] = True
    assert not percolates(open_cells, "x")
    open_cells[1, 1] = True
    assert percolates(open_cells, "x")


@given(st.integers(0, 2**32 - 1), st.floats(0.3, 0.8))
def test_percolation_is_that_of_a_walk_over_many_periods(seed, share):
    open_cells = np.random.default_rng(seed).random((7, 6)) < share
    periods = 9  # a path of 42 cells that does not wind gets no further, wrapped in y and unrolled in x
    unrolled = np.vstack([np.tile(open_cells, (periods, 1)), np.zeros((1, 6), dtype=bool)])
    labels = find_patches(unrolled, (1.0, 1.0)).labels
    through = np.intersect1d(labels[:7], labels[7 * (periods - 1) : 7 * periods])
    assert percolates(open_cells, "x") == bool(np.any(through > 0))


def test_the_critical_gap_is_the_last_level_at_which_the_gap_percolates():
    gap = np.random.default_rng(8).random((20, 20))
    for axis in ("x", "y"):
        critical = critical_gap(gap, axis)
        assert percolates(gap >= critical, axis)
        assert not percolates(gap > critical, axis)
