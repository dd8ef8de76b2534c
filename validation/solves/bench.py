"""The bench that studies run on: solves many independent jobs, stores each, and hands the results back."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from validation.errors import RunFailed
from validation.files import prepare_folder
from validation.solves.running import Execution, Progress, Silent, solve_jobs
from validation.solves.solve import AnyJob
from validation.solves.store import Store

__all__ = ["DEFAULT_STORE", "Bench", "PlannedOnly", "Solves"]

#: Where studies keep their solves unless told otherwise: one folder for all of them, so that they share
#: cases.
DEFAULT_STORE = Path("results") / "solves"


class PlannedOnly(Exception):
    """Raised by a bench that only plans, in place of the first solve; carries the jobs."""

    def __init__(self, jobs: tuple[AnyJob, ...], store: Store) -> None:
        self.jobs, self.store = jobs, store
        super().__init__(f"{len(jobs)} solves planned")


@dataclass(frozen=True, kw_only=True, eq=False)
class Solves(Mapping[AnyJob, Any]):
    """Stored results by job, fields or numbers; each is read when asked for: thousands need no memory."""

    jobs: tuple[AnyJob, ...]
    store: Store

    def __getitem__(self, job: AnyJob) -> Any:
        """Read a result from the store."""
        result = self.store.load(job)
        if result is None:
            raise RunFailed(f"{job.describe()}: its result in {self.store.folder} vanished or was damaged")
        return result

    def __iter__(self) -> Iterator[AnyJob]:
        """Jobs in the order they were asked for."""
        return iter(self.jobs)

    def __len__(self) -> int:
        """Count the jobs."""
        return len(self.jobs)


@dataclass(frozen=True, kw_only=True)
class Bench:
    """A store and a way of running.

    Attributes
    ----------
    store : Store
        Finished solves; shared by studies, which then share cases.
    execution : Execution
        In the process, on local workers or on a cluster.
    progress : Progress
    plan_only : bool
        Solve nothing: `solve` raises `PlannedOnly` with the jobs.

    Examples
    --------
    ::

        bench = Bench.at("results/solves", execution=Execution(workers=2))
        results = bench.solve(jobs)
        areas = [results[job].in_contact.mean() for job in jobs]  # a job is the key of its result
    """

    store: Store
    execution: Execution = field(default_factory=Execution)
    progress: Progress = field(default_factory=Silent)
    plan_only: bool = False

    @classmethod
    def at(
        cls,
        folder: Path | str = DEFAULT_STORE,
        *,
        execution: Execution | None = None,
        progress: Progress | None = None,
    ) -> Bench:
        """Return a bench whose store is in a folder, created if need be."""
        store = Store(folder=prepare_folder(Path(folder), option="--store"))
        return cls(store=store, execution=execution or Execution(), progress=progress or Silent())

    def solve(self, jobs: Iterable[AnyJob]) -> Solves:
        """Solve what is not stored yet and return all results, a mapping whose keys are the jobs.

        Raises
        ------
        RunFailed
            When a solve fails; the others are stored.
        PlannedOnly
            From a bench that only plans.
        """
        unique = tuple({job.key: job for job in jobs}.values())
        if self.plan_only:
            raise PlannedOnly(unique, self.store)
        solve_jobs(unique, self.store, progress=self.progress, execution=self.execution)
        return Solves(jobs=unique, store=self.store)
