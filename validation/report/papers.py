"""The one list of papers: a text that has "[hertz1882]" in it cites that one."""

from __future__ import annotations

import re

PAPERS = {
    "almqvist2007": "A. Almqvist, F. Sahlin, R. Larsson, S. Glavatskih, Tribol. Int. 40, 574 (2007)",
    "barber2003": "J. R. Barber, Proc. R. Soc. A 459, 53 (2003)",
    "bertsekas1982": "D. P. Bertsekas, SIAM J. Control Optim. 20, 221 (1982)",
    "borri2006": "M. Borri-Brunetto, private communication in Persson 2006, Sec. 3.5",
    "brandt1977": "A. Brandt, Math. Comput. 31, 333 (1977)",
    "bush1975": "A. W. Bush, R. D. Gibson, T. R. Thomas, Wear 35, 87 (1975)",
    "campana2007": "C. Campana, M. H. Müser, Europhys. Lett. 77, 38005 (2007)",
    "carbone2008": "G. Carbone, F. Bottiglione, J. Mech. Phys. Solids 56, 2555 (2008)",
    "dhondt2004": "G. Dhondt, The Finite Element Method for Three-Dimensional Thermomechanical "
    "Applications (Wiley, 2004)",
    "frerot2020": "L. Frerot, G. Anciaux, V. Rey, S. Pham-Ba, J.-F. Molinari, J. Open Source Softw. 5, "
    "2121 (2020)",
    "giannakopoulos1997": "A. E. Giannakopoulos, S. Suresh, Int. J. Solids Struct. 34, 2357 (1997)",
    "greenwood1966": "J. A. Greenwood, J. B. P. Williamson, Proc. R. Soc. A 295, 300 (1966)",
    "gustafsson2020": "T. Gustafsson, G. D. McBain, scikit-fem, J. Open Source Softw. 5, 2369 (2020)",
    "hertz1882": "H. Hertz, J. reine angew. Math. 92, 156 (1882)",
    "hintermueller2002": "M. Hintermüller, K. Ito, K. Kunisch, SIAM J. Optim. 13, 865 (2003)",
    "huber1904": "M. T. Huber, Ann. Phys. 14, 153 (1904)",
    "hunter1961": "S. C. Hunter, J. Appl. Mech. 28, 611 (1961)",
    "hyun2004": "S. Hyun, L. Pei, J.-F. Molinari, M. O. Robbins, Phys. Rev. E 70, 026117 (2004)",
    "jacobs2017": "T. D. B. Jacobs, T. Junge, L. Pastewka, Surf. Topogr.: Metrol. Prop. 5, 013001 (2017)",
    "johnson1971": "K. L. Johnson, K. Kendall, A. D. Roberts, Proc. R. Soc. A 324, 301 (1971)",
    "johnson1985": "K. L. Johnson, J. A. Greenwood, J. G. Higginson, Int. J. Mech. Sci. 27, 383 (1985)",
    "johnson_book": "K. L. Johnson, Contact Mechanics (Cambridge University Press, 1985)",
    "love1929": "A. E. H. Love, Phil. Trans. R. Soc. A 228, 377 (1929)",
    "maugis1992": "D. Maugis, J. Colloid Interface Sci. 150, 243 (1992)",
    "mccool1987": "J. I. McCool, J. Tribol. 109, 264 (1987)",
    "monti2021": "J. M. Monti, A. Sanner, L. Pastewka, Tribol. Lett. (2021), doi 10.1007/s11249-021-01454-6",
    "nayak1971": "P. R. Nayak, J. Lubr. Technol. 93, 398 (1971)",
    "pastewka2014": "L. Pastewka, M. O. Robbins, PNAS 111, 3298 (2014)",
    "persson2001": "B. N. J. Persson, J. Chem. Phys. 115, 3840 (2001)",
    "persson2006": "B. N. J. Persson, Surf. Sci. Rep. 61, 201 (2006)",
    "persson2007": "B. N. J. Persson, Phys. Rev. Lett. 99, 125502 (2007)",
    "polonsky1999": "I. A. Polonsky, L. M. Keer, Wear 231, 206 (1999)",
    "prodanov2014": "N. Prodanov, W. B. Dapp, M. H. Müser, Tribol. Lett. 53, 433 (2014)",
    "read1997": "F. H. Read, J. Comput. Phys. 133, 1 (1997)",
    "stanley1997": "H. M. Stanley, T. Kato, J. Tribol. 119, 481 (1997)",
    "wang2017": "A. Wang, M. H. Müser, Tribol. Lett. 65, 103 (2017)",
    "westergaard1939": "H. M. Westergaard, J. Appl. Mech. 6, 49 (1939)",
    "xu2024": "Y. Xu, L. Zhu, F. Xiao, Y. Zhou, Tribol. Lett. (2024), doi 10.1007/s11249-024-01838-4",
    "yang2006": "C. Yang, U. Tartaglino, B. N. J. Persson, Eur. Phys. J. E 19, 47 (2006)",
    "yang2008": "C. Yang, B. N. J. Persson, J. Phys.: Condens. Matter 20, 215214 (2008)",
    "yastrebov2015": "V. A. Yastrebov, G. Anciaux, J.-F. Molinari, Int. J. Solids Struct. 52, 83 (2015)",
    "yastrebov2017": "V. A. Yastrebov, G. Anciaux, J.-F. Molinari, Tribol. Int. 114, 161 (2017)",
}

#: What to cite beside methods and effects, which name their own: by the name of what is used.
CITED_FOR = {key: f"[{key}]." for key in PAPERS} | {
    "measured": "C(q) of measured surfaces: [jacobs2017].",
    "perimeter": "Edge correction of the area: [yastrebov2017], with constants of the discretisations "
    "used here.",
    "wang_mueser": "Variant of the theory: [wang2017].",
    "xu": "Variant of the theory: [xu2024].",
    "yang_persson": "Variant of the theory: [yang2008].",
}


def cited(text: str) -> str:
    """Return a text with each key in brackets written out.

    >>> cited("Cells under constant pressure: [love1929].")
    'Cells under constant pressure: A. E. H. Love, Phil. Trans. R. Soc. A 228, 377 (1929).'
    """
    return re.sub(r"\[(\w+)\]", lambda key: PAPERS.get(key[1], key[0]), text)
