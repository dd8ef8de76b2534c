"""Measured surfaces: read from any format, levelled, filled, made periodic, through theory and solvers."""

import hashlib
import io
import json
import math
import os
import re
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from commanding import output_of
from numpy.testing import assert_allclose, assert_array_equal
from refusing import refused
from small_scene import PRESSED, scene_in

import fem_contact as fc
from fem_contact import HeightField, estimate_spectrum, random_surface
from fem_contact.surface.spectra import window_weights
from persson import SelfAffine
from validation.audit.reading import audit
from validation.audit.values import page_tables
from validation.comparison.explain import explain
from validation.comparison.run import run_scene, run_sweep
from validation.comparison.run_views import run_views
from validation.comparison.sweep_views import sweep_views
from validation.errors import UsageError
from validation.execution.bench import Bench
from validation.execution.press import run_solves
from validation.report.estimates import claim
from validation.scenes.problem import realise
from validation.scenes.scene import load_scene
from validation.scenes.sweep import load_asked
from validation.scenes.topography import measured as reading
from validation.scenes.topography.formats import read_plain
from validation.scenes.topography.measured import Measured, file_says, read_topography
from validation.scenes.topography.patch import Topography
from validation.scenes.topography.statistics import height_statistics
from validation.scenes.topography.writing import write_topography
from validation.units import LARGEST

LENGTH = 1e-5
BAND = {"q_long": 2 * math.pi / 1e-5, "q_short": 2 * math.pi / 0.625e-6, "rolloff": "plateau"}
SPECTRUM = SelfAffine.from_rms_gradient(0.1, hurst=0.8, **BAND)


def npy(array):
    file = io.BytesIO()
    np.save(file, array)
    return file.getvalue()


#: A table of a scene that names no treatment.
AS_IT_IS = {"tilt": None, "missing": "refuse", "edges": None}


def periodic(n, *, seed=13):
    lengths = (2 * LENGTH, 2 * LENGTH)
    return random_surface(SPECTRUM, q_short=SPECTRUM.q_short, lengths=lengths, shape=(n, n), seed=seed)


def patch(n=96, *, seed=31):
    """A quarter of it: its opposite edges do not match."""
    return np.array(periodic(2 * n, seed=seed).heights[:n, :n])


def square(heights, side=LENGTH):
    return Topography(heights=heights, lengths=(side, side))


def measured_patch(n=96):
    """A patch as it comes from an instrument, with tilt and holes; and the mask of the holes."""
    heights = patch(n)
    x = np.arange(n) * LENGTH / n
    tilted = heights + 0.05 * x[:, None] - 0.02 * x[None, :] + 3e-6
    holes = np.zeros(heights.shape, dtype=bool)
    holes[10:16, 40:45] = True
    holes[np.random.default_rng(8).integers(0, n, 60), np.random.default_rng(9).integers(0, n, 60)] = True
    return np.where(holes, np.nan, tilted), holes


@pytest.mark.parametrize("suffix", [".npy", ".txt", ".nc"])
def test_every_format_is_written_and_read_back_exactly(tmp_path, suffix):
    field = HeightField(heights=patch(48)[:24, :18], lengths=(2.4e-6, 2.7e-6))
    path = tmp_path / f"surface{suffix}"
    write_topography(path, field)
    says_size = suffix == ".nc"
    found = read_topography(path, **({} if says_size else {"lengths": field.lengths, "unit": 1.0}))
    assert_array_equal(found.heights, field.heights)
    assert_allclose(found.lengths, field.lengths, rtol=1e-14)
    if suffix == ".txt":
        assert "size 2.4e-06 m x 2.7e-06 m" in path.read_text()
    if not says_size:
        largest = LARGEST / np.abs(field.heights).max()  # as its unit
        size = {"lengths": (1e6 * largest, 1e6 * largest)}
        assert read_topography(path, unit=0.9 * largest, **size).heights.max() <= LARGEST
        with pytest.raises(UsageError, match="holds heights up to"):
            read_topography(path, unit=1.1 * largest, **size)
        with pytest.raises(UsageError, match="does not say how large the patch is"):
            read_topography(path)
        with pytest.raises(UsageError, match="does not say the unit of its heights: give unit"):
            read_topography(path, lengths=field.lengths)


# Numbers that are not whole are no mask.
@pytest.mark.parametrize("mask", ["", "u1", "i2", "f8"])
def test_netcdf_units_and_holes_are_those_of_the_file(tmp_path, mask):
    import netCDF4

    path = tmp_path / "afm.nc"
    with netCDF4.Dataset(path, "w") as file:
        for axis, count in (("x", 4), ("y", 3)):
            file.createDimension(axis, count)
            positions = file.createVariable(axis, "f8", (axis,))
            positions.units = "um"
            positions[...] = np.arange(count) * 0.5
        heights = file.createVariable("height", "f4", ("x", "y"), fill_value=-9999.0)
        heights.units = "nm"
        heights.scale_factor, heights.add_offset = 2.0, 1.0  # which the library undoes
        heights[...] = np.ma.masked_equal(np.arange(12.0).reshape(4, 3), 5.0)
        if mask:
            file.createVariable("mask", mask, ("x", "y"))[...] = np.eye(4, 3)
    found = read_topography(path)
    assert_allclose(found.lengths, (2e-6, 1.5e-6), rtol=1e-14)
    holes = np.eye(4, 3) * (mask in {"u1", "i2"})
    holes[1, 2] = True
    np.testing.assert_array_equal(np.isnan(found.heights), holes)
    assert found.missing == holes.sum()
    assert found.heights[3, 2] == pytest.approx(11e-9, rel=1e-7)


def test_other_formats_are_read_and_written_with_surfacetopography(tmp_path):
    library = pytest.importorskip("SurfaceTopography", reason="LOUD: SurfaceTopography is not installed")
    field = HeightField(heights=patch(48)[:24, :18], lengths=(2.4e-6, 1.8e-6))
    holed = np.ma.masked_greater(field.heights * 1e9, np.quantile(field.heights * 1e9, 0.9))
    made = library.Topography(holed, (2400.0, 1800.0), unit="nm")
    with (tmp_path / "whole-numbers.x3p").open("wb") as file:
        made.to_unit("m").to_x3p(file, dtype="L")
    made.to_netcdf(str(tmp_path / "classic.data"))
    made.to_gwy(str(tmp_path / "scan.gwy"))
    for path in ("whole-numbers.x3p", "classic.data", "scan.gwy"):
        found = read_topography(tmp_path / path)
        assert_allclose(found.lengths, field.lengths, rtol=1e-12)
        assert_array_equal(np.isnan(found.heights), holed.mask)
        assert_allclose(found.heights[~holed.mask], field.heights[~holed.mask], atol=1e-9 * 1e-8)
    write_topography(tmp_path / "plain.x3p", field)
    found = read_topography(tmp_path / "plain.x3p")
    assert_array_equal(found.heights, field.heights)
    # Text of a program whose header is not ours, and binary data of a suffix that is ours.
    (tmp_path / "binary.dat").write_bytes((tmp_path / "scan.gwy").read_bytes())
    assert read_topography(tmp_path / "binary.dat").heights.shape == (24, 18)
    for name in ("scan.al3d", "scan.x3p"):
        (tmp_path / name).write_bytes(b"nonsense")
        with pytest.raises(UsageError, match="is no topography of its kind"):
            read_topography(tmp_path / name)


def test_without_surfacetopography_a_line_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "SurfaceTopography", None)
    (tmp_path / "scan.x3p").write_bytes(b"PK")
    with pytest.raises(UsageError, match=r"for x3p and other formats install .*fem-contact\[topography\]"):
        read_plain(str(tmp_path / "scan.x3p"))
    with pytest.raises(UsageError, match=r"written by SurfaceTopography: pip install 'fem-contact\[topo"):
        write_topography(tmp_path / "scan.x3p", HeightField(heights=np.eye(4), lengths=(1.0, 1.0)))


def test_a_plane_is_found_from_the_known_points_alone():
    heights, holes = measured_patch()
    flat = square(heights)
    x = np.arange(96) * LENGTH / 96
    plane = 0.05 * x[:, None] - 0.02 * x[None, :] + 3e-6
    only_plane = square(np.where(holes, np.nan, plane))
    assert only_plane.slope == pytest.approx((0.05, -0.02), rel=1e-12)
    left = only_plane.levelled("plane").heights
    assert np.nanmax(np.abs(left)) < 1e-12 * 3e-6
    levelled = flat.levelled("plane")
    assert np.abs(levelled.slope).max() < 1e-12
    assert "plane taken out" in levelled.history[-1]
    assert np.nanstd(flat.levelled("quadratic").heights) <= np.nanstd(levelled.heights)


def test_holes_are_refused_or_filled_by_choice():
    heights, holes = measured_patch()
    levelled = square(heights).levelled("plane")
    assert "of 9216 heights are NaN or infinite" in levelled.faults(**AS_IT_IS)["missing"][0]
    truth = square(patch()).levelled("plane").heights
    error = {}
    for choice in ("nearest", "harmonic"):
        filled = levelled.filled(choice)
        assert filled.missing == 0
        assert_array_equal(filled.heights[~holes], levelled.heights[~holes])
        error[choice] = np.std((filled.heights - truth)[holes])
        assert f"filled: {choice}" in filled.history[-1]
    # The membrane follows the rim of a hole; the nearest point is off by the slope.
    assert error["harmonic"] < 0.1 * np.std(truth)
    assert error["harmonic"] < error["nearest"]


@pytest.mark.parametrize("hole", [np.s_[3:7, 4:9], np.s_[5, 5]], ids=["patch", "point"])
def test_the_membrane_continues_a_plane_exactly(hole):
    x = np.arange(12.0)
    plane = 2 * x[:, None] - x[None, :]
    holed = plane.copy()
    holed[hole] = np.nan
    found = square(holed, 1.0).filled("harmonic").heights
    assert_allclose(found, plane, atol=1e-12 * 20)


def test_edges_that_do_not_match_are_refused_unless_a_taper_is_named():
    rough = square(patch()).levelled("plane")
    assert rough.edge_jump > 4
    assert set(rough.faults(**AS_IT_IS)) == {"edges"}
    assert rough.faults(**AS_IT_IS)["edges"][1] == "tukey"
    for edges in ("tukey", "hann"):
        periodic = rough.made_periodic(edges, margin=0.15)
        assert periodic.edge_jump < 1.5
        assert f"{edges} taper" in periodic.history[-1]
    middle = slice(20, -20)
    kept = rough.made_periodic("tukey", margin=0.15).heights[middle, middle]
    assert_allclose(kept, (rough.heights - rough.heights.mean())[middle, middle], rtol=1e-12, atol=1e-20)
    assert rough.made_periodic("periodic", margin=0.1).edge_jump == rough.edge_jump


def test_a_periodic_surface_needs_no_taper():
    topography = square(periodic(96).heights, 2 * LENGTH)
    assert topography.edge_jump < 2
    assert topography.made_periodic(None, margin=0.1) is topography


def test_windows_are_one_inside_fall_to_the_edges_and_are_symmetric():
    for window in ("hann", "tukey"):
        weights = window_weights((20, 31), window=window, margin=0.2)
        assert weights.min() > 0
        assert weights.max() <= 1
        assert_allclose(weights, weights[::-1, ::-1], atol=1e-15)
    assert np.all(window_weights((40, 40), window="tukey", margin=0.1)[5:-5, 5:-5] == 1)


def test_a_windowed_patch_gives_back_the_spectrum_it_was_cut_from():
    powers = []
    for seed in range(100, 116):
        levelled = square(patch(seed=seed)).levelled("plane")
        rings = estimate_spectrum(levelled.heights, levelled.lengths, window="hann")
        powers.append(rings.power)
    unit = 2 * math.pi / LENGTH
    inside = (rings.q > 5.5 * unit) & (rings.q < 0.85 * SPECTRUM.q_short)
    ratio = np.mean(powers, axis=0)[inside] / SPECTRUM(rings.q[inside])
    # Sixteen patches of `count` waves, of which a Hann window leaves one in (3/2)^2 independent.
    scatter = 4 / np.sqrt(16 * rings.count[inside] / 2.25)
    # The window blurs C ~ q^-3.6 by a third of a ring squared on each axis: (1/6) (C'' + C'/q) / C = 2.2 /
    # q^2.
    blur = 2.2 / (rings.q[inside] / unit) ** 2
    assert np.all(np.abs(ratio - 1 - blur) < scatter + 0.02), ratio
    # Without a window the jump at the edges fills the spectrum beyond the cut-off, where there is nothing.
    raw = estimate_spectrum(levelled.heights, levelled.lengths, window="none")
    beyond = rings.q > 1.5 * SPECTRUM.q_short
    assert rings.power[beyond].sum() < 1e-2 * raw.power[raw.q > 1.5 * SPECTRUM.q_short].sum()


SCENE = f"""
name = "measured"
[surface]
kind = "file"
path = "{{path}}"
tilt = "plane"
missing = "harmonic"
edges = "tukey"
margin = 0.15
{{length}}
{PRESSED}
[methods.theory]
[methods.bem]
grids = [96, 144]
shifts = 2
[methods.fem]
grids = [24]
under_resolved = true
depth = "5 um"
"""


def test_a_measured_topography_goes_through_theory_and_solvers(tmp_path):
    heights, _ = measured_patch()
    np.save(tmp_path / "afm.npy", heights * 1e9)
    scene = scene_in(tmp_path, SCENE.format(path="afm.npy", length='length = "10 um"\nunit = "nm"'))
    outputs = run_scene(scene, tmp_path / "results")
    c = outputs.data
    treatment = c.attrs["treatment"]
    assert c.shifts.count("grid").values.tolist() == [2, 1]
    for words in ("plane taken out", "filled: harmonic", "tukey taper"):
        assert words in treatment
    # The estimate from the untapered patch, and the surface that was pressed, are of one roughness.
    estimated = Measured.read(scene.surface).spectrum.moments().rms_gradient
    slopes = np.gradient(patch(), LENGTH / 96, edge_order=2)
    assert estimated == pytest.approx(float(np.hypot(np.std(slopes[0]), np.std(slopes[1]))), rel=0.1)
    assert_allclose(c.rms_gradient, estimated, rtol=0.25)
    assert 0.05 < float(c.area_ensemble) < 0.3
    assert float(c.residual.max()) < 1e-6
    assert "tukey taper" in (tmp_path / "results" / "report.html").read_text()


def test_two_measured_bodies_are_the_map_of_their_sum_with_one_turned_over(tmp_path):
    first, second = patch(48, seed=31), patch(48, seed=32) / 2
    np.save(tmp_path / "a.npy", first * 1e9)
    np.save(tmp_path / "b.npy", second * 1e9)
    np.save(tmp_path / "sum.npy", (first + second[::-1]) * 1e9)
    text = SCENE[: SCENE.index("[methods.bem]")] + "[methods.bem]\ngrids = [48, 72]\n"
    unit, areas = 'length = "10 um"\nunit = "nm"\n', {}
    for name, line in {"both": 'path = "a.npy"\nsecond_path = "b.npy"', "sum": 'path = "sum.npy"'}.items():
        scene = text.replace('path = "{path}"', line).format(length=unit)
        outputs = run_scene(scene_in(tmp_path, scene, name=f"{name}"), tmp_path / name, report=False)
        areas[name] = float(outputs.data.area_own)
        assert ("facing b.npy" in outputs.data.attrs["treatment"]) == (name == "both")
        assert not audit(tmp_path / name).wrong
    assert areas["both"] == pytest.approx(areas["sum"], rel=1e-9)
    options = {"length": "10 um", "unit": "nm", "second_path": str(tmp_path / "b.npy")}
    for heights in (str(tmp_path / "a.npy"), first * 1e9):
        raw = fc.measured(heights, **options).given.raw.heights
        assert_allclose(raw, first + second[::-1], rtol=0, atol=1e-18)
    np.save(tmp_path / "b.npy", second[:40])
    with refused(UsageError, r"surface.second_path = .*: has 40 x 48 points, the first body 48 x"):
        Measured.read(load_scene(str(tmp_path / "both.toml")).surface)


def test_several_maps_of_a_surface_are_an_ensemble(tmp_path):
    """Its mean is that of the maps pressed one by one, each under p* by its own gradient."""
    for name, seed in (("a", 31), ("b", 32), ("c", 33)):
        np.save(tmp_path / f"{name}.npy", patch(40, seed=seed) * 1e9)
    head = SCENE[: SCENE.index("[methods.bem]")] + "[methods.bem]\ngrids = [56, 80]\n"
    head = head.format(path="{path}", length='length = "10 um"\nunit = "nm"\n{more}')
    together = head.format(path="a.npy", more='more_paths = ["b.npy", "c.npy"]\ntreatment = false')
    ensemble = together + "[ensemble]\nrealisations = {}\ngrids = [56, 80]\n"
    data = run_scene(scene_in(tmp_path, ensemble.format(3)), tmp_path / "all").data
    for k, name in enumerate("abc"):
        scene = scene_in(tmp_path, head.format(path=f"{name}.npy", more="treatment = false"))
        alone = run_scene(scene, tmp_path / name, report=False).data
        assert_allclose(data.area_each[k], alone.area_own, rtol=1e-9)
        assert_allclose(data.area_persson_each[k], alone.area_persson_own, rtol=1e-9)
    assert_allclose(data.area, data.area_each.mean(), rtol=1e-12)
    assert not audit(tmp_path / "all").wrong
    assert "Over 3 maps the mean is" in (tmp_path / "all" / "report.html").read_text()
    broken = {ensemble.format(4): "has 3 maps; say realisations = 3", together: "add .ensemble. with"}
    broken[together.replace(', "c.npy"', "")] = "add .ensemble. with realisations = 2"
    for text, words in broken.items():
        with pytest.raises(UsageError, match=words):
            scene_in(tmp_path, text)
    np.save(tmp_path / "c.npy", np.ones((8, 8)))
    with pytest.raises(UsageError, match=r"surface.path = .*c.npy.*: is flat"):
        run_scene(scene_in(tmp_path, ensemble.format(3)), tmp_path / "flat")


def test_a_file_that_says_its_size_needs_no_length_in_the_scene(tmp_path):
    field = HeightField(heights=patch()[:24, :24], lengths=(LENGTH / 4, LENGTH / 4))
    write_topography(tmp_path / "scan.nc", field)
    surface = scene_in(tmp_path, SCENE.format(path="scan.nc", length="")).surface
    assert_allclose(surface.length, field.lengths, rtol=1e-14)
    assert Measured.read(surface).period.height_field().shape == (24, 24)


def test_one_length_for_a_map_that_is_not_square_is_refused_and_oblong_cells_are_said(tmp_path):
    np.save(tmp_path / "scan.npy", patch()[:24, :18])
    text = SCENE.format(path="scan.npy", length='length = "10 um"\nunit = "1 nm"')
    with refused(UsageError, r"surface.length: one length for 24 x 18 points makes oblong cells; give"):
        scene_in(tmp_path, text)
    surface = scene_in(tmp_path, text.replace('"10 um"', '["10 um", "10 um"]')).surface
    assert "oblong cells of 416.7 nm x 555.6 nm" in Measured.read(surface).period.history[0]
    assert "oblong" not in read_topography(tmp_path / "scan.npy", lengths=(4.0, 3.0), unit=1.0).history[0]


def test_a_larger_file_is_given_more_time_and_memory_and_no_file_hours(monkeypatch):
    given = []
    monkeypatch.setattr(reading.sandbox, "call", lambda *_, **bounds: given.append(bounds))
    for size in (0, 2**20, 2**30):
        reading._read.__wrapped__("scan.txt", size)
    small, middle, large = given
    assert 0 < small["seconds"] < middle["seconds"] < large["seconds"] < 3600
    assert large["memory"] > small["memory"] + 2**30
    assert large["most_bytes"] == small["most_bytes"]


def test_a_file_is_read_once_until_it_changes(tmp_path, monkeypatch):
    calls = []
    inner = reading.sandbox.call
    monkeypatch.setattr(reading.sandbox, "call", lambda *a, **k: calls.append(a) or inner(*a, **k))
    path = tmp_path / "scan.npy"
    np.save(path, patch()[:24, :24] * 1e9)
    os.utime(path, (1, 1))
    monkeypatch.setattr(reading, "_SETTLED", 0.0)
    text = SCENE.format(path="scan.npy", length='length = "2.5 um"\nunit = "1 nm"')
    surface = scene_in(tmp_path, text).surface
    first = Measured.read(surface)
    assert_array_equal(Measured.read(surface).raw.heights, first.raw.heights)
    assert first.raw.digest == hashlib.sha256(path.read_bytes()).hexdigest()
    assert len(calls) == 1
    np.save(path, patch()[:24, :24][::-1] * 1e9)
    second = Measured.read(surface)
    assert second.raw.digest != first.raw.digest
    assert_array_equal(second.raw.heights, first.raw.heights[::-1])
    assert len(calls) == 2
    assert not any(t.heights.flags.writeable for t in (first.raw, first.patch, first.period))


def test_a_file_that_was_just_changed_is_read_again(tmp_path):
    path = tmp_path / "scan.npy"
    for k in range(3):
        # The times of the file may not tell these apart.
        np.save(path, np.full((4, 4), float(k)))
        assert file_says(path).heights[0, 0] == k


def test_a_plane_of_many_blocks_is_that_of_one(monkeypatch):
    heights, _ = measured_patch()
    whole = square(heights)
    expected = {tilt: whole.levelled(tilt).heights for tilt in ("plane", "quadratic")}
    monkeypatch.setattr("validation.scenes.topography.patch._BLOCK_POINTS", 400)
    for tilt, found in expected.items():
        assert_allclose(whole.levelled(tilt).heights, found, rtol=0, atol=1e-13 * np.nanmax(heights))


def test_more_holes_than_a_membrane_is_stretched_over_are_refused(monkeypatch):
    heights, holes = measured_patch()
    monkeypatch.setattr("validation.scenes.topography.patch.MOST_HOLES", 20)
    patch = square(heights)
    words, remedy = patch.faults(**AS_IT_IS | {"missing": "harmonic"})["missing"]
    assert remedy == "nearest"
    assert f"{holes.sum()} of 9216 heights are NaN or infinite, and 'harmonic' fills at most 20" in words


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("scan.txt", b"1 2 3\n4 5", "is no topography of its kind"),
        ("scan.npy", b"no array", "is no topography of its kind"),
        ("scan.nc", b"no netcdf", "cannot be read: it is damaged, cut short or no netCDF"),
        ("scan.txt", b"1 2 3 4", "at least 2 x 2 heights"),
        ("scan.npy", npy(np.ones((4, 4)) * (1 + 2j)), "complex128 values; heights are real numbers"),
        ("scan.npy", npy(np.array([["a", "b"], ["c", "d"]])), "heights are real numbers"),
    ],
)
def test_a_file_that_is_no_topography_is_refused_in_one_line(tmp_path, name, content, words):
    (tmp_path / name).write_bytes(content)
    with refused(UsageError, words):
        read_topography(tmp_path / name, lengths=(1.0, 1.0))


WAVES = np.outer(np.sin(np.arange(24) * math.pi / 6), np.ones(24))


@pytest.mark.parametrize(
    ("heights", "length", "words"),
    [
        (None, 'length = "10 um"\nunit = "1 nm"', "surface.path = .*cannot be read: No such file"),
        (None, "", "surface.path = 'scan.npy': cannot be read: No such file"),
        (WAVES, 'length = "10 um"', "surface.unit: missing, and 'scan.npy' does not say it; unit of"),
        (WAVES, 'unit = "1 nm"', "surface.length: missing"),
        (np.zeros((24, 24)), 'length = "10 um"\nunit = "1 nm"', r"is flat \(h'_rms = 0\)"),
    ],
)
def test_a_file_that_no_scene_can_press_is_refused_before_anything_is_solved(
    tmp_path, heights, length, words
):
    if heights is not None:
        np.save(tmp_path / "scan.npy", heights)
    for command in (explain, lambda scene: run_scene(scene, tmp_path / "results")):
        with refused(UsageError, words):
            command(scene_in(tmp_path, SCENE.format(path="scan.npy", length=length)))
    assert not list((tmp_path / "results").rglob("*.nc"))


def tilted_map(folder):
    """One period of a rough surface as an instrument gives it: tilted, in um, with a hole; a scene of it."""
    waves = SelfAffine.from_rms_gradient(0.1, hurst=0.8, q_long=1.3e6, q_short=1.2e7)
    whole = random_surface(waves, q_short=1.2e7, lengths=(2e-5, 1.2e-5), shape=(160, 96), seed=9)
    x, y = np.arange(160)[:, None] / 160 * 20, np.arange(96)[None, :] / 96 * 12
    heights = whole.heights * 1e6 + 0.21 * x - 0.12 * y
    heights[30:36, 40:47] = np.nan
    np.savetxt(folder / "afm.txt", heights, fmt="%.6f")
    return '[surface]\nkind = "file"\npath = "afm.txt"\nlength = ["20 um", "12 um"]\nunit = "1 um"\n'


REST = f"{PRESSED}[methods.bem]\ngrids = [[160, 96]]\n"


def test_a_tilt_and_a_hole_come_at_once_with_the_table_that_mends_them(tmp_path):
    text = tilted_map(tmp_path)
    with pytest.raises(UsageError, match=r"tilt: a plane holds 9\d\.?\d* % of the variance") as caught:
        explain(scene_in(tmp_path, text + REST))
    said = str(caught.value)
    assert "missing: 42 of 15360 heights are NaN or infinite" in said
    # The plane made the edges differ: without it they match, and no taper is called for.
    assert "edges" not in said
    pasted = said[said.index("[surface]") :] + text.partition('"afm.txt"')[2]
    found = Measured.read(scene_in(tmp_path, pasted + REST).surface)
    assert found.period.missing == 0
    assert found.faults == {}
    # Without a size all faults come before the first is mended.
    with pytest.raises(UsageError, match=r"surface\.length: missing") as caught:
        scene_in(tmp_path, '[surface]\nkind = "file"\npath = "afm.txt"\n' + REST)
    asked = ("surface.unit: missing", 'unit = "..."', 'length = ["...", "..."]')
    for words in (*asked, 'tilt = "plane"', 'missing = "harmonic"'):
        assert words in str(caught.value)


@pytest.fixture(scope="module")
def treated(tmp_path_factory):
    """A run of a tilted map with a hole and spikes under a taper, and its folder."""
    folder = tmp_path_factory.mktemp("treated")
    text = tilted_map(folder) + 'tilt = "plane"\nmissing = "nearest"\nedges = "tukey"\n'
    heights = np.loadtxt(folder / "afm.txt")
    heights[[20, 70, 110], [30, 60, 80]] += 40
    np.savetxt(folder / "afm.txt", heights)
    rest = REST.replace("[[160, 96]]", "[[160, 96], [320, 192]]")
    return folder, run_scene(scene_in(folder, text + rest), folder / "results")


def test_the_budget_of_the_treatment_is_what_a_scene_so_treated_says(treated, tmp_path):
    folder, outputs = treated
    data = outputs.data
    names = data.variation.values.tolist()
    assert names == [
        "without the last octave of waves",
        "spikes clipped",
        "taper twice as wide",
        "holes filled: harmonic",
        "quadratic taken out",
    ]
    changes = data.treated_area_change.values
    assert_allclose(data.treatment_spread, math.sqrt(np.sum(changes**2)), rtol=1e-12)
    text = (folder / "scene.toml").read_text().replace('"afm.txt"', json.dumps(str(folder / "afm.txt")))
    pressure = f"pressure = {float(data.pressure)!r}"
    text = text.replace("reduced_pressure = 0.1", pressure).replace("[[160, 96], [320, 192]]", "[[160, 96]]")
    areas = {}
    treatments = {"": "", "spikes clipped": 'spikes = "clip"\n', names[0]: 'lambda_short = "0.5 um"\n'}
    for name, line in treatments.items():
        scene = scene_in(tmp_path, text.replace("tilt =", line + "tilt ="))
        alone = run_scene(scene, tmp_path / f"r{len(areas)}", report=False)
        assert "variation" not in alone.data.dims  # five more solves on its one grid are not cheap
        areas[name] = float(alone.data.area_own)
    for name in (names[0], "spikes clipped"):
        change = float(data.treated_area_change.sel(variation=name))
        assert change == pytest.approx(areas[name] / areas[""] - 1, abs=1e-6)
        assert abs(change) > 1e-3


def test_a_sweep_of_a_map_has_the_budget_of_each_case(treated):
    folder, outputs = treated
    sweep = load_asked(str(folder / "scene.toml"), ["sweep.load.reduced_pressure=[0.1, 0.2]"])
    swept = run_sweep(sweep, folder / "swept", bench=Bench.at(folder / "results" / "solves"))
    names = ["treated_area_change", "treated_gradient_change", "treatment_spread"]
    first = swept.data[names].isel(reduced_pressure=0)
    xr.testing.assert_allclose(first.drop_vars("reduced_pressure"), outputs.data[names], rtol=1e-12)
    worst = float(swept.data.treatment_spread.max())
    assert f"move the area by at most {100 * worst:.2g}" in (swept.folder / "report.html").read_text()
    cells = [row[swept.page.budget.columns.index("treatment [%]")] for row in swept.page.budget.rows]
    assert cells == pytest.approx(100 * swept.data.treatment_spread.values, rel=1e-12)
    # The larger of the two is the answer, the other stands below it.
    known = claim(swept.data, "area", surfaces=0.0, solver=0.0, grid=0.01 * swept.data.area)
    sure = next(card for card in sweep_views(known).cards if card.question == "How sure?")
    assert f"{100 * worst:.2g} % by treatment" in str(sure.answer)
    assert str(sure.basis).startswith("+- 1 % (95 %: ")
    assert str(sure.basis).endswith("); other treatments of the map move the area so far")


def test_the_treatment_of_a_map_is_in_its_budget_beside_what_the_interval_holds(treated):
    _, outputs = treated
    row = dict(zip(outputs.page.budget.columns, outputs.page.budget.rows[0], strict=True))
    assert (row["number"], row["treatment [%]"]) == ("A/A0", 100 * float(outputs.data.treatment_spread))
    error = 100 * float((outputs.data.area_error**2).sum() ** 0.5 / outputs.data.area)
    assert row["with treatment [%]"] == pytest.approx(math.hypot(row["treatment [%]"], error), rel=1e-12)
    titles, rows = page_tables((outputs.folder / "report.html").read_text())["What is uncertain"]
    assert float(dict(zip(titles, rows[0], strict=True))["treatment [%]"]) > 1
    judged = [one for one in audit(outputs.folder).entries if "treatment [%]" in one.name]
    assert len(judged) > 2
    assert all(one.agrees for one in judged)

    report = (outputs.folder / "report.html").read_text()
    assert "Budget of the treatment of the map" in report
    assert "judges this premise, not the theory" in report
    sure = next(str(card.answer) for card in run_views(outputs.data).cards if card.question == "How sure?")
    assert ("by treatment" in sure) == (100 * float(outputs.data.treatment_spread) > error)
    assert f"{100 * float(outputs.data.treatment_spread):.2g}" in sure
    assert_allclose(outputs.data.pixel, 1.25e-7, rtol=1e-12)
    assert float(outputs.data.steep_share) > 0.02


@pytest.mark.parametrize(
    ("heights", "left"),
    [
        (np.eye(48)[:, [24]] @ np.eye(48)[[24]], ["without the last octave of waves"]),  # one spike
        ((-1.0) ** np.add.outer(np.arange(48), np.arange(48)), []),  # waves of two points alone
    ],
)
def test_what_a_treatment_would_leave_flat_is_not_treated_so(map_scene, heights, left):
    scene = map_scene(heights)
    problems = [solve.problem for solve in run_solves(scene, realise(scene)) if solve.problem.variation]
    assert [problem.variation for problem in problems] == left
    assert all(problem.field.rms_gradient > 0 for problem in problems)


def test_without_its_last_octave_a_map_has_no_waves_of_it(treated):
    folder, _ = treated
    surface = load_scene(str(folder / "scene.toml")).surface
    full = Measured.read(surface)
    half = full.variations["without the last octave of waves"]
    assert half.shortest == pytest.approx(2 * full.shortest, rel=1e-12)
    rings = estimate_spectrum(half.period.heights, half.period.lengths, window="none")
    beyond = rings.q > 1.02 * 2 * math.pi / half.shortest
    assert rings.power[beyond].max() < 1e-20 * rings.power.max()
    assert half.spectrum.q_short <= 2 * math.pi / half.shortest * (1 + 1e-9)


def test_the_map_of_the_docs_is_made_and_gets_the_table_that_they_show(tmp_path, monkeypatch):
    page = (Path(__file__).parents[2] / "docs" / "my_afm_map.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```(\w+)\n(.*?)```", page, re.S)
    monkeypatch.chdir(tmp_path)
    exec(next(text for kind, text in blocks if kind == "python"), {})
    shown = next(text for kind, text in blocks if kind == "text").partition("before it is pressed: ")[2]
    scene = next(text for kind, text in blocks if kind == "toml")
    bare = re.sub("(tilt|missing|edges) = .*\n", "", scene)
    (tmp_path / "scene.toml").write_text(bare)
    with pytest.raises(UsageError) as caught:
        explain(load_scene("scene.toml"))
    refusal = str(caught.value).partition("cannot be pressed as it is\n")[2]
    assert refusal.replace(str(tmp_path / "afm.txt"), "afm.txt").strip() == shown.strip()
    (tmp_path / "scene.toml").write_text(scene)
    explanation = explain(load_scene("scene.toml"))
    # Its own two solves, and five of other treatments on the coarser grid.
    assert [grid.solves for grid in explanation.grids] == [6, 1]
    said = [words for name, words in explanation.facts if name == "measured"]
    assert sum("quadratic taken out" in words for words in said) == 1


@pytest.mark.parametrize("sweep", ["", "[sweep]\nload.reduced_pressure = [0.1, 0.2]\n"])
def test_faults_of_a_map_and_of_other_tables_come_at_once(sweep, tmp_path):
    np.save(tmp_path / "afm.npy", np.arange(64.0)[:, None] + np.random.default_rng(3).normal(size=(64, 64)))
    table = '[surface]\nkind = "file"\npath = "afm.npy"\n'
    with pytest.raises(UsageError) as caught:
        scene_in(tmp_path, table + REST.replace("2 MPa", "2 kg").replace("0.3", "0.7") + sweep)
    words = "solid.young = '2 kg'", "solid.poisson = 0.7", "surface.length: missing", 'tilt = "plane"'
    places = [str(caught.value).index(each) for each in words]
    assert places == sorted(places)
    assert str(caught.value).endswith('tilt = "plane"')
    treated = table + 'tilt = "plane"\nedges = "tukey"\n'
    with pytest.raises(UsageError, match=r"surface\.length: missing") as caught:
        scene_in(tmp_path, treated + REST + sweep)
    assert "cannot be pressed as it is" not in str(caught.value)


@pytest.mark.parametrize("length", ["64 um, 48 um", "64 um", '["64 um", "48 um"]', "[6.4e-5, 4.8e-5]"])
def test_the_table_to_paste_is_a_scene_whatever_the_length_was_written_as(length, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shape = (64, 48) if "," in length else (64, 64)
    waves = np.random.default_rng(3).normal(size=shape)
    np.save("afm.npy", waves + 5 * np.arange(shape[0])[:, None])
    shown = output_of("surface inspect afm.npy --unit nm --length", length)
    assert f"size: 64 um x {shape[1]} um" in shown
    table = re.search(r"^\[surface\]\n(?:\w+ = .*\n)+", shown, re.M)[0]
    (tmp_path / "scene.toml").write_text(table + REST)
    assert 'tilt = "plane"' in table
    size = (6.4e-5, 4.8e-5) if "," in length else (6.4e-5, 6.4e-5)
    assert load_scene("scene.toml").surface.length == pytest.approx(size)
    assert fc.measured("afm.npy", length=length, unit="nm", tilt="plane").field.lengths == pytest.approx(size)


def test_what_makes_a_map_doubtful_is_among_the_findings_and_in_what_python_shows(tmp_path):
    heights = patch(48) + np.linspace(0, 1e-6, 48)[:, None]
    np.save(tmp_path / "tilted.npy", heights)
    surface = fc.measured(heights, length="5 um", unit=1, tilt="keep", edges="tukey")
    contact = fc.press(surface, young="1000 MPa", poisson=0.3, pressure="50 bar", grid=48)
    words = "a plane that was not taken out holds"
    assert words in repr(surface)
    assert words not in repr(fc.measured(heights, length="5 um", unit=1, tilt="plane", edges="tukey"))
    assert words in repr(contact)
    assert "p0 = 50 bar" in repr(contact)
    assert any(finding.startswith(f"The map is doubtful: {words}") for finding in contact.findings)
    table = '[surface]\nkind = "file"\npath = "tilted.npy"\nlength = "5 um"\nunit = 1\nedges = "tukey"\n'
    scene = scene_in(tmp_path, f"{table}{PRESSED}[methods.theory]\n")
    outputs = run_scene(scene, tmp_path / "run", report=False)
    assert words in outputs.page.findings[0]


@pytest.mark.parametrize(
    ("lengths", "unit", "words"),
    [
        ((160.0, 120.0), 1e-6, "no instrument measures 160 m x 120 m"),
        ((1e-9, 1e-9), 1e-6, "slopes of .* are no surface's"),
        ((1e-5, 1e-5), 1e-12, "no instrument measures heights of"),
    ],
)
def test_sizes_slopes_and_heights_that_cannot_be_are_told_of_a_file_and_of_an_array(
    tmp_path, lengths, unit, words
):
    np.save(tmp_path / "scan.npy", patch(96) * 1e6)
    for heights in (patch(96) * 1e6, tmp_path / "scan.npy"):
        surface = fc.measured(heights, length=lengths, unit=unit, tilt="plane", edges="tukey")
        assert re.search(f"doubts=.*{words}", repr(surface))
        assert re.search(words, "; ".join(surface.given.patch.history))
        assert "doubts" not in repr(fc.measured(heights, length=1e-5, unit=1e-6))
    holed = patch(96) * 1e6
    holed[5:9, 7] = np.nan
    assert "doubts" not in repr(fc.measured(holed, length=1e-5, unit=1e-6, missing="harmonic"))


@pytest.mark.parametrize("fine", [1, 4])
def test_single_spikes_are_clipped_to_their_neighbours_and_a_gaussian_surface_is_left_alone(fine):
    rough = SelfAffine.from_rms_gradient(0.1, hurst=0.5, q_long=2 * np.pi, q_short=32 * np.pi)
    grid = (64 * fine, 64 * fine)
    field = random_surface(rough, q_short=rough.q_short, lengths=(1, 1), shape=grid, seed=4)
    heights = np.array(field.heights)
    clean = square(heights, 1.0)
    assert clean.clipped() is clean
    spiked = heights.copy()
    places = (np.array([0, 20, 41]), np.array([7, 63, 0]))
    spiked[places] += (4.5 * heights.std(), -4.5 * heights.std(), 4.5 * heights.std())
    spiked[40:44, 2:6] = np.nan
    found = square(spiked, 1.0).clipped()
    assert found.history == ("3 heights more than 6 standard deviations away clipped",)
    changed = np.argwhere(~((found.heights == spiked) | np.isnan(spiked)))
    assert changed.tolist() == np.transpose(places).tolist()
    around = heights[19:22, 62:65].copy()
    around[1, 1] = np.inf
    assert found.heights[20, 63] == around.min()
    # In a map of few digits most steps are none.
    coarse = np.repeat(np.arange(8.0), 8)[:, None] + np.zeros(64)
    coarse[::5, ::5] += 1
    # Pillars on a plane, and heights of which no two neighbours are known.
    pillars, sparse = np.zeros((16, 16)), np.full((16, 16), np.nan)
    pillars[::4, ::4], sparse[::2, ::2] = 1.0, heights[:8, :8]
    for left in (coarse, pillars, sparse):
        flat = square(left, 1.0)
        assert flat.clipped() is flat


def test_a_gaussian_surface_is_as_the_theory_assumes_and_one_with_spikes_is_not():
    waves = SelfAffine.from_rms_gradient(0.1, hurst=0.8, q_long=6e6, q_short=1e8)
    field = random_surface(waves, q_short=1e8, lengths=(1e-5, 1e-5), shape=(1024, 1024), seed=8)
    traits = height_statistics(field.heights, field.spacing)
    assert traits.is_gaussian
    assert traits.slope_kurtosis == pytest.approx(3, abs=0.15)
    assert traits.steep_share == pytest.approx(0.0079, rel=0.1)
    # Nayak (1971): m4 / (6 pi sqrt(3) m2) with the moments of a profile.
    m2, m4 = field.moments[1] / 2, 3 / 8 * field.moments[2]
    assert traits.summit_density == pytest.approx(m4 / m2 / (6 * math.pi * math.sqrt(3)), rel=0.1)
    spiked = np.array(field.heights)
    spiked[::90, ::90] += 30 * field.rms_height
    traits = height_statistics(spiked, field.spacing)
    assert not traits.is_gaussian
    assert traits.steep_share > 0.2


def test_heights_that_belong_to_no_surface_are_told(tmp_path):
    heights = np.random.default_rng(12).normal(size=(20, 20))
    np.save(tmp_path / "good.npy", heights)
    told = read_topography(tmp_path / "good.npy", lengths=(1.0, 1.0), unit=1.0).history
    assert not [words for words in told if "spikes" in words]
    raw = heights.copy()
    raw[3, 4] *= 2.0**32  # one bit of the exponent
    np.save(tmp_path / "bad.npy", raw)
    told = read_topography(tmp_path / "bad.npy", lengths=(1.0, 1.0), unit=1.0).history
    assert "1 of 400 heights lie more than 100 times the height of the middle half away" in told[-1]
