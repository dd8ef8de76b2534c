"""The single solves a scene asks for: what determines each, how it is named on disk, and how it is done."""

from __future__ import annotations

import hashlib
import itertools
import json
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from fem_contact.contact import ContactResult
from fem_contact.solid import Solid
from fem_contact.surface import HeightField
from validation.effects.tables import EffectSpec
from validation.scenes.scene import FileSurface, Load, Scene, SelfAffineSurface, SolidSpec
from validation.scenes.surfaces import Expected, file_digest, height_field, reference_field

if TYPE_CHECKING:
    import xarray as xr

__all__ = [
    "AnyJob",
    "Job",
    "NumbersJob",
    "Prediction",
    "code_path",
    "execute",
    "jobs_of",
    "nominal_pressure",
    "warm_up",
]

#: Raised when a change of the code changes results, so that stored ones are not mistaken for new ones.
RESULTS_VERSION = 1


@dataclass(frozen=True, kw_only=True)
class Job:
    """One solve: a method, one realisation of the surface on one grid, a solid and a load.

    Attributes
    ----------
    method : str
        "bem" or "fem".
    grid : tuple of int
    realisation : int
        Counts further surfaces of the same spectrum from 0, the scene's own.
    shift : tuple of float
        Sub-grid shift of the surface, in parts of a cell.
    surface, solid, load
        Tables of the scene.
    settings : tuple of (str, value)
        What else the method was told, such as its tolerance; only what was said.
    mirrored : bool
        Press -h instead of h: hills become valleys, which halves much of the scatter between surfaces.
    """

    method: str
    grid: tuple[int, int]
    realisation: int = 0
    shift: tuple[float, float] = (0.0, 0.0)
    surface: SelfAffineSurface | FileSurface
    solid: SolidSpec
    load: Load
    settings: tuple[tuple[str, float | str], ...] = ()
    effects: tuple[EffectSpec, ...] = ()
    mirrored: bool = False

    @cached_property
    def recipe(self) -> dict[str, Any]:
        """Everything that determines the result, as JSON-ready data, and nothing else."""
        surface = self.surface.model_dump(mode="json")
        if isinstance(self.surface, FileSurface):
            surface["path"] = file_digest(self.surface)
        else:
            surface["seed"] = self.surface.seed + self.realisation
        recipe = {
            "results_version": RESULTS_VERSION,
            "method": self.method,
            "grid": list(self.grid),
            "shift": list(self.shift),
            "surface": surface,
            "solid": self.solid.model_dump(mode="json"),
            "load": self.load.model_dump(mode="json"),
            "settings": dict(self.settings),
        }
        # Only where they are said, so that what was stored without them keeps its name.
        if self.effects:
            recipe["effects"] = [effect.model_dump(mode="json") for effect in self.effects]
        return recipe | {"mirrored": True} if self.mirrored else recipe

    @cached_property
    def key(self) -> str:
        """Name on disk: readable, then the hash of the recipe."""
        text = json.dumps(self.recipe, sort_keys=True)
        digest = hashlib.sha256(text.encode()).hexdigest()[:16]
        return f"{self.method}-{self.grid[0]}x{self.grid[1]}-{digest}"

    def describe(self) -> str:
        """Return a few words for a progress bar."""
        text = f"{self.method.upper()} {self.grid[0]}x{self.grid[1]}"
        if self.realisation:
            text += f", surface {self.realisation + 1}"
        if self.mirrored:
            text += ", mirrored"
        if self.shift != (0.0, 0.0):
            text += f", shift ({self.shift[0]:g}, {self.shift[1]:g})"
        return text

    def height_field(self) -> HeightField:
        """Return the heights this job presses."""
        field = height_field(self.surface, self.grid, realisation=self.realisation, shift=self.shift)
        return HeightField(heights=-field.heights, lengths=field.lengths) if self.mirrored else field


@dataclass(frozen=True, kw_only=True)
class Prediction:
    """Predicted cost of a solve: seconds, peak bytes, unknowns."""

    seconds: float
    peak_bytes: int
    unknowns: int


class NumbersJob(ABC):
    """A job of a study whose result is a small dataset of numbers rather than fields.

    Subclasses are frozen dataclasses of plain data, so that worker processes can be sent them.
    """

    @property
    @abstractmethod
    def recipe(self) -> dict[str, Any]:
        """Everything that determines the numbers, as JSON-ready data, and nothing else."""

    @property
    @abstractmethod
    def prefix(self) -> str:
        """Readable start of the name on disk."""

    @property
    def key(self) -> str:
        """Name on disk: readable, then the hash of the recipe."""
        recipe = {"results_version": RESULTS_VERSION, "kind": type(self).__name__, **self.recipe}
        digest = hashlib.sha256(json.dumps(recipe, sort_keys=True).encode()).hexdigest()[:16]
        return f"{self.prefix}-{digest}"

    @abstractmethod
    def describe(self) -> str:
        """Return a few words for a progress bar."""

    @abstractmethod
    def predict(self) -> Prediction:
        """Predict what the job takes."""

    @abstractmethod
    def measure(self) -> xr.Dataset:
        """Solve, and keep the numbers."""


#: What a store keeps and a bench runs.
AnyJob: TypeAlias = "Job | NumbersJob"


def jobs_of(scene: Scene) -> tuple[Job, ...]:
    """List the solves of a scene, coarse grids first; one that is asked for twice is listed once."""
    common: dict[str, Any] = {
        "surface": scene.surface,
        "solid": scene.solid,
        "load": scene.load,
        "effects": scene.effects,
    }
    jobs: list[Job] = []
    bem, fem = scene.methods.bem, scene.methods.fem
    if bem is not None:
        settings: tuple[tuple[str, float | str], ...] = (("tolerance", bem.tolerance),)
        steps = [k / bem.shifts for k in range(bem.shifts)]
        for grid, shift in itertools.product(sorted(bem.grids), itertools.product(steps, steps)):
            jobs.append(Job(method="bem", grid=grid, shift=shift, settings=settings, **common))
        if scene.ensemble is not None:
            for k, grid in itertools.product(
                range(scene.ensemble.realisations), sorted(scene.ensemble.grids)
            ):
                jobs.append(Job(method="bem", grid=grid, realisation=k, settings=settings, **common))
    if fem is not None:
        said = {"method": fem.method, "tolerance": fem.tolerance, "growth": fem.growth, "depth": fem.depth}
        settings = tuple((name, value) for name, value in said.items() if value is not None)
        jobs.extend(Job(method="fem", grid=grid, settings=settings, **common) for grid in sorted(fem.grids))
    return tuple({job.key: job for job in jobs}.values())


def nominal_pressure(load: Load, solid: SolidSpec, field: HeightField | Expected) -> float:
    """p0 [Pa]: as given, or p* E* h'_rms with the spectral gradient of the realised surface."""
    if load.pressure is not None:
        return load.pressure
    assert load.reduced_pressure is not None
    modulus = Solid(**solid.model_dump()).contact_modulus
    return load.reduced_pressure * modulus * field.rms_gradient


@dataclass(frozen=True, kw_only=True)
class Solved:
    """Result of one job, and the block it came from where there is one to export."""

    contact: ContactResult
    block: Any = None


def execute(job: Job, *, threads: int | None = None) -> Solved:
    """Do one solve. Does not touch the disk.

    Parameters
    ----------
    job : Job
    threads : int, optional
        Threads of the transforms; all available processors if not given.
    """
    solid = Solid(**job.solid.model_dump())
    settings: dict[str, Any] = dict(job.settings)
    field = job.height_field()
    pressure = nominal_pressure(
        job.load, job.solid, reference_field(job.surface, realisation=job.realisation)
    )
    if job.method == "bem" and job.effects:
        from validation.methods.slots import solve_bem

        return Solved(
            contact=solve_bem(
                field, solid, effects=job.effects, mean_pressure=pressure, threads=threads, **settings
            )
        )
    if job.method == "bem":
        from fem_contact import bem
        from fem_contact.response import HalfSpace

        half_space = HalfSpace(solid=solid)
        return Solved(
            contact=bem.solve(field, half_space, mean_pressure=pressure, threads=threads, **settings)
        )
    from fem_contact import block

    if job.effects:
        from validation.methods.slots import block_arguments

        settings |= block_arguments(solid, job.effects)
    solution = block.solve(field, solid, mean_pressure=pressure, **({"method": "full"} | settings))
    return Solved(contact=solution.contact, block=solution)


def code_path(job: AnyJob) -> tuple[str, ...]:
    """Name what decides which compiled passes a job runs through: method, its variant, kinds of effects."""
    if isinstance(job, NumbersJob):
        return ("bem", "")
    variant = str(dict(job.settings).get("method", "full")) if job.method == "fem" else ""
    return (job.method, variant, *sorted(effect.kind for effect in job.effects))


def warm_up(jobs: Sequence[AnyJob]) -> None:
    """Load the compiled passes of the methods and effects of jobs, so that no solve is charged with it."""
    for (method, variant, *_), job in {code_path(job): job for job in jobs}.items():
        effects = () if isinstance(job, NumbersJob) else _rehearsed(job.effects)
        if method == "bem":
            _rehearse_bem(effects)
        else:
            _rehearse_fem(effects, variant)


def _rehearsed(effects: Sequence[EffectSpec]) -> tuple[EffectSpec, ...]:
    """Return effects of the same kinds that matter on waves of unit size, to warm the methods up by."""
    sizes: dict[str, Any] = {
        "hardness": {"hardness": 1.0},
        "adhesion": {"work": 1.0, "reach": 1.0},
        "thickness": {"thickness": 0.5},
        "coating": {"young": 2.0, "thickness": 0.1, "poisson": 0.0},
        "graded": {"bulk_young": 2.0, "depth": 0.5},
    }
    return tuple(effect.model_copy(update=sizes.get(effect.kind, {})) for effect in effects)


def _waves(points: int) -> HeightField:
    x = np.cos(2 * np.pi * np.arange(points) / points)
    return HeightField(heights=x[:, None] + x[None, :], lengths=(1.0, 1.0))


_UNIT_SOLID = {"young": 1.0, "poisson": 0.0}


def _rehearse_bem(effects: tuple[EffectSpec, ...]) -> None:
    from fem_contact import bem
    from fem_contact.response import HalfSpace

    # Large enough for the passes between grids and at partial contact, and done in milliseconds.
    waves, solid = _waves(64), Solid(**_UNIT_SOLID)
    if not effects:
        bem.solve(waves, HalfSpace(solid=solid), mean_pressure=0.5, threads=1)
        return
    from validation.methods.slots import solve_bem

    solve_bem(waves, solid, effects=effects, mean_pressure=0.5, tolerance=1e-6, threads=1)


def _rehearse_fem(effects: tuple[EffectSpec, ...], variant: str) -> None:
    from fem_contact import block

    arguments: dict[str, Any] = {"method": variant}
    if effects:
        from validation.methods.slots import block_arguments

        arguments |= block_arguments(Solid(**_UNIT_SOLID), effects)
    block.solve(_waves(16), Solid(**_UNIT_SOLID), mean_pressure=0.5, **arguments)


def block_file(folder: Path, job: Job) -> Path:
    """Where the deformed block of a finite-element job is exported to."""
    return folder / f"{job.key}.vtu"


def recipe_text(job: AnyJob) -> str:
    """Return the recipe as text, stored beside the result."""
    return json.dumps(job.recipe, sort_keys=True)
