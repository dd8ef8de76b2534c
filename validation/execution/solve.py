"""The unit of work: a recipe that determines a result, its name on disk, its cost, and how it is done."""

from __future__ import annotations

import hashlib
import json
from abc import ABC, abstractmethod
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fem_contact.settings import available_processors

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["LOCATED_EDGES", "RESULTS_VERSION", "NumbersSolve", "Prediction", "Solve"]

#: Raised when a change of the code changes results, so that stored ones are not mistaken for new ones.
RESULTS_VERSION = 2

#: How `fem_contact.area.EDGE_MAPS` locate edges of contact: in the recipe of every solve that keeps a located
#: area, since one whose edges were located otherwise is another one.
LOCATED_EDGES = "edges of second order, traits of contour and heights"


@dataclass(frozen=True, kw_only=True)
class Prediction:
    """Predicted cost of a solve: seconds, peak bytes, unknowns."""

    seconds: float
    peak_bytes: int
    unknowns: int


class Solve(ABC):
    """One unit of work; its result is kept under a name made from its recipe.

    Subclasses are frozen dataclasses of plain data, so that worker processes can be sent them. A solve is the
    key of its own result: ``bench.solve(solves)[solve]``.
    """

    @property
    @abstractmethod
    def recipe(self) -> dict[str, Any]:
        """Everything that determines the result, as JSON-ready data, and nothing else."""

    @property
    def kind(self) -> str:
        """Kind of work, in the name on disk."""
        return type(self).__name__

    @property
    @abstractmethod
    def prefix(self) -> str:
        """Readable start of the name on disk."""

    @abstractmethod
    def describe(self) -> str:
        """Return a few words for a progress bar."""

    @abstractmethod
    def predict(self, *, pair_seconds: float = 0.5e-3) -> Prediction:
        """Predict what it takes on one thread, storing included, beyond what an idle process takes.

        Machines differ by the time of one pair of real 256 x 256 transforms (`pair_seconds` [s]).
        """

    @abstractmethod
    def do(self, *, threads: int | None = None) -> Any:
        """Do it; does not touch the disk. All available processors are used if `threads` is not given."""

    @abstractmethod
    def encode(self, result: Any) -> memoryview:
        """Return a result as the bytes of a netCDF file; does not touch the disk."""

    @abstractmethod
    def decode(self, content: memoryview) -> Any:
        """Return the result of a netCDF file that is intact."""

    def written_beside(self, result: Any, folder: Path) -> None:  # noqa: B027
        """Write what belongs beside a result, such as a block to look at; nothing unless a subclass does."""

    @property
    def code_path(self) -> tuple[str, ...]:
        """What decides which compiled passes are run through; nothing to warm up if empty."""
        return ()

    def warm_up(self) -> None:  # noqa: B027
        """Run through the compiled passes once, so that no solve is charged with loading them."""

    def threads_used(self, threads: int | None) -> int:
        """Return how many threads `do` uses when it is given that many."""
        return available_processors() if threads is None else threads

    def after(self, previous: Solve | None) -> Solve:
        """Return this solve with what the previous one has made already, such as its surface."""
        return self

    @property
    def recipe_text(self) -> str:
        """Return recipe, kind and version as text: what is hashed, and what is stored beside the result."""
        return json.dumps(
            {"results_version": RESULTS_VERSION, "kind": self.kind, **self.recipe}, sort_keys=True
        )

    @property
    def key(self) -> str:
        """Name on disk: readable, then the hash of the recipe."""
        return f"{self.prefix}-{hashlib.sha256(self.recipe_text.encode()).hexdigest()[:16]}"


class NumbersSolve(Solve):
    """A solve of a study, whose result is a small dataset of numbers rather than fields."""

    @abstractmethod
    def measure(self) -> xr.Dataset:
        """Solve, and keep the numbers."""

    def do(self, *, threads: int | None = None) -> xr.Dataset:
        """Measure; such solves use one thread each, so that their numbers are the same everywhere."""
        return self.measure()

    def threads_used(self, threads: int | None) -> int:
        """One."""
        return 1

    def encode(self, result: xr.Dataset) -> memoryview:
        """Return the dataset as netCDF, with the recipe."""
        from validation.execution.netcdf import dataset_bytes

        return dataset_bytes(result.assign_attrs(recipe=self.recipe_text))

    def decode(self, content: memoryview) -> xr.Dataset:
        """Read the dataset."""
        from validation.execution.netcdf import read_dataset

        return read_dataset(content)
