"""Settings that all iterative solvers share, checked once and handed down as one object."""

from __future__ import annotations

import contextlib
import functools
import os
import time
from dataclasses import dataclass, replace
from typing import Any, TypedDict

from fem_contact._checks import positive, whole, within


def available_processors() -> int:
    """Processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@functools.cache
def _libraries() -> Any:
    """Look once for libraries with threads of their own: it takes longer than a small solve."""
    import scipy.linalg  # noqa: F401 -- which brings one
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


def one_blas_thread() -> contextlib.AbstractContextManager[object]:
    """Keep the dense linear algebra inside to one thread: more of them only wait for each other."""
    limits: contextlib.AbstractContextManager[object] = _libraries().limit(limits=1, user_api="blas")
    return limits


class Limits(TypedDict, total=False):
    """What `Settings` are made of, as arguments of functions that hand them down."""

    tolerance: float
    max_iterations: int
    time_limit: float | None
    threads: int | None


@dataclass(frozen=True, kw_only=True)
class Settings:
    """When an iteration stops, and how many threads it may use.

    Parameters
    ----------
    tolerance : float
        Complementarity that will do, the mean gap where there is pressure, weighted with it, over h_rms; at
        most 0.1. The other residuals are within ten times that.
    max_iterations : int
        Steps allowed.
    time_limit : float, optional
        Seconds allowed.
    threads : int, optional
        Threads; all available processors if not given.

    Raises
    ------
    InvalidInput
        For a tolerance outside (0, 0.1], numbers of steps or threads that are not positive and whole, or a
        time that is not positive.
    """

    tolerance: float = 1e-8
    max_iterations: int = 1000
    time_limit: float | None = None
    threads: int | None = None

    def __post_init__(self) -> None:
        # A larger residual would say nothing about the answer.
        tolerance = within("tolerance", self.tolerance, "(0, 0.1]")
        object.__setattr__(self, "tolerance", tolerance)
        whole("max_iterations", self.max_iterations, least=1, most=10**7)
        if self.time_limit is not None:
            positive("time_limit", self.time_limit)
        if self.threads is not None:
            whole("threads", self.threads, least=1, most=1024)

    @property
    def workers(self) -> int:
        """Number of threads, resolved."""
        return available_processors() if self.threads is None else self.threads

    def expired(self, began: float) -> bool:
        """Whether the time allowed has passed since `began`, a reading of `time.monotonic`."""
        return self.time_limit is not None and time.monotonic() - began > self.time_limit

    def remaining(self, began: float) -> Settings:
        """Return these settings with the time that is left since `began`."""
        if self.time_limit is None:
            return self
        return replace(self, time_limit=max(self.time_limit - (time.monotonic() - began), 1e-9))


def inner_tolerance(tolerance: float, *, of: float, on: float) -> float:
    """Return a tolerance over one rms height [m] as one over another, in the range of an elastic contact."""
    return min(max(tolerance * (of / on if on > 0 else 1.0), 1e-13), 1e-3)
