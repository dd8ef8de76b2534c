"""Sentences that judge: with a large uncertainty they may not claim what a small one allows."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from validation.comparison.findings import findings
from validation.comparison.run import run_scene
from validation.comparison.sweep import run_sweep
from validation.measures.statistics import Estimate
from validation.scenes.sweep import load_asked
from validation.studies.refinement import sentences


def _kappa(value: float, half: float) -> Estimate:
    return Estimate(value=value, standard_error=half / 2, half_width=half, samples=5)


@pytest.mark.parametrize(
    ("value", "half", "said"),
    [
        (2.17, 0.09, "agree with the converged 2.17"),
        (2.337, 1.8, "can be neither confirmed nor ruled out by the converged 2.337"),
        (2.5, 0.09, "do not agree with the converged 2.5"),
        (2.1, float("nan"), "can be neither confirmed nor ruled out"),
    ],
)
def test_published_values_agree_only_with_an_interval_that_could_have_missed_them(value, half, said):
    slopes = xr.DataArray(np.array([[[2.4, 2.3, 2.0]]]), dims=("surface", "protocol_grid", "slope"))
    text = sentences._published(xr.Dataset({"kappa_grid_scale": slopes}), _kappa(value, half))
    assert said in text
    # 1.8 is 17 % from 2.17; with a large interval it is not told from it.
    assert ("not told from it" in text) == (abs(1.8 - value) <= half)


def _elements(error: float) -> xr.Dataset:
    limit = np.array([0.1, 0.11, 0.105])
    apart = 1 + np.array([-0.0089, -0.0088, -0.0090])
    fem = ("element", "surface")
    return xr.Dataset(
        {
            "limit": ("surface", limit),
            "limit_error": ("surface", 1e-6 * limit),
            "limit_drift": ("surface", np.zeros(3)),
            "fem_limit": (fem, (limit * apart)[None]),
            "fem_limit_error": (fem, error * limit[None]),
            "fem_pixel": ((*fem, "fem_grid"), 1.1 * limit[None, :, None]),
            "fem_perimeter": ((*fem, "fem_grid"), 1.01 * limit[None, :, None]),
            "depth_error": ((), 1e-4),
        },
        coords={"element": ["Hex1"], "fem_points_per_wave": ("fem_grid", [16.0])},
    )


def test_the_limit_of_an_element_is_judged_with_the_error_of_its_own_grids():
    sharp = sentences._element_sentence(_elements(1e-5), 0)
    assert "they are told apart, so that the grids of the element leave 0.89 %, not 0.00 %" in sharp
    # Its grids leave 2 x .01 / sqrt(3) of the mean: 1.2 %, more than the .89 % between the two.
    blurred = sentences._element_sentence(_elements(0.01), 0)
    assert "the two are not told apart" in blurred
    assert "1.16 % their grids" in blurred or "1.17 % their grids" in blurred


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
