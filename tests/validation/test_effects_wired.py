"""Effects that a scene lists: read, refused or handed to the slots of the solvers, explained, and stored."""

import itertools
import tomllib

import numpy as np
import pytest
from pydantic import TypeAdapter
from small_scene import ONE_BODY, ensemble

from fem_contact import BondedLayer, HalfSpace, Solid, bem
from validation.effects.base import ContactModel, Roughness, full_contact_energy
from validation.errors import SceneError, UsageError
from validation.execution.attempt import warm_up
from validation.execution.press import solves_of
from validation.scenes.checks import check_scene
from validation.scenes.problem import realise
from validation.scenes.scene import EffectSpec
from validation.scenes.surfaces import height_field
from validation.solvers.bem import Bem
from validation.solvers.theory import predict

HARD = '[[effects]]\nkind = "hardness"\nhardness = "40 kPa"\n'
STICKY = '[[effects]]\nkind = "adhesion"\nwork = "1 mJ/m^2"\nreach = "40 nm"\n'
LAYER = '[[effects]]\nkind = "thickness"\nthickness = "1 um"\n'
COATED = '[[effects]]\nkind = "coating"\nyoung = "6 MPa"\nthickness = "0.4 um"\n'
GRADED = '[[effects]]\nkind = "graded"\nbulk_young = "6 MPa"\ndepth = "0.4 um"\n'


@pytest.fixture
def with_effects(read_scene):
    def make(*effects, theory=False, fem=False, extra=()):
        changes = ["\n".join(effects)]
        if any(layered in effect for layered in ("thickness", "depth") for effect in effects):
            changes.append(ONE_BODY)
        if not theory:
            changes.append(("[methods.theory]", ""))
        return read_scene(*changes, *extra, fem=fem)

    return make


def solve_of(scene, grid, method="bem"):
    """The first solve of a grid by a method, which is not shifted."""
    return next(solve for solve in solves_of(scene) if (solve.grid, solve.method) == (grid, method))


def solved(scene, grid=(48, 32), method="bem"):
    return solve_of(scene, grid, method).do(threads=1).contact.checked()


@pytest.mark.parametrize(("method", "grid", "within"), [("bem", (48, 32), 0.0), ("fem", (24, 16), 1e-12)])
def test_hardness_bounds_the_pressure(with_effects, method, grid, within):
    contact = solved(with_effects(HARD, fem=method == "fem"), grid, method)
    assert contact.pressure.max() == pytest.approx(40e3, rel=within, abs=0.0)
    assert contact.at_bound.any()


@pytest.mark.parametrize("solver", ["bem", "fem"])
def test_hardness_by_size_bounds_every_patch_by_its_own_in_both_solvers(with_effects, solver):
    """And beside them the theory has a number of its own."""
    effect = HARD + 'size_wavelength = "2 um"\nsize_exponent = 0.5\n'
    scene = with_effects(effect, theory=True, fem=True)
    check_scene(scene, realise(scene))
    contact = solved(scene, (12, 8), solver)
    law = ContactModel.filled(Solid(young=2e6, poisson=0.3), scene.effects).patch_hardness
    bears = law.of_patches(contact.in_contact, contact.spacing)
    assert contact.at_bound.any()
    assert contact.pressure[contact.at_bound] == pytest.approx(bears[contact.at_bound], rel=1e-9)
    assert bears.min() > 40e3
    sized = predict(realise(scene), scene.effects)
    plain = predict(realise(scene), with_effects(HARD, theory=True).effects)
    assert sized.plastic < plain.plastic
    assert sized.area < plain.area


def test_thickness_is_the_layer_of_the_library(with_effects):
    scene = with_effects(LAYER)
    solve = solve_of(scene, (24, 16))
    assert solve.shift == (0.0, 0.0)
    field = solve.height_field()
    layer = BondedLayer(solid=Solid(young=2e6, poisson=0.3), thickness=1e-6)
    pressure = 0.1 * layer.contact_modulus * height_field(scene.surface).rms_gradient
    direct = bem.solve(field, layer, mean_pressure=pressure, threads=1)
    np.testing.assert_array_equal(solve.do(threads=1).contact.pressure, direct.pressure)


def test_finite_elements_and_boundary_elements_agree_on_a_graded_solid(with_effects):
    scene = with_effects(GRADED, fem=True)
    fine, block = (solved(scene, (24, 16), method) for method in ("bem", "fem"))
    difference = np.linalg.norm(block.pressure - fine.pressure) / np.linalg.norm(fine.pressure)
    plain = solved(with_effects(), (24, 16))
    grading = np.linalg.norm(plain.pressure - fine.pressure) / np.linalg.norm(fine.pressure)
    # Trilinear elements with 6 nodes on the shortest wave, in a block as deep as the longest.
    assert difference < 0.12
    assert grading > 3 * difference


@pytest.mark.parametrize("order", [(HARD, STICKY), (STICKY, HARD)])
def test_adhesion_and_hardness_act_together(with_effects, order):
    both, sticky = solved(with_effects(*order)), solved(with_effects(STICKY))
    # Where it yields the pressure is H to the tolerance of the solve.
    np.testing.assert_allclose(both.pressure[both.at_bound], 40e3, rtol=1e-5)
    assert both.pressure.min() < 0
    assert both.in_contact.mean() > sticky.in_contact.mean()


ENTRY = r"\[\[effects\]\] 1 "


@pytest.mark.parametrize(
    ("effects", "options", "message"),
    [
        ((STICKY,), {"fem": True}, ENTRY + "kind = 'adhesion': method 'fem' does not handle it"),
        ((COATED,), {"fem": True}, "'coating': method 'fem'"),
        ((LAYER,), {"theory": True}, "'thickness': method 'theory'"),
        ((HARD.replace("40 kPa", "9 kPa"),), {}, ENTRY + "hardness = 9 kPa: must not be below"),
        ((STICKY.replace("40 nm", "2 nm"),), {}, ENTRY + r"reach = 2 nm: grid \[12, 8\] has"),
        (
            (STICKY.replace("40 nm", "34 nm"), ensemble(2, "[10, 24]")),
            {},
            r"reach = 34 nm: grid \[10, 10\] has",
        ),
        (
            (LAYER,),
            {"fem": True},
            r"methods\.fem\.depth: \[\[effects\]\] 1 kind = 'thickness' says",
        ),
        (
            (LAYER + 'base = "frictionless"\n',),
            {"fem": True, "extra": [('depth = "5 um"', "")]},
            ENTRY + "kind = 'thickness': as it stands it is no body on a clamped base",
        ),
        ((COATED + "poisson = 0.4\n",), {"theory": True}, ENTRY + r"poisson = 0\.4: method 'theory'"),
    ],
)
def test_what_a_method_lacks_is_refused_by_name_before_computing(with_effects, effects, options, message):
    scene = with_effects(*effects, **options)
    with pytest.raises(UsageError, match=message):
        check_scene(scene, realise(scene))


@pytest.mark.parametrize(
    ("effect", "message"),
    [
        ('[[effects]]\nkind = "hardness"\n', "[[effects]] 1 hardness: missing"),
        ("[[effects]]\nhardness = 1.0\n", "[[effects]] 1 kind: missing; one of 'adhesion', "),
        (HARD.replace("[[effects]]", "[effects]"), "write [[effects]], not [effects]"),
        (STICKY + 'law = "spring"\n', "[[effects]] 1 law = 'spring': must be 'exponential' or 'dugdale'"),
        (LAYER + GRADED, "'thickness' and 'graded' both fill the slot 'response'"),
    ],
)
def test_a_wrong_effect_is_one_line_naming_the_key(with_effects, effect, message):
    with pytest.raises(SceneError) as error:
        with_effects(effect)
    assert message in str(error.value)


def test_theory_of_a_graded_solid_uses_the_modulus_each_wave_feels(with_effects):
    problem = realise(with_effects())
    plain = predict(problem, ()).stress_variance
    assert plain == pytest.approx(problem.contact_modulus**2 / 4 * problem.field.rms_gradient**2, rel=1e-12)
    # The bulk is three times as stiff.
    assert plain < predict(problem, with_effects(GRADED).effects).stress_variance < 9 * plain


def test_a_graded_solid_of_one_modulus_is_the_plain_one_for_the_theory(with_effects):
    problem = realise(with_effects(extra=[ONE_BODY]))
    same = with_effects(GRADED.replace("6 MPa", "2 MPa")).effects
    plain = predict(problem, ()).stress_variance
    assert predict(problem, same).stress_variance == pytest.approx(plain, rel=1e-12)


def rough():
    waves = {"gradient": 0.1, "curvature": 1e5, "longest": 1e-5, "shortest": 1e-6}
    return Roughness(modulus=1e9, full_energy=10.0, **waves)


def effect(text):
    return TypeAdapter(EffectSpec).validate_python(tomllib.loads(text)["effects"][0])


@pytest.mark.parametrize(
    ("template", "matters", "negligible"),
    [
        ('[[effects]]\nkind = "hardness"\nhardness = "{}"\n', "100 MPa", "1 GPa"),
        ('[[effects]]\nkind = "adhesion"\nwork = "{}"\nreach = "1 nm"\n', "2 J/m^2", "1 uJ/m^2"),
        ('[[effects]]\nkind = "thickness"\nthickness = "{}"\n', "5 um", "50 um"),
        ('[[effects]]\nkind = "coating"\nyoung = "1 MPa"\nthickness = "{}"\n', "1 um", "1 nm"),
        ('[[effects]]\nkind = "graded"\nbulk_young = "2 GPa"\ndepth = "{}"\n', "1 um", "1 mm"),
    ],
)
def test_the_word_of_a_listed_effect_turns_with_its_parameter(template, matters, negligible):
    assert effect(template.format(matters)).judge(rough()).verdict == "matters"
    word = effect(template.format(negligible)).judge(rough())
    assert word.verdict.startswith("negligible")


def test_the_energy_of_full_contact_is_that_of_the_pressure_that_makes_it(with_effects):
    field = height_field(with_effects().surface)
    half = HalfSpace(solid=Solid(young=2e6, poisson=0.3))
    contact = bem.solve(field, half, mean_pressure=1e6, threads=1).checked()
    assert contact.in_contact.all()
    stored = 0.5 * np.mean(contact.pressure * (field.heights - field.heights.mean()))
    assert full_contact_energy(field, modulus=half.contact_modulus) == pytest.approx(stored, rel=1e-10)


def test_the_pastewka_robbins_number_is_the_printed_one():
    # h' = .1, half Laplacian: rms curvature of a profile is sqrt(3/2) of it, 1e5 / sqrt(3/2) = 8.165e4 /m;
    # E* = 1 GPa, w = 1 J/m^2, rho = 1 nm: (.1 * 1e-9 / (2 * 1e-9)) (.1^2 / 8.165e4 / 1e-9)^(2/3).
    word = effect('[[effects]]\nkind = "adhesion"\nwork = "1 J/m^2"\nreach = "1 nm"\n').judge(rough())
    assert "Pastewka-Robbins number 1.23 " in word.number


def test_no_solve_is_charged_with_loading_what_its_effects_need(with_effects, monkeypatch):
    from fem_contact import block

    warmed_up = []

    def kept(solve):
        def keeping(*arguments, **options):
            warmed_up.append(solve(*arguments, **options))
            return warmed_up[-1]

        return keeping

    monkeypatch.setattr("validation.execution.attempt._warm", set())  # whatever this process ran before
    monkeypatch.setattr(Bem, "solve", kept(Bem.solve))
    monkeypatch.setattr(block, "solve", kept(block.solve))
    solves = [solve for kind in (HARD, STICKY, GRADED) for solve in solves_of(with_effects(kind))]
    solves += solves_of(with_effects(HARD, fem=True))
    warm_up(solves)
    hard, sticky, graded, elements = (one.contact for one in warmed_up)
    assert hard.at_bound.any()
    assert sticky.pressure.min() < 0
    assert 0 < graded.in_contact.mean() < 1
    assert elements.at_bound.any()


PAIRS = [(HARD, STICKY), *itertools.product((HARD, STICKY), (LAYER, COATED, GRADED))]


@pytest.mark.parametrize("pair", PAIRS)
def test_what_any_two_effects_need_is_loaded(with_effects, monkeypatch, pair):
    loaded = set()
    monkeypatch.setattr("validation.execution.attempt._warm", loaded)
    solves = solves_of(with_effects(*pair))
    warm_up(solves)
    kinds = sorted(tomllib.loads(effect)["effects"][0]["kind"] for effect in pair)
    assert loaded == {("bem", "", *kinds)}
    monkeypatch.setattr(Bem, "warm_up", None)  # once is enough
    warm_up(solves)
