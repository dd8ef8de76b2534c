"""Which effects and methods a scene calls for, what they will cost, and what is left out and why."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from fem_contact import errors as fem_errors
from persson import errors as persson_errors
from validation.arrays import Grid
from validation.comparison.reductions import grid_name
from validation.effects import effect_kinds
from validation.effects.base import Judgement, Roughness, TheoryInputs, full_contact_energy
from validation.errors import UsageError
from validation.execution.calibration import effect_costs
from validation.execution.press import Press, run_solves
from validation.execution.solve import Prediction, transform_seconds
from validation.measurements.measurement import has_square_cells
from validation.report.quantities import as_length, in_prefixed_unit
from validation.report.words import significant
from validation.scenes.checks import check_scene
from validation.scenes.problem import ContactProblem, realise
from validation.scenes.scene import Scene, affordable, usual_grids
from validation.scenes.surfaces import Expected
from validation.scenes.sweep import Sweep
from validation.solvers import Solver, methods
from validation.solvers.theory import theory_words
from validation.units import alike

if TYPE_CHECKING:
    from rich.table import Table

    from fem_contact.surface import HeightField
    from persson.spectrum import Moments

#: Differences of contact area and of rms pressure from the linear ones per h'_rms, by Poisson ratio: mean of
#: p* = .05 and .2 up to h'_rms = .4 over four surfaces, by `fem-contact study large-slope` for nu = .3 and
#: with 8 points per shortest wave for the others (docs/block.md). Either load is a third off the mean.
_POISSONS = (0.0, 0.3, 0.45, 0.49)
_AREA = (-0.30, -0.12, -0.01, 0.03)
_RMS_PRESSURE = (0.27, 0.115, 0.01, -0.03)

#: What is left over h'_rms^2 where the first order vanishes: 3 % at nu = .45 and slopes of .7.
_SECOND_ORDER = 0.06

#: Largest relative difference that is called negligible.
_NEGLIGIBLE = 0.02


@dataclass(frozen=True, kw_only=True)
class PlannedGrid(Prediction):
    """One line of an explanation: a method on a grid, and what all its solves take."""

    method: str
    grid: Grid
    points_per_wave: float
    solves: int


@dataclass(frozen=True, kw_only=True)
class Explanation:
    """What a scene runs and what it leaves out; `seconds` of all solves, the most `peak_bytes` of any."""

    name: str
    facts: tuple[tuple[str, str], ...]
    grids: tuple[PlannedGrid, ...]
    effects: tuple[Judgement, ...]
    left_out: tuple[Judgement, ...]
    costs: str
    seconds: float
    peak_bytes: int

    def summary(self) -> dict[str, Any]:
        """Return everything as JSON-ready data."""
        return asdict(self)

    def parts(self) -> Iterator[str | Table]:
        """Yield what the command line prints, in order."""
        from rich.table import Table

        yield f"Scene {self.name}"
        for name, value in self.facts:
            yield f"  {name}: {value}"
        if self.grids:
            table = Table("method", "grid", title="What will run")
            for column in ("lambda_short/dx", "solves", "unknowns each", "seconds", "peak MiB"):
                table.add_column(column, justify="right")
            for g in self.grids:
                counts = f"{g.points_per_wave:.3g}", str(g.solves), f"{g.unknowns:,}"
                sizes = significant(g.seconds, 2), significant(g.peak_bytes / 2**20, 3)
                table.add_row(g.method, grid_name(g.grid), *counts, *sizes)
            yield table
            yield (
                f"About {significant(self.seconds, 2)} s of solving and {self.peak_bytes / 2**20:.0f} MiB "
                "at most on this machine (meant to be right within a factor of 2); start and page take "
                "seconds more."
            )
        else:
            yield "No solver runs: the theory answers from C(q) alone."
        if self.costs:
            yield f"Solves with effects are predicted from their cost over plain ones, {self.costs}."
        none = "" if self.effects else " none beyond linear elasticity."
        for title, items in ((f"Effects that run:{none}", self.effects), ("Left out:", self.left_out)):
            yield title
            yield from (f"  {item.effect}: {item.number} - {item.verdict}" for item in items)


def explain(scene: Scene, problem: ContactProblem | None = None) -> Explanation:
    """Say what a scene will run and at what cost, without solving anything.

    A UsageError for an effect that a method of the scene lacks, and for numbers that no method can compute
    with.
    """
    problem = problem or realise(scene, surveyed=True)
    try:
        check_scene(scene, problem)
        groups: dict[tuple[str, Grid], list[Press]] = {}
        for solve in run_solves(scene, problem):
            groups.setdefault((solve.method, solve.grid), []).append(solve)
        pair, facts = transform_seconds(), tuple(_facts(scene, problem))
        grids = []
        for (method, grid), solves in sorted(groups.items()):
            cost, waves = solves[0].predict(pair_seconds=pair), problem.points_per_wave(grid)
            sizes = {**vars(cost), "solves": len(solves), "seconds": cost.seconds * len(solves)}
            grids.append(PlannedGrid(method=method, grid=grid, points_per_wave=waves, **sizes))
        effects, left_out = judgements(scene, problem)
    except (fem_errors.InvalidInput, persson_errors.InvalidInput) as error:
        raise UsageError(str(error)) from None
    except (ArithmeticError, np.linalg.LinAlgError) as error:
        raise UsageError(f"its numbers lie too far apart to compute with ({error})") from None
    cost_words = ""
    if scene.effects and scene.methods.solvers:
        costs = effect_costs()
        factors = ", ".join(f"{effect.kind} {costs.factors[effect.kind]:.2g}" for effect in scene.effects)
        cost_words = f"{factors} times ({costs.source})"
    return Explanation(
        name=scene.name,
        facts=facts,
        grids=tuple(grids),
        effects=effects,
        left_out=left_out,
        costs=cost_words,
        **_in_all(grids),
    )


def _in_all(costs: Sequence[Prediction]) -> dict[str, Any]:
    """Sum of the times, one after the other [s], and the largest memory."""
    peak = max((cost.peak_bytes for cost in costs), default=0)
    return {"seconds": sum(cost.seconds for cost in costs), "peak_bytes": peak}


def problems_of(sweep: Sweep, *, surveyed: bool = False) -> tuple[ContactProblem, ...]:
    """Return what each scene asks for, each surface made once, and refuse what cannot be run.

    A UsageError naming the values at which it cannot.
    """
    made: list[ContactProblem] = []
    surfaces: dict[Any, ContactProblem] = {}
    for k, scene in enumerate(sweep.scenes):
        problem = realise(scene, like=surfaces.get(scene.surface), surveyed=surveyed)
        try:
            if len(scene.load.values) > 1:
                key = f"load.{scene.load.key}"
                raise UsageError(f"{key}: lists several loads; move the list to [sweep], as sweep.{key}")
            check_scene(scene, problem)
        except (UsageError, fem_errors.InvalidInput, persson_errors.InvalidInput) as error:
            raise UsageError(f"{error} ([sweep] at {sweep.place(k)})") from None
        surfaces.setdefault(scene.surface, problem)
        made.append(problem)
    return tuple(made)


def solves_of_sweep(sweep: Sweep, cases: Sequence[ContactProblem]) -> tuple[Press, ...]:
    """List the solves of all scenes; what several of them ask for is listed once."""
    each = zip(sweep.scenes, cases, strict=True)
    return tuple({solve.key: solve for scene, case in each for solve in run_solves(scene, case)}.values())


@dataclass(frozen=True, kw_only=True)
class SweepExplanation:
    """What a sweep runs: each of its `cases`, and what the solves that they share will take."""

    sweep: Sweep
    cases: tuple[Explanation, ...]
    costs: tuple[Prediction, ...]

    def summary(self) -> dict[str, Any]:
        """Return everything as JSON-ready data."""
        return {
            "name": self.sweep.name,
            "mode": self.sweep.mode,
            "keys": [asdict(key) for key in self.sweep.keys],
            "cases": [{"case": self.sweep.place(k), **case.summary()} for k, case in enumerate(self.cases)],
            "solves": len(self.costs),
            "asked": sum(grid.solves for case in self.cases for grid in case.grids),
            **_in_all(self.costs),
        }

    def parts(self) -> Iterator[Any]:
        """Yield what the command line prints, in order: the sum, then the first and the last case."""
        whole, last = self.summary(), len(self.cases) - 1
        joined = "every combination of" if self.sweep.mode == "product" else "side by side"
        named = ", ".join(f"{key.key} ({len(key.values)} values)" for key in self.sweep.keys)
        yield f"Sweep of scene {self.sweep.name}: {len(self.cases)} cases, {joined} {named}"
        yield (
            f"{whole['solves']} solves; {whole['asked'] - whole['solves']} more are shared between cases: "
            f"about {significant(whole['seconds'], 2)} s one after the other and "
            f"{significant(whole['peak_bytes'] / 2**20, 3)} MiB at most (meant to be right within a factor "
            "of 2); start and page take seconds more."
        )
        if last > 1:
            yield "The first and the last of them:"
        for k in sorted({0, last}):
            yield f"\nCase {self.sweep.place(k)}:"
            yield from self.cases[k].parts()


def explain_sweep(sweep: Sweep) -> SweepExplanation:
    """Say what a sweep will run and at what cost, without solving anything.

    A UsageError for a scene that cannot be run, naming the values at which it cannot.
    """
    problems, pair = problems_of(sweep, surveyed=True), transform_seconds()
    costs = tuple(solve.predict(pair_seconds=pair) for solve in solves_of_sweep(sweep, problems))
    return SweepExplanation(sweep=sweep, cases=tuple(map(explain, sweep.scenes, problems)), costs=costs)


def judgements(scene: Scene, problem: ContactProblem) -> tuple[tuple[Judgement, ...], tuple[Judgement, ...]]:
    """Return the effects that a scene lists and those it leaves out, each with the number that decides."""
    rough = roughness_of(problem)
    listed = [effect.judge(rough) for effect in scene.effects]
    for k, judgement in enumerate(listed):
        if judgement.negligible and scene.methods.solvers:
            costs = effect_costs()
            words = f"it costs {costs.factors[judgement.effect]:.2g} times the plain solve ({costs.source})"
            listed[k] = replace(judgement, verdict=f"{judgement.verdict}; {words}")
    slots = {effect.slot for effect in scene.effects}
    # Where one effect fills a slot, its rivals are not missing.
    rivals = (kind for kind in effect_kinds().values() if kind.slot not in slots)
    left_out = [*filter(None, (kind.unlisted(rough) for kind in rivals))]
    left_out.append(finite_slopes(rough, poisson=problem.elastic.poisson))
    what, verdict = "an independent solver", "the contact algorithm is not cross-checked"
    able = [name for name, method in methods().items() if method.independent]
    if not scene.methods.solvers:
        what, able = "a solver", [name for name, method in methods().items() if isinstance(method, Solver)]
        verdict = "how far the theory is from the equations of elasticity is not measured"
    if not any(method.independent for method in scene.methods.solvers.values()):
        left_out.append(Judgement(effect=what, number=f"no [methods.{able[0]}]", verdict=verdict))
    return tuple(listed), tuple(left_out)


def roughness_of(problem: ContactProblem) -> Roughness:
    """Return what judgements need to know of a surface; of C(q) where none is made."""
    field: HeightField | Expected = problem.field
    given = {"modulus": problem.contact_modulus, "longest": problem.longest, "shortest": problem.shortest}
    if isinstance(field, Expected):
        energy = 0.25 * problem.contact_modulus * field.first_moment
    else:
        energy = full_contact_energy(field, modulus=problem.contact_modulus)
    curvature = math.sqrt(3 * field.moments[2] / 8)
    return Roughness(gradient=field.rms_gradient, curvature=curvature, full_energy=energy, **given)


def _facts(scene: Scene, problem: ContactProblem) -> Iterator[tuple[str, str]]:
    from fem_contact.surface import Patch

    field: HeightField | Expected = problem.field
    yield "E*", in_prefixed_unit(alike(problem.contact_modulus, scene.solid.young), "Pa")
    if isinstance(field, Expected):
        points = f"not made here, for it takes {field.shape[0]} x {field.shape[1]} points"
        why = points if scene.methods.solvers else "none is drawn, for no solver runs"
        yield "realised surface", f"{why}; all that follows is that of C(q)"
    else:
        how = "by differences" if isinstance(field, Patch) else "spectral"
        yield "realised surface", f"{_heights(field)} ({how})"
    if problem.measured is not None:
        yield from (("measured", words) for words in problem.measured.period.history)
    else:
        yield "integrals over C(q)", _heights(problem.spectrum_shape.moments())
        sizes = f"L/lambda_long = {problem.periods:.3g}, "
        yield "bandwidth", sizes + f"lambda_long/lambda_short = {problem.longest / problem.shortest:.3g}"
    source = "of C(q)" if isinstance(field, Expected) else "realised"
    yield "Nayak parameter", f"alpha = {field.nayak:.4g} ({source})"
    for key, v in problem.load.held.items():
        words = f"{key.replace('_', ' ')} = {as_length(v, 4)} is held; "
        yield "load", words + "the load that takes follows from the solve"
    if not problem.load.held:
        each = ", ".join(in_prefixed_unit(pressure, "Pa") for pressure in problem.pressures)
        reduced = ", ".join(f"{pressure / problem.pressure_scale:.4g}" for pressure in problem.pressures)
        force = problem.load.force
        first = "" if force is None else f"force = {in_prefixed_unit(force, 'N')}; "
        yield "load", f"{first}p0 = {each}; p* = {reduced}"
    usual = usual_grids(problem.lengths, problem.shortest)
    for name, solver in scene.methods.solvers.items():
        options = scene.methods.options(name)
        listed, left = usual[: len(options.grids)], usual[len(options.grids) :]
        more = left and options.grids == listed
        if more and not affordable(solver, left[0], lengths=problem.lengths, options=options):
            words = f"{grid_name(left[0])} would take more than 2 GiB or ten minutes"
            yield f"grids of {name}", f"{words}; list it in methods.{name}.grids to have it all the same"
    yield from oblong_grids(scene, problem)
    for name, method in scene.methods.chosen.items():
        yield from method.facts(scene.methods.options(name), problem)
    if (theory := scene.methods.options("theory")) is not None:
        words = "Persson 2006, elastic, without adhesion: A/A0, P(sigma), kappa; milliseconds"
        if scene.effects:
            words = theory_words(TheoryInputs.by(problem.elastic, scene.effects), theory)
        yield "theory", words


def _heights(of: HeightField | Moments) -> str:
    return f"h_rms = {as_length(of.rms_height, 4)}, h'_rms = {of.rms_gradient:.4g}"


def oblong_grids(scene: Scene, problem: ContactProblem) -> Iterator[tuple[str, str]]:
    """Say which grids have oblong cells, and which would have square ones."""
    for name in scene.methods.solvers:
        for nx, ny in scene.methods.options(name).grids:
            if not has_square_cells(problem, (nx, ny)):
                lx, ly = problem.lengths
                least, ratio = (nx, ly / lx) if lx >= ly else (ny, lx / ly)
                # Of few points rounding may leave them oblong, too.
                sides = ((n, max(2, round(n * ratio))) for n in itertools.count(least))
                both = (side if lx >= ly else side[::-1] for side in sides)
                square = next(list(grid) for grid in both if has_square_cells(problem, grid))
                words = f"{nx} x {ny} has oblong cells, in which no edge is located; {square} has square ones"
                yield f"grids of {name}", words


def finite_slopes(rough: Roughness, *, poisson: float) -> Judgement:
    """Say whether the slopes are too large for linear elasticity.

    Both differences go with the slope to first order and vanish near nu = .45: the surface of a compressible
    solid is drawn into the contact, and meets the profile elsewhere than the linear one does.
    """
    slope = rough.gradient
    area, pressure = (slope * float(np.interp(poisson, _POISSONS, rates)) for rates in (_AREA, _RMS_PRESSURE))
    matters = max(abs(area), abs(pressure)) + _SECOND_ORDER * slope**2 > _NEGLIGIBLE
    return Judgement(
        effect="finite slopes",
        number=f"h'_rms = {slope:.2g} changes the contact area by about {100 * area:+.1g} % and the rms "
        f"pressure by {100 * pressure:+.1g} % (measured on a neo-Hookean block, nu = {poisson:.3g})",
        verdict="matters: every method here is linear in the slope" if matters else "negligible",
    )
