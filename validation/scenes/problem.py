"""What a scene asks for, made once: the surface, its spectrum, the solid, the load, the units of pressure."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from functools import cached_property, partial
from typing import Any

from fem_contact.solid import Solid
from fem_contact.surface import HeightField, RandomWaves, resolves
from validation.arrays import Grid, Pair
from validation.errors import UsageError
from validation.report.quantities import as_length
from validation.scenes import surfaces
from validation.scenes.tables import FileSurface, Load, RandomSurface, SolidSpec, SpectrumSurface, Surface
from validation.scenes.topography.measured import Measured


@dataclass(frozen=True, kw_only=True)
class ContactProblem:
    """One realisation of a surface, the solid under it and the load, each derived once and handed down.

    Of further surfaces of the same spectrum `realisation` is added to the seed; `inverted` presses -h for h,
    which halves much of the scatter between surfaces. `given` heights stand in place of those of a file. A
    random surface that is not `drawn`, for the theory alone, has the h'_rms of C(q). `variation` names what
    of the treatment of a measured surface is another than its scene says.

    What is derived stays with the value and does not travel with it: another process makes it anew.
    """

    surface: Surface
    solid: SolidSpec
    load: Load
    realisation: int = 0
    inverted: bool = False
    given: Measured | None = None
    drawn: bool = True
    variation: str = ""

    def __reduce__(self) -> Any:
        return partial(ContactProblem, **{f.name: getattr(self, f.name) for f in fields(self)}), ()

    def further(self, realisation: int) -> ContactProblem:
        """Return another realisation of the same spectrum; the same value for its own."""
        return self if realisation == self.realisation else replace(self, realisation=realisation)

    @property
    def _random(self) -> RandomSurface:
        assert isinstance(self.surface, RandomSurface)
        return self.surface

    @cached_property
    def _waves(self) -> RandomWaves:
        """The waves of a random surface, drawn once for all grids."""
        return surfaces.waves_of(self._random, self.realisation)

    @cached_property
    def measured(self) -> Measured | None:
        """The measured surface, read and hashed once; None for a random one."""
        if self.given is None and isinstance(self.surface, FileSurface):
            return Measured.read(self.surface, self.realisation)
        return self.given

    @cached_property
    def field(self) -> HeightField:
        """The surface on the smallest grid that resolves it; its moments are the surface's own.

        Where no surface is drawn, the moments of C(q) in place of it.
        """
        if self.measured is not None:
            return self._signed(self.measured.field)
        if not self.drawn:
            return surfaces.expected(self._random)  # type: ignore[return-value]
        surfaces.check_memory(self._random)
        return self.heights(self._random.resolving_grid)

    def heights(self, grid: Grid, shift: Pair = (0.0, 0.0)) -> HeightField:
        """Return the surface on a grid, moved by parts of a cell."""
        if self.measured is not None:
            return self.on_points(self.field, grid, shift)
        return self._signed(surfaces.sampled(self._waves, self._random, grid, shift))

    def aliases(self, grid: Grid) -> bool:
        """Whether a grid has fewer points than the map along a side: it cannot carry all waves of it."""
        return self.measured is not None and any(n < m for n, m in zip(grid, self.field.shape, strict=True))

    def on_points(self, field: HeightField, grid: Grid, shift: Pair) -> HeightField:
        """Return heights on the points of a map at those of a grid, moved by parts of its cell."""
        if shift == (0.0, 0.0) or not self.aliases(grid):
            field = field.resampled(grid)
            return field if shift == (0.0, 0.0) else field.shifted(shift)
        x, y = (part * m / n for part, m, n in zip(shift, field.shape, grid, strict=True))
        return field.shifted((x, y)).resampled(grid)

    def _signed(self, field: HeightField) -> HeightField:
        return HeightField(heights=-field.heights, lengths=field.lengths) if self.inverted else field

    @cached_property
    def spectrum(self) -> surfaces.AnySpectrum | None:
        """C(q) of the scene, estimated for a measured patch with tapered edges; None for one period."""
        period = isinstance(self.surface, FileSurface) and self.surface.edges not in ("tukey", "hann")
        return None if period else self.spectrum_shape

    @cached_property
    def spectrum_shape(self) -> surfaces.AnySpectrum:
        """C(q) whose scale may be another: for a measured surface an estimate, whatever its edges."""
        return surfaces.spectrum_of(self._random) if self.measured is None else self.measured.spectrum

    @cached_property
    def own_spectrum(self) -> surfaces.AnySpectrum:
        """C(q), scaled to the gradient of this surface; that of the scene where no surface is drawn."""
        shape = self.spectrum_shape
        if not self.drawn and self.measured is None:
            return shape
        return shape.scaled(float(self.field.rms_gradient**2 / shape.m2()))

    @cached_property
    def elastic(self) -> Solid:
        """The solid; one that stands for both where there are two."""
        return self.solid.elastic

    def under(self, load: Load) -> ContactProblem:
        """Return the same surface and solid under another load; what is made of the surface is shared."""
        return self.shared(replace(self, load=load))

    def shared(self, other: ContactProblem) -> ContactProblem:
        """Hand what is made of the surface to another value of the same surface, and return that."""
        made = {name: self.__dict__[name] for name in _OF_THE_SURFACE if name in self.__dict__}
        other.__dict__.update(made)
        return other

    @cached_property
    def contact_modulus(self) -> float:
        """E* [Pa]."""
        return self.elastic.contact_modulus

    @cached_property
    def pressure_scale(self) -> float:
        """E* h'_rms [Pa] with the spectral gradient of this surface: the unit of p*."""
        return self.contact_modulus * self.field.rms_gradient

    @cached_property
    def pressures(self) -> tuple[float, ...]:
        """p0 [Pa] of each load: as given, p* E* h'_rms, or force over nominal area.

        A UsageError where a distance is held: what load that takes, a solve says.
        """
        if self.load.held:
            (value,) = self.load.values
            raise UsageError(
                f"load.{self.load.key} = {as_length(value)}: what load that takes is known after a solve; "
                "give pressure, reduced_pressure or force here"
            )
        if self.load.pressure is not None:
            return self.load.values
        if self.load.force is not None:
            return (self.load.force / math.prod(self.lengths),)
        return tuple(value * self.contact_modulus * self.field.rms_gradient for value in self.load.values)

    @property
    def pressure(self) -> float:
        """p0 [Pa] of the one load."""
        (pressure,) = self.pressures
        return pressure

    @property
    def reduced_pressure(self) -> float:
        """p* = p0 / (E* h'_rms)."""
        return self.pressure / self.pressure_scale

    @property
    def lengths(self) -> Pair:
        """Periods (Lx, Ly) [m]."""
        return self.surface.length

    @cached_property
    def shortest(self) -> float:
        """lambda_short [m]; of a measured surface, see there."""
        return self._random.lambda_short if self.measured is None else self.measured.shortest

    @cached_property
    def variations(self) -> tuple[ContactProblem, ...]:
        """The same pressure on the same map, treated otherwise; none for a surface that was not measured."""
        if self.measured is None or self.load.held or self.variation:
            return ()
        load = Load(pressure=self.pressure)
        return tuple(
            replace(self, surface=case.surface, given=case, load=load, variation=name)
            for name, case in self.measured.variations.items()
        )

    @property
    def longest(self) -> float:
        """lambda_long [m], along the lay if there is one; of a measured surface, the longer period."""
        surface = self.surface
        long = max(surface.length) if isinstance(surface, FileSurface) else surface.lambda_long
        return long * surface.elongation

    @property
    def periods(self) -> float:
        """Long waves side by side on a period, along its side that has fewer; those of a lay run along x."""
        lx, ly = self.lengths
        return min(lx, ly * self.surface.elongation) / self.longest

    def spacing(self, grid: Grid) -> Pair:
        """Return dx and dy of a grid [m]."""
        return self.lengths[0] / grid[0], self.lengths[1] / grid[1]

    def points_per_wave(self, grid: Grid) -> float:
        """lambda_short / dx, on the coarser axis."""
        return self.shortest / max(self.spacing(grid))

    def resolved_by(self, grid: Grid) -> bool:
        """Whether lambda_short > 2 dx on both axes."""
        return resolves(grid, self.lengths, q_short=2 * math.pi / self.shortest)

    @cached_property
    def recipe(self) -> dict[str, Any]:
        """Everything that determines surface, solid and load, as JSON-ready data."""
        surface = self.surface.model_dump(mode="json")
        if self.measured is not None:
            surface |= {"path": self.measured.raw.digest, "tilt": surface["tilt"] or "keep"}
            if surface["edges"] != "free":  # solves of before counted from the zero of the file
                surface["heights"] = "over the mean plane"
            if surface["spikes"] == "clip":  # solves of before knew only what is far from all heights
                surface["clipped"] = "single points too"
            second = self.measured.raw.second_digest or None
            surface |= {"second_path": second, "more_paths": self.realisation}  # which of the maps it is
            del surface["treatment"]
            usual = {"spikes": "keep", "lambda_short": None, "second_path": None, "more_paths": 0}
            surface = {k: v for k, v in surface.items() if k not in usual or v != usual[k]}
        else:
            surface["seed"] = self._random.seed_of(self.realisation)
            if isinstance(self.surface, SpectrumSurface):
                surface["path"] = surfaces.read_spectrum(self.surface.path)[1]
            if surface.get("stretch") is None:  # what is not listed names no solve
                surface.pop("stretch", None)
        solid = self.solid.model_dump(mode="json", exclude_none=True)
        inverted = {"inverted": True} if self.inverted else {}
        return {"surface": surface, "solid": solid, "load": self.load.recipe, **inverted}


#: What is made of the surface alone, whatever the solid and the load.
_OF_THE_SURFACE = ("_waves", "measured", "field", "spectrum")


def realise(scene: Any, *, like: ContactProblem | None = None, surveyed: bool = False) -> ContactProblem:
    """Return what a scene asks for, to be made once and handed down.

    What another scene made of the same surface, given as `like`, is not made again. A surface that is only
    surveyed is told by its C(q) where it has too many points to be made.
    """
    drawn = bool(scene.methods.solvers)
    if surveyed and not isinstance(scene.surface, FileSurface):
        drawn = drawn and math.prod(scene.surface.resolving_grid) <= surfaces.SURVEYED_POINTS
    made = ContactProblem(surface=scene.surface, solid=scene.solid, load=scene.load, drawn=drawn)
    if like is None or replace(like, solid=made.solid, load=made.load) != made:
        return made
    return like.shared(made)
