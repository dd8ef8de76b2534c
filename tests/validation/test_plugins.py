"""A toy effect, a toy method and a toy study, each one file of another package, found by entry points."""

import importlib.util
import json
import re
import sys
from importlib import metadata

import pytest
from processes import run_python
from small_scene import square_scene

from validation import registry
from validation.errors import UsageError
from validation.execution.results import read_results
from validation.solvers import Solver
from validation.studies import find_study

EFFECT = '''
"""A skin of another stiffness that weighs nothing."""
from typing import ClassVar, Literal

from pydantic import Field

from fem_contact.graded import LayeredSolid
from fem_contact.solid import Solid
from validation.effects.base import Effect
from validation.units import Length, Pressure


class Skin(Effect):
    """A skin on the solid."""

    kind: Literal["skin"] = "skin"
    young: Pressure = Field(description="Young's modulus of the skin")
    thickness: Length = Field(description="thickness of the skin")

    slot: ClassVar = "response"
    meshed: ClassVar = False
    papers: ClassVar = ("Skin: A. Nobody, J. Toys 1, 1 (2026).",)

    def fill(self, model):
        skin = Solid(young=self.young, poisson=model.solid.poisson)
        model.response = LayeredSolid(layers=[skin], thicknesses=[self.thickness], base=model.solid)

    def judge(self, rough):
        return self.judgement(f"skin over wave {self.thickness / rough.shortest:.3g}", matters=True)

    @classmethod
    def unlisted(cls, rough):
        return cls.unknown(f"shortest wave {rough.shortest:.3g} m", "a skin")

    @classmethod
    def example(cls, spacing):
        return cls(young=3.0, thickness=0.02)
'''

METHOD = '''
"""Conjugate gradients on the pressures, of Polonsky and Keer."""
from fem_contact import HalfSpace, bem
from validation.solvers.base import Cost, Gridded, Solved, Solver


class Descent(Solver):
    """The textbook's method."""

    name = "descent"
    label = "Descent"
    options = Gridded
    independent = True
    papers = ("Descent: A. Nobody, J. Toys 1, 2 (2026).",)

    def cost(self, size):
        return Cost(pairs=10.0, peak_bytes=10 * 8 * size.points, unknowns=size.points)

    def solve(self, job):
        body, how = HalfSpace(solid=job.model.solid), {"method": "polonsky-keer", "tolerance": 1e-7}
        return Solved(contact=bem.solve(job.field, body, mean_pressure=job.mean_pressure, **how))

    def edge_constant(self, result):
        return 0.1
'''

STUDY = '''
"""Is one surface as good as another?"""
from pydantic import Field

from validation.measurements.common import base_case, base_surface
from validation.measurements.limits import limits_of, solved
from validation.measurements.measurement import press_on_grids
from validation.report.places import gather
from validation.report.estimates import mean
from validation.report.findings import finding
from validation.report.table import Table
from validation.report.views import Views
from validation.studies import StudyOptions


class Options(StudyOptions):
    """How many."""

    surfaces: int = Field(default=2, ge=1, description="how many surfaces")


def run(options, *, bench):
    first = base_case(base_surface(hurst=0.8, periods=1, bandwidth=2, seed=5), pressure=1e7)
    cases = {
        k: press_on_grids(problem=first.further(k), grids=((8, 8), (16, 16)))
        for k in range(options.surfaces)
    }
    parts = {k: limits_of(one) for k, one in solved(bench, cases).items()}
    return mean(gather(parts, surface=range(options.surfaces)), "area")


def views(data):
    return Views(
        table=Table(rows=("load",), columns=("reduced_pressure", "area")),
        findings=[finding("value", "{count} surfaces: {area}.", data, count=data.sizes["surface"])],
    )
'''

ENTRY_POINTS = """[fem_contact.effects]
skin = toy_effect:Skin
[fem_contact.methods]
descent = toy_method:Descent
[fem_contact.studies]
toy = toy_study
"""

SCENE = square_scene(grids="[12, 24]")
SKIN = '[[effects]]\nkind = "skin"\nyoung = "20 MPa"\nthickness = "0.5 um"\n'
DESCENT = "[methods.descent]\ngrids = [12, 24]\n"


@pytest.fixture(scope="module")
def toys(tmp_path_factory):
    """Return a folder that holds the toy package as pip would have installed it."""
    folder = tmp_path_factory.mktemp("toys")
    for name, text in (("toy_effect", EFFECT), ("toy_method", METHOD), ("toy_study", STUDY)):
        (folder / f"{name}.py").write_text(text)
    info = folder / "toys-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: toys\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(ENTRY_POINTS)
    return folder


#: Several commands in one process: exit code, stdout and stderr of each.
ONE_AFTER_THE_OTHER = """
import contextlib, io, json, sys
from validation.cli.commands import main

answers = []
for words in json.loads(sys.argv[1]):
    sys.argv, out, err, code = ["fem-contact", *words.split()], io.StringIO(), io.StringIO(), 0
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            main()
        except SystemExit as end:
            code = end.code or 0
    answers.append([code, out.getvalue(), err.getvalue()])
print(json.dumps(answers))
"""
COMMANDS = ("run skin.toml -q --no-pictures", "explain skin.toml --json", "run both.toml -q")
COMMANDS += ("run descent.toml -q --no-report --json", "study --list", "study toy --surfaces 3 -q")


@pytest.fixture(scope="module")
def answers(toys, tmp_path_factory):
    folder = tmp_path_factory.mktemp("answers")
    for name, more in (("skin", SKIN), ("both", DESCENT + SKIN), ("descent", DESCENT)):
        (folder / f"{name}.toml").write_text(SCENE + more)
    done = run_python("-c", ONE_AFTER_THE_OTHER, json.dumps(COMMANDS), folder=folder, paths=(toys,))
    assert done.returncode == 0, done.stderr
    return folder, dict(zip(COMMANDS, json.loads(done.stdout), strict=True))


def test_an_effect_of_another_package_runs_is_explained_and_stands_in_the_report(answers):
    folder, told = answers
    code, _, err = told[COMMANDS[0]]
    assert code == 0, err
    page = (folder / "results" / "skin" / "report.html").read_text()
    assert "skin over wave" in page
    assert "J. Toys 1, 1" in page
    assert json.loads(told[COMMANDS[1]][1])["effects"][0]["effect"] == "skin"


def test_an_effect_is_refused_by_name_where_a_method_lacks_its_slot(answers):
    code, _, err = answers[1][COMMANDS[2]]
    assert code == 2
    assert "[[effects]] 1 kind = 'skin': method 'descent' does not handle it; handled by: bem" in err


def test_a_method_of_another_package_is_compared_with_boundary_elements(answers):
    folder, told = answers
    code, out, err = told[COMMANDS[3]]
    assert code == 0, err
    assert json.loads(out)["kind"] == "run"
    data = read_results(folder / "results" / "descent").data
    assert set(data.solver.values) == {"bem", "descent"}
    # Both solve the same discrete problem.
    assert 0 < float(data.pressure_difference.sel(solver="descent", grid="12 x 12").squeeze()) < 1e-3


def test_a_study_of_another_package_is_listed_and_leaves_a_report(answers):
    folder, told = answers
    listed = told[COMMANDS[4]][1]
    assert re.search(r"Of other packages\n \*? *toy +Is one surface as good as another\?", listed)
    code, out, err = told[COMMANDS[5]]
    assert code == 0, err
    assert "3 surfaces: " in out
    assert (folder / "results" / "toy" / "report.html").exists()


def test_an_entry_point_that_cannot_be_loaded_is_named(toys, tmp_path):
    info = tmp_path / "broken-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: broken\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[fem_contact.studies]\nlost = no_such_module\n")
    # The command runs in that folder, which Python searches.
    done = run_python("-m", "validation.cli", "study", "--list", "--json", folder=tmp_path, paths=(toys,))
    assert done.returncode == 0
    assert {"area", "toy"} <= set(json.loads(done.stdout))
    assert "entry point lost = no_such_module of fem_contact.studies: left out, cannot be load" in done.stderr


@pytest.mark.parametrize(
    ("module", "words"),
    [
        ("raise ValueError('two\\nlines')", "ValueError: two lines"),
        ("raise SystemExit(3)", "SystemExit: 3"),
        ("class Odd(BaseException): pass\nraise Odd('odd')", "Odd: odd"),
        ("import time\ntime.sleep(60)", "TimeoutError: still importing after 1 s"),
        ("while True:\n    try:\n        while True: pass\n    except ValueError: pass", "TimeoutError"),
        ("x = (", "SyntaxError"),
        ("import os\nprint('loud')\nos.system('echo louder')\nMine = 3", "must be a subclass of"),
    ],
    ids=["raises", "exits", "odd", "sleeps", "spins", "no Python", "prints"],
)
def test_a_package_that_misbehaves_at_import_is_a_warning_and_all_else_works(
    tmp_path, monkeypatch, capfd, module, words
):
    (tmp_path / "bad_plugin.py").write_text(module)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(registry, "_PATIENCE", 1.0)
    entry = metadata.EntryPoint(name="bad", value="bad_plugin:Mine", group="fem_contact.methods")
    monkeypatch.setattr(registry.metadata, "entry_points", lambda group: [entry])
    registry.say_once.cache_clear()
    try:
        known = registry.found_in("validation.solvers", Solver, group="fem_contact.methods")
    finally:
        sys.modules.pop("bad_plugin", None)
    said = capfd.readouterr()
    assert said.out == ""
    (line,) = [line for line in said.err.splitlines() if line.startswith("fem-contact: ")]
    assert "entry point bad = bad_plugin:Mine of fem_contact.methods: left out" in line
    assert words in line
    assert {"bem", "fem"} <= {solver.name for solver in known}


def test_a_name_that_is_taken_is_refused_by_both_names(tmp_path, monkeypatch):
    (tmp_path / "taken_plugin.py").write_text(METHOD.replace('"descent"', '"bem"'))
    monkeypatch.syspath_prepend(tmp_path)
    entry = metadata.EntryPoint(name="x", value="taken_plugin:Descent", group="fem_contact.methods")
    monkeypatch.setattr(registry.metadata, "entry_points", lambda group: [entry])
    with pytest.raises(UsageError, match=r"taken_plugin:Descent .* the name 'bem' is that of validation"):
        registry.found_in("validation.solvers", Solver, group="fem_contact.methods")


STUDIES = """
import json
from validation.execution.bench import Bench
from validation.studies import run, stability

bench = Bench.at("solves")
asked = {"methods": ("bem", "descent"), "periods": 1.0, "bandwidth": 2.0, "surfaces": 2}
beside = {**asked, "method_points_per_wave": (4.0, 6.0), "bench": bench}
cross = run("cross", **beside)
refined = run(
    "refinement", points_per_wave=(3.0, 4.0), grid_scale_grids=(), ladders=False, **beside
)
cost = run(
    "accuracy-cost", points_per_wave=(3.0, 4.0), held_out_points_per_wave=(6.0, 8.0), **beside
)
near = run("stress-near-zero", points_per_wave=(6.0, 8.0, 12.0), bench=bench, **asked)
hard = {case.name: case for case in stability.Options(methods=("descent",)).chosen}
print(json.dumps({
    "cross": {"legs": cross.leg.values.tolist(), "apart": cross.pressure_difference_each.values[0].tolist(),
              "used": cross.attrs["methods"]},
    "refined": {"others": refined.other.values.tolist(), "fem": "depth_share" in refined},
    "cost": cost.way.values.tolist(),
    "near": near.density_at_zero.values.tolist(),
    "hard": [sorted(hard), hard["load-descent"].measure(0.5).error],
}))
"""


@pytest.mark.slow
def test_studies_about_a_solver_take_one_of_another_package(toys, tmp_path):
    (tmp_path / "studies.py").write_text(STUDIES)
    done = run_python("studies.py", folder=tmp_path, paths=(toys,))
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    assert said["cross"]["legs"] == ["descent"]
    assert said["cross"]["used"] == "bem descent perimeter"
    # Both solve the same discrete problem.
    assert max(map(max, said["cross"]["apart"])) < 1e-4
    assert said["refined"]["others"] == ["descent"]
    assert not said["refined"]["fem"]
    ways = {f"descent {area}, {n} per wave" for area in ("pixel", "perimeter") for n in (4, 6)}
    assert {label for label in said["cost"] if not label.startswith("BEM")} == ways
    ours, theirs = said["near"]
    assert theirs[0] == pytest.approx(ours[0], rel=0.05)
    # The hard cases that any solver can be put through; at half of p* it finds the width within cells.
    names, error = said["hard"]
    cases = ("gradient", "hurst", "load", "precision", "scales", "ties")
    assert names == [f"{name}-descent" for name in cases]
    assert error < 2.5


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ("bem,decent", "study cross: method 'decent': no such method; one of: bem, fem"),
        ("bem,theory", "method 'theory': presses no surface"),
        ("bem,tamaas", "tamaas is not installed; install it with: pip install 'fem-contact[peers]'"),
        ("bem,nowhere:solve", "no module 'nowhere' is installed"),
    ],
)
def test_a_method_that_is_none_or_not_installed_is_refused_with_what_to_do(monkeypatch, asked, words):
    find = importlib.util.find_spec
    without = lambda name, *more: None if name == "tamaas" else find(name, *more)  # noqa: E731
    monkeypatch.setattr(importlib.util, "find_spec", without)
    with pytest.raises(UsageError, match=re.escape(words)):
        find_study("cross").parse(["--methods", asked])
