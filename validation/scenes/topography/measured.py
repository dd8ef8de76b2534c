"""A measured surface as its scene has it: read, hashed, levelled and filled once, made periodic once."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from validation.scenes.topography.patch import Topography
from validation.scenes.topography.reading import read_topography

if TYPE_CHECKING:
    from validation.scenes.tables import FileSurface

__all__ = ["Measured", "measured"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Measured:
    """A measured surface: its table of the scene, and its heights as the file has them."""

    surface: FileSurface
    raw: Topography

    @property
    def digest(self) -> str:
        """SHA-256 of the bytes that were read."""
        return self.raw.digest

    @cached_property
    def patch(self) -> Topography:
        """Levelled and filled; its edges are as they were."""
        return _frozen(self.raw.levelled(self.surface.tilt).filled(self.surface.missing))

    @cached_property
    def period(self) -> Topography:
        """The patch made periodic: what is pressed."""
        return _frozen(self.patch.made_periodic(self.surface.edges, margin=self.surface.margin))


def _frozen(topography: Topography) -> Topography:
    topography.heights.setflags(write=False)
    return topography


def measured(surface: FileSurface) -> Measured:
    """Read a measured surface; a UsageError for a file that gives none."""
    return Measured(
        surface=surface, raw=read_topography(surface.path, lengths=surface.length, unit=surface.unit)
    )
