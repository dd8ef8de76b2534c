"""A measured surface as its scene has it: read, hashed, levelled and filled once, made periodic once."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

from validation.errors import UsageError
from validation.scenes.topography.patch import REMOVABLE, Topography
from validation.scenes.topography.reading import read_topography

if TYPE_CHECKING:
    from validation.scenes.tables import FileSurface

__all__ = ["Measured", "fault_lines", "measured"]


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
        surface = self.surface
        patch = self.raw.levelled(surface.tilt or "keep").filled(surface.missing)
        share = self.raw.plane_share if surface.tilt in (None, "keep") else 0.0
        if share > REMOVABLE and surface.edges is not None:
            words = (
                f"a plane that was not taken out holds {100 * share:.3g} % of the variance: with "
                'tilt = "plane" the area may be another'
            )
            patch = replace(patch, history=(*patch.history, words))
        return _frozen(patch)

    def check(self, *keys: str) -> None:
        """Raise a UsageError of all that keeps it from being pressed, or of what these keys mend."""
        faults = {k: fault for k, fault in self.faults.items() if not keys or k in keys}
        if faults:
            table = self.surface.model_dump()
            raise UsageError("\n".join(("cannot be pressed as it is", *fault_lines(faults, table))))

    @cached_property
    def faults(self) -> dict[str, tuple[str, str]]:
        """What keeps it from being pressed, and the remedies, by key."""
        return self.raw.faults(**self.surface.model_dump())

    @cached_property
    def period(self) -> Topography:
        """The patch made periodic: what is pressed. A UsageError of all that keeps it from being pressed."""
        self.check()
        return _frozen(self.patch.made_periodic(self.surface.edges, margin=self.surface.margin))


def fault_lines(faults: Mapping[str, tuple[str, str]], table: Mapping[str, Any]) -> tuple[str, ...]:
    """Return a line for each fault, and the table of the scene that mends them all, to be pasted."""
    remedies = {key: json.dumps(remedy) for key, (_, remedy) in faults.items()}
    block = [f"path = {json.dumps(str(table['path']))}"]
    block += [f"{key} = {remedy}" for key, remedy in remedies.items()]
    return (
        *(f"  {key}: {words}" for key, (words, _) in faults.items()),
        "paste into the scene (and choose anew what you know better):",
        "",
        "[surface]",
        'kind = "file"',
        *block,
    )


def _frozen(topography: Topography) -> Topography:
    topography.heights.setflags(write=False)
    return topography


def measured(surface: FileSurface) -> Measured:
    """Read a measured surface; a UsageError for a file that gives none."""
    return Measured(
        surface=surface, raw=read_topography(surface.path, lengths=surface.length, unit=surface.unit)
    )
