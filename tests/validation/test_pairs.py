"""Areas of pairs of surfaces in blocks: those of single solves, under every load, located or corrected."""

import math
from dataclasses import replace

import numpy as np
import pytest

from fem_contact.area import EDGE_CONSTANTS, contact_areas
from validation.effects.hardness import Hardness
from validation.execution.press import Press
from validation.measurements.common import base_surface
from validation.measurements.control_variates import unsolved_pairs, unsolved_statistics
from validation.measurements.ensemble import area_pairs
from validation.measurements.measurement import area_limits, limit_over, press_on_grids
from validation.scenes.problem import ContactProblem
from validation.scenes.tables import Load, SolidSpec

GRIDS = ((24, 24), (36, 36))


def base(load):
    surface = base_surface(hurst=0.6, periods=2.0, bandwidth=3.0, seed=515)
    surface = surface.model_copy(update={"amplitudes": "gaussian"})
    return ContactProblem(surface=surface, solid=SolidSpec(young=2e9, poisson=0.3), load=load)


@pytest.mark.parametrize("load", [Load(reduced_pressure=0.2), Load(pressure=4e7), Load(force=40.0)])
@pytest.mark.parametrize("effects", [(), (Hardness(hardness=1.5e8),)])
def test_a_block_reads_the_areas_of_each_surface_and_its_mirror_image(load, effects):
    case = area_pairs(problem=base(load), grids=GRIDS, first=7, count=2, tolerance=1e-7, effects=effects)
    areas = case.do()
    limits, _ = area_limits(areas)
    for k, inverted in ((0, False), (1, True), (2, False), (3, True)):
        surface = replace(base(load).further(7 + k // 2), inverted=inverted)
        own = []
        for i, grid in enumerate(GRIDS):
            settings = (("tolerance", 1e-7),)
            press = Press(method="bem", grid=grid, problem=surface, settings=settings, effects=effects)
            told = {"edge_constant": EDGE_CONSTANTS["bem"], "subcell": not effects}
            own.append(contact_areas(press.do(threads=1).contact, **told))
            read = areas.isel(grid=i, shift=0, load=k)
            assert read.perimeter.item() == pytest.approx(own[-1].perimeter, rel=1e-9)
            located = math.nan if effects else own[-1].subcell
            assert read.subcell.item() == pytest.approx(located, rel=1e-9, nan_ok=True)
        assert limits[k] == pytest.approx(limit_over(own).value, rel=1e-9)
    # Neighbours in the list are no copies of each other.
    assert len(set(np.round(limits, 9))) == 4


def test_the_statistics_of_a_block_are_those_of_its_surfaces():
    problem = base(Load(reduced_pressure=0.2))
    looked = unsolved_pairs(problem=problem, grid=GRIDS[0], first=3, count=3).do()
    fields = [problem.further(k).heights(GRIDS[0]) for k in (3, 4, 5)]
    each = [unsolved_statistics(field) | {"h'_rms": field.rms_gradient} for field in fields]
    np.testing.assert_allclose(looked.value, [list(one.values()) for one in each], rtol=1e-12)
    names = looked.attrs["statistics"].split("; ")
    assert names == list(each[0])
    assert names[-1] == "h'_rms"
    # Random amplitudes scatter it.
    assert np.ptp(looked.value.values[:, -1]) > 0.005


def test_the_name_of_a_block_tells_loads_effects_and_surfaces_apart():
    problem = base(Load(reduced_pressure=0.2))
    usual = area_pairs(problem=problem, grids=GRIDS, first=0, count=2, tolerance=1e-6, effects=())
    others = {"first": 2, "count": 4, "grids": GRIDS[:1], "tolerance": 1e-5}
    others |= {"problem": base(Load(pressure=4e7)), "effects": (Hardness(hardness=1.5e8),)}
    keys = {usual.but(**{name: value}).key for name, value in others.items()}
    assert len({usual.key, *keys}) == 7
    assert 2 * usual.predict().seconds == pytest.approx(usual.but(count=4).predict().seconds)
    one = press_on_grids(problem=problem, grids=GRIDS, effects=(), shifts=1)
    assert usual.predict().seconds == pytest.approx(2 * 2 * one.predict().seconds)
