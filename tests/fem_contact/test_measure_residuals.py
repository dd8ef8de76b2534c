"""Each residual on fields made by hand, where its value can be read off."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fem_contact import Residuals, measure_residuals

MODULUS, GRADIENT, LENGTH = 5.0, 0.2, 8.0


def exact_fields(*, shape=(6, 4), mean=0.25):
    """Heights of rms 0.5, half of them loaded and closed, half open and free: no condition is missed."""
    sign = np.where(np.arange(shape[0]) % 2, -1.0, 1.0)[:, None] * np.ones(shape)
    closed = sign > 0
    return {"pressure": 2 * mean * closed, "gap": np.where(closed, 0.0, 1.0), "heights": 0.5 * sign}


def residuals(fields, **options):
    defaults = {"lengths": (LENGTH, LENGTH / 2), "contact_modulus": MODULUS, "rms_gradient": GRADIENT}
    return measure_residuals(**(defaults | fields | options))


def values(result):
    return np.array(dataclasses.astuple(result))


def by_definition(pressure, gap, heights, *, at_bound, weights, target):
    height, total, missed, weight_of_load, deepest, lowest = float(np.std(heights)), 0.0, 0.0, 0.0, 0.0, 0.0
    for p, g, bound, weight in zip(*(a.ravel() for a in (pressure, gap, at_bound, weights)), strict=True):
        open_or_sunk = 0.0 if bound else g
        total, missed = total + weight * abs(p), missed + weight * abs(p) * abs(open_or_sunk)
        deepest, lowest = min(deepest, open_or_sunk), min(lowest, p)
        weight_of_load += weight * p
    mean = weight_of_load / pressure.size
    load = 0.0 if target is None else abs(mean - target) / target
    return [-deepest / height, -lowest / (MODULUS * GRADIENT), missed / total / height, load]


@given(st.integers(2, 2**32), st.booleans(), st.booleans(), st.sampled_from([None, 0.2, 0.7]))
def test_every_residual_is_its_definition(seed, bounded, weighted, target):
    fields = faulty_fields(seed)
    bound, weights = fields.pop("at_bound"), fields.pop("weights")
    options = {"at_bound": bound} if bounded else {}
    options |= {"weights": weights} if weighted else {}
    plain = {"at_bound": np.zeros_like(bound), "weights": np.ones_like(weights)}
    expected = by_definition(**fields, target=target, **plain | options)
    found = residuals(fields, target_pressure=target, **options)
    np.testing.assert_allclose(values(found), expected, rtol=1e-12)


@pytest.mark.parametrize("level", [0.0, 3.7, -1e6])
def test_on_a_flat_surface_the_scales_come_from_the_load(level):
    fields = {"pressure": np.full((4, 4), 0.25), "gap": np.zeros((4, 4)), "heights": np.full((4, 4), level)}
    assert residuals(fields, target_pressure=0.25, rms_gradient=0.0).worst == 0
    fields["gap"] = np.full((4, 4), -0.1)
    result = residuals(fields, target_pressure=0.25, rms_gradient=0.0)
    scale = 0.25 * LENGTH / MODULUS
    assert result.penetration == pytest.approx(0.1 / scale, rel=1e-14)
    assert result.complementarity == pytest.approx(0.1 / scale, rel=1e-14)
    fields["pressure"][0, 0] = -0.5
    assert residuals(fields, target_pressure=0.25, rms_gradient=0.0).tension == pytest.approx(2, rel=1e-14)


def test_a_flat_surface_without_load_is_solved_by_no_pressure():
    flat = np.zeros((3, 3))
    fields = {"pressure": flat, "gap": flat, "heights": flat}
    assert residuals(fields, target_pressure=0.0, rms_gradient=0.0).worst == 0


def test_what_cannot_be_measured_against_anything_is_infinitely_wrong():
    flat = np.zeros((3, 3))
    fields = {"pressure": flat, "gap": flat - 1.0, "heights": flat}
    assert residuals(fields, target_pressure=0.0, rms_gradient=0.0).penetration == np.inf


@pytest.mark.parametrize("field", ["pressure", "gap", "heights"])
@pytest.mark.parametrize("index", [(0, 0), (3, 2)])
def test_nan_anywhere_makes_the_worst_residual_nan(field, index):
    fields = exact_fields()
    fields[field][index] = np.nan
    assert np.isnan(residuals(fields, target_pressure=0.25).worst)


@pytest.mark.parametrize("name", ["penetration", "tension", "complementarity", "load"])
def test_the_worst_residual_is_the_largest_and_never_hides_a_nan(name):
    zero = Residuals(penetration=0.1, tension=0.1, complementarity=0.1, load=0.1)
    assert dataclasses.replace(zero, **{name: 0.5}).worst == 0.5
    assert np.isnan(dataclasses.replace(zero, **{name: np.nan}).worst)


# --- residuals are free of units
# -----------------------------------------------------------------------------


def faulty_fields(seed):
    rng = np.random.default_rng(seed)
    fields = {name: rng.standard_normal((5, 7)) for name in ("pressure", "gap", "heights")}
    return fields | {"at_bound": rng.random((5, 7)) < 0.2, "weights": rng.uniform(0.5, 1.5, (5, 7))}


def in_other_units(fields, length, pressure):
    scales = {"pressure": pressure, "gap": length, "heights": length}
    scaled = {name: values * scales.get(name, 1) for name, values in fields.items() if values.dtype != bool}
    return scaled | {"at_bound": fields["at_bound"]}


def in_units(fields, *, length, pressure):
    told = {"contact_modulus": MODULUS * pressure, "target_pressure": 0.3 * pressure}
    lengths, scaled = (LENGTH * length, LENGTH / 2 * length), in_other_units(fields, length, pressure)
    return residuals(scaled, lengths=lengths, **told)


@given(st.integers(2, 2**32))
def test_scaling_lengths_and_pressures_by_powers_of_two_changes_no_bit(seed):
    fields = faulty_fields(seed)
    plain = in_units(fields, length=1.0, pressure=1.0)
    assert in_units(fields, length=2.0**20, pressure=2.0**-30) == plain
    assert min(values(plain)) > 0
