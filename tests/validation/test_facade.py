"""The few lines of a notebook give the numbers of a run, and what is wrong is said in one line."""

from functools import partial

import numpy as np
import pint
import pytest
from matplotlib.figure import Figure
from numpy.testing import assert_allclose
from reading_back import misdrawn
from refusing import refused

import fem_contact
import persson
import validation
from fem_contact import HalfSpace, HeightField, Solid
from fem_contact.area import EDGE_CONSTANTS
from validation import measured, press, self_affine, table, theory
from validation.errors import NoLimit, UsageError
from validation.studies import GROUPS, find_study

WAVES = {
    "length": "100 um",
    "hurst": 0.7,
    "lambda_long": "50 um",
    "lambda_short": "12.5 um",
    "rms_gradient": 0.1,
}
SOLID = {"young": "2 GPa", "poisson": 0.25}
SURFACE = self_affine(**WAVES, seed=7)
pressed = partial(press, SURFACE, **SOLID)
CONTACT = pressed(reduced_pressure=0.08, grid=32)
NODE = {"hurst": 0.8, "bandwidth": 8, "reduced_pressure": 0.05}
TILTED = np.tile(np.arange(16.0)[:, None], 16) + np.random.default_rng(9).normal(size=(16, 16))
TILTED[3, 4] = np.nan


def test_a_load_may_be_a_force_or_a_distance_and_the_rough_body_elastic():
    pressure, area = 0.08 * CONTACT.problem.pressure_scale, CONTACT.areas().perimeter
    by_force = pressed(force=f"{pressure * 1e-8 * 1e3!r} mN", grid=32)
    assert by_force.areas().perimeter == pytest.approx(area, rel=1e-6)
    held = pressed(mean_gap=CONTACT.mean_gap.value, grid=32)
    assert held.areas().perimeter == pytest.approx(area, rel=1e-5)
    assert held.theory.area == pytest.approx(CONTACT.theory.area, rel=1e-5)
    assert "p* = 0.08" in repr(held)
    two = pressed(second_young="2 GPa", second_poisson=0.25, pressure=pressure / 2, grid=32)
    assert two.areas().perimeter == pytest.approx(area, rel=1e-6)
    patch = measured(SURFACE.heights(32).values, length=1e-4, unit=1.0, edges="free")
    free = press(patch, **SOLID, pressure=pressure, free_boundary=True, grid=32)
    assert 0 < free.areas().pixel < 1


def test_quantities_of_pint_are_read():
    unit = pint.UnitRegistry()
    assert self_affine(**{**WAVES, "length": 100 * unit.um}).table == self_affine(**WAVES).table
    contact = press(SURFACE, young=2000 * unit.MPa, poisson=0.25, pressure=17.5 * unit.MPa, grid=32)
    assert contact.problem.pressure == 17.5e6
    with pytest.raises(UsageError, match="'3 m': is not a pressure"):
        pressed(pressure=3 * unit.m)


def test_a_surface_knows_its_size_in_numbers_and_pictures():
    exact = np.sqrt(np.mean(SURFACE.heights().values ** 2) - np.mean(SURFACE.heights().values) ** 2)
    assert SURFACE.rms_height == pytest.approx(exact, rel=1e-9)
    q = SURFACE.spectrum.wavevector.values
    assert SURFACE.spectrum.dims == ("wavevector",)
    assert SURFACE.spectrum.wavevector.attrs["units"] == "1/m"
    assert 2 * np.pi * np.sum(SURFACE.spectrum.values * q) * q[1] == pytest.approx(exact**2, rel=0.2)
    wave = measured(np.cos(2 * np.pi * np.arange(32) / 32)[:, None] * np.ones(32), length=1.0, unit=1e-3)
    # The Laplacian of a wave of amplitude a is a k^2 in amplitude.
    assert wave.rms_curvature == pytest.approx(1e-3 * (2 * np.pi) ** 2 / np.sqrt(2) / 2, rel=1e-9)
    assert wave.pixel_size == (1 / 32, 1 / 32)
    drawn = SURFACE.plot()
    # 64 summits of 1 nm within a rim of one point, on cells of 1 um.
    peaks = measured(np.kron(np.ones((8, 8)), np.pad([[1]], (2, 1))), length="32 um", unit="nm").statistics
    assert peaks["summit_density"].value == pytest.approx(64 / 30**2 * 1e12)
    assert repr(peaks["summit_density"]) == "summits/A0 = 71110 1/mm^2"
    assert repr(peaks["summit_curvature"]) == "curvature of summits = 2 1/mm"
    heights = SURFACE.heights().values
    kurtosis = np.mean(heights**4) / np.mean(heights**2) ** 2
    assert SURFACE.statistics["kurtosis"].value == pytest.approx(kurtosis, rel=1e-3)
    with pytest.raises(UsageError, match="cannot be pressed as it is"):
        _ = measured(TILTED, length="32 um", unit="nm").statistics
    assert peaks["kurtosis"].value == pytest.approx(1 / (1 / 16 * 15 / 16) - 3)  # of shares 1/16 and 15/16
    assert list(misdrawn(drawn, drawn.data)) == []
    assert float(drawn.data.heights.std()) == pytest.approx(exact, rel=0.01)
    # A map as it is, waves on eight points each.
    assert wave.plot().data.heights.shape == (32, 32)
    assert drawn.data.heights.shape == (64, 64)


@pytest.mark.parametrize("what", ["pressure", "gap", "distribution", "grids"])
def test_a_picture_of_a_contact_shows_its_numbers_in_axes_of_ones_own_too(what):
    drawing, figure = CONTACT.plot(what), Figure()
    assert list(misdrawn(drawing, drawing.data)) == []
    own = figure.subplots(1, 2)
    drawn = CONTACT.plot(what, ax=own if what == "distribution" else own[0])
    assert drawn.figure is figure
    assert list(misdrawn(drawn, drawn.data)) == []
    ends = [axes.get_xlim() for axes in drawing.figure.axes]
    assert [axes.get_xlim() for axes in own][: len(ends)] == ends[:2]


def test_a_finite_element_contact_is_corrected_by_the_constant_of_its_element():
    areas = pressed(reduced_pressure=0.08, method="fem", grid=18).areas()
    assert areas.edge_constant == EDGE_CONSTANTS["Hex1"]


def test_heights_given_in_nanometres_are_those_that_were_drawn():
    drawn = SURFACE.heights(40).values
    field = HeightField(heights=drawn, lengths=(1e-4, 1e-4))
    maps = (measured(drawn * 1e9, length="100 um", unit="1 nm"), measured(field))
    by_seed = press(SURFACE, Solid(young=2e9, poisson=0.25), pressure=5e6, grid=40)
    # Rounding of the factor 1e9 alone; the solver's tolerance is 1e-8.
    for other in (press(one, **SOLID, pressure=5e6, grid=40) for one in maps):
        difference = np.abs(other.result.pressure - by_seed.result.pressure).max()
        assert difference < 1e-5 * by_seed.result.pressure.max()
        assert other.areas().pixel == by_seed.areas().pixel


def test_a_measured_surface_is_resolved_unless_a_grid_is_asked_for():
    contact = press(measured(SURFACE.heights(40).values, length=1e-4, unit=1.0), **SOLID, pressure=5e6)
    assert contact.result.shape == (80, 80)
    assert contact.data.resolved.values.tolist() == [1]


def test_heights_in_memory_have_a_recipe_of_their_own():
    heights = SURFACE.heights(40).values
    both = [press(measured(h, length=1e-4, unit=1.0), **SOLID, pressure=5e6) for h in (heights, -heights)]
    assert len({one.solve.recipe["surface"]["path"] for one in both}) == 2


def test_what_looks_like_a_topography_of_another_package_is_read_with_its_units():
    class Topography:
        unit = "um"
        physical_sizes = (100.0, 100.0)

        def heights(self):
            return np.ma.masked_array(SURFACE.heights(40).values * 1e6, mask=np.eye(40) * 0)

    found = measured(Topography())
    assert found.table.length == pytest.approx((1e-4, 1e-4))
    assert_allclose(found.heights(), SURFACE.heights(40), rtol=0, atol=1e-18)
    for part in ({"heights": Topography.heights}, {"physical_sizes": (1.0, 1.0)}):
        with pytest.raises(UsageError, match="heights of type Part: it holds object values"):
            measured(type("Part", (), part)())


def test_a_file_is_a_surface_and_its_size_may_stand_in_it(tmp_path):
    np.save(tmp_path / "tilted.npy", TILTED)
    with pytest.raises(UsageError, match=r"^measured: surface.length: missing, and .*$"):
        measured(tmp_path / "tilted.npy", unit="nm")
    SURFACE.heights(40).to_netcdf(tmp_path / "rough.nc")
    assert_allclose(measured(tmp_path / "rough.nc").heights(), SURFACE.heights(40), rtol=1e-14, atol=1e-20)


def test_a_table_tells_contacts_apart_by_what_differs():
    loads = (0.05, 0.1)
    soft = table([pressed(reduced_pressure=p, hardness="150 MPa") for p in loads])
    assert (soft.plastic.sel(reduced_pressure=list(loads)).diff("reduced_pressure") > 0).all()
    assert (soft.persson_plastic > 0).all()
    assert {"hardness", "hurst", "young"}.isdisjoint(soft.coords)
    swept = [pressed(reduced_pressure=0.05, hardness=h) for h in ("150 MPa", "200 MPa")]
    assert table(swept).hardness.dims == ("hardness",)
    both = table([pressed(reduced_pressure=p, hardness=f"{1e9 * p + 1e8} Pa") for p in loads])
    assert both.hardness.values.tolist() == [150e6, 200e6]
    with pytest.raises(UsageError, match="nor does any of: reduced_pressure, pressure, method"):
        table([pressed(reduced_pressure=0.05)] * 2)
    layer = {"young": "6 GPa", "thickness": "5 um"}
    coated = [
        press(SURFACE, young=f"{e} GPa", poisson=0.3, reduced_pressure=0.05, coating=layer) for e in (1, 2)
    ]
    found = table(coated, along="young")
    assert found.young.values.tolist() == [1e9, 2e9]
    with pytest.raises(UsageError, match="these do: reduced_pressure, pressure"):
        table([pressed(reduced_pressure=0.05)], along="colour")


def test_several_grids_give_every_number_its_error():
    fine = pressed(reduced_pressure=0.08, grids=[32, (48, 48), 64])
    numbers = [fine.area, fine.kappa, fine.mean_gap, fine.approach, fine.stiffness, fine.max_pressure]
    assert all(0 < number.error < 0.1 * abs(number.value) for number in numbers)
    assert fine.area.value == fine.limit().value == CONTACT.limit([64, 48, 32]).value
    row = table([fine, CONTACT], along="points", limit=True)
    assert list(row.points) == [64, 32]
    assert list(row.area) == [fine.area.value, CONTACT.area.value]
    assert list(row.kappa) == [fine.kappa.value, CONTACT.kappa.value]
    assert (row.area_error[0], row.kappa_error[0]) == (fine.area.error, fine.kappa.error)
    assert np.isnan(row.area_error[1])


def test_what_the_report_of_a_study_shows_is_had_of_its_dataset(tmp_path):
    small = {"surfaces": 2, "grids": (32, 48), "reduced_pressures": (0.05, 0.1)}
    study, data = find_study("area"), fem_contact.study("area", bench=str(tmp_path), **small)
    assert fem_contact.study.findings(data) == study.findings(data)
    assert fem_contact.study.figures(data)[0].name == study.figures(data)[0].name
    assert "<table" in fem_contact.study.budget(data)._repr_html_()
    assert fem_contact.study.table(data).rows
    assert len(list(tmp_path.glob("*.nc"))) == 8


def test_a_limit_that_is_not_there_says_why():
    with pytest.raises(NoLimit, match="two resolved grids"):
        pressed(reduced_pressure=0.05, grid=32).limit([32])


def test_what_is_shown_is_short_and_the_whole_of_the_distribution():
    contact = pressed(reduced_pressure=0.05, grid=32)
    assert max(len(repr(SURFACE)), len(repr(contact))) < 250
    assert repr(CONTACT.mean_gap) == "mean gap = 358 nm"
    assert "<table>" in contact._repr_html_()
    drawing = contact.plot("distribution")
    assert drawing._repr_html_().startswith("<figure><svg")
    # What was left out at the upper end is nothing.
    width = float(drawing.data.stress_wide[1] - drawing.data.stress_wide[0])
    share = float(drawing.data.density_wide.sum()) * width
    assert share == pytest.approx(contact.areas().pixel, rel=1e-9)


loaded = partial(pressed, pressure=1e6)
STEEL, FLAT = Solid(young=1e9, poisson=0.3), np.zeros((8, 8))
tilted = partial(measured, TILTED, length=1e-5, unit=1e-9)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (lambda: press(FLAT, **SOLID, pressure=1e6), r"found ndarray; .* write measured\(array"),
        (lambda: press(STEEL, SURFACE, pressure=1e6), "surface: found Solid; write"),
        (lambda: press(SURFACE, HalfSpace(solid=STEEL), pressure=1e6), "HalfSpace; give its Solid"),
        (lambda: press(SURFACE, STEEL, young=1e9, pressure=1e6), "given twice; leave young and poisson out"),
        (lambda: press(SURFACE.field, **SOLID, pressure=1e6), r"found HeightField; write measured\(field\)"),
        (lambda: press(tilted(), **SOLID, pressure=1e6), r'measured.*: tilt="plane", missing="harmonic"$'),
        (lambda: tilted(edges="free", lambda_short=4e-6), "lambda_short: takes waves out of a period"),
        (lambda: measured(TILTED, more_paths=["b.npy"]), r"press each map: table\(\[press\(measured\(path, "),
        (lambda: measured(FLAT, unit=1), 'length is missing; .* length="100 um"'),
        (lambda: measured(FLAT, length=1e-5), 'unit is missing; .* unit="1 nm"'),
        (lambda: measured(FLAT, lengths=1e-5), "unknown key 'lengths'; did you mean 'length'"),
        (lambda: self_affine(lengths=1e-5), "unknown key 'lengths'; did you mean 'length'"),
        (lambda: measured(FLAT[:6], length=1e-5, unit=1), "one length for 6 x 8 points; give both"),
        (lambda: measured(3, length=1e-5, unit=1), "heights of type int: .*give a file, a 2-D array"),
        (lambda: pressed(reduced_pressure=[0.1, 0.2]), r"one load; for several write table"),
        (lambda: loaded(adhesion=1.0), "give a table .* with work, reach"),
        (lambda: loaded(method="bemm"), "did you mean 'bem'"),
        (lambda: loaded(force=1.0), "exactly one of .* found pressure and"),
        (lambda: loaded(grid=8), r"too coarse for lambda_short"),
        (lambda: loaded(grids=64), r"grids = 64: must be a list of grids"),
        (lambda: loaded(grids=[64, 96], grid=64), "give one of them"),
        (lambda: table([]), "table: no contact is given"),
        (lambda: fem_contact.study("hurts"), "did you mean 'hurst'"),
        (lambda: fem_contact.study("hurst", hursts=5), "hursts = 5: must be a list"),
        (lambda: fem_contact.study("area", bench=3), "bench = 3: give a folder"),
        (lambda: fem_contact.study.findings(3), "no such study; one of: "),
        (lambda: fem_contact.reference(**NODE, gradient=np.ones(2)), "must be 'surface' or 'spectrum'"),
        (lambda: fem_contact.reference(0.8, "8", 0.05), "bandwidth = '8': must be one finite"),
        (lambda: CONTACT.limit(np.ones(2)), "must be a whole number of points"),
        (lambda: CONTACT.against("bem"), "another method"),
        (lambda: CONTACT.plot([0, 0]), "is not drawn; one of: 'pressure'"),
        (lambda: CONTACT.plot("distribution", ax=Figure().subplots()), "give 2 axes of matplotlib"),
        (lambda: theory(SURFACE, **SOLID, pressure=1e6, offset="1 um"), "offset: no .*; Allowed: (?!.*off)"),
        (lambda: theory(SURFACE, **SOLID), "theory: give exactly one of 'pressure' and 'reduced_pressure'$"),
        (lambda: pressed(reduced_pressure=0.08, method="fem", grid=18).stiffness, "follows from"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(wrong, words):
    with refused(UsageError, words):
        wrong()


def test_study_names_are_completed():
    names = {name.replace("-", "_") for group in GROUPS.values() for name in group}
    assert names <= set(dir(fem_contact.study))
    for name in names:
        with pytest.raises(UsageError, match=f"study {name.replace('_', '-')}: unknown key 'no_such'"):
            getattr(fem_contact.study, name)(no_such=1)


def test_the_three_packages_have_one_version():
    assert validation.__version__ == persson.__version__ == fem_contact.__version__
    with pytest.raises(AttributeError, match="No validation attribute presss"):
        _ = validation.presss
