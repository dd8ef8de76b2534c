"""Measured surfaces as text and as netCDF: however numbers are parted, points of a map, axes turned round."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from validation.errors import UsageError
from validation.scenes.topography.measured import file_says, read_topography

NUMBERS = np.round(np.random.default_rng(15).normal(size=(5, 4)), 3)


def written(heights, delimiter=" ", *, comma=False, end="\n"):
    text = end.join(delimiter.join(f"{h:.3f}" for h in row) for row in heights) + end
    return text.replace(".", ",") if comma else text


@pytest.mark.parametrize(
    ("name", "raw"),
    [
        ("spaces.txt", written(NUMBERS).encode()),
        ("tabs.dat", written(NUMBERS, "\t", end="\r\n").encode()),
        ("commas.csv", written(NUMBERS, ", ").encode()),
        ("semicolons.csv", written(NUMBERS, ";").encode()),
        ("decimal-commas.csv", written(NUMBERS, ";", comma=True).encode()),
        ("decimal-commas.txt", written(NUMBERS, "\t", comma=True).encode()),
        ("closed.csv", written(NUMBERS, ";", end=";\r\n").encode()),
        ("byte-order-mark.csv", "\ufeffa;b;c;d\n".encode() + written(NUMBERS, ";").encode()),
        ("utf-16.txt", ("# µm\n" + written(NUMBERS)).encode("utf-16")),
        ("old-mac.txt", written(NUMBERS, end="\r").encode()),
        ("tabs.tsv", b"# heights in nm\n" + written(NUMBERS, "\t").encode()),
        ("no-suffix", written(NUMBERS).encode()),
        ("empty-line.txt", b"\n# heights in nm\n" + written(NUMBERS).encode()),
    ],
)
def test_text_is_read_however_its_numbers_are_parted(tmp_path, name, raw):
    path = tmp_path / name
    path.write_bytes(raw)
    assert_array_equal(file_says(path).heights, NUMBERS)


@pytest.mark.parametrize(("delimiter", "comma"), [(" ", False), ("\t", True), (";", True), (", ", False)])
def test_a_map_may_begin_with_a_missing_point(tmp_path, delimiter, comma):
    holed = NUMBERS.copy()
    holed[0, 0] = np.nan
    (tmp_path / "holed.txt").write_text(written(holed, delimiter, comma=comma))
    assert_array_equal(file_says(tmp_path / "holed.txt").heights, holed)


@pytest.mark.parametrize("encoding", ["utf-8", "latin-1"])
def test_the_header_that_gwyddion_writes_says_size_and_unit(tmp_path, encoding):
    path = tmp_path / "gwyddion.txt"
    header = "# Channel: Topography\n# Width: 8,00 µm\n# Height: 10.0 µm\n# Value units: nm\n"
    path.write_bytes((header + written(NUMBERS, "\t")).encode(encoding))
    found = read_topography(path)
    # Rows run down the page: five of them over the height.
    assert_allclose(found.lengths, (1e-5, 8e-6), rtol=1e-15)
    assert_allclose(found.heights, NUMBERS * 1e-9, rtol=1e-15)
    assert found.unit == 1e-9


@pytest.mark.parametrize(
    "header",
    [
        "# Channel: Topography\n# Width: 3.00 µm\n# Height: 5.00 µm\n# Value units: nm\n",
        "# Kanal: Topographie\n# Breite: 3,00 µm\n# Höhe: 5,00 µm\n# Einheiten: nm\n",
    ],
)
def test_a_map_three_points_wide_with_a_header_of_gwyddion_is_no_list_of_points(tmp_path, header):
    (tmp_path / "narrow.txt").write_text(header + written(NUMBERS[:, :3]), encoding="utf-8")
    found = read_topography(tmp_path / "narrow.txt")
    assert_allclose(found.heights, NUMBERS[:, :3] * 1e-9, rtol=1e-15)
    assert_allclose(found.lengths, (5e-6, 3e-6), rtol=1e-15)


@pytest.mark.parametrize(
    ("header", "factor"),
    [
        ("# h=5 w=4\n# pixel size=0.5 um\n# height conversion factor (-> nm) = 2.5\n", 2.5),
        (
            "# x-pixels = 4\n# y-pixels = 5\n# x-length = 2000\n# y-length = 2500\n# x-unit = nm\n"
            "# y-unit = nm\n# z-unit = nm\n",
            1,
        ),
    ],
)
def test_a_header_that_only_surfacetopography_understands_says_size_and_unit(tmp_path, header, factor):
    pytest.importorskip("SurfaceTopography", reason="LOUD: SurfaceTopography is not installed")
    (tmp_path / "scan.txt").write_text(header + written(NUMBERS))
    found = read_topography(tmp_path / "scan.txt")
    # It has x along the columns.
    assert_allclose(found.heights, NUMBERS.T * factor * 1e-9, rtol=1e-12)
    assert_allclose(found.lengths, (2e-6, 2.5e-6), rtol=1e-12)
    (tmp_path / "scan.txt").write_text("# a header that nobody understands\n" + written(NUMBERS))
    assert_array_equal(file_says(tmp_path / "scan.txt").heights, NUMBERS)


def test_a_file_of_arrays_takes_the_size_that_is_given(tmp_path):
    pytest.importorskip("SurfaceTopography", reason="LOUD: SurfaceTopography is not installed")
    np.savez(tmp_path / "map.npz", NUMBERS)
    found = read_topography(tmp_path / "map.npz", lengths=(5e-6, 4e-6), unit=1e-9)
    assert_allclose(found.heights, NUMBERS * 1e-9, rtol=1e-15)


def test_elevations_that_any_bytes_could_be_are_believed_by_their_name(tmp_path):
    pytest.importorskip("SurfaceTopography", reason="LOUD: SurfaceTopography is not installed")
    metres = np.arange(500, 1701)[:, None] + np.zeros(1201)
    for name in ("N01E001.hgt", "N01E001.dat"):
        metres.astype(">i2").tofile(tmp_path / name)
    found = read_topography(tmp_path / "N01E001.hgt", lengths=(0.1, 0.1), unit=1e-9)
    assert_allclose(np.sort(found.heights, axis=None), np.sort(metres, axis=None) * 1e-9)
    with pytest.raises(UsageError, match="of no format that SurfaceTopography reads"):
        read_topography(tmp_path / "N01E001.dat", lengths=(0.1, 0.1), unit=1e-9)


def test_hdf5_of_several_data_sets_takes_the_size_that_is_given_and_damage_has_words_of_ours(tmp_path):
    pytest.importorskip("SurfaceTopography", reason="LOUD: SurfaceTopography is not installed")
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "two.h5", "w") as file:
        file["a"], file["b"] = NUMBERS, 2 * NUMBERS
    with pytest.raises(UsageError, match="does not say how large the patch is: give length"):
        read_topography(tmp_path / "two.h5")
    found = read_topography(tmp_path / "two.h5", lengths=(5e-6, 4e-6), unit=1e-9)
    assert_allclose(found.heights, NUMBERS * 1e-9, rtol=1e-15)
    assert "of its 2 channels 'a' (a, b)" in found.history
    for name in ("bad.opd", "bad.x3p", "bad.dat"):
        (tmp_path / name).write_bytes(b"PK" + np.random.default_rng(4).bytes(2000))
        with pytest.raises(UsageError, match="damaged, cut short, or of no format that SurfaceTopography"):
            read_topography(tmp_path / name)


def points(heights, *, digits=4, order=3):
    """Lines x y z of a map with steps of 1/3 and 1/7, in any order."""
    i, j = np.indices(heights.shape)
    rows = np.column_stack([i.ravel() / 3 + 2, j.ravel() / 7 - 1, heights.ravel()])
    np.random.default_rng(order).shuffle(rows)
    return "".join(f"{x:.{digits}f} {y:.{digits}f} {z:.3f}\n" for x, y, z in rows if np.isfinite(z))


@pytest.mark.parametrize("suffix", ["txt", "xyz"])
def test_three_columns_are_points_of_a_map(tmp_path, suffix):
    path = tmp_path / f"points.{suffix}"
    path.write_text("# x [um]  y [um]  z [nm]\n" + points(NUMBERS))
    found = read_topography(path)
    assert_allclose(found.heights, NUMBERS * 1e-9, rtol=1e-15)
    assert_allclose(found.lengths, (5e-6 / 3, 4e-6 / 7), rtol=1e-3)
    assert "three columns taken for x, y, z" in found.history[1]


def test_three_columns_without_units_need_lengths_in_their_ratio(tmp_path):
    path = tmp_path / "points.txt"
    holed = NUMBERS.copy()
    holed[1, 2] = holed[4, 0] = np.nan
    path.write_text(points(holed))
    with pytest.raises(UsageError, match="does not say how large"):
        read_topography(path)
    with pytest.raises(UsageError, match=r"its sides are in the ratio 2\.91\d*, and length = .* says 2"):
        read_topography(path, lengths=(2e-5, 1e-5), unit=1e-9)
    found = read_topography(path, lengths=(5e-6 / 3, 4e-6 / 7), unit=1e-9)
    assert_array_equal(np.isnan(found.heights), np.isnan(holed))


def test_the_netcdf_that_surfacetopography_writes_says_size_and_unit(tmp_path):
    from scipy.io import netcdf_file

    # As its writer does it: one unit for all on the axes, the sizes beside it, missing points in a mask.
    with netcdf_file(tmp_path / "map.nc", "w", version=2) as file:
        for axis, count, size in (("x", 5, 10.0), ("y", 4, 8.0)):
            file.createDimension(axis, count)
            positions = file.createVariable(axis, "f8", (axis,))
            positions.length, positions.periodic, positions.unit = size, 1, "um"
            positions[:] = np.arange(count) * size / count
        file.createVariable("heights", "f8", ("x", "y"))[:] = NUMBERS
        mask = file.createVariable("mask", "b", ("x", "y"))
        mask[:] = np.eye(5, 4)
    found = read_topography(tmp_path / "map.nc")
    assert_allclose(found.lengths, (1e-5, 8e-6), rtol=1e-15)
    assert_allclose(found.heights, np.where(np.eye(5, 4) != 0, np.nan, NUMBERS * 1e-6), rtol=1e-15)


@pytest.mark.parametrize(("along_x", "along_y"), [(-1, 1), (1, -1)])
def test_a_map_listed_against_its_axis_is_turned_round(tmp_path, along_x, along_y):
    import netCDF4

    for name, steps in (("up.nc", (1, 1)), ("down.nc", (along_x, along_y))):
        with netCDF4.Dataset(tmp_path / name, "w") as file:
            for axis, count, step in zip("xy", NUMBERS.shape, steps, strict=True):
                file.createDimension(axis, count)
                variable = file.createVariable(axis, "f8", (axis,))
                variable.units = "um"
                variable[...] = step * np.arange(float(count))
            file.createVariable("heights", "f8", ("x", "y"))[...] = NUMBERS[:: steps[0], :: steps[1]]
    up, down = (read_topography(tmp_path / name, unit=1e-6) for name in ("up.nc", "down.nc"))
    assert_array_equal(up.heights, down.heights)
    assert up.lengths == down.lengths
