"""One number stands behind every door: each key that two records share is the same in both.

Left out are, by name, what a clock says, and what a door says of itself. All else is compared whole: values,
errors by source, units, dimensions and counts.
"""

import itertools
import json
import re
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from commanding import answer_of, output_of
from small_scene import HARD, ONE_BODY, ensemble, small_scene

import fem_contact as fc
from validation.execution.bench import Bench
from validation.execution.results import read_results
from validation.notebook import Contact
from validation.reference import table
from validation.report.estimates import total_error
from validation.report.values import Value
from validation.scenes.scene import load_scene
from validation.studies import theory_verdict
from validation.theories.predicted import COMPARED

#: What a clock says, and where the least of it was.
_CLOCK = re.compile(r"seconds.*|cheapest|area_cheapest_off")
#: Of a run alone: its maps and curves. No other door draws them from its dataset.
_DRAWN = re.compile(
    r"(density|stress)_(near|wide).*|heights|power_spectrum.*|pressure_map|wavevector|plane_.*|x|y"
)
#: What is added to the scene.
MORE = {
    "elastic": "",
    "yielding": HARD,
    "coated": '[[effects]]\nkind = "coating"\nyoung = "8 MPa"\npoisson = 0.3\nthickness = "0.4 um"\n',
    "several": ensemble(3, "[[24, 16], [36, 24]]")
    + '[quantities.leak]\nviscosity = "1 mPa s"\npressure_drop = "1 kPa"\n',
}
OWN_SOLVER = """
from fem_contact import HeightField, HalfSpace, Solid, bem

def solve(heights, lengths, *, contact_modulus, mean_pressure, tolerance, hardness=None):
    field = HeightField(heights=heights, lengths=lengths)
    solid = HalfSpace(solid=Solid(young=contact_modulus, poisson=0.0))
    return bem.solve(field, solid, mean_pressure=mean_pressure, tolerance=1e-10).pressure
"""
_SAID = {"pressure_distribution": "stress, pressure"}
_SAID |= dict.fromkeys(("area", "mean_gap", "elastic_energy"), "pressure")
OWN_THEORY = """
from types import SimpleNamespace
from validation.measurements.theory import Waves
from validation.theories import find_theory
""" + "".join(
    f"""
def {quantity}({arguments}, *, contact_modulus, moments, spectrum):
    rough = dict(contact_modulus=contact_modulus, moments=moments, waves=Waves.of_spectrum(spectrum))
    return find_theory("persson").{quantity}({arguments}, SimpleNamespace(**rough))
"""
    for quantity, arguments in _SAID.items()
)


def differing(first, second, *, rtol=0.0):
    """Names of what both records have and is not the same, in value, unit or dimension."""
    wrong = []
    for name in map(str, set(first.variables) & set(second.variables)):
        a, b = (data[name].squeeze(drop=True) for data in (first, second))
        same = a.dims == b.dims and a.shape == b.shape and a.attrs.get("units") == b.attrs.get("units")
        if same and a.dtype.kind == "f":
            same = np.allclose(a, b, rtol=rtol, atol=0.0, equal_nan=True)
        elif same:
            same = np.array_equal(a, b)
        if not same and not _CLOCK.fullmatch(name):
            wrong.append(name)
    return sorted(wrong)


def only(first, second):
    """Names that one of two records has alone, but for what is drawn."""
    apart = set(first.variables) ^ set(second.variables)
    return {name for name in map(str, apart) if not _DRAWN.fullmatch(name)}


@pytest.fixture(scope="module", params=MORE)
def doors(request, once, tmp_path_factory):
    """One scene by every command that solves, in a folder of its own each."""
    name = request.param
    return once(f"doors of {name}", lambda: _by_every_door(name, tmp_path_factory.mktemp("doors")))


def _by_every_door(case, folder):
    scene, store = folder / "scene.toml", f"--store {folder / 'solves'}"
    text = small_scene("[methods.theory]\n") + MORE[case]
    scene.write_text(text.replace(*ONE_BODY) if case == "coated" else text)

    def run(name, more=""):
        output_of(f"run {scene} {more} --output {folder / name} {store} --quiet --no-report")

    run("run")
    several = case == "several"
    if several:
        run("again")
        compared = f"compare {folder / 'run'} {folder / 'again'} --output {folder / 'compare'} --no-report"
        assert answer_of(compared)["differing"] == {}
    for mode in ("product", "zip") if several else ("product",):
        run(mode, f"--set sweep.surface.seed=[77] --set sweep.mode={mode}")
    return folder


#: Neither notebook nor study has what is of several surfaces or flows.
ONE_SURFACE = pytest.mark.parametrize("doors", ["elastic", "yielding", "coated"], indirect=True)


def numbers(folder):
    return read_results(folder).data


def said(scene):
    """Surface, solid and effects of a scene as a notebook is told them."""
    return {
        "surface": fc.self_affine(**scene.surface.model_dump(exclude={"kind"}, exclude_none=True)),
        **scene.solid.model_dump(exclude_none=True),
        **{e.kind: e.model_dump(exclude={"kind"}, exclude_none=True) for e in scene.effects},
    }


@ONE_SURFACE
def test_a_notebook_and_a_run_have_the_same_record(doors):
    scene = load_scene(str(doors / "scene.toml"))
    grids = scene.methods.options("bem").grids
    contact = fc.press(**said(scene), reduced_pressure=0.1, grid=grids[0])
    run, pressed = numbers(doors / "run"), contact._on(grids)
    assert differing(run, pressed.data) == []
    assert only(run, pressed.data) == set()
    names = {"max_pressure": "largest_pressure"}
    shown = [name for name, kind in vars(Contact).items() if isinstance(kind, property)]
    values = {name: got for name in shown if isinstance(got := getattr(pressed, name), Value)}
    assert {"area", "kappa", "mean_gap", "approach", "max_pressure", "stiffness"} <= set(values)
    for name, value in [*values.items(), ("area", contact.limit(grids))]:
        of_run = run[names.get(name, name)]
        error = float(total_error(run, of_run.name))
        assert (value.value, value.error, value.unit) == (of_run.item(), error, of_run.attrs["units"])
    assert contact.theory.area == run.area_persson_own.item()
    np.testing.assert_array_equal(contact.to_xarray().pressure, contact.result.pressure)
    np.testing.assert_array_equal(said(scene)["surface"].heights(grids[0]), contact.result.heights)
    findings = json.loads((doors / "run" / "summary.json").read_text())["findings"]
    written = {record["text"] for record in findings}
    assert {text for text in written ^ set(pressed.findings) if "cheapest" not in text} == set()
    assert pressed.areas().perimeter == run.area_perimeter.values[0, -1]


@ONE_SURFACE
def test_the_cheapest_way_is_the_least_time_of_a_resolved_grid_close_to_the_limit(doors):
    run = numbers(doors / "run")
    ways = [run[f"area_{way}_off"] for way in ("located", "perimeter", "pixel") if f"area_{way}" in run]
    off = abs(xr.concat(ways, "way"))
    close = run.seconds.where((off <= 0.01) & (run.resolved > 0))
    assert run.seconds_cheapest.item() == close.min().item()
    assert abs(run.area_cheapest_off.item()) <= 0.01


@ONE_SURFACE
def test_the_theory_alone_says_of_a_scene_what_it_says_in_a_notebook_and_beside_a_solver(doors):
    scene = (doors / "scene.toml").read_text()
    (doors / "alone.toml").write_text(re.sub(r"\[methods.bem\]\n.*\n", "", scene))
    output_of(f"run {doors / 'alone.toml'} --output {doors / 'alone'} --quiet --no-report")
    asked = said(load_scene(str(doors / "alone.toml")))
    alone, run = numbers(doors / "alone"), numbers(doors / "run")
    here = fc.theory(**asked, reduced_pressure=0.1)
    words = {"area": "area_ensemble", "area_plastic": "area_plastic_ensemble"}
    renamed = here.rename({name: words[name] for name in map(str, here) if name in words})
    assert differing(renamed, alone) == []
    assert set(renamed.variables) <= set(alone.variables)
    # p* is by the gradient of C(q) where no surface is drawn: at the pressure of a run the two are one.
    at_pressure = fc.theory(**asked, pressure=run.pressure.item())
    assert at_pressure.area.item() == run.area_ensemble.item()


@pytest.mark.parametrize(
    ("doors", "mode"), [*((scene, "product") for scene in MORE), ("several", "zip")], indirect=["doors"]
)
def test_a_sweep_of_one_has_the_record_of_a_run(doors, mode):
    run, swept = (numbers(doors / name) for name in ("run", mode))
    assert differing(run, swept) == []
    assert only(run, swept) == {"seed"} | ({"case"} if mode == "zip" else set())


@ONE_SURFACE
def test_a_study_of_one_surface_says_what_a_run_says(doors):
    one = f"--scene {doors / 'scene.toml'} --surfaces 1 --reduced-pressures 0.1"
    output_of(f"study area {one} --output {doors / 'study'} --quiet --no-report")
    run, study = (numbers(doors / name) for name in ("run", "study"))
    # Its solves are listed over the grids, and its kappa is a mean of one quotient. The limit is a fit by
    # least squares, which turns rounding (NumPy 2.5) into 1e-10 of the area and 2e-9 of its error.
    assert differing(run, study, rtol=1e-8) == ["solve"]
    assert study.solve.item().split() == run.solve.values.ravel().tolist()
    assert {"area", "kappa", "area_persson", "area_excess", "area_error"} <= set(run) & set(study)
    assert study.area_each.item() == pytest.approx(run.area.item(), rel=1e-8)
    for name in ("area_pixel", "area_perimeter"):
        assert study[f"{name}_each"].item() == run[f"{name}_finest"].item(), name


@pytest.mark.parametrize("doors", ["several"], indirect=True)
def test_a_run_beside_itself_differs_in_nothing(doors):
    run, both = numbers(doors / "run"), numbers(doors / "compare")
    apart = [name for name in both if str(name).endswith("_apart")]
    assert len(apart) > 40
    for name, k in itertools.product(apart, range(2)):
        bare = str(name).removesuffix("_apart")
        assert _CLOCK.fullmatch(bare) or not (both[name].fillna(0) != 0).any(), name
        assert differing(run[[bare]], both.isel(result=k)[[bare]]) == []
    findings = json.loads((doors / "compare" / "summary.json").read_text())["findings"]
    texts = " ".join(one["text"] for one in findings)
    assert "No setting differs" in texts
    assert "agree to the last digit" in texts
    errors = [name for name in both if str(name).endswith("_error") and "_apart" not in str(name)]
    assert differing(run[errors], both.isel(result=1)[errors]) == []


def test_the_record_that_is_read_without_us_is_that_of_the_dataset(doors):
    run = numbers(doors / "run")
    records = json.loads((doors / "run" / "summary.json").read_text())["numbers"]
    single = {name for name, values in run.variables.items() if values.ndim == 0}
    assert set(records) >= {name for name in single if not name.endswith("_error")}
    for name, record in records.items():
        value, error = run[name].item(), total_error(run, name)
        assert record["value"] == value or (record["value"] is None and np.isnan(value)), name
        expected = None if error is None or np.isnan(error) else error.item()
        assert record.get("error") == expected, name


def test_every_cell_of_the_reference_is_what_is_looked_up_there():
    data = table()
    names = ("amplitudes", "hurst", "bandwidth", "reduced_pressure")
    cells = data.area.stack(cell=names).dropna("cell").cell.values.tolist()
    # One in twenty-nine, which no axis has in common: each takes half a second of interpolation.
    for place in cells[::29]:
        at = dict(zip(names, place, strict=True))
        cell = data.sel(at)
        by_spectrum = fc.reference(**at, gradient="spectrum")
        looked_up = {f"{name}_by_spectrum": value for name, value in by_spectrum.items()} | fc.reference(**at)
        for name, value in looked_up.items():
            quantity, per = name.replace("kappa", "area"), place[-1] if "kappa" in name else 1.0
            expected = (float(cell[quantity]) / per, float(total_error(cell, quantity)) / per)
            assert (value.value, value.uncertainty) == pytest.approx(expected, rel=1e-12), (name, at)
    assert len(cells[::29]) > 8


def test_boundary_elements_entered_as_the_user_s_own_are_boundary_elements(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("copied_solver.py").write_text(OWN_SOLVER)
    own = '[methods.own]\nsolver = "copied_solver:solve"\ngrids = [[24, 16], [36, 24], [48, 32]]\n'
    Path("scene.toml").write_text(
        small_scene("[methods.theory]\n").replace("grids", "tolerance = 1e-10\ngrids") + own
    )
    output_of("run scene.toml --output out --quiet --no-report")
    run = numbers(Path("out"))
    over = [name for name, values in run.items() if "solver" in values.dims]
    bem, copied = (run[over].sel(solver=name, drop=True) for name in ("bem", "own"))
    # Residuals are computed anew of the pressure; differences are of one of the two.
    but = {"solve", "residual", "residual_finest"} | {name for name in over if "_difference" in name}
    assert set(differing(bem, copied)) <= but
    assert float(abs(run[sorted(name for name in but if name.endswith("_difference"))]).to_array().max()) == 0
    assert differing(bem, copied, rtol=1e-4)[-1] == "solve"


def test_persson_s_theory_entered_as_the_user_s_own_is_his(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("copied_theory.py").write_text(OWN_THEORY)
    asked = {"reduced_pressures": (0.02, 0.1), "ladder_reduced_pressures": (), "theory": ("copied_theory",)}
    small = {"periods": 2.0, "bandwidth": 2.0, "surfaces": 2, "points_per_wave": (4.0, 6.0)}
    options = theory_verdict.Options(**asked, **small)
    data = theory_verdict.run(options, bench=Bench.at(tmp_path / "solves"))
    over = [name for name, values in data.items() if "theory" in values.dims]
    persson, copied = (data[over].isel(theory=k) for k in (0, -1))
    # A theory of the user's own is told C(q) and no waves of the surface, of which gap and energy are.
    of_waves = {
        f"{n}_{end}" for n in COMPARED[1:] for end in ("predicted", "over", "off", "over_error", "off_error")
    }
    assert set(differing(persson, copied, rtol=1e-12)) - of_waves == {"theory"}
    assert np.isfinite(copied.gap_spectral).all()
