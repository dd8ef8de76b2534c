"""The independent reader: silent on a sound run, and it finds each number that was changed."""

import math
import os
import re
import shutil
import signal
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from commanding import invoke, output_of
from small_scene import GRIDS, HARD, ONE_BODY, SQUARE_CELLS, STICKY, ensemble

from fem_contact import ContactAreas, contact_areas, located_limit, perimeter_limit
from fem_contact.area import EDGE_CONSTANTS, EDGE_MAPS, TRAITS
from persson.hardness import constant_hardness
from validation.audit import audit, stored
from validation.audit.dataset import Result
from validation.audit.ledger import Ledger, printed
from validation.audit.limits import limit_over
from validation.audit.reading import judge_fields, judge_surfaces
from validation.audit.runs import Run, _cases, _of_solves, audit_run, yielded_areas
from validation.comparison.accuracy import run_accurate
from validation.comparison.run import run_sweep
from validation.errors import RunFailed, UsageError
from validation.execution.press import Press
from validation.execution.results import read_results, write_results
from validation.files import read_record, write_record
from validation.scenes.problem import realise
from validation.scenes.sweep import load_asked
from validation.units import Duration, read_quantity


@pytest.fixture
def copied(small_run, tmp_path):
    """A copy of the results of the small scene, to be damaged."""
    return shutil.copytree(small_run.folder, tmp_path / "results")


def sound(folder):
    """The ledger of results in which nothing is wrong."""
    ledger = audit(folder)
    assert [str(entry) for entry in ledger.wrong] == []
    return ledger


@pytest.fixture
def audited(solved):
    """Run the small scene so changed, and read it back: nothing is wrong."""
    return lambda *changes: sound(solved(*changes).folder)


def _changed(folder, change):
    """Change the dataset of a run, and its record with it, as a mistake of the comparison would."""
    found = read_results(folder)
    data = change(found.data.copy(deep=True))
    kept = {"kind": found.kind, "name": found.name, "settings": found.settings, "store": found.store}
    write_results(folder, data, **kept)
    return {entry.name for entry in audit(folder).wrong}


def test_every_number_of_the_small_run_follows_from_its_fields(small_run):
    ledger = sound(small_run.folder)
    assert len(ledger.entries) > 700
    names = {line.removeprefix("data.nc: ").partition(",")[0] for line in ledger.unread if "data.nc" in line}
    assert names == {*_LISTED.split()} - {"area_located_error", "area_located_shift"}


def test_an_edge_of_neither_pressure_nor_gap_lies_where_the_solver_has_it(read_scene):
    solve = Press(method="bem", grid=(32, 16), problem=realise(read_scene(SQUARE_CELLS, fem=False)))
    whole = solve.do(threads=1)
    touching = whole.contact.in_contact
    within = tuple(np.argwhere(touching & ~np.roll(touching, -1, 0))[0])
    pressure, gap = whole.contact.pressure.copy(), whole.contact.gap.copy()
    pressure[within] = gap[(within[0] + 1) % 32, within[1]] = 0.0
    bare = replace(whole, contact=replace(whole.contact, pressure=pressure, gap=gap))
    found = stored.Stored(solve.encode(bare)).subcell
    assert found == pytest.approx(contact_areas(bare.contact, subcell=True).subcell, rel=1e-9)


#: What is not computed again of a run of the half-space, and listed.
_LISTED = """
area_cheapest_off area_limit_error area_located_error area_located_shift
area_perimeter_difference_order area_perimeter_finest area_pixel_difference_order area_pixel_error
area_pixel_finest density_at_zero_order density_near density_near_persson density_wide
density_wide_persson deviation_perimeter deviation_persson deviation_pixel heights patches
patches_error power_spectrum power_spectrum_told pressure_difference_order pressure_map
pressure_map_difference residual_finest seconds_cheapest stiffness stiffness_error stress_near
stress_near_exact stress_variance stress_wide stress_wide_exact surfaces wave_long
"""


def _run(folder):
    """The stored solves of a results folder."""
    result = Result(folder)
    return Run(result.record["asked"]["scene"], partial(result.solve, read=stored.Stored), result.data)


def wrong_of(judge, *judged):
    """Names of what a part of the audit finds wrong."""
    ledger = Ledger()
    judge(*judged, ledger)
    return [entry.name for entry in ledger.wrong]


def _moved(variables, name, by):
    """The variables of a dataset with one number changed."""
    values = variables[name].values.copy()
    first = np.flatnonzero(np.isfinite(values.ravel()) & (values.ravel() != 0))[:1]
    values.ravel()[first] = by(values.ravel()[first])
    return {**variables, name: variables[name].copy(data=values)}


def test_each_number_of_the_dataset_that_is_not_what_it_was_is_found_by_name(small_run):
    result, unnoticed = Result(small_run.folder), []
    whole = result.data
    for k, (name, variable) in enumerate(whole.items()):
        listed = name in {*_LISTED.split(), *variable.dims} or variable.dtype.kind != "f"
        if not listed and np.nansum(np.abs(variable.values)) > 0:
            result.data = _moved(whole, name, lambda x, k=k: 1.01 * x if k % 2 else np.nan)
            wrong = {entry.name for entry in audit_run(result)[0].wrong}
            unnoticed += [] if any(place.startswith(name) for place in wrong) else [name]
    assert unnoticed == []


#: What stands in place of the theory of the small scene, and other changes of it.
_COAT = '[[effects]]\nkind = "coating"\nyoung = "5 MPa"\npoisson = 0.3\nthickness = "2 um"'
_LAYER = '[[effects]]\nkind = "thickness"\nthickness = "3 um"'
_MELT = 'temperature = "370 K"\nsurface_tension = "0.04 J/m^2"\nlambda_bend = "3 um"'


def _load(text):
    return ("reduced_pressure = 0.1", text)


def _on(grids):
    return (f"{GRIDS}\nshifts = 2", f"grids = {grids}")


def _asked(*changes, judged, moved=""):
    return changes, judged.split(" | "), moved


_COARSE = "area_own | resolved of 8 x 8 | mean_gap_error"
_GAUSSIAN = ("seed = 77", 'seed = 77\namplitudes = "gaussian"')
#: What is other than in the small scene, what is judged then, and what is found where it is moved.
ASKED = {
    "located edges": _asked(SQUARE_CELLS, judged="area_located | area_limit"),
    # Gaussian amplitudes and a pressure in Pa: each surface has its own gradient, and its own theory.
    "an ensemble of all": _asked(
        *(ensemble(3, "[16, 32]"), _on("[6, 16, 32]\nunder_resolved = true")),
        *(_GAUSSIAN, _load('pressure = "11 kPa"')),
        judged="area_ratio_each at (0,) | area_error, surfaces | scatter | area_persson_each of surface 2"
        " | resolved of 6 x 6",
    ),
    # Without the shifts of its first surface.
    "an ensemble": _asked(ensemble(2), judged="area_each of surface 1"),
    # Its surfaces are not the bodies of one contact.
    "melts": _asked(
        *(ensemble(2), ("self-affine", "capillary-waves"), ("hurst = 0.7", _MELT)),
        ("rms_gradient = 0.05\n", ""),
        judged="area_each of surface 1",
    ),
    "hardness": _asked(
        HARD,
        judged="area_plastic_persson | area_persson_own | area_ensemble | area_plastic_pixel of bem 48 x 32",
        moved="area_plastic_persson",
    ),
    # Where it yields under attraction the bound is what pushes back.
    "hardness and adhesion": _asked(STICKY + HARD, judged="residual, complementarity"),
    "coating": _asked(
        *(ONE_BODY, ("[methods.theory]", _COAT)), judged="contact_modulus", moved="surface_modulus"
    ),
    # Where no grid resolves the surface all count, and else those that do.
    "coarse grids": _asked(_on("[6, 8]\nunder_resolved = true"), judged=_COARSE),
    "coarse and fine grids": _asked(_on("[6, 8, 24, 32]\nunder_resolved = true"), judged=_COARSE),
    # A single grid tells its area however few points touch.
    "one grid": _asked(_on("[24]"), _load("reduced_pressure = 0.005"), judged="area_own"),
    # The load is that of the finest grid unshifted.
    "a distance": _asked(_load('offset = "50 nm"'), judged="pressure | reduced_pressure", moved="pressure"),
    "a distance under attraction": _asked(STICKY, _load('offset = "20 nm"'), judged="residual, load"),
    # What is infinite is nothing in JSON.
    "heat": _asked(
        *(_load("reduced_pressure = 4.0"), '[quantities.thermal]\nconductivity = "4 W/(m K)"\n'),
        judged="numbers: thermal_conductance",
    ),
    "an exponent of one": _asked(("hurst = 0.7", "hurst = 1.0"), judged="rms_height_spectrum"),
}


@pytest.mark.parametrize("case", ASKED)
def test_every_number_follows_from_the_fields_whatever_was_asked(audited, tmp_path, case):
    changes, judged, moved = ASKED[case]
    entries = audited(*changes).entries
    names = [entry.name.removeprefix("bem ") for entry in entries]
    if case == "one grid":  # few points touch
        assert 0 < next(entry.found for entry in entries if entry.name == "area_own") < 16 / 24**2
    assert [part for part in judged if not any(name.startswith(part) for name in names)] == []
    if moved:
        assert moved in _changed(tmp_path / "results", lambda d: d.assign({moved: 1.01 * d[moved]}))


def test_of_a_sweep_with_a_case_that_failed_the_others_are_judged(write_scene, tmp_path):
    scene = write_scene(_load('offset = "50 nm"'), fem=False)
    swept = load_asked(str(scene), ["sweep.load.offset=['50 nm', '1 mm']"])
    run_sweep(swept, tmp_path / "out", report=False)
    ledger = sound(tmp_path / "out")
    assert any(entry.name == "area_own at offset = 5e-08" for entry in ledger.entries)
    assert "offset = 0.001: its solves failed" in ledger.unread


def test_with_adhesion_tension_and_balance_are_judged_and_the_theory_is_listed(audited, tmp_path):
    ledger = audited(STICKY)
    names = {entry.name for entry in ledger.entries}
    assert {"residual, tension", "residual, complementarity", "residual of bem 48 x 32"} <= names
    run = _run(tmp_path / "results")
    one = run.solves["bem", (24, 16), (0.0, 0.0), 0]
    one.p[~one.contact] -= 0.1 * abs(one.p.min())
    assert {"residual, tension", "residual, complementarity"} <= {*wrong_of(judge_fields, 0, one, run)}
    finer = run.solves["bem", (48, 32), (0.0, 0.0), 0]
    finer.gap[finer.contact] -= 1e-3 * np.std(finer.h)
    assert "residual, penetration" in wrong_of(judge_fields, 0, finer, run)


def test_residuals_under_a_law_that_is_not_read_are_listed(audited):
    ledger = audited(STICKY + 'law = "dugdale"\n')
    assert "residuals under an attraction of another law than the exponential" in " ".join(ledger.unread)
    assert "residual, tension" not in {entry.name for entry in ledger.entries}


@pytest.mark.parametrize("variance", [1e-5, 9e-4, 1.1e-3, 0.1, 3.0])
@pytest.mark.parametrize("pressure", [0.02, 0.3, 0.97])
def test_areas_of_one_hardness_are_those_of_the_theory(pressure, variance):
    known = constant_hardness(stress_variance=variance, pressure=pressure, yield_stress=1.0)
    found = yielded_areas(2 * pressure, variance=4 * variance, hardness=2.0)
    assert found == pytest.approx((float(known.plastic), float(known.elastic)), rel=1e-9, abs=1e-12)


def test_the_displacement_of_a_bonded_layer_is_judged(audited, tmp_path):
    audited(ONE_BODY, ("[methods.theory]", _LAYER))
    run = _run(tmp_path / "results")
    one = run.solves["bem", (24, 16), (0.0, 0.0), 0]
    run.effects[0]["thickness"] *= 1.1
    run.__dict__.pop("depth", None)
    assert wrong_of(judge_fields, 0, one, run) == ["u against 2 p / (E* q)"]


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (
            ["sweep.load.pressure=['5 kPa', '10 kPa']", "sweep.effects.hardness.hardness=['200 kPa', 60e3]"],
            "pressure = 5000.0, hardness = 60000.0",
        ),
        (["sweep.methods.bem.grids=[[12, 24], [16, 32]]"], "grids = 16x16, 32x32"),
        (["ensemble.grids=[12, 24]", "sweep.ensemble.realisations=[2, 3]"], "realisations = 3"),
        (["grids=[[24, 48]]", "sweep.length=['10 um', ['10 um', '20 um']]"], "length = 10 um, 20 um"),
        # The other method has a tolerance of its own.
        (["sweep.methods.bem.tolerance=[1e-8, 1e-6]", "methods.fem.grids=[12]"], "tolerance = 1e-06"),
        # Grids that are chosen differ, too.
        (["sweep.lambda_short=['2.5 um', '2 um']"], "lambda_short = 2e-06"),
    ],
)
def test_a_sweep_of_whatever_key_is_read_by_the_scenes_of_its_cases(
    write_scene, tmp_path, bench, settings, words
):
    chosen = f"{GRIDS}\n" if "lambda" in settings[0] else ""
    scene = write_scene((f"{chosen}shifts = 2", "" if chosen else "shifts = 1"), fem=False)
    run_sweep(load_asked(str(scene), settings), tmp_path / "swept", bench=bench, report=False)
    ledger = sound(tmp_path / "swept")
    assert any(entry.name.endswith(words) for entry in ledger.entries)
    data = read_results(tmp_path / "swept").data
    name = next(iter(data.sizes))
    if data[name].dtype.kind == "f":
        wrong = _changed(tmp_path / "swept", lambda d: d.assign_coords({name: 1.01 * d[name]}))
        assert any(entry.startswith(f"{name} at (") for entry in wrong)


def test_a_sweep_whose_record_has_no_cases_is_refused_by_name():
    with pytest.raises(LookupError, match="swept by an earlier version"):
        audit_run(SimpleNamespace(record={"asked": {"scene": {}, "sweep": {}}}))


def test_a_case_of_a_sweep_that_is_not_at_its_place_is_found():
    effects = [{"effects": [{"kind": "hardness", "hardness": value}]} for value in (1.0, 3.0)]
    keys = [{"key": "effects.hardness.hardness", "name": "hardness", "values": [1.0, 2.0]}]
    ledger, asked = Ledger(), {"sweep": {"mode": "product", "keys": keys}, "cases": effects, "scene": {}}
    result = SimpleNamespace(data={"hardness": SimpleNamespace(values=np.array([1.0, 2.0]))})
    assert [at for _, at, _ in _cases(asked, result, ledger)] == [{"hardness": 0}, {"hardness": 1}]
    assert [entry.name for entry in ledger.wrong] == ["effects.hardness.hardness at hardness = 2.0"]


def test_what_a_run_to_an_accuracy_claims_follows_from_its_fields(read_scene, tmp_path):
    outputs = run_accurate(read_scene(ensemble(2)), tmp_path / "results", target=0.3, report=False)
    spent = re.search(r"It cost \d+ solves, .*?(\S+) s \(", outputs.more[-1])[1]
    (card,) = [card for card in outputs.page.answers if card.question == "What did it cost?"]
    answer = read_quantity(Duration, card.answer, card.question)
    assert outputs.data.wall_seconds.item() == pytest.approx(float(spent), rel=0.06)
    assert outputs.data.wall_seconds.item() == pytest.approx(answer, rel=0.01)
    ledger = sound(tmp_path / "results")
    assert "area_own_error of source 1" in {entry.name for entry in ledger.entries}
    wrong = _changed(tmp_path / "results", lambda d: d.assign(area_own_error=d.area_own_error / 2))
    assert "area_own_error of source 1" in wrong


def test_a_number_agrees_within_its_tolerance_and_no_further():
    ledger = Ledger()
    for part in (0.9, 1.1):
        ledger.number("here", "a number", 1 + part * 1e-9, 1.0)
        ledger.number("here", "an array", np.array([1.0, 2 + part * 2e-9]), np.array([1.0, 2.0]))
    assert [entry.agrees for entry in ledger.entries] == [True, True, False, False]


def test_a_grid_whose_solve_is_not_stored_is_named(small_run):
    run = _run(small_run.folder)
    run.solves = {key: solve for key, solve in run.solves.items() if key[:2] != ("bem", (24, 16))}
    with pytest.raises(LookupError, match=r"^no stored solve of bem on 24 x 16$"):
        list(_of_solves(run))


def test_fields_that_break_their_own_definitions_are_found(small_run):
    run = _run(small_run.folder)
    (one,) = [solve for key, solve in run.solves.items() if key[:2] == ("fem", (24, 16))]
    one.gap[0, 0] += 1e-9
    one.p[one.contact] *= 1.001
    broken = {"gap less u - h + offset, over the height", "mean pressure [Pa]"}
    assert broken <= {*wrong_of(judge_fields, 0, one, run)}


def test_surfaces_that_share_one_seed_are_found(small_run):
    run = _run(small_run.folder)
    key = ("bem", (24, 16), (0.0, 0.0), 0)
    run.solves[(*key[:3], 1)] = run.solves[key]
    assert wrong_of(judge_surfaces, run) == ["surfaces that differ"]


def test_a_shift_in_the_other_direction_is_found(small_run):
    run = _run(small_run.folder)
    # Without the surface as it stands there is nothing that was moved.
    del run.solves["bem", (12, 8), (0.0, 0.0), 0]
    one = run.solves[("bem", (24, 16), (0.0, 0.5), 0)]
    one.h = np.roll(one.h, 1, axis=1)
    assert {*wrong_of(judge_surfaces, run)} == {"heights against those moved by the shift"}


def test_the_command_exits_with_one_where_a_number_disagrees(small_run, copied):
    counts = re.findall(r"^(.+): (\d+) agree$", output_of("audit", small_run.folder), re.MULTILINE)
    assert sum(int(count) for _, count in counts) == len(audit(small_run.folder).entries)
    assert {"data.nc", "table.csv", "fields of the solves"} <= {place for place, _ in counts}
    _changed(copied, lambda data: data.assign(area_own=1.01 * data.area_own))
    damaged = invoke("audit", copied)
    assert damaged.exit_code == 1
    assert "data.nc: area_own: found" in damaged.output


def test_the_command_refuses_a_folder_without_a_run_of_this_version(tmp_path, copied):
    assert "cannot be audited" in str(invoke("audit", tmp_path).exception)
    record = read_record(copied / "result.json")
    write_record(copied / "result.json", record | {"format": "fem-contact result 1"})
    assert "not of this version; run it again" in str(invoke("audit", copied).exception)


def _pipe(path):
    os.mkfifo(path)


def _link_out(path):
    outside = path.parent.parent.parent / f"outside-{path.name}"
    outside.write_text("{}")
    path.symlink_to(outside)


def _nested(path):
    path.write_text("[" * 1_000_000)


@pytest.mark.parametrize("hostile", [_pipe, _link_out, _nested, Path.mkdir])
def test_a_hostile_folder_ends_in_a_line_within_seconds(copied, hostile):
    def late(*_):
        pytest.fail(f"{path.name}: no end")  # no Exception, which the command might take for one of a file

    before = signal.signal(signal.SIGALRM, late)
    names = "result.json data.nc summary.json table.csv report.html solves/*.nc figures/*.nc"
    try:
        for name in names.split():
            path = sorted(copied.glob(name))[0]
            whole = path.read_bytes()
            path.unlink()
            hostile(path)
            signal.alarm(60)
            outcome = invoke("audit", copied)
            assert isinstance(outcome.exception, UsageError | RunFailed), (path, repr(outcome.exception))
            assert str(outcome.exception).count("\n") == 0
            path.rmdir() if path.is_dir() else path.unlink()
            path.write_bytes(whole)
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


@pytest.mark.parametrize(
    ("text", "value", "digits", "agrees"),
    [
        ("27 %", 0.2751, None, False),
        ("0.1", 0.10004, 4, True),
        ("0.1", 0.10006, 4, False),
        ("1.1e-10", 1.149e-10, None, True),
        ("-0.20 %", 0.002, None, False),
        ("12,096", 12096, None, True),
        ("0.13", 0.125, None, True),
        ("", float("nan"), None, True),
    ],
)
def test_a_printed_number_agrees_to_half_a_unit_of_its_last_digit(text, value, digits, agrees):
    assert printed(text, value, digits=digits) is agrees


def test_constants_of_edges_stand_twice_and_agree():
    assert {key: c for key, c in EDGE_CONSTANTS.items() if key != "fem"} == stored.EDGE_CONSTANTS
    assert EDGE_CONSTANTS["fem"] == EDGE_CONSTANTS["Hex1"]
    second = np.ravel(list(stored.EDGE_BEND.values()))
    assert (*stored.EDGE_MAP.ravel(), *second) == EDGE_MAPS["bem"]


@pytest.mark.parametrize("located", [True, False])
def test_limits_are_those_of_the_error_law_whatever_the_grids(located):
    """Up to four grids of oblong cells, shifted or not, on coarse ones of which nothing may be left."""
    rng, seen = np.random.default_rng(20), set()
    for _ in range(300):
        true, edges, constant = rng.uniform(0.02, 0.97), 10 ** rng.uniform(-1, 2.5), rng.uniform(0.09, 0.14)
        traits = {name: rng.uniform(0, 1) ** 4 for name in TRAITS}
        areas = []
        for n in rng.choice([16, 24, 32, 48, 96, 256], size=rng.integers(1, 5), replace=False):
            shape, empty = (int(n), int(n * rng.choice([1, 2]))), rng.uniform() < 0.2
            for _ in range(rng.integers(1, 3)):
                share = min(edges / n, 4.0) * true * (1 - true)
                pixel = min(true + share * rng.uniform(0.05, 0.2), 1.0)
                subcell = 0.0 if empty else true + share * rng.normal() * 0.01
                grid = {"spacing": (2.0 / shape[0], 1.0 / shape[1]), "cells": shape[0] * shape[1]}
                edge = {"edge_length": math.nan, "edge_fraction": share, "edge_constant": constant}
                counted = {"pixel": pixel, "perimeter": pixel - constant * share, "subcell": subcell}
                areas.append(ContactAreas(**counted, **edge, **grid, **traits))
        ours = (located_limit if located else perimeter_limit)(areas)
        read = [SimpleNamespace(edges=area.edge_fraction, located=located, **asdict(area)) for area in areas]
        expected = pytest.approx((ours.value, ours.uncertainty), rel=1e-8, abs=1e-12, nan_ok=True)
        assert limit_over(read) == expected, areas
        seen.add((len({area.spacing for area in areas}), ours.determinable))
    assert {(1, True), (2, True), (3, True), (1, False), (2, False)} <= seen


def test_places_are_named_by_both_sides_of_their_grids(small_run):
    entries = sound(small_run.folder).entries
    for name in ("E* [Pa]", "h'_rms of the surface pressed", "surfaces that differ"):
        grids = {re.findall(r"\d+x\d+", entry.place)[0] for entry in entries if entry.name == name}
        assert grids == {"12x8", "24x16", "48x32"}, name
