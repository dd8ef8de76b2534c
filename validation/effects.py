"""Which effects and methods a scene calls for, what they will cost, and what is left out and why."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from validation.effect_tables import effect_key
from validation.errors import UsageError
from validation.jobs import AnyJob, Job, NumbersJob, Prediction, jobs_of, nominal_pressure
from validation.neglect import Judgement, Roughness, judge, unlisted
from validation.scene import FileSurface, Scene, SelfAffineSurface
from validation.surfaces import reference_field, shortest_wavelength, spectrum_of, topography_of

if TYPE_CHECKING:
    from rich.table import Table

__all__ = [
    "Explanation",
    "Prediction",
    "available_memory",
    "check_effects",
    "explain",
    "judgements",
    "predicted_cost",
    "too_large",
]

#: For each effect a scene can name, the methods that handle it. A method that is not named refuses the scene.
HANDLED_BY: dict[str, frozenset[str]] = {
    "hardness": frozenset({"bem", "fem", "theory"}),
    "adhesion": frozenset({"bem", "theory"}),
    "thickness": frozenset({"bem", "fem"}),
    "coating": frozenset({"bem", "theory"}),
    "graded": frozenset({"bem", "fem", "theory"}),
    "size-dependent-hardness": frozenset(),
    "cracks": frozenset(),
}

# Measured on one thread, in units of a pair of real 256 x 256 transforms, which tells one machine from
# another.
#: What a solve costs whatever its grid: surface, set-up, storing.
_FIXED_PAIRS = 26.0
#: Boundary elements, per pair of transforms on the grid; 25 to 30 are needed, and the passes between them
#: cost.
_BEM_PAIRS = 80.0
#: The reduced block takes as many, and makes its compliance first.
_REDUCED_PAIRS = 110.0
#: The whole block, per unknown: assembly, active sets, export.
_FULL_PAIRS_PER_UNKNOWN = 0.17
#: Active sets of a block that yields over those of an elastic one: 1 to 4, by how little it can bear.
_YIELDING_SETS = 2.0
_SURFACE_BYTES_PER_POINT, _FIXED_BYTES = 15 * 8, 3 * 2**19
_FULL_BYTES_PER_UNKNOWN = 4900


def check_effects(scene: Scene) -> None:
    """Refuse a scene that lists an effect one of its methods lacks, or a solid it cannot discretise.

    Raises
    ------
    UsageError
        Naming the key, the method, and what is allowed.
    """
    fem = scene.methods.fem
    if fem is not None and fem.method == "full" and scene.solid.poisson > 0.49:
        raise UsageError(
            f"solid.poisson = {scene.solid.poisson!r}: method 'fem' locks above 0.49 with elements of "
            "displacement alone; leave [methods.fem] out or lower it"
        )
    wanted = [name for name in ("bem", "fem", "theory") if getattr(scene.methods, name) is not None]
    for k, effect in enumerate(scene.effects):
        handled = HANDLED_BY[effect.kind]
        for method in wanted:
            if method not in handled:
                able = ", ".join(sorted(handled)) or "the functions of the package persson alone"
                raise UsageError(
                    f"{effect_key(k, 'kind')} = {effect.kind!r}: method {method!r} does not handle it; "
                    f"handled by: {able}"
                )
    if scene.effects:
        from validation.slots import check_slots

        check_slots(scene)


def transform_seconds(n: int = 256) -> float:
    """Median time of a pair of real n x n transforms on this machine, on one thread [s]."""
    import scipy.fft

    field = np.random.default_rng(5).random((n, n))
    times = []
    for _ in range(5):
        start = time.perf_counter()
        scipy.fft.irfft2(scipy.fft.rfft2(field), s=(n, n))
        times.append(time.perf_counter() - start)
    return sorted(times)[2]


def predicted_cost(job: AnyJob, *, pair_seconds: float = 0.5e-3) -> Prediction:
    """Predict the cost of a job on one thread, storing included, beyond what an idle process takes.

    Parameters
    ----------
    job : AnyJob
    pair_seconds : float
        Time of one pair of 256 x 256 transforms on this machine, from `transform_seconds` [s].
    """
    if isinstance(job, NumbersJob):
        return job.predict()
    points = job.grid[0] * job.grid[1]
    scale = points * math.log2(points) / (256**2 * 16)
    dearer = _dearer(job)
    pairs, unknowns = _FIXED_PAIRS + _BEM_PAIRS * dearer * scale, points
    size = _FIXED_BYTES + _SURFACE_BYTES_PER_POINT * points
    if job.method == "fem":
        from fem_contact.block import estimate

        settings: dict[str, Any] = dict(job.settings)
        method = settings.get("method", "full")
        mesh = {name: settings[name] for name in ("depth", "growth") if name in settings}
        unknowns = estimate(job.grid, job.surface.length, method=method, **mesh).unknowns
        if method == "full":
            sets = _YIELDING_SETS if any(effect.kind == "hardness" for effect in job.effects) else 1.0
            pairs = _FIXED_PAIRS + _FULL_PAIRS_PER_UNKNOWN * sets * unknowns
            size = _FIXED_BYTES + _FULL_BYTES_PER_UNKNOWN * unknowns
        else:
            pairs = _FIXED_PAIRS + _REDUCED_PAIRS * scale
    return Prediction(seconds=pairs * pair_seconds, peak_bytes=size, unknowns=unknowns)


def _dearer(job: Job) -> float:
    """Seconds of a solve with its effects over those of a plain one; 1 for a job that lists none."""
    if not job.effects:
        return 1.0
    from validation.calibration import effect_costs

    factors = effect_costs().factors
    return math.prod(factors.get(effect.kind, 1.0) for effect in job.effects)


def available_memory() -> int:
    """Bytes that solves may take on this machine: nine tenths of what is free now."""
    import psutil

    return int(0.9 * psutil.virtual_memory().available)


def memory_words(size: float) -> str:
    """Return an amount of memory in words.

    >>> memory_words(3 * 2**20), memory_words(2.5 * 2**30)
    ('3 MiB', '2.5 GiB')
    """
    return f"{size / 2**30:.3g} GiB" if size >= 2**30 else f"{size / 2**20:.3g} MiB"


def too_large(job: AnyJob, limit: int, *, where: str = "here") -> str:
    """Say that a job does not fit into memory, and what to do."""
    needed = predicted_cost(job).peak_bytes
    return (
        f"{job.describe()}: needs about {memory_words(needed)} and {where} {memory_words(limit)} are free "
        "for it; "
        "leave the grid out, run it on a larger machine, or raise the limit with --memory"
    )


@dataclass(frozen=True, kw_only=True)
class PlannedGrid:
    """One line of an explanation: a method on a grid."""

    method: str
    grid: tuple[int, int]
    points_per_wave: float
    solves: int
    unknowns: int
    seconds: float
    peak_bytes: int


@dataclass(frozen=True, kw_only=True)
class Explanation:
    """What a scene runs and what it leaves out."""

    name: str
    facts: tuple[tuple[str, str], ...]
    grids: tuple[PlannedGrid, ...]
    effects: tuple[Judgement, ...]
    left_out: tuple[Judgement, ...]
    costs: str = ""

    @property
    def seconds(self) -> float:
        """Predicted time of all solves, one after the other [s]."""
        return sum(grid.seconds for grid in self.grids)

    @property
    def peak_bytes(self) -> int:
        """Largest memory of any one solve."""
        return max(grid.peak_bytes for grid in self.grids)

    def summary(self) -> dict[str, Any]:
        """Return everything as JSON-ready data."""
        return {**asdict(self), "seconds": self.seconds, "peak_bytes": self.peak_bytes}

    def parts(self) -> Iterator[str | Table]:
        """Yield what the command line prints, in order."""
        from rich.table import Table

        yield f"Scene {self.name}"
        for name, value in self.facts:
            yield f"  {name}: {value}"
        table = Table(title="What will run")
        for column in ("method", "grid", "lambda_short/dx", "solves", "unknowns each", "seconds", "peak MiB"):
            table.add_column(column, justify="left" if column in ("method", "grid") else "right")
        for g in self.grids:
            table.add_row(
                g.method,
                f"{g.grid[0]} x {g.grid[1]}",
                f"{g.points_per_wave:.3g}",
                str(g.solves),
                f"{g.unknowns:,}",
                f"{g.seconds:.2g}",
                f"{g.peak_bytes / 2**20:.3g}",
            )
        yield table
        yield (
            f"About {self.seconds:.0f} s in all and {self.peak_bytes / 2**20:.0f} MiB at most on this "
            "machine (meant to be right within a factor of 2)."
        )
        if self.costs:
            yield f"Solves with effects are predicted from their cost over plain ones, {self.costs}."
        yield f"Effects that run:{'' if self.effects else ' none beyond linear elasticity.'}"
        for item in self.effects:
            yield f"  {item.effect}: {item.number} - {item.verdict}"
        yield "Left out:"
        for item in self.left_out:
            yield f"  {item.effect}: {item.number} - {item.verdict}"


def explain(scene: Scene) -> Explanation:
    """Say what a scene will run and at what cost, without solving anything.

    Raises
    ------
    UsageError
        For an effect that a method of the scene lacks.
    """
    check_effects(scene)
    pair = transform_seconds()
    groups: dict[tuple[str, tuple[int, int]], list[Job]] = {}
    for job in jobs_of(scene):
        groups.setdefault((job.method, job.grid), []).append(job)
    grids = []
    for (method, grid), jobs in groups.items():
        cost = predicted_cost(jobs[0], pair_seconds=pair)
        spacing = max(length / n for length, n in zip(scene.surface.length, grid, strict=True))
        grids.append(
            PlannedGrid(
                method=method,
                grid=grid,
                points_per_wave=shortest_wavelength(scene.surface) / spacing,
                solves=len(jobs),
                unknowns=cost.unknowns,
                seconds=cost.seconds * len(jobs),
                peak_bytes=cost.peak_bytes,
            )
        )
    effects, left_out = judgements(scene)
    return Explanation(
        name=scene.name,
        facts=_facts(scene),
        grids=tuple(sorted(grids, key=lambda g: (g.method, g.grid))),
        effects=effects,
        left_out=left_out,
        costs=_cost_words(scene),
    )


def judgements(scene: Scene) -> tuple[tuple[Judgement, ...], tuple[Judgement, ...]]:
    """Return the effects that a scene lists and those it leaves out, each with the number that decides."""
    return tuple(judge(effect, _roughness(scene)) for effect in scene.effects), _left_out(scene)


def _cost_words(scene: Scene) -> str:
    """Say what the effects of a scene cost over a plain solve, and where these numbers were measured."""
    if not scene.effects:
        return ""
    from validation.calibration import effect_costs

    costs = effect_costs()
    factors = ", ".join(
        f"{effect.kind} {costs.factors[effect.kind]:.2g}"
        for effect in scene.effects
        if effect.kind in costs.factors
    )
    return f"{factors} times ({costs.source})"


def _facts(scene: Scene) -> tuple[tuple[str, str], ...]:
    """Return the numbers a reader checks first: realised and continuum roughness, load, bandwidth."""
    surface = scene.surface
    field = reference_field(surface)
    pressure = nominal_pressure(scene.load, scene.solid, field)
    modulus = scene.solid.young / (1 - scene.solid.poisson**2)
    facts = [
        ("E*", f"{modulus:.6g} Pa"),
        (
            "realised surface",
            f"h_rms = {field.rms_height:.6g} m, h'_rms = {field.rms_gradient:.6g} (spectral)",
        ),
    ]
    if isinstance(surface, SelfAffineSurface):
        moments = spectrum_of(surface).moments()
        facts.append(
            (
                "integrals over C(q)",
                f"h_rms = {moments.rms_height:.6g} m, h'_rms = {moments.rms_gradient:.6g}",
            )
        )
        facts.append(
            (
                "bandwidth",
                f"L/lambda_long = {min(surface.length) / surface.lambda_long:.3g}, "
                f"lambda_long/lambda_short = {surface.lambda_long / surface.lambda_short:.3g}",
            )
        )
    else:
        facts.extend(("measured", words) for words in topography_of(surface).history)
    if field.rms_gradient > 0:
        facts.append(("Nayak parameter", f"alpha = {field.nayak:.4g} (realised)"))
        facts.append(
            ("load", f"p0 = {pressure:.6g} Pa, p* = {pressure / (modulus * field.rms_gradient):.4g}")
        )
    facts.extend(_mesh_facts(scene))
    if scene.methods.theory is not None:
        facts.append(("theory", _theory_words(scene)))
    return tuple(facts)


def _theory_words(scene: Scene) -> str:
    if not scene.effects:
        return "Persson 2006, elastic, without adhesion: A/A0, P(sigma), kappa; milliseconds"
    from validation.effect_theory import words

    return words(scene.effects)


def _mesh_facts(scene: Scene) -> Iterator[tuple[str, str]]:
    """Yield for each finite-element grid the discretisation error that its waves are answered with."""
    fem, solid = scene.methods.fem, scene.solid
    if fem is None:
        return
    from fem_contact.block import wave_errors

    shortest, longest = shortest_wavelength(scene.surface), _longest(scene)
    for grid in sorted(fem.grids):
        spacing = max(length / n for length, n in zip(scene.surface.length, grid, strict=True))
        waves = [max(shortest, 2 * spacing), longest]
        short, long = wave_errors(
            grid, scene.surface.length, waves, poisson=solid.poisson, depth=fem.depth, growth=fem.growth
        )
        yield (
            f"finite elements, {grid[0]} x {grid[1]}",
            f"compliance off by {short.along_axis:+.2%} along the axes and {short.along_diagonal:+.2%} along "
            f"the diagonal at {short.nodes:.3g} nodes per wave (the shortest), by {long.along_axis:+.2%} at "
            f"{long.nodes:.3g} (the longest); + is too soft",
        )


def _roughness(scene: Scene) -> Roughness:
    return Roughness.of(
        reference_field(scene.surface),
        modulus=scene.solid.young / (1 - scene.solid.poisson**2),
        longest=_longest(scene),
        shortest=shortest_wavelength(scene.surface),
    )


def _left_out(scene: Scene) -> tuple[Judgement, ...]:
    """Return the effects that are not listed, each with the number that decides whether it may be."""
    rough = _roughness(scene)
    items = list(unlisted(scene, rough))
    neglected = rough.gradient**2
    items.append(
        Judgement(
            effect="finite slopes",
            number=f"h'_rms^2 = {neglected:.2g}, the relative size of the neglected terms",
            verdict="negligible"
            if neglected <= 0.02
            else "matters: every method here is linear in the slope",
        )
    )
    if scene.methods.fem is None:
        items.append(
            Judgement(
                effect="finite elements",
                number="no [methods.fem]",
                verdict="the contact algorithm is not cross-checked",
            )
        )
    return tuple(items)


def _longest(scene: Scene) -> float:
    surface = scene.surface
    return max(surface.length) if isinstance(surface, FileSurface) else surface.lambda_long
