"""What a surface tells of its contact without a solve: a wave by hand, signs, scales, what area follows."""

from dataclasses import replace

import numpy as np
import pytest

from fem_contact import HeightField, random_surface
from persson import SelfAffine
from validation.measurements.common import base_case, base_surface
from validation.measurements.control_variates import unsolved_pairs, unsolved_statistics


def rough(seed):
    spectrum = SelfAffine.from_rms_gradient(0.1, hurst=0.8, q_long=4 * np.pi, q_short=16 * np.pi)
    return random_surface(spectrum, q_short=16 * np.pi, lengths=(1.0, 1.0), shape=(32, 32), seed=seed)


def test_the_statistics_of_a_wave_are_those_by_hand():
    n = 4096
    x = (np.arange(n) + 0.5) / n
    wave = HeightField(heights=np.cos(2 * np.pi * x)[:, None] * np.ones(2), lengths=(1.0, 1.0))
    told = unsolved_statistics(wave)
    # Heights and full-contact pressures are sqrt(2) cos, slopes^2 are 2 sin^2; the top share s is |x| < s/2.
    for share in (0.01, 0.1, 0.3):
        top = np.sqrt(2) * np.sin(np.pi * share) / (np.pi * share)
        steep = 1 - np.sin(2 * np.pi * share) / (2 * np.pi * share)
        for of, by in (("height", "pressure"), ("pressure", "height"), ("height", "height")):
            assert told[f"{of} on the top {share:g} of {by}"] == pytest.approx(top, rel=1e-3)
        assert told[f"slope on the top {share:g} of height"] == pytest.approx(steep, rel=0.03, abs=1e-4)
    assert told["share in tension at 0.2"] == pytest.approx(np.arccos(0.4 / np.sqrt(2)) / np.pi, abs=2 / n)
    assert told["tension at 0.8"] == 0
    assert told["h4"] == pytest.approx(1.5, rel=1e-6)


def test_they_are_the_same_of_minus_h_and_of_any_unit():
    field = rough(19)
    told = unsolved_statistics(field)
    for scale, length in ((-1.0, 1.0), (2.0**20, 2.0**20), (0.125, 1.0)):
        other = HeightField(heights=scale * field.heights, lengths=(length, length))
        assert unsolved_statistics(other) == pytest.approx(told, rel=1e-9, abs=1e-12)


def test_the_gradient_is_told_and_differs_where_amplitudes_are_random():
    base = base_case(base_surface(hurst=0.8, periods=1.6, bandwidth=2.5, seed=17), reduced_pressure=0.1)
    gaussian = replace(base, surface=base.surface.model_copy(update={"amplitudes": "gaussian"}))
    told, plain = (
        unsolved_pairs(problem=one, grid=(16, 16), first=3, count=4).do() for one in (gaussian, base)
    )
    assert told.attrs["statistics"].split("; ")[-1] == "h'_rms"
    own = [gaussian.further(k).field.rms_gradient for k in range(3, 7)]
    assert told.value.values[:, -1] == pytest.approx(own, rel=1e-9)
    assert np.std(own) > 0.02 * np.mean(own)
    assert np.std(plain.value.values[:, -1]) < 1e-9 * np.mean(own)
