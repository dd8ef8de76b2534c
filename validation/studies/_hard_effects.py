"""Further hard cases: single precision, yielding elements, yielding under adhesion, and blocks beyond memory."""

from __future__ import annotations

import math

import numpy as np

from fem_contact import bem
from fem_contact.contact import ContactResult
from fem_contact.response import BondedLayer, HalfSpace
from fem_contact.solid import Solid
from fem_contact.surface import HeightField, random_surface
from validation.studies._hard_cases import HardCase, Measured

__all__ = ["MORE_CASES"]

_HALF = HalfSpace(solid=Solid(young=1.0, poisson=0.0))
_LOAD = 0.01


def _rough(points: int, *, waves: int) -> HeightField:
    surface = random_surface(
        lambda q: q**-3.6, q_short=waves * 2 * np.pi, lengths=(1.0, 1.0), shape=(points, points), seed=41
    )
    return HeightField(heights=surface.heights * (0.1 / surface.rms_gradient), lengths=(1.0, 1.0))


def _judged(result: ContactResult, error: float) -> Measured:
    return Measured(error=error, residual=result.residuals.worst, status=result.status)


def _single(height: float) -> Measured:
    """Heights stored in single precision on top of a mean height, preconditioned in single precision."""
    exact = _rough(64, waves=8)
    mean = height * exact.rms_height
    stored = (exact.heights + mean).astype(np.float32).astype(float)
    double = bem.solve(exact, _HALF, mean_pressure=0.005, threads=1)
    single = bem.solve(
        HeightField(heights=stored, lengths=(1.0, 1.0)),
        _HALF,
        mean_pressure=0.005,
        method="mixed",
        threads=1,
    )
    # Contact is monotone: no offset moves by more than the heights did, nor by more than the solver leaves.
    allowed = float(np.max(np.abs(stored - exact.heights - mean))) + 1e-7 * exact.rms_height
    return _judged(single, abs(single.offset - mean - double.offset) / allowed)


def _books(result: ContactResult, hardness: float) -> float:
    """By how much loads and bound are missed, relative to the load and the hardness."""
    from fem_contact.hardness import yielded

    found = yielded(result)
    missed = abs(found.elastic_load + found.plastic_load - _LOAD) / _LOAD
    missed = max(missed, abs(found.plastic_load - hardness * found.plastic_area) / _LOAD)
    return max(missed, float(np.max(result.pressure)) / hardness - 1, 0.0)


def _yielding_block(ratio: float) -> Measured:
    """Active set of the full system against the reduction, which knows no active set."""
    from fem_contact import block

    full, reduced = (
        block.solve(
            _rough(16, waves=4),
            Solid(young=1.0, poisson=0.3),
            mean_pressure=_LOAD,
            pressure_bound=ratio * _LOAD,
            method=method,
            tolerance=1e-9,
            depth=0.3,
            growth=1.5,
        ).contact
        for method in ("full", "reduced")
    )
    difference = np.linalg.norm(full.pressure - reduced.pressure) / np.linalg.norm(reduced.pressure)
    return _judged(full, max(float(difference), _books(full, ratio * _LOAD)))


def _yielding_under_adhesion(ratio: float) -> Measured:
    """Hardness over the mean pressure under a law of the gap as strong as the contact's own stresses."""
    from fem_contact import adhesion
    from fem_contact.adhesion.laws import Exponential

    work, points = 1e-4, 64
    state = adhesion.solve(
        _rough(points, waves=8),
        _HALF,
        law=Exponential(work=work, reach=math.sqrt(3 / points * work)),
        hardness=ratio * _LOAD,
        mean_pressure=_LOAD,
        tolerance=1e-10,
        threads=1,
    )
    return _judged(state.contact, _books(state.contact, ratio * _LOAD))


def _large_block(points: float) -> Measured:
    """Full contact on one wave by the full system, against the bonded layer."""
    from fem_contact import block

    n, depth, solid = int(points), 0.3, Solid(young=1.0, poisson=0.3)
    x = np.cos(2 * np.pi * np.arange(n) / n)
    exact = 0.01 / float(
        BondedLayer(solid=solid, thickness=depth).compliance(np.array([2 * np.pi]), np.zeros(1))[0]
    )
    contact = block.solve(
        HeightField(heights=0.01 * x[:, None] * np.ones(n), lengths=(1.0, 1.0)),
        solid,
        mean_pressure=1.5 * exact,
        method="full",
        depth=depth,
        growth=1.1,
    ).contact
    found = 2 * float(np.mean(contact.pressure[:, 0] * x))
    # Trilinear cells err with the square of the spacing, by 2 % at 32 nodes per wave.
    return _judged(contact, abs(found / exact - 1) / (0.02 * (32 / n) ** 2))


MORE_CASES = (
    HardCase(
        name="single",
        method="bem",
        dial="mean height over h_rms, heights in single precision",
        values=(0.0, 1.0, 10.0, 100.0, 1e3, 1e4, 1e5, 1e6),
        reference="offset of the heights in double; change over that of the heights",
        bound=1.0,
        measure=_single,
    ),
    HardCase(
        name="yielding-block",
        method="fem",
        dial="H / p0, from hard to barely carrying",
        values=(1e4, 100.0, 10.0, 3.0, 1.5, 1.1, 1.01, 1.001, 1.0, 0.99),
        reference="active set against reduction, relative L2 of the pressure; loads add up",
        bound=1e-6,
        limit="below 1 nothing carries the load",
        refusable=lambda value: value < 1,
        measure=_yielding_block,
    ),
    HardCase(
        name="yielding-adhesion",
        method="bem",
        dial="H / p0 under adhesion, from hard to barely carrying",
        values=(1e4, 100.0, 10.0, 3.0, 1.5, 1.1, 1.01, 1.001, 1.0, 0.99),
        reference="loads add up, none above the bound; relative to load and bound",
        # The imbalance asked for is 1e-10 of the law's strength, which is some seven times the load.
        bound=1e-8,
        limit="at 1 and below nothing carries the load",
        refusable=lambda value: value <= 1,
        measure=_yielding_under_adhesion,
    ),
    HardCase(
        name="memory",
        method="fem",
        dial="points along a side of the full system",
        values=(8.0, 16.0, 32.0, 1024.0, 2048.0),
        reference="bonded layer, one wave in full contact; error over 2 % (32/n)^2",
        bound=1.0,
        limit="from 1024 on the assembled block takes hundreds of gigabytes",
        refusable=lambda value: value >= 1024,
        measure=_large_block,
    ),
)
