"""The scorecard by files: numbered problems go out, pressures in any language come back."""

from __future__ import annotations

import contextlib
import json
import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from fem_contact.contact import Cost
from validation.arrays import Grid
from validation.cases import NotJudged
from validation.cases.scorecard import Scorecard, ladder, rows, score
from validation.cases.scorecard.subject import Subject
from validation.errors import UsageError
from validation.files import atomic_path, read_record, write_json, write_record
from validation.solvers.base import Claim, Job
from validation.solvers.bem import Bem

_FORMAT = "fem-contact challenge 2"
_INDEX = "challenge.json"
#: The order of the problems says nothing of what they ask for.
_ORDER_SEED = 20170405
_ASKED = (
    "Press the rigid rough profile h, positive towards the elastic half-space z < 0, against it with the "
    "mean pressure p0: p >= 0, gap g = u - h + offset >= 0, p g = 0, without friction or adhesion, repeated "
    "in x and y. Write the pressures [Pa], compression positive, as an array of the shape of the heights to "
    "pressure.npy, or as nx lines of ny numbers to pressure.txt, in this folder. Optional: answer.json with "
    '"seconds" (processor time) and "iterations".'
)


def _key(job: Job) -> tuple[object, ...]:
    field, modulus = job.field, job.model.solid.contact_modulus
    return field.heights.tobytes(), field.shape, field.lengths, modulus, job.mean_pressure


class _Recorder(Bem):
    """Boundary elements that remember what they were asked; with folders of problems, the answers there."""

    label = "Answers"
    papers = ()  # type: ignore[assignment]
    #: Problems in files ask for a load on the half-space.
    slots, controls = frozenset(), frozenset()

    def __init__(self, points: int, folders: Mapping[tuple[object, ...], Path] | None = None) -> None:
        self.score_points = points  # type: ignore[misc]
        self.jobs: dict[tuple[object, ...], Job] = {}
        self.folders = folders

    def claim(self, job: Job) -> Claim:
        """Solve a problem, since rows read the answers, or read its answer; a NotJudged without one."""
        self.jobs.setdefault(_key(job), job)
        if self.folders is None:
            return super().claim(job)
        if (folder := self.folders.get(_key(job))) is None:
            raise NotJudged("a problem that was not exported")
        return _claim(folder, job.field.shape)

    def subject(self, name: str, tolerance: float) -> Subject:
        """Return it to be scored, however long that takes."""
        return Subject(name=name, solver=self, settings={}, tolerance=tolerance, seconds=math.inf)


def export(folder: Path, *, points: int, tolerance: float) -> int:
    """Write the problems of a scorecard into a folder, without their answers; return how many.

    `points` are those along a side of the coarsest grid of a ladder, `tolerance` is that of the residuals.
    A UsageError for a folder that holds one.
    """
    if (folder / _INDEX).exists():
        raise UsageError(f"{folder}: holds a challenge already; score it, or export into another folder")
    problems = _problems(folder, points, tolerance)
    for number, (place, job) in enumerate(problems.items(), start=1):
        place.mkdir(parents=True, exist_ok=True)
        _write(place, number, job, tolerance)
    index = {"format": _FORMAT, "points": points, "tolerance": tolerance, "problems": len(problems)}
    write_record(folder / _INDEX, index)
    return len(problems)


def score_folder(folder: Path, *, tell: Callable[[str], None] | None = None) -> Scorecard:
    """Score the answers of a folder; rows whose problems have none are left out.

    A UsageError for a folder that is no challenge, holds no answer, or one that cannot be read.
    """
    try:
        index = read_record(folder / _INDEX)
        if index["format"] != _FORMAT:
            raise ValueError(f"{_INDEX} is of another version")
    except (OSError, ValueError, KeyError) as error:
        why = f"no {_INDEX} in it" if isinstance(error, FileNotFoundError) else error
        raise UsageError(
            f"{folder}: is no challenge ({why}); make one with: fem-contact challenge export DIR"
        ) from None
    points, tolerance = int(index["points"]), float(index["tolerance"])
    problems = _problems(folder, points, tolerance)
    answered = [place for place in problems if _answer(place)]
    if not answered:
        raise UsageError(f"{folder}: no answer; write pressure.npy or pressure.txt beside the heights")
    for place in answered:
        _claim(place, problems[place].field.shape)
    answers = _Recorder(points, {_key(job): place for place, job in problems.items()})
    subject = answers.subject(folder.resolve().name, tolerance)
    return score(subject, tell=tell)


def _problems(folder: Path, points: int, tolerance: float) -> dict[Path, Job]:
    """Return what the rows of a scorecard ask for, each once, in folders whose order tells nothing."""
    recorder = _Recorder(points)
    subject = recorder.subject("recorder", tolerance)
    for row in rows(subject):
        with contextlib.suppress(NotJudged):
            tuple(row.run())
    ladder.cost(subject)
    jobs = list(recorder.jobs.values())
    order = np.random.default_rng(_ORDER_SEED).permutation(len(jobs))
    return {folder / f"problem-{number:03d}": jobs[k] for number, k in enumerate(order, start=1)}


def _write(folder: Path, number: int, job: Job, tolerance: float) -> None:
    field = job.field
    numbers: dict[str, Any] = {
        "lengths_m": list(field.lengths),
        "contact_modulus_Pa": job.model.solid.contact_modulus,
        "mean_pressure_Pa": job.mean_pressure,
        "tolerance": tolerance,
    }
    with atomic_path(folder / "heights.npy") as draft, draft.open("wb") as file:
        np.save(file, field.heights)
    with atomic_path(folder / "heights.txt") as draft:
        np.savetxt(draft, field.heights, fmt="%.17g")
    with atomic_path(folder / "parameters.txt") as draft:
        np.savetxt(draft, np.hstack((field.shape, *numbers.values())), fmt="%.17g")
    write_json(
        folder / "problem.json",
        {
            "problem": number,
            "shape": list(field.shape),
            **numbers,
            "heights": "heights.npy, or nx lines of ny numbers in heights.txt, in m",
            "parameters": "parameters.txt: nx, ny, Lx [m], Ly [m], E* [Pa], p0 [Pa], tolerance, one a line",
            "asked": _ASKED,
        },
    )


def _answer(folder: Path) -> Path | None:
    files = (folder / "pressure.npy", folder / "pressure.txt")
    return next(filter(Path.is_file, files), None)


def _claim(folder: Path, shape: Grid) -> Claim:
    """Read pressures, and the processor time and iterations that an answer tells; NaN and 0 without one."""
    file = _answer(folder)
    if file is None:
        raise NotJudged(f"{folder.name} has no answer")
    try:
        if file.suffix == ".npy":
            pressure = np.asarray(np.load(file, allow_pickle=False), dtype=float)
        else:
            pressure = np.loadtxt(file, ndmin=2)
    except Exception as problem:  # a reader of damaged bytes raises whatever they lead to
        raise UsageError(f"{file}: cannot be read: {problem}; write it again") from None
    if pressure.shape != shape:
        raise UsageError(f"{file}: shape {pressure.shape}: must be that of the heights, {shape}")
    file = folder / "answer.json"
    try:
        answer = json.loads(file.read_text(encoding="utf-8")) if file.exists() else {}
        seconds, iterations = float(answer.get("seconds", np.nan)), int(answer.get("iterations", 0))
    except (OSError, ValueError, TypeError, AttributeError, OverflowError, RecursionError) as problem:
        raise UsageError(f"{file}: cannot be read: {problem}; write it again, or remove it") from None
    cost = Cost(
        wall_seconds=seconds,
        cpu_seconds=seconds,
        iterations=iterations,
        unknowns=pressure.size,
        peak_bytes=0,
    )
    return Claim(pressure=pressure, cost=cost)
