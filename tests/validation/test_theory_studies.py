"""The studies that compare limits with the theory: kappa over H, load and magnification, and the verdict."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from planted import decided
from solving import persson_area

from validation.errors import UsageError
from validation.measurements.limits import moved_shares
from validation.studies import find_study, hurst, magnification, pressure, theory_verdict
from validation.theories.predicted import COMPARED


def test_every_option_of_the_ladders_reaches_them():
    told = {"hursts": (0.4,), "bandwidths": (2.0, 5.0), "pairs": 3, "points_per_wave": (3.0, 7.0)}
    told |= {"reduced_pressure": 0.07, "periods": (1.5, 3.0)}
    climbed = hurst.Options(**{f"ladder_{name}": value for name, value in told.items()}).climbed
    told["sizes"], told["periods"] = told["periods"], hurst.Options().periods
    assert {name: getattr(climbed, name) for name in told} == told


def test_what_no_spectrum_has_is_refused_by_name(bench):
    with pytest.raises(UsageError, match=r"equal_nayak = 1\.2: no bandwidth gives it"):
        hurst.run(hurst.Options(equal_nayak=1.2), bench=bench)
    with pytest.raises(UsageError, match=r"magnifications = 1, the first: leaves no wave, must be larger"):
        magnification.design(magnification.Options(periods=1.6, magnifications=(1.0, 2.0)))
    assert magnification.design(magnification.Options(periods=1.6, magnifications=(1.25, 2.0)))


def test_magnification_ends_at_the_theory_of_the_whole_surface(numbers):
    data = numbers("magnification")
    area, theory = data.area_each.isel(load=0), data.area_persson_each.isel(load=0, magnification=-1)
    assert_allclose(theory, persson_area(0.05), rtol=1e-9)
    assert np.all(area.isel(magnification=0) > area.isel(magnification=-1))


def test_every_quantity_of_the_theory_is_scored_and_full_contact_is_no_comparison_but_of_the_area(numbers):
    scored = numbers("theory-verdict")
    for name in COMPARED:
        over = scored[f"{name}_over"].transpose("theory", "load")
        assert np.isfinite(over[:, :-1]).all()
        assert np.isfinite(over[:, -1]).all() == (name == "area")
        assert np.isfinite(scored[f"{name}_off"]).all()
    assert_allclose(scored.area_over.isel(load=-1), 1.0, rtol=1e-9)
    table = theory_verdict.views(scored).table.of(scored)
    assert len(table.rows) == 4 * 4
    assert len(find_study("theory-verdict").budget(scored).rows) == 4


def test_the_pressure_study_says_from_where_on_the_distributions_move(numbers):
    data = numbers("pressure")
    claim = decided(pressure, data, "moved_stress_beyond")
    assert claim.outcomes[-1] == "+"
    # Were all loads alike, none would have moved.
    shares = data.stress_share_each
    alike = moved_shares(data.assign(stress_share_each=shares * 0 + shares.isel(load=0)))
    claim = decided(pressure, alike, "moved_stress_beyond")
    assert set(claim.outcomes) <= {"0", "-"}
    full = pressure.views(data.assign(area=data.area * 0 + 0.99)).findings
    assert full[0].text == "All loads are of nearly full contact."
    assert len(full) == 2


def test_the_ladders_of_the_hurst_study_keep_phases_and_area(numbers):
    data = numbers("hurst")
    assert np.all(data.nayak_by_bandwidth[:, 0] < data.nayak_by_bandwidth[:, 1])
    assert data.order_by_bandwidth.values == pytest.approx([1.4, 0.4], rel=1e-12)
    # The first rung of the bandwidth ladder is the study's own spectrum: the same surfaces on the same grids,
    # but for the tolerance of a solve that starts from the load before.
    own = data.kappa.isel(family=0, load=1)
    assert_allclose(data.kappa_by_bandwidth[:, 0], own, rtol=1e-6)
    # 1 / 1.25^2 of the area, so more pairs; the others are no samples of the larger.
    assert ((data.solve_by_size != "").sum("surface_by_size") == [[6, 4], [6, 4]]).all()
