"""How structure makes a stiff material soft: foams and fibres (Persson 2006, Sec. 8.7)."""

import math

from persson._checks import positive, within


def foam_modulus(young: float, *, wall: float, cell: float) -> float:
    """Effective Young's modulus E_eff = E (d/D)^3 [Pa] of a foam: cells of size D, walls of d.

    Parameters
    ----------
    young : float
        E [Pa] of the walls.
    wall, cell : float
        d < D [m].

    Notes
    -----
    Persson 2006, Sec. 4, caption of the adhesion pad, after L. J. Gibson and M. F. Ashby, Proc. R. Soc. A
    382, 43 (1982): walls bend. A number of order 1 depends on the shape of the cells; for regular hexagons in
    their plane it is 4/sqrt(3).

    Examples
    --------
    >>> round(foam_modulus(1e9, wall=1e-7, cell=1e-6) / 1e6, 6)
    1.0
    """
    size = positive("cell", cell)
    thin = within("wall", wall, "(0, cell)", ends=(0, size)) / size
    return positive("young", young) * thin * thin * thin


def fibre_modulus(young: float, *, radius: float, length: float, density: float, angle: float) -> float:
    r"""Effective Young's modulus [Pa] of a layer of slanted fibres, which bend as cantilevers.

    .. math:: E_\mathrm{eff} = \frac{3 E I\, n \sin\varphi}{L^2\cos^2\varphi}, \qquad I = \frac{\pi R^4}{4}

    Parameters
    ----------
    young : float
        E [Pa] of the fibres.
    radius, length : float
        R and L [m].
    density : float
        n [1/m^2], fibres per area.
    angle : float
        phi [rad], between the fibres and the surface they stand on, in (0, pi/2): upright fibres do not bend.

    Notes
    -----
    Persson 2006, Sec. 8.7, states how soft such layers are and cites B. N. J. Persson, J. Chem. Phys.
    118, 7614 (2003); the formula is that of K. Autumn et al., J. Exp. Biol. 209, 3558 (2006), without
    friction at the tips.

    Examples
    --------
    Setae of a gecko, of keratin a thousand times stiffer than rubber, are ten times softer than it:

    >>> gecko = {"radius": 2.1e-6, "length": 106e-6, "density": 1.44e10, "angle": 0.75}
    >>> round(fibre_modulus(1.5e9, **gecko) / 1e6, 2)
    0.11
    """
    big, far = positive("radius", radius), positive("length", length)
    slant = within("angle", angle, "(0, pi/2)", ends=(0, math.pi / 2))
    slender = (big / far) * (big / far)
    covered = positive("density", density) * big * big
    shape = 0.75 * math.pi * math.sin(slant) / math.cos(slant) ** 2
    return positive("young", young) * slender * covered * shape
