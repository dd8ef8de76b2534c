"""What presses in a scene: a force, a distance that is held, a second elastic body."""

import itertools
import re

import pytest
from numpy.testing import assert_allclose
from small_scene import HARD, OBLONG, ensemble, scene_in

from fem_contact import HalfSpace, Solid, bem, block
from persson import contact_area, stress_variance
from validation.audit import audit
from validation.comparison.explain import explain
from validation.comparison.run import run_scene
from validation.errors import RunFailed, SceneError, UsageError
from validation.execution.press import solves_of
from validation.scenes.checks import check_scene
from validation.scenes.problem import realise
from validation.scenes.sweep import load_asked

SOLID = Solid(young=2e6, poisson=0.3)
STICKS = '\n[[effects]]\nkind = "adhesion"\nwork = "1 mJ/m^2"\nreach = "20 nm"\n'


@pytest.fixture
def scene(tmp_path):
    def read(load='pressure = "10 kPa"', *, more="", solid=""):
        text = OBLONG.replace('pressure = "10 kPa"', load).replace("poisson = 0.3", f"poisson = 0.3\n{solid}")
        return scene_in(tmp_path, text + more, name="mine")

    return read


def finest(scene):
    return solves_of(scene)[-1].do().contact


def test_a_force_is_the_pressure_over_the_nominal_area(scene):
    # 10 kPa on 10 um x 5 um.
    loaded = realise(scene('force = "0.5 uN"'))
    assert loaded.pressure == pytest.approx(1e4, rel=1e-12)
    assert loaded.recipe["load"] == {"pressure": None, "reduced_pressure": None, "force": 5e-7}
    plain = realise(scene())
    # What is absent is absent: solves that are stored stay where they are.
    assert plain.recipe["load"] == {"pressure": 1e4, "reduced_pressure": None}
    assert plain.recipe["solid"] == {"young": 2e6, "poisson": 0.3}
    assert finest(scene('force = "0.5 uN"')).mean_pressure == pytest.approx(1e4, rel=1e-9)


@pytest.mark.parametrize("key", ["mean_gap", "offset"])
@pytest.mark.parametrize("more", ["", HARD], ids=["elastic", "yielding"])
def test_the_distance_of_a_pressed_surface_gives_its_load_back(scene, key, more):
    pressed = finest(scene(more=more))
    distance = {"mean_gap": float(pressed.gap.mean()), "offset": pressed.offset}[key]
    held = finest(scene(f"{key} = {distance!r}", more=more))
    # The search stops within 1e-7 h_rms, and here the load falls e-fold over about half of h_rms.
    assert held.mean_pressure == pytest.approx(1e4, rel=1e-5)
    assert (held.in_contact == pressed.in_contact).all()


def test_an_offset_is_held_with_adhesion(scene):
    held = finest(scene('offset = "30 nm"', more=STICKS))
    assert held.offset == pytest.approx(30e-9, rel=1e-9)
    assert held.pressure.min() < 0
    assert held.mean_pressure != pytest.approx(finest(scene('offset = "30 nm"')).mean_pressure, rel=0.05)


def test_a_block_is_pressed_to_an_offset(scene):
    own = scene('offset = "20 nm"', more="[methods.fem]\ngrids = [[16, 8]]\n")
    with pytest.raises(UsageError, match=r"load.offset: the body of method 'fem' sinks as a whole"):
        check_scene(own, realise(own))
    (solve,) = (one for one in solves_of(own) if one.method == "fem")
    found = solve.do().contact
    direct = block.solve_displacement(solve.height_field(), SOLID, offset=20e-9, method="full").contact
    assert found.mean_pressure == pytest.approx(direct.mean_pressure, rel=1e-9)
    # Softer than the half-space, which does not sink: less load at the same offset.
    half = bem.solve_displacement(solve.height_field(), HalfSpace(solid=SOLID), offset=20e-9)
    assert 0 < found.mean_pressure < 0.9 * half.mean_pressure


def test_the_theory_is_told_the_load_that_a_held_gap_takes(scene, tmp_path):
    held, told = 'mean_gap = "40 nm"', "[methods.theory]\n"
    outputs = run_scene(scene(held, more=told), tmp_path / "out", report=False)
    found, surface = outputs.data, realise(scene()).heights((48, 24))
    carried = bem.solve_displacement(surface, HalfSpace(solid=SOLID), mean_gap=40e-9).mean_pressure
    assert_allclose(found.pressure, carried, rtol=1e-9)
    variance = stress_variance(float(found.rms_gradient) ** 2, contact_modulus=SOLID.contact_modulus)
    assert_allclose(found.area_persson_own, contact_area(carried, stress_variance=variance), rtol=1e-9)
    # Each grid takes a load of its own, and its kappa is over that.
    for row, solve in zip(found.grid.values, solves_of(scene(held)), strict=True):
        own = solve.do().contact.mean_pressure / (SOLID.contact_modulus * float(found.rms_gradient))
        here = found.sel(solver="bem", grid=row)
        assert_allclose(here.kappa_perimeter, float(here.area_perimeter) / own, rtol=1e-9)
    assert "mean gap 40 nm held" in outputs.page.lead
    assert audit(tmp_path / "out").wrong == ()


def test_bodies_too_far_apart_to_touch_are_told_to_come_closer(scene, tmp_path):
    with pytest.raises(RunFailed, match=r"load.offset = 1 mm: nothing touches so far apart; come closer"):
        run_scene(scene('offset = "1 mm"'), tmp_path / "out", report=False)


def test_a_contact_that_is_pulled_is_not_said_to_be_none(scene, tmp_path):
    asked = scene('offset = "60 nm"', more=STICKS.replace("1 mJ", "20 mJ").replace("20 nm", "200 nm"))
    with pytest.raises(
        RunFailed, match=r"offset = 60 nm: 0\.\d+ of the area touches, and is pulled; come closer"
    ):
        run_scene(asked, tmp_path / "out", report=False)


def test_a_held_distance_is_explained_as_one(scene):
    told = dict(explain(scene('mean_gap = "40 nm"')).facts)
    assert told["load"] == "mean gap = 40 nm is held; the load that takes follows from the solve"


def test_two_elastic_bodies_are_the_half_space_of_their_composite_modulus(scene):
    two = scene(solid='second_young = "3 MPa"\nsecond_poisson = 0.45')
    modulus = 1 / ((1 - 0.3**2) / 2e6 + (1 - 0.45**2) / 3e6)
    assert realise(two).contact_modulus == pytest.approx(modulus, rel=1e-12)
    found = finest(two)
    equal = HalfSpace(solid=Solid(young=modulus, poisson=0.0))
    same = bem.solve(solves_of(two)[-1].height_field(), equal, mean_pressure=1e4)
    assert found.offset == pytest.approx(same.offset, rel=1e-9)
    assert realise(two).recipe["solid"]["second_young"] == 3e6
    # A second body that hardly gives is rigid.
    stiff = realise(scene(solid='second_young = "1e9 GPa"\nsecond_poisson = 0.3'))
    assert stiff.contact_modulus == pytest.approx(SOLID.contact_modulus, rel=1e-9)


HELD, PRESSED = 'mean_gap = "40 nm"', 'pressure = "10 kPa"'
LAYER = '\n[[effects]]\nkind = "thickness"\nthickness = "3 um"\n'


@pytest.mark.parametrize(
    ("load", "solid", "more", "words"),
    [
        ('mean_gap = "-1 nm"', "", "", "mean_gap"),
        (
            "force = 3\nmean_gap = 0",
            "",
            "",
            "exactly one of 'pressure', 'reduced_pressure', 'force', 'mean_gap",
        ),
        ('force = "3 nm"', "", "", 'is not a force; must be a force such as "10 mN", or a number in N'),
        (HELD, "", "[methods.fem]\ngrids = [[16, 8]]\n", "method 'fem' presses with a load; held by: bem"),
        ('offset = "40 nm"', "", "[methods.tamaas]\ngrids = [[16, 8]]\n", "held by: bem, fem"),
        (HELD, "", STICKS, "several states have the same; give load.offset"),
        (HELD, "", ensemble(2, "[[24, 12], [48, 24]]"), "ensemble: is pressed"),
        (PRESSED, 'second_young = "3 MPa"', "", "second_poisson: missing; a second elastic body has both"),
        (PRESSED, "second_poisson = 0.3", "", "second_young: missing"),
        (PRESSED, 'second_young = "3 MPa"\nsecond_poisson = 0.6', "", "second_poisson"),
        (
            PRESSED,
            'second_young = "3 MPa"\nsecond_poisson = 0.4',
            LAYER,
            "'thickness' changes one body alone",
        ),
    ],
)
def test_what_cannot_be_pressed_is_refused_by_name(scene, monkeypatch, load, solid, more, words):
    monkeypatch.setattr("validation.solvers.tamaas.Tamaas.available", lambda self: None)
    with pytest.raises((SceneError, UsageError), match=re.escape(words)):
        check_scene(own := scene(load, solid=solid, more=more), realise(own))


def test_the_theory_alone_is_told_a_load(tmp_path):
    text = OBLONG.partition("[methods.bem]")[0].replace('pressure = "10 kPa"', 'offset = "1 nm"')
    with pytest.raises(SceneError, match=r"load.offset: the theory is told a load; add a method"):
        scene_in(tmp_path, text + "[methods.theory]\n", name="mine")


def test_setting_one_load_takes_that_of_the_scene_out_and_two_are_refused(scene, tmp_path):
    scene()
    path = str(tmp_path / "mine.toml")
    for key, other in itertools.permutations(("force='1 uN'", "mean_gap='20 nm'", "offset='5 nm'"), 2):
        assert load_asked(path, [f"load.{key}"]).load.key == key.partition("=")[0]
        with pytest.raises(UsageError, match="excludes load"):
            load_asked(path, [f"load.{key}", f"load.{other}"])
