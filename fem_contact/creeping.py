r"""A rigid rough surface at rest on a viscoelastic half-space: how its contact grows, or remembers, in time.

Poisson's ratio does not relax, so that displacement and pressure of a half-space with the relaxation modulus
E(t) are those of an elastic one, point by point in time:

.. math:: \hat p(\mathbf q, t) = \frac{|\mathbf q|}{2(1 - \nu^2)}
          \int_0^t E(t - t')\, \frac{\partial \hat u(\mathbf q, t')}{\partial t'}\, dt',
          \qquad p \ge 0,\ g \ge 0,\ p g = 0

With a Prony series each term needs one field of its own, and a step of time is one elastic contact.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from fem_contact import bem
from fem_contact._checks import instance, samples, shape_of
from fem_contact.contact import ContactResult
from fem_contact.errors import InvalidInput
from fem_contact.response import HalfSpace
from fem_contact.settings import Settings, inner_tolerance
from fem_contact.solid import Solid
from fem_contact.surface import HeightField
from fem_contact.viscoelastic import PronySolid


def creep(
    surface: HeightField,
    solid: PronySolid,
    *,
    times: Sequence[float] | ArrayLike,
    mean_pressure: float | Sequence[float] | ArrayLike,
    tolerance: float = 1e-8,
    max_iterations: int = 1000,
    threads: int | None = None,
) -> list[ContactResult]:
    r"""Press a rigid rough surface against a viscoelastic half-space under a load that changes in time.

    The solid is at rest and without stress before the first time, at which the first load is put on at once.

    Parameters
    ----------
    surface : HeightField
        The rigid body, periodic.
    solid : PronySolid
        Of one or more relaxation times.
    times : (n,) array
        t [s] at which the contact is computed, rising; the first is that of the first load, and one that
        stands twice is a sudden change of load.
    mean_pressure : float or (n,) array
        Nominal pressure p0 [Pa] at these times, positive; a number is a load that stays.
    tolerance, max_iterations, threads
        As of `bem.solve`, for the contact of each time.

    Returns
    -------
    list of ContactResult
        One for each time. Use `.checked()` before relying on one; a time builds on those before. Its
        `contact_modulus` is what a change within the step meets, between E_0 and E_inf over 1 - nu^2.

    Raises
    ------
    InvalidInput
        For times that fall, or not as many loads.

    Notes
    -----
    Between two times the displacement is taken as linear, so that the error falls with the square of the
    step. As long as the load does not fall the contact only grows, and its area is that of the elastic
    solid with the creep compliance 1/J(t) in place of E: exactly, since what is pressed onto a frozen
    contact is nowhere negative (E. H. Lee, J. R. M. Radok, J. Appl. Mech. 27, 438 (1960), for a sphere;
    C. Y. Hui, Y. Y. Lin, J. M. Baney, J. Polym. Sci. B 38, 1485 (2000), for rough surfaces). After that it
    is not: the solid remembers the contact that was (T. C. T. Ting, J. Appl. Mech. 33, 845 (1966)).

    Examples
    --------
    >>> from fem_contact import PronySolid
    >>> x = np.arange(32) / 32
    >>> wave = HeightField(heights=1e-3 * np.cos(2 * np.pi * x)[:, None] * np.ones(4), lengths=(1.0, 0.125))
    >>> rubber = PronySolid(relaxed=1.0, moduli=(9.0,), times=(1.0,), poisson=0.0)
    >>> early, late = creep(wave, rubber, times=[0.0, 100.0], mean_pressure=1e-4)
    >>> bool(early.in_contact.mean() < late.in_contact.mean())
    True
    """
    instance("surface", surface, HeightField)
    instance("solid", solid, PronySolid)
    settings = Settings(tolerance=tolerance, max_iterations=max_iterations, threads=threads)
    at = samples("times", times)
    if np.any(np.diff(at) < 0):
        raise InvalidInput("times: must not fall, in s")
    single = shape_of("mean_pressure", mean_pressure) == ()
    given = np.repeat(mean_pressure, at.size) if single else mean_pressure
    loads = samples("mean_pressure", given)
    if loads.size != at.size or loads.min() <= 0:
        raise InvalidInput(
            f"mean_pressure: {loads.size} loads for {at.size} times: must be as many, and positive, in Pa"
        )
    moduli, decay = np.array(solid.moduli)[:, None, None], np.array(solid.times)[:, None, None]
    results: list[ContactResult] = []
    stresses, displacement = np.zeros((moduli.size, *surface.shape)), np.zeros(surface.shape)
    for step, load in zip(np.diff(at, prepend=at[0]), loads, strict=True):
        # Of E_k times a displacement that grows linearly over the step, and of what was there before.
        left = moduli * (-np.expm1(-step / decay) * decay / step if step > 0 else 1.0)
        stresses = np.exp(-step / decay) * stresses - left * displacement
        modulus = solid.relaxed + float(left.sum())
        memory = stresses.sum(axis=0) / modulus
        step_surface = HeightField(heights=surface.heights + memory, lengths=surface.lengths)
        contact = bem.solve(
            step_surface,
            HalfSpace(solid=Solid(young=modulus, poisson=solid.poisson)),
            mean_pressure=float(load),
            start=results[-1].pressure * (load / results[-1].mean_pressure) if results else None,
            tolerance=inner_tolerance(settings.tolerance, of=surface.rms_height, on=step_surface.rms_height),
            max_iterations=settings.max_iterations,
            threads=settings.threads,
        )
        displacement = contact.displacement - memory
        stresses += left * displacement
        contact = contact.remeasured(
            rms_gradient=surface.rms_gradient,
            target_pressure=float(load),
            displacement=displacement,
            heights=surface.heights,
            tolerance=settings.tolerance,
        )
        results.append(contact)
    return results
