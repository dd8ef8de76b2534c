"""Contact in time on a viscoelastic half-space: exact answers, an independent integral, refusals."""

import itertools

import numpy as np
import pytest

from fem_contact import HalfSpace, HeightField, PronySolid, Solid, bem, creep, random_surface

RUBBER = PronySolid(relaxed=1.0, moduli=(3.0, 0.0, 4.0, 2.0), times=(0.1, 0.5, 1.0, 10.0), poisson=0.3)


def rough(n):
    lengths = (1.0, 1.0)
    return random_surface(lambda q: 1e-6 * q**-3.6, q_short=50.3, lengths=lengths, shape=(n, n), seed=7)


def load_of(surface):
    return 0.1 * surface.rms_gradient / (1 - 0.3**2)


def elastic(surface, young, load):
    response = HalfSpace(solid=Solid(young=young, poisson=0.3))
    return bem.solve(surface, response, mean_pressure=load, tolerance=1e-10).checked()


def test_creep_and_relaxation_belong_to_one_solid():
    t = np.linspace(0, 5, 100001)
    compliance = RUBBER.creep_compliance(t)
    modulus = 1 + 3 * np.exp(-t / 0.1) + 4 * np.exp(-t) + 2 * np.exp(-t / 10)
    rest = np.sum((modulus[-2::-1] + modulus[:0:-1]) / 2 * np.diff(compliance))
    assert compliance[0] * modulus[-1] + rest == pytest.approx(1.0, abs=1e-7)
    # A standard solid, by its retardation time.
    solid = PronySolid.standard(relaxed=1.0, unrelaxed=20.0, time=0.7, poisson=0.3)
    assert solid.creep_compliance(1.1) == pytest.approx(0.05 + 0.95 * -np.expm1(-1.1 / 0.7), rel=1e-12)
    assert PronySolid(relaxed=2.0, moduli=(0.0,), times=(1.0,), poisson=0.3).creep_compliance([3.0]) == 0.5


def test_under_a_load_that_does_not_fall_the_area_is_elastic_and_the_error_of_order_two():
    surface = rough(64)
    load = load_of(surface)
    exact = elastic(surface, 1 / RUBBER.creep_compliance(2.0), load)
    errors = []
    for steps in (8, 16, 32):
        path = creep(surface, RUBBER, times=np.linspace(0, 2, steps + 1), mean_pressure=load, tolerance=1e-10)
        assert all(result.checked() for result in path)
        assert not any((a.in_contact & ~b.in_contact).any() for a, b in itertools.pairwise(path))
        errors.append(abs(path[-1].offset - exact.offset) / surface.rms_height)
    assert (path[-1].in_contact == exact.in_contact).mean() > 0.999
    assert errors[2] < 2e-4
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2, abs=0.15)
    assert np.log2(errors[1] / errors[2]) == pytest.approx(2, abs=0.15)


def test_after_the_load_fell_the_solid_remembers_as_the_integral_over_its_past_says():
    """The creep integral over pressures, without stresses of terms, and of order two as well."""
    surface = rough(48)
    load = load_of(surface)
    times = np.concatenate([np.linspace(0, 1, 41), np.linspace(1, 2, 41)])
    loads = np.where(np.arange(82) < 41, load, load / 2)
    path = creep(surface, RUBBER, times=times, mean_pressure=loads, tolerance=1e-10)
    shape, modes = surface.shape, [np.fft.fftfreq(n, 1 / n) * 2 * np.pi for n in surface.shape]
    wave = np.hypot(modes[0][:, None], modes[1][None, :])
    response = np.where(wave > 0, 2 * (1 - 0.3**2) / np.where(wave > 0, wave, 1.0), 0.0)
    changes, middles = [], []
    for k, (time, p0) in enumerate(zip(times, loads, strict=True)):
        middle = time if k == 0 else (times[k - 1] + time) / 2
        now = float(RUBBER.creep_compliance(time - middle))
        weights = [float(RUBBER.creep_compliance(time - when)) for when in middles]
        past = sum(weight * change for weight, change in zip(weights, changes, strict=True))
        before = np.sum(changes, axis=0) if changes else np.zeros(shape)
        kept = np.fft.ifft2(response * np.fft.fft2(past - now * before)).real if changes else 0.0
        heights = HeightField(heights=surface.heights - kept, lengths=surface.lengths)
        contact = elastic(heights, 1 / now, p0)
        changes.append(contact.pressure - before)
        middles.append(middle)
    last = path[-1].checked()
    assert np.abs(last.pressure - contact.pressure).max() < 5e-3 * contact.pressure.max()
    assert last.offset == pytest.approx(contact.offset, abs=1e-3 * surface.rms_height)
    assert last.in_contact.mean() == pytest.approx(contact.in_contact.mean(), rel=0.01)
    # It touches more than if it had carried the load that is left all the time.
    never_more = elastic(surface, 1 / RUBBER.creep_compliance(2.0), load / 2)
    assert last.in_contact.mean() > 1.02 * never_more.in_contact.mean()
    displacement = np.fft.ifft2(response * np.fft.fft2(path[0].pressure)).real / RUBBER.unrelaxed
    assert np.abs(path[0].displacement - displacement).max() < 1e-6 * surface.rms_height


@pytest.mark.parametrize(("step", "young"), [(1e-9, 10.0), (1e9, 1.0)])
def test_very_fast_and_very_slow_loads_meet_the_glassy_and_the_relaxed_solid(step, young):
    surface = rough(32)
    loads = load_of(surface) * np.array([0.3, 1.0, 0.5])
    path = creep(surface, RUBBER, times=step * np.arange(3), mean_pressure=loads, tolerance=1e-10)
    for result, load in list(zip(path, loads, strict=True))[1:]:
        still = elastic(surface, young, load)
        assert np.abs(result.pressure - still.pressure).max() < 1e-6 * still.pressure.max()
