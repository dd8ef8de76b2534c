"""Where the gaps of a contact join up: percolation of the non-contact area (Persson 2006, Secs. 3.6, 8.3)."""

import math

from scipy.special import erfinv

from persson._checks import instance, positive, within
from persson.scale import Scale

#: A/A0 at which the gaps percolate if contact is scattered at random, Persson 2006: 1 - p_c, 0.7 of sites.
SITE_THRESHOLD = 0.3
#: The same for elastic contact of randomly rough surfaces, computed without adhesion: .400 +- .005 (95 %) for
#: contact and gap alike.
MEASURED_THRESHOLD = 0.40
#: Where computed thresholds lie, ours and those of others (.415, arXiv:2010.13470; .42, Dapp et al. 2012).
COMPUTED_THRESHOLDS = (0.39, 0.42)


def percolation_magnification(
    scale: Scale, *, pressure: float, q_reference: float, threshold: float = SITE_THRESHOLD
) -> float:
    """Magnification at which the non-contact area first reaches from side to side, without adhesion.

    Parameters
    ----------
    scale : Scale
        Spectrum and modulus.
    pressure : float
        sigma_0 [Pa].
    q_reference : float
        Wavevector at zeta = 1 [1/m].
    threshold : float
        A/A0 in (0, 1) at percolation: `SITE_THRESHOLD`, the paper's, or `MEASURED_THRESHOLD`.

    Returns
    -------
    float
        zeta with A(zeta)/A0 = threshold; infinite where more area than that touches with all roughness,
        so that nothing leaks.

    Notes
    -----
    Persson 2006, Secs. 3.6 and 8.3. The width of the channel that opens there is a share of 2 pi / (zeta
    q_ref).

    Examples
    --------
    >>> from persson.spectrum import SelfAffine
    >>> rough = SelfAffine.from_rms_height(1e-6, hurst=0.8, q_long=1e5, q_short=1e8)
    >>> soft = Scale(rough, contact_modulus=1e6)
    >>> percolation_magnification(soft, pressure=1e8, q_reference=1e5)
    inf
    """
    instance("scale", scale, Scale)
    load = positive("pressure", pressure)
    reference = positive("q_reference", q_reference)
    share = within("threshold", threshold, "(0, 1)")
    root = load / float(erfinv(share))
    variance = root * root / 2
    if variance >= float(scale.variance(scale.q_short)):
        return math.inf
    return float(scale.wavevector(variance)) / reference
