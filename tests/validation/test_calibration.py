"""Costs of effects: measured on this machine where it was calibrated, on the reference machine otherwise."""

import numpy as np
import pytest
from commanding import answer_of, output_of

from validation.comparison.explain import explain
from validation.effects import effect_kinds
from validation.execution import calibration
from validation.execution.press import solves_of
from validation.execution.solve import transform_seconds
from validation.files import write_record
from validation.solvers import find_solver
from validation.solvers.base import example_field

EFFECT = '[[effects]]\nkind = "hardness"\nhardness = "40 kPa"\n'
USUAL = {name: kind.cost for name, kind in effect_kinds().items() if find_solver("bem").handles(kind)}


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setenv("LOCALAPPDATA", str(tmp_path / "cache"))
    return calibration.cache_file()


def test_without_a_calibration_the_reference_machine_is_named(cache):
    assert not cache.exists()
    assert calibration.effect_costs().factors == USUAL
    assert "fem-contact calibrate" in calibration.effect_costs().source


def test_a_pair_of_transforms_takes_the_median_of_five_times_of_one(monkeypatch):
    def told(action, number, repeat):
        return [number * seconds for seconds in (5.0, 1.0, 3.0, 2.0, 9.0)[:repeat]]

    monkeypatch.setattr("timeit.repeat", told)
    assert transform_seconds() == 3.0


def test_a_calibration_is_kept_and_used_and_named(cache, read_scene):
    lines = []
    found = calibration.calibrate(points=32, repeats=1, tell=lines.append)
    assert set(found.factors) == set(USUAL)
    assert all(value > 0 for value in found.factors.values())
    assert len(lines) == len(found.factors) + 1
    assert calibration.effect_costs() == found
    scene = read_scene(EFFECT)
    text = "\n".join(part for part in explain(scene).parts() if isinstance(part, str))
    assert f"hardness {found.factors['hardness']:.2g} times (measured on this machine" in text


def test_an_effect_that_hardly_matters_is_told_with_what_it_costs(cache, read_scene):
    cost = calibration.effect_costs().factors["hardness"]
    for hardness, told in (("40 kPa", False), ("4 GPa", True)):
        plan = explain(read_scene(EFFECT.replace("40 kPa", hardness)))
        (judgement,) = plan.effects
        assert (f"it costs {cost:.2g} times the plain solve" in judgement.verdict) == told


def test_the_command_says_where_a_calibration_is_kept(cache, monkeypatch):
    monkeypatch.setattr(calibration, "calibrate", lambda points, tell: calibration.effect_costs())
    assert output_of("calibrate").strip() == f"Kept in {cache}"
    assert answer_of("calibrate")["factors"] == USUAL


def test_a_prediction_grows_with_the_factor_that_was_measured(cache, read_scene):
    solve, seconds = solves_of(read_scene(EFFECT))[0], []
    cache.parent.mkdir(parents=True)
    for factor in (1.0, 1e4):
        write_record(cache, {"date": "2026-01-01", "factors": USUAL | {"hardness": factor}})
        seconds.append(solve.predict().seconds)
    assert seconds[1] > 2 * seconds[0]


@pytest.mark.parametrize(
    "text", ["", "[1]", '{"factors": {"hardness": 1.0}, "date": "x"}', '{"factors": 3, "date": "x"}']
)
def test_a_damaged_or_foreign_cache_is_as_none(cache, text):
    cache.parent.mkdir(parents=True)
    cache.write_text(text)
    costs = calibration.effect_costs()
    assert costs.factors == USUAL
    assert f"{cache}: damaged, or of another version" in costs.source


def test_waves_that_effects_are_tried_on_are_those_that_the_grid_carries():
    for points, carried in ((12, {4}), (16, {4}), (64, {4, 8, 16})):
        field = example_field(points)
        assert set(np.flatnonzero(abs(np.fft.rfft(field.heights[:, 0])) > 1e-9)) - {0} == carried
        assert field.rms_gradient == pytest.approx(0.1)
