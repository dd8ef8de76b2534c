"""The bench that studies run on: solves many independent solves, stores each, and hands the results back."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from validation.execution.attempt import Progress
from validation.execution.provenance import Made
from validation.execution.running import Execution, Solves, solve_all
from validation.execution.solve import Solve
from validation.execution.store import Store

#: Where studies keep their solves unless told otherwise: one folder for all of them, so that they share
#: cases.
DEFAULT_STORE = Path("results") / "solves"


class PlannedOnly(Exception):
    """Raised by a bench that only plans, in place of the first solve; carries the solves."""

    def __init__(self, solves: tuple[Solve, ...], store: Store) -> None:
        self.solves, self.store = solves, store
        super().__init__(f"{len(solves)} solves planned")


@dataclass(frozen=True, kw_only=True)
class Bench:
    """A store, which studies share, and a way of running: in the process, on local workers or on a cluster.

    One that only plans solves nothing: `solve` raises `PlannedOnly` with the solves.

    ::

        bench = Bench.at("results/solves", execution=Execution(workers=2))
        results = bench.solve(solves)
        areas = [results[solve].in_contact.mean() for solve in solves]  # a solve is the key of its result
    """

    store: Store
    execution: Execution = field(default_factory=Execution)
    progress: Progress = field(default_factory=Progress)
    plan_only: bool = False
    _read: list[dict[str, Made]] = field(default_factory=list, init=False, repr=False, compare=False)

    @classmethod
    def at(cls, folder: Path | str = DEFAULT_STORE, **how: Any) -> Bench:
        """Return a bench whose store is in a folder, made by the first solve that is to be kept."""
        return cls(store=Store(folder=Path(folder)), **how)

    def solve(self, solves: Iterable[Solve], *, despite_failures: bool = False) -> Solves:
        """Solve what is not stored yet and return all results, a mapping whose keys are the solves.

        A RunFailed when a solve fails; the others are stored, and given `despite_failures`.
        """
        if self.plan_only:
            plan = tuple({solve.key: solve for solve in solves}.values())
            for solve in plan:
                solve.predict()  # refuses what has no cost, for it cannot be done
            raise PlannedOnly(plan, self.store)
        results = solve_all(
            solves,
            self.store,
            progress=self.progress,
            execution=self.execution,
            despite_failures=despite_failures,
        )
        self._read.append(results.how)
        return results

    def made(self) -> tuple[Made, ...]:
        """Return how each result was made that has been read from this bench, for `made_words`."""
        return tuple({key: made for read in self._read for key, made in read.items()}.values())
