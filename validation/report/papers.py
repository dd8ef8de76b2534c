"""What to cite for a result: the papers behind the methods that made it."""

from __future__ import annotations

from collections.abc import Iterable

__all__ = ["papers"]

_PAPERS = {
    "theory": "Theory: B. N. J. Persson, Surf. Sci. Rep. 61, 201 (2006); J. Chem. Phys. 115, 3840 (2001).",
    "bem": "Boundary elements by FFT: H. M. Stanley, T. Kato, J. Tribol. 119, 481 (1997); conjugate "
    "gradients with "
    "bounds: I. A. Polonsky, L. M. Keer, Wear 231, 206 (1999).",
    "bem-adhesive": "Boundary elements by FFT: H. M. Stanley, T. Kato, J. Tribol. 119, 481 (1997); "
    "projected Newton method: D. P. Bertsekas, SIAM J. Control Optim. 20, 221 (1982).",
    "fem": "Finite elements: T. Gustafsson, G. D. McBain, scikit-fem, J. Open Source Softw. 5, 2369 "
    "(2020); linear "
    "systems: N. Bell, L. N. Olson, J. Schroder, PyAMG, J. Open Source Softw. 7, 4142 (2022).",
    "adhesion": "Adhesion: D. Maugis, J. Colloid Interface Sci. 150, 243 (1992); when rough surfaces "
    "stick: L. Pastewka, M. O. Robbins, PNAS 111, 3298 (2014).",
    "hardness": "Hardness as a bound of the pressure: A. Almqvist, F. Sahlin, R. Larsson, S. Glavatskih, "
    "Tribol. Int. 40, 574 (2007).",
    "thickness": "Layer on a rigid base: K. L. Johnson, Contact Mechanics (Cambridge, 1985), Sec. 5.8.",
    "coating": "Coated solid: K. L. Johnson, Contact Mechanics (Cambridge, 1985), Sec. 5.8.",
    "graded": "Modulus that varies with depth: B. N. J. Persson, Surf. Sci. Rep. 61, 201 (2006), Sec. 5.",
    "perimeter": "Edge correction of the area: V. A. Yastrebov, G. Anciaux, J.-F. Molinari, Tribol. Int. "
    "114, 161 "
    "(2017), with constants of the discretisations used here.",
    "measured": "C(q) of measured surfaces: T. D. B. Jacobs, T. Junge, L. Pastewka, Surf. Topogr.: Metrol. "
    "Prop. 5, "
    "013001 (2017).",
}


def papers(used: Iterable[str]) -> tuple[str, ...]:
    """Return the papers for the methods and effects used, in a fixed order.

    Examples
    --------
    >>> len(papers({"bem", "perimeter"}))
    2
    """
    wanted = set(used)
    return tuple(text for name, text in _PAPERS.items() if name in wanted)
