"""The theory in two modes: told the roughness of the realised surface, or told C(q) alone."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from persson import elastic
from validation.scenes.surfaces import spectrum_of

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from validation.scenes.scene import SelfAffineSurface

__all__ = ["ensemble_area", "ensemble_stress_variance", "modes_sentence"]


def ensemble_stress_variance(surface: SelfAffineSurface, rms_gradients: ArrayLike) -> NDArray[np.float64]:
    r"""Variances of the full-contact stress that C(q) alone lets one expect, over E*^2, one for each surface.

    Their mean is that of C(q); their scatter is that of the realised gradients, which C(q) does not know.

    .. math:: V_k = \frac{m_2[C]}{4} \frac{h'^2_k}{\langle h'^2 \rangle}

    Parameters
    ----------
    surface : SelfAffineSurface
        Gives C(q).
    rms_gradients : (n,) array
        Realised h'_rms of the surfaces.
    """
    squares = np.square(np.asarray(rms_gradients, dtype=float))
    variance = elastic.stress_variance(spectrum_of(surface).m2(), contact_modulus=1.0)
    return np.asarray(variance * squares / squares.mean())


def ensemble_area(
    surface: SelfAffineSurface, reduced_pressures: ArrayLike, *, rms_gradients: ArrayLike
) -> NDArray[np.float64]:
    r"""A/A0 of the theory from C(q) alone, for each surface and load, of shape (n, loads).

    .. math:: A_k/A_0 = \bigl\langle \operatorname{erf}(p_k / \sqrt{2 V_j}) \bigr\rangle_j,
              \qquad p_k = p^* E^* h'_k

    The surfaces are pressed with p* times their own gradient, so that their nominal pressures p_k differ; a generator
    whose surfaces are rougher than C(q) says shows here, while the theory that is told their gradient hides it.

    Parameters
    ----------
    surface : SelfAffineSurface
        Gives C(q).
    reduced_pressures : (loads,) array
        p* with the realised gradient of each surface.
    rms_gradients : (n,) array
        Realised h'_rms of the surfaces.
    """
    gradients = np.asarray(rms_gradients, dtype=float)
    pressure = np.multiply.outer(gradients, np.asarray(reduced_pressures, dtype=float))
    variance = ensemble_stress_variance(surface, gradients)
    return np.asarray(
        elastic.contact_area(pressure[..., None], stress_variance=variance).mean(axis=-1), dtype=float
    )


def modes_sentence(conditional: ArrayLike, ensemble: ArrayLike) -> str:
    """Say how far the two modes of the theory are apart, over everything that was computed."""
    change = 100 * (np.asarray(ensemble, dtype=float) / np.asarray(conditional, dtype=float) - 1)
    spread = f"{change.min():+.2f} to {change.max():+.2f} % (mean {change.mean():+.2f} %)"
    return (
        "Told C(q) alone (ensemble) instead of the realised gradient (conditional), the theory predicts areas that differ by "
        f"{spread if change.size > 1 else f'{change.item():+.2f} %'}: the sum over the waves of a finite period against "
        "the integral, which is what a wrong generator would also change."
    )
