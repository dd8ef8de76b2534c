"""Values beyond all reason are refused by name when a scene is read; what is read is explained."""

import math
import re
import time
import tomllib

import pytest
from commanding import invoke
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pydantic import ValidationError
from refusing import refused
from small_scene import changed, small_scene

from validation.comparison.explain import explain
from validation.effects.base import full_contact_energy
from validation.errors import RunFailed, UsageError
from validation.scenes import surfaces
from validation.scenes.mistakes import problems
from validation.scenes.problem import realise
from validation.scenes.scene import Scene
from validation.scenes.surfaces import Expected, expected, height_field
from validation.studies import find_study, studies

MORE = "under_resolved = true\n"
MORE += f'[methods.fem]\ngrids = [16]\n{MORE}method = "reduced"\n[methods.theory]\n'
TREE = tomllib.loads('name = "extreme"' + small_scene(MORE))


def problem(tree):
    """What the reader of scenes says; empty if it has no objection."""
    try:
        Scene.model_validate(tree)
    except ValidationError as error:
        lines = problems(error)
        assert all("\n" not in line and len(line) < 600 for line in lines)
        return "; ".join(lines)
    return ""


BEYOND = [
    ("surface.length", 5e-324, "surface.length = 5e-324: is out of range; sizes from 1e-30"),
    ("surface.length", "1 m**9**9**9", "has an unknown unit"),
    ("surface.length", "1" * 5000 + " m", "(5004 characters): must be a length such as"),
    ("surface.length", 10**5000, "a number of thousands of digits: is out of range"),
    ("surface.rms_gradient", 5e-324, "surface.rms_gradient = 5e-324: must lie between 1e-12 and 1e+06"),
    ("methods.bem.grids", [9 * 10**15], "must have at most 131072 points along a side"),
    ("title", "\x1b[31mred", r"must be a line of text; it holds the control character '\x1b'"),
    ("title", "abc\u202edef", r"it holds the control character '\u202e'"),
    ("title", "x" * 10**6, "(1000002 characters): String should have at most 200 characters"),
]


@pytest.mark.parametrize(("place", "value", "words"), BEYOND, ids=range(len(BEYOND)))
def test_a_value_beyond_all_reason_is_refused_by_name(place, value, words):
    assert words in problem(changed(TREE, place, value))


def test_titles_in_any_language_and_with_brackets_are_shown(tmp_path):
    for title in ("Rauheit – größer", "粗さ", "a [/] b [bold]c", "חספוס"):
        assert problem(changed(TREE, "title", title)) == ""


EXTREMES = st.one_of(
    st.sampled_from([10.0**k for k in (-30, -20, -12, -9, -6, -3, 0, 3, 6, 9, 20, 30)]),
    st.floats(min_value=0.0, allow_infinity=False),
)
WHOLE = st.integers(0, 10**18)
SIDES = st.integers(2, 200_000)


def effect(kind, *keys):
    return st.fixed_dictionaries({"kind": st.just(kind), **dict.fromkeys(keys, EXTREMES)})


ENSEMBLES = st.tuples(st.one_of(WHOLE, st.integers(2, 300)), st.integers(2, 70_000)).map(
    lambda asked: {"realisations": asked[0], "grids": [asked[1], 2 * asked[1]]}
)
EFFECTS = (
    effect("hardness", "hardness"),
    effect("adhesion", "work", "reach"),
    effect("thickness", "thickness"),
    effect("graded", "bulk_young", "depth"),
)
PLACES = {
    "surface.length": st.one_of(EXTREMES, st.lists(EXTREMES, min_size=2, max_size=2)),
    "surface.hurst": st.floats(0, 1),
    "surface.lambda_long": EXTREMES,
    "surface.lambda_short": EXTREMES,
    "surface.rms_gradient": EXTREMES,
    "surface.seed": WHOLE,
    "surface.rolloff": st.sampled_from(["sharp", "smooth", "plateau"]),
    "solid.young": EXTREMES,
    "solid.poisson": st.floats(-1, 0.5),
    "load.reduced_pressure": EXTREMES,
    "load": st.fixed_dictionaries({"pressure": EXTREMES}),
    "methods.bem.grids": st.lists(st.one_of(WHOLE, SIDES), max_size=3),
    "methods.bem.shifts": st.integers(0, 9),
    "methods.fem.grids": st.lists(SIDES, max_size=3),
    "methods.fem.depth": EXTREMES,
    "methods.fem.growth": st.floats(1, 4),
    "methods.fem.method": st.sampled_from(["full", "reduced"]),
    "ensemble": ENSEMBLES,
    "effects": st.lists(st.one_of(*EFFECTS), max_size=2),
}
CHANGES = st.lists(
    st.sampled_from(sorted(PLACES)).flatmap(lambda place: st.tuples(st.just(place), PLACES[place])),
    min_size=1,
    max_size=4,
)


def explain_changed(changes):
    """Read and explain a scene with extreme values."""
    tree = {**TREE}
    # Tables before what is in them, or the load of a table that was replaced would be set.
    for place, value in sorted(changes, key=lambda change: -change[0].count(".")):
        tree = changed(tree, place, value)
    if problem(tree):
        return
    try:
        found = explain(Scene.model_validate(tree))
    except UsageError as refusal:
        sentence = str(refusal)
    else:
        sentence = ""
        assert math.isfinite(found.seconds)
        assert all("nan" not in words for _, words in found.facts)
    assert "\n" not in sentence


@settings(suppress_health_check=[HealthCheck.too_slow])
@given(CHANGES)
def test_extreme_scenes_are_refused_or_explained(changes):
    # Large surfaces are looked at by their spectrum; this keeps the others small as well.
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(surfaces, "SURVEYED_POINTS", 2**16)
        explain_changed(changes)


def planned(*arguments):
    """What a study says of its plan, in how many seconds of processor time."""
    began = time.process_time()
    outcome = invoke("study", *arguments, "--dry-run")
    return outcome, time.process_time() - began


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ("heights --periods 1e3", "8000 shortest waves along a side: at most 2048"),
        ("depth --points-per-wave 1e300", r"4e\+300 points along a side of a grid: must be 2 to 1048576"),
        ("depth --depths 1e300", r"study depth: depth = 1e\+297: must be"),
        ("adhesion --bandwidth 1e3", "must rise, for a limit, from above 2 periods bandwidth = 4000"),
    ],
)
def test_a_plan_beyond_reason_is_refused_before_it_is_made(arguments, words):
    outcome, seconds = planned(*arguments.split())
    assert isinstance(outcome.exception, UsageError)
    assert re.search(words, str(outcome.exception))
    assert "\n" not in str(outcome.exception)
    assert seconds < 10


@pytest.mark.nightly
@pytest.mark.parametrize("name", studies())
def test_every_option_of_a_study_at_extremes_is_planned_or_refused_in_a_line(name):
    for flag, field in find_study(name).options.flags().items():
        for value in ("1e-300", "5e-324", "1e300", "1e9", "1e3", "nan", "inf", "0", "-1", "", "2,2"):
            if field.annotation is not bool:
                outcome, seconds = planned(name, f"{flag}={value}")
                ended = f"{name} {flag}={value}: {seconds:.0f} s: {outcome.exception!r}"
                assert outcome.exit_code == 0 or isinstance(outcome.exception, UsageError | RunFailed), ended
                assert "\n" not in str(outcome.exception), ended
                assert seconds < 60, ended


LARGE = Scene.model_validate(changed(TREE, "surface.lambda_short", 1e-9))


def test_a_surface_too_large_to_be_looked_at_is_told_by_its_spectrum():
    facts = dict(explain(LARGE).facts)
    assert facts["realised surface"].startswith("not made here, for it takes 20001 x 10001 points")
    assert "(of C(q))" in facts["Nayak parameter"]
    assert facts["bandwidth"] == "L/lambda_long = 1, lambda_long/lambda_short = 5e+03"


def test_what_the_spectrum_tells_is_near_what_a_surface_has(monkeypatch):
    surface = LARGE.surface.model_copy(update={"lambda_long": 1e-6, "lambda_short": 5e-8})
    field = height_field(surface)
    monkeypatch.setattr(surfaces, "SURVEYED_POINTS", 100)
    told = expected(surface)
    assert isinstance(told, Expected)
    scene = LARGE.model_copy(update={"surface": surface})
    assert (realise(scene).drawn, realise(scene, surveyed=True).drawn) == (True, False)
    monkeypatch.setattr(surfaces, "SURVEYED_POINTS", math.prod(surface.resolving_grid))  # just so many
    assert realise(scene, surveyed=True).drawn
    assert told.rms_height == pytest.approx(field.rms_height, rel=0.05)
    assert told.rms_gradient == pytest.approx(field.rms_gradient, rel=0.02)
    assert told.nayak == pytest.approx(field.nayak, rel=0.1)
    # U = (E*/4) sum q |h(q)|^2: half of what the integral of q C over the plane gives, per E*/2.
    assert 0.25 * told.first_moment == pytest.approx(full_contact_energy(field, modulus=1.0), rel=0.05)


@pytest.mark.parametrize("make", [lambda: height_field(LARGE.surface), lambda: realise(LARGE).field])
def test_a_surface_that_does_not_fit_into_memory_is_refused_in_one_line(monkeypatch, make):
    import psutil

    free = psutil.virtual_memory()._replace(available=2**30)
    monkeypatch.setattr(psutil, "virtual_memory", lambda: free)
    with refused(UsageError, r"20001 x 10001 points and 11\.2 GiB, .* take a lambda_short above 3.* nm"):
        make()
