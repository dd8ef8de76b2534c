"""Theories that simulations are scored against: entries, a user's own, another package's."""

import textwrap
from importlib import metadata
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from persson.elastic import KAPPA_BGT, contact_area, stress_variance
from validation import theories as registry
from validation.errors import UsageError
from validation.measurements.common import base_case, base_surface
from validation.registry import found_in
from validation.theories import Rough, Theory, find_theory, theories

SMALL = {"periods": 1.6, "bandwidth": 2.5, "surfaces": 2, "points_per_wave": (4.0, 6.0)}


@pytest.fixture(scope="module")
def rough():
    surface = base_surface(hurst=0.8, periods=2.0, bandwidth=8.0, seed=311)
    return Rough.of(base_case(surface, reduced_pressure=0.05))


def unit(rough):
    return rough.contact_modulus * rough.moments.rms_gradient


def written(body, name="my_theory"):
    Path(f"{name}.py").write_text(textwrap.dedent(body), encoding="utf-8")


def test_all_theories_of_the_package_are_found_and_have_an_area(rough):
    asked = {"persson", "yang-persson", "wang-mueser", "xu"}
    asked |= {"bush-gibson-thomas", "carbone-bottiglione", "greenwood-williamson"}
    assert set(theories()) == asked
    pressure = np.array([1e-3, 1e-2]) * unit(rough)
    for theory in theories().values():
        area = theory.area(pressure, rough)
        assert area.shape == (2,)
        assert np.all((area > 0) & (np.diff(area, prepend=0) > 0)), theory.name


def test_the_entry_of_persson_is_his_theory_of_the_realised_surface(rough):
    pressure = np.array([0.01, 0.3, 2.0]) * unit(rough)
    full = stress_variance(rough.moments.m2, contact_modulus=rough.contact_modulus)
    exact = contact_area(pressure, stress_variance=full)
    assert_array_equal(theories()["persson"].area(pressure, rough), exact)


@pytest.mark.parametrize("name", ["persson", "yang-persson", "wang-mueser", "xu"])
def test_the_distribution_of_an_entry_carries_the_load_on_its_area(name, rough):
    theory, load = theories()[name], 0.2 * unit(rough)
    stress = np.linspace(0.0, 12 * unit(rough), 60001)
    density = theory.pressure_distribution(stress, load, rough)
    step = stress[1]
    assert density.sum() * step == pytest.approx(float(theory.area(np.array([load]), rough)[0]), rel=1e-6)
    assert (density * stress).sum() * step == pytest.approx(load, rel=1e-6)


def test_asperities_begin_with_the_linear_law_and_leave_it_soon(rough):
    """Carbone and Bottiglione (2008), Fig. 5: the law of 1975 holds at vanishing loads only."""
    line, full = theories()["bush-gibson-thomas"], theories()["carbone-bottiglione"]
    pressure = np.array([1e-9, 1e-3, 1e-2, 5e-2]) * unit(rough)
    ratio = full.area(pressure, rough) / line.area(pressure, rough)
    assert line.area(pressure, rough)[0] / 1e-9 == pytest.approx(KAPPA_BGT)
    assert ratio[0] > 0.85
    assert np.all(np.diff(ratio) < 0)
    assert ratio[-1] < 0.75
    gap = full.mean_gap(pressure, rough)
    assert np.all(np.diff(gap) < 0)


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("no_such_theory", "neither a module here nor one of: .*persson"),
        ("my_theory:missing", "module 'my_theory' has no function 'missing'"),
        ("my_theory", "module 'my_theory' has no function 'area'"),
        ("broken", "cannot be imported: ZeroDivisionError"),
    ],
)
def test_a_theory_that_is_not_there_is_refused_by_name(name, says, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    written("def other(pressure): return pressure\n", "my_theory_of_others")
    written("1 / 0\n", "broken")
    monkeypatch.syspath_prepend(str(tmp_path))
    written("def other(pressure): return pressure\n", "lonely_theory")
    with pytest.raises(UsageError, match=says.replace("my_theory", "lonely_theory")):
        find_theory(name.replace("my_theory", "lonely_theory"))


def test_a_theory_of_a_wrong_shape_is_refused_by_name(tmp_path, monkeypatch, rough):
    monkeypatch.chdir(tmp_path)
    written("def area(pressure): return 0.5\ndef bad(pressure): return pressure + missing\n", "shapeless")
    written("def area(pressure): return 1e-6 * pressure\n", "linear")
    with pytest.raises(UsageError, match=r"area = 3: must lie in \[0, 1\], or be NaN"):
        find_theory("linear:area").area(np.array([1.0, 3e6]), rough)
    with pytest.raises(UsageError, match=r"'shapeless:area': area of shape \(\): must have \(2,\)"):
        find_theory("shapeless:area").area(np.ones(2), rough)
    written("mean_gap = 3.0\ndef area(pressure): return 0.5j * pressure\n", "complex_theory")
    with pytest.raises(UsageError, match="area raised TypeError: complex numbers"):
        find_theory("complex_theory").area(np.ones(2), rough)
    assert "mean_gap" not in vars(find_theory("complex_theory"))
    with pytest.raises(UsageError, match=r"raised NameError.*; it is given an array, pressures"):
        find_theory("shapeless:bad").area(np.ones(2), rough)


class Elsewhere(Theory):
    name = "elsewhere"
    label = "Elsewhere"

    def area(self, pressure, rough):
        return pressure / pressure.max()


def offered(monkeypatch, load):
    """What is found where another package's entry point is loaded by a function."""
    entry = metadata.EntryPoint(name="elsewhere", value=f"{__name__}:Elsewhere", group="fem_contact.theories")
    monkeypatch.setattr(type(entry), "load", lambda self: load())
    monkeypatch.setattr("validation.registry.metadata.entry_points", lambda group: [entry])
    return found_in(registry.__name__, Theory, group="fem_contact.theories")


def test_another_package_adds_a_theory_by_an_entry_point(monkeypatch, capsys):
    assert Elsewhere in offered(monkeypatch, lambda: print("hello") or Elsewhere)
    assert capsys.readouterr().out == ""
