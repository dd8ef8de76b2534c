"""Cost of the boundary elements by plain array operations, on a device of PyTorch.

The surface and load of bem_speed.py. "GB/s" is of one pair of transforms with the multiplication between
them, taken to read and write the field twice each way and to read the table: 84 bytes a point. "rest" is the
share of the solve that neither steps nor pairs of any grid take: C(q) by NumPy, moving arrays, measuring the
answer. "off" is the largest difference of the pressure from that of the compiled passes, over its peak.

Run as ``python tests/benchmarks/device_speed.py [device, as cuda] [sizes, comma separated]``.
"""

import sys
import time

import numpy as np
from bem_speed import PRESSURE, SOFT, benchmark_surface, pair_seconds

from fem_contact.bem import solve
from fem_contact.complementarity import solve as iteration
from fem_contact.complementarity.arrays import ArrayGrids

#: Bytes that a pair moves for each point, and the largest grid that is solved by the compiled passes, too.
PAIR_BYTES, COMPARED = 84, 2048


def main(device="cpu", sizes="256,512,1024"):
    """Print the table."""
    inside = [0.0]
    bounded = iteration.solve_bounded

    def timed(*arguments, **options):
        clock = time.perf_counter()
        solution = bounded(*arguments, **options)
        inside[0] += time.perf_counter() - clock
        return solution

    iteration.solve_bounded = timed
    solve(benchmark_surface(64), SOFT, mean_pressure=PRESSURE, device=device)
    print("     n  steps   pairs  seconds  pair [ms]   GB/s  ratio   rest      off")
    for n in (int(text) for text in sizes.split(",")):
        surface, inside[0] = benchmark_surface(n), 0.0
        result = solve(surface, SOFT, mean_pressure=PRESSURE, device=device).checked()
        cost, rest = result.cost, 1 - inside[0] / result.cost.wall_seconds
        grids, off = ArrayGrids(device, (n, n), threads=1), float("nan")
        operator = grids.operator_of(SOFT, (n, n), (1.0, 1.0))
        field = grids.put(np.random.default_rng(3).standard_normal((n, n)))
        pair, _ = pair_seconds(operator, field, grids.xp.empty_like(field), repeats=7)
        if n <= COMPARED:
            compiled = solve(surface, SOFT, mean_pressure=PRESSURE, method="double").checked()
            off = float(np.max(np.abs(result.pressure - compiled.pressure)) / np.max(compiled.pressure))
        print(
            f"{n:6d} {cost.iterations:6d} {cost.fft_pairs:7.1f} {cost.wall_seconds:8.3f} {1e3 * pair:10.2f} "
            f"{PAIR_BYTES * n * n / pair / 1e9:6.1f} {cost.wall_seconds / (cost.fft_pairs * pair):6.2f} "
            f"{rest:6.1%} {off:8.1e}",
            flush=True,
        )


if __name__ == "__main__":
    main(*sys.argv[1:])
