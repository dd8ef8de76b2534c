"""Comparison with tamaas and ContactMechanics on shared surfaces, and what those codes get wrong.

The comparisons need the codes installed (extra ``peers``) and are skipped otherwise; the regressions do not.
"""

import numpy as np
import pytest

from fem_contact.bem import solve, solve_displacement
from fem_contact.contact import ContactResult, Status, measure_residuals
from fem_contact.errors import NotConverged
from fem_contact.response import HalfSpace
from fem_contact.solid import Solid
from fem_contact.surface import HeightField, random_surface

SOFT = HalfSpace(solid=Solid(young=1.0, poisson=0.0))


def shared_surface(shape: tuple[int, int] = (64, 64), seed: int = 51) -> HeightField:
    surface = random_surface(
        lambda q: np.where(q > 12.0, q**-3.6, 0.0),
        q_short=2 * np.pi * min(shape) / 8,
        lengths=(1.0, 1.0),
        shape=shape,
        seed=seed,
    )
    return HeightField(heights=surface.heights / surface.rms_gradient, lengths=(1.0, 1.0))


def difference(result: ContactResult, pressure: np.ndarray) -> float:
    return float(np.linalg.norm(result.pressure - pressure) / np.linalg.norm(result.pressure))


@pytest.mark.parametrize("load", [0.01, 0.1, 0.8])
@pytest.mark.parametrize("shape", [(64, 64), (48, 64)])
def test_tamaas_agrees_on_pressure(load: float, shape: tuple[int, int]) -> None:
    tamaas = pytest.importorskip("tamaas")
    surface = shared_surface(shape)
    ours = solve(surface, SOFT, mean_pressure=load, tolerance=1e-10).checked()
    model = tamaas.ModelFactory.createModel(tamaas.model_type.basic_2d, [1.0, 1.0], list(shape))
    model.E, model.nu = 1.0, 0.0
    kind = tamaas.PolonskyKeerRey
    solver = kind(model, surface.heights.copy(), 1e-10, kind.pressure, kind.pressure)
    solver.max_iter = 100_000
    solver.solve(load)
    assert difference(ours, np.array(model.traction)) < 1e-6


@pytest.mark.parametrize("load", [0.01, 0.1, 0.8])
@pytest.mark.filterwarnings("ignore")
def test_contact_mechanics_agrees_on_pressure(load: float) -> None:
    peer = pytest.importorskip("ContactMechanics")
    surface = shared_surface()
    ours = solve(surface, SOFT, mean_pressure=load, tolerance=1e-10).checked()
    substrate = peer.PeriodicFFTElasticHalfSpace(surface.shape, 1.0, surface.lengths, fft="numpy")
    topography = pytest.importorskip("SurfaceTopography").Topography(
        surface.heights.copy(), surface.lengths, periodic=True
    )
    system = peer.make_system(substrate=substrate, surface=topography)
    # Forces are per point there, and so are their tolerances; forces on the elastic body count as negative.
    cell = 1 / surface.heights.size
    outcome = system.minimize_proxy(external_force=load, pentol=1e-10 * surface.rms_height, maxiter=20000)
    assert outcome.success
    pressure = np.array(outcome.jac) / cell
    residuals = measure_residuals(
        pressure=pressure,
        gap=ours.gap,
        heights=surface.heights,
        lengths=surface.lengths,
        contact_modulus=1.0,
        rms_gradient=surface.rms_gradient,
        target_pressure=load,
    )
    assert residuals.load < 1e-9
    assert difference(ours, pressure) < 1e-6


def test_contact_mechanics_failure_no_convergence_near_full_contact_under_displacement_control() -> None:
    surface = shared_surface()
    for gap in (3e-3, 1e-4, 1e-6):
        result = solve_displacement(surface, SOFT, mean_gap=gap * surface.rms_height).checked()
        assert result.in_contact.mean() > 0.96
        assert result.residuals.worst < 1e-7


def test_tamaas_failure_mean_gap_control_returns_a_wrong_answer_near_full_contact() -> None:
    surface = shared_surface()
    target = 1e-3 * surface.rms_height
    result = solve_displacement(surface, SOFT, mean_gap=target).checked()
    gap = result.displacement - surface.heights + result.offset
    assert np.mean(gap) == pytest.approx(target, rel=1e-4)
    again = solve(
        surface, SOFT, mean_pressure=result.mean_pressure, method="polonsky-keer", max_iterations=20000
    )
    assert difference(result, again.checked().pressure) < 1e-5


def test_tamaas_failure_counting_positive_tractions_as_contact_at_light_load() -> None:
    surface = shared_surface((128, 128))
    result = solve(surface, SOFT, mean_pressure=1e-5).checked()
    assert result.in_contact.mean() < 0.01
    assert np.array_equal(result.in_contact, result.pressure > 0)
    assert np.all(np.abs(result.gap[result.in_contact]) < 1e-6 * surface.rms_height)


def test_peers_failure_reaching_the_iteration_limit_in_silence() -> None:
    result = solve(shared_surface(), SOFT, mean_pressure=0.1, max_iterations=2)
    assert result.status is Status.ITERATION_LIMIT
    assert result.residuals.complementarity > 1e-8
    with pytest.raises(NotConverged):
        result.checked()


@pytest.mark.parametrize(("length", "stress"), [(2.0**-30, 2.0**37), (2.0**20, 2.0**-30), (1e-9, 2e11)])
def test_peers_failure_absolute_tolerances_change_the_result_with_the_unit_system(
    length: float, stress: float
) -> None:
    surface = shared_surface()
    plain = solve(surface, SOFT, mean_pressure=0.1).checked()
    scaled = solve(
        HeightField(heights=surface.heights * length, lengths=(length, length)),
        HalfSpace(solid=Solid(young=stress, poisson=0.0)),
        mean_pressure=0.1 * stress,
    ).checked()
    assert scaled.cost.fft_pairs == plain.cost.fft_pairs
    assert np.array_equal(scaled.in_contact, plain.in_contact)
    assert difference(plain, scaled.pressure / stress) < 1e-7


def test_peers_failure_the_same_seed_on_a_finer_grid_is_another_surface() -> None:
    coarse = solve(shared_surface((64, 64)), SOFT, mean_pressure=0.1).checked()
    fine_surface = shared_surface((64, 64)).resampled((192, 192))
    fine = solve(fine_surface, SOFT, mean_pressure=0.1).checked()
    assert np.linalg.norm(fine.pressure[::3, ::3] - coarse.pressure) < 0.1 * np.linalg.norm(coarse.pressure)


@pytest.mark.parametrize("shape", [(45, 64), (64, 45), (45, 45)])
def test_tamaas_failure_displacement_on_an_odd_first_axis(shape: tuple[int, int]) -> None:
    """The gap under its contacts is off by 1e-4 h_rms; here a complex transform is the judge."""
    surface = shared_surface(shape)
    result = solve(surface, SOFT, mean_pressure=0.1, tolerance=1e-10).checked()
    qx, qy = (2 * np.pi * np.fft.fftfreq(n, 1 / n) for n in shape)
    q = np.hypot(qx[:, None], qy[None, :])
    q[0, 0] = np.inf
    displacement = np.fft.ifft2(2 / q * np.fft.fft2(result.pressure)).real
    np.testing.assert_allclose(result.displacement, displacement, atol=1e-14)
    gap = displacement - surface.heights + result.offset
    assert np.sum(result.pressure * np.abs(gap)) < 1e-10 * surface.rms_height * result.pressure.sum()
