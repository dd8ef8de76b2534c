"""Small files that bring readers of heights down, made by code; and damage done to good ones."""

import io
import struct
import tempfile
import zipfile
import zlib
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from fem_contact import HeightField
from validation.scenes.topography.writing import write_topography

Files = Iterator[tuple[str, bytes]]


def good(suffix, shape=(12, 10)):
    """A file that is read without complaint."""
    heights = np.random.default_rng(77).normal(size=shape) * 1e-9
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"good{suffix}"
        write_topography(path, HeightField(heights=heights, lengths=(1.2e-6, 1.0e-6)))
        return path.read_bytes()


def all_hostile():
    """Every one of them, with the name it should have."""
    yield from _nothing()
    yield from _npy()
    yield from _text()
    yield from _netcdf()
    yield from _x3p()


def _nothing():
    for suffix in (".npy", ".txt", ".csv", ".dat", ".asc", ".nc"):
        yield f"empty{suffix}", b""
        yield f"zeros{suffix}", bytes(4096)
        yield f"ones{suffix}", b"\xff" * 4096
        yield f"noise{suffix}", np.random.default_rng(6).bytes(4096)
        yield f"half{suffix}", good(".txt" if suffix in (".csv", ".dat", ".asc") else suffix)[:-70]


def _npy():
    def header(text, version=b"\x01\x00"):
        size = struct.pack("<H" if version[0] == 1 else "<I", len(text))
        return b"\x93NUMPY" + version + size + text.encode()

    def says(kind, shape):
        return header(f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}\n")

    yield "petabytes.npy", says("<f8", "(100000000, 200000000)")
    yield "gigabytes.npy", says("<f8", "(40000, 40000)") + bytes(64)
    yield "negative.npy", says("<f8", "(-4, -4)") + bytes(128)
    yield "no-axis.npy", says("<f8", "()") + bytes(8)
    yield "one-axis.npy", says("<f8", "(16,)") + bytes(128)
    yield "empty-axis.npy", says("<f8", "(0, 8)")
    yield "three-axes.npy", says("<f8", "(2, 2, 2)") + bytes(64)
    yield "short.npy", says("<f8", "(8, 8)") + bytes(64)
    yield "objects.npy", says("|O", "(2, 2)") + b"cos\nsystem\n(S'true'\ntR." * 4
    yield "no-type.npy", says("<q9", "(2, 2)") + bytes(64)
    yield "zero-width.npy", says("|V0", "(2, 2)")
    yield "nested.npy", header("(" * 9000 + "\n")
    yield "long-header.npy", header("{" + " " * 2_000_000, b"\x02\x00")
    yield "announced-header.npy", b"\x93NUMPY\x02\x00" + struct.pack("<I", 2**32 - 1) + b"{"
    yield "unknown-version.npy", header("{}", b"\x09\x00")
    yield "calls.npy", header("__import__('os').getcwd()\n")
    yield "dates.npy", says("<M8[s]", "(4, 4)") + bytes(128)
    yield "archive.npy", _archive({"main.xml": b"", "a.npy": b""})


def _text():
    rows = b"1 2 3 4\n5 6 7 8\n9 1 2 3\n4 5 6 7\n"
    yield "utf-16-half.txt", "1 2\n3 4\n".encode("utf-16")[:-1]
    yield "no-utf-8.txt", b"# Width: 10 \xb5m \xff\xfe\n" + b"x" + rows
    yield "letters-within.txt", rows + b"five 6 7 8\n" + rows
    yield "control.txt", b"\x1b[31m\x07" + rows
    yield "escapes-within.txt", rows + b"\x1b]0;title\x07 2 3 4\n"
    yield "zero-byte.txt", b"1 2\n3 \x004\n"
    yield "ragged.txt", b"1 2 3 4\n5 6\n7 8 9 1\n"
    yield "one-row-of-a-million.txt", b"1 " * 10**6 + b"\n"
    yield "one-column.txt", b"1\n" * 1000
    yield "one-number-of-a-megabyte.txt", b"9" * 2**20 + b"\n"
    yield "announced-rows.txt", b"1 2 3 4 5 6 7 8 " * 64 + b"\n" * 2**21
    yield "header-alone.txt", b"# Channel: Topography\n# Width: 1 um\n"
    yield "header-without-end.txt", b"#" * 2**20
    yield "volts.txt", b"# Width: 1 um\n# Height: 1 um\n# Value units: V\n" + rows
    yield "endless-unit.txt", b"# Width: 1 um\n# Height: 1 um\n# Value units: m**9**9**9\n" + rows
    yield "width-nan.txt", b"# Width: ,,e um\n# Height: 1 um\n# Value units: m\n" + rows
    yield "scattered.txt", b"0 0 1\n1 3 2\n2.3 1 1\n4 .4 2\n5 5 5\n"
    yield "points-twice.txt", b"0 0 1\n0 1 2\n1 0 1\n1 1 2\n1 1 5\n"
    yield "points-on-a-diagonal.txt", b"".join(b"%d %d 1\n" % (i, i) for i in range(200))
    yield "points-of-a-huge-grid.txt", b"".join(b"%d %d 1\n" % (i, i) for i in range(20_000))
    yield "narrow-map.txt", b"1 5 3\n2 3 9\n7 3 3\n8 1 1\n5 5 5\n"
    yield "empty-fields.csv", b"1;;3;4\n5;6;7;8\n1;2;3;4\n"
    yield "thousands.csv", b"1.000,5;2.000,5;1;1\n1.000,5;2.000,5;1;1\n"
    yield "quoted.csv", b'"1","2"\n"3","4"\n'
    yield "overflow.csv", b"1e999,1e999\n1,2\n"


def _archive(entries):
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in entries.items():
            archive.writestr(name, content)
    return file.getvalue()


def _x3p():
    """Archives for the reader of SurfaceTopography, which has its own views of what is damaged."""
    xml, data = X3P.encode(), np.arange(120.0).tobytes()

    def with_xml(text, data=data):
        return _archive({"main.xml": text, "data.bin": data})

    yield "no-data.x3p", _archive({"main.xml": xml})
    laughs = b'<!DOCTYPE l [<!ENTITY a "ha">' + b"".join(
        b'<!ENTITY a%d "%s">' % (k, b"&a%s;" % (b"%d" % (k - 1) if k else b"") * 10) for k in range(10)
    )
    yield "laughs.x3p", with_xml(laughs + b"]>" + xml.replace(b"SUR", b"&a9;"))
    yield "announced.x3p", with_xml(xml.replace(b"<SizeX>12", b"<SizeX>40000"))
    for name, value in {"zero": b"0", "word": b"many", "digits": b"9" * 6000}.items():
        yield f"size-{name}.x3p", with_xml(xml.replace(b"<SizeX>12", b"<SizeX>" + value))
    # It says that it unpacks to 960 bytes, and unpacks to 256 MiB.
    yield "lying.x3p", with_xml(xml, bytes(2**28)).replace(struct.pack("<I", 2**28), struct.pack("<I", 960))


#: main.xml of a map of 12 x 10 heights.
X3P = (
    '<p:ISO5436_2 xmlns:p="http://www.opengps.eu/2008/ISO5436_2"><Record1><Revision>ISO5436 - 2000</Revision>'
    "<FeatureType>SUR</FeatureType><Axes><CX><AxisType>I</AxisType><DataType>D</DataType>"
    "<Increment>1e-7</Increment></CX><CY><AxisType>I</AxisType><DataType>D</DataType>"
    "<Increment>2e-7</Increment></CY><CZ><AxisType>A</AxisType><DataType>D</DataType></CZ></Axes></Record1>"
    "<Record3><MatrixDimension><SizeX>12</SizeX><SizeY>10</SizeY><SizeZ>1</SizeZ></MatrixDimension>"
    "<DataLink><PointDataLink>data.bin</PointDataLink></DataLink></Record3></p:ISO5436_2>"
)


def _netcdf():
    import netCDF4

    def made(build, **options):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "made.nc"
            with netCDF4.Dataset(path, "w", **options) as file:
                build(file)
            return path.read_bytes()

    def plain(nx=6, ny=5, kind="f8", unit="nm", x_unit="um", x=None, **storage):
        def build(file):
            for axis, count in (("x", nx), ("y", ny)):
                file.createDimension(axis, count)
                position = file.createVariable(axis, "f8", (axis,))
                if x_unit is not None:
                    position.units = x_unit
                if count and count < 10**4:
                    position[...] = np.arange(count) if x is None or axis == "y" else x
            heights = file.createVariable("heights", kind, ("x", "y"), **storage)
            if unit is not None:
                heights.units = unit
            if nx and ny and nx * ny < 10**6 and kind is not str:
                heights[...] = np.ones((nx, ny))

        return build

    for layout in ("NETCDF4", "NETCDF3_CLASSIC", "NETCDF3_64BIT_OFFSET", "NETCDF3_64BIT_DATA"):
        yield f"cut-{layout}.nc", made(plain(), format=layout)[:-100]
        yield f"headed-{layout}.nc", made(plain(), format=layout)[:200]
    yield "nothing.nc", made(lambda file: None)
    yield "empty-axis.nc", made(plain(nx=0))
    yield "one-point.nc", made(plain(nx=1, ny=1))
    yield "huge.nc", made(plain(nx=10**6, ny=10**6, zlib=True, chunksizes=(1000, 1000)))
    yield "huge-chunk.nc", made(plain(nx=30_000, ny=30_000, zlib=True, chunksizes=(16_000, 16_000)))
    yield "texts.nc", made(plain(kind=str))
    yield "unit-array.nc", made(plain(unit=np.array([1.0, 2.0])))
    yield "unit-number.nc", made(plain(unit=3))
    yield "unit-texts.nc", made(plain(unit=["nm", "um"]))
    yield "x-unit-array.nc", made(plain(x_unit=np.arange(3)))
    yield "endless-unit.nc", made(plain(unit="m**9**9**9"))
    yield "endless-x-unit.nc", made(plain(x_unit="m**9**9**9"))
    yield "long-unit.nc", made(plain(unit="nm " * 10**5))
    yield "seconds.nc", made(plain(unit="s"))
    yield "escaping-unit.nc", made(plain(unit="\x1b[31m"))
    yield "uneven.nc", made(plain(x=[0, 1, 2, 4, 8, 16]))
    yield "standing.nc", made(plain(x=[1] * 6))
    yield "unknown-x.nc", made(plain(x=[0, 1, np.nan, 3, 4, 5]))
    yield "infinite-x.nc", made(plain(x=[0, 1, 2, 3, 4, np.inf]))

    def telling(names, key, value):
        def build(file):
            plain()(file)
            for name in names:
                file[name].setncattr(key, value)

        return build

    for name, value in {"text": "large", "array": np.arange(3.0)}.items():
        yield f"scale-{name}.nc", made(telling(("heights",), "scale_factor", value))
    for name, value in {"text": "long", "array": np.arange(3.0), "nan": np.nan, "minus": -6.0}.items():
        yield f"length-{name}.nc", made(telling("xy", "length", value))

    def holding(variables):
        def build(file):
            for axis in "xyz":
                file.createDimension(axis, 4)
            for name, (kind, *axes) in variables(file).items():
                file.createVariable(name, kind, axes)

        return build

    pair = np.dtype([("a", "f8"), ("b", "f8")])
    yield "two-maps.nc", made(holding(lambda file: {"first": ("f8", "x", "y"), "second": ("f8", "y", "z")}))
    yield "crossed.nc", made(holding(lambda file: dict.fromkeys(("x", "heights"), ("f8", "x", "y"))))
    for name, kind in {
        "compound": lambda file: file.createCompoundType(pair, "pair"),
        "ragged": lambda file: file.createVLType("f8", "ragged"),
    }.items():
        yield f"{name}.nc", made(holding(lambda file, kind=kind: {"heights": (kind(file), "x", "y")}))

    def elsewhere(build):
        import h5py

        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "made.nc"
            with h5py.File(path, "w", libver="latest") as file:
                build(file, h5py)
            return path.read_bytes()

    layout = {"shape": (4, 4), "dtype": "f8"}

    def virtual(file, h5py):
        whole = h5py.VirtualLayout(**layout)
        whole[...] = h5py.VirtualSource("/tmp/other.h5", "heights", shape=(4, 4))
        file.create_virtual_dataset("heights", whole)

    yield "virtual.nc", elsewhere(virtual)
    outside = {"external": [("/etc/passwd", 0, 128)]}
    yield "external.nc", elsewhere(lambda file, _: file.create_dataset("heights", **layout, **outside))
    yield (
        "linked.nc",
        elsewhere(lambda file, h5py: file.update(heights=h5py.ExternalLink("/tmp/other.h5", "heights"))),
    )
    # A classic header that announces 2^31 - 1 dimensions.
    yield "announced.nc", b"CDF\x01" + struct.pack(">iii", 0, 10, 2**31 - 1) + bytes(64)
    yield "announced-name.nc", b"CDF\x01" + struct.pack(">iiii", 0, 10, 1, 2**31 - 1) + bytes(64)
    yield "announced-64.nc", b"CDF\x05" + struct.pack(">qiqq", 0, 10, 2**62, 2**62) + bytes(64)
    yield "packed.nc", zlib.compress(made(plain()))


def damaged(raw, *, seed):
    """A good file after a flipped bit, a zeroed or repeated block, a cut, or a number made extreme."""
    chance = np.random.default_rng(seed)
    copy = bytearray(raw)
    place = int(chance.integers(len(copy)))
    match int(chance.integers(6)):
        case 0:
            copy[place] ^= 1 << int(chance.integers(8))
        case 1:
            size = int(chance.choice([16, 64, 512]))
            start = place // size * size
            copy[start : start + size] = bytes(len(copy[start : start + size]))
        case 2:
            del copy[place:]
        case 3:
            copy[place : place + 4] = bytes.fromhex("ffffffff")
        case 4:
            copy[place:place] = copy[place // 2 : place // 2 + 64]
        case _:
            for spot in chance.integers(len(copy), size=8):
                copy[int(spot)] = int(chance.integers(256))
    return bytes(copy)
