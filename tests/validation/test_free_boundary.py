"""One patch instead of a period in a scene: a ball, a measured patch with its edges, and who refuses it."""

from dataclasses import replace

import numpy as np
import pytest

from fem_contact import Patch
from validation.audit import audit
from validation.comparison.run import run_scene
from validation.effects.free_boundary import FreeBoundary
from validation.errors import UsageError
from validation.execution.press import solves_of
from validation.scenes.checks import check_scene
from validation.scenes.problem import realise
from validation.scenes.scene import Scene, load_scene
from validation.studies import find_study, studies

_WAVES = {"hurst": 0.8, "lambda_long": "20 um", "lambda_short": "5 um", "rms_height": "1 pm", "seed": 8}
BALL = {
    "name": "ball",
    "surface": {"kind": "self-affine", "length": "40 um", **_WAVES},
    "solid": {"young": "1 GPa", "poisson": 0.3},
    "load": {"force": "1 mN"},
    "methods": {"bem": {"grids": [64]}},
    "effects": [{"kind": "free-boundary", "radius": "1 mm"}],
}


def scene(**changed):
    return Scene.model_validate(BALL | changed)


def checked(**changed):
    asked = scene(**changed)
    check_scene(asked, realise(asked))


def test_a_ball_almost_without_roughness_is_hertzian():
    asked = scene()
    (solve,) = solves_of(asked)
    assert solve.predict().peak_bytes > replace(solve, effects=()).predict().peak_bytes
    result = solve.do().contact
    modulus = realise(asked).contact_modulus
    a = (3 * 1e-3 * 1e-3 / (4 * modulus)) ** (1 / 3)
    assert result.pressure.max() == pytest.approx(3 * 1e-3 / (2 * np.pi * a**2), rel=2e-3)
    # The mean of the heights lies below the apex by that of r^2/2R; the roughness is a picometre.
    assert -result.offset == pytest.approx(a**2 / 1e-3, rel=2e-3)


def test_the_ball_stays_where_it_is_on_every_grid():
    effect = FreeBoundary(radius="1 mm")
    surface = realise(scene())
    coarse, fine = (effect.shaped(surface.heights((n, n))) for n in (32, 64))
    np.testing.assert_allclose(fine.heights[::2, ::2], coarse.heights, atol=1e-20)


def test_a_measured_patch_keeps_its_edges(tmp_path):
    rng = np.random.default_rng(4)
    heights = 1e-8 * rng.random((12, 10)) + 1e-8 * np.arange(12)[:, None]
    np.save(tmp_path / "patch.npy", heights)
    map_ = {"kind": "file", "path": str(tmp_path / "patch.npy"), "length": ["12 um", "10 um"], "unit": "1 m"}
    changed = {
        "surface": map_ | {"edges": "free"},
        "effects": [{"kind": "free-boundary"}],
        "load": {"pressure": "1 MPa"},
        "methods": {"bem": {"grids": [[12, 10], [24, 20]]}},
    }
    outputs = run_scene(scene(**changed), tmp_path / "out", report=False)
    assert "pressed as one patch, with its edges" in outputs.data.attrs["treatment"]
    assert [str(entry) for entry in audit(tmp_path / "out").wrong] == []
    field = realise(scene(**changed)).field
    assert isinstance(field, Patch)
    np.testing.assert_array_equal(field.heights, heights)
    with pytest.raises(UsageError, match=r"surface.edges = 'free': has no period"):
        checked(**changed | {"effects": []})


def _with(**effect):
    return {"effects": [*BALL["effects"], effect]}


_TINY = {"kind": "free-boundary", "radius": "1 nm"}
_OBLONG = BALL["surface"] | {"length": ["40 um", "20 um"]}


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"methods": {"bem": {"grids": [64]}, "theory": {}}}, r"1 kind = 'free-boundary': method 'theory'"),
        ({"methods": {"bem": {"grids": [64]}, "fem": {"grids": [64]}}}, r"'free-boundary': method 'fem'"),
        ({"methods": {"bem": {"grids": [64], "shifts": 2}}}, r"methods.bem.shifts = 2: .*has no period"),
        ({"load": {"offset": "-50 nm"}}, r"load.offset: a patch .* is pressed by a load"),
        ({"load": {"force": "1 N"}}, r"1 radius = 1 mm: the ball would touch over .* \(Hertz\)"),
        ({"effects": [_TINY]}, r"1 radius = 1 nm: .* touch over .* where no paraboloid is a ball"),
        # (3 F R/4E*)^(1/3) with F = 1 MPa of 40 um by 20 um.
        (
            {"surface": _OBLONG, "effects": [_TINY], "load": {"pressure": "1 MPa"}},
            "the ball would touch over 81.7 nm",
        ),
        ({"ensemble": {"realisations": 2, "grids": [32, 64]}}, r"ensemble: averages over periods"),
        ({"quantities": {"subsurface": {}}}, r"quantities: are read off a period"),
        (_with(kind="thickness", thickness="1 um"), "is not solved together with a layer"),
        (_with(kind="adhesion", work="1 mJ/m^2", reach="1 um"), "is not solved together with adhesion"),
    ],
)
def test_what_needs_a_period_or_the_theory_refuses_it_by_name(changed, words):
    with pytest.raises(UsageError, match=words):
        checked(**changed)


def test_every_study_of_a_scene_refuses_it_by_name():
    refused = []
    for name, study in studies().items():
        if "scene" in study.options.model_fields:
            with pytest.raises(UsageError, match=r"free-boundary'|own"):
                find_study(name).parse([], scene=load_scene("rough-ball"))
            refused.append(name)
    assert {"pressure", "area", "refinement", "cross", "theory-verdict"} <= set(refused)
