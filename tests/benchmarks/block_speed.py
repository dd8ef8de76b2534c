"""Unknowns, seconds and memory of the finite-element block, full and reduced, beside boundary elements.

Surface: H = .8, lambda_long = L/4, lambda_short = 8 dx, p* = .05, nu = .3; a mesh one period deep. Every row
is a process of its own, so that its peak memory is its own; compiled kernels are warm.

Run as ``python tests/benchmarks/block_speed.py [method:size ...]``, for instance ``reduced:1024 full:64``.
Methods are full, quadratic (full, with Hex2), incompressible (full, with Hex2/P1disc, nu = .4999), reduced,
bem, field (reduced, and the stress of every cell), and particle (full, with a ball under a contact that is
ten times stiffer).
"""

import resource
import subprocess
import sys
import time

import numpy as np
from bem_speed import benchmark_surface

from fem_contact import HalfSpace, Solid, bem, block

SOLID = Solid(young=1.0, poisson=0.3)
ELEMENTS = {"quadratic": "Hex2", "incompressible": "Hex2/P1disc"}
DEFAULT = (
    "reduced:256",
    "bem:256",
    "reduced:512",
    "bem:512",
    "reduced:1024",
    "bem:1024",
    "full:32",
    "full:64",
    "full:128",
    "full:256",
    "quadratic:64",
    "quadratic:128",
    "incompressible:64",
    "particle:64",
    "particle:128",
)


def particle(surface, x, y, z):
    """Ten times stiffer in a ball below the highest point."""
    i, j = np.unravel_index(surface.heights.argmax(), surface.shape)
    away = (x - i / surface.shape[0] + 0.5) % 1 - 0.5, (y - j / surface.shape[1] + 0.5) % 1 - 0.5
    return np.where(away[0] ** 2 + away[1] ** 2 + (z + 0.12) ** 2 < 0.01, 10.0, 1.0)


def solve(method, surface):
    """Solve, and with "field" walk through the whole block."""
    solid = Solid(young=1.0, poisson=0.4999) if method == "incompressible" else SOLID
    load = 0.05 * solid.contact_modulus * surface.rms_gradient
    if method == "bem":
        return bem.solve(surface, HalfSpace(solid=SOLID), mean_pressure=load)
    if method in ELEMENTS:
        name = ELEMENTS[method]
        return block.solve(surface, solid, mean_pressure=load, method="full", element=name).contact
    name = "full" if method == "full" else "reduced"
    if method == "particle":

        def modulus(x, y, z):
            return particle(surface, x, y, z)

        return block.solve(surface, SOLID, mean_pressure=load, modulus=modulus, method="full").contact
    solution = block.solve(surface, SOLID, mean_pressure=load, method=name)
    if method == "field":
        peak = max(float(layer.von_mises.max()) for _, layer in solution.stress_layers())
        assert np.isfinite(peak)
    return solution.contact


def measure(method, n):
    """One row."""
    solve(method, benchmark_surface(32))
    surface = benchmark_surface(n)
    began, processor = time.perf_counter(), time.process_time()
    result = solve(method, surface).checked()
    seconds, busy = time.perf_counter() - began, time.process_time() - processor
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    cost = result.cost
    steps = f"{cost.iterations}" + (f" ({cost.linear_iterations})" if cost.linear_iterations else "")
    return (
        f"{method:>14} {n:>5} {cost.unknowns:>11,} {seconds:>8.2f} {busy:>8.2f} {memory:>8.2f} {steps:>10} "
        f"{cost.fft_pairs:>7.1f} {result.residuals.worst:>9.1e} {result.in_contact.mean():>8.5f}"
    )


def main(rows):
    """Print the table."""
    if len(rows) == 2 and rows[0] == "--row":
        method, n = rows[1].split(":")
        print(measure(method, int(n)), flush=True)
        return
    print(
        "        method     n    unknowns  seconds      cpu      GiB steps (CG)   pairs  residual     area",
        flush=True,
    )
    for row in rows or list(DEFAULT):
        subprocess.run([sys.executable, __file__, "--row", row], check=True)


if __name__ == "__main__":
    main(sys.argv[1:])
