"""How a contact answers a small further approach while its contact set stays: stiffness and conductance."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fem_contact._checks import positive, samples
from fem_contact._types import Array, Mask
from fem_contact.complementarity import FourierOperator, FreeOperator, operator_of
from fem_contact.contact import ContactResult, check_result
from fem_contact.errors import InvalidInput, NotConverged, UnsupportedEffect
from fem_contact.response import Response, check_response
from fem_contact.settings import Settings


@dataclass(frozen=True, kw_only=True, eq=False)
class FrozenContact:
    """Answer of a contact to a small approach, with the contact set held fixed.

    Attributes
    ----------
    stiffness : float
        K = d p0 / d(approach) [Pa/m].
    pressure : (nx, ny) array
        dp / d(approach) [Pa/m], zero outside the contact set; its mean is K. Times the approach it is the
        field of flux through the spots, too.
    steps : int
        Steps of the conjugate gradients; each costs two pairs of Fourier transforms.
    residual : float
        Largest relative deviation of the displacement of the contact set from the approach.
    """

    stiffness: float
    pressure: Array
    steps: int
    residual: float


def frozen_contact(
    result: ContactResult,
    response: Response,
    *,
    tolerance: float = 1e-9,
    max_iterations: int = 10_000,
    threads: int | None = None,
) -> FrozenContact:
    r"""Press a contact a little further while its contact set stays.

    .. math:: \Delta p = 0 \text{ outside the contact set}, \qquad
              (S\,\Delta p)(x) = \Delta d \text{ inside it}, \qquad K = \overline{\Delta p} / \Delta d

    This is the exact derivative of the load by the approach, since a frictionless contact changes its area
    only in the second order. Points at a pressure bound give way and carry nothing more.

    Parameters
    ----------
    result : ContactResult
        Of the boundary elements, or of finite elements whose surface nodes all weigh alike.
    response : Response
        The solid, such as `HalfSpace`.
    tolerance : float
        Largest relative deviation of the displacement from the approach; at most 0.1.
    max_iterations : int
        Steps of the conjugate gradients allowed.
    threads : int, optional
        Of each transform; all available processors if not given.

    Raises
    ------
    InvalidInput
        Where nothing touches; where everything does, since a half-space in full contact cannot approach.
    UnsupportedEffect
        For a result whose nodes weigh differently.
    NotConverged
        When the steps do not suffice.

    Notes
    -----
    J. R. Barber, Proc. R. Soc. A 459, 53 (2003): the same problem as that of the flux through the spots.

    Examples
    --------
    >>> from fem_contact import HalfSpace, HeightField, Solid, bem
    >>> x = np.arange(64) / 64
    >>> wave = HeightField(heights=1e-3 * np.cos(2 * np.pi * x)[:, None] * np.ones(64), lengths=(1.0, 1.0))
    >>> solid = HalfSpace(solid=Solid(young=1.0, poisson=0.0))
    >>> frozen = frozen_contact(bem.solve(wave, solid, mean_pressure=5e-4), solid)
    >>> bool(frozen.residual < 1e-9)
    True
    """
    check_result("result", result)
    check_response(response)
    settings = Settings(tolerance=tolerance, max_iterations=max_iterations, threads=threads)
    if result.weights is not None:
        raise UnsupportedEffect(
            "result: its nodes weigh differently (quadratic elements); use boundary or trilinear elements"
        )
    moving = result.in_contact & ~result.at_bound
    if not moving.any():
        raise InvalidInput(
            "result: nothing touches, or all that does is at its pressure bound: there is no stiffness"
        )
    operator = operator_of(response, result.shape, result.lengths, threads=settings.threads)
    if moving.all() and operator.compliance[0, 0] == 0:
        raise InvalidInput(
            "result: full contact of a half-space cannot approach further: its stiffness is infinite"
        )
    return _solved(operator, moving, settings)


def _solved(operator: FourierOperator | FreeOperator, moving: Mask, settings: Settings) -> FrozenContact:
    """Conjugate gradients for a unit displacement of the contact set."""
    from scipy.sparse.linalg import LinearOperator, cg

    field, answer = np.zeros(operator.shape), np.empty(operator.shape)
    count, steps = int(np.count_nonzero(moving)), 0

    def spread(values: Array) -> Array:
        field[moving] = values
        return field

    def displaced(values: Array) -> Array:
        operator.apply(spread(values), answer)
        return answer[moving]

    def preconditioned(values: Array) -> Array:
        operator.precondition(spread(values), answer)
        # It leaves out the mean, which is given the stiffness of the softest wave.
        return np.asarray(answer[moving] + longest * values.mean())

    def counted(_: Array) -> None:
        nonlocal steps
        steps += 1

    longest = 1 / float(np.max(operator.compliance))
    target, shape = np.ones(count), (count, count)
    pressure = np.zeros(count)
    # The solver stops on the mean square; the largest deviation is asked for, and looked at.
    aim, worst = settings.tolerance, np.inf
    while worst > settings.tolerance and steps < settings.max_iterations:
        pressure, _ = cg(
            LinearOperator(shape, matvec=displaced, dtype=float),
            target,
            x0=pressure,
            rtol=aim,
            maxiter=settings.max_iterations - steps,
            M=LinearOperator(shape, matvec=preconditioned, dtype=float),
            callback=counted,
        )
        worst, aim = float(np.max(np.abs(displaced(pressure) - 1))), aim / 10
        if aim < 1e-15:
            break
    if not worst <= settings.tolerance:
        raise NotConverged(
            f"stiffness: {steps} steps leave a deviation of {worst:.1e}, above the tolerance "
            f"{settings.tolerance:g}: "
            "allow more steps or a larger tolerance"
        )
    solved = np.zeros(operator.shape)
    solved[moving] = pressure
    return FrozenContact(stiffness=float(solved.mean()), pressure=solved, steps=steps, residual=worst)


def contact_conductance(stiffness: float, *, contact_modulus: float, resistivities: Sequence[float]) -> float:
    r"""Conductance of a contact per nominal area, electrical or thermal, from its stiffness.

    .. math:: G = \frac{2 K}{E^* (\rho_1 + \rho_2)}

    Parameters
    ----------
    stiffness : float
        K = d p0 / d(approach) [Pa/m] of two half-spaces.
    contact_modulus : float
        E* [Pa].
    resistivities : (2,) sequence of float
        rho of both bodies: electrical [ohm m], which gives G in 1/(ohm m^2), or the inverse of the thermal
        conductivity [m K/W], which gives W/(m^2 K).

    Notes
    -----
    Clean contact: all current passes through the spots, which touch directly. Barber (2003).

    Examples
    --------
    A circular spot of radius a, K A0 = 2 a E*, has Holm's resistance (rho_1 + rho_2) / (4 a):

    >>> contact_conductance(2 * 0.5 * 3.0, contact_modulus=3.0, resistivities=(1.0, 1.0))
    1.0
    """
    positive("stiffness", stiffness)
    modulus = positive("contact_modulus", contact_modulus)
    rho = samples("resistivities", resistivities, least=2)
    if rho.size != 2 or not np.all(rho >= 0) or not rho.sum() > 0:
        raise InvalidInput(
            f"resistivities = {resistivities!r}: must be those of two bodies, none negative and not both 0"
        )
    return float(2 * stiffness / modulus / rho.sum())
