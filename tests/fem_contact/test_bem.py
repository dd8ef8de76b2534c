"""The boundary-element solver against closed forms, symmetries and changes of unit."""

import numpy as np
import pytest

from fem_contact.area import contact_areas
from fem_contact.bem import solve
from fem_contact.contact import ContactResult, Status
from fem_contact.errors import InvalidInput, NotConverged
from fem_contact.response import HalfSpace
from fem_contact.solid import Solid
from fem_contact.surface import HeightField, random_surface

SOFT = HalfSpace(solid=Solid(young=1.0, poisson=0.0))

#: Lattice sums of the square lattice: sum of 1/R^3, and of 1/R against a uniform background.
LATTICE_CUBE, LATTICE_MADELUNG = 9.03362168, -3.90026492


def rough(shape: tuple[int, int] = (64, 64), *, seed: int = 7, ratio: float = 8.0) -> HeightField:
    lengths = (1.0, shape[1] / shape[0])
    q_long, q_short = 2 * np.pi * 4, 2 * np.pi * shape[0] / ratio
    surface = random_surface(
        lambda q: np.where(q >= q_long * (1 - 1e-9), q ** (-2 - 2 * 0.8), 0.0),
        q_short=q_short,
        lengths=lengths,
        shape=shape,
        seed=seed,
    )
    return HeightField(heights=surface.heights / surface.rms_gradient, lengths=lengths)


class Hertz:
    """A paraboloid repeated periodically: Hertz's solution with the curvature that the images add."""

    def __init__(self, n: int, *, radius: float = 1.0, relative_size: float = 0.1) -> None:
        self.n, self.a = n, relative_size
        load = 4 * self.a**3 / (3 * radius)
        # The images' field near the origin is F/(pi E*) (constant + sum R^-3 r^2 / 4): it adds to the
        # curvature.
        curvature = 1 / radius - load * LATTICE_CUBE / (2 * np.pi)
        x = (np.arange(n) + 0.5) / n - 0.5
        self.r = np.hypot(x[:, None], x[None, :])
        self.surface = HeightField(heights=-(self.r**2) * curvature / 2, lengths=(1.0, 1.0))
        self.load, self.peak = load, 2 * self.a / (np.pi * radius)
        self.pressure = self.peak * np.sqrt(np.maximum(1 - (self.r / self.a) ** 2, 0))
        self.approach = self.a**2 / radius + load * LATTICE_MADELUNG / np.pi

    def solve(self) -> ContactResult:
        return solve(self.surface, SOFT, mean_pressure=self.load).checked()


def test_hertz_pressure_peak_and_approach() -> None:
    case = Hertz(256)
    result = case.solve()
    assert result.pressure.max() == pytest.approx(case.peak, rel=2e-3)
    inside = case.r < 0.9 * case.a
    np.testing.assert_allclose(result.pressure[inside], case.pressure[inside], rtol=0.01)
    assert np.linalg.norm(result.pressure - case.pressure) < 0.01 * np.linalg.norm(case.pressure)
    assert -result.offset == pytest.approx(case.approach, rel=2e-3)


def test_hertz_radius_converges_in_first_order_and_the_edge_correction_gains_an_order() -> None:
    pixel, corrected = [], []
    for n in (48, 96, 192, 384):
        case = Hertz(n)
        areas = contact_areas(case.solve())
        pixel.append(np.sqrt(areas.pixel / np.pi) / case.a - 1)
        corrected.append(np.sqrt(areas.perimeter / np.pi) / case.a - 1)
    order = np.polyfit(np.log([48, 96, 192, 384]), -np.log(pixel), 1)[0]
    assert 0.75 < order < 1.25
    assert abs(corrected[-1]) < 1e-3
    assert abs(corrected[0]) < 0.35 * pixel[0]


@pytest.mark.parametrize("axis", [0, 1])
def test_westergaard_pressure_under_a_wave(axis: int) -> None:
    n, width, amplitude = 256, 0.3, 0.01
    x = (np.arange(n) + 0.5) / n - 0.5
    line = amplitude * np.cos(2 * np.pi * x)
    heights = line[:, None] * np.ones(6) if axis == 0 else line[None, :] * np.ones(6)[:, None]
    mean = np.pi * amplitude * np.sin(np.pi * width) ** 2
    result = solve(HeightField(heights=heights, lengths=(1.0, 1.0)), SOFT, mean_pressure=mean).checked()
    root = np.sqrt(np.maximum(np.sin(np.pi * width) ** 2 - np.sin(np.pi * x) ** 2, 0))
    exact = 2 * mean * np.cos(np.pi * x) / np.sin(np.pi * width) ** 2 * root
    computed = result.pressure[:, 2] if axis == 0 else result.pressure[2]
    assert computed.max() == pytest.approx(exact.max(), rel=1e-3)
    inside = np.abs(x) < 0.9 * width
    np.testing.assert_allclose(computed[inside], exact[inside], rtol=0.01)


def test_full_contact_pressure_is_the_height_spectrum_times_the_stiffness() -> None:
    surface = rough((48, 45))
    result = solve(surface, SOFT, mean_pressure=5.0).checked()
    assert result.in_contact.all()
    assert result.residuals.worst < 1e-12
    variance = np.mean((result.pressure - 5.0) ** 2)
    assert variance == pytest.approx(surface.rms_gradient**2 / 4, rel=1e-12)


def test_flat_surface_gives_uniform_pressure() -> None:
    for level in (0.0, 3.0, 1e6):
        flat = HeightField(heights=np.full((9, 6), level), lengths=(2.0, 1.0))
        result = solve(flat, SOFT, mean_pressure=0.25).checked()
        np.testing.assert_allclose(result.pressure, 0.25, rtol=1e-9)
        assert result.in_contact.all()
        assert result.residuals.worst < 1e-12


@pytest.mark.parametrize("shape", [(64, 64), (45, 63), (37, 64), (96, 41)])
@pytest.mark.parametrize("pressure", [1e-4, 0.05, 0.6])
def test_contact_conditions_and_load_hold(shape: tuple[int, int], pressure: float) -> None:
    result = solve(rough(shape), SOFT, mean_pressure=pressure).checked()
    assert result.residuals.complementarity <= 1e-8
    assert result.residuals.penetration <= 1e-7
    assert result.residuals.tension == 0
    assert result.residuals.load < 1e-14
    assert 0 < result.in_contact.mean() < 1


def test_change_of_units_changes_no_bit() -> None:
    surface = rough((45, 64))
    plain = solve(surface, SOFT, mean_pressure=0.05)
    length, stress = 2.0**20, 2.0**-30
    scaled_surface = HeightField(
        heights=surface.heights * length, lengths=(surface.lengths[0] * length, surface.lengths[1] * length)
    )
    scaled = solve(
        scaled_surface, HalfSpace(solid=Solid(young=stress, poisson=0.0)), mean_pressure=0.05 * stress
    )
    assert np.array_equal(plain.pressure, scaled.pressure / stress)
    assert np.array_equal(plain.gap, scaled.gap / length)
    assert np.array_equal(plain.in_contact, scaled.in_contact)
    assert plain.residuals == scaled.residuals


def test_translation_and_rotation_of_the_surface_carry_the_pressure_along() -> None:
    surface = rough((48, 48))
    pressure = solve(surface, SOFT, mean_pressure=0.05, tolerance=1e-11).checked().pressure
    moved = HeightField(heights=np.roll(surface.heights, (5, 11), axis=(0, 1)), lengths=surface.lengths)
    turned = HeightField(heights=np.rot90(surface.heights), lengths=surface.lengths)
    for other, expected in ((moved, np.roll(pressure, (5, 11), axis=(0, 1))), (turned, np.rot90(pressure))):
        again = solve(other, SOFT, mean_pressure=0.05, tolerance=1e-11).checked().pressure
        assert np.linalg.norm(again - expected) < 1e-8 * np.linalg.norm(expected)


def test_offset_of_the_heights_only_moves_the_offset() -> None:
    surface = rough((48, 48))
    lifted = HeightField(heights=surface.heights + 0.75, lengths=surface.lengths)
    first, second = (solve(s, SOFT, mean_pressure=0.05, tolerance=1e-11).checked() for s in (surface, lifted))
    assert second.offset - first.offset == pytest.approx(0.75, rel=1e-10)
    assert np.linalg.norm(first.pressure - second.pressure) < 1e-8 * np.linalg.norm(first.pressure)


def test_start_from_another_load_gives_the_same_answer() -> None:
    surface = rough((48, 48))
    light = solve(surface, SOFT, mean_pressure=0.02, tolerance=1e-11).checked()
    cold = solve(surface, SOFT, mean_pressure=0.05, tolerance=1e-11).checked()
    warm = solve(surface, SOFT, mean_pressure=0.05, tolerance=1e-11, start=light.pressure).checked()
    assert np.linalg.norm(warm.pressure - cold.pressure) < 1e-8 * np.linalg.norm(cold.pressure)


def test_iteration_limit_is_a_status_with_a_remedy() -> None:
    result = solve(rough(), SOFT, mean_pressure=0.05, max_iterations=3)
    assert result.status is Status.ITERATION_LIMIT
    with pytest.raises(NotConverged, match="allow more iterations"):
        result.checked()


@pytest.mark.parametrize("pressure", [0.0, -1.0, np.nan, np.inf])
def test_pressure_that_is_not_positive_is_refused(pressure: float) -> None:
    with pytest.raises(InvalidInput, match="mean_pressure"):
        solve(rough(), SOFT, mean_pressure=pressure)


def test_start_of_the_wrong_shape_is_refused() -> None:
    with pytest.raises(InvalidInput, match="start"):
        solve(rough((64, 64)), SOFT, mean_pressure=0.05, start=np.ones((32, 32)))
