"""Hard cases of the finite elements: Poisson ratio, flat cells, depth, yielding, blocks beyond memory."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from fem_contact.response import BondedLayer
from fem_contact.solid import Solid
from validation.measurements.hard_cases.cases import HardCase, Measured, judged, load_errors, rough, wave

_LOAD = 0.01


def _full_contact(points: int, *, poisson: float = 0.3, depth: float = 1.0, **settings: Any) -> Measured:
    from fem_contact import block

    surface, solid = wave(points, rows=points), Solid(young=1.0, poisson=poisson)
    layer = BondedLayer(solid=solid, thickness=depth)
    exact = 0.01 / float(layer.compliance(np.array([2 * np.pi]), np.zeros(1))[0])
    contact = block.solve(
        surface, solid, mean_pressure=1.5 * exact, depth=depth, growth=1.1, **settings
    ).contact
    cosine = np.cos(2 * np.pi * np.arange(points) / points)
    amplitude = 2 * float(np.mean(contact.pressure[:, 0] * cosine))
    return judged(contact, abs(amplitude / exact - 1))


def _large_block(points: float) -> Measured:
    """Full contact on one wave by the full system; trilinear cells err with the square of the spacing, by 2 % at 32."""
    amplitude = _full_contact(int(points), depth=0.3, method="full")
    return replace(amplitude, error=amplitude.error / (0.02 * (32 / points) ** 2))


def _yielding_block(ratio: float) -> Measured:
    from fem_contact import block

    full, reduced = (
        block.solve(
            rough(16, waves=4),
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
    return judged(full, max(float(difference), load_errors(full, load=_LOAD, hardness=ratio * _LOAD)))


BLOCKS = (
    HardCase(
        name="poisson",
        method="fem",
        varied="nu",
        values=(-0.5, 0.0, 0.3, 0.45, 0.49, 0.499, 0.4999, 0.499999, 0.5, 0.51),
        limit="above 1/2 there is no such solid",
        refusable=lambda value: value > 0.5,
        reference="bonded layer, wave of 32 nodes in full contact; relative",
        bound=0.02,
        measure=lambda nu: _full_contact(32, poisson=nu),
    ),
    HardCase(
        name="aspect",
        method="fem",
        varied="width of a surface cell over its height",
        values=(1.0, 3.0, 10.0, 100.0, 1000.0, 1e4),
        reference="bonded layer, wave of 32 nodes in full contact; relative",
        bound=0.02,
        measure=lambda aspect: _full_contact(32, first_layer=1 / 32 / aspect),
    ),
    HardCase(
        name="depth",
        method="fem",
        varied="depth of the block over its period",
        values=(10.0, 3.0, 1.0, 0.3, 0.1, 0.03, 0.01),
        reference="bonded layer of that depth, wave of 32 nodes in full contact; relative",
        bound=0.02,
        measure=lambda depth: _full_contact(32, depth=depth),
    ),
)

YIELDING_BLOCK = HardCase(
    name="yielding-block",
    method="fem",
    varied="H / p0, from hard to barely carrying",
    values=(1e4, 100.0, 10.0, 3.0, 1.5, 1.1, 1.01, 1.001, 1.0, 0.99),
    reference="active set against reduction, relative L2 of the pressure; loads add up",
    bound=1e-6,
    limit="below 1 nothing carries the load",
    refusable=lambda value: value < 1,
    measure=_yielding_block,
)

LARGE_BLOCK = HardCase(
    name="memory",
    method="fem",
    varied="points along a side of the full system",
    values=(8.0, 16.0, 32.0, 4096.0, 8192.0),
    reference="bonded layer, one wave in full contact; error over 2 % (32/n)^2",
    bound=1.0,
    limit="from 4096 on the block takes hundreds of gigabytes",
    refusable=lambda value: value >= 4096,
    measure=_large_block,
)
