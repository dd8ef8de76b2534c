import numpy as np
import pytest

from fem_contact import HeightField, Solid
from fem_contact.block import solve, wave_errors


def test_announced_error_is_the_error_of_a_solved_full_contact():
    n, length, waves, solid = 48, 1e-5, 4, Solid(young=2e9, poisson=0.3)
    phase = 2 * np.pi * waves * np.arange(n) / n
    amplitude = 1e-9
    surface = HeightField(heights=amplitude * np.cos(phase)[:, None] * np.ones(n), lengths=(length, length))
    (expected,) = wave_errors((n, n), (length, length), [length / waves], poisson=0.3)
    peak = solid.contact_modulus * np.pi * waves * amplitude / length
    contact = solve(surface, solid, mean_pressure=2 * peak).contact.checked()
    wave = 2 * np.mean(contact.pressure * np.cos(phase)[:, None])
    assert peak / wave - 1 == pytest.approx(expected.along_axis, abs=1e-6)


def test_rectangular_cells_have_their_own_diagonal():
    square, flat = (wave_errors((64, n), (1.0, 1.0), [0.25], poisson=0.3, depth=1.0)[0] for n in (64, 128))
    assert square.nodes == flat.nodes == 16
    assert abs(flat.along_diagonal - square.along_diagonal) > 1e-4
    assert flat.worst < 1e-2


def test_smaller_growth_lowers_the_floor_of_long_waves():
    waves = {"shape": (256, 256), "lengths": (1.0, 1.0), "wavelengths": [0.25], "poisson": 0.3}
    floors = [abs(wave_errors(**waves, growth=growth)[0].along_axis) for growth in (1.5, 1.2, 1.1)]
    assert floors == sorted(floors, reverse=True)
    assert floors[0] > 3e-3
    assert floors[2] < 1e-3


def test_announced_error_of_quadratic_elements_falls_with_the_fourth_power_of_the_spacing():
    nodes, wave, errors = (16, 32, 64), {"poisson": 0.3, "element": "Hex2"}, []
    for n in nodes:  # the layers are refined with the cells
        (found,) = wave_errors((n, n), (1.0, 1.0), [1.0], growth=1 + 3.2 / n, **wave)
        errors.append(abs(found.along_diagonal))
    order = -np.polyfit(np.log(nodes), np.log(errors), 1)[0]
    assert order == pytest.approx(4, abs=0.4)
    assert errors[-1] < 1e-4
