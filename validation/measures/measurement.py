"""The unit of work of the studies: one surface, pressed along a path of loads on several grids, reduced to numbers."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from fem_contact.area import EDGE_CONSTANTS, TRAITS, ContactAreas, contact_areas, subgrid_shifts
from fem_contact.contact import ContactResult
from fem_contact.extrapolation import Limit, located_limit, perimeter_limit
from fem_contact.patches import find_patches
from fem_contact.stress import density_at_zero, elastic_energy
from fem_contact.surface import HeightField
from validation.arrays import Grid
from validation.effects.base import Slots
from validation.measures.common import LEAST_POINTS_PER_WAVE, SHIFTS, named, reduced_load
from validation.methods import find_solver
from validation.methods.base import Job
from validation.scenes.realised import Realised
from validation.scenes.scene import EffectSpec, FileSurface, SelfAffineSurface
from validation.scenes.surfaces import spectrum_of
from validation.solves.cost import dearer_by
from validation.solves.solve import LOCATED_EDGES, NumbersSolve, Prediction

if TYPE_CHECKING:
    import xarray as xr

__all__ = [
    "TOLERANCES_LEFT",
    "Grid",
    "Measurement",
    "area_limits",
    "areas_of",
    "grid_for",
    "grid_tolerance",
    "has_square_cells",
    "limit_over",
    "without_waves_beyond",
]

#: How far the sides of a cell may differ for edges to be located inside it.
_SQUARE = 0.05

#: What is read off every solve: name, unit, meaning.
QUANTITIES = {
    "pixel": ("1", "A/A0, contact points counted"),
    "perimeter": ("1", "A/A0, perimeter-corrected"),
    "subcell": ("1", "A/A0, edge located inside the cells"),
    "edge_fraction": ("1", "edges between contact and non-contact per grid point"),
    "alignment": ("1", "0 for a contour of all directions, 1 for a line"),
    "anisotropy": ("1", "1 less Peklenik's number of the heights"),
    "unresolved": ("1", "share of the curvature of the heights in waves of less than four points"),
    "wavenumber": ("1", "rms wavenumber of the curvature of the heights, times the spacing"),
    "density_at_zero": ("1", "P(0+) E* h'_rms from pressures below a threshold ~ sqrt(dx)"),
    "patches": ("1", "number of contact patches"),
    "patch_size": ("m^2", "mean patch size, sum A_i^2 / sum A_i"),
    "cells_per_patch": ("1", "cells of the patch in which the median point of the contact area lies"),
    "mean_gap": ("m", "mean gap"),
    "energy": ("Pa m", "elastic energy per nominal area, mean of p u / 2"),
    "residual": ("1", "largest contact residual"),
    "seconds": ("s", "processor time of the solve, on one thread"),
    "peak_bytes": ("byte", "largest memory of the arrays of the solve"),
}


def grid_for(realised: Realised, points_per_wave: float) -> Grid:
    """Smallest even grid with at least that many points on lambda_short, along both axes."""
    nx, ny = (
        2 * int(np.ceil(points_per_wave * length / realised.shortest / 2 - 1e-9))
        for length in realised.lengths
    )
    return nx, ny


#: Tolerance whose effect on the located area is below a hundredth of what its grids leave, at 8 points per
#: shortest wave; that falls with the cube of the spacing (docs/bem.md).
_TOLERANCE, _AT_POINTS, _LEAST_TOLERANCE = 1e-5, 8, 1e-8

#: The located area of a solve is off by so many tolerances, relative, but for rare ones (docs/bem.md).
TOLERANCES_LEFT = 7.0


def grid_tolerance(realised: Realised, grids: Sequence[Grid]) -> float:
    """Tolerance that areas on such grids deserve: below it, digits are computed that the grids do not have."""
    points = max(
        n * realised.shortest / length
        for grid in grids
        for n, length in zip(grid, realised.lengths, strict=True)
    )
    return max(_TOLERANCE * min(1.0, (_AT_POINTS / points) ** 3), _LEAST_TOLERANCE)


def has_square_cells(realised: Realised, grid: Grid) -> bool:
    """Whether the cells of a grid are square within 5 %, so that edges can be located inside them."""
    dx, dy = (length / n for length, n in zip(realised.lengths, grid, strict=True))
    return abs(dx / dy - 1) <= _SQUARE


@dataclass(frozen=True, kw_only=True)
class Measurement(NumbersSolve):
    """One surface, at ascending loads, on nested grids, each on `shifts`^2 sub-grid shifts.

    Attributes
    ----------
    realised : Realised
        Surface, solid and load.
    reduced_pressures : tuple of float
        A path of ascending loads instead of the one of `realised`: p* = p0 / (E* h'_rms), with the realised gradient
        of the whole, untruncated surface.
    effects : tuple
        Of a scene; then each load is pressed by itself.
    truncation : float or None
        Drop waves beyond this wavevector [1/m]: roughness up to a magnification.
    grids : tuple of (int, int)
    shifts : int
        Sub-grid shifts along each axis.
    tolerance : float
    """

    realised: Realised
    reduced_pressures: tuple[float, ...] = ()
    effects: tuple[EffectSpec, ...] = ()
    truncation: float | None = None
    grids: tuple[Grid, ...]
    shifts: int = SHIFTS
    tolerance: float = 1e-8

    @property
    def loads(self) -> tuple[float, ...]:
        """All p*, ascending."""
        return self.reduced_pressures or (reduced_load(self.realised),)

    @property
    def recipe(self) -> dict[str, Any]:
        """Everything that determines the numbers, as JSON-ready data."""
        made = {name: value for name, value in self.realised.recipe.items() if name != "load"}
        if self.effects:
            made["effects"] = [effect.model_dump(mode="json", exclude_none=True) for effect in self.effects]
        return made | {
            "truncation": self.truncation,
            "reduced_pressures": list(self.loads),
            "grids": [list(grid) for grid in self.grids],
            "shifts": self.shifts,
            "tolerance": self.tolerance,
            # What is read off belongs to the result: a stored one that lacks a number is another one.
            "quantities": sorted([*self.quantities, "cells", LOCATED_EDGES]),
        }

    @property
    def quantities(self) -> Mapping[str, tuple[str, str]]:
        """What is read off every solve: name, unit, meaning."""
        return QUANTITIES

    @property
    def prefix(self) -> str:
        """Readable start of the name on disk."""
        return f"measure-{max(self.grids)[0]}x{max(self.grids)[1]}"

    def describe(self) -> str:
        """Return a few words for a progress bar."""
        own, finest = self.realised, max(self.grids)
        kind = f"H = {own.surface.hurst:g}, " if isinstance(own.surface, SelfAffineSurface) else ""
        sign = "-h" if own.inverted else "h"
        kind += f"nu = {own.solid.poisson:g}, "
        return f"{kind}surface {own.realisation + 1} ({sign}), to {finest[0]}x{finest[1]}"

    def predict(self, *, pair_seconds: float = 0.5e-3) -> Prediction:
        """Predict seconds, memory and unknowns from the sizes of the grids."""
        points = [nx * ny for nx, ny in self.grids]
        solves = len(self.loads) * self.shifts**2
        return Prediction(
            seconds=dearer_by(self.effects) * solves * sum(2e-3 + 8e-7 * n for n in points),
            peak_bytes=120 * max(points),
            unknowns=max(points),
        )

    def heights(self, grid: Grid, shift: tuple[float, float] = (0.0, 0.0)) -> HeightField:
        """Return the heights that are pressed on one grid."""
        if self.truncation is None:
            return self.realised.heights(grid, shift)
        if isinstance(self.realised.surface, FileSurface):
            whole = without_waves_beyond(self.realised.field, self.truncation)
            return whole.resampled(grid).shifted(shift)
        field = self._truncated(grid, self.truncation).shifted(shift)
        return HeightField(heights=-field.heights, lengths=field.lengths) if self.realised.inverted else field

    def _truncated(self, grid: Grid, last: float) -> HeightField:
        from fem_contact.surface import random_surface

        surface = self.realised.surface
        assert not isinstance(surface, FileSurface)
        spectrum = spectrum_of(surface)
        return random_surface(
            spectrum,
            q_short=min(last, spectrum.q_short),
            lengths=surface.length,
            shape=grid,
            seed=surface.seed_of(self.realised.realisation),
            amplitudes=surface.amplitudes,
        )

    def measure(self) -> xr.Dataset:
        """Solve everything and keep the numbers; dimensions (grid, shift, load)."""
        offsets = subgrid_shifts(self.shifts)
        shape = (len(self.grids), len(offsets), len(self.loads))
        values = {name: np.empty(shape) for name in self.quantities}
        profiles: dict[str, np.ndarray] = {}
        for (i, grid), (j, shift) in itertools.product(enumerate(self.grids), enumerate(offsets)):
            for k, result in enumerate(self._path(grid, shift)):
                for name, value in self.read_off(result, located=self._located(grid)).items():
                    values[name][i, j, k] = value
                for name, profile in self.profiles(result).items():
                    profiles.setdefault(name, np.zeros((shape[0], shape[2], profile.size)))[i, k] += profile
        return self._dataset(values, {name: sums / len(offsets) for name, sums in profiles.items()})

    def _dataset(self, values: dict[str, np.ndarray], profiles: dict[str, np.ndarray]) -> xr.Dataset:
        import xarray as xr

        data: dict[str, Any] = {
            name: named(("grid", "shift", "load"), values[name], words, unit=unit)
            for name, (unit, words) in self.quantities.items()
        }
        for name, profile in profiles.items():
            data[f"{name}_profile"] = (("grid", "load", f"{name}_bin"), profile)
        own = self.realised
        per_wave = [own.points_per_wave(grid) for grid in self.grids]
        return xr.Dataset(
            data,
            coords={
                "points": ("grid", [nx for nx, _ in self.grids]),
                "cells": ("grid", [nx * ny for nx, ny in self.grids]),
                "points_per_wave": named("grid", per_wave, "lambda_short / dx"),
                "reduced_pressure": named("load", list(self.loads), "p0 / (E* h'_rms)"),
            },
            attrs={
                "rms_height": own.field.rms_height,
                "rms_gradient": own.field.rms_gradient,
                "nayak": own.field.nayak,
                "contact_modulus": own.contact_modulus,
                "full_contact_energy": own.field.spectral_sum(lambda q: own.contact_modulus / 4 * q),
            },
        )

    def read_off(self, result: ContactResult, *, located: bool) -> dict[str, float]:
        """Return every one of `quantities` of one solve; the area inside the cells if it can be `located`."""
        return _read_off(result, located=located)

    def profiles(self, result: ContactResult) -> dict[str, np.ndarray]:
        """Return distributions to keep of one solve, by name; they are averaged over the shifts. None here."""
        return {}

    def _located(self, grid: Grid) -> bool:
        """Whether edges can be located inside the cells: on the bare half-space, on square ones."""
        return not self.effects and has_square_cells(self.realised, grid)

    def _path(self, grid: Grid, shift: tuple[float, float]) -> Iterator[ContactResult]:
        """Solve the loads of one grid in order, each from the one before; only one result is held at a time."""
        from fem_contact import bem
        from fem_contact.response import HalfSpace

        response, field = HalfSpace(solid=self.realised.elastic), self.heights(grid, shift)
        start = None
        for reduced in self.loads:
            if self.effects:
                yield self._with_effects(field, reduced * self.realised.pressure_scale)
                continue
            solved = bem.solve(
                field,
                response,
                mean_pressure=reduced * self.realised.pressure_scale,
                start=start,
                tolerance=self.tolerance,
                threads=1,
            )
            yield solved.checked()
            start = solved.pressure

    def _with_effects(self, field: HeightField, pressure: float) -> ContactResult:
        """Press as a scene with these effects does."""
        job = Job(
            field=field,
            load={"mean_pressure": pressure},
            slots=Slots.filled(self.realised.elastic, self.effects),
            settings={"tolerance": self.tolerance},
            threads=1,
        )
        return find_solver("bem").solve(job).contact.checked()


def without_waves_beyond(field: HeightField, last: float) -> HeightField:
    """Return a surface without its waves shorter than 2 pi / `last`, on the same points."""
    nx, ny = field.shape
    dx, dy = field.spacing
    q = np.hypot(2 * np.pi * np.fft.fftfreq(nx, dx)[:, None], 2 * np.pi * np.fft.rfftfreq(ny, dy)[None, :])
    waves = np.where(q <= last * (1 + 1e-9), np.fft.rfft2(field.heights), 0)
    return HeightField(heights=np.fft.irfft2(waves, s=field.shape), lengths=field.lengths)


def _read_off(result: ContactResult, *, located: bool) -> dict[str, float]:
    areas = contact_areas(result, subcell=located)
    patches = find_patches(result.in_contact, result.spacing)
    sizes = np.sort(patches.areas)[::-1]
    cell = result.spacing[0] * result.spacing[1]
    half = np.searchsorted(np.cumsum(sizes), sizes.sum() / 2)
    return {
        "pixel": areas.pixel,
        "perimeter": areas.perimeter,
        "subcell": np.nan if areas.subcell is None else areas.subcell,
        "edge_fraction": areas.edge_fraction,
        **{name: getattr(areas, name) for name in TRAITS},
        "density_at_zero": density_at_zero(result).reduced,
        "patches": patches.count,
        "patch_size": patches.mean_size,
        "cells_per_patch": float(sizes[half] / cell) if sizes.size else 0.0,
        "mean_gap": float(result.gap.mean()),
        "energy": elastic_energy(result),
        "residual": result.residuals.worst,
        "seconds": result.cost.cpu_seconds,
        "peak_bytes": result.cost.peak_bytes,
    }


def limit_over(areas: Sequence[ContactAreas]) -> Limit:
    """Return the limit of the located area where there is one, else of the corrected."""
    located = all(area.subcell is not None for area in areas)
    return located_limit(areas) if located else perimeter_limit(areas)


def areas_of(dataset: xr.Dataset, load: int, *, least_points_per_wave: float = 0.0) -> list[ContactAreas]:
    """Return the areas of a measurement at one load, one for each grid and shift, as `located_limit` takes them.

    Parameters
    ----------
    dataset : xarray.Dataset
        From `Measurement.measure`.
    load : int
        Which of its loads.
    least_points_per_wave : float
        Coarser grids are left out.
    """
    keep = dataset.points_per_wave.values >= least_points_per_wave * (1 - 1e-9)
    names = ("pixel", "perimeter", "edge_fraction", "subcell", *(name for name in TRAITS if name in dataset))
    numbers = {name: dataset[name].values[..., load].astype(float) for name in names}
    points, cells = (dataset[name].values.tolist() for name in ("points", "cells"))
    areas = []
    for i, j in itertools.product(np.flatnonzero(keep), range(dataset.sizes["shift"])):
        found: dict[str, Any] = {name: float(values[i, j]) for name, values in numbers.items()}
        areas.append(
            ContactAreas(
                edge_length=np.nan,
                edge_constant=EDGE_CONSTANTS["bem"],
                spacing=(1 / int(points[i]), int(points[i]) / int(cells[i])),
                cells=int(cells[i]),
                **(found | {"subcell": None if np.isnan(found["subcell"]) else found["subcell"]}),
            )
        )
    return areas


def area_limits(dataset: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """Return the limit of A/A0 over the grids of one measurement and its standard error, for each load.

    It is that of the areas located inside the cells (`fem_contact.extrapolation`), or where they cannot be located of
    those corrected at their edge; grids of less than
    `LEAST_POINTS_PER_WAVE` are left out. Both are NaN where the contact is too small to carry the law; the report
    of a study says so.
    """
    limits = [
        limit_over(areas_of(dataset, k, least_points_per_wave=LEAST_POINTS_PER_WAVE))
        for k in range(dataset.sizes["load"])
    ]
    return np.array([limit.value for limit in limits]), np.array([limit.uncertainty for limit in limits])
