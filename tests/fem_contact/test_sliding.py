"""Steady sliding on a viscoelastic half-space: known answers, limits, and what is refused."""

import numpy as np
import pytest

from fem_contact import GivenResponse, HeightField, InvalidInput, NotConverged, Status, bem, slide
from fem_contact.surface import random_surface
from fem_contact.viscoelastic import PronySolid, TabulatedSolid

Q = 2 * np.pi


def rough(n, ratio=8, seed=7):
    waves = {"q_short": ratio * Q * (1 + 1e-9), "lengths": (1.0, 1.0)}
    return random_surface(lambda q: 1e-6 * q**-3.6, **waves, shape=(n, n), seed=seed)


def standard(ratio, *, time=1.0, poisson=0.3):
    return PronySolid.standard(relaxed=1.0, unrelaxed=ratio, time=time, poisson=poisson)


def load_of(surface, reduced=0.1):
    return reduced * surface.rms_gradient / (1 - 0.3**2)


@pytest.mark.parametrize("velocity", [1e-9, 0.0, 1e9, -1e9])
def test_slow_and_fast_sliding_are_elastic_contacts(velocity):
    """Waves along the motion stay relaxed at any velocity: a point of a period never leaves them."""
    surface = rough(32)
    load = load_of(surface)
    young = 20.0 if abs(velocity) > 1 else 1.0

    def compliance(qx, qy):
        q = np.hypot(qx, qy)
        modulus = np.where(qx == 0, 1.0, young) / (1 - 0.3**2)
        return np.where(q > 0, 2 / (modulus * np.where(q > 0, q, 1.0)), 0.0)

    response = GivenResponse(contact_modulus=1 / (1 - 0.3**2), function=compliance)
    found = slide(surface, standard(20.0), velocity=velocity, mean_pressure=load, tolerance=1e-11).checked()
    elastic = bem.solve(surface, response, mean_pressure=load, tolerance=1e-11).checked()
    assert np.abs(found.contact.pressure - elastic.pressure).max() < 1e-6 * elastic.pressure.max()
    assert abs(found.contact.offset - elastic.offset) < 1e-6 * surface.rms_height
    assert abs(found.dissipation) < 1e-6


@pytest.mark.parametrize("velocity", [1e-3, 1e-2, 0.1, 1.0, 10.0])
def test_a_thousandfold_modulus_is_solved_and_the_conditions_hold(velocity):
    surface = rough(48)
    load = load_of(surface)
    found = slide(surface, standard(1000.0), velocity=velocity, mean_pressure=load).checked()
    contact = found.contact
    # Judged here by another road: the response applied as a full complex transform.
    q = Q * np.fft.fftfreq(48, 1 / 48)
    modulus = np.array([complex(standard(1000.0).modulus(abs(k) * velocity)) for k in q])
    modulus = np.where(q > 0, modulus.conj(), modulus)
    with np.errstate(divide="ignore", invalid="ignore"):
        response = 2 * (1 - 0.3**2) / (np.hypot(q[:, None], q[None, :]) * modulus[:, None])
    response[0, 0], response[24] = 0, response[24].real
    gap = np.fft.ifft2(response * np.fft.fft2(contact.pressure)).real - surface.heights + contact.offset
    assert contact.pressure.min() >= 0
    assert contact.pressure.mean() == pytest.approx(load, rel=1e-12)
    assert gap.min() > -1e-7 * surface.rms_height
    assert np.sum(contact.pressure * np.abs(gap)) < 2e-8 * surface.rms_height * np.sum(contact.pressure)


@pytest.mark.parametrize("velocity", [0.03, 0.3, 30.0])
def test_the_interval_of_friction_holds_that_of_a_finer_grid(velocity):
    """At v tau/L = 30 and 8 points per shortest wave the slopes say a quarter of it."""
    load = load_of(rough(32))
    found = [slide(rough(n), standard(100.0), velocity=velocity, mean_pressure=load) for n in (32, 64, 192)]
    coarse, middle, fine = found
    for one in (coarse, middle):
        low, high = one.friction_interval
        assert low < fine.friction < high
        assert one.friction == pytest.approx((low + high) / 2)
    widths = [one.friction_interval[1] - one.friction_interval[0] for one in found]
    assert widths[2] < widths[1] / 2 < widths[0] / 2
    assert widths[2] < 0.05 * fine.friction
    if velocity == 30.0:
        assert middle.friction == pytest.approx(fine.friction, rel=0.03)
        assert middle.slopes < 0.5 * fine.friction


def test_sliding_backwards_is_the_mirror_image():
    surface = rough(32)
    mirrored = HeightField(heights=np.roll(surface.heights[::-1], 1, axis=0), lengths=(1.0, 1.0))
    load = load_of(surface)
    ahead = slide(surface, standard(10.0), velocity=0.05, mean_pressure=load, tolerance=1e-10)
    back = slide(mirrored, standard(10.0), velocity=-0.05, mean_pressure=load, tolerance=1e-10)
    assert back.friction == pytest.approx(ahead.friction, rel=1e-7)
    assert ahead.friction > 0
    turned = np.roll(back.contact.pressure[::-1], 1, axis=0)
    assert np.abs(turned - ahead.contact.pressure).max() < 1e-6 * ahead.contact.pressure.max()


def test_a_start_shortens_the_way_and_changes_nothing_else():
    surface, solid = rough(32), standard(100.0)
    load = load_of(surface)
    first = slide(surface, solid, velocity=0.1, mean_pressure=load)
    again = slide(surface, solid, velocity=0.1, mean_pressure=2 * load, start=first.contact.pressure)
    alone = slide(surface, solid, velocity=0.1, mean_pressure=2 * load)
    assert again.friction == pytest.approx(alone.friction, rel=1e-6)
    same = slide(surface, solid, velocity=0.1, mean_pressure=load, start=first.contact.pressure)
    assert same.contact.cost.iterations < first.contact.cost.iterations / 2


def test_accelerated_steps_that_do_not_pay_are_taken_back(monkeypatch):
    """With an acceleration that leads astray each time the plain steps still arrive."""
    from fem_contact import sliding

    class Astray(sliding._Acceleration):
        def after(self, point, step):
            super().after(point, step)
            return point - 3 * step if self.active else point + step

    monkeypatch.setattr(sliding, "_Acceleration", Astray)
    surface = rough(24)
    found = slide(surface, standard(10.0), velocity=0.05, mean_pressure=load_of(surface)).checked()
    assert found.contact.cost.iterations < 100


def test_what_stops_early_says_so():
    surface = rough(32)
    found = slide(surface, standard(1000.0), velocity=0.1, mean_pressure=load_of(surface), max_iterations=3)
    assert found.contact.status is Status.ITERATION_LIMIT
    with pytest.raises(NotConverged):
        found.checked()
    exact = slide(surface, standard(3.0), velocity=0.1, mean_pressure=load_of(surface), tolerance=1e-16)
    assert exact.contact.status is Status.STAGNATED
    assert exact.contact.residuals.worst < 1e-12
    late = slide(surface, standard(10.0), velocity=0.1, mean_pressure=load_of(surface), time_limit=1e-9)
    assert late.contact.status is Status.TIME_LIMIT


def test_a_table_of_a_prony_series_gives_its_friction_and_is_refused_beyond_its_ends():
    surface, solid = rough(32), standard(10.0)
    omega = np.geomspace(0.1, 30, 300)
    modulus = solid.modulus(omega)
    table = TabulatedSolid(frequencies=omega, storage=modulus.real, loss=modulus.imag, poisson=0.3)
    load = load_of(surface)
    both = [slide(surface, one, velocity=0.05, mean_pressure=load) for one in (table, solid)]
    assert both[0].friction == pytest.approx(both[1].friction, rel=2e-4)
    with pytest.raises(InvalidInput, match="the table spans"):
        slide(surface, table, velocity=5.0, mean_pressure=load)


def test_the_standard_solid_is_given_by_its_retardation_time():
    solid, omega = standard(50.0, time=2.0), np.array([0.0, 0.01, 0.7, 30.0, 1e30])
    compliance = 1 / 50 + (1 - 1 / 50) / (1 + 2j * omega)
    assert solid.modulus(omega) == pytest.approx(1 / compliance, rel=1e-13)
    assert solid.unrelaxed == pytest.approx(50.0)
