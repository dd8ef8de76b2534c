"""`run --accuracy`: the grids, solver tolerance and number of surfaces that an asked-for error of A/A0 takes.

The claim is a 95 % interval. For a scene of one surface it is of that surface's limit of vanishing spacing;
with an [ensemble], the mean over surfaces meets it, too (`validation.measurements.ensemble`), and the number
of surfaces is chosen. A coarse solve says how large the contact is and how long its edges; the law of error
of the area (`fem_contact.extrapolation`) then says what every ladder of grids will claim, and the cheapest
that is good enough is solved. If what it claims is not enough after all, the next is.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from validation.comparison.accuracy_search import Beside, Metered, Search, Single, grid_words
from validation.comparison.run import run_scene
from validation.effects.base import effect_key
from validation.errors import UsageError
from validation.execution.bench import Bench
from validation.execution.results import Outputs
from validation.execution.solve import memory_words
from validation.files import prepare_folder
from validation.measurements.ensemble import MeanArea
from validation.report.words import json_ready, percent, significant
from validation.scenes.checks import check_scene
from validation.scenes.problem import realise
from validation.scenes.scene import Scene
from validation.scenes.tables import FileSurface
from validation.solvers.bem import BemOptions

#: Slots of effects with which the area corrected at its edge follows its law of error.
_LAWFUL = frozenset({"pressure bound", "response"})


def parse_accuracy(text: str) -> float:
    """Read "1%" or "0.01" as a share.

    A UsageError for anything else, for what is not above 0 and at most 50 %, and for more than 0.1 without
    the sign: many mean half a per cent by 0.5.

    >>> parse_accuracy("1%"), parse_accuracy("0.01"), parse_accuracy("2.5 %")
    (0.01, 0.01, 0.025)
    """
    match = re.fullmatch(r"\s*((?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(%?)\s*", text)
    value = float(match[1]) / (100 if match[2] else 1) if match else math.nan
    if not 0 < value <= 0.5:
        allowed = "a share such as 1% or 0.01, above 0 and at most 50%"
        raise UsageError(f"--accuracy = {text!r}: must be {allowed}")
    if value > 0.1 and match and not match[2]:
        raise UsageError(f"--accuracy = {text!r}: is that {value:g}% or {100 * value:g}%? say which")
    return value


@dataclass(frozen=True, kw_only=True)
class AccuracyResult(Single):
    """An accuracy that was asked for, and what became of it.

    Of the `tolerance` of the solver seven times is counted as left in the area. Of the `solves` done now,
    blocks of pairs counted as one, and the `seconds` spent, `solving_seconds` were predicted to be
    `predicted_seconds`; `reused` solves were found finished.
    """

    target: float
    tolerance: float
    beside: tuple[Beside, ...]
    ensemble: MeanArea | None
    solves: int
    seconds: float
    solving_seconds: float
    predicted_seconds: float
    peak_bytes: int
    reused: int

    def summary(self) -> dict[str, Any]:
        """Return everything as JSON-ready data."""
        numbers = {n: value for n, value in vars(self).items() if n not in ("finest", "ensemble")}
        numbers |= {"located": self.located, "beside": list(map(asdict, self.beside)), "mean": None}
        if (ensemble := self.ensemble) is not None:
            mean = ensemble.estimate.value
            numbers |= {n: getattr(ensemble, n) for n in ("surfaces", "scatter", "pairs", "unsolved")}
            numbers |= {"mean": mean, "mean_error": ensemble.half_width / mean}
            numbers |= {"statistical": ensemble.estimate.half_width / mean, "surface_grids": ensemble.grids}
        return dict(json_ready(numbers))

    def chosen(self, scene: Scene) -> Scene:
        """Return the scene with the grids that were chosen for its own surface."""
        bem = BemOptions(grids=self.grids, shifts=self.shifts, tolerance=self.tolerance)
        methods = scene.methods.model_copy(update={"bem": bem})
        return scene.model_copy(update={"methods": methods, "ensemble": None})

    def sentences(self) -> Iterator[str]:
        """Say what was reached, and what it cost."""
        edge = {True: "located inside the cells", False: "corrected at its edge"}
        yield (
            f"Asked for {100 * self.target:g} %: A/A0 = {self.area:.6g} +- {percent(self.error)} (95 %: grid "
            f"and solver) in the limit of vanishing grid spacing for this surface, of the area "
            f"{edge[self.located]}, by boundary elements on {grid_words(self.grids)}, {self.shifts**2} "
            f"shift{'s' if self.shifts > 1 else ''} each, solved to {self.tolerance:g}."
        )
        for other in self.beside:
            answer = f"A/A0 = {other.area:.6g} +- {percent(other.error)} (95 %: grid; limit of the area "
            answer += f"{edge[other.located]}), {100 * (other.area / self.area - 1):+.2g} % from it"
            answer = f"no limit: {other.doubt}" if other.doubt else answer
            yield f"Beside it {other.label} on {grid_words(other.grids)}: {answer}."
        if (mean := self.ensemble) is not None:
            area, half = mean.estimate.value, mean.estimate.half_width
            pairs = zip(mean.pairs, mean.grids, strict=True)
            ending = ", ".join(f"{count} to {nx} x {ny}" for count, (nx, ny) in pairs)
            plain = math.ceil((1.96 * mean.scatter * area / half) ** 2) if half > 0 else 2
            yield (
                f"Mean over the surfaces of this spectrum: A/A0 = {area:.6g} +- "
                f"{percent(mean.half_width / area)} (95 %: surfaces, grid and solver), of which "
                f"{percent(half / area)} from the scatter between surfaces; from {mean.surfaces} surfaces, "
                f"in pairs h, -h ({ending}), and from the heights of {mean.unsolved} more pairs, not solved. "
                f"A plain mean of single surfaces, which scatter by {percent(mean.scatter)}, would take "
                f"about {plain}, every one on the finest of these grids."
            )
        counted = ", blocks of pairs counted as one" if self.ensemble else ""
        times = self.seconds, self.solving_seconds, self.predicted_seconds
        spent, solving, predicted = (significant(seconds, 2) for seconds in times)
        yield (
            f"It cost {self.solves} solves{counted}, {spent} s ({solving} s of solving, {predicted} s "
            f"predicted) and {memory_words(self.peak_bytes)} for the largest."
        )


def run_accurate(
    scene: Scene,
    folder: Path,
    *,
    target: float,
    time_limit: float | None = None,
    bench: Bench | None = None,
    report: bool = True,
    pictures: bool = False,
) -> Outputs:
    """Run a scene to an accuracy and write its report; it holds the grids that were chosen.

    Arguments and errors are those of `reach` and of `validation.comparison.run.run_scene`.
    """
    prepare_folder(folder)
    bench = bench or Bench.at(folder / "solves")
    reached = reach(scene, bench, target=target, time_limit=time_limit)
    found, asked = reached.chosen(scene), reached.summary()
    outputs = run_scene(found, folder, bench=bench, accurate=asked, report=report, pictures=pictures)
    return replace(outputs, more=tuple(reached.sentences()), solved=reached.solves, reused=reached.reused)


def reach(scene: Scene, bench: Bench, *, target: float, time_limit: float | None = None) -> AccuracyResult:
    """Solve a scene until half of the 95 % interval of A/A0 is `target` of it.

    Grids, tolerance and number of surfaces are chosen: those that the scene names for its boundary elements
    and its ensemble are not used. Its other methods are solved on their own grids and put beside. Solving may
    take `time_limit` seconds, and the memory that `bench` allows.

    A UsageError for an effect whose areas have no law of error, and, before the main solves, for an accuracy
    that this machine's memory or the time limit do not allow, with the one that they do. A RunFailed when
    that is seen only later, or a solve fails; everything finished is stored.
    """
    problem = realise(scene)
    check_scene(scene, problem)
    if not scene.methods.solvers:
        raise UsageError("--accuracy: no solver is listed; add [methods.bem], whose grids are then chosen")
    if scene.ensemble is not None and isinstance(scene.surface, FileSurface):
        raise UsageError("ensemble: --accuracy draws as many surfaces as it takes, not maps; remove it")
    for k, effect in enumerate(scene.effects):
        if effect.slot not in _LAWFUL:
            why = f"the law of error is not known with {effect_key(k, 'kind')} = {effect.kind!r}"
            raise UsageError(f"--accuracy: {why}; leave --accuracy out and refine by hand")
    shared = {name: getattr(bench, name) for name in ("store", "execution", "progress")}
    metered = Metered(**shared, wanted=f"--accuracy = {100 * target:g} %", time_limit=time_limit)
    search = Search(scene=scene, problem=problem, target=target, bench=metered)
    search.reserve()
    single, account = search.own_surface(), metered.account
    return AccuracyResult(
        **vars(single),
        target=target,
        tolerance=search.tolerance,
        beside=search.beside(),
        ensemble=None if scene.ensemble is None else search.ensemble(single),
        solves=len(account.done),
        seconds=metered.spent,
        solving_seconds=account.solving,
        predicted_seconds=account.predicted,
        peak_bytes=search.peak_bytes,
        reused=len(account.found),
    )
