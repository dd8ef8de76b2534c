"""The iteration in plain array operations: the answers of the compiled passes, in any library."""

from typing import Any

import numpy as np
import pytest
from surfaces import rough_surface

from fem_contact import BondedLayer, HalfSpace, HeightField, Solid
from fem_contact.bem import solve
from fem_contact.complementarity.arrays import ArrayGrids, PlainIterationArrays
from fem_contact.complementarity.fourier import FourierOperator
from fem_contact.complementarity.grids import Grids
from fem_contact.complementarity.iteration_arrays import IterationArrays

SOLID = Solid(young=1.0, poisson=0.3)
LIBRARIES = ("numpy", "array_api_strict", "torch")


def place(library):
    pytest.importorskip("numpy" if library == "numpy" else "array_api_compat")
    return pytest.importorskip(library).zeros(1)


@pytest.mark.parametrize("library", LIBRARIES)
@pytest.mark.parametrize(
    ("shape", "response", "load", "bound"),
    [
        ((48, 45), HalfSpace(solid=SOLID), 0.05, None),
        ((64, 64), HalfSpace(solid=SOLID), 1e-4, None),
        ((37, 64), HalfSpace(solid=SOLID), 0.6, None),
        ((1, 41), HalfSpace(solid=SOLID), 0.1, None),
        ((64, 56), HalfSpace(solid=SOLID), 0.3, 0.6),
        ((64, 56), HalfSpace(solid=SOLID), 0.599, 0.6),
        ((48, 40), BondedLayer(solid=SOLID, thickness=0.06), 0.1, None),
    ],
)
def test_plain_arrays_give_the_answer_of_the_compiled_passes(library, shape, response, load, bound):
    there = place(library)
    surface = rough_surface(shape, (1.0, shape[1] / shape[0]), seed=7, waves=12, longest=4, gradient=1.0)
    options = {"mean_pressure": load, "pressure_bound": bound, "tolerance": 1e-13}
    compiled = solve(surface, response, **options).checked()
    plain = solve(surface, response, device=there, **options).checked()
    assert np.linalg.norm(plain.pressure - compiled.pressure) < 1e-10 * np.linalg.norm(compiled.pressure)
    assert np.array_equal(plain.in_contact, compiled.in_contact)
    assert np.array_equal(plain.at_bound, compiled.at_bound)
    assert plain.offset == pytest.approx(compiled.offset, abs=1e-10 * surface.rms_height)
    assert abs(plain.cost.iterations - compiled.cost.iterations) <= 2


@pytest.mark.parametrize("units", [None, (3.0, 0.25)], ids=["double", "single"])
@pytest.mark.parametrize("bounded", [False, True])
@pytest.mark.parametrize("shape", [(16, 16), (13, 10), (1, 12), (70, 33)])
def test_each_pass_is_the_twin_of_the_compiled_one(shape, bounded, units):
    generator = np.random.default_rng(29)
    heights = generator.standard_normal(shape)
    bound = 1 + generator.random(shape) if bounded else None
    steps, images, forces = (generator.standard_normal(shape) for _ in range(3))
    forces = np.clip(forces, 0, 1.5 if bound is None else bound)
    operator = FourierOperator(HalfSpace(solid=SOLID), shape, (1.0, shape[1] / shape[0]), threads=1)
    caution = 0.1 / operator.stiffness
    asked, answers = {"bound": bound, "caution": caution}, []
    compiled = IterationArrays(operator, heights, **asked, units=units, threads=2)
    for arrays in (compiled, PlainIterationArrays(operator, heights, **asked)):
        force, length = arrays.force_unit, arrays.length_unit
        work = force * length
        sums, errors = (force, work), (work, force, length, length, force, force, work)
        arrays.force[...] = forces
        found: list[Any] = [np.array(arrays.start(roughly=True)) * sums]
        arrays.step[...], arrays.image[...] = steps / force, images / length
        found.append(np.array(arrays.start(roughly=False)) * sums)
        found.append(np.array(list(vars(arrays.place(0.2 / length)).values())) * errors)
        found.append(np.array(list(vars(arrays.move(0.3, 0.1 / length)).values())) * errors)
        found.append(np.array(arrays.precondition()) * sums)
        found.append(np.where(arrays.working, arrays.buffer, 0) * force)
        arrays.trial(0.4 * heights.size / force, length=0.7, beta=0.4, shift=0.2)
        found.extend((arrays.step * force, arrays.slope * work))
        arrays.project(0.4 * heights.size / force)
        found.extend((arrays.step * force, arrays.slope * work))
        found.extend((arrays.bend() * work, arrays.room(), np.array(arrays.advance(0.8)) * sums))
        found.extend((arrays.force.copy(), arrays.gap * length, arrays.image * length))
        # A whole step ends at its bounds, not beside them.
        arrays.force[...] = forces
        arrays.advance(1.0)
        found.append(arrays.force == (0 if bound is None else bound))
        answers.append(found)
    digits = 1e-11 if units is None else 2e-5
    for compiled, plain in zip(*answers, strict=True):
        # A field is rounded by its peak; sums over points cancel.
        size = np.abs(plain).max() / 10 if np.ndim(plain) == 2 else max(0.01 * heights.size, 1)
        rounded = digits * size
        np.testing.assert_allclose(compiled, plain, rtol=digits, atol=rounded)


@pytest.mark.parametrize("library", LIBRARIES)
@pytest.mark.parametrize("shape", [(24, 20), (45, 61), (1, 40)])
def test_fields_are_carried_between_grids_as_by_numpy(library, shape):
    coarse = (-(-shape[0] // 2), -(-shape[1] // 2))
    surface = HeightField(heights=np.random.default_rng(9).standard_normal(shape), lengths=(1.0, 1.7))
    plain, there = Grids(shape, threads=1), ArrayGrids(place(library), shape, threads=1)
    heights = there.put(surface.heights)
    assert there.rms_gradient(surface, heights) == pytest.approx(surface.rms_gradient, rel=1e-12)
    smooth = plain.coarsened(surface.heights, shape, coarse)
    size = surface.rms_height
    for field, expected in (
        (there.coarsened(heights, shape, coarse), smooth),
        (there.refined(there.put(smooth), coarse, shape), plain.refined(smooth, coarse, shape)),
        (there.nearest(heights, coarse), plain.nearest(surface.heights, coarse)),
    ):
        np.testing.assert_allclose(there.fetched_field(field), expected, atol=1e-13 * size)


@pytest.mark.parametrize("library", LIBRARIES)
def test_nothing_but_the_answer_is_fetched(library, monkeypatch):
    there, fetched, fetch = place(library), [], ArrayGrids.fetched_field
    noted = lambda self, field: fetched.append(field.shape) or fetch(self, field)  # noqa: E731
    monkeypatch.setattr(ArrayGrids, "fetched_field", noted)
    surface = rough_surface((64, 56), (1.0, 56 / 64), seed=7, waves=12, longest=4, gradient=1.0)
    for load, bound in ((0.1, None), (0.3, 0.6), (0.6, 0.6), (40.0, None)):
        fetched.clear()
        asked = {"mean_pressure": load, "pressure_bound": bound, "device": there}
        solve(surface, HalfSpace(solid=SOLID), **asked).checked()
        assert fetched == [surface.shape] * 5, "pressure, displacement, gap and two sets, once"
