"""Running a scene: check everything first, solve what is not stored yet, compare, write the results."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from fem_contact.errors import FemContactError
from validation.effects import check_effects
from validation.errors import RunFailed
from validation.jobs import Job, block_file, execute, jobs_of
from validation.store import Store, atomic_path, prepare_folder
from validation.surfaces import reference_field

if TYPE_CHECKING:
    from validation.comparison import Comparison
    from validation.scene import Scene

__all__ = ["Outputs", "Progress", "run_scene", "solve_jobs"]


class Progress(Protocol):
    """What a run tells the person who watches it."""

    def start(self, missing: tuple[Job, ...], stored: int) -> None:
        """Tell which jobs are to be done, and how many were found finished."""

    def begin(self, job: Job) -> None:
        """Tell that a job starts."""

    def done(self, job: Job) -> None:
        """Tell that a job is solved and stored."""


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


def run_scene(scene: Scene, folder: Path, *, progress: Progress | None = None) -> Outputs:
    """Run a scene into a folder; finished solves found there are used, not repeated.

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
    store = Store(folder=prepare_folder(folder / "solves"))
    jobs = jobs_of(scene)
    solved = solve_jobs(jobs, store, progress=progress)

    from validation.comparison import compare
    from validation.report import write_outputs

    comparison = compare(scene, store)
    files = write_outputs(comparison, store, folder)
    return Outputs(
        comparison=comparison, folder=folder, files=files, solved=solved, reused=len(jobs) - solved
    )


def solve_jobs(jobs: tuple[Job, ...], store: Store, *, progress: Progress | None = None) -> int:
    """Solve and store the jobs that are not stored yet; return how many that were.

    Each result is on disk before the next solve begins: an interruption loses at most the solve under way.
    """
    missing = tuple(job for job in jobs if not store.holds(job))
    if progress is not None:
        progress.start(missing, len(jobs) - len(missing))
    for job in missing:
        if progress is not None:
            progress.begin(job)
        with _named(job):
            solved = execute(job)
            solved.contact.checked()
        if solved.block is not None:
            from fem_contact.export import write_block

            with atomic_path(block_file(store.folder, job)) as draft:
                write_block(draft, solved.block)
        store.save(job, solved.contact)
        if progress is not None:
            progress.done(job)
    return len(missing)


@contextlib.contextmanager
def _named(job: Job) -> Iterator[None]:
    """Say which solve failed, in one line."""
    try:
        yield
    except FemContactError as error:
        raise RunFailed(f"{job.describe()}: {error}") from error
