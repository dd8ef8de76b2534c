"""What to cite for a result, by key; methods and effects name their own papers."""

from __future__ import annotations

PAPERS = {
    "borri2006": "M. Borri-Brunetto, private communication in Persson 2006, Sec. 3.5.",
    "campana2007": "C. Campana, M. H. Müser, Europhys. Lett. 77, 38005 (2007).",
    "hyun2004": "S. Hyun, L. Pei, J.-F. Molinari, M. O. Robbins, Phys. Rev. E 70, 026117 (2004).",
    "measured": "C(q) of measured surfaces: T. D. B. Jacobs, T. Junge, L. Pastewka, Surf. Topogr.: Metrol. "
    "Prop. 5, 013001 (2017).",
    "monti2021": "J. M. Monti, A. Sanner, L. Pastewka, Tribol. Lett. (2021), doi 10.1007/s11249-021-01454-6.",
    "perimeter": "Edge correction of the area: V. A. Yastrebov, G. Anciaux, J.-F. Molinari, Tribol. Int. "
    "114, 161 (2017), with constants of the discretisations used here.",
    "persson2006": "B. N. J. Persson, Surf. Sci. Rep. 61, 201 (2006).",
    "prodanov2014": "N. Prodanov, W. B. Dapp, M. H. Müser, Tribol. Lett. 53, 433 (2014).",
    "wang_mueser": "Variant of the theory: A. Wang, M. H. Müser, Gauging Persson theory on adhesion, "
    "Tribol. Lett. 65 (2017).",
    "xu": "Variant of the theory: Y. Xu, L. Zhu, F. Xiao, Y. Zhou, Tribol. Lett. (2024), "
    "doi 10.1007/s11249-024-01838-4.",
    "yang2006": "C. Yang, U. Tartaglino, B. N. J. Persson, Eur. Phys. J. E 19, 47 (2006).",
    "yang_persson": "Variant of the theory: C. Yang, B. N. J. Persson, J. Phys.: Condens. Matter 20, "
    "215214 (2008).",
    "yastrebov2015": "V. A. Yastrebov, G. Anciaux, J.-F. Molinari, Int. J. Solids Struct. (2015).",
}
