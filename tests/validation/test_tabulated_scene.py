"""Scenes with a tabulated C(q): the area of the surface it was taken from, and files that are refused."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from small_scene import scene_in

from fem_contact import radial_spectrum
from persson import SelfAffine
from validation.errors import SceneError, UsageError
from validation.scenes.problem import realise
from validation.scenes.surfaces import band_of
from validation.scenes.topography.text import read_columns

SPECTRUM = SelfAffine.from_rms_gradient(0.1, hurst=0.8, q_long=2 * np.pi / 5e-5, q_short=2 * np.pi / 5e-6)
REST = """
length = "100 um"
seed = 3
[solid]
young = "1 GPa"
poisson = 0.3
[load]
pressure = "5 MPa"
[methods.theory]
[methods.bem]
grids = [64]
"""
SELF_AFFINE = """[surface]
kind = "self-affine"
hurst = 0.8
rms_gradient = 0.1
lambda_long = "50 um"
lambda_short = "5 um"
"""
TABULATED = '[surface]\nkind = "spectrum"\npath = "psd.csv"\n'
UM = 'units = ["1/um", "um^4"]\n'


def rows(n=200, *, q_unit=1.0, power_unit=1.0):
    q = np.geomspace(SPECTRUM.q_min, SPECTRUM.q_short, n)
    return np.column_stack([q / q_unit, SPECTRUM(q) / power_unit])


@pytest.fixture
def scene(tmp_path):
    def write(text, table=None):
        if table is not None:
            np.savetxt(tmp_path / "psd.csv", table, delimiter=",", header="q, C")
        return scene_in(tmp_path, text + REST, name="mine")

    return write


@pytest.mark.parametrize(
    ("keys", "units"),
    [
        ("", {}),
        (UM, {"q_unit": 1e6, "power_unit": 1e-24}),
        (UM + 'power = "areal-psd"\n', {"q_unit": 1e6, "power_unit": 1e-24 / (4 * np.pi**2)}),
    ],
)
def test_a_finely_tabulated_spectrum_gives_the_surface_it_was_taken_from(scene, keys, units):
    drawn, tabulated = realise(scene(SELF_AFFINE)), realise(scene(TABULATED + keys, rows(**units)))
    assert_allclose(tabulated.heights((64, 64)).heights, drawn.heights((64, 64)).heights, atol=1e-12)
    assert tabulated.spectrum.moments().m2 == pytest.approx(0.01, rel=1e-9)


def test_an_edited_table_is_another_solve_and_a_comment_in_the_scene_is_not(scene):
    first = realise(scene(TABULATED, rows())).recipe
    assert realise(scene(f"# mine\n{TABULATED}")).recipe == first
    changed = rows()
    changed[50, 1] *= 1.001
    assert realise(scene(TABULATED, changed)).recipe["surface"]["path"] != first["surface"]["path"]


def test_fewer_waves_than_those_of_the_table(scene):
    surface = scene(TABULATED + 'lambda_long = "40 um"\nlambda_short = "8 um"\n', rows())
    spectrum = realise(surface).spectrum
    assert (spectrum.q_min, spectrum.q_short) == pytest.approx((2 * np.pi / 4e-5, 2 * np.pi / 8e-6))
    assert spectrum.m2() == pytest.approx(SPECTRUM.m2(2 * np.pi / 8e-6) - SPECTRUM.m2(2 * np.pi / 4e-5))
    with pytest.raises(UsageError, match="the table has those of 5 um to 50 um"):
        _ = realise(scene(TABULATED + 'lambda_long = "60 um"\n')).spectrum


def test_what_the_table_says_near_its_ends_is_kept(scene):
    table = rows(5)
    table[1:4, 1] *= 30  # a hill that straight lines from end to end would miss
    keys = 'units = ["1/m", "m^4"]\nlambda_long = "49 um"\nlambda_short = "5.1 um"'
    within = scene(TABULATED + keys, table)
    spectrum = realise(within).spectrum
    assert_allclose(spectrum(table[1:4, 0]), table[1:4, 1], rtol=1e-9)


def _with(row, column, value):
    table = rows(20)
    table[row, column] = value
    return table


@pytest.mark.parametrize(
    ("table", "keys", "message"),
    [
        (_with(7, 0, 2e5), "", "row 8 has q, C = .*; q must rise from row to row"),
        (_with(0, 0, 0.0), "", "row 1 .* q must be positive"),
        (_with(3, 1, -1e-20), "", "row 4 .* C must not be negative"),
        (_with(3, 1, np.nan), "", "row 4 .* must be finite"),
        (_with(3, 1, 0.0), "", "without a gap"),
        (rows(20)[:, :1], "", "must have two columns, q and C; it has 1"),
        (rows(20)[:1], "", "C must be above 0 in two rows or more"),
        (rows(20) / [4, 1], "", "lambda_long = 200 um: must not exceed the period 100 um"),
        (rows(20), 'units = ["um", "um^4"]\n', 'must be a unit such as "1/um"'),
        (np.zeros((0, 2)), "", "is no table of q and C"),
    ],
)
def test_a_bad_table_is_refused_in_a_line(scene, table, keys, message):
    with pytest.raises(SceneError, match=message) as caught:
        scene(TABULATED + keys, table)
    assert len(caught.value.problems) == 1
    assert "\n" not in caught.value.problems[0]


@pytest.mark.parametrize("header", [b"", b"q, C\n", b"# of an instrument\n\n"])
def test_what_marks_the_order_of_bytes_moves_no_number(header):
    numbers = b"12,3\n45,6\n78,9\n"
    for mark in (b"", b"\xef\xbb\xbf"):
        assert_allclose(read_columns(mark + header + numbers), [[12, 3], [45, 6], [78, 9]])


RANDOM = ["", "stretch = 1.6", 'rolloff = "plateau"', 'amplitudes = "gaussian"']


@pytest.mark.parametrize("more", [*RANDOM, "tabulated", "capillary"])
def test_no_wave_of_a_surface_lies_outside_its_band(scene, more):
    waves = 'lambda_bend = "7 um"\ntemperature = "300 K"\nsurface_tension = "1 mJ/m^2"'
    capillary = SELF_AFFINE.replace("self-affine", "capillary-waves")
    capillary = capillary.replace("hurst = 0.8\nrms_gradient = 0.1", waves)
    text = {"tabulated": TABULATED + UM, "capillary": capillary}.get(more, SELF_AFFINE + more)
    problem = realise(scene(text, rows(q_unit=1e6, power_unit=1e-24)))
    low, high = band_of(problem.surface)
    inside = radial_spectrum(problem.field, band=(low, high))
    power = (2 * np.pi / 1e-4) ** 2 * np.sum(inside.power * inside.count)
    assert power == pytest.approx(problem.field.rms_height**2, rel=1e-9)
    # And there are waves near both its ends.
    assert inside.q.max() > 0.93 * high
    assert inside.q.min() < max(1.2 * low, 8e4)
