"""A measured surface as its scene has it: read, hashed, levelled and filled once, made periodic once.

Files are read within bounds of time and memory, once for a file.
"""

from __future__ import annotations

import contextlib
import functools
import json
import math
import os
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fem_contact.surface import HeightField, Patch
from fem_contact.surface.spectra import estimate_spectrum
from validation import sandbox
from validation.arrays import Array, Pair
from validation.errors import UsageError
from validation.report.quantities import as_length
from validation.scenes.topography.formats import one_line, read_plain
from validation.scenes.topography.patch import MOST_HOLES, REMOVABLE, Faults, Topography, rms
from validation.scenes.topography.raw import MOST_POINTS, RATIO, FileSays
from validation.units import LARGEST

if TYPE_CHECKING:
    from persson.tabulated import Tabulated
    from validation.scenes.tables import FileSurface


#: Time to read a file, and bytes of it that are read in a further second [s, 1/s].
_SECONDS, _BYTES_PER_SECOND = 60.0, 2e6
#: Memory to read a file: that of the largest map in a few copies, and more for the text of it.
_MEMORY, _COPIES = 2**31 + 2**30, 4
#: Sides of a patch and of its cells [m], rms slopes and heights [m], that no instrument goes beyond.
_LARGEST_PATCH, _SMALLEST_CELL, _STEEPEST, _LEAST_HEIGHT = 1.0, 1e-12, 10.0, 1e-12
#: A file that was changed less than this before it was read is read again: a later change may have the same
#: time [s].
_SETTLED = 1.0


def file_says(path: Path) -> FileSays:
    """Read a file as it is; a file that has not changed since is not read again.

    A UsageError for one that cannot be read, or not within bounds of size, time and memory.
    """
    name = os.path.abspath(path)
    try:
        facts = os.stat(name)
    except (OSError, ValueError):  # whoever reads it says why
        return _read(name)
    changed = max(facts.st_mtime_ns, facts.st_ctime_ns)
    unsettled = time.monotonic_ns() if time.time() - changed / 1e9 < _SETTLED else 0
    return _read(name, facts.st_size, (facts.st_dev, facts.st_ino, changed, unsettled))


@functools.lru_cache(maxsize=1)
def _read(name: str, size: int = 0, content: tuple[int, ...] = ()) -> FileSays:
    """Read a file of a size; `content` is for the cache alone: it differs where the file has changed."""
    del content
    try:
        says: FileSays = sandbox.call(
            read_plain,
            name,
            seconds=_SECONDS + size / _BYTES_PER_SECOND,
            memory=_MEMORY + _COPIES * size,
            most_bytes=8 * MOST_POINTS,
        )
    except sandbox.OutOfBounds as error:
        raise UsageError(f"cannot be read: its reader {error}") from None
    return says


def read_topography(path: Path, *, lengths: Pair | None = None, unit: float | None = None) -> Topography:
    """Read a topography: .npy, text, .nc, and whatever SurfaceTopography reads where it is installed.

    Text is a matrix, rows along x, or three columns x, y, z of an even grid; a width and a height in its
    header, as Gwyddion writes them, are the sizes along its columns and rows.

    The size [m] and the unit of the heights [m] are those of the file if not given. A UsageError for a file
    that cannot be read, or says neither and is given none: heights taken for metres by default would be wrong
    by the factor that instruments most often leave out.
    """
    says = file_says(path)
    size = lengths or says.lengths
    if size is None:
        raise UsageError("does not say how large the patch is: give length")
    scale = unit if unit is not None else says.unit
    if scale is None:
        raise UsageError('does not say the unit of its heights: give unit, such as "1 nm"')
    if says.lengths is None and says.ratio is not None and abs(size[0] / size[1] / says.ratio - 1) > RATIO:
        raise UsageError(
            f"its sides are in the ratio {says.ratio:.4g}, and length = [{size[0]:.4g}, {size[1]:.4g}] m "
            f"says {size[0] / size[1]:.4g}: give both sides, [Lx, Ly]"
        )
    heights = np.where(np.isfinite(says.heights), says.heights, np.nan)
    peak = float(np.abs(says.heights).max(where=np.isfinite(says.heights), initial=0.0)) * scale
    if not peak <= LARGEST:
        raise UsageError(f"holds heights up to {peak:.3g} m; at most {LARGEST:.0e} m are computed with")
    heights *= scale
    heights.setflags(write=False)
    (nx, ny), own = heights.shape, says.lengths or size
    words = f"{one_line(path.name)}: {nx} x {ny} points, {_sides(size)}"
    if any(abs(a / b - 1) > RATIO for a, b in zip(size, own, strict=True)):
        words += f" (its own: {_sides(own)})"
    cells = size[0] / nx, size[1] / ny
    if abs(cells[0] / cells[1] - 1) > RATIO:
        words += f", oblong cells of {_sides(cells)}"
    history = (words, *says.notes)
    return Topography(heights=heights, lengths=size, history=history, unit=scale, digest=says.digest)


def _sides(sides: Pair) -> str:
    return " x ".join(as_length(side, 4) for side in sides)


def impossible(heights: Array, size: Pair) -> Iterator[str]:
    """Yield what no instrument measures: more likely a unit that is missing, or another."""
    cells = [side / n for side, n in zip(size, heights.shape, strict=True)]
    if max(size) > _LARGEST_PATCH or min(cells) < _SMALLEST_CELL:
        yield (
            f"no instrument measures {as_length(size[0], 3)} x {as_length(size[1], 3)} in cells of "
            f"{as_length(min(cells), 3)}: check the unit of length"
        )
    with np.errstate(over="ignore", invalid="ignore"):
        slope = max(rms(np.diff(heights, axis=axis)) / cells[axis] for axis in (0, 1))
    if slope > _STEEPEST:
        yield f"root mean square slopes of {slope:.3g} are no surface's: check unit and length"
    known = heights[np.isfinite(heights)]
    if known.size and (height := float(np.std(known))) < _LEAST_HEIGHT:
        yield f"no instrument measures heights of {as_length(height, 3)}, root mean square: check their unit"


@dataclass(frozen=True, kw_only=True, eq=False)
class Measured:
    """A measured surface: its table of the scene, and its heights as the file has them."""

    surface: FileSurface
    raw: Topography

    @classmethod
    def read(cls, surface: FileSurface, number: int = 0) -> Measured:
        """Read a measured surface, or a further map of it; a UsageError for a file that gives none."""
        path = (surface.path, *surface.more_paths)[number]
        surface = surface.model_copy(update={"path": path, "more_paths": ()})
        with _naming(surface):
            raw = read_topography(surface.path, lengths=surface.length, unit=surface.unit)
        return cls.of(surface, raw)

    @classmethod
    def of(cls, surface: FileSurface, raw: Topography) -> Measured:
        """Return heights with those of the other body, where there is one."""
        if surface.second_path is None:
            return cls(surface=surface, raw=raw)
        with _naming(surface, "second_path"):
            second = read_topography(surface.second_path, lengths=surface.length, unit=surface.unit)
            return cls(surface=surface, raw=raw.facing(second))

    @cached_property
    def patch(self) -> Topography:
        """Levelled and filled; its edges are as they were."""
        surface = self.surface
        patch = self.raw.levelled(surface.tilt or "keep")
        patch = (patch.clipped() if surface.spikes == "clip" else patch).filled(surface.missing)
        return _frozen(replace(patch, history=(*patch.history, *self.doubts)))

    @cached_property
    def doubts(self) -> tuple[str, ...]:
        """What makes its numbers doubtful: what no instrument measures, a plane that was kept."""
        surface, found = self.surface, [*impossible(self.raw.heights, self.raw.lengths)]
        share = self.raw.plane_share if surface.tilt in (None, "keep") else 0.0
        if share > REMOVABLE and surface.edges is not None:
            found.append(
                f"a plane that was not taken out holds {100 * share:.3g} % of the variance: with "
                'tilt = "plane" the area may be another'
            )
        return tuple(found)

    def check(self, *keys: str) -> None:
        """Raise a UsageError of all that keeps it from being pressed, or of what these keys mend."""
        with _naming(self.surface):
            faults = {k: fault for k, fault in self.faults.items() if not keys or k in keys}
            if faults:
                raise UsageError(f"cannot be pressed as it is{self.remedy(faults)}")

    def remedy(self, faults: Faults) -> str:
        """Say what is wrong, and what of a scene mends it."""
        return "\n".join(("", *fault_lines(faults, {"path": str(self.surface.path)})))

    @cached_property
    def faults(self) -> Faults:
        """What keeps it from being pressed, and the remedies, by key."""
        return self.raw.faults(**self.surface.model_dump())

    @cached_property
    def period(self) -> Topography:
        """The patch made periodic: what is pressed. A UsageError of all that keeps it from being pressed.

        Its heights are those over their mean plane, from which distances are counted; of a patch with edges
        they are as the file has them.
        """
        self.check()
        period = self.patch.made_periodic(self.surface.edges, margin=self.surface.margin)
        if self.surface.edges != "free":
            period = replace(period, heights=period.heights - np.mean(period.heights))
        return _frozen(period.smoothed(self.surface.lambda_short))

    @property
    def field(self) -> HeightField:
        """Its heights as one period, or a patch with edges; they are rough, since p* divides by h'_rms."""
        if not self.is_rough:
            with _naming(self.surface):
                raise UsageError("is flat (h'_rms = 0); a scene needs a rough surface")
        return self._field

    @cached_property
    def _field(self) -> HeightField:
        field = self.period.height_field()
        return Patch(heights=field.heights, lengths=field.lengths) if self.surface.edges == "free" else field

    @property
    def is_rough(self) -> bool:
        """Whether its heights are more than what rounding leaves of a plane."""
        noise = 1e-13 * float(np.nanmax(np.abs(self.raw.heights)))
        return self._field.rms_gradient > 0 and self._field.rms_height > noise

    @cached_property
    def spectrum(self) -> Tabulated:
        """C(q), estimated from the patch before its edges were tapered.

        A patch that is one period needs no window; any other gets a Hann window, with its loss made up for.
        """
        from persson.tabulated import Tabulated

        periodic, patch = self.surface.edges in (None, "periodic"), self.patch
        rings = estimate_spectrum(patch.heights, patch.lengths, window="none" if periodic else "hann")
        cut = 2 * math.pi / self.shortest if self.surface.lambda_short else math.inf
        rough = (rings.power > 0) & (rings.q <= cut * (1 + 1e-9))
        if np.count_nonzero(rough) < 2:
            with _naming(self.surface):
                raise UsageError(
                    "has waves of less than two lengths: lower lambda_short, or give a finer map"
                )
        return Tabulated(wavevectors=rings.q[rough], power=rings.power[rough])

    @property
    def shortest(self) -> float:
        """Shortest wave [m]: two of its points, or what is left where shorter ones were taken out."""
        raw = self.raw
        spacing = max(length / n for length, n in zip(raw.lengths, raw.heights.shape, strict=True))
        return max(2 * float(spacing), self.surface.lambda_short or 0.0)

    @property
    def variations(self) -> dict[str, Measured]:
        """The same map treated otherwise, by what is changed: what that moves hangs on a choice."""
        surface = self.surface
        changes: dict[str, dict[str, Any]] = {}
        if surface.edges != "free":
            changes["without the last octave of waves"] = {"lambda_short": 2 * self.shortest}
        if surface.spikes == "keep" and len(self.patch.clipped().history) > len(self.patch.history):
            changes["spikes clipped"] = {"spikes": "clip"}
        if surface.edges == "tukey":
            changes["taper twice as wide"] = {"margin": min(0.5, 2 * surface.margin)}
        elif surface.edges == "hann":
            changes["tukey taper"] = {"edges": "tukey", "margin": 0.25}
        if self.raw.missing and (self.raw.missing <= MOST_HOLES or surface.missing == "harmonic"):
            other = "nearest" if surface.missing == "harmonic" else "harmonic"
            changes[f"holes filled: {other}"] = {"missing": other}
        if surface.tilt == "plane":
            changes["quadratic taken out"] = {"tilt": "quadratic"}
        elif surface.tilt == "quadratic" or surface.edges not in (None, "periodic"):
            changes["plane taken out"] = {"tilt": "plane"}
        others = {name: surface.model_copy(update=change) for name, change in changes.items()}
        cases = {name: replace(self, surface=other) for name, other in others.items()}
        # Without a plane a period may be none.
        return {name: case for name, case in cases.items() if not case.faults}


def fault_lines(faults: Faults, table: Mapping[str, Any]) -> tuple[str, ...]:
    """Return a line for each fault, and the table of the scene that mends them all, to be pasted."""
    remedies = {key: json.dumps(remedy) for key, (_, remedy) in faults.items()}
    block = [f"{key} = {json.dumps(table[key])}" for key in ("path", "length", "unit") if table.get(key)]
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


@contextlib.contextmanager
def _naming(surface: FileSurface, key: str = "path") -> Iterator[None]:
    """Name the key in a complaint about a file or its treatment."""
    try:
        yield
    except UsageError as error:
        raise UsageError(f"surface.{key} = {str(getattr(surface, key))!r}: {error}") from None
