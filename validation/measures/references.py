"""Figures from the literature with their sources; shown beside results, never used to make them."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["ALPHA_HURST", "ALPHA_LITERATURE", "KAPPA_LITERATURE", "KappaRange"]


@dataclass(frozen=True, kw_only=True)
class KappaRange:
    """kappa as published, with the range of Hurst exponents it was given for."""

    source: str
    hurst: tuple[float, float]
    kappa: tuple[float, float]
    note: str


KAPPA_LITERATURE = (
    KappaRange(
        source="Hyun et al. 2004; Campana, Mueser 2007; Prodanov et al. 2014; "
        "Yastrebov et al. 2015; Monti et al. 2021",
        hurst=(0.3, 0.9),
        kappa=(2.0, 2.2),
        note="simulations of resolved surfaces by several groups, A/A0 below about 0.1",
    ),
    KappaRange(
        source="Hyun et al. 2004, as read from a figure of Persson 2006",
        hurst=(0.8, 0.8),
        kappa=(1.8, 1.8),
        note="finite elements, roughness down to the grid scale, nodes counted",
    ),
)

#: alpha of A = alpha F over that of Persson's theory, as he quotes it (2006, Sec. 3.5), all of them for D_f = 2.2.
ALPHA_LITERATURE = {
    "molecular dynamics (Yang, Tartaglino, Persson 2006)": 1.14,
    "finite elements (Hyun et al. 2004)": 1.13,
    "discretised continuum (Borri-Brunetto 2006)": 0.80,
}
#: H = 3 - D_f for which they were computed.
ALPHA_HURST = 0.8
