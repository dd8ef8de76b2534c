"""Running a scene: check everything first, solve what is not stored yet, compare, write the results."""

from __future__ import annotations

import contextlib
import json
import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from fem_contact.errors import FemContactError
from validation.effects import available_memory, check_effects, predicted_cost, too_large
from validation.errors import RunFailed, UsageError
from validation.jobs import AnyJob, NumbersJob, block_file, execute, jobs_of, warm_up
from validation.store import Store, atomic_path, prepare_folder, remove_drafts
from validation.surfaces import reference_field

if TYPE_CHECKING:
    from validation.comparison import Comparison
    from validation.scene import Scene

__all__ = [
    "ACCURACY_FILE",
    "Execution",
    "Outcome",
    "Outputs",
    "Progress",
    "Silent",
    "attempt",
    "load_run",
    "one_blas_thread",
    "report_run",
    "run_scene",
    "solve_jobs",
]

_RUN_FILE = "run.json"
_RUN_FORMAT = "fem-contact run 1"

#: What a run to an accuracy reached, in its results folder.
ACCURACY_FILE = "accuracy.json"


class Progress(Protocol):
    """What a run tells the person who watches it."""

    def start(self, missing: tuple[AnyJob, ...], stored: int) -> None:
        """Tell which jobs are to be done, and how many were found finished."""

    def begin(self, job: AnyJob) -> None:
        """Tell that a job starts."""

    def done(self, job: AnyJob) -> None:
        """Tell that a job is solved and stored."""

    def note(self, text: str) -> None:
        """Tell something the user should know, such as a damaged file that was set aside."""


class Silent:
    """Progress that nobody watches."""

    def start(self, missing: tuple[AnyJob, ...], stored: int) -> None:
        """Say nothing."""

    def begin(self, job: AnyJob) -> None:
        """Say nothing."""

    def done(self, job: AnyJob) -> None:
        """Say nothing."""

    def note(self, text: str) -> None:
        """Say nothing."""


@dataclass(frozen=True, kw_only=True)
class Execution:
    """Where solves run.

    Attributes
    ----------
    workers : int
        1: in this process, with all its threads. More: that many processes of one thread each.
    scheduler : str or None
        Address of a Dask scheduler, which then does the work; its workers write into the same store.
    memory : int or None
        Bytes that all solves running at a time may take together; what is free on this machine if not given.
    """

    workers: int = 1
    scheduler: str | None = None
    memory: int | None = None

    def __post_init__(self) -> None:
        if self.workers < 1:
            raise UsageError(f"workers = {self.workers}: must be at least 1")
        if self.scheduler is not None and self.workers != 1:
            raise UsageError(
                f"workers = {self.workers}: cannot be combined with a scheduler, which has workers of its own"
            )


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """How the attempt at one job ended; the result itself is in the store.

    Attributes
    ----------
    job : AnyJob
    error : str or None
        Why there is no result.
    fatal : bool
        Whether the others need not be tried: a full disk.
    """

    job: AnyJob
    error: str | None = None
    fatal: bool = False


@dataclass(frozen=True, kw_only=True)
class Outputs:
    """What a run left behind.

    Attributes
    ----------
    comparison : Comparison
    folder : Path
    files : tuple of Path
        Everything a reader may want to open, the report first.
    solved, reused : int
        Jobs solved now, and jobs found finished.
    """

    comparison: Comparison
    folder: Path
    files: tuple[Path, ...]
    solved: int
    reused: int


def run_scene(
    scene: Scene,
    folder: Path,
    *,
    progress: Progress | None = None,
    execution: Execution | None = None,
    store_folder: Path | None = None,
    pictures: bool = False,
    accurate: bool = False,
) -> Outputs:
    """Run a scene into a folder; finished solves found in the store are used, not repeated.

    Parameters
    ----------
    scene : Scene
    folder : Path
        For tables, figures and report.
    progress : Progress, optional
    execution : Execution, optional
        Where the solves run; in this process if not given.
    store_folder : Path, optional
        Where the solves are kept, to be shared with other runs and studies; `folder`/solves if not given.
    pictures : bool
        Whether the report gets 3-D pictures, rendered off screen in some seconds.
    accurate : bool
        Whether the grids were chosen for an accuracy; a plain run removes what an earlier such run reached.

    Raises
    ------
    UsageError
        For a scene or folder that cannot be used, before anything is computed.
    RunFailed
        When a solve fails; everything finished is stored.
    """
    check_effects(scene)
    reference_field(scene.surface)
    prepare_folder(folder)
    store = Store(folder=prepare_folder(store_folder or folder / "solves", option="--store"))
    if not accurate:
        # What an earlier run to an accuracy reached is not what this one finds.
        (folder / ACCURACY_FILE).unlink(missing_ok=True)
    _record(scene, folder, store)
    jobs = jobs_of(scene)
    solved = solve_jobs(jobs, store, progress=progress, execution=execution)
    comparison, files = _compared(scene, store, folder, pictures=pictures, accurate=accurate)
    return Outputs(
        comparison=comparison, folder=folder, files=files, solved=solved, reused=len(jobs) - solved
    )


def report_run(folder: Path, *, pictures: bool = False) -> Outputs:
    """Write tables, figures and report of a finished run again, from its stored solves alone.

    Raises
    ------
    UsageError
        For a folder that holds no run.
    RunFailed
        When a solve of the run is missing.
    """
    scene, store = load_run(folder)
    accurate = (folder / ACCURACY_FILE).exists()
    comparison, files = _compared(scene, store, prepare_folder(folder), pictures=pictures, accurate=accurate)
    return Outputs(comparison=comparison, folder=folder, files=files, solved=0, reused=len(jobs_of(scene)))


def _compared(
    scene: Scene, store: Store, folder: Path, *, pictures: bool, accurate: bool
) -> tuple[Comparison, tuple[Path, ...]]:
    from validation.comparison import compare
    from validation.report import write_outputs

    comparison = compare(scene, store, accurate=accurate)
    return comparison, write_outputs(comparison, store, folder, pictures=pictures)


def _record(scene: Scene, folder: Path, store: Store) -> None:
    """Write down what the folder is a run of, so that its report can be made again without the scene file."""
    said = {
        "format": _RUN_FORMAT,
        "scene": scene.model_dump(mode="json", exclude_none=True),
        "store": os.path.relpath(store.folder.resolve(), folder.resolve()),
    }
    with atomic_path(folder / _RUN_FILE) as draft:
        draft.write_text(json.dumps(said, indent=2) + "\n", encoding="utf-8")


def load_run(folder: Path) -> tuple[Scene, Store]:
    """Return the scene and the store of the run in a folder.

    Raises
    ------
    UsageError
        When the folder holds none.
    """
    from validation.scene import Scene

    path = folder / _RUN_FILE
    try:
        said = json.loads(path.read_text(encoding="utf-8"))
        if said["format"] != _RUN_FORMAT:
            raise ValueError
        scene = Scene.model_validate(said["scene"])
        return scene, Store(folder=(folder / said["store"]).resolve())
    except OSError as error:
        raise UsageError(
            f"{folder}: holds no run ({_RUN_FILE}: {error.strerror}); name a results folder"
        ) from None
    except (ValueError, KeyError, TypeError):
        raise UsageError(f"{path}: is not the record of a run of this version; run the scene again") from None


def solve_jobs(
    jobs: tuple[AnyJob, ...],
    store: Store,
    *,
    progress: Progress | None = None,
    execution: Execution | None = None,
) -> int:
    """Solve and store the jobs that are not stored yet; return how many that were.

    Each result is on disk as soon as its solve ends, written by whoever solved it: an interruption loses at
    most the solves under way. A solve that fails does not keep the others from being done.

    Raises
    ------
    UsageError
        For a job that does not fit into memory, or a scheduler that does not answer, before anything runs.
    RunFailed
        When solves failed, naming them, or the disk is full.
    """
    execution, progress = execution or Execution(), progress or Silent()
    remove_drafts(store.folder)
    missing = tuple(job for job in jobs if not store.holds(job, on_damage=progress.note))
    if execution.scheduler is None:
        _refuse_too_large(missing, execution)
    progress.start(missing, len(jobs) - len(missing))
    failures = []
    for outcome in _outcomes(missing, store, execution, progress.begin):
        if outcome.fatal:
            raise RunFailed(outcome.error)
        if outcome.error is not None:
            failures.append(outcome)
        else:
            progress.done(outcome.job)
    if failures:
        raise RunFailed(_failed(failures, len(missing)))
    return len(missing)


def _outcomes(
    jobs: tuple[AnyJob, ...], store: Store, execution: Execution, begin: Callable[[AnyJob], None]
) -> Iterator[Outcome]:
    if not jobs:
        return iter(())
    if execution.scheduler is not None:
        from validation.cluster import solve_on_cluster

        return solve_on_cluster(jobs, store, address=execution.scheduler, begin=begin)
    if execution.workers > 1:
        from validation.pool import solve_in_processes

        memory = available_memory() if execution.memory is None else execution.memory
        return solve_in_processes(jobs, store, workers=execution.workers, memory=memory, begin=begin)
    return _in_this_process(jobs, store, begin)


def _in_this_process(
    jobs: Sequence[AnyJob], store: Store, begin: Callable[[AnyJob], None]
) -> Iterator[Outcome]:
    warm_up(jobs)
    for job in jobs:
        begin(job)
        yield attempt(job, store)


def attempt(job: AnyJob, store: Store, *, threads: int | None = None) -> Outcome:
    """Do one job and store its result; what a worker does.

    Parameters
    ----------
    job : AnyJob
    store : Store
    threads : int, optional
        Threads for this solve; all that there are if not given. Their number changes the result by rounding:
        the transforms group their sums by it.
    """
    try:
        if isinstance(job, NumbersJob):
            with one_blas_thread():
                store.save(job, job.measure())
            return Outcome(job=job)
        # Sparse solvers gain nothing from a threaded BLAS, whose idle threads spin on cores that others need.
        with one_blas_thread():
            solved = execute(job) if threads is None else execute(job, threads=threads)
        solved.contact.checked()
        # The reduced method never holds the inside of the block, which may be a thousand times the surface.
        if solved.block is not None and dict(job.settings).get("method", "full") == "full":
            from fem_contact.export import write_block

            with atomic_path(block_file(store.folder, job)) as draft:
                write_block(draft, solved.block)
        store.save(job, solved.contact)
    except (FemContactError, MemoryError) as error:
        return Outcome(job=job, error=f"{job.describe()}: {error}")
    except RunFailed as error:
        return Outcome(job=job, error=str(error), fatal=True)
    return Outcome(job=job)


def one_blas_thread() -> contextlib.AbstractContextManager[object]:
    """Keep the dense linear algebra inside to one thread."""
    from threadpoolctl import threadpool_limits

    limits: contextlib.AbstractContextManager[object] = threadpool_limits(1, user_api="blas")
    return limits


def _failed(failures: Sequence[Outcome], tried: int) -> str:
    if len(failures) == 1 == tried:
        return str(failures[0].error)
    lines = "\n".join(f"  {failure.error}" for failure in failures[:10])
    more = f"\n  and {len(failures) - 10} more" if len(failures) > 10 else ""
    return f"{len(failures)} of {tried} solves failed, the others are stored:\n{lines}{more}"


def _refuse_too_large(jobs: Sequence[AnyJob], execution: Execution) -> None:
    limit = available_memory() if execution.memory is None else execution.memory
    largest = max(jobs, key=lambda job: predicted_cost(job).peak_bytes, default=None)
    if largest is not None and predicted_cost(largest).peak_bytes > limit:
        raise UsageError(too_large(largest, limit))
