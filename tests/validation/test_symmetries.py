"""One number, whatever door it comes through, whatever units and axes: every key of every record."""

from __future__ import annotations

import json

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

import fem_contact as fc
from fem_contact.surface import random_surface
from validation.audit.reading import audit
from validation.cli import app
from validation.comparison.compare import side_by_side
from validation.comparison.run import run_scene
from validation.comparison.sweep import run_sweep
from validation.execution.results import read_results
from validation.reference import table
from validation.report.quantities import quantity
from validation.scenes.scene import load_scene
from validation.scenes.sweep import load_asked
from validation.units import unit_registry

#: Rectangular cells on an oblong period, two unequal elastic bodies.
SURFACE = {
    "length": ["20 um", "10 um"],
    "hurst": 0.7,
    "lambda_long": "10 um",
    "lambda_short": "2.5 um",
    "rms_gradient": 0.05,
    "seed": 7,
}
SOLID = {"young": "2 MPa", "poisson": 0.3, "second_young": "5 MPa", "second_poisson": 0.45}
GRIDS = [[32, 14], [48, 20]]
MORE = {
    "plain": {},
    "yielding": {"effects": [{"kind": "hardness", "hardness": "40 kPa"}]},
    "ensemble": {"ensemble": {"realisations": 3, "grids": GRIDS}},
    "passing": {"quantities": {"leak": {"viscosity": "1 mPa s", "pressure_drop": "1 kPa"}}},
}
#: Seconds are those of each run; what says on which machine and when stands in no variable.
TIMES = {"seconds", "seconds_total", "seconds_cheapest", "cheapest", "area_cheapest_off"}
#: Fields are kept by a run alone, not by a case of a sweep.
FIELDS = {"heights", "pressure_map", "power_spectrum", "power_spectrum_told"} | {
    f"density_{part}{theory}" for part in ("near", "wide") for theory in ("", "_persson")
}


def tables(more=None, **changed):
    parts = {
        "surface": {"kind": "self-affine", **SURFACE},
        "solid": SOLID,
        "load": {"reduced_pressure": 0.1},
        "methods": {"bem": {"grids": GRIDS}, "theory": {}},
    }
    return parts | MORE.get(more, {}) | changed


def toml(parts, sweep=""):
    """Write tables as TOML: JSON values in inline tables."""

    def value(item):
        if isinstance(item, dict):
            return "{" + ", ".join(f"{key} = {value(inner)}" for key, inner in item.items()) + "}"
        return "[" + ", ".join(map(value, item)) + "]" if isinstance(item, list) else json.dumps(item)

    return "\n".join(f"{key} = {value(item)}" for key, item in parts.items()) + f"\n{sweep}"


def run_of(parts, folder, name="scene"):
    folder.mkdir(exist_ok=True)
    path = folder / f"{name}.toml"
    path.write_text(toml(parts))
    return run_scene(load_scene(str(path)), folder / name, report=False)


@pytest.fixture(scope="module", params=MORE)
def case(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp(request.param)
    return request.param, folder, run_of(tables(request.param), folder)


def assert_same(one, other, *, without=frozenset(), lacking=frozenset()):
    """Compare every variable with its attributes: value, error by source, unit, reason, words."""
    assert set(other.variables) - set(one.variables) == set()
    assert set(one.data_vars) - set(other.data_vars) <= lacking
    for name in set(other.data_vars) - TIMES - without:
        xr.testing.assert_identical(
            one[name].drop_vars(lacking, errors="ignore").reset_coords(drop=True),
            other[name].reset_coords(drop=True),
        )


def test_the_command_line_has_the_numbers_of_python(case):
    _, folder, run = case
    done = CliRunner().invoke(
        app, ["run", str(folder / "scene.toml"), "-o", str(folder / "again"), "-q", "--no-report"]
    )
    assert done.exit_code == 0, done.output
    assert_same(run.data, read_results(folder / "again").data)


def test_a_sweep_of_one_has_the_numbers_of_the_run(case):
    name, folder, run = case
    (folder / "sweep.toml").write_text(toml(tables(name), "[sweep]\nload.reduced_pressure = [0.1]\n"))
    sweep = run_sweep(load_asked(str(folder / "sweep.toml")), folder / "sweep", report=False).data
    one = sweep.isel(reduced_pressure=0).reset_coords("reduced_pressure")
    assert_same(run.data, one, without={"reduced_pressure"}, lacking=FIELDS)


def test_beside_itself_a_run_is_apart_by_nothing(case):
    _, _, run = case
    beside = side_by_side({"a": run.result, "b": run.result})
    for name in beside.data_vars:
        if "result" in beside[name].dims and name in run.data:
            np.testing.assert_array_equal(*(beside[name].isel(result=k).values for k in (0, 1)))
            np.testing.assert_array_equal(beside[name].isel(result=0).values, run.data[name].values)
        if str(name).endswith("_apart"):
            assert not beside[name].fillna(0.0).values.any(), name


def test_the_audit_finds_each_number_again(case):
    _, _, run = case
    ledger = audit(run.folder)
    assert ledger.entries
    assert not ledger.wrong


def test_the_facade_has_the_numbers_of_a_run_on_one_grid(tmp_path):
    one = tables(methods={"bem": {"grids": GRIDS[:1]}, "theory": {}})
    contact = fc.press(fc.self_affine(**SURFACE), **SOLID, reduced_pressure=0.1, grid=(32, 14))
    assert_same(run_of(one, tmp_path).data, contact.data, lacking=FIELDS)
    for name, variable in (
        ("max_pressure", "largest_pressure"),
        *((n, n) for n in ("area", "kappa", "approach")),
    ):
        value = getattr(contact, name)
        assert value.value == contact.data[variable].item()
        assert value.unit == contact.data[variable].attrs["units"]


def test_our_solver_entered_as_the_users_own_has_the_same_numbers(tmp_path, monkeypatch):
    (tmp_path / "mine.py").write_text(
        "from fem_contact import bem, Solid, HalfSpace\nfrom fem_contact.surface import HeightField\n"
        "def solve(heights, lengths, *, contact_modulus, mean_pressure, tolerance):\n"
        "    body = HalfSpace(solid=Solid(young=contact_modulus, poisson=0.0))\n"
        "    field = HeightField(heights=heights, lengths=lengths)\n"
        "    return bem.solve(field, body, mean_pressure=mean_pressure, tolerance=tolerance).pressure\n"
    )
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    table = {"grids": GRIDS, "tolerance": 1e-9}
    both = run_of(tables(methods={"bem": table, "own": {"solver": "mine:solve", **table}}), tmp_path).data
    ours, theirs = (both.isel(solver=k) for k in (0, 1))
    for name in set(both.data_vars) - TIMES - {"unknowns", "residual", "residual_finest"}:
        if "solver" in both[name].dims and both[name].dtype.kind == "f" and not name.endswith("_difference"):
            np.testing.assert_allclose(ours[name], theirs[name], rtol=1e-6, atol=1e-9, err_msg=name)


@pytest.mark.parametrize("name", ["area", "kappa", "mean_gap", "compliance", "elastic_energy"])
def test_the_reference_has_the_numbers_of_its_own_cells(name):
    cells = table().sel(amplitudes="exact", hurst=0.8, bandwidth=8.0, reduced_pressure=0.05)
    answer = fc.reference(hurst=0.8, bandwidth=8, reduced_pressure=0.05)
    if name in answer and name in cells:
        assert answer[name].value == pytest.approx(cells[name].item(), rel=1e-12)
        assert quantity(name).name


# ---- symmetries ------------------------------------------------------------------------------------


def scaled_by(unit, length, pressure):
    """Return the factor of a number of this unit where all lengths and all pressures are so much larger."""
    base = unit_registry().Unit(unit).dimensionality if unit not in ("", "1") else {}
    mass, time = base.get("[mass]", 0), base.get("[time]", 0)
    # Time enters by pressures alone, so that mass tells their power: Pa = kg / (m s^2).
    assert time == -2 * mass, unit
    return pressure ** float(mass) * length ** float(base.get("[length]", 0) + mass)


@pytest.mark.parametrize(("length", "pressure"), [(2.0**20, 1.0), (1.0, 2.0**-30), (2.0**-10, 2.0**20)])
def test_every_number_scales_by_its_unit(tmp_path, length, pressure):
    def parts(long, stiff):
        surface = {**SURFACE, "length": [20e-6 * long, 10e-6 * long]}
        surface |= {"lambda_long": 10e-6 * long, "lambda_short": 2.5e-6 * long}
        solid = {**SOLID, "young": 2e6 * stiff, "second_young": 5e6 * stiff}
        yields = [{"kind": "hardness", "hardness": 1.5e5 * stiff}]
        return tables("ensemble", surface={"kind": "self-affine", **surface}, solid=solid, effects=yields)

    before = run_of(parts(1.0, 1.0), tmp_path, "before").data
    after = run_of(parts(length, pressure), tmp_path, "after").data
    assert set(before.variables) == set(after.variables)
    for name in set(map(str, before.variables)) - TIMES:
        values = before[name]
        if values.dtype.kind == "f" and values.attrs.get("units", "1") != "s":
            factor = scaled_by(values.attrs.get("units", "1"), length, pressure)
            np.testing.assert_allclose(after[name], factor * values, rtol=1e-9, err_msg=name)


TURNED = {
    "swapped": lambda h: h.T,
    "reflected": lambda h: h[::-1],
    "rolled": lambda h: np.roll(h, (5, 3), axis=(0, 1)),
    "raised": lambda h: h + 3e-6,
}


@pytest.mark.parametrize("turn", TURNED)
def test_no_number_knows_how_axes_were_laid(tmp_path, turn):
    rough = random_surface(
        lambda q: q**-3.6, q_short=2 * np.pi / 2.5e-6, lengths=(20e-6, 10e-6), shape=(32, 20), seed=5
    )

    def run(heights, name):
        swapped = heights.shape[0] < heights.shape[1]
        np.save(tmp_path / f"{name}.npy", heights * (0.05 / rough.rms_gradient))
        turned = slice(None, None, -1 if swapped else 1)
        surface = {"kind": "file", "path": f"{name}.npy", "length": ["20 um", "10 um"][turned], "unit": 1.0}
        grids = [grid[turned] for grid in ([64, 40], [96, 60])]
        methods = {"bem": {"grids": grids, "tolerance": 1e-11}, "theory": {}}
        surface |= {"tilt": "keep", "edges": "periodic", "missing": "refuse"}
        return run_of(tables("passing", surface=surface, methods=methods), tmp_path, name).data

    plain, other = run(rough.heights, "plain"), run(TURNED[turn](rough.heights), turn)
    # Statistics of a patch look at no neighbours across its edges, which rolling moves.
    of_patch = {"slope_kurtosis", "steep_share", "summit_density", "summit_curvature", "summit_height"}
    numerical = {"residual", "residual_finest"} | (of_patch if turn == "rolled" else set())
    for name in set(map(str, plain.data_vars)) - TIMES - FIELDS - numerical:
        swap = {"_x": "_y", "_y": "_x"} if turn == "swapped" else {}
        twin = name[:-2] + swap.get(name[-2:], name[-2:])
        if plain[name].dtype.kind == "f":
            values = [data[n].values for data, n in ((plain, name), (other, twin))]
            np.testing.assert_allclose(*values, rtol=1e-6, atol=1e-12, err_msg=name)
