"""What a comparison found: rows, cross-checks, scatter and limit of one scene, ready to be shown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from fem_contact.extrapolation import Limit
from validation.comparison.below import Below
from validation.effects.base import Effect
from validation.methods.theory import Prediction
from validation.report.words import json_ready
from validation.scenes.realised import Realised
from validation.scenes.scene import Scene

if TYPE_CHECKING:
    from validation.comparison.passing import Passing
    from validation.effects.base import Judgement

__all__ = ["Comparison", "CrossCheck", "Row", "Scatter", "is_adhesive"]


def is_adhesive(effects: Sequence[Effect]) -> bool:
    """Whether one of the effects is a gap law."""
    return any(effect.slot == "gap law" for effect in effects)


@dataclass(frozen=True, kw_only=True)
class Row:
    """One method on one grid, averaged over the sub-grid shifts that were run.

    Attributes
    ----------
    method : str
        Its name.
    grid : tuple of int
    points_per_wave : float
        lambda_short / dx, on the coarser axis.
    under_resolved : bool
        Whether lambda_short <= 2 dx.
    solves : int
        Number of shifts averaged.
    pixel, perimeter : float
        A/A0 by counting, and with the perimeter correction of the method's edge constant.
    pixel_scatter : float
        Standard error of `pixel` over the shifts; NaN for one shift, which tells nothing of it.
    kappa : float
        (A/A0) / p* from `perimeter`.
    density_at_zero : float
        P(0+) E* h'_rms, from the points below a pressure that falls like sqrt(dx); NaN with adhesion, where
        pressures do not start at zero.
    residual : float
        The largest of the four contact residuals over the solves.
    seconds : float
        Wall time of all the solves.
    unknowns : int
        Of one solve.
    plastic : float or None
        A_pl/A0, points at the pressure bound counted; None without a hardness.
    """

    method: str
    grid: tuple[int, int]
    points_per_wave: float
    under_resolved: bool
    solves: int
    pixel: float
    pixel_scatter: float
    perimeter: float
    kappa: float
    density_at_zero: float
    residual: float
    seconds: float
    unknowns: int
    plastic: float | None = None


@dataclass(frozen=True, kw_only=True)
class CrossCheck:
    """One method against the first on the same surface and grid.

    Attributes
    ----------
    method, reference : str
        Finite elements and boundary elements, say.
    grid : tuple of int
    points_per_wave : float
        lambda_short / dx.
    pressure : float
        ||p - p_reference|| / ||p_reference||, over all points.
    pixel, perimeter : float
        A / A_reference - 1, by counting and with each method's perimeter correction.
    """

    method: str
    reference: str
    grid: tuple[int, int]
    points_per_wave: float
    pressure: float
    pixel: float
    perimeter: float


@dataclass(frozen=True, kw_only=True)
class Scatter:
    """Spread of the contact area between realisations of the same spectrum.

    Attributes
    ----------
    areas : tuple of float
        Limit of A/A0 of each realisation.
    ratios : tuple of float
        Each over the theory conditional on that realisation.
    grid_error : float
        Root mean square of the uncertainties of the single limits, relative.
    """

    areas: tuple[float, ...]
    ratios: tuple[float, ...]
    grid_error: float

    @property
    def mean_ratio(self) -> float:
        """Mean of area over theory."""
        return float(np.mean(self.ratios))

    @property
    def relative(self) -> float:
        """Standard deviation between surfaces over the mean."""
        return float(np.std(self.ratios, ddof=1) / np.mean(self.ratios))

    @property
    def mean_error(self) -> float:
        """Standard error of `mean_ratio`."""
        return float(np.std(self.ratios, ddof=1) / np.sqrt(len(self.ratios)))


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """Everything a run found, in numbers; plots, tables and sentences are made from it.

    Attributes
    ----------
    scene : Scene
    realised : Realised
        Its surface, solid and load.
    pressure, contact_modulus, rms_gradient : float
        p0 [Pa], E* [Pa], and the realised, spectral h'_rms.
    rms_height, nayak : float
        h_rms [m] and Nayak parameter of the realised surface.
    continuum : dict of str to float, or None
        h_rms [m] and h'_rms of the integrals over C(q), which for a measured surface is estimated.
    treatment : tuple of str
        What was done to a measured surface, in words; empty for a generated one.
    rows, cross : tuples
    limit : Limit or None
        Limit of A/A0 over the resolved BEM grids (FEM grids where there is no BEM); None from a single grid,
        fewer than three counted areas, or a contact too small to carry the law.
    theory : Prediction or None
        None unless the scene asks for it.
    scatter : Scatter or None
    no_limit : str
        Why there is no limit, in words; empty where there is one.
    below : tuple of Below
        Where the solid below the contact is strained most, where the scene asks for it.
    accurate : mapping or None
        What was reached, where the grids were chosen for an accuracy
        (`validation.comparison.accuracy.Reached`).
    passing : tuple of Passing
        What passes through contact and gap, where the scene asks for it.
    """

    scene: Scene
    realised: Realised
    pressure: float
    contact_modulus: float
    rms_gradient: float
    rms_height: float
    nayak: float
    continuum: dict[str, float] | None
    treatment: tuple[str, ...]
    rows: tuple[Row, ...]
    cross: tuple[CrossCheck, ...]
    limit: Limit | None
    theory: Prediction | None
    scatter: Scatter | None
    no_limit: str = ""
    below: tuple[Below, ...] = ()
    accurate: Mapping[str, Any] | None = None
    passing: tuple[Passing, ...] = ()

    @property
    def adhesive(self) -> bool:
        """Whether the surfaces attract each other, so that pressures are negative near the edges."""
        return is_adhesive(self.scene.effects)

    @cached_property
    def judgements(self) -> tuple[tuple[Judgement, ...], tuple[Judgement, ...]]:
        """Effects that ran and effects left out, each with the number that decides."""
        from validation.comparison.explain import judgements

        return judgements(self.scene, self.realised)

    @property
    def mean(self) -> Mapping[str, Any] | None:
        """What a run to an accuracy reached for the mean over surfaces; None where there is no such mean."""
        return None if self.accurate is None or self.accurate["mean"] is None else self.accurate

    @property
    def theory_of_all(self) -> float | None:
        """A/A0 of the theory where it is the same for all surfaces of the spectrum."""
        surface, load = self.scene.surface, self.scene.load
        alike = getattr(surface, "amplitudes", "") == "exact" or (
            load.reduced_pressure is not None and not self.scene.effects
        )
        return self.theory.area if alike and self.theory is not None and self.theory.answers else None

    @property
    def reduced_pressure(self) -> float:
        """p* = p0 / (E* h'_rms) with the realised gradient."""
        return self.pressure / (self.contact_modulus * self.rms_gradient)

    @cached_property
    def findings(self) -> tuple[str, ...]:
        """What the run found, in words."""
        from validation.comparison.findings import findings

        return findings(self)

    def rows_of(self, method: str) -> tuple[Row, ...]:
        """Rows of one method, coarse to fine."""
        return tuple(row for row in self.rows if row.method == method)

    def summary(self) -> dict[str, Any]:
        """Everything as JSON-ready data."""
        return {
            "scene": self.scene.model_dump(mode="json"),
            "pressure_Pa": self.pressure,
            "reduced_pressure": self.reduced_pressure,
            "contact_modulus_Pa": self.contact_modulus,
            "realised": json_ready(
                {
                    "rms_height_m": self.rms_height,
                    "rms_gradient": self.rms_gradient,
                    "nayak": self.nayak,
                }
            ),
            "continuum": self.continuum,
            "treatment": list(self.treatment),
            "rows": [json_ready(asdict(row)) for row in self.rows],
            "cross_checks": [asdict(check) for check in self.cross],
            "limit": None if self.limit is None else asdict(self.limit),
            "no_limit": self.no_limit,
            "theory": None if self.theory is None else self.theory.summary(),
            "scatter": None if self.scatter is None else asdict(self.scatter),
            **({"below": [asdict(row) for row in self.below]} if self.below else {}),
            "findings": list(self.findings),
        } | ({"quantities": [json_ready(asdict(one)) for one in self.passing]} if self.passing else {})
