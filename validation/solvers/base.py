"""What a method is: its table in a scene, the slots it can be given, its cost, and how it solves."""

from __future__ import annotations

import dataclasses
import math
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, StrictBool

from fem_contact import contact
from fem_contact.area import EDGE_CONSTANTS, discretisation
from fem_contact.contact import ContactResult, Status
from fem_contact.response import Response
from fem_contact.solid import Solid
from fem_contact.surface import HeightField
from validation.arrays import Grid
from validation.effects.base import ContactModel, Effect, SlotName, effect_key
from validation.errors import UsageError
from validation.units import Grids, Length, Number, Table, key

if TYPE_CHECKING:
    from validation.scenes.problem import ContactProblem

#: What a solve costs whatever its grid, in pairs of real 256 x 256 transforms on one thread, and bytes.
_FIXED_PAIRS, _FIXED_BYTES = 26.0, 3 * 2**19

Shift = tuple[float, float]
#: What a solver was told beyond surface, load and model; only what was said, so that it is its own recipe.
Settings = tuple[tuple[str, float | str], ...]


class Gridded(Table):
    """Options of every method that solves on grids."""

    grids: Annotated[Grids, Field(min_length=1)] = key(
        "surface points, e.g. [32, 64]; default: 4, 8 and 16 on the shortest wave, as affordable"
    )
    tolerance: Number = key(
        "complementarity sum p |g| / (h_rms sum p) of the solution, e.g. 1e-6; penetration, "
        "tension and load are within ten times that",
        1e-8,
        gt=0,
        lt=1e-2,
    )
    under_resolved: StrictBool = key("run grids with lambda_short <= 2 dx, labelled", False)


class Blocks(Gridded):
    """Options of every method whose body is a block of finite elements."""

    depth: Length | None = key("depth of the block; default: the longer period", None)
    growth: Number = key("ratio of the thicknesses of successive layers", 1.2, ge=1, le=4)


@dataclass(frozen=True, kw_only=True, eq=False)
class Job:
    """What a solver is asked."""

    field: HeightField  # The surface [m]
    #: One of ``{"mean_pressure": p0}`` [Pa], ``{"mean_gap": d}`` and ``{"offset": d}`` [m].
    load: Mapping[str, float]
    model: ContactModel  # The solid and what effects filled in
    #: What else it is told, such as its tolerance.
    settings: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    threads: int | None = None  # All that there are if None

    @property
    def mean_pressure(self) -> float:
        """The load [Pa].

        A UsageError where a distance is to be held, which the solver that asks cannot.
        """
        if "mean_pressure" not in self.load:
            raise UsageError(f"load: the solver presses with a load, and holds no {' or '.join(self.load)}")
        return self.load["mean_pressure"]


@dataclass(frozen=True, kw_only=True)
class Size:
    """What the cost of a solve is predicted from."""

    grid: Grid
    lengths: tuple[float, float]  # Periods [m]
    settings: Mapping[str, Any]  # What the solver is told
    effects: Sequence[Effect] = ()
    dearer: float = 1.0  # What the effects make of the time of boundary elements

    @property
    def points(self) -> int:
        """Number of grid points."""
        return self.grid[0] * self.grid[1]

    @property
    def transforms(self) -> float:
        """Cost of a pair of transforms on the grid over that on 256 x 256 points."""
        return self.points * math.log2(max(self.points, 2)) / (256**2 * 16)

    def cost(self, pairs: float, peak_bytes: float, unknowns: int | None = None) -> Cost:
        """Return the cost of a solve, with what any costs: surface, set-up, storing."""
        pairs, peak_bytes = _FIXED_PAIRS + pairs, _FIXED_BYTES + int(peak_bytes)
        return Cost(pairs=pairs, peak_bytes=peak_bytes, unknowns=unknowns or self.points)


@dataclass(frozen=True, kw_only=True)
class Cost:
    """What a solve takes."""

    pairs: float  # Time in pairs of real 256 x 256 transforms on one thread
    peak_bytes: int
    unknowns: int


@dataclass(frozen=True, kw_only=True)
class Solved:
    """Result of one solve, and the block it came from where there is one to export."""

    contact: ContactResult
    block: Any = None


@dataclass(frozen=True, kw_only=True, eq=False)
class Claim:
    """What a solver says, before anybody judges it."""

    pressure: NDArray[np.float64]  # [Pa], compression positive
    in_contact: NDArray[np.bool_] | None = None  # Its contact set; None where it names none
    cost: contact.Cost  # What it took; 0 iterations where it does not say
    converged: bool | None = None  # Whether it says that it met its tolerance; None where it says nothing


class Method(ABC):
    """A way to answer a scene: its table ``[methods.NAME]``, and what it can be given."""

    name: ClassVar[str]  # By which a scene lists it, and what tables call it
    label: ClassVar[str]
    options: ClassVar[type[Table]]  # Its table in a scene
    independent: ClassVar[bool] = False  # Whether it shares no contact algorithm with `bem`
    papers: ClassVar[tuple[str, ...]] = ()  # What to cite

    def available(self) -> str | None:
        """Return the sentence that says what to install; None where nothing is missing."""
        return None

    @abstractmethod
    def handles(self, effect: type[Effect]) -> bool:
        """Whether the method can be given an effect of that kind."""

    def cited(self, effects: Sequence[Effect]) -> tuple[str, ...]:
        """Return the papers to cite for it with these effects."""
        return self.papers

    def check(self, options: Any, problem: ContactProblem, effects: Sequence[Effect]) -> None:  # noqa: B027
        """Refuse, before anything is computed, what it cannot do."""

    def facts(self, options: Any, problem: ContactProblem) -> Iterator[tuple[str, str]]:
        """Yield what a reader of `explain` should know of it: name and words."""
        yield from ()


def in_slot(slot: SlotName, effects: Sequence[Effect]) -> str:
    """Return how a scene has the effect that fills a slot, such as [[effects]] 1 kind = 'x'; or ""."""
    named = (f"{effect_key(k, 'kind')} = {e.kind!r}" for k, e in enumerate(effects) if e.slot == slot)
    return next(named, "")


class Solver(Method):
    """A method that presses a surface on a grid."""

    #: What effects may fill; a scene that lists another is refused by name.
    slots: ClassVar[frozenset[SlotName]] = frozenset()
    #: Whether the place of an edge inside a cell is known for the bare half-space on square cells.
    locates_edges: ClassVar[bool] = False
    for_ensembles: ClassVar[bool] = False  # Whether it is quick enough for the realisations of an ensemble
    foreign: ClassVar[bool] = False  # Whether it was written elsewhere; such ones stand after the others
    #: Distances of the table of loads that it can hold in place of a load.
    holds: ClassVar[frozenset[str]] = frozenset()
    #: Whether its body, clamped below, is pressed together as a whole under its load.
    sinks: ClassVar[bool] = False
    #: What its scorecard may tell it beside the load: "offset" [m] in its place, "max_iterations".
    controls: ClassVar[frozenset[str]] = frozenset()
    score_points: ClassVar[int] = 32  # Points along a side of the coarsest grid of its scorecard
    #: What the edges of its contacts are those of there: "bem", or a finite element.
    score_element: ClassVar[str] = "bem"
    setting_keys: ClassVar[tuple[str, ...]] = ("tolerance",)  # Keys of its table that are settings of a solve

    def handles(self, effect: type[Effect]) -> bool:
        """Whether the slot of the effect is one of its own."""
        return effect.slot in self.slots

    def check_bodies(
        self, problem: ContactProblem, effects: Sequence[Effect], *, depth: float | None = None
    ) -> None:
        """Refuse an effect that makes the solid something else than a body on a clamped base.

        `depth` [m] is what the options of the method say of it.
        """
        layered = in_slot("response", effects)
        if not layered:
            return
        body = ContactModel.filled(problem.elastic, effects).body
        if body is None:
            raise UsageError(
                f"{layered}: as it stands it is no body on a clamped base, which is what method "
                f"{self.name!r} solves; change it, or leave [methods.{self.name}] out"
            )
        if body.depth is not None and depth is not None:
            raise UsageError(f"methods.{self.name}.depth: {layered} says the depth; leave one of them out")

    def places(self, options: Any) -> Iterator[tuple[Grid, Shift]]:
        """Yield the grids and sub-grid shifts that a scene asks for, coarse grids first."""
        for grid in sorted(options.grids):
            yield grid, (0.0, 0.0)

    def settings(self, options: Any) -> Settings:
        """Return what a solve is told, of what the scene's table says."""
        values = ((name, getattr(options, name)) for name in self.setting_keys)
        return tuple((name, value) for name, value in values if value is not None)

    @abstractmethod
    def cost(self, size: Size) -> Cost:
        """Predict what a solve takes."""

    @abstractmethod
    def solve(self, job: Job) -> Solved:
        """Press a surface with the load, or to the distance, that is asked for."""

    def pressed(
        self, field: HeightField, model: ContactModel, pressure: float, **settings: Any
    ) -> ContactResult:
        """Return what it makes of a surface under a mean pressure [Pa], on one thread."""
        load = {"mean_pressure": pressure}
        return self.solve(Job(field=field, load=load, model=model, settings=settings, threads=1)).contact

    def felt(self, job: Job) -> Response:
        """Return the response by which displacements follow from its pressures at the points of a surface."""
        return job.model.felt_response

    def controlled(self, settings: Mapping[str, Any]) -> frozenset[str]:
        """Return which of `controls` it takes as it is set."""
        return self.controls

    def claim(self, job: Job) -> Claim:
        """Return what it says, unjudged; `settings` and `load` may have what `controls` names."""
        contact = self.solve(job).contact
        return Claim(
            pressure=contact.pressure,
            in_contact=contact.in_contact,
            cost=contact.cost,
            converged=contact.status is Status.CONVERGED,
        )

    def score_settings(self, points: int) -> dict[str, float | str]:
        """Return what its scorecard tells it on a grid, so that refining the grid refines all of it."""
        return {}

    def warm_up(self, effects: Sequence[Effect], settings: Mapping[str, Any]) -> None:
        """Run through the compiled passes once, so that no solve is charged with loading them."""

    def edge_constant(self, result: ContactResult) -> float:
        """Edge constant of the perimeter correction of a result: that of the discretisation it names."""
        return EDGE_CONSTANTS[discretisation(result)]

    def variant(self, settings: Mapping[str, Any]) -> str:
        """Name the compiled passes that the settings choose."""
        return ""


def example_field(points: int) -> HeightField:
    """Return waves of gradient 0.1 on which the examples of effects matter."""
    x = np.arange(points) / points
    waves = np.zeros(points)
    for k in (4, 8, 16, 32):
        waves += np.cos(2 * np.pi * k * x + k) / k**1.8 if 2 * k < points else 0
    heights = waves[:, None] + np.roll(waves, 3)[None, :]
    rough = HeightField(heights=heights, lengths=(1.0, 1.0))
    return HeightField(heights=heights * (0.1 / rough.rms_gradient), lengths=(1.0, 1.0))


def example_job(points: int, effects: Sequence[Effect] = (), **settings: Any) -> Job:
    """Return a job on these waves, with examples of the kinds of effects."""
    examples = [type(effect).example(1 / points) for effect in effects]
    model = ContactModel.filled(Solid(young=1.0, poisson=0.0), examples)
    return Job(field=example_field(points), load={"mean_pressure": 0.02}, model=model, settings=settings)
