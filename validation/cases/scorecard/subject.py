"""What is scored: a solver with its settings, and what it answers, recomputed where that can be."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from fem_contact.contact import ContactResult
from fem_contact.solid import Solid
from fem_contact.surface import HeightField, random_surface
from validation.effects.base import Slots
from validation.methods import Solver
from validation.methods.base import Claim
from validation.methods.foreign import judged

__all__ = ["SOFT", "Inconclusive", "Pressed", "Subject", "Unanswered", "rough"]

#: E* = 1.
SOFT = Solid(young=1.0, poisson=0.0)


class Inconclusive(Exception):
    """A row that cannot be read, because another one fails."""


class Unanswered(Exception):
    """A problem that the solver was not asked, or left out."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Pressed:
    """What a solver said of one problem, and what that amounts to.

    Attributes
    ----------
    claim : Claim
    result : ContactResult
        Recomputed from the pressure alone, where the solver is one of the half-space; its own otherwise.
    """

    claim: Claim
    result: ContactResult


@dataclass(frozen=True, kw_only=True)
class Subject:
    """A solver to be scored.

    Attributes
    ----------
    name : str
        By which it was asked for.
    solver : Solver
    settings : mapping
        What it is told beyond surface, solid and load.
    tolerance : float
        Of the residuals it is asked for.
    quick : bool
        Whether small grids do.
    """

    name: str
    solver: Solver
    settings: Mapping[str, Any]
    tolerance: float = 1e-6
    quick: bool = True

    @property
    def points(self) -> int:
        """Points along a side of the coarsest grid of a ladder."""
        return self.solver.score_points

    @property
    def ladder(self) -> tuple[int, int, int]:
        """Three grids, each twice as fine as the one before."""
        return self.points, 2 * self.points, 4 * self.points

    @property
    def pressure_error(self) -> float:
        """Relative error of pressures that the tolerance allows: the tolerance is one of an energy."""
        return float(np.sqrt(10 * self.tolerance))

    def press(self, field: HeightField, load: float, *, solid: Solid = SOFT) -> Pressed:
        """Press a surface [m] with a mean pressure [Pa]."""
        refined = self.solver.score_settings(max(field.shape))
        settings = {**refined, **self.settings, "tolerance": self.tolerance}
        slots = Slots(solid=solid)
        if self.solver.half_space:
            claim = self.solver.claim(field, mean_pressure=load, slots=slots, settings=settings)
            result = judged(
                claim,
                field,
                solid=solid,
                mean_pressure=load,
                tolerance=self.tolerance,
                method=self.solver.label,
            )
            return Pressed(claim=claim, result=result)
        found = self.solver.solve(
            field, mean_pressure=load, slots=slots, settings=settings, threads=1
        ).contact
        return Pressed(claim=Claim.of(found), result=found)

    def warm_up(self) -> None:
        """Let it import and compile what it needs."""
        self.solver.rehearse((), {**self.settings, "tolerance": self.tolerance})


def rough(points: int, *, bandwidth: int = 4, waves: int = 2, seed: int = 271) -> HeightField:
    """Return a surface of unit gradient and period with `waves` longest waves across, H = 0.8.

    Parameters
    ----------
    points : int
        Along a side.
    bandwidth : int
        lambda_long / lambda_short.
    waves : int
        L / lambda_long.
    seed : int
    """
    longest, shortest = 2 * np.pi * waves, 2 * np.pi * waves * bandwidth
    surface = random_surface(
        lambda q: np.where(q >= 0.999 * longest, np.maximum(q, longest) ** -3.6, 0.0),
        q_short=shortest,
        lengths=(1.0, 1.0),
        shape=(4 * waves * bandwidth,) * 2,
        seed=seed,
    )
    unit = HeightField(heights=surface.heights / surface.rms_gradient, lengths=(1.0, 1.0))
    return unit.resampled((points, points))
