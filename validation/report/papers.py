"""What to cite for a result: the papers behind the areas and spectra; methods and effects name their own."""

from __future__ import annotations

__all__ = ["MEASURED", "PERIMETER"]

PERIMETER = (
    "Edge correction of the area: V. A. Yastrebov, G. Anciaux, J.-F. Molinari, Tribol. Int. 114, 161 (2017), "
    "with constants of the discretisations used here."
)
MEASURED = (
    "C(q) of measured surfaces: T. D. B. Jacobs, T. Junge, L. Pastewka, Surf. Topogr.: Metrol. Prop. 5, "
    "013001 (2017)."
)
