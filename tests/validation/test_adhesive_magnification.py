"""Adhesive contact as waves are added: what is read off a solve, and what the theory is asked."""

import numpy as np
import pytest
from gold.asked import STUDIES
from numpy.testing import assert_allclose

from fem_contact import HalfSpace, bem
from persson import Interface, Scale, pressure_distribution, solve_adhesion
from validation.effects.adhesion import Adhesion
from validation.effects.base import full_contact_energy
from validation.execution.bench import Bench, PlannedOnly
from validation.measurements.adhesive import STRESS_EDGES, readings, sticky_contact
from validation.measurements.statistics import kolmogorov_smirnov
from validation.studies import adhesive_magnification as study

OPTIONS = study.Options(**STUDIES["adhesive-magnification"])


@pytest.fixture(scope="module")
def data(numbers):
    return numbers("adhesive-magnification")


@pytest.fixture(scope="module")
def whole():
    return study._full_surface(OPTIONS, 0)


def sticky(whole, work):
    reach = (work / 1e7 * 1e-5 / 10) ** 0.5
    shells = tuple(2 * np.pi / 1e-5 * np.array([1.5, 3.0]))
    return sticky_contact(problem=whole[0], grid=(48, 48), work=work, reach=reach, shells=shells).do()


def test_without_attraction_all_is_that_of_the_plain_contact(whole):
    """A work of 1e-9 of the energy, over a range that 48 points resolve, adds 1e-6 at most."""
    problem, work = whole
    found = sticky(whole, 2e-9 * work)
    plain = bem.solve(
        problem.heights((48, 48)), HalfSpace(solid=problem.elastic), mean_pressure=problem.pressure
    )
    assert float(found.area) == float(found.plain) == plain.in_contact.mean()
    assert float(found.force) == pytest.approx(1, abs=1e-4)
    assert float(found.tension) == pytest.approx(0, abs=0.02)
    assert np.isnan(found.parted)
    stored = 0.5 * np.mean(plain.pressure * (plain.displacement - plain.displacement.mean()))
    assert_allclose(found.stored_by_pressure, stored, rtol=1e-4)


def test_the_energy_of_the_waves_adds_up_to_half_of_p_u_and_to_that_of_full_contact(whole):
    problem, work = whole
    found = sticky(whole, work)
    assert_allclose(found.stored.sum(), found.stored_by_pressure, rtol=1e-9)
    full = full_contact_energy(problem.field, modulus=problem.contact_modulus)
    assert_allclose(found.full.sum(), full, rtol=1e-9)
    assert float(found.full[-1]) < 1e-12 * full
    assert_allclose(found.stress.sum(), found.area, rtol=1e-12)


def test_great_adhesion_closes_the_contact_under_its_load_and_stores_all(whole):
    _, work = whole
    found = sticky(whole, 60 * work)
    assert float(found.area) == float(found.parted) == 1
    assert_allclose(found.force, 1, rtol=1e-9)
    assert found.stored.values == pytest.approx(found.full.values, rel=1e-6, abs=1e-20)


def test_the_law_is_as_strong_as_the_theory_s_detachment_stress_at_the_last_wave(whole):
    """sigma_a^2 = (9/8) w E* q, Eq. 36, and w / range is the strength."""
    cut = study._cut(OPTIONS, 0, 3.0)
    case = cut.solve(16.0 * 3.0, shells=())
    q = 2 * np.pi / cut.problem.shortest
    assert (case["work"] / case["reach"]) ** 2 == pytest.approx(
        1.125 * case["work"] * cut.problem.contact_modulus * q
    )
    assert (case["work"], case["grid"]) == (whole[1], (48, 48))


def test_energies_are_summed_between_the_last_waves_of_the_magnifications():
    options = OPTIONS.model_copy(update={"periods": 2.0})
    with pytest.raises(PlannedOnly) as planned:
        study.run(options, bench=Bench.at("", plan_only=True))
    shells = {solve["shells"] for solve in planned.value.args}
    longest = 1e-5 / 2
    assert shells == {tuple(2 * np.pi / longest * np.array(OPTIONS.magnifications))}


def test_the_whole_surface_is_told_the_same_work_both_ways(data):
    """gamma_eff(zeta_1) = w; area, force and energy of the theory are those of the whole surface."""
    assert data.area_each.values[1, :, 1] == pytest.approx(data.area_each.values[0, :, 1], rel=1e-4)
    assert data.area_improved_each.values[1, :, 1] == pytest.approx(
        data.area_improved_each.values[0, :, 1], rel=1e-4
    )
    problem, work = study._full_surface(OPTIONS, 1)
    along = readings(problem, Adhesion(work=work), area="projected")["improved"]
    assert data.force_inside_improved_each.values[0, 1, 1] == pytest.approx(
        along.contact_force[-1] / problem.pressure, rel=1e-9
    )
    full = full_contact_energy(problem.field, modulus=problem.contact_modulus)
    assert data.energy_ratio_improved_each.values[0, 1, 1] * full == pytest.approx(
        float(along.elastic_energy[0]), rel=1e-9
    )


def test_adhesion_adds_area_force_and_tension(data):
    own = data.isel(told=0)
    assert (own.area_each > own.area_plain_each).all()
    assert (own.force_inside_each > 1).all()
    assert (own.tension_each > 0).all()
    assert (own.area_parted_each > own.area_each - 1e-9).all()
    assert (own.force_inside_improved_each > 1).all()
    assert (own.force_inside_old_each > 1).all()


def test_stresses_of_the_theory_fill_their_bins_with_its_area(data):
    """Their sum is A/A0, but for the half of a bin at the wall; none lie below the detachment stress."""
    own = data.isel(told=0)
    for reading in ("improved", "old"):
        shares, area = own[f"stress_share_{reading}_each"], own[f"area_{reading}_each"]
        assert shares.sum("stress_bin").values == pytest.approx(area.values, rel=2e-3)
    cut = study._cut(OPTIONS, 0, 3.0)
    case = cut.solve(16.0 * 3.0, shells=())
    lowest = -case["work"] / case["reach"] / cut.problem.pressure_scale
    below = STRESS_EDGES[1:] < lowest
    assert own.stress_share_improved_each.values[0, 1, below].sum() == 0
    assert own.stress_share_each.values[0, 1, STRESS_EDGES[1:] < lowest - 0.03].sum() == 0


def test_stresses_of_all_surfaces_are_one_sample_and_their_distance_is_that_of_kolmogorov(data):
    own = data.isel(told=0, magnification=1)
    pooled, theirs = (own[f"stress_share{end}_each"].sum("surface").values for end in ("", "_old"))
    assert_allclose(own.stress_distance_old, kolmogorov_smirnov(pooled, theirs), rtol=1e-12)
    assert float(own.stress_density.sum()) * np.diff(STRESS_EDGES)[0] == pytest.approx(1, rel=1e-12)


@pytest.mark.parametrize("energy", ["improved", "old"])
def test_theory_with_vanishing_adhesion_is_the_plain_one_in_stress_force_and_energy(energy, whole):
    problem = whole[0]
    scale = Scale(problem.spectrum_shape, contact_modulus=problem.contact_modulus)
    interface = Interface(work_of_adhesion=1e-9 * whole[1], energy=energy)
    found = solve_adhesion(scale, pressure=problem.pressure, interface=interface).checked()
    stress = np.linspace(0.02, 3, 200) * problem.pressure_scale
    plain = pressure_distribution(stress, pressure=problem.pressure, stress_variance=found.variance[-1])
    assert found.distribution(-1, stress) == pytest.approx(plain, abs=1e-3 * plain.max())
    assert found.contact_force == pytest.approx(np.full(found.area.size, problem.pressure), rel=1e-5)
