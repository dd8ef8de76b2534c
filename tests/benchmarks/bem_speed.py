"""Cost of the boundary-element solver per grid, and against tamaas and ASPHER where they are installed.

Surface: H = .8, lambda_long = L/4, lambda_short = 8 dx, p* = .05; stopped at a complementarity of 1e-8,
measured by `fem_contact.contact.measure_residuals` on the fields of either code. "ratio" is seconds over
pairs times the seconds of one pair, by the wall clock and by processor time: the latter is the one to trust
on a machine that is not idle.

Run as ``python tests/benchmarks/bem_speed.py [sizes, comma separated] [threads] [method] [peer]``. A peer is
tamaas, aspher or free, the same surface as a patch of a `FreeHalfSpace`. The last two are run at three loads
and compared by processor time; ASPHER takes no number of threads (set OMP_NUM_THREADS=1).
"""

import resource
import sys
import time

import numpy as np

from fem_contact import FreeHalfSpace, HalfSpace, Solid, measure_residuals
from fem_contact.bem import solve
from fem_contact.complementarity import FourierOperator
from fem_contact.surface import HeightField, random_surface

SOFT = HalfSpace(solid=Solid(young=1.0, poisson=0.0))
PRESSURE = 0.05


def benchmark_surface(n, seed=7):
    """Unit rms gradient."""
    q_long = 8 * np.pi
    surface = random_surface(
        lambda q: np.where(q > 0.999 * q_long, q**-3.6, 0.0),
        q_short=2 * np.pi * n / 8,
        lengths=(1.0, 1.0),
        shape=(n, n),
        seed=seed,
    )
    return HeightField(heights=surface.heights / surface.rms_gradient, lengths=(1.0, 1.0))


def pair_seconds(operator, field, out, *, repeats):
    """Least wall and processor time of one pair of transforms with the multiplication between them."""
    times = []
    for _ in range(repeats):
        wall, processor = time.perf_counter(), time.process_time()
        operator.apply(field, out)
        float(out[0, 0])  # waits for a device
        times.append((time.perf_counter() - wall, time.process_time() - processor))
    return np.min(times, axis=0)


def run_ours(n, threads, method):
    """Print one line of the table; the seconds of the solve."""
    surface = benchmark_surface(n)
    operator = FourierOperator(SOFT, (n, n), (1.0, 1.0), threads=threads)
    field, out = np.random.default_rng(3).standard_normal((n, n)), np.empty((n, n))
    pair, pair_processor = pair_seconds(operator, field, out, repeats=9 if n <= 2048 else 3)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    costs = []
    for _ in range(3 if n <= 2048 else 1):
        result = solve(surface, SOFT, mean_pressure=PRESSURE, threads=threads, method=method).checked()
        residuals = result.residuals
        costs.append(result.cost)
        del result
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 - before
    cost = min(costs, key=lambda one: one.wall_seconds)
    processor = min(one.cpu_seconds for one in costs)
    print(
        f"{n:6d} {cost.iterations:6d} {cost.fft_pairs:7.1f} {cost.wall_seconds:8.3f} {1e3 * pair:9.2f} "
        f"{cost.wall_seconds / (cost.fft_pairs * pair):6.2f} "
        f"{processor / (cost.fft_pairs * pair_processor):6.2f} "
        f"{cost.peak_bytes / (8 * n * n):7.2f} {grown / (8 * n * n):7.2f} "
        f"{residuals.complementarity:9.1e} {residuals.penetration:9.1e}",
        flush=True,
    )
    return cost.wall_seconds


def run_tamaas(n):
    """Seconds and residuals of tamaas' PolonskyKeerRey on the same surface."""
    import tamaas

    surface = benchmark_surface(n)
    model = tamaas.ModelFactory.createModel(tamaas.model_type.basic_2d, [1.0, 1.0], [n, n])
    model.E, model.nu = 1.0, 0.0
    heights = surface.heights.copy()
    kind = tamaas.PolonskyKeerRey
    for tolerance in (1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11):
        solver = kind(model, heights, tolerance, kind.pressure, kind.pressure)
        solver.max_iter = 100_000
        model.traction[:] = 0
        clock = time.perf_counter()
        solver.solve(PRESSURE)
        seconds = time.perf_counter() - clock
        pressure = np.array(model.traction)
        gap = np.array(model.displacement) - heights
        gap -= np.sum(pressure * gap) / np.sum(pressure)
        residuals = measure_residuals(
            pressure=pressure,
            gap=gap,
            heights=heights,
            lengths=(1.0, 1.0),
            contact_modulus=1.0,
            rms_gradient=surface.rms_gradient,
            target_pressure=PRESSURE,
        )
        if residuals.complementarity <= 1e-8:
            break
    return seconds, residuals


def run_aspher(n, pressure):
    """Ratio of processor times at one load; of ASPHER's settings the fastest that meets the same residual."""
    import aspher

    surface = benchmark_surface(n)
    ours = min(
        (solve(surface, SOFT, mean_pressure=pressure, threads=1).checked() for _ in range(3)),
        key=lambda result: result.cost.cpu_seconds,
    )
    best = np.inf, "no setting meets 1e-8", 0.0, 0
    for precision in ("double", "float_then_double"):
        for tolerance in (1e-6, 1e-7, 1e-8, 1e-9, 1e-10):
            clock = time.process_time()
            found = aspher.solve_nested(
                n, -surface.heights.ravel(), pressure, tol=tolerance, backend="periodic", precision=precision
            )
            seconds = time.process_time() - clock
            force = np.array(found.pressure).reshape(n, n)
            displacement = np.empty_like(force)
            FourierOperator(SOFT, (n, n), (1.0, 1.0), threads=1).apply(force, displacement)
            gap = displacement - surface.heights
            gap -= np.sum(force * gap) / np.sum(force)
            missed = float(np.sum(force * np.abs(gap)) / (np.sum(force) * surface.rms_height))
            if missed <= 1e-8:
                if seconds < best[0]:
                    differ = int(np.count_nonzero((force > 0) != ours.in_contact))
                    apart = float(np.max(np.abs(force - ours.pressure)) / ours.pressure.max())
                    best = seconds, f"{precision}, tol {tolerance:g}", apart, differ
                break
    return (
        f"       aspher, p* {pressure}: {best[0]:.3f} s, {best[0] / ours.cost.cpu_seconds:.1f} times ours "
        f"({ours.cost.cpu_seconds:.3f}); {best[1]}; pressures {best[2]:.1e} apart, {best[3]} points differ"
    )


def run_free(n, pressure):
    """Pairs and processor seconds of a patch beside those of the periodic surface."""
    surface, patch = benchmark_surface(n), FreeHalfSpace(solid=SOFT.solid)
    period, free = (
        solve(surface, response, mean_pressure=pressure, threads=1).checked().cost
        for response in (SOFT, patch)
    )
    return (
        f"       free, p* {pressure}: {free.fft_pairs:.1f} pairs, "
        f"{free.fft_pairs / period.fft_pairs:.2f} times; {free.cpu_seconds:.3f} s, "
        f"{free.cpu_seconds / period.cpu_seconds:.1f} times"
    )


def main(sizes="512,1024,2048", threads=2, method="preconditioned", peer=""):
    """Print the table."""
    solve(benchmark_surface(64), SOFT, mean_pressure=PRESSURE, threads=threads, method=method)
    print("     n  steps   pairs  seconds  pair [ms]  ratio    cpu  arrays     RSS  complem.  penetr.")
    for n in (int(text) for text in sizes.split(",")):
        ours = run_ours(n, threads, method)
        if peer == "tamaas":
            seconds, residuals = run_tamaas(n)
            print(f"       tamaas {seconds:.2f} s, {seconds / ours:.1f} times ours; {residuals}", flush=True)
        for pressure in (0.005, 0.05, 0.3) if peer in ("aspher", "free") else ():
            print(run_aspher(n, pressure) if peer == "aspher" else run_free(n, pressure), flush=True)


if __name__ == "__main__":
    main(*(kind(text) for kind, text in zip((str, int, str, str), sys.argv[1:], strict=False)))
