"""`run --accuracy`: the grids, solver tolerance and number of surfaces that an asked-for error of A/A0 takes.

The claim is a 95 % interval. For a scene of one surface it is of that surface's limit of vanishing spacing;
with an [ensemble], the mean over surfaces meets it, too, and the number of surfaces is chosen. A coarse solve
says how large the contact is and how long its edges; the law of error of the located area
(`fem_contact.extrapolation`) then says what every ladder of grids will claim, and the cheapest that is good
enough is solved. If what it claims is not enough after all, the next is.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from validation.comparison.accuracy_search import Search, grid_words
from validation.comparison.findings import percent
from validation.comparison.run import ACCURACY_FILE, Outputs, run_scene
from validation.effects.base import effect_key
from validation.errors import UsageError
from validation.files import atomic_path, prepare_folder
from validation.methods.bem import BemOptions
from validation.scenes.checks import check_scene
from validation.scenes.realised import realise
from validation.scenes.scene import Ensemble, Methods, Scene
from validation.solves.attempt import Progress, Silent, warm_up
from validation.solves.bench import Bench
from validation.solves.cost import memory_words
from validation.solves.press import solves_of
from validation.solves.running import Execution
from validation.solves.store import Store

__all__ = ["AccurateRun", "Reached", "parse_accuracy", "reach", "run_accurate"]

Grid = tuple[int, int]


def parse_accuracy(text: str) -> float:
    """Read "1%" or "0.01" as a share.

    Raises
    ------
    UsageError
        For anything else, and for what is not above 0 and at most 50 %.

    Examples
    --------
    >>> parse_accuracy("1%"), parse_accuracy("0.01"), parse_accuracy("2.5 %")
    (0.01, 0.01, 0.025)
    """
    allowed = "must be a share such as 1% or 0.01, above 0 and at most 50%"
    found = re.fullmatch(r"\s*(\d+\.?\d*(?:[eE][-+]?\d+)?|\.\d+(?:[eE][-+]?\d+)?)\s*(%?)\s*", text)
    if found is None:
        raise UsageError(f"--accuracy = {text!r}: {allowed}")
    value = float(found[1]) / (100 if found[2] else 1)
    if not 0 < value <= 0.5:
        raise UsageError(f"--accuracy = {text!r}: {allowed}")
    return value


@dataclass(frozen=True, kw_only=True)
class Reached:
    """An accuracy that was asked for, and what became of it; every error is half of a 95 % interval.

    Attributes
    ----------
    target : float
        What was asked for, relative.
    area, error : float
        Limit of A/A0 of the scene's surface, and its relative error: grid and solver.
    grids : tuple of (int, int)
        Solved for it, each on `shifts`^2 sub-grid shifts.
    shifts : int
    tolerance : float
        Of the solver, which bounds the relative error that it leaves in the area.
    surfaces : int
        Surfaces of the mean; 1 without an ensemble.
    mean, mean_error : float or None
        Mean of A/A0 over the surfaces, and its relative error: scatter, grid and solver.
    statistical : float or None
        Share of the scatter between surfaces in `mean_error`.
    surface_grids : tuple of (int, int)
        Solved for each surface of the mean.
    solves : int
        Done now.
    seconds : float
        Spent now, choosing included [s].
    predicted_seconds : float
        What the plan said of the solves that were done [s].
    peak_bytes : int
        Largest memory of the arrays of any solve.
    reused : int
        Solves found finished, by the search for the grids or for the report.
    """

    target: float
    area: float
    error: float
    grids: tuple[Grid, ...]
    shifts: int
    tolerance: float
    surfaces: int = 1
    mean: float | None = None
    mean_error: float | None = None
    statistical: float | None = None
    surface_grids: tuple[Grid, ...] = ()
    solves: int
    seconds: float
    predicted_seconds: float
    peak_bytes: int
    reused: int = 0

    def summary(self) -> dict[str, Any]:
        """Return everything as JSON-ready data."""
        return asdict(self)

    def chosen(self, scene: Scene) -> Scene:
        """Return the scene with the methods, grids and surfaces that were chosen for it."""
        bem = BemOptions(grids=self.grids, shifts=self.shifts, tolerance=self.tolerance)
        ensemble = None
        if self.surfaces > 1:
            ensemble = Ensemble(realisations=self.surfaces, grids=self.surface_grids)
        methods = Methods(bem=bem, theory=scene.methods.theory)
        return scene.model_copy(update={"methods": methods, "ensemble": ensemble})

    def sentences(self) -> Iterator[str]:
        """Say what was reached, and what it cost."""
        yield (
            f"Asked for {100 * self.target:g} %: A/A0 = {self.area:.6g} +- {percent(self.error)} (95 %) in "
            "the limit of vanishing grid spacing for this surface, by boundary elements on "
            f"{grid_words(self.grids)}, "
            f"{self.shifts**2} shift{'s' if self.shifts > 1 else ''} each, solved to {self.tolerance:g}."
        )
        if self.mean is not None and self.mean_error is not None and self.statistical is not None:
            yield (
                f"Mean over {self.surfaces} surfaces: A/A0 = {self.mean:.6g} +- {percent(self.mean_error)} "
                f"(95 %), of which {percent(self.statistical)} from the scatter between surfaces; each on "
                f"{grid_words(self.surface_grids)}."
            )
        yield (
            f"It cost {self.solves} solves, {self.seconds:.2g} s ({self.predicted_seconds:.2g} s of solving "
            f"were predicted) and {memory_words(self.peak_bytes)} for the largest."
        )


@dataclass(frozen=True, kw_only=True)
class AccurateRun:
    """What a run to an accuracy left behind."""

    outputs: Outputs
    reached: Reached


def run_accurate(
    scene: Scene,
    folder: Path,
    *,
    target: float,
    time_limit: float | None = None,
    progress: Progress | None = None,
    execution: Execution | None = None,
    store_folder: Path | None = None,
    pictures: bool = False,
    report: bool = True,
) -> AccurateRun:
    """Run a scene to an accuracy and write its report; it holds the grids that were chosen.

    Parameters
    ----------
    folder, progress, execution, store_folder, pictures
        As in `validation.run.run_scene`.
    scene, target, time_limit
        As in `reach`.

    Raises
    ------
    UsageError, RunFailed
        As `reach`.
    """
    prepare_folder(folder)
    store = Store(folder=store_folder or folder / "solves")
    bench = Bench(store=store, execution=execution or Execution(), progress=progress or Silent())
    reached = reach(scene, bench, target=target, time_limit=time_limit)
    outputs = run_scene(
        reached.chosen(scene),
        folder,
        progress=progress,
        execution=execution,
        store_folder=store_folder,
        pictures=pictures,
        report=report,
        accurate=True,
    )
    with atomic_path(folder / ACCURACY_FILE) as draft:
        draft.write_text(json.dumps(reached.summary(), indent=2) + "\n", encoding="utf-8")
    outputs = replace(outputs, files=(*outputs.files, folder / ACCURACY_FILE))
    return AccurateRun(outputs=outputs, reached=reached)


def reach(scene: Scene, bench: Bench, *, target: float, time_limit: float | None = None) -> Reached:
    """Solve a scene to an accuracy: its method, grids, tolerance and number of surfaces are chosen.

    Parameters
    ----------
    scene : Scene
        Of a half-space without effects. Grids and tolerances it names are not used, its finite elements are
        left out: boundary elements reach every accuracy at less cost.
    bench : Bench
        Where solves are kept, and the memory they may take.
    target : float
        Half of the 95 % interval of A/A0, relative.
    time_limit : float, optional
        Seconds that solving may take.

    Raises
    ------
    UsageError
        For a scene whose areas cannot be located, and, before the main solves, for an accuracy that this
        machine's memory or the time limit do not allow, with the one that they do.
    RunFailed
        When that is seen only later, or a solve fails; everything finished is stored.
    """
    realised = realise(scene)
    check_scene(scene, realised)
    if not scene.methods.solvers:
        raise UsageError("--accuracy: no solver is listed; add [methods.bem], whose grids are then chosen")
    if scene.effects:
        raise UsageError(
            f"--accuracy: the law of error is known for the bare half-space, not with "
            f"{effect_key(0, 'kind')} = {scene.effects[0].kind!r}; leave --accuracy out and refine by hand"
        )
    # Not charged to the solves, whose time tells how fast the machine is.
    warm_up(solves_of(scene, realised))
    search = Search(scene=scene, realised=realised, target=target, bench=bench, time_limit=time_limit)
    single = search.own_surface()
    mean = None if scene.ensemble is None else search.ensemble(single)
    said: dict[str, Any] = {}
    if mean is not None:
        said = {
            "surfaces": mean.surfaces,
            "mean": mean.area,
            "mean_error": mean.error,
            "statistical": mean.statistical,
            "surface_grids": mean.ladder.grids,
        }
    return Reached(
        target=target,
        area=single.area,
        error=single.error,
        grids=single.ladder.grids,
        shifts=single.ladder.shifts,
        tolerance=search.tolerance,
        solves=search.solves,
        seconds=search.spent,
        predicted_seconds=search.predicted,
        peak_bytes=search.peak_bytes,
        reused=search.reused,
        **said,
    )
