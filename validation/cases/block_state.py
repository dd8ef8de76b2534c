"""What the block returns beside contact, and what is done with results: unloading, shifts, plans."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from fem_contact import bem, block, hardness
from fem_contact.area import ContactAreas, mean_areas, subgrid_shifts
from fem_contact.extrapolation import PlannedGrid, located_limit, perimeter_limit, predicted_uncertainty
from fem_contact.response import HalfSpace
from fem_contact.solid import Solid
from fem_contact.stress import elastic_energy, window_slope
from fem_contact.surface import HeightField, random_surface
from validation.cases import Check, below, case, relative, within
from validation.cases._closed_forms import HertzInPeriod


@case(
    "block-inside",
    "Stress, strain and energy inside the block are those of confined compression, and balance.",
    source="S. P. Timoshenko, J. N. Goodier, Theory of Elasticity",
    tolerance="solver",
)
def _inside() -> Iterator[Check]:
    """Press a block evenly, and a wave flat: confined compression, and equilibrium with the load above."""
    solid, load = Solid(young=2.0, poisson=0.3), 0.01
    flat = HeightField(heights=np.zeros((6, 8)), lengths=(1.0, 1.5))
    for element in ("Hex1", "Hex2"):
        even = block.solve(flat, solid, mean_pressure=load, element=element, depth=1.0, growth=1.5)
        stress = even.stress()
        sideways = -load * 0.3 / 0.7
        worst = float(np.max(np.abs(stress.tensor - [sideways, sideways, -load, 0, 0, 0]))) / load
        # E (1 - nu) / ((1 + nu)(1 - 2 nu)) is the confined modulus.
        strain = load / (2.0 * 0.7 / (1.3 * 0.4))
        sunk = float(np.mean(even.contact.displacement))
        mises = float(np.max(np.abs(stress.von_mises / (load - load * 0.3 / 0.7) - 1)))
        rise = float(np.max(np.abs(even.strain()[..., 2] / -strain - 1)))
        yield below(f"error of the stress over the load, {element}", worst, 1e-9)
        yield below(f"error of von Mises' stress, {element}", mises, 1e-8)
        yield below(f"error of the strain, {element}", rise, 1e-8)
        yield relative(f"displacement [m], {element}", sunk, strain * even.depth, 1e-9)
        yield relative(f"energy [J/m^2], {element}", even.energy, 0.5 * load * strain * even.depth, 1e-9)
    x = np.cos(2 * math.pi * np.arange(24) / 24)
    wave = HeightField(heights=1e-3 * x[:, None] * np.ones(8), lengths=(1.0, 1.0 / 3))
    found = block.solve(wave, solid, mean_pressure=0.05)
    sheared = replace(found.stress(), tensor=np.array([0.0, 0.0, 0.0, 0.0, 0.2, 0.0]))
    carried = float(np.mean(found.stress().tensor[:, :, -1, 2]))
    yield relative("von Mises' stress of simple shear", sheared.von_mises, 0.2 * 3**0.5, 1e-12)
    yield relative("mean vertical stress under the surface [Pa]", carried, -0.05, 1e-9)
    yield relative("energy of the field [J/m^2]", found.equilibrium().energy, found.energy, 1e-9)
    yield below("forces that nothing balances", found.equilibrium().residual, 1e-9)
    yield relative("energy by what is read off [J/m^2]", elastic_energy(found.contact), found.energy, 1e-12)


def _rough(n: int) -> HeightField:
    return random_surface(
        lambda q: 1e-5 * q**-3.6, q_short=40.0, lengths=(1.0, 1.0), shape=(n, n), seed=9_001
    )


@case(
    "block-approach",
    "The block pressed to an approach, or along a path, is the block under that load.",
    source="uniqueness of the elastic solution",
    tolerance="solver",
)
def _approach() -> Iterator[Check]:
    """Press to the approach at which a load stands, and follow a path of loads."""
    solid, surface = Solid(young=1.0, poisson=0.3), _rough(24)
    load = 0.1 * solid.contact_modulus * surface.rms_gradient
    single = block.solve(surface, solid, mean_pressure=load, tolerance=1e-10).contact.checked()
    back = block.solve_displacement(surface, solid, offset=single.offset, tolerance=1e-10).contact.checked()
    path = list(block.solve_path(surface, solid, mean_pressures=[load / 3, load], tolerance=1e-10))
    last = path[-1].contact.checked()
    scale = float(np.linalg.norm(single.pressure))
    yield relative("load at that approach", back.mean_pressure, load, 1e-7)
    yield below(
        "difference of pressure", float(np.linalg.norm(back.pressure - single.pressure)) / scale, 1e-6
    )
    yield below("nodes in contact in one only", np.sum(back.in_contact != single.in_contact), 0)
    yield below(
        "difference from the end of a path",
        float(np.linalg.norm(last.pressure - single.pressure)) / scale,
        1e-6,
    )


@case(
    "yielding-unloading",
    "What has yielded answers elastically up to the load that it yielded under.",
    source="the smoothed surface pressed again",
    tolerance="solver",
)
def _unloading() -> Iterator[Check]:
    """Press until something yields, take the load away, and press again: elastic up to the first load."""
    body, surface = HalfSpace(solid=Solid(young=1.0, poisson=0.3)), _rough(48)
    unit = body.contact_modulus * surface.rms_gradient
    load = 0.15 * unit
    pressed = hardness.press_yielding(
        surface, body, hardness=hardness.Hardness(pressure=0.5 * unit), mean_pressure=load, tolerance=1e-10
    ).checked()
    parts = hardness.yielded(pressed)
    again, lower = hardness.unload(pressed, body, mean_pressures=[load, load / 4], tolerance=1e-10)
    off = float(np.max(np.abs(again.checked().pressure - pressed.pressure))) / unit
    at_bound = float(np.mean(pressed.at_bound))
    yield within("yielded area", parts.plastic_area, 1e-3, 0.3)
    yield relative("yielded area, counted", parts.plastic_area, at_bound, 1e-12)
    yield relative(
        "elastic area, counted", parts.elastic_area, float(pressed.in_contact.mean()) - at_bound, 1e-12
    )
    yield relative("load of what yielded", parts.plastic_load, 0.5 * unit * at_bound, 1e-7)
    yield relative("both loads", parts.plastic_load + parts.elastic_load, load, 1e-7)
    yield relative(
        "indented volume",
        parts.volume,
        np.mean(np.maximum(-pressed.gap, 0) * pressed.at_bound),
        1e-12,
    )
    yield below("largest difference of p, pressed again, over E* h'_rms", off, 1e-6)
    yield relative("load after unloading", lower.checked().mean_pressure, load / 4, 1e-7)
    yield below("yielded on the way back", np.mean(lower.at_bound), 0)


@case(
    "results-planned",
    "Shifts are averaged, grids planned and slopes of P(sigma) read off as they should.",
    source="Persson 2006, Eq. 23 for Hertz's contact",
    tolerance="estimate",
)
def _planned() -> Iterator[Check]:
    """Average shifts, plan grids, and start P(sigma): Hertz's contact has a slope in closed form."""
    case, n = HertzInPeriod(radius=0.2), 192
    body = HalfSpace(solid=Solid(young=1.0, poisson=0.0))
    found = bem.solve(case.surface(n), body, mean_pressure=case.load).checked()
    # P = 2 pi a^2 sigma / peak^2, with peak = 2 E* a / (pi R), in units of E* h'.
    stress = HeightField(heights=found.heights, lengths=(1.0, 1.0)).rms_gradient
    slope = 2 * math.pi * case.radius**2 / case.peak**2
    window = 0.2 * case.peak / stress, 0.8 * case.peak / stress
    start = window_slope(found, window=window)
    shifts = np.array(subgrid_shifts(3))
    areas = [
        ContactAreas(
            pixel=0.2 + d,
            perimeter=0.19 + d,
            edge_length=5.0,
            edge_fraction=0.08,
            edge_constant=0.1,
            spacing=(1 / 64, 1 / 64),
            subcell=0.18 + 2 * d,
            cells=64**2,
        )
        for d in (-0.003, 0.001, 0.005)
    ]
    mean = mean_areas(areas)
    plan = [PlannedGrid(spacing=(1 / 64, 1 / 64), cells=64**2, solves=3)]
    claimed = located_limit(areas).uncertainty
    line = [0.2 + 0.01 * 2.56 / points for points in (32, 64, 128)]
    corrected = perimeter_limit(
        [
            ContactAreas(
                pixel=value + 0.1 * 2.56 / points,
                perimeter=value,
                edge_length=2.56,
                edge_fraction=2.56 / points,
                edge_constant=0.1,
                spacing=(1 / points, 1 / points),
                cells=10**6 * points**2,
            )
            for value, points in zip(line, (32, 64, 128), strict=True)
        ]
    )
    # Six bins between .2 and .8 of the peak, some 2800 points: 2 %.
    yield relative("slope of P(sigma) of Hertz's contact", start.slope, slope, 0.05)
    yield relative("shifts fill a cell: mean along x", shifts[:, 0].mean(), 1 / 3, 1e-12)
    yield relative("mean counted area of shifts", mean.pixel, 0.201, 1e-12)
    yield relative("mean located area of shifts", mean.subcell or 0.0, 0.182, 1e-12)
    yield relative(
        "uncertainty planned is uncertainty claimed", predicted_uncertainty(mean, plan), claimed, 1e-9
    )
    # All but what the second order might be, .01 of the width of the contact.
    yield relative("limit of corrected areas, linear in the edges", corrected.value, 0.2, 2e-4)
    yield relative("excess per edge that is left", corrected.edge_constant, 0.01, 0.05)
