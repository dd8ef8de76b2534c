"""What to cite for a result: the papers behind the areas and spectra; methods and effects name their own."""

from __future__ import annotations

__all__ = ["MEASURED", "PERIMETER", "VARIANTS"]

PERIMETER = (
    "Edge correction of the area: V. A. Yastrebov, G. Anciaux, J.-F. Molinari, Tribol. Int. 114, 161 (2017), "
    "with constants of the discretisations used here."
)
MEASURED = (
    "C(q) of measured surfaces: T. D. B. Jacobs, T. Junge, L. Pastewka, Surf. Topogr.: Metrol. Prop. 5, "
    "013001 (2017)."
)
#: Variants of the theory that are ranked beside it, by name.
VARIANTS = {
    "yang_persson": "Variant of the theory: C. Yang, B. N. J. Persson, J. Phys.: Condens. Matter 20, "
    "215214 (2008).",
    "wang_mueser": "Variant of the theory: A. Wang, M. H. Mueser, Lubricants 5, 35 (2017).",
    "xu": "Variant of the theory: Y. Xu, R. Xu, X. Chen (2024), V = [g + (1 - g) P] V_full.",
}
