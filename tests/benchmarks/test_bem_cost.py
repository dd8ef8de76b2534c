"""Counted cost of the boundary-element solver: transforms and memory, which no busy machine can change."""

import pytest
from bem_speed import PRESSURE, SOFT, benchmark_surface

from fem_contact.bem import solve


@pytest.mark.parametrize(("n", "pairs"), [(256, 40), (512, 45), (1024, 50)])
@pytest.mark.slow
def test_pairs_and_memory_per_grid(n, pairs):
    for seed in (7, 8):
        result = solve(benchmark_surface(n, seed), SOFT, mean_pressure=PRESSURE).checked()
        assert result.residuals.complementarity <= 1e-8
        assert result.cost.fft_pairs <= pairs
        assert result.cost.peak_bytes <= 10 * 8 * n * n


@pytest.mark.benchmark
def test_pairs_at_4096():
    result = solve(benchmark_surface(4096), SOFT, mean_pressure=PRESSURE).checked()
    assert result.cost.fft_pairs <= 80
    assert result.cost.peak_bytes <= 10 * 8 * 4096**2
