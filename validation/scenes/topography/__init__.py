"""Measured topographies: read from files that nobody vouches for, levelled, filled, made periodic."""

from validation.scenes.topography.measured import Measured, fault_lines, measured
from validation.scenes.topography.patch import Edges, Missing, Tilt, Topography
from validation.scenes.topography.reading import FileSays, file_says, read_topography
from validation.scenes.topography.writing import write_topography

__all__ = [
    "Edges",
    "FileSays",
    "Measured",
    "Missing",
    "Tilt",
    "Topography",
    "fault_lines",
    "file_says",
    "measured",
    "read_topography",
    "write_topography",
]
