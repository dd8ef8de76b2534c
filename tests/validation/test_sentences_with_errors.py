"""Sentences that judge: with a large uncertainty they may not claim what a small one allows."""

from __future__ import annotations

import numpy as np

from validation.comparison.findings import findings
from validation.comparison.run import run_scene
from validation.comparison.sweep import run_sweep
from validation.scenes.sweep import load_asked

_LAYER = '[[effects]]\nkind = "coating"\nyoung = "10 MPa"\nthickness = "0.2 um"\n[solid]'


def test_kappa_of_a_coated_solid_says_on_which_modulus_it_stands(write_scene, tmp_path):
    path = str(write_scene(("[solid]", _LAYER), fem=False))
    found = run_scene(load_asked(path, ()), tmp_path / "run", report=False).comparison
    (said,) = [text for text in findings(found) if "stand on E*" in text]
    # What the roughness feels lies between layer and solid, and so does kappa on it.
    felt = 2 * np.sqrt(found.theory.stress_variance) / found.rms_gradient
    assert 2e6 / 0.91 < felt < 10e6 / 0.91
    kappa = found.limit.value * felt * found.rms_gradient / found.pressure
    assert f"kappa = {kappa:.4g}"[:12] in said
    below = found.limit.value * found.realised.contact_modulus * found.rms_gradient / found.pressure
    assert f"kappa = {below:.4g}"[:12] in said
    asked = ["sweep.load.pressure=['5 kPa', '10 kPa']"]
    swept = run_sweep(load_asked(path, asked), tmp_path / "swept", report=False)
    # One modulus for p* and for kappa: their product is the area.
    product = swept.data["kappa"] * swept.data["reduced_pressure"]
    np.testing.assert_allclose(product, swept.data["area"], rtol=1e-12)
    assert any("kappa stands on E* of the layer" in text for text in swept.page.findings)


def test_a_homogeneous_solid_has_one_modulus_and_nothing_to_say_of_it(small_run):
    assert not [text for text in small_run.comparison.findings if "stand on E*" in text]
