"""A ground surface in a scene: its stretch reaches generator, theory and audit; older recipes stay."""

import numpy as np
import pytest

from fem_contact import measured_lay
from persson import SelfAffine, Stretched
from validation.errors import SceneError
from validation.scenes.problem import realise
from validation.scenes.scene import Scene, load_scene
from validation.scenes.surfaces import spectrum_of
from validation.scenes.sweep import load_asked


def test_its_surface_has_the_lay_along_x_on_every_grid():
    problem = realise(load_scene("ground"))
    lays = [measured_lay(problem.heights((n, n))) for n in (64, 96)]
    assert lays[0].ratio == pytest.approx(lays[1].ratio, rel=1e-9)
    # Four waves of the longest along y, and one along x: sums are no integrals.
    assert lays[0].ratio == pytest.approx(4, rel=0.15)
    assert lays[0].direction == pytest.approx(0, abs=1e-9)
    assert problem.longest == pytest.approx(100e-6)


def test_a_scene_without_a_stretch_has_the_recipe_that_it_had():
    plain = realise(load_scene("quickstart"))
    assert "stretch" not in plain.recipe["surface"]
    assert isinstance(plain.spectrum, SelfAffine)
    assert realise(load_scene("ground")).recipe["surface"]["stretch"] == 4
    same = load_asked("quickstart", ["surface.stretch=1"])
    np.testing.assert_allclose(
        realise(same).field.heights, plain.field.heights, atol=1e-12 * plain.field.rms_height
    )


def test_waves_longer_than_the_period_are_refused():
    with pytest.raises(SceneError, match=r"stretch = 5: makes waves of 125 um along x, longer"):
        load_asked("ground", ["surface.stretch=5"])
    said = load_scene("ground").model_dump(mode="json", exclude_none=True)
    with pytest.raises(ValueError, match="greater than or equal to 1"):
        Scene.model_validate(said | {"surface": said["surface"] | {"stretch": 0.5}})


def test_the_spectrum_of_a_ground_surface_has_the_slope_asked_for():
    found = spectrum_of(load_scene("ground").surface)
    assert isinstance(found, Stretched)
    assert found.moments().rms_gradient == pytest.approx(0.1, rel=1e-12)
    high = load_asked("ground", ["surface.rms_height=1 um", "methods.bem.grids=[64]"])
    assert spectrum_of(high.surface).moments().rms_height == pytest.approx(1e-6, rel=1e-11)
