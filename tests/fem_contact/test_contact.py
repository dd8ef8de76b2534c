"""What every solver returns: fields that cannot be changed, and a status that cannot be overlooked."""

import copy
import dataclasses
import pickle

import numpy as np
import pytest
from made_results import made_contact

from fem_contact import FemContactError, HeightField, NotConverged, Residuals, Solid, Status, block

SHAPE = (3, 4)
FIELDS = ("pressure", "gap", "displacement", "in_contact", "at_bound", "heights")


def result(**changes):
    residuals = Residuals(penetration=0.0, tension=1e-9, complementarity=3e-4, load=0.0)
    whole = {"lengths": (6.0, 2.0), "residuals": residuals, "provenance": {"method": "by hand"}}
    return made_contact(np.ones(SHAPE, dtype=bool), **(whole | changes))


def test_a_converged_result_checks_to_itself():
    converged = result()
    assert converged.checked() is converged


@pytest.mark.parametrize("status", [status for status in Status if status is not Status.CONVERGED])
def test_any_other_status_refuses_to_be_used_and_says_the_remedy(status):
    with pytest.raises(NotConverged) as caught:
        result(status=status).checked()
    assert str(caught.value) == f"{status.value} (worst residual 0.0003)"
    assert isinstance(caught.value, FemContactError)
    assert ":" in status.value


def with_worst(**residuals):
    return dataclasses.replace(result().residuals, **residuals)


@pytest.mark.parametrize("value", [np.nan, np.inf])
@pytest.mark.parametrize("name", ["penetration", "tension", "complementarity", "load"])
def test_a_residual_that_is_no_number_is_never_converged(name, value):
    with pytest.raises(NotConverged, match=f"worst residual is {value}"):
        result(residuals=with_worst(**{name: value})).checked()


def test_a_residual_above_its_tolerance_is_never_converged():
    within = result(tolerance=1e-3, residuals=with_worst(complementarity=9e-4, penetration=9e-3))
    assert within.checked() is within
    for above in ({"complementarity": 2e-3}, {"penetration": 2e-2}):
        with pytest.raises(NotConverged):
            result(tolerance=1e-3, residuals=with_worst(**above)).checked()


def test_statuses_tell_each_other_apart():
    assert len({status.value for status in Status}) == len(Status)


@pytest.mark.parametrize("name", [*FIELDS, "weights"])
def test_the_fields_of_a_result_are_read_only_and_leave_the_solver_its_arrays(name):
    array = np.ones(SHAPE, dtype=bool if name in ("in_contact", "at_bound") else float)
    frozen = getattr(result(**{name: array}), name)
    with pytest.raises(ValueError, match="read-only"):
        frozen[0, 0] = 0
    assert np.shares_memory(frozen, array)
    assert array.flags.writeable


def test_neither_attributes_nor_provenance_can_be_changed():
    settings = {"method": "by hand"}
    frozen = result(provenance=settings)
    with pytest.raises(dataclasses.FrozenInstanceError):
        frozen.offset = 1.0
    with pytest.raises(TypeError):
        frozen.provenance["method"] = "another"
    settings["method"] = "changed later"
    assert frozen.provenance["method"] == "by hand"


def test_shape_and_spacing_follow_the_fields():
    assert result().shape == SHAPE
    assert result().spacing == (2.0, 0.5)


@pytest.mark.parametrize("copied", [lambda value: pickle.loads(pickle.dumps(value)), copy.deepcopy])
def test_a_result_travels_to_another_process_and_stays_read_only(copied):
    original = result(pressure=np.arange(12.0).reshape(SHAPE))
    arrived = copied(original)
    for name in FIELDS:
        np.testing.assert_array_equal(getattr(arrived, name), getattr(original, name))
        assert not getattr(arrived, name).flags.writeable
    assert arrived.weights is None
    assert dict(arrived.provenance) == {"method": "by hand"}
    assert arrived.checked() is arrived
    assert (arrived.cost, arrived.residuals) == (original.cost, original.residuals)


def test_results_are_compared_by_identity_because_arrays_have_no_single_truth():
    one, other = result(), result()
    assert one == one
    assert one != other
    assert len({one, other}) == 2


def test_the_mean_gap_counts_each_point_by_its_area():
    """On a quadratic block of finite depth mean(w u) = p0 d (1 + nu)(1 - 2 nu) / (E (1 - nu))."""
    x = np.arange(24) / 24
    wave = HeightField(heights=0.02 * np.cos(2 * np.pi * x)[:, None] * np.ones(24), lengths=(1.0, 1.0))
    body = Solid(young=1.0, poisson=0.3)
    found = block.solve(wave, body, mean_pressure=0.02, depth=0.5, element="Hex2").contact.checked()
    sunk = 0.02 * 0.5 * 1.3 * 0.4 / 0.7
    assert found.mean_gap == pytest.approx(sunk + found.offset, rel=1e-6)
