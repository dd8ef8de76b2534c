"""What a solve will cost, in seconds and bytes, predicted before it is done."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING, Any

import numpy as np

from validation.solves.solve import AnyJob, Job, NumbersJob, Prediction

if TYPE_CHECKING:
    pass

__all__ = ["available_memory", "memory_words", "predicted_cost", "too_large", "transform_seconds"]


# Measured on one thread, in units of a pair of real 256 x 256 transforms, which tells one machine from
# another.
#: What a solve costs whatever its grid: surface, set-up, storing.
_FIXED_PAIRS = 26.0


#: Boundary elements, per pair of transforms on the grid; 25 to 30 are needed, and the passes between them
#: cost.
_BEM_PAIRS = 80.0


#: The reduced block takes as many, and makes its compliance first.
_REDUCED_PAIRS = 110.0


#: The whole block, per unknown: assembly, active sets, export.
_FULL_PAIRS_PER_UNKNOWN = 0.17


#: Active sets of a block that yields over those of an elastic one: 1 to 4, by how little it can bear.
_YIELDING_SETS = 2.0


_SURFACE_BYTES_PER_POINT, _FIXED_BYTES = 15 * 8, 3 * 2**19


_FULL_BYTES_PER_UNKNOWN = 4900


def transform_seconds(n: int = 256) -> float:
    """Median time of a pair of real n x n transforms on this machine, on one thread [s]."""
    import scipy.fft

    field = np.random.default_rng(5).random((n, n))
    times = []
    for _ in range(5):
        start = time.perf_counter()
        scipy.fft.irfft2(scipy.fft.rfft2(field), s=(n, n))
        times.append(time.perf_counter() - start)
    return sorted(times)[2]


def predicted_cost(job: AnyJob, *, pair_seconds: float = 0.5e-3) -> Prediction:
    """Predict the cost of a job on one thread, storing included, beyond what an idle process takes.

    Parameters
    ----------
    job : AnyJob
    pair_seconds : float
        Time of one pair of 256 x 256 transforms on this machine, from `transform_seconds` [s].
    """
    if isinstance(job, NumbersJob):
        return job.predict()
    points = job.grid[0] * job.grid[1]
    scale = points * math.log2(points) / (256**2 * 16)
    dearer = _dearer(job)
    pairs, unknowns = _FIXED_PAIRS + _BEM_PAIRS * dearer * scale, points
    size = _FIXED_BYTES + _SURFACE_BYTES_PER_POINT * points
    if job.method == "fem":
        from fem_contact.block import estimate

        settings: dict[str, Any] = dict(job.settings)
        method = settings.get("method", "full")
        mesh = {name: settings[name] for name in ("depth", "growth") if name in settings}
        unknowns = estimate(job.grid, job.surface.length, method=method, **mesh).unknowns
        if method == "full":
            sets = _YIELDING_SETS if any(effect.kind == "hardness" for effect in job.effects) else 1.0
            pairs = _FIXED_PAIRS + _FULL_PAIRS_PER_UNKNOWN * sets * unknowns
            size = _FIXED_BYTES + _FULL_BYTES_PER_UNKNOWN * unknowns
        else:
            pairs = _FIXED_PAIRS + _REDUCED_PAIRS * scale
    return Prediction(seconds=pairs * pair_seconds, peak_bytes=size, unknowns=unknowns)


def _dearer(job: Job) -> float:
    """Seconds of a solve with its effects over those of a plain one; 1 for a job that lists none."""
    if not job.effects:
        return 1.0
    from validation.solves.calibration import effect_costs

    factors = effect_costs().factors
    return math.prod(factors.get(effect.kind, 1.0) for effect in job.effects)


def available_memory() -> int:
    """Bytes that solves may take on this machine: nine tenths of what is free now."""
    import psutil

    return int(0.9 * psutil.virtual_memory().available)


def memory_words(size: float) -> str:
    """Return an amount of memory in words.

    >>> memory_words(3 * 2**20), memory_words(2.5 * 2**30)
    ('3 MiB', '2.5 GiB')
    """
    return f"{size / 2**30:.3g} GiB" if size >= 2**30 else f"{size / 2**20:.3g} MiB"


def too_large(job: AnyJob, limit: int, *, where: str = "here") -> str:
    """Say that a job does not fit into memory, and what to do."""
    needed = predicted_cost(job).peak_bytes
    return (
        f"{job.describe()}: needs about {memory_words(needed)} and {where} {memory_words(limit)} are free "
        "for it; "
        "leave the grid out, run it on a larger machine, or raise the limit with --memory"
    )
