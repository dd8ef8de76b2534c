"""Reader of .npy: an array of numbers, whose size is known from its header."""

from __future__ import annotations

import io
import math

import numpy as np

from validation.scenes.topography.raw import Raw, check_shape, real

__all__ = ["read_npy"]


def read_npy(data: bytes) -> Raw:
    """Read the bytes of a .npy file; one that needs pickles is refused."""
    from numpy.lib import format as npy

    file = io.BytesIO(data)
    version = npy.read_magic(file)
    readers = {(1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0}
    if version not in readers:
        raise ValueError(f"version {version} of .npy, in which names are written, not heights")
    shape, _, kind = readers[version](file)
    if kind.kind not in "biuf":
        raise ValueError(f"it holds {kind.name} values; heights are real numbers")
    check_shape(shape)
    announced, there = math.prod(shape) * kind.itemsize, len(data) - file.tell()
    if there < announced:
        raise ValueError(f"{there} bytes of heights where {announced} are announced")
    file.seek(0)
    return Raw(heights=real(np.load(file, allow_pickle=False)))
