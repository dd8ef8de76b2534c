"""Attraction across the gap."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Literal, Self

import numpy as np

from validation.arrays import Grid
from validation.effects.base import ContactModel, Effect, Judgement, Roughness, TheoryInputs
from validation.errors import UsageError
from validation.report.quantities import as_length, in_prefixed_unit
from validation.units import Length, Work, key

if TYPE_CHECKING:
    from collections.abc import Sequence

    from fem_contact.adhesion import GapLaw
    from validation.scenes.problem import ContactProblem

#: Pastewka-Robbins number below which attraction takes more than 2 % off what repulsion carries.
_FELT = 50.0
#: Contact area over load / (E* h'_rms) without adhesion.
_KAPPA_REPULSIVE = 2.0


class Adhesion(Effect):
    """The surfaces attract each other across the gap."""

    kind: Literal["adhesion"] = "adhesion"
    work: Work = key('work of adhesion, e.g. "50 mJ/m^2"')
    reach: Length | None = key(
        'range of the attraction, e.g. "2 nm"; every solver needs it, the theory knows none', None
    )
    law: Literal["exponential", "dugdale"] = key(
        "attraction that decays with the gap, or is constant over the range", "exponential"
    )

    slot = "gap law"
    cost = 5.1
    papers = ("Adhesion: [maugis1992]; when rough surfaces stick: [pastewka2014].",)

    def gap_law(self) -> GapLaw:
        """Return the law of the gap."""
        from fem_contact.adhesion import Dugdale, Exponential

        kind = Exponential if self.law == "exponential" else Dugdale
        return kind(work=self.work, reach=self._range)

    @property
    def _range(self) -> float:
        """Range of the attraction [m]."""
        if self.reach is None:
            raise UsageError("adhesion: reach is missing; a solver needs the range of the attraction")
        return self.reach

    def fill(self, model: ContactModel) -> None:
        """Give the law of the gap."""
        model.gap_law = self.gap_law()

    def check_solver(self, name: str, *, key: str) -> None:
        """Refuse attraction without a range."""
        if self.reach is None:
            raise UsageError(
                f'{key} reach: missing; method {name!r} needs the range of the attraction, e.g. "2 nm"'
            )

    def theory(self, inputs: TheoryInputs) -> None:
        """Persson 2006, Sec. 8; the theory knows no range."""
        inputs.work = self.work

    def check(self, problem: ContactProblem, grids: Sequence[Grid], *, model: ContactModel, key: str) -> None:
        """Refuse grids that are too coarse for the range of the attraction."""
        from fem_contact.adhesion import CELLS_NEEDED, cells_in_process_zone

        modulus = model.felt_response.contact_modulus
        for grid in grids:
            spacing = max(problem.spacing(grid))
            cells = cells_in_process_zone(self.gap_law(), spacing=spacing, contact_modulus=modulus)
            if cells < CELLS_NEEDED:
                needed = [int(np.ceil(n * CELLS_NEEDED / cells)) for n in grid]
                raise UsageError(
                    f"{key} reach = {as_length(self._range)}: grid {list(grid)} has {cells:.3g} cells in the "
                    f"zone where adhesion acts and needs {CELLS_NEEDED:.0f}: at least {needed}, or a "
                    "longer reach"
                )

    def judge(self, rough: Roughness) -> Judgement:
        """Compare attraction with repulsion and with the stored energy."""
        stored = rough.full_energy / self.work
        if self.reach is None:
            return self.judgement(f"U_full/w = {stored:.3g} (Persson 2006, Sec. 8)", matters=stored < 10)
        radius = 2 / rough.curvature
        tabor = (radius * self.work**2 / rough.modulus**2 / self.reach**3) ** (1 / 3)
        parting = self._parting(rough)
        number = (
            f"Pastewka-Robbins number {parting:.3g} (sticky below 1; Pastewka and Robbins 2014, Eq. 10), "
            f"U_full/w = {stored:.3g} (Persson 2006, Sec. 8), Tabor parameter of a summit {tabor:.3g}"
        )
        return self.judgement(number, matters=parting < _FELT or stored < 10)

    def _parting(self, rough: Roughness) -> float:
        r"""Repulsion in the contacts over the attraction around them.

        .. math:: \frac{h' \rho}{\kappa_\mathrm{rep}\, \ell_a}
                  \left(\frac{h' d_\mathrm{rep}}{4\rho}\right)^{2/3},
                  \qquad \ell_a = w/E^*,\quad d_\mathrm{rep} = 4 h'/h'',\quad \kappa_\mathrm{rep} = 2

        L. Pastewka, M. O. Robbins, PNAS 111 (2014) 3298, Eq. 10, with h'' half of the rms Laplacian.
        """
        laplacian = rough.curvature * math.sqrt(8 / 3)
        width = 4 * rough.gradient / (laplacian / 2)
        length = self.work / rough.modulus
        bare = rough.gradient * self._range / (_KAPPA_REPULSIVE * length)
        return float(bare * (rough.gradient * width / (4 * self._range)) ** (2 / 3))

    @classmethod
    def unlisted(cls, rough: Roughness) -> Judgement:
        """Name the work of adhesion from which it matters."""
        return cls.unknown(
            f"U_full = {in_prefixed_unit(rough.full_energy, 'J/m^2', 3)} (Persson 2006, Sec. 8)",
            "a work of adhesion and its range; it matters from about "
            f"{in_prefixed_unit(rough.full_energy / 10, 'J/m^2', 3)}",
        )

    @classmethod
    def example(cls, spacing: float) -> Self:
        """Return attraction as strong as repulsion, with a process zone of three cells."""
        work = 5e-5
        return cls(work=work, reach=math.sqrt(3 * spacing * work))
