"""What a theory is: functions of pressure and roughness, of which it has the area and may have others."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar, Self

from persson.spectrum import Moments, Spectrum
from validation.arrays import Array
from validation.measurements.theory import Waves
from validation.scenes.problem import ContactProblem


@dataclass(frozen=True, kw_only=True, eq=False)
class Rough:
    """What a theory is told of a surface and the solid that it is pressed on."""

    contact_modulus: float  # E* [Pa]
    moments: Moments  # m0 [m^2], m2 [-] and m4 [1/m^2] of the realised surface
    spectrum: Spectrum | None  # C(q) [m^4] that it was drawn from; None where nobody knows it
    waves: Waves  # Of the realised surface, in units of E*

    @classmethod
    def of(cls, problem: ContactProblem) -> Self:
        """Return what is told of a surface."""
        m0, m2, m4 = problem.field.moments
        return cls(
            contact_modulus=problem.contact_modulus,
            moments=Moments(m0=m0, m2=m2, m4=m4),
            spectrum=problem.spectrum,
            waves=Waves.of_field(problem.field),
        )


class Theory(ABC):
    """A theory of the elastic contact of rough surfaces; a subclass is found by its class.

    Pressures are nominal, rising, of shape (n,) [Pa]. Where a theory says nothing of a pressure, NaN.
    """

    name: ClassVar[str]  # By which it is asked for, and what tables call it
    label: str
    papers: ClassVar[tuple[str, ...]] = ()  # What to cite

    @abstractmethod
    def area(self, pressure: Array, rough: Rough) -> Array:
        """Return A/A0, (n,)."""

    def pressure_distribution(self, stress: Array, pressure: float, rough: Rough) -> Array | None:
        """Return P(sigma) [1/Pa] per nominal area at stresses (m,) [Pa]; None where it has none."""
        return None

    def mean_gap(self, pressure: Array, rough: Rough) -> Array | None:
        """Return the mean gap [m], (n,); None where it has none."""
        return None

    def elastic_energy(self, pressure: Array, rough: Rough) -> Array | None:
        """Return the elastic energy per nominal area [J/m^2], (n,); None where it has none."""
        return None
