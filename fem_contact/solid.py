"""Elastic solids: isotropic and homogeneous; thickness and grading are effects of the response."""

from dataclasses import dataclass

from fem_contact._checks import instance, poisson_ratio, positive


@dataclass(frozen=True, kw_only=True)
class Solid:
    """A homogeneous, isotropic, linear elastic solid.

    Parameters
    ----------
    young : float
        Young's modulus E [Pa], positive.
    poisson : float
        Poisson ratio nu, in (-1, 0.5].

    Raises
    ------
    InvalidInput
        For a modulus or Poisson ratio outside its range.

    Examples
    --------
    >>> Solid(young=1e6, poisson=0.5).contact_modulus
    1333333.3333333333
    """

    young: float
    poisson: float

    def __post_init__(self) -> None:
        positive("young", self.young)
        poisson_ratio(self.poisson)

    @property
    def contact_modulus(self) -> float:
        """E* = E / (1 - nu^2) [Pa]."""
        return self.young / (1 - self.poisson**2)

    @property
    def shear_modulus(self) -> float:
        """G = E / (2 (1 + nu)) [Pa]."""
        return self.young / (2 * (1 + self.poisson))


def composite_modulus(first: Solid, second: Solid) -> float:
    """Contact modulus of two elastic solids pressed together.

    Returns E* [Pa] with 1/E* = (1 - nu_1^2)/E_1 + (1 - nu_2^2)/E_2 (Persson 2006, Eq. 5). The pair is then
    equivalent to a rigid body carrying the sum of both roughnesses on an elastic half-space of that modulus.

    Examples
    --------
    >>> steel = Solid(young=200e9, poisson=0.3)
    >>> composite_modulus(steel, steel) == steel.contact_modulus / 2
    True
    """
    instance("first", first, Solid)
    instance("second", second, Solid)
    return 1 / (1 / first.contact_modulus + 1 / second.contact_modulus)
