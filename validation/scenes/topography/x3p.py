"""Reader of ISO 25178-72 (X3P): a ZIP archive with main.xml and a binary matrix, x fastest, in metres."""

from __future__ import annotations

import io
import math
import zipfile
from xml.etree import ElementTree
from xml.parsers import expat

import numpy as np

from validation.scenes.topography.raw import Raw, check_shape

__all__ = ["read_x3p"]

#: Types of the binary matrix.
_TYPES = {"I": "<i2", "L": "<i4", "F": "<f4", "D": "<f8"}
#: Bytes of main.xml, and how deep its elements are nested; real ones have some ten thousand, and six.
_MOST_XML, _MOST_DEPTH = 2**22, 64
_MOST_ENTRIES = 4096
#: The ways of packing that are unpacked here; those that others use are named when met.
_PACKINGS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)


def read_x3p(data: bytes) -> Raw:
    """Read the bytes of an X3P file."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        if len(archive.infolist()) > _MOST_ENTRIES:
            raise ValueError(f"{len(archive.infolist())} entries; at most {_MOST_ENTRIES} are looked at")
        root = _parsed(_unpacked(archive, "main.xml", most=_MOST_XML))
        axes = {name: _child(root, "Axes", name) for name in ("CX", "CY", "CZ")}
        steps = [_step(axes[name], name) for name in ("CX", "CY")]
        size = _child(root, "Record3", "MatrixDimension")
        nx, ny = (_count(size, name) for name in ("SizeX", "SizeY"))
        check_shape((nx, ny))
        said = _text(axes["CZ"], "DataType")
        if said not in _TYPES:
            raise ValueError(f"DataType {said[:20]!r} of CZ; it must be one of {', '.join(_TYPES)}")
        kind = np.dtype(_TYPES[said])
        link = _text(root, "Record3", "DataLink", "PointDataLink")
        raw = _unpacked(archive, link, most=nx * ny * kind.itemsize)
        if len(raw) != nx * ny * kind.itemsize:
            raise ValueError(f"{len(raw) // kind.itemsize} heights where {nx} x {ny} are announced")
        heights = np.frombuffer(raw, dtype=kind).reshape(ny, nx).T.astype(float)
        if kind.kind == "i":
            heights *= _step(axes["CZ"], "CZ")
        mask = next((node for node in root.iter() if _local(node) == "ValidPointsLink"), None)
        if mask is not None and mask.text and mask.text.strip():
            needed = -(-nx * ny // 8)
            packed = _unpacked(archive, mask.text.strip(), most=2 * needed + 64)
            bits = np.unpackbits(np.frombuffer(packed, np.uint8), bitorder="little")
            if bits.size < nx * ny:
                raise ValueError(f"{bits.size} marks of valid points where {nx * ny} are needed")
            heights[~bits[: nx * ny].reshape(ny, nx).T.astype(bool)] = np.nan
    return Raw(heights=heights, lengths=(nx * steps[0], ny * steps[1]), length_units=("m", "m"), unit="m")


def _unpacked(archive: zipfile.ZipFile, name: str, *, most: int) -> bytes:
    """Unpack an entry, and no more of it than is allowed: what an archive announces may be a lie."""
    try:
        entry = archive.getinfo(name)
    except KeyError:
        raise ValueError(f"has no entry {name[:80]!r}") from None
    if entry.flag_bits & 0x1:
        raise ValueError(f"{name!r} is encrypted; unpack it and pack it without a password")
    if entry.compress_type not in _PACKINGS:
        raise ValueError(f"{name!r} is packed in way {entry.compress_type}; pack it anew with deflate")
    if entry.file_size > most:
        raise ValueError(f"{name!r} is {entry.file_size} bytes long; at most {most} belong there")
    with archive.open(entry) as file:
        found = file.read(most + 1)
    if len(found) > most:
        raise ValueError(f"{name!r} is longer than the {most} bytes that belong there")
    return found


def _parsed(text: bytes) -> ElementTree.Element:
    """Parse XML that declares no document type: without one there are no entities, which may grow."""
    builder, depth = ElementTree.TreeBuilder(), 0

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal depth
        depth += 1
        if depth > _MOST_DEPTH:
            raise ValueError(f"main.xml is nested more than {_MOST_DEPTH} deep")
        builder.start(tag, attributes)

    def end(tag: str) -> None:
        nonlocal depth
        depth -= 1
        builder.end(tag)

    def refuse(*_: object) -> None:
        raise ValueError("main.xml declares a document type, which X3P has no use for")

    parser = expat.ParserCreate(namespace_separator="}")
    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.CharacterDataHandler = builder.data
    parser.StartDoctypeDeclHandler = refuse
    try:
        parser.Parse(text, True)
    except expat.ExpatError as error:
        raise ValueError(f"main.xml: {error}") from None
    return builder.close()


def _local(node: ElementTree.Element) -> str:
    # Some writers put the tags into a namespace, some do not.
    return node.tag.rpartition("}")[2]


def _child(node: ElementTree.Element, *names: str) -> ElementTree.Element:
    for name in names:
        found = next((child for child in node.iter() if _local(child) == name), None)
        if found is None:
            raise ValueError(f"main.xml has no {name}")
        node = found
    return node


def _text(node: ElementTree.Element, *names: str) -> str:
    return (_child(node, *names).text or "").strip()


def _step(axis: ElementTree.Element, name: str) -> float:
    said = _text(axis, "Increment")
    try:
        step = float(said)
    except ValueError:
        step = math.nan
    if not (math.isfinite(step) and step > 0):
        raise ValueError(f"Increment {said[:40]!r} of {name}; it must be a number of metres above 0")
    return step


def _count(size: ElementTree.Element, name: str) -> int:
    said = _text(size, name)
    if not (said.isascii() and said.isdigit() and len(said) < 12):
        raise ValueError(f"{name} {said[:40]!r}; it must be a whole number of points")
    return int(said)
