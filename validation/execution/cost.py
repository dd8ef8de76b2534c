"""What a solve will cost, in seconds and bytes, predicted before it is done."""

from __future__ import annotations

import math
import timeit
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from validation.execution.solve import Solve

if TYPE_CHECKING:
    from validation.effects.base import Effect


def transform_seconds() -> float:
    """Median time of a pair of real 256 x 256 transforms on this machine, on one thread [s]."""
    from scipy.fft import irfft2, rfft2

    field = np.random.default_rng(5).random((256, 256))
    return sorted(timeit.repeat(lambda: irfft2(rfft2(field), s=field.shape), number=1, repeat=5))[2]


def memory_words(size: float) -> str:
    """Return an amount of memory in words.

    >>> memory_words(3 * 2**20), memory_words(2**30), memory_words(2.5 * 2**30)
    ('3 MiB', '1 GiB', '2.5 GiB')
    """
    return f"{size / 2**30:.3g} GiB" if size >= 2**30 else f"{size / 2**20:.3g} MiB"


def too_large(solve: Solve, limit: int, *, where: str = "here") -> str:
    """Say that a solve does not fit into memory, and what to do."""
    needed = solve.predict().peak_bytes
    return (
        f"{solve.describe()}: needs about {memory_words(needed)} and {where} {memory_words(limit)} are free "
        "for it; "
        "leave the grid out, run it on a larger machine, or raise the limit with --memory"
    )


def dearer_by(effects: Sequence[Effect]) -> float:
    """Time of a boundary-element solve with effects over that of a plain one, on this machine."""
    if not effects:
        return 1.0
    from validation.execution.calibration import effect_costs

    factors = effect_costs().factors
    return math.prod(factors[effect.kind] * effect.solves for effect in effects)
