"""Cost of one solve in slabs: seconds, pairs and memory of each process.

The surface of bem_speed.py, made in slabs: H = .8, lambda_long = L/4, lambda_short = 8 dx, p* = .05. "work"
is the most processor time of a process outside calls of MPI, in which processes wait; then the calls, and the
MiB that a process sends, each per pair. "arrays" is what the largest process grew by beyond a small solve,
over the doubles of its slab, at its peak (under glibc, with MALLOC_MMAP_THRESHOLD_=1000000).

Run as ``mpiexec -n 2 python tests/benchmarks/slabs_speed.py [sizes, comma separated]``.
"""

from __future__ import annotations

import resource
import sys
import time
from typing import Any

import numpy as np
from bem_speed import PRESSURE, SOFT

from fem_contact.bem import SlabSurface, solve
from fem_contact.bem.parallel import communicator
from fem_contact.complementarity.in_slabs import SlabOperator


class Counted:
    """A communicator that counts what goes through it, and the processor time of that."""

    def __init__(self, comm: Any) -> None:
        self.comm, self.rank, self.size = comm, comm.rank, comm.size
        self.seconds, self.calls, self.sent = 0.0, 0, 0

    def __getattr__(self, name: str) -> Any:
        def call(*arguments: Any, **options: Any) -> Any:
            clock = time.process_time()
            answer = getattr(self.comm, name)(*arguments, **options)
            self.seconds += time.process_time() - clock
            self.calls += 1
            if name == "Alltoallv":
                values, (counts, _) = arguments[0]
                self.sent += (sum(counts) - counts[self.rank]) * values.itemsize
            return answer

        return call


def slab_surface(n: int, comm: Any) -> SlabSurface:
    """Unit rms gradient, nearly."""
    q_long, q_short = 8 * np.pi, 2 * np.pi * n / 8
    slopes = 2 * np.pi * (q_short**0.4 - q_long**0.4) / 0.4
    return SlabSurface.random(
        lambda q: np.where(q > 0.999 * q_long, q**-3.6 / slopes, 0.0),
        q_short=q_short,
        lengths=(1.0, 1.0),
        shape=(n, n),
        seed=7,
        comm=comm,
    )


def pair_seconds(surface: SlabSurface, kind: type[np.floating[Any]]) -> float:
    """Least time of one pair of transforms with the multiplication between them."""
    operator: Any = SlabOperator(SOFT, surface.slabs, surface.lengths, threads=1)
    operator = operator if kind is np.float64 else operator.single(1.0)
    field, times = surface.heights.astype(kind), []
    out = np.empty_like(field)
    for _ in range(7):
        surface.slabs.gathered(0.0)
        clock = time.perf_counter()
        operator.apply(field, out)
        times.append(float(surface.slabs.gathered(time.perf_counter() - clock).max()))
    return min(times)


def resident() -> float:
    """Peak memory so far [bytes]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024.0


def main(sizes: str = "512,1024,2048") -> None:
    """Print the table."""
    comm = Counted(communicator())
    solve(slab_surface(256, comm), SOFT, mean_pressure=PRESSURE, comm=comm)
    if comm.rank == 0:
        print("     n    P  steps   pairs  seconds  work  pair [ms], single  calls   MiB  arrays  area")
    for n in (int(text) for text in sizes.split(",")):
        before = resident()
        surface = slab_surface(n, comm)
        comm.seconds, comm.calls, comm.sent = 0.0, 0, 0
        began = time.process_time()
        result = solve(surface, SOFT, mean_pressure=PRESSURE, comm=comm).checked()
        cost = result.contact.cost
        counts = comm.calls / cost.fft_pairs, comm.sent / cost.fft_pairs / 2**20
        work = float(surface.slabs.gathered(time.process_time() - began - comm.seconds).max())
        grown = (resident() - before) / surface.heights.nbytes
        arrays, area = float(surface.slabs.gathered(grown).max()), result.areas().subcell
        del result
        double, single = (1e3 * pair_seconds(surface, kind) for kind in (np.float64, np.float32))
        if comm.rank == 0:
            print(
                f"{n:6d} {comm.size:4d} {cost.iterations:6d} {cost.fft_pairs:7.1f} {cost.wall_seconds:8.2f} "
                f"{work:5.2f} {double:9.1f} {single:8.1f} {counts[0]:6.1f} {counts[1]:5.1f} {arrays:7.2f}  "
                f"{area:.9f}",
                flush=True,
            )


if __name__ == "__main__":
    main(*sys.argv[1:])
