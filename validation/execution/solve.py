"""The unit of work: a recipe that determines a result, its name on disk, its cost, and how it is done."""

from __future__ import annotations

import hashlib
import json
import math
import timeit
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from validation.effects import effect_kinds
from validation.effects.base import Effect
from validation.errors import UsageError
from validation.netcdf import dataset_bytes, read_dataset
from validation.solvers import find_solver

#: A method, its settings and the effects that it is to be warmed up with.
Compiled = tuple[tuple[str, Mapping[str, Any], tuple[Any, ...]], ...]

#: Raised when a change of the code changes results, so that stored ones are not mistaken for new ones.
RESULTS_VERSION = 2

#: How `fem_contact.area.EDGE_MAPS` locate edges of contact: in the recipe of every solve that keeps a located
#: area, since one whose edges were located otherwise is another one.
LOCATED_EDGES = "edges of second order, traits of contour and heights"

#: Seconds of a pair of real 256 x 256 transforms unless the machine was asked.
PAIR_SECONDS = 0.5e-3


@dataclass(frozen=True, kw_only=True)
class Prediction:
    """Predicted cost of a solve: seconds, peak bytes, unknowns."""

    seconds: float
    peak_bytes: int
    unknowns: int


class Solve(ABC):
    """One unit of work; its result, a dataset of numbers as a rule, has a name on disk made from its recipe.

    Subclasses are frozen dataclasses of plain data, so that worker processes can be sent them. A solve is the
    key of its own result: ``bench.solve(solves)[solve]``.
    """

    #: Whether its result is that of all the threads it is given; of numbers one is used.
    threaded: ClassVar[bool] = False

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
    def predict(self, *, pair_seconds: float = PAIR_SECONDS) -> Prediction:
        """Predict what it takes on one thread, storing included, beyond what an idle process takes.

        Machines differ by the time of one pair of real 256 x 256 transforms (`pair_seconds` [s]).
        """

    @abstractmethod
    def do(self, *, threads: int | None = None) -> Any:
        """Do it; does not touch the disk. All available processors are used if `threads` is not given.

        Numbers are solved for on one thread each, so that they are the same everywhere.
        """

    def encode(self, result: Any) -> memoryview:
        """Return a result as the bytes of a netCDF file; does not touch the disk."""
        return dataset_bytes(result.assign_attrs(recipe=self.recipe_text))

    def decode(self, content: memoryview) -> Any:
        """Return the result of a netCDF file that is intact."""
        return read_dataset(content)

    def written_beside(self, result: Any, folder: Path) -> None:  # noqa: B027
        """Write what belongs beside a result, such as a block to look at; nothing unless a subclass does."""

    @property
    def compiled(self) -> Compiled:
        """Methods whose compiled passes it runs through."""
        return ()

    def warm_up(self, warm: set[tuple[str, ...]]) -> None:
        """Run through compiled passes that are not `warm`, so that no solve is charged with loading them."""
        for method, settings, effects in self.compiled:
            solver = find_solver(method)
            path = (method, solver.variant(settings), *sorted(effect.kind for effect in effects))
            if path not in warm:
                solver.warm_up(effects, settings)
                warm.add(path)

    def after(self, previous: Solve | None) -> Solve:
        """Return this solve with what the previous one has made already, such as its surface."""
        return self

    @property
    def recipe_text(self) -> str:
        """Return recipe, kind and version as text: what is hashed, and what is stored beside the result."""
        told = {"results_version": RESULTS_VERSION, "kind": self.kind, **self.recipe}
        known, kinds = effect_kinds(), (effect["kind"] for effect in told.get("effects", ()))
        if since := {kind: known[kind].since for kind in kinds if known[kind].since}:
            told["since"] = since
        return json.dumps(told, sort_keys=True)

    @cached_property
    def key(self) -> str:
        """Name on disk: readable, then the hash of the recipe."""
        return f"{self.prefix}-{hashlib.sha256(self.recipe_text.encode()).hexdigest()[:16]}"


def check_memory(solves: Iterable[Solve], limit: float, *, where: str = "here") -> None:
    """Refuse solves of which the largest is predicted to take more than so many bytes, by a UsageError."""
    largest = max(solves, key=lambda solve: solve.predict().peak_bytes)
    needed = largest.predict().peak_bytes
    if needed > limit:
        raise UsageError(
            f"{largest.describe()}: needs about {memory_words(needed)} and {where} {memory_words(limit)} are "
            "free for it; leave the grid out, run it on a larger machine, or raise the limit with --memory"
        )


def memory_words(size: float) -> str:
    """Return an amount of memory in words.

    >>> memory_words(3 * 2**20), memory_words(2**30), memory_words(2.5 * 2**30)
    ('3 MiB', '1 GiB', '2.5 GiB')
    """
    return f"{size / 2**30:.3g} GiB" if size >= 2**30 else f"{size / 2**20:.3g} MiB"


def transform_seconds() -> float:
    """Median time of a pair of real 256 x 256 transforms on this machine, on one thread [s]."""
    from scipy.fft import irfft2, rfft2

    field = np.random.default_rng(5).random((256, 256))
    return sorted(timeit.repeat(lambda: irfft2(rfft2(field), s=field.shape), number=1, repeat=5))[2]


def dearer_by(effects: Sequence[Effect]) -> float:
    """Time of a boundary-element solve with effects over that of a plain one, on this machine."""
    if not effects:
        return 1.0
    from validation.execution.calibration import effect_costs

    factors = effect_costs().factors
    return math.prod(factors[effect.kind] * effect.solves for effect in effects)
