"""Which effects and methods a scene calls for, what they will cost, and what is left out and why."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from fem_contact import errors as fem_errors
from persson import errors as persson_errors
from validation.effects.judgement import Judgement, Roughness, judge, unlisted
from validation.errors import UsageError
from validation.methods.handled import check_effects
from validation.scenes.scene import FileSurface, Scene, SelfAffineSurface
from validation.scenes.surfaces import (
    Expected,
    shortest_wavelength,
    spectrum_of,
    surveyed,
    topography_of,
)
from validation.solves.cost import predicted_cost, transform_seconds
from validation.solves.solve import Job, Prediction, jobs_of, nominal_pressure

if TYPE_CHECKING:
    from rich.table import Table

    from fem_contact.surface import HeightField

__all__ = ["Explanation", "Prediction", "explain", "judgements"]


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
        For an effect that a method of the scene lacks, and for numbers that no method can compute with.
    """
    check_effects(scene)
    try:
        return _explained(scene)
    except (fem_errors.InvalidInput, persson_errors.InvalidInput) as error:
        raise UsageError(str(error)) from None
    except (ArithmeticError, np.linalg.LinAlgError) as error:
        raise UsageError(f"its numbers lie too far apart to compute with ({error})") from None


def _explained(scene: Scene) -> Explanation:
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
    from validation.solves.calibration import effect_costs

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
    field = surveyed(surface)
    pressure = nominal_pressure(scene.load, scene.solid, field)
    modulus = scene.solid.young / (1 - scene.solid.poisson**2)
    facts = [
        ("E*", f"{modulus:.6g} Pa"),
        ("realised surface", _realised_words(field)),
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
        source = "of C(q)" if isinstance(field, Expected) else "realised"
        facts.append(("Nayak parameter", f"alpha = {field.nayak:.4g} ({source})"))
        facts.append(
            ("load", f"p0 = {pressure:.6g} Pa, p* = {pressure / (modulus * field.rms_gradient):.4g}")
        )
    facts.extend(_mesh_facts(scene))
    if scene.methods.theory is not None:
        facts.append(("theory", _theory_words(scene)))
    return tuple(facts)


def _realised_words(field: HeightField | Expected) -> str:
    if isinstance(field, Expected):
        return (
            f"not made here, for it takes {field.shape[0]} x {field.shape[1]} points; all that follows is "
            "that of C(q)"
        )
    return f"h_rms = {field.rms_height:.6g} m, h'_rms = {field.rms_gradient:.6g} (spectral)"


def _theory_words(scene: Scene) -> str:
    if not scene.effects:
        return "Persson 2006, elastic, without adhesion: A/A0, P(sigma), kappa; milliseconds"
    from validation.methods.effect_theory import words

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
        name = f"finite elements, {grid[0]} x {grid[1]}"
        if longest < 2 * spacing:
            yield name, f"carry no wave of this surface, whose longest is {longest / spacing:.3g} cells long"
            continue
        # Cells count along x, whatever they are along y.
        carried = 2 * max(spacing, scene.surface.length[0] / grid[0])
        waves = [max(shortest, carried), max(longest, carried)]
        short, long = wave_errors(
            grid, scene.surface.length, waves, poisson=solid.poisson, depth=fem.depth, growth=fem.growth
        )
        yield (
            name,
            f"compliance off by {short.along_axis:+.2%} along the axes and {short.along_diagonal:+.2%} along "
            f"the diagonal at {short.nodes:.3g} nodes per wave (the shortest), by {long.along_axis:+.2%} at "
            f"{long.nodes:.3g} (the longest); + is too soft",
        )


def _roughness(scene: Scene) -> Roughness:
    field = surveyed(scene.surface)
    modulus = scene.solid.young / (1 - scene.solid.poisson**2)
    waves = {"longest": _longest(scene), "shortest": shortest_wavelength(scene.surface)}
    if isinstance(field, Expected):
        return Roughness(
            modulus=modulus,
            gradient=field.rms_gradient,
            curvature=math.sqrt(3 * field.moments[2] / 8),
            full_energy=0.25 * modulus * field.first_moment,
            **waves,
        )
    return Roughness.of(field, modulus=modulus, **waves)


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
