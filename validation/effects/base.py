"""What an effect is: a table of a scene, the slot of a solver it fills, and how to judge it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self

from fem_contact.response import HalfSpace, Response
from fem_contact.solid import Solid
from fem_contact.surface import HeightField
from validation.arrays import Array, Grid
from validation.units import Table

if TYPE_CHECKING:
    from fem_contact.adhesion import GapLaw
    from fem_contact.hardness import Hardness
    from validation.scenes.problem import ContactProblem

SlotName = Literal["response", "pressure bound", "gap law", "spectrum", "boundary"]


@dataclass(frozen=True, kw_only=True)
class Body:
    """The solid as a body of finite depth, for methods that mesh it.

    Its base is clamped at `depth` [m], None where no effect says it; E(x, y, z) is `modulus`, which must be
    picklable, times that of the solid.
    """

    depth: float | None = None
    modulus: Callable[[Array, Array, Array], Array] | None = None


@dataclass(kw_only=True)
class ContactModel:
    """What solvers ask for and effects fill in; a slot that no effect fills is None.

    `response` gives displacement from pressure, that of the half-space of the solid if None, and `body` the
    same for methods that mesh; `pressure_bound` is the largest pressure [Pa], and `patch_hardness` one that
    depends on the size of patches; `gap_law` attracts.
    """

    solid: Solid
    response: Response | None = None
    body: Body | None = None
    pressure_bound: float | None = None
    patch_hardness: Hardness | None = None
    gap_law: GapLaw | None = None

    @classmethod
    def filled(cls, solid: Solid, effects: Sequence[Effect]) -> ContactModel:
        """Return the model as the effects of a scene fill them."""
        model = cls(solid=solid)
        for effect in effects:
            effect.fill(model)
        return model

    @property
    def felt_response(self) -> Response:
        """Return the response; that of the half-space if no effect changes it."""
        return HalfSpace(solid=self.solid) if self.response is None else self.response


@dataclass(kw_only=True)
class TheoryInputs:
    """What Persson's theory is told beyond an elastic half-space; None where no effect says it.

    `modulus` is E* [Pa] that a wave of wavevector q [1/m] feels, `hardness` the largest pressure [Pa], or a
    function of q, `work` that of adhesion [J/m^2], `smoothing` the arguments of an earlier squeezing.
    """

    solid: Solid
    modulus: Callable[[Any], Array] | None = None
    hardness: float | Callable[[Array], Array] | None = None
    work: float | None = None
    smoothing: Mapping[str, Any] | None = None

    @classmethod
    def by(cls, solid: Solid, effects: Sequence[Effect]) -> TheoryInputs:
        """Return what the effects of a scene tell the theory."""
        inputs = cls(solid=solid)
        for effect in effects:
            effect.theory(inputs)
        return inputs

    @property
    def felt_modulus(self) -> float | Callable[[Any], Array]:
        """E* [Pa], or what each wave feels."""
        return self.solid.contact_modulus if self.modulus is None else self.modulus


@dataclass(frozen=True, kw_only=True)
class Judgement:
    """A dimensionless number in words, with its source, and what follows from it for an effect.

    The verdict begins with "negligible", "matters" or "unknown without".
    """

    effect: str
    number: str
    verdict: str

    @property
    def negligible(self) -> bool:
        """Whether the effect may be left out."""
        return self.verdict.startswith("negligible")


@dataclass(frozen=True, kw_only=True)
class Roughness:
    """What the judgements need to know of a scene.

    E* [Pa], h'_rms, the rms curvature of a profile sqrt(3 m4 / 8) [1/m], the longest and shortest wavelength
    [m], and the elastic energy per area at full contact [J/m^2].
    """

    modulus: float
    gradient: float
    curvature: float
    longest: float
    shortest: float
    full_energy: float


def full_contact_energy(surface: HeightField, *, modulus: float) -> float:
    """Elastic energy per area of a half-space that follows the whole surface, (E*/4) sum q |h(q)|^2 [J/m^2].

    Examples
    --------
    >>> import numpy as np
    >>> x = np.arange(16) / 16
    >>> wave = HeightField(heights=np.cos(2 * np.pi * x)[:, None] * np.ones(4), lengths=(1.0, 0.25))
    >>> round(full_contact_energy(wave, modulus=8.0) / (2 * np.pi), 12)
    1.0
    """
    return surface.spectral_sum(lambda q: 0.25 * modulus * q)


class Effect(Table):
    """A physical effect beyond linear elastic contact of a half-space; a subclass is one file.

    Its fields are its table in the scene, with units. A scene that does not list it never touches it.
    """

    kind: str
    slot: ClassVar[SlotName]  # The slot of a solver that it fills
    meshed: ClassVar[bool] = True  # Whether a method that meshes the solid can be given it
    #: Processor time of a boundary-element solve with it over that of a plain one, on the reference machine,
    #: and contacts that are solved until one is pressed, beyond what that measures.
    cost: ClassVar[float] = 1.0
    solves: ClassVar[float] = 1.0
    papers: ClassVar[tuple[str, ...]] = ()  # What to cite
    since: ClassVar[str] = ""  # Day since when it is solved otherwise: solves of before are not found again

    def fill(self, model: ContactModel) -> None:
        """Fill the slot that solvers ask for."""

    def shaped(self, field: HeightField) -> HeightField:
        """Return the heights that are pressed, of those of the surface."""
        return field

    def theory(self, inputs: TheoryInputs) -> None:
        """Tell Persson's theory; an effect that does not override this has none there."""

    def check(self, problem: ContactProblem, grids: Sequence[Grid], *, model: ContactModel, key: str) -> None:
        """Refuse, with a UsageError and before anything is computed, what does not fit the load or the grids.

        The grids are all of methods to which it gives its slot, the model as all effects fill it; where the
        theory stands alone there are none. Messages name the effect by `key`.
        """

    def check_solver(self, name: str, *, key: str) -> None:
        """Refuse, as it stands and with a UsageError, a solver that could be given others of its kind."""

    def judge(self, rough: Roughness) -> Judgement:
        """Say by a number whether it matters on a rough surface."""
        raise NotImplementedError

    @classmethod
    def unlisted(cls, rough: Roughness) -> Judgement | None:
        """Say what would decide whether it may be left out; None if nothing need be said."""
        return None

    @classmethod
    def example(cls, spacing: float) -> Self:
        """Return one that matters where E* = 1 and h'_rms = 0.1, on waves of 1/4 to 1/32.

        It warms up the compiled passes, measures the cost, and stands in docs and tests.
        """
        raise NotImplementedError

    @classmethod
    def kind_name(cls) -> str:
        """Return the word by which a scene lists it."""
        return str(cls.model_fields["kind"].annotation.__args__[0])  # type: ignore[union-attr]

    @classmethod
    def has_theory(cls) -> bool:
        """Whether Persson's theory knows it."""
        return cls.theory is not Effect.theory

    def judgement(self, number: str, *, matters: bool) -> Judgement:
        """Return a judgement of this effect."""
        return Judgement(effect=self.kind, number=number, verdict="matters" if matters else "negligible")

    @classmethod
    def unknown(cls, number: str, without: str) -> Judgement:
        """Return the judgement of an effect that is not listed."""
        return Judgement(effect=cls.kind_name(), number=number, verdict=f"unknown without {without}")


def effect_key(index: int, key: str) -> str:
    """How a message names a key of an effect: counted from one, as a reader of the file counts.

    >>> effect_key(0, "hardness")
    '[[effects]] 1 hardness'
    """
    return f"[[effects]] {index + 1} {key}".rstrip()


def __getattr__(name: str) -> object:
    new = {"Slots": "ContactModel", "Told": "TheoryInputs"}.get(name)
    if new is not None:
        raise ImportError(f"validation.effects.base.{name} is called {new}")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
