"""A measurement: a function of plain arguments whose every call is a solve, stored under a digest of these.

::

    @measurement("leak-{size}", kind="LeakMeasurement", words="leak", seconds=lambda points: 2e-6 * points)
    def leaks(*, problem: ContactProblem, grid: Grid, areas: tuple[float, ...]) -> xr.Dataset: ...

    case = leaks(problem=first, grid=(64, 64), areas=(0.1,))  # nothing is measured yet
    numbers = bench.solve([case])[case]
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial, update_wrapper
from typing import TYPE_CHECKING, Any, Generic, ParamSpec, cast

from pydantic_core import to_jsonable_python

from validation.execution.solve import LOCATED_EDGES, PAIR_SECONDS, Compiled, Prediction, Solve
from validation.scenes.problem import ContactProblem

if TYPE_CHECKING:
    import xarray as xr

P = ParamSpec("P")


@dataclass(eq=False, kw_only=True)
class Measurement(Generic[P]):
    """A function that solves and keeps numbers; called, it gives the solve.

    Callables are given those of the arguments that they name, and ``points``, those of the finest grid.
    """

    #: Of hashable keyword arguments, to a dataset.
    function: Callable[P, xr.Dataset]
    #: How names on disk begin, and what it is in a progress bar; with arguments, and ``{size}``, in braces.
    name: str | Callable[..., str]
    words: str
    #: Of its results: with the arguments it determines the name on disk.
    kind: str
    #: Predicted time of a solve on one thread [s], bytes for each grid point; or a `Prediction` for both.
    seconds: Callable[..., float] = lambda: 0.0
    bytes: int = 0
    predict: Callable[..., Prediction] | None = None
    #: Whether it keeps a located area; the version of what is read off, in the recipe unless it is 0.
    located: bool = False
    version: int = 0
    #: Makes of the usual recipe, ``made``, that of this measurement; what it leaves out then.
    recipe: Callable[..., dict[str, Any]] = lambda made: made
    left_out: tuple[str, ...] = ()
    #: Methods whose compiled passes it runs through; plain boundary elements if not given.
    compiled: Callable[..., Compiled] = lambda: (("bem", {}, ()),)

    def __post_init__(self) -> None:
        update_wrapper(self, self.function)

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> Call:
        """Return the solve of these arguments."""
        bound = inspect.signature(self.function).bind(*args, **kwargs)
        bound.apply_defaults()
        return Call(measurement=self, arguments=tuple(bound.arguments.items()))

    def __reduce__(self) -> str:
        return str(self.__qualname__)  # type: ignore[attr-defined]


def measurement(name: Any, **about: Any) -> Callable[[Callable[P, xr.Dataset]], Measurement[P]]:
    """Make a `Measurement` of a function; see there for what is said about it."""
    return lambda function: Measurement(function=function, name=name, **about)


@dataclass(frozen=True, kw_only=True)
class Call(Solve):
    """A measurement with its arguments: the key of its own result."""

    measurement: Measurement[Any]
    arguments: tuple[tuple[str, Any], ...]

    def __getitem__(self, name: str) -> Any:
        return dict(self.arguments)[name]

    def but(self, **others: Any) -> Call:
        """Return the same with other arguments."""
        return self.measurement(**{**dict(self.arguments), **others})

    def do(self, *, threads: int | None = None) -> xr.Dataset:
        """Solve, and keep the numbers."""
        return self.measurement.function(**dict(self.arguments))

    @property
    def finest(self) -> tuple[int, ...]:
        """The finest of its grids."""
        given = dict(self.arguments)
        finest = max(given["grids"]) if "grids" in given else given.get("grid")
        return tuple(finest or 2 * (given["points"],))

    @property
    def recipe(self) -> dict[str, Any]:
        """What is pressed, and every other argument that is not None, as JSON has it."""
        entries: dict[str, Any] = {}
        for name, value in self.arguments:
            if isinstance(value, ContactProblem):
                entries |= value.recipe
            elif name == "grid":
                entries["points"] = value[0] if value[0] == value[1] else list(value)
            elif value is not None:
                plain = to_jsonable_python(value, exclude_none=True)
                entries[name] = dict(value) if name == "settings" else plain
        entries |= {"edges": LOCATED_EDGES} if self.measurement.located else {}
        entries |= {"version": self.measurement.version} if self.measurement.version else {}
        entries = self._evaluated(self.measurement.recipe, made=entries)
        return {name: value for name, value in entries.items() if name not in self.measurement.left_out}

    @property
    def kind(self) -> str:
        """That of the measurement."""
        return self.measurement.kind

    @property
    def prefix(self) -> str:
        """Readable start of the name on disk."""
        return self._formatted(self.measurement.name)

    def describe(self) -> str:
        """Return a few words for a progress bar."""
        text = f"{self._formatted(self.measurement.words)} {'x'.join(map(str, self.finest))}"
        problem = dict(self.arguments).get("problem")
        if problem is None:
            return text
        hurst = getattr(problem.surface, "hurst", None)
        kind = "" if hurst is None else f"H = {hurst:g}, "
        kind += f"nu = {problem.solid.poisson:g}"
        return f"{text}, {kind}, surface {problem.realisation + 1}{' (-h)' if problem.inverted else ''}"

    def predict(self, *, pair_seconds: float = PAIR_SECONDS) -> Prediction:
        """Predict from the number of points, or as the measurement says."""
        about, points = self.measurement, math.prod(self.finest)
        evaluated = partial(self._evaluated, points=points, pair_seconds=pair_seconds)
        if about.predict is not None:
            return cast("Prediction", evaluated(about.predict))
        return Prediction(seconds=evaluated(about.seconds), peak_bytes=about.bytes * points, unknowns=points)

    @cached_property
    def compiled(self) -> Compiled:
        """As the measurement says."""
        return cast("Compiled", self._evaluated(self.measurement.compiled))

    def _evaluated(self, of: Callable[..., Any], **more: Any) -> Any:
        known = {**dict(self.arguments), **more}
        return of(**{name: known[name] for name in inspect.signature(of).parameters})

    def _formatted(self, text: str | Callable[..., str]) -> str:
        if not isinstance(text, str):
            return str(self._evaluated(text))
        square = len(set(self.finest)) == 1 and "grids" not in dict(self.arguments)
        size = "x".join(map(str, self.finest[:1] if square else self.finest))
        return text.format(size=size, **dict(self.arguments))
