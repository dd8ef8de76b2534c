"""One surface in slabs: the answer of one process, for any number of processes; here they are threads."""

from dataclasses import asdict

import h5py
import numpy as np
import pytest
from numpy.testing import assert_allclose
from surfaces import rough_surface
from thread_processes import run_threads

from fem_contact import InvalidInput, Solid, Status, contact_areas, random_surface
from fem_contact.bem import SlabSurface, solve
from fem_contact.complementarity.fourier import FourierOperator
from fem_contact.complementarity.grids import Grids
from fem_contact.complementarity.in_slabs import SlabGrids, SlabIterationArrays, SlabOperator
from fem_contact.complementarity.iteration_arrays import IterationArrays
from fem_contact.complementarity.slabs import Slabs
from fem_contact.response import BondedLayer, FreeHalfSpace, GivenResponse, HalfSpace

SOFT = HalfSpace(solid=Solid(young=1.0, poisson=0.3))
JELLY = BondedLayer(solid=Solid(young=1.0, poisson=0.5), thickness=0.02)
OBLIQUE = GivenResponse(
    contact_modulus=1.0,
    function=lambda qx, qy: 2 / np.sqrt(qx**2 + qx * qy + qy**2 + (qx**2 + qy**2 == 0)) * (qx**2 + qy**2 > 0),
)


def field(shape):
    return rough_surface(shape, (1.0, shape[1] / shape[0]), seed=7, waves=12, longest=4, gradient=1.0)


@pytest.mark.parametrize("count", [2, 3])
@pytest.mark.parametrize(
    ("shape", "response", "load", "bound"),
    [
        ((48, 45), SOFT, 0.05, None),
        ((37, 64), SOFT, 0.6, None),
        ((64, 64), SOFT, 1e-4, None),
        ((64, 56), SOFT, 0.3, "field"),
        ((45, 56), SOFT, 0.599, 0.6),
        ((64, 64), JELLY, 0.05, None),
        ((51, 40), OBLIQUE, 0.1, None),
        ((48, 40), SOFT, 0.6, 0.6),
        ((48, 40), SOFT, 40.0, None),
    ],
)
def test_slabs_give_the_answer_of_one_process(count, shape, response, load, bound):
    surface = field(shape)
    bound = 0.5 + 0.1 * np.random.default_rng(3).random(shape) if bound == "field" else bound
    options = {"mean_pressure": load, "pressure_bound": bound, "tolerance": 1e-13}
    alone = solve(surface, response, threads=1, **options).checked()

    def press(comm):
        result = solve(surface, response, comm=comm, **options).checked()
        return result.whole(), result.areas()

    # Double precision on small grids: what sums in another order leave, through some twenty steps.
    for whole, areas in run_threads(count, press):
        assert np.abs(whole.pressure - alone.pressure).max() < 1e-11 * alone.pressure.max()
        assert np.abs(whole.gap - alone.gap).max() < 1e-11 * surface.rms_height
        assert np.array_equal(whole.in_contact, alone.in_contact)
        assert np.array_equal(whole.at_bound, alone.at_bound)
        assert whole.offset == pytest.approx(alone.offset, abs=1e-11 * surface.rms_height)
        assert abs(whole.cost.iterations - alone.cost.iterations) <= 1
        assert whole.residuals.worst < 1e-12
        expected = contact_areas(alone, subcell=True)
        for name, value in asdict(expected).items():
            assert getattr(areas, name) == pytest.approx(value, rel=1e-10, abs=1e-12), name


@pytest.mark.parametrize("count", [2, 3])
@pytest.mark.parametrize("shape", [(48, 45), (45, 37), (9, 30), (129, 64)])
@pytest.mark.parametrize("bounded", [False, True])
def test_each_pass_over_slabs_is_that_over_the_whole(count, shape, bounded):
    generator = np.random.default_rng(29)
    heights = generator.standard_normal(shape)
    bound = 1 + generator.random(shape) if bounded else None
    fields = [generator.standard_normal(shape) for _ in range(3)]
    force = np.clip(generator.standard_normal(shape), 0, 1)

    def passed(arrays, own):
        arrays.force[...], arrays.step[...], arrays.image[...] = (v[own] for v in (force, *fields[:2]))
        numbers = [*arrays.start(roughly=False), *vars(arrays.place(0.2)).values()]
        numbers += [*vars(arrays.move(0.3, 0.1)).values(), *arrays.precondition()]
        direction = np.where(arrays.working, arrays.buffer, 0)
        arrays.trial(0.4 * heights.size, length=0.7, beta=0.4, shift=0.2)
        numbers += [arrays.slope, arrays.bend(), arrays.room()]
        trial = arrays.step.copy()
        arrays.project(0.4 * heights.size)
        numbers += [arrays.slope, *arrays.advance(0.8)]
        return [np.array(numbers), direction, trial, arrays.force.copy()]

    operator = FourierOperator(JELLY, shape, (1.0, 1.2), threads=1)
    alone = passed(IterationArrays(operator, heights, bound=bound, caution=0.1, threads=1), slice(None))

    def work(comm):
        slabs = Slabs(comm, shape)
        own = slice(slabs.first, slabs.last)
        there = SlabOperator(JELLY, slabs, (1.0, 1.2), threads=1)
        asked = {"bound": None if bound is None else bound[own], "caution": 0.1, "units": None}
        arrays = SlabIterationArrays(there, heights[own].copy(), **asked, threads=1)
        numbers, *found = passed(arrays, own)
        return [numbers, *(slabs.whole(field) for field in found)]

    for found in run_threads(count, work):
        for value, expected in zip(found, alone, strict=True):
            size = np.abs(expected[np.isfinite(expected)]).max()
            assert_allclose(value, expected, rtol=1e-10, atol=1e-11 * size)


@pytest.mark.parametrize("count", [2, 3])
def test_single_precision_in_slabs_differs_by_less_than_the_tolerance(count):
    surface = field((300, 270))
    asked = {"mean_pressure": 0.05, "tolerance": 1e-10}
    alone = solve(surface, SOFT, **asked, threads=1).checked()
    results = run_threads(count, lambda comm: solve(surface, SOFT, **asked, comm=comm).whole())
    assert np.abs(results[0].pressure - alone.pressure).max() < 1e-9 * alone.pressure.max()
    assert np.array_equal(results[0].in_contact, alone.in_contact)


@pytest.mark.parametrize("count", [2, 3])
@pytest.mark.parametrize("shape", [(64, 64), (45, 61), (128, 40), (64, 6)])
def test_fields_are_carried_between_grids_in_slabs_as_between_whole_ones(count, shape):
    values = np.random.default_rng(5).standard_normal(shape)
    half = (-(-shape[0] // 2), -(-shape[1] // 2))
    plain = Grids(shape, threads=1)
    coarse = plain.coarsened(values, shape, half)

    def carry(comm):
        slabs = Slabs(comm, shape)
        grids = SlabGrids(slabs, threads=1)
        own = grids.put(values)
        there = grids.coarsened(own, shape, half)
        kind = grids.slabs_of(half)
        back, below = slabs.whole(grids.refined(there, half, shape)), grids.nearest(own, half)
        there, below = (one if kind is None else kind.whole(one) for one in (there, below))
        return there, back, below

    for there, back, below in run_threads(count, carry):
        assert_allclose(there, coarse, atol=1e-13)
        assert_allclose(back, plain.refined(coarse, half, shape), atol=1e-13)
        assert np.array_equal(below, plain.nearest(values, half))


@pytest.mark.parametrize("count", [1, 3])
@pytest.mark.parametrize("amplitudes", ["exact", "gaussian"])
@pytest.mark.parametrize("isotropic", [True, False])
def test_a_random_surface_made_in_slabs_is_that_made_at_once(count, amplitudes, isotropic):
    options = {"q_short": 2 * np.pi * 11, "lengths": (1.0, 1.5), "shape": (40, 51), "seed": 8}
    options |= {"amplitudes": amplitudes, "isotropic": isotropic}

    def power(qx, qy=0.0):
        return (qx**2 + 2 * qy**2 + 1) ** -2.0

    whole = random_surface(power, **options)

    def make(comm):
        surface = SlabSurface.random(power, comm=comm, **options)
        return surface.slabs.whole(surface.heights), surface.rms_height, surface.rms_gradient

    for heights, rms_height, rms_gradient in run_threads(count, make):
        assert_allclose(heights, whole.heights, atol=1e-13 * whole.rms_height)
        assert rms_height == pytest.approx(whole.rms_height, rel=1e-12)
        assert rms_gradient == pytest.approx(whole.rms_gradient, rel=1e-12)


def test_the_file_of_all_processes_is_that_of_one(tmp_path):
    surface, path = field((37, 44)), tmp_path / "fields.h5"

    def press(comm):
        result = solve(surface, SOFT, mean_pressure=0.1, pressure_bound=0.4, comm=comm)
        result.write(path, about={"scene": "three slabs"})
        return result.whole()

    whole = run_threads(3, press)[0]
    with h5py.File(path) as file:
        assert file.attrs["scene"] == "three slabs"
        for name in ("pressure", "gap", "displacement", "heights", "in_contact", "at_bound"):
            assert np.array_equal(file[name][...], getattr(whole, name)), name
    netcdf = pytest.importorskip("netCDF4")
    with netcdf.Dataset(path) as file:
        assert file["pressure"].dimensions == ("x", "y")
        assert file["pressure"].units == "Pa"
        assert np.array_equal(file["gap"][...], whole.gap)
    assert [entry.name for entry in tmp_path.iterdir()] == ["fields.h5"]


def test_what_cannot_be_shared_is_refused_by_all_in_one_line():
    def press(surface, **options):
        body = options.pop("response", SOFT)
        return lambda comm: solve(surface, body, mean_pressure=0.1, comm=comm, **options)

    with pytest.raises(InvalidInput, match="4 processes: a grid of 7 x 32 points can be shared by 3 at most"):
        run_threads(4, press(field((7, 32))))
    with pytest.raises(InvalidInput, match="comm: runs periodic solids"):
        run_threads(2, press(field((32, 32)), response=FreeHalfSpace(solid=SOFT.solid)))
    with pytest.raises(InvalidInput, match="runs on no device and no MPI"):
        run_threads(2, press(field((32, 32)), method="polonsky-keer"))
    with pytest.raises(InvalidInput, match="square cells only"):
        run_threads(2, lambda comm: press(rough_surface((32, 32), (1.0, 2.0), seed=7, waves=6))(comm).areas())


def test_all_processes_stop_at_the_time_limit_of_the_first():
    surface = field((64, 64))
    asked = {"mean_pressure": 0.1, "time_limit": 1e-6}
    results = run_threads(3, lambda comm: solve(surface, SOFT, **asked, comm=comm).contact.status)
    assert results == [Status.TIME_LIMIT] * 3
