"""The studies: their measurements are right, their sentences are computed, their options are checked."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from refusing import refused

from validation.errors import UsageError
from validation.execution.results import Result
from validation.measurements.common import base_case, base_surface
from validation.measurements.measurement import grid_for, press_on_grids
from validation.scenes import surfaces
from validation.scenes.scene import load_scene
from validation.scenes.tables import SolidSpec
from validation.studies import cross, find_study, studies
from validation.studies._outputs import study_page

SOLID = SolidSpec(young=3e8, poisson=0.25)
SMALL = {"periods": 1.6, "bandwidth": 2.5}


def pressed(*, seed=61, solid=SOLID):
    return base_case(base_surface(hurst=0.6, seed=seed, **SMALL), reduced_pressure=0.05, solid=solid)


def measurement(**changes):
    settings = {"problem": pressed(), "reduced_pressures": (0.05, 0.2), "shifts": 2}
    return press_on_grids(**{**settings, "grids": ((16, 16), (24, 24), (32, 32)), **changes})


@pytest.fixture(scope="module")
def measured():
    return measurement().do()


def test_the_inverted_surface_has_the_same_gradient_and_another_area(measured):
    inverted = measurement(problem=replace(pressed(), inverted=True))
    assert inverted.key != measurement().key
    found = inverted.do()
    assert found.attrs["rms_gradient"] == measured.attrs["rms_gradient"]
    assert not np.allclose(found.pixel.values, measured.pixel.values)


def test_grids_have_the_points_that_are_asked_for():
    surface = base_surface(hurst=0.5, periods=4.0, bandwidth=8.0, seed=1)
    case = base_case(surface, reduced_pressure=0.1)
    assert grid_for(case, 8.0) == (256, 256)
    assert grid_for(case, 3.3) == (106, 106)


def test_a_list_of_one_is_enough_where_nothing_is_compared_along_it():
    for name, options in (("adhesion", "--works 0.1 --magnifications 2"), ("hurst", "--hursts 0.8")):
        find_study(name).parse(options.split())


def test_every_default_of_a_study_is_one_that_could_be_given():
    for study in studies().values():
        usual = study.options()
        for name in study.options.model_fields:
            given = study.options(**{name: getattr(usual, name)})
            assert getattr(given, name) == getattr(usual, name)


#: Options, and the words with which they are refused.
REFUSED = [
    ("adhesion --bandwidth 4 --magnifications 5", "= 5: must lie above 1, at most bandwidth = 4"),
    ("adhesion --grids 96,64", "grids = 96, 64: must rise"),
    ("adhesion --works nan", "--works = 'nan': must be a finite number"),
    ("archard --grids 256,512", "take 512 points or more"),
    ("archard --waves 16", "one for each of --waves"),
    ("graded --ratios 2,1", "ratios = 2, 1: must not be 1"),
    ("hardness --bandwidth 4 --magnifications 5", "= 5: must lie above 1, at most bandwidth = 4"),
    ("hardness --grids ,", "at least 1 value"),
    ("hardness --grids 64", "grids = 64: at least two"),
    ("hardness --grids 64,64", "grids = 64, 64: at least two"),
    ("hardness --periods 0", "--periods = '0': must be greater than or equal to 1"),
    ("hardness --reduced-pressures 0.0 --grids 64,32", "--reduced-pressures = '0.0': must be greater than 0"),
    ("hurst --pairs 2147483648", "10000"),
    ("refinement --bandwidth 0.5", "--bandwidth = '0.5'"),
    ("refinement --elements Hex3", "--elements = "),
    ("refinement --fem-points-per-wave 4,8", "fem_points_per_wave = 4, 8: the limit of the finite elements"),
    ("refinement --hurst 1.4", "--hurst = '1.4'"),
    ("refinement --points-per-wave 8,4", "--points-per-wave = 8,4: must be positive and rising"),
    ("refinement --points-per-wave 2,4", "needs three solves on two grids of at least 3 points per wave"),
    ("energy --points-per-wave 1,2.9", "--points-per-wave = 1,2.9: must be 3 or more: coarser"),
    ("autopsy --bandwidth 6", "bandwidth = 6: no octave ends with a ring; take a power of two"),
    ("autopsy --points-per-wave 2.9,9", "--points-per-wave = 2.9,9: must be 3 or more: coarser"),
    ("autopsy --periods 1 --probe-points-per-wave 3.1,3.9", "probe_points_per_wave: too close"),
    ("autopsy --periods 1 --bandwidth 2 --points-per-wave 3.1,3.9", ": points_per_wave: too close"),
    ("adhesive-magnification --points-per-wave 14.1,15", "must be greater than or equal to 14.2"),
    ("adhesive-magnification --points-per-wave 16,16", "must be positive and rising"),
    ("refinement --shifts 1 --points-per-wave 3,4", "with shifts = 1 a limit over grids needs three solves"),
    ("refinement --surfaces 1", "--surfaces = '1': must be greater than or equal to 2"),
    ("heights --periods 1,1.9", "periods = 1.9, the last: must be at least longer = 2"),
    ("leak --areas nan", "--areas = 'nan': must be a finite number"),
    ("leak --areas 0.3,1.5", "--areas = '1.5': must be less than 0.9"),
    ("leak --areas 0.3,0.2", "--areas = 0.3,0.2: must be positive and rising"),
    ("area --grids 48,32,24", "--grids = 48,32,24: must be positive and rising"),
    ("scaling --grids 64,128", "at least 3"),
    ("scaling --grids 128,64,256", "must be positive and rising"),
    ("scaling --grids 8,64,128", "must be above L/lambda_long"),
    ("scaling --surfaces 2147483648", "10000"),
    *(
        (f"{name} {options}", words)
        for name in ("hurst", "pressure", "magnification", "theory-verdict")
        for options, words in (
            ("--points-per-wave 8,4", "--points-per-wave = 8,4: must be positive and rising"),
            ("--points-per-wave 2,4", "with shifts = 2 a limit over grids needs three solves on two grids"),
            ("--shifts 1 --points-per-wave 4,6", "with shifts = 1 a limit over grids needs three solves"),
            ("--reduced-pressures 0,1", "must be greater than 0"),
            ("--hurzt 4", "unknown option '--hurzt'; did you mean "),
        )
    ),
]


def test_what_did_not_reach_its_residuals_is_counted_by_the_study_of_two_solvers(numbers):
    data = numbers("cross")
    missed = data.converged_each.where(data.converged_each.isnull(), 0.0)
    both = cross.views(data).findings, cross.views(data.assign(converged_each=missed)).findings
    known, found = ([one.text for one in findings if one.kind == "refusal"] for findings in both)
    count = int(missed.notnull().sum())
    assert known == []
    assert found[0].startswith(f"{count} of {count} answers do not have the residuals asked for, the worst ")


@pytest.mark.parametrize(("failures", "told"), [("BEM: a", "BEM: a"), ("BEM: a\nb\nc", "BEM: a, and 2 more")])
def test_a_study_tells_on_its_page_what_failed(numbers, failures, told):
    data = numbers("area").assign_attrs(failures=failures)
    result = Result(kind="study", name="area", settings={}, data=data, store=Path())
    found = study_page(result, figures=False).findings
    assert f"Not all solves succeeded; their methods are left out: {told}." in found


@pytest.mark.parametrize(("asked", "words"), REFUSED)
def test_options_of_a_study_are_refused_by_name_before_anything_runs(asked, words):
    name, *options = asked.split()
    with refused(UsageError, re.escape(words)):
        find_study(name).parse(options)


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("depth", "its surface is the one whose longest wave feels the bottom most"),
        ("scaling", "its surfaces grow with the grid"),
        ("hurst", "it asks about spectra, and makes a surface for each"),
        ("hardness", "it turns load and waves by itself; `area` takes a scene that yields"),
        ("adhesion", "it turns load, waves, work and hardness by itself"),
        ("graded", "it asks about single waves, and presses nothing"),
        ("stability", "it asks about hard cases with known answers"),
    ],
)
def test_a_study_that_cannot_honour_a_scene_refuses_it_by_name_and_says_why(name, why):
    with pytest.raises(UsageError) as caught:
        find_study(name).parse([], scene=load_scene("quickstart"))
    assert str(caught.value) == f"study {name}: takes no scene: {why}; leave 'quickstart' out"


def test_each_solve_of_a_study_shares_one_surface_with_the_others_on_it(bench, monkeypatch):
    drawn = []
    waves = surfaces.waves_of
    monkeypatch.setattr(surfaces, "waves_of", lambda *said: drawn.append(said) or waves(*said))
    grids = {"full_points_per_wave": (4.0,), "reduced_points_per_wave": (4.0, 5.0)}
    cross.run(cross.Options(surfaces=2, periods=1.0, bandwidth=2.0, seed=77, **grids), bench=bench)
    assert len(drawn) == 2
