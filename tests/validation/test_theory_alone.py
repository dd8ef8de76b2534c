"""Scenes of the theory alone: the paper's applications, run as every other scene is; mistakes named."""

import csv
import json
import math

import numpy as np
import pytest
from commanding import answer_of, output_of
from processes import run_python
from small_scene import scene_in

from persson import CapillaryWaves, Scale, SelfAffine, constant_hardness
from validation.comparison.explain import explain, roughness_of
from validation.comparison.run import report_scene, run_scene
from validation.effects.base import Roughness
from validation.errors import SceneError, UsageError
from validation.execution.press import solves_of
from validation.scenes.checks import check_scene
from validation.scenes.problem import ContactProblem, realise
from validation.scenes.scene import load_scene
from validation.scenes.surfaces import spectrum_of
from validation.solvers.theory import TheoryOptions, against_magnification, predict

APPLICATIONS = ("pmma-silane", "polished-steel", "pyrex", "pyrex-squeezed", "tire-rim")

RIM = """
name = "mine"
[surface]
kind = "self-affine"
length = "62.83185307179586 um"
hurst = 0.8
lambda_long = "62.83185307179586 um"
lambda_short = "0.6283185307179586 nm"
rms_height = "0.5 um"
[solid]
young = "10 MPa"
poisson = 0.5
[load]
pressure = "0.5 MPa"
[methods.theory]
"""

THEORY = "[methods.theory]"
HARD = 'kind = "hardness"\nhardness = "'
SMOOTH = 'kind = "smoothing"\nhardness = "5 MPa"'
WAVES = """
name = "waves"
[surface]
kind = "capillary-waves"
length = "100 nm"
lambda_long = "50 nm"
lambda_short = "12.5 nm"
lambda_bend = "4 nm"
temperature = "370 K"
surface_tension = "0.04 J/m^2"
seed = 77
[solid]
young = "2.9 GPa"
poisson = 0.35
[load]
reduced_pressure = 0.1
[methods.theory]
[methods.bem]
grids = [24, 48]
"""


@pytest.fixture
def scene(tmp_path):
    def write(text, *changes):
        for old, new in changes:
            assert old in text, old
            text = text.replace(old, new)
        return scene_in(tmp_path, text, name="mine")

    return write


def answers(scene):
    problem = realise(scene)
    check_scene(scene, problem)
    return against_magnification(problem, scene.effects, scene.methods.theory)


def with_effect(text, effect):
    return f"{text}\n[[effects]]\n{effect}\n"


def test_scenes_say_the_spectra_of_the_paper():
    from validation.paper import systems

    ours = spectrum_of(load_scene("pmma-silane").surface), spectrum_of(load_scene("polished-steel").surface)
    for found, paper in zip(ours, (systems.pmma(), systems.steel()), strict=True):
        assert found.q_short == pytest.approx(paper.q_short, rel=1e-15)
        assert found.moments().rms_gradient == pytest.approx(paper.moments().rms_gradient, rel=1e-12)


def test_without_effects_the_contact_is_elastic(scene):
    (answer,) = answers(scene(RIM))
    assert answer.area[-1] == pytest.approx(0.060086, abs=5e-7)
    assert answer.work is None
    assert answer.error_estimate == 0


def test_every_effect_and_every_reading_changes_the_result(scene):
    (plain,) = answers(scene(RIM))
    sticky = 'kind = "adhesion"\nwork = "0.01 J/m^2"'
    for effect in (
        sticky,
        f'{HARD}5 MPa"',
        f'{HARD}5 MPa"\nsize_wavelength = "0.6 um"\nsize_exponent = 0.1',
        'kind = "coating"\nyoung = "2 MPa"\nthickness = "10 um"',
        f'{SMOOTH}\npressure = "0.5 MPa"',
    ):
        (changed,) = answers(scene(with_effect(RIM, effect)))
        assert changed.area[-1] > 1.01 * plain.area[-1], effect
    (improved,) = answers(scene(with_effect(RIM, sticky)))
    strong = 'ideal_strength = "1 MPa"'
    for reading in ('energy = "old"', 'energy = "as_printed"', 'area = "projected"', strong):
        (other,) = answers(scene(with_effect(RIM + reading, sticky)))
        assert abs(other.area[-1] / improved.area[-1] - 1) > 10 * improved.error_estimate, reading


def test_the_theory_alone_speaks_in_the_units_of_its_scene(scene, tmp_path):
    asked = scene(RIM, ('"10 MPa"', '"10000 kPa"'), ('"0.5 MPa"', '["2 bar", "5 bar"]'))
    outputs = run_scene(asked, tmp_path / "results")
    first, second, *_ = map(str, outputs.page.findings)
    assert first.startswith("At p0 = 2 bar (p* = ")
    assert second.startswith("At p0 = 5 bar (p* = ")
    page = (tmp_path / "results" / "report.html").read_text("utf-8")
    assert "p<sub>0</sub> = 2 bar to 5 bar" in page
    assert "= 13330 kPa" in page


def test_the_theory_alone_names_an_elastic_rough_body(scene, tmp_path):
    both = scene(RIM, ("[load]", 'second_young = "20 MPa"\nsecond_poisson = 0.4\n[load]'))
    assert run_scene(both, tmp_path, report=False).page.lead.startswith("Elastic rough surface on an elastic")


def test_a_list_of_loads_is_answered_load_by_load(scene):
    many = answers(scene(RIM, ('pressure = "0.5 MPa"', 'pressure = ["0.1 MPa", "0.5 MPa", 2e6]')))
    assert [answer.pressure for answer in many] == [1e5, 5e5, 2e6]
    (one,) = answers(scene(RIM))
    np.testing.assert_array_equal(many[1].area, one.area)


@pytest.mark.parametrize("loads", [4, 6])
def test_of_more_than_four_loads_the_table_has_the_rest(scene, tmp_path, loads):
    many = scene(RIM, ('pressure = "0.5 MPa"', f"pressure = {[1e5 * (k + 1) for k in range(loads)]}"))
    found = run_scene(many, tmp_path / "out", report=False).page.findings
    assert any(f"The table has {loads - 4} more loads." in text for text in found) == (loads > 4)


def test_no_surface_is_drawn_for_the_theory_alone(scene, monkeypatch, tmp_path):
    def drawn(*arguments, **options):
        raise AssertionError("a surface was drawn")

    monkeypatch.setattr("validation.scenes.surfaces.random_waves", drawn)
    # With a seed, too: C(q) alone answers.
    loaded = scene(RIM, ('rms_height = "0.5 um"', 'rms_height = "0.5 um"\nseed = 5'))
    run_scene(loaded, tmp_path / "out")
    explain(loaded)
    assert solves_of(loaded) == ()


def test_an_earlier_squeezing_takes_what_yielded_from_the_spectrum(scene):
    (smooth,) = answers(scene(with_effect(RIM, f'{SMOOTH}\npressure = "0.5 MPa"\nform = "sharp"')))
    exact = SelfAffine.from_rms_height(5e-7, hurst=0.8, q_long=1e5, q_short=1e10)
    scale = Scale(exact, contact_modulus=1e7 / 0.75)
    last = smooth.wavevectors[-1]
    assert last < 1e10
    half = constant_hardness(5e5, stress_variance=scale.variance(last), yield_stress=5e6).plastic * 10
    # The last of 400 wavevectors at which at most half had yielded.
    assert 0.4 < half <= 0.5


def test_what_is_not_listed_is_not_imported(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(RIM, encoding="utf-8")
    code = (
        "import sys\n"
        "from validation.scenes.scene import load_scene\n"
        "from validation.scenes.problem import realise\n"
        "from validation.solvers.theory import against_magnification\n"
        f"scene = load_scene({str(path)!r})\n"
        "against_magnification(realise(scene), scene.effects, scene.methods.theory)\n"
        "unwanted = {'numba', 'matplotlib', 'persson.adhesion', 'persson.hardness', 'persson.graded'}\n"
        "print(sorted(unwanted & set(sys.modules)))\n"
    )
    done = run_python("-c", code)
    assert done.stdout.strip() == "[]", done.stderr


@pytest.mark.parametrize(
    ("old", "new", "named"),
    [
        ('rms_height = "0.5 um"', "", "'rms_gradient' and 'rms_height'; found none"),
        ('pressure = "0.5 MPa"', "pressure = 0.0", r"load\.pressure: 0 needs the effect 'adhesion'"),
        ('pressure = "0.5 MPa"', "pressure = [1e5, 0.0]", r"load\.pressure: 0 needs the effect 'adhesion'"),
        ('pressure = "0.5 MPa"', "pressure = []", r"load\.pressure = \[\]"),
        ('pressure = "0.5 MPa"', 'pressure = ["1 MPa", "2 s"]', r"load\.pressure \(item 2\) = '2 s'"),
        (THEORY, f"{THEORY}\nenergy = 'new'", r"methods\.theory\.energy = 'new'"),
        (THEORY, "", "methods: missing"),
        (THEORY, "[methods]", r"give at least one of the tables .*\[methods.theory\]"),
        (THEORY, f"{THEORY}\n[methods.bem]\ngrids = [32]", r"surface\.seed: missing.*'bem'"),
        (THEORY, with_effect(THEORY, f'{HARD}5 MPa"\nsize_exponent = 0.1'), "give both 'size_wavelength'"),
        (THEORY, with_effect(THEORY, f'{SMOOTH}\npressure = "9 MPa"'), "must be above the pressure of the"),
    ],
)
def test_mistakes_are_named(scene, old, new, named):
    with pytest.raises(SceneError, match=named):
        scene(RIM, (old, new))


@pytest.mark.parametrize(
    ("text", "changes", "effect", "named"),
    [
        (RIM, (), 'kind = "thickness"\nthickness = "1 mm"', "'thickness': method 'theory' does not handle"),
        (RIM, (), f'{HARD}0.4 MPa"', "hardness = 0.4 MPa: must not be below"),
        (RIM, ((THEORY, f'{THEORY}\nenergy = "old"'),), "", "energy = 'old': belongs to"),
        (WAVES, (), 'kind = "adhesion"\nwork = 0.01', "1 reach: missing; method 'bem' needs"),
        (WAVES, (), f'{SMOOTH}\npressure = "1 MPa"', "'smoothing': method 'bem' does"),
        (
            *(WAVES, (("reduced_pressure = 0.1", 'offset = "1 nm"'),)),
            f'{HARD}1 GPa"\nsize_wavelength = "1 um"\nsize_exponent = 0.1',
            r"\[\[effects\]\] 1 size_wavelength = 1 um: does not go with offset",
        ),
    ],
)
def test_what_a_method_cannot_be_given_is_refused_by_name(scene, text, changes, effect, named):
    loaded = scene(with_effect(text, effect) if effect else text, *changes)
    with pytest.raises(UsageError, match=named):
        check_scene(loaded, realise(loaded))


@pytest.mark.parametrize("load", ["reduced_pressure = [0.1, 0.2]", "reduced_pressure = 0.0"])
def test_a_solver_presses_with_one_load_above_zero(scene, load):
    with pytest.raises(SceneError, match=r"load\.reduced_pressure = .*: method 'bem' presses with one load"):
        scene(WAVES, ("reduced_pressure = 0.1", load))


def test_a_solver_presses_frozen_capillary_waves(scene):
    loaded = scene(WAVES)
    problem = realise(loaded)
    bend, longest, shortest = (2 * math.pi / wave for wave in (4e-9, 50e-9, 12.5e-9))
    waves = {"q_bend": bend, "q_min": longest, "q_short": shortest}
    exact = CapillaryWaves(temperature=370, surface_tension=0.04, **waves)
    assert problem.spectrum == exact
    # Waves of a period: their sum over C(q) is that of `random_waves` for any C(q).
    q = 2 * np.pi * np.fft.fftfreq(96, 100e-9 / 96)
    waves = np.hypot(q[:, None], q[None, :])
    power = (2 * np.pi / 100e-9) ** 2 * np.sum(exact(waves) * waves**2)
    assert problem.field.rms_gradient == pytest.approx(math.sqrt(power), rel=1e-12)
    contact = next(iter(solves_of(loaded))).do(threads=1).contact.checked()
    assert 0 < contact.in_contact.mean() < 1
    assert predict(problem, ()).ensemble_area == pytest.approx(predict(problem, ()).area, rel=0.5)


def test_two_equal_surfaces_add_up_wave_by_wave(scene):
    both = [scene(WAVES, ("seed = 77", f"seed = 77\nsurfaces = {n}")).surface for n in (1, 2)]
    one, two = map(spectrum_of, both)
    assert two.moments().rms_height == pytest.approx(2 * one.moments().rms_height, rel=1e-14)


def test_readings_of_the_theory_are_used_beside_a_solver_too(scene):
    loaded = scene(with_effect(WAVES, 'kind = "adhesion"\nwork = "1 mJ/m^2"\nreach = "1 nm"'))
    problem = realise(loaded)
    readings = [TheoryOptions(energy=energy) for energy in ("improved", "old")]
    plain, old = (predict(problem, loaded.effects, reading) for reading in readings)
    assert plain.other == pytest.approx(old.area, rel=1e-14)
    assert old.other == pytest.approx(plain.area, rel=1e-14)
    assert abs(old.area / plain.area - 1) > 1e-3
    assert "Eqs. 44-49" in plain.note
    assert "Eq. 43" in old.note


def test_judgements_from_the_spectrum_are_those_of_a_surface_with_many_waves(scene):
    loaded = scene(WAVES, ('length = "100 nm"', 'length = "800 nm"'), ("[24, 48]", "[144]"))
    drawn = realise(loaded)
    alone = ContactProblem(surface=drawn.surface, solid=drawn.solid, load=drawn.load, drawn=False)
    exact, expected = roughness_of(drawn), roughness_of(alone)
    # Sums over the waves of a period against integrals: the long waves are few, L = 16 lambda_long.
    for name in Roughness.__dataclass_fields__:
        assert getattr(expected, name) == pytest.approx(getattr(exact, name), rel=0.02), name


def rows(path):
    with path.open(encoding="utf-8") as file:
        return list(csv.reader(file))


def test_a_run_leaves_tables_figures_and_a_report_that_can_be_made_again(tmp_path):
    outputs = run_scene(load_scene("polished-steel"), tmp_path / "out")
    folder = outputs.folder
    (table,) = [rows(folder / "table.csv")]
    assert [float(row[table[0].index("p [Pa]")]) for row in table[1:]] == [1e6, 1e7, 1e8]
    zeta = outputs.data.magnification.isel(load=0).values
    assert zeta.size == 200
    assert (zeta[0], zeta[-1]) == pytest.approx((1.001, 1e5), rel=1e-8)
    assert "200001 points along a side" in (folder / "report.html").read_text(encoding="utf-8")
    assert {path.suffix for path in (folder / "figures").iterdir()} >= {".svg", ".pdf", ".csv", ".nc"}
    assert float(outputs.data.area_plastic_ensemble[1]) == pytest.approx(0.005, rel=0.01)
    before = {path: path.read_bytes() for path in folder.rglob("*.csv")}
    (folder / "report.html").unlink()
    again = report_scene(folder)
    assert again.files[0] == folder / "report.html"
    assert (folder / "report.html").exists()
    assert {path: path.read_bytes() for path in folder.rglob("*.csv")} == before


def test_where_the_theory_has_no_answer_the_row_says_why(scene, tmp_path, monkeypatch):
    from persson.errors import OutsideTheory

    def refused(*arguments, **options):
        raise OutsideTheory("tension beyond what holds")

    monkeypatch.setattr("persson.elastic.contact_area", refused)
    outputs = run_scene(scene(RIM), tmp_path / "out", report=False)
    assert "the theory has no answer: tension beyond what holds" in outputs.page.findings[0]
    assert np.isnan(outputs.data.area_ensemble.item())
    assert outputs.page.answers[0].answer == "no answer"


def test_the_command_line_runs_lists_and_plans_them(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    assert set(APPLICATIONS) <= set(answer_of("scenes list"))
    assert answer_of("run pyrex --dry-run") == []
    assert not list(tmp_path.iterdir())
    found = answer_of("run pyrex-squeezed")
    assert found["kind"] == "theory"
    area = found["findings"][0]["values"]["area_ensemble"]["value"]
    assert area == pytest.approx(0.9356, abs=2e-4)
    text = output_of("run pmma-silane -q")
    kept = (tmp_path / "results" / "pmma-silane" / "summary.json").read_text(encoding="utf-8")
    said = json.loads(kept)["findings"][0]
    assert said["values"]["area_ensemble"]["value"] == pytest.approx(0.91166, abs=5e-6)
    assert said["text"] in text
    assert "results/pmma-silane/report.html" in text
    assert "report.html" in output_of("report results/pmma-silane")


def test_an_accuracy_needs_a_solver_to_reach_it(scene, tmp_path):
    from validation.comparison.accuracy import run_accurate

    with pytest.raises(UsageError, match=r"--accuracy: no solver is listed; add \[methods\.bem\]"):
        run_accurate(scene(RIM), tmp_path, target=0.01)
