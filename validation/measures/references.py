"""Figures from the literature with their sources; shown beside results, never used to make them."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["KAPPA_LITERATURE", "XU_2024", "XU_2024_FINE", "AreaTable", "KappaRange"]


@dataclass(frozen=True, kw_only=True)
class KappaRange:
    """kappa as published, with the range of Hurst exponents it was given for."""

    source: str
    hurst: tuple[float, float]
    kappa: tuple[float, float]
    note: str


@dataclass(frozen=True, kw_only=True)
class AreaTable:
    """Relative contact area against reduced pressure for one spectrum."""

    source: str
    reduced_pressure: tuple[float, ...]
    area: tuple[float, ...]
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

#: Xu, Xu, Zhou, Mueser, J. Appl. Mech. 2024: GFMD, H = 0.8, lambda_long/lambda_short = 100, no roll-off.
XU_2024 = AreaTable(
    source="Xu et al. 2024, published GFMD data",
    reduced_pressure=(0.0181, 0.0362, 0.0542, 0.0904, 0.1446, 0.2350, 0.4085, 0.6905, 1.085),
    area=(0.0399, 0.0779, 0.1147, 0.1852, 0.2846, 0.4326, 0.6571, 0.8739, 0.9794),
    note="pixel count at four points per shortest wavelength",
)
XU_2024_FINE = AreaTable(
    source="the same spectrum, limit over grids",
    reduced_pressure=(0.0181, 0.0542, 0.1446, 0.4085),
    area=(0.0368, 0.1063, 0.2685, 0.6367),
    note="boundary elements, eight surfaces, +- 2.2, 1.3, 0.4, 0.2 %",
)
