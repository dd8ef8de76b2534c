"""The unit of work of the studies: one surface, pressed along a path of loads on several grids, reduced to numbers."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from fem_contact.area import EDGE_CONSTANTS, ContactAreas, contact_areas
from fem_contact.contact import ContactResult
from fem_contact.extrapolation import located_limit
from fem_contact.patches import find_patches
from fem_contact.solid import Solid
from fem_contact.stress import density_at_zero
from fem_contact.surface import HeightField
from validation.measures.common import LEAST_POINTS_PER_WAVE
from validation.scenes.scene import SelfAffineSurface, SolidSpec
from validation.scenes.surfaces import height_field, reference_field, spectrum_of
from validation.solves.solve import NumbersSolve, Prediction

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Measurement", "area_limits", "areas_of", "grid_for"]

Grid = tuple[int, int]

#: What is read off every solve: name, unit, meaning.
QUANTITIES = {
    "pixel": ("1", "A/A0, contact points counted"),
    "perimeter": ("1", "A/A0, perimeter-corrected"),
    "subcell": ("1", "A/A0, edge located inside the cells"),
    "edge_fraction": ("1", "edges between contact and non-contact per grid point"),
    "density_at_zero": ("1", "P(0+) E* h'_rms from pressures below a threshold ~ sqrt(dx)"),
    "patches": ("1", "number of contact patches"),
    "patch_size": ("m^2", "mean patch size, sum A_i^2 / sum A_i"),
    "cells_per_patch": ("1", "cells of the patch in which the median point of the contact area lies"),
    "mean_gap": ("m", "mean gap"),
    "energy": ("Pa m", "elastic energy per nominal area, mean of p (u - u_mean) / 2"),
    "residual": ("1", "largest contact residual"),
    "seconds": ("s", "processor time of the solve, on one thread"),
    "peak_bytes": ("byte", "largest memory of the arrays of the solve"),
}


def grid_for(surface: SelfAffineSurface, points_per_wave: float) -> Grid:
    """Smallest even grid with at least that many points on lambda_short, along both axes."""
    nx, ny = (
        2 * int(np.ceil(points_per_wave * length / surface.lambda_short / 2 - 1e-9))
        for length in surface.length
    )
    return nx, ny


@dataclass(frozen=True, kw_only=True)
class Measurement(NumbersSolve):
    """One realisation, at ascending reduced pressures, on nested grids, each on `shifts`^2 sub-grid shifts.

    Attributes
    ----------
    surface : SelfAffineSurface
    realisation : int
        Added to the seed of the surface.
    inverted : bool
        Press -h instead of h: the other half of an anti-correlated pair.
    truncation : float or None
        Drop waves beyond this wavevector [1/m]: roughness up to a magnification.
    solid : SolidSpec
    reduced_pressures : tuple of float
        p* = p0 / (E* h'_rms), with the realised gradient of the whole, untruncated surface.
    grids : tuple of (int, int)
    shifts : int
        Sub-grid shifts along each axis.
    tolerance : float
    """

    surface: SelfAffineSurface
    realisation: int = 0
    inverted: bool = False
    truncation: float | None = None
    solid: SolidSpec
    reduced_pressures: tuple[float, ...]
    grids: tuple[Grid, ...]
    shifts: int = 2
    tolerance: float = 1e-8

    @property
    def recipe(self) -> dict[str, Any]:
        """Everything that determines the numbers, as JSON-ready data."""
        surface = self.surface.model_dump(mode="json")
        surface["seed"] = self.surface.seed_of(self.realisation)
        return {
            "surface": surface,
            "inverted": self.inverted,
            "truncation": self.truncation,
            "solid": self.solid.model_dump(mode="json"),
            "reduced_pressures": list(self.reduced_pressures),
            "grids": [list(grid) for grid in self.grids],
            "shifts": self.shifts,
            "tolerance": self.tolerance,
            # What is read off belongs to the result: a stored one that lacks a number is another one.
            "quantities": sorted(QUANTITIES),
        }

    @property
    def prefix(self) -> str:
        """Readable start of the name on disk."""
        return f"measure-{max(self.grids)[0]}x{max(self.grids)[1]}"

    def describe(self) -> str:
        """Return a few words for a progress bar."""
        sign = "-h" if self.inverted else "h"
        finest = max(self.grids)
        return (
            f"H = {self.surface.hurst:g}, surface {self.realisation + 1} ({sign}), to {finest[0]}x{finest[1]}"
        )

    def predict(self, *, pair_seconds: float = 0.5e-3) -> Prediction:
        """Predict seconds, memory and unknowns from the sizes of the grids."""
        points = [nx * ny for nx, ny in self.grids]
        solves = len(self.reduced_pressures) * self.shifts**2
        return Prediction(
            seconds=solves * sum(2e-3 + 8e-7 * n for n in points),
            peak_bytes=120 * max(points),
            unknowns=max(points),
        )

    def field(self, grid: Grid, shift: tuple[float, float] = (0.0, 0.0)) -> HeightField:
        """Return the heights that are pressed on one grid."""
        if self.truncation is None:
            field = height_field(self.surface, grid, realisation=self.realisation, shift=shift)
        else:
            field = self._truncated(grid).shifted(shift)
        return HeightField(heights=-field.heights, lengths=field.lengths) if self.inverted else field

    def _truncated(self, grid: Grid) -> HeightField:
        from fem_contact.surface import random_surface

        assert self.truncation is not None
        spectrum = spectrum_of(self.surface)
        return random_surface(
            spectrum,
            q_short=min(self.truncation, spectrum.q_short),
            lengths=self.surface.length,
            shape=grid,
            seed=self.surface.seed_of(self.realisation),
            amplitudes=self.surface.amplitudes,
        )

    def measure(self) -> xr.Dataset:
        """Solve everything and keep the numbers; dimensions (grid, shift, load)."""
        import xarray as xr

        steps = [k / self.shifts for k in range(self.shifts)]
        offsets = list(itertools.product(steps, steps))
        shape = (len(self.grids), len(offsets), len(self.reduced_pressures))
        values = {name: np.empty(shape) for name in QUANTITIES}
        profiles: dict[str, np.ndarray] = {}
        for (i, grid), (j, shift) in itertools.product(enumerate(self.grids), enumerate(offsets)):
            for k, result in enumerate(self._path(grid, shift)):
                for name, value in _read_off(result).items():
                    values[name][i, j, k] = value
                for name, profile in self.profiles(result).items():
                    profiles.setdefault(name, np.zeros((shape[0], shape[2], profile.size)))[i, k] += profile
        whole = reference_field(self.surface, realisation=self.realisation)
        data: dict[str, Any] = {
            name: (("grid", "shift", "load"), values[name], {"units": unit, "long_name": words})
            for name, (unit, words) in QUANTITIES.items()
        }
        for name, profile in profiles.items():
            data[f"{name}_profile"] = (("grid", "load", f"{name}_bin"), profile / len(offsets))
        wave = self.surface.lambda_short
        per_wave = [
            wave / max(x / n for x, n in zip(self.surface.length, g, strict=True)) for g in self.grids
        ]
        return xr.Dataset(
            data,
            coords={
                "points": ("grid", [nx for nx, _ in self.grids]),
                "points_per_wave": ("grid", per_wave, {"long_name": "lambda_short / dx"}),
                "reduced_pressure": ("load", list(self.reduced_pressures), {"long_name": "p0 / (E* h'_rms)"}),
            },
            attrs={
                "rms_height": whole.rms_height,
                "rms_gradient": whole.rms_gradient,
                "nayak": whole.nayak,
                "contact_modulus": self._modulus,
                "full_contact_energy": _full_contact_energy(whole, self._modulus),
            },
        )

    def profiles(self, result: ContactResult) -> dict[str, np.ndarray]:
        """Return distributions to keep of one solve, by name; they are averaged over the shifts. None here."""
        return {}

    @property
    def _modulus(self) -> float:
        return Solid(**self.solid.model_dump()).contact_modulus

    def _path(self, grid: Grid, shift: tuple[float, float]) -> Iterator[ContactResult]:
        """Solve the loads of one grid in order, each from the one before; only one result is held at a time."""
        from fem_contact import bem
        from fem_contact.response import HalfSpace

        response = HalfSpace(solid=Solid(**self.solid.model_dump()))
        whole = reference_field(self.surface, realisation=self.realisation)
        scale = response.contact_modulus * whole.rms_gradient
        field = self.field(grid, shift)
        start = None
        for reduced in self.reduced_pressures:
            solved = bem.solve(
                field,
                response,
                mean_pressure=reduced * scale,
                start=start,
                tolerance=self.tolerance,
                threads=1,
            )
            yield solved.checked()
            start = solved.pressure


def _full_contact_energy(field: HeightField, contact_modulus: float) -> float:
    """Elastic energy per area of complete contact, (E*/4) sum |q| |h(q)|^2 [Pa m]."""
    nx, ny = field.shape
    spectrum = np.fft.fft2(field.heights) / (nx * ny)
    qx, qy = (2 * np.pi * np.fft.fftfreq(n, d) for n, d in zip(field.shape, field.spacing, strict=True))
    q = np.hypot(qx[:, None], qy[None, :])
    return float(contact_modulus / 4 * np.sum(q * np.abs(spectrum) ** 2))


def _read_off(result: ContactResult) -> dict[str, float]:
    areas = contact_areas(result, edge_constant=EDGE_CONSTANTS["bem"], subcell=True)
    patches = find_patches(result.in_contact, result.spacing)
    sizes = np.sort(patches.areas)[::-1]
    cell = result.spacing[0] * result.spacing[1]
    half = np.searchsorted(np.cumsum(sizes), sizes.sum() / 2)
    displacement = result.displacement - result.displacement.mean()
    return {
        "pixel": areas.pixel,
        "perimeter": areas.perimeter,
        "subcell": np.nan if areas.subcell is None else areas.subcell,
        "edge_fraction": areas.edge_fraction,
        "density_at_zero": density_at_zero(result).reduced,
        "patches": patches.count,
        "patch_size": patches.mean_size,
        "cells_per_patch": float(sizes[half] / cell) if sizes.size else 0.0,
        "mean_gap": float(result.gap.mean()),
        "energy": float(0.5 * np.mean(result.pressure * displacement)),
        "residual": result.residuals.worst,
        "seconds": result.cost.cpu_seconds,
        "peak_bytes": result.cost.peak_bytes,
    }


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
    return [
        ContactAreas(
            pixel=float(dataset.pixel[i, j, load]),
            perimeter=float(dataset.perimeter[i, j, load]),
            edge_length=np.nan,
            edge_fraction=float(dataset.edge_fraction[i, j, load]),
            edge_constant=EDGE_CONSTANTS["bem"],
            spacing=(1 / int(dataset.points[i]), 1 / int(dataset.points[i])),
            subcell=float(dataset.subcell[i, j, load]),
            cells=int(dataset.points[i]) ** 2,
        )
        for i, j in itertools.product(np.flatnonzero(keep), range(dataset.sizes["shift"]))
    ]


def area_limits(dataset: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """Return the limit of A/A0 over the grids of one measurement and its standard error, for each load.

    It is that of the areas located inside the cells (`fem_contact.extrapolation`); grids of less than
    `LEAST_POINTS_PER_WAVE` are left out. Both are NaN where the contact is too small to carry the law; the report
    of a study says so.
    """
    limits = [
        located_limit(areas_of(dataset, k, least_points_per_wave=LEAST_POINTS_PER_WAVE))
        for k in range(dataset.sizes["load"])
    ]
    return np.array([limit.value for limit in limits]), np.array([limit.uncertainty for limit in limits])
