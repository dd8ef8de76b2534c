"""The study of energy, gap and stiffness: its numbers are the surface's, its sentences the numbers'."""

import numpy as np
import pytest
import xarray as xr

from fem_contact import HalfSpace, bem, frozen_contact
from fem_contact.stress import elastic_energy
from persson import separation
from persson.scale import Scale
from persson.spectrum import SelfAffine
from validation.measures.measurement import grid_for
from validation.measures.theory import Waves
from validation.solves.bench import Bench
from validation.studies import energy
from validation.studies.energy import THEORIES, _said
from validation.studies.energy.words import QUANTITIES, scored

LOADS = (0.05, 0.1, 0.2, 0.4, 4.0)


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    options = energy.Options(
        reduced_pressures=LOADS, periods=2.0, bandwidth=2.0, surfaces=2, points_per_wave=(4.0, 8.0), seed=23
    )
    return options, energy.run(options, bench=Bench.at(tmp_path_factory.mktemp("energy")))


def test_energy_gap_and_compliance_are_those_of_the_contact_carried_to_the_limit(stored):
    """Richardson's step of second order for energy and gap, the finest grid for the compliance."""
    options, data = stored
    case, values = options.pressed[1], []
    solid, load = HalfSpace(solid=case.elastic), 0.2 * case.pressure_scale
    for points in (4.0, 8.0):
        contact = bem.solve(case.heights(grid_for(case, points)), solid, mean_pressure=load)
        height = case.field.rms_height
        compliance = load / (frozen_contact(contact, solid).stiffness * height)
        values.append((elastic_energy(contact), contact.gap.mean() / height, compliance))
    coarse, fine = np.array(values)
    step = (fine - coarse) / 3
    full = case.field.spectral_sum(lambda q: case.contact_modulus / 4 * q)
    assert float(data.energy[1, 2]) == pytest.approx((fine + step)[0] / full, rel=1e-6)
    assert float(data.gap[1, 2]) == pytest.approx((fine + step)[1], rel=1e-6)
    assert float(data.gap_error[1, 2]) == pytest.approx(abs(step[1]), rel=1e-4)
    assert float(data.compliance[1, 2]) == pytest.approx(fine[2], rel=1e-5)
    assert float(data.compliance_error[1, 2]) == pytest.approx(3 * abs(step[2]), rel=1e-3, abs=1e-9)


def test_what_is_solved_keeps_its_own_books(stored):
    """Work between loads .2 % apart to second order; over the path to fourth, in steps of ln 2."""
    _, data = stored
    assert data.work.values[:-1] == pytest.approx(np.ones(4), abs=1e-4)
    assert data.stiffness_check.values[:-1] == pytest.approx(np.ones(4), abs=0.01)
    assert data.path_work.values[1:4] == pytest.approx(np.ones(3), abs=0.01)
    assert float(data.first_energy[-1]) == pytest.approx(1, rel=1e-12)
    assert float(data.first_gap[-1]) == 0
    assert float(data.left_gap[2, :-1].max()) < 1e-5


def test_full_contact_is_scored_by_no_theory_and_said(stored):
    _, data = stored
    for name in QUANTITIES:
        assert np.isnan(scored(data, name).ratio[:, -1]).all()
        assert np.isfinite(scored(data, name).ratio[:, :-1]).all()
    assert any(
        "From p* = 4 on the contact of the first surface is full: its gap is 0 h_rms" in s
        for s in energy.findings(data)
    )
    assert energy.table(data).rows[-1][-1] == "full contact"
    assert {drawing.name for drawing in energy.figures(data)} == {
        "energy-gap-stiffness",
        "towards-full-contact",
    }


def test_gap_and_compliance_of_a_reading_follow_from_its_energy():
    """Of a continuous spectrum by `persson.separation`, which integrates in closed form; 100 rings, 2e-3."""
    rough = SelfAffine.from_rms_gradient(0.1, hurst=0.8, q_long=2e5, q_short=2e7)
    waves, scale = Waves.of_spectrum(rough, intervals=100), Scale(rough, contact_modulus=1.0)
    load = 0.1 * np.array([0.02, 0.3, 0.8])
    height = rough.moments().rms_height
    said = _said(waves, load, "old", height=height)
    assert said["gap"] * height == pytest.approx(separation.mean_separation(load, scale=scale), rel=2e-3)
    assert load / (said["compliance"] * height) == pytest.approx(
        separation.contact_stiffness(load, scale=scale), rel=2e-3
    )
    for reading in THEORIES:
        found = waves.elastic_energy(load, reading)
        assert found == pytest.approx(separation.elastic_energy(load, scale=scale, energy=reading), rel=2e-3)


def planted():
    """Half the energy of the first theory, the gap of the second but for 1 %; four surfaces, two loads."""
    names = list(THEORIES.values())
    at = ("surface", "load")
    shape, spread = (4, 2), np.array([-0.01, 0.01, -0.01, 0.01])[:, None]
    data = {"area": (at, np.full(shape, 0.3))}
    for name in QUANTITIES:
        data[name] = (at, 1 + np.broadcast_to(spread, shape))
        data[f"{name}_error"] = (at, np.full(shape, 0.003))
        data[f"theory_{name}"] = (("theory", "load"), np.full((len(names), 2), 4.0))
        data[f"left_{name}"] = (("tolerance", "load"), np.full((3, 2), 1e-9))
    data["theory_energy"][1][0] = 2.0
    data["theory_gap"][1][1] = 1.01
    for name in ("work", "stiffness_check", "path_work", "first_energy"):
        data[name] = ("load", np.array([1.0, 1.002]))
    data["first_gap"] = ("load", np.array([0.5, 0.25]))
    return xr.Dataset(
        data,
        coords={"reduced_pressure": ("load", [0.1, 0.2]), "theory": names, "tolerance": [1e-4, 1e-6, 1e-8]},
        attrs={"solver_tolerance": 1e-8},
    )


def test_a_theory_is_scored_with_students_interval_and_the_grids_and_holds_within_it():
    """Student's factor of four surfaces 3.182, error .01 / sqrt 3, the grids 1.96 times .003."""
    data = planted()
    found = scored(data, "energy")
    half = np.hypot(3.18245 * 0.01 / np.sqrt(3), 1.96 * 0.003)
    assert found.half_width == pytest.approx([half, half], rel=1e-5)
    assert found.ratio[0] == pytest.approx([0.5, 0.5], rel=1e-12)
    assert found.interval[0] == pytest.approx([half / 2, half / 2], rel=1e-5)
    assert not found.holds[0].any()
    assert scored(data, "gap").holds[1].all()
    row = energy.table(data).rows[2]
    assert (row[0], row[-1]) == ("mean gap / h_rms", "Persson, Eq. 48")


def test_the_sentences_hold_the_planted_factors():
    said = " ".join(energy.findings(planted()))
    assert (
        "Elastic energy / that of full contact, over that of Persson, Eq. 43: 0.5 +- 0.01 at A/A0 = 0.3"
        in said
    )
    assert "nearest are Persson, Eq. 48 (nowhere told from it, within the interval at 2 of 2 loads)" in said
    assert "Persson, Eq. 43 (off by a factor of 2 at worst, within the interval at 0 of 2 loads)" in said
    assert "the energy gained between loads .2 % apart is the work of the load within 0.002" in said
    assert "The smallest gap, 0.25 h_rms at p* = 0.2" in said
