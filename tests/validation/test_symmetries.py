"""One number, whatever units and axes: every key of every record."""

import json
import re

import numpy as np
import pytest
from gold.asked import STUDIES
from small_scene import scene_in

from fem_contact import random_surface
from validation.comparison.run import run_scene, run_sweep
from validation.studies import find_study, studies
from validation.units import unit_registry

#: Rectangular cells on an oblong period, two unequal elastic bodies.
SURFACE = {"length": ["20 um", "10 um"], "lambda_long": "10 um", "lambda_short": "2.5 um"}
SURFACE |= {"hurst": 0.7, "rms_gradient": 0.05, "seed": 7}
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
    parts = {"surface": {"kind": "self-affine", **SURFACE}, "solid": SOLID}
    parts |= {"load": {"reduced_pressure": 0.1}, "methods": {"bem": {"grids": GRIDS}, "theory": {}}}
    return parts | MORE.get(more, {}) | changed


def toml(parts, sweep=""):
    def value(item):
        if isinstance(item, dict):
            return "{" + ", ".join(f"{key} = {value(inner)}" for key, inner in item.items()) + "}"
        return "[" + ", ".join(map(value, item)) + "]" if isinstance(item, list) else json.dumps(item)

    return "\n".join(f"{key} = {value(item)}" for key, item in parts.items()) + f"\n{sweep}"


def run_of(parts, folder, name="scene"):
    folder.mkdir(exist_ok=True)
    return run_scene(scene_in(folder, toml(parts), name=name), folder / name, report=False)


def scaled_by(unit, length, pressure):
    """Return the factor of a number of this unit where all lengths and all pressures are so much larger."""
    base = unit_registry().Unit(unit).dimensionality if unit not in ("", "1") else {}
    mass = base.get("[mass]", 0)  # Pa = kg / (m s^2), and times stay
    return pressure ** float(mass) * length ** float(base.get("[length]", 0) + mass)


def scaled_tables(length, pressure, more=None, **changed):
    surface = {**SURFACE, "length": [20e-6 * length, 10e-6 * length]}
    surface |= {"lambda_long": 10e-6 * length, "lambda_short": 2.5e-6 * length}
    solid = {**SOLID, "young": 2e6 * pressure, "second_young": 5e6 * pressure}
    return tables(more, surface={"kind": "self-affine", **surface}, solid=solid, **changed)


def assert_scaled(before, after, length, pressure):
    """Every number, error and share is the other times the power of its unit."""
    assert set(before.variables) == set(after.variables)
    for name in set(map(str, before.variables)) - TIMES:
        values = before[name]
        if values.dtype.kind == "f" and values.attrs.get("units", "1") != "s":
            factor = scaled_by(values.attrs.get("units", "1"), length, pressure)
            np.testing.assert_allclose(after[name], factor * values, rtol=1e-9, err_msg=name)


def yielding(folder, length, pressure):
    yields = [{"kind": "hardness", "hardness": 1.5e5 * pressure}]
    return run_of(scaled_tables(length, pressure, "ensemble", effects=yields), folder).data


@pytest.fixture(scope="module")
def in_si(tmp_path_factory):
    return yielding(tmp_path_factory.mktemp("si"), 1.0, 1.0)


@pytest.mark.parametrize(("length", "pressure"), [(2.0**20, 1.0), (1.0, 2.0**-30)])
def test_every_number_scales_by_its_unit(in_si, tmp_path, length, pressure):
    assert_scaled(in_si, yielding(tmp_path, length, pressure), length, pressure)


def test_every_number_of_a_sweep_scales_by_its_unit(tmp_path):
    def data(name, length, pressure):
        leak = {"viscosity": 1e-3 * pressure, "pressure_drop": 1e3 * pressure}
        text = toml(scaled_tables(length, pressure, quantities={"leak": leak}))
        loads = f"sweep.load.pressure={[1e3 * pressure, 9e3 * pressure]}"
        moduli = f"sweep.solid.young={[2e6 * pressure, 3e6 * pressure]}"
        sweep = scene_in(tmp_path, text, loads, moduli, name=name)
        return run_sweep(sweep, tmp_path / name, report=False).data

    assert_scaled(data("before", 1.0, 1.0), data("after", 2.0**20, 2.0**-30), 2.0**20, 2.0**-30)


TURNED = {
    "swapped": lambda h: h.T,
    "reflected": lambda h: h[::-1],
    "rolled": lambda h: np.roll(h, (5, 3), axis=(0, 1)),
    "raised": lambda h: h + 3e-6,
}


def map_of(folder, turn, *, length=1.0):
    """Return a table of a rough map that lies in the folder, turned, and how to turn what has two sides."""
    waves = {"q_short": 2 * np.pi / 2.5e-6, "lengths": (20e-6, 10e-6), "seed": 5}
    rough = random_surface(lambda q: q**-3.6, shape=(32, 20), **waves)
    heights = turn(rough.heights) * (0.05 / rough.rms_gradient)
    np.save(folder / "map.npy", heights)
    turned = slice(None, None, -1 if heights.shape[0] < heights.shape[1] else 1)
    surface = {"kind": "file", "path": "map.npy", "length": [20e-6 * length, 10e-6 * length][turned]}
    return surface | {"unit": length, "tilt": "keep", "edges": "periodic", "missing": "refuse"}, turned


def laid(folder, turn):
    surface, turned = map_of(folder, turn)
    grids = [grid[turned] for grid in ([64, 40], [96, 60])]
    methods = {"bem": {"grids": grids, "tolerance": 1e-11}, "theory": {}}
    return run_of(tables("passing", surface=surface, methods=methods), folder).data


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    return laid(tmp_path_factory.mktemp("plain"), lambda heights: heights)


@pytest.mark.parametrize("turn", TURNED)
def test_no_number_knows_how_axes_were_laid(plain, tmp_path, turn):
    other = laid(tmp_path, TURNED[turn])
    # Statistics of a patch look at no neighbours across its edges, which rolling moves.
    of_patch = {"slope_kurtosis", "steep_share", "summit_density", "summit_curvature", "summit_height"}
    numerical = {"residual", "residual_finest"} | (of_patch if turn == "rolled" else set())
    axes = {"_x": "_y", "_y": "_x"}
    for name in set(map(str, plain.data_vars)) - TIMES - FIELDS - numerical:
        twin = name if turn != "swapped" else re.sub("_([xy])(?=_|$)", lambda axis: axes[axis[0]], name)
        if plain[name].dtype.kind == "f":
            few = 1e-12 if plain[name].attrs.get("units", "1") == "1" else 0.0
            np.testing.assert_allclose(other[twin], plain[name], rtol=1e-6, atol=few, err_msg=name)


#: What the tolerance leaves, what depends on a clock, and memory, more of which one side of a grid takes.
OF_THE_MACHINE = ("seconds", "bytes", "fastest", "leanest", "cheapest", "residual", "left_")


@pytest.mark.parametrize("name", [name for name, study in studies().items() if study.options.takes_scene()])
def test_no_number_of_a_study_knows_units_and_axes(name, bench, tmp_path):
    def data(length, pressure, turn):
        folder = tmp_path / str(length)
        folder.mkdir()
        surface, turned = map_of(folder, turn, length=length)
        grids = [grid[turned] for grid in ([64, 40], [96, 60], [128, 80])]
        methods = {"bem": {"grids": grids, "tolerance": 1e-11}}
        methods |= {"fem": {"grids": grids[:1], "tolerance": 1e-11}} if name == "cross" else {}
        solid = scaled_tables(length, pressure)["solid"]
        (folder / "scene.toml").write_text(toml(tables(surface=surface, solid=solid, methods=methods)))
        study = find_study(name)
        asked = STUDIES.get(f"{name} on a scene", STUDIES[name])
        left_out = {"surfaces", *study.options.fixed_by_scene()}
        options = {key: value for key, value in asked.items() if key not in left_out}
        options["scene"] = str(folder / "scene.toml")
        return study.compute(study.options(**options), bench=bench).drop_sel(source="solver", errors="ignore")

    before = data(1.0, 1.0, lambda h: h)
    # Reflected at the first point, which every grid has.
    after = data(2.0**20, 2.0**-30, lambda h: np.roll(h[::-1], 1, axis=0).T + 3e-6)
    for variable in map(str, before.variables):
        values, unit = before[variable], before[variable].attrs.get("units", "1")
        if values.dtype.kind == "f" and not any(word in variable for word in OF_THE_MACHINE):
            scaled = after[variable] / scaled_by(unit, 2.0**20, 2.0**-30)
            few = 1e-7 if unit == "1" else 0.0
            np.testing.assert_allclose(scaled, values, rtol=1e-6, atol=few, err_msg=variable)
